/* SPDX-License-Identifier: Apache-2.0 */
/*
 * options.h: the options of all commands, each spelled, typed and explained
 * once. A command lists which of them it takes (commands.c).
 */
#ifndef CLI_OPTIONS_H
#define CLI_OPTIONS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "ttf/base/err.h"
#include "ttf/config/board_file.h"

#define CLI_SETS_MAX    32
#define CLI_SOURCES_MAX 15

enum cli_option {
    OPT_END = 0,
    OPT_GROUP, /* no option: the text heads those that follow */
    OPT_BOARD,
    OPT_BUNDLE,
    OPT_ROOT,
    OPT_SET,
    OPT_SCENE,
    OPT_OUTPUT,
    OPT_CALIBRATION,
    OPT_PLAN,
    OPT_SHOT,
    OPT_EXPOSURE,
    OPT_REFLECTANCE,
    OPT_REHEARSE,
    OPT_NO_SPEED_CHECK,
    OPT_SCRIPT,
    OPT_AS_GIVEN,
    OPT_SLOTS,
    OPT_TAG,
    OPT_AUTHOR,
    OPT_REGION,
    OPT_TREATMENT,
    OPT_TABLE,
    OPT_REMOVE,
    OPT_THREADS,
    OPT_SEED,
    OPT_INTERVAL,
    OPT_ORDER,
    OPT_TRANSFER,
    OPT_TITLE,
    OPT_MM_PER_PX,
    OPT_TO,
    OPT_GAPS,
    OPT_START,
    OPT_EVERY,
    OPT_FRAMES,
    OPT_FPS,
    OPT_WIDTH_MAX,
    OPT_COLUMNS,
    OPT_WHITE,
    OPT_NAME,
    OPT_STREAM,
    OPT_ROLE,
    OPT_BRACKET,
    OPT_WITH_EXCLUDED,
    OPT_CORNERS,
    OPT_PITCH,
    OPT_VALUES,
    OPT_SIZE,
    OPT_BLOCK,
    OPT_OVERLAP,
    OPT_TOLERANCE,
    OPT_METRIC,
    OPT_COMPRESS,
    OPT_SINK,
    OPT_PER_FRAME,
    OPT_FEATHER,
    OPT_CHECK,
    OPT_RANK,
    OPT_RANK_ERROR,
    OPT_SVD,
    OPT_FACTORS,
    OPT_SOURCE,
    OPT_MIRROR,
    OPT_FLIPS,
    OPT_ROTATIONS,
    OPT_TILEABLE,
    OPT_AVOID,
    OPT_JITTER,
    OPT_JITTER_ROUNDED,
    OPT_JITTER_EVERY,
    OPT_RATE_MAP,
    OPT_LIGHT,
    OPT_NORMALS,
    OPT_HEIGHTS,
    OPT_HEIGHT_SCALE,
    OPT_CURVATURE,
    OPT_RATE_OFFSET,
    OPT_RATE_GAIN,
    OPT_STABILISE,
    OPT_DEFLICKER,
    OPT_DEFLICKER_WINDOW,
    OPT_FLATTEN,
    OPT_FLATTEN_SIGMA,
    OPT_KEEP_GRADIENT,
    OPT_SAVE_MAP,
    OPT_MAP,
    OPT_AGREEMENT,
    OPT_FIGURES,
    OPT_NO_FIGURES,
    OPT_PREVIEW,
    OPT_MEMORY,
    OPT_TIME,
    OPT_LEAST,
    OPT_THRESHOLD,
    OPT_SOFTEN,
    OPT_LISTEN,
    OPT_TOKEN_FILE,
    OPT_BOX,
    OPT_USB,
    OPT_ONLY,
    OPT_FOLLOW,
    OPT_LIST,
    OPT_BESIDE,
    OPT_MAN,
    OPT_JSON,
    OPT_QUIET,
    OPT_COUNT
};

/* Values as given; what was not given has the value the option's table names. */
struct cli_options {
    const char *board, *scene, *output, *calibration, *plan, *shot, *to, *gaps, *order, *transfer;
    const char *corners, *values;
    const char *listen, *token_file, *box, *only, *beside;
    bool follow, list, usb;
    const char *bundle, *root, *script, *slots, *tag, *author;
    const char *region, *treatment, *table, *role;
    const char *compress, *sink, *stream, *title, *name, *metric;
    bool json, quiet, per_frame, no_speed_check, as_given, with_excluded, check, man, remove;
    int64_t threads, rehearse, frames, every, start, fps, feather, columns, width_max;
    int64_t bracket; /* -1: of each bracket the reference */
    int64_t seed;
    bool has_seed;
    int64_t interval_ns, exposure_ns;
    uint32_t size[2], block[2], overlap[2];
    bool block_auto;
    double tolerance, reflectance, mm_per_px, pitch_mm, white;
    /* of the quilting commands */
    const char *svd, *factors, *rate_map, *normals, *heights, *curvature, *save_map, *map;
    const char *sources[CLI_SOURCES_MAX];
    unsigned n_sources;
    bool mirror, flips, rotations, tileable, jitter_rounded, stabilise, deflicker, flatten,
        keep_gradient;
    bool figures, no_figures, preview;
    int64_t rank; /* 0: full */
    int64_t avoid, jitter, jitter_every, deflicker_window, agreement, memory_bytes, time_ns;
    double rank_error, height_scale, rate_offset, rate_gain, flatten_sigma;
    double light[3];
    double least, threshold, soften;
    struct ttf_board_set sets[CLI_SETS_MAX];
    unsigned n_sets;
    char *set_texts[CLI_SETS_MAX]; /* owned: what sets[] points into */
    const char *given[OPT_COUNT];  /* what was typed, "" of a flag; NULL: not given */
    const char *const *args;       /* what is no option */
    unsigned n_args;
};

enum cli_type {
    CLI_FLAG = 0,
    CLI_TEXT,
    CLI_WORDS,   /* a text that may be empty */
    CLI_TIME,    /* int64_t ns */
    CLI_WHOLE,   /* int64_t */
    CLI_SEED,    /* int64_t and has_seed */
    CLI_SIZE,    /* uint32_t[2] */
    CLI_BLOCK,   /* the same or "auto": block_auto */
    CLI_RANK,    /* int64_t, 0: "full" */
    CLI_DECIMAL, /* double */
    CLI_POINT,   /* double[3] */
    CLI_BYTES,   /* int64_t */
    CLI_SOURCE,  /* a text, may be repeated */
    CLI_SET      /* PATH=VALUE, may be repeated */
};

struct cli_option_def {
    const char *name; /* long, without dashes */
    char letter;      /* 0: none */
    const char *arg;  /* NULL: a flag */
    enum cli_type type;
    size_t offset; /* in struct cli_options */
    double lo, hi; /* of numbers; times in ns, data in bytes */
    const char *text;
};

const struct cli_option_def *cli_option_def(enum cli_option option);

/* Values before any option was read. */
void cli_options_defaults(struct cli_options *options);

/* Was it typed? */
static inline bool cli_given(const struct cli_options *options, enum cli_option option)
{
    return options->given[option] != NULL;
}

/* Takes one option. -EINVAL with *err naming the option. */
int cli_option_take(struct cli_options *options, enum cli_option option, const char *value,
                    struct ttf_err *err);
void cli_options_free(struct cli_options *options);

#endif
