/* SPDX-License-Identifier: Apache-2.0 */
/* options.c: one line per option; see options.h. */
#include "options.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ttf/base/time.h"
#include "ttf/config/units.h"

#define O(member) offsetof(struct cli_options, member)

static const struct cli_option_def OPTIONS[OPT_COUNT] = {
    [OPT_BOARD] = {"board", 'b', "NAME", CLI_TEXT, O(board), 0, 0,
                   "the box: a name or a board.yaml (default: sim, the simulated box)"},
    [OPT_SET] = {"set", 0, "KEY=VALUE", CLI_SET, 0, 0, 0,
                 "change a key of the board for this run, as sim.optics.blur=0px; may be repeated"},
    [OPT_SCENE] = {"scene", 0, "NAME", CLI_TEXT, O(scene), 0, 0,
                   "what a simulated camera looks at: a procedural sample, 'white' (an even "
                   "target), a folder of pictures or a dataset"},
    [OPT_OUTPUT] = {"output", 'o', "PATH", CLI_TEXT, O(output), 0, 0, "where the result goes"},
    [OPT_CALIBRATION] = {"calibration", 'c', "CAL", CLI_TEXT, O(calibration), 0, 0,
                         "a calibration folder, made by 'ttfbox calibrate'"},
    [OPT_PLAN] = {"plan", 'p', "PLAN", CLI_TEXT, O(plan), 0, 0,
                  "take exposure and lamps from this plan's first shot"},
    [OPT_SHOT] = {"shot", 0, "STREAM", CLI_TEXT, O(shot), 0, 0,
                  "with --plan: take this stream's shot instead of the first"},
    [OPT_EXPOSURE] = {"exposure", 0, "TIME", CLI_TIME, O(exposure_ns), 1000, 1e12,
                      "the exposure time, as 20ms (default: the plan's, else 20ms)"},
    [OPT_REFLECTANCE] = {"reflectance", 0, "SHARE", CLI_DECIMAL, O(reflectance), 0.01, 1,
                         "the even target's reflectance, 0..1 (default: 0.9; the simulated "
                         "'white' is known and needs none)"},
    [OPT_REHEARSE] = {"rehearse", 0, "N", CLI_WHOLE, O(rehearse), 1, 1000,
                      "try N slots at once and report; the dataset stays unsealed"},
    [OPT_NO_SPEED_CHECK] = {"no-speed-check", 0, NULL, CLI_FLAG, O(no_speed_check), 0, 0,
                            "do not measure how fast the disk writes"},
    [OPT_THREADS] = {"threads", 't', "N", CLI_WHOLE, O(threads), 0, 256,
                     "computing threads (default: one per processor); never changes a result"},
    [OPT_SEED] = {"seed", 0, "N", CLI_SEED, O(seed), 0, 9.2e18,
                  "the seed of all chance; the same seed gives the same bits"},
    [OPT_INTERVAL] = {"interval", 'i', "TIME", CLI_TIME, O(interval_ns), 1e6, 366e9 * 86400,
                      "the time from frame to frame, as 10min"},
    [OPT_ORDER] = {"order", 0, "HOW", CLI_TEXT, O(order), 0, 0,
                   "natural (by name, default), given, exif-time or name-time"},
    [OPT_TRANSFER] = {"transfer", 0, "CURVE", CLI_TEXT, O(transfer), 0, 0,
                      "auto (as the files say, default), srgb or linear"},
    [OPT_TITLE] = {"title", 0, "TEXT", CLI_TEXT, O(title), 0, 0, "a line for people"},
    [OPT_MM_PER_PX] = {"mm-per-px", 0, "MM", CLI_DECIMAL, O(mm_per_px), 1e-6, 1e3,
                       "millimetres per pixel"},
    [OPT_TO] = {"to", 0, "KIND", CLI_TEXT, O(to), 0, 0,
                "mp4, gif, y4m, png, tiff, npy or sheet (default: by the output's ending)"},
    [OPT_GAPS] = {"gaps", 0, "HOW", CLI_TEXT, O(gaps), 0, 0,
                  "what stands for slots without an image: hold (default), fail or interpolate"},
    [OPT_START] = {"start", 0, "N", CLI_WHOLE, O(start), 0, 1e9,
                   "number of the first file (default: 1001)"},
    [OPT_EVERY] = {"every", 0, "N", CLI_WHOLE, O(every), 1, 1e6, "take each N-th slot only"},
    [OPT_FRAMES] = {"frames", 0, "N", CLI_WHOLE, O(frames), 1, 1e9, "at most N frames"},
    [OPT_FPS] = {"fps", 0, "N", CLI_WHOLE, O(fps), 1, 240,
                 "frames per second of a video (default: 24, gif: 12)"},
    [OPT_WIDTH_MAX] = {"width", 0, "PX", CLI_WHOLE, O(width_max), 16, 65535,
                       "shrink to at most this width, in linear light"},
    [OPT_COLUMNS] = {"columns", 0, "N", CLI_WHOLE, O(columns), 1, 100,
                     "columns of a contact sheet"},
    [OPT_WHITE] = {"white", 0, "VALUE", CLI_DECIMAL, O(white), 1e-6, 1e6,
                   "value shown as full white (default: 1, a perfect diffuser)"},
    [OPT_NAME] = {"name", 0, "NAME", CLI_TEXT, O(name), 0, 0,
                  "name of numbered files (default: frame)"},
    [OPT_STREAM] = {"stream", 0, "ID", CLI_TEXT, O(stream), 0, 0,
                    "the stream to read (default: the primary one)"},
    [OPT_SIZE] = {"size", 's', "WxH", CLI_SIZE, O(size), 0, 0,
                  "the output's size in pixels (default: twice the input's)"},
    [OPT_BLOCK] = {"block", 0, "WxH", CLI_SIZE, O(block), 0, 0,
                   "a block's size in pixels (default: 64x64); elongated ones suit grass"},
    [OPT_OVERLAP] = {"overlap", 0, "WxH", CLI_SIZE, O(overlap), 0, 0,
                     "overlap of blocks per axis (default: a sixth of the block)"},
    [OPT_TOLERANCE] = {"tolerance", 0, "SHARE", CLI_DECIMAL, O(tolerance), 0, 10,
                       "choose among blocks within this share of the best (default: 0.1)"},
    [OPT_METRIC] = {"metric", 0, "SPACE", CLI_TEXT, O(metric), 0, 0,
                    "compare in display (default, as the paper) or linear values"},
    [OPT_COMPRESS] = {"compress", 0, "HOW", CLI_TEXT, O(compress), 0, 0,
                      "none (default) or deflate: the output's TIFF frames"},
    [OPT_SINK] = {"sink", 0, "KIND", CLI_TEXT, O(sink), 0, 0,
                  "dataset (default), raw (one file of 8-bit RGB frames) or null (nothing: for "
                  "timing)"},
    [OPT_PER_FRAME] = {"per-frame", 0, NULL, CLI_FLAG, O(per_frame), 0, 0,
                       "quilt each frame alone: the baseline that flickers"},
    [OPT_FEATHER] = {"feather", 0, "PX", CLI_WHOLE, O(feather), 0, 64,
                     "blend across the seam over so many pixels, in linear light (default: 0)"},
    [OPT_CHECK] = {"check", 0, NULL, CLI_FLAG, O(check), 0, 0,
                   "read the result back and compare every trajectory with its source's, bit for "
                   "bit"},
    [OPT_MAN] = {"man", 0, NULL, CLI_FLAG, O(man), 0, 0, "print the manual page as troff source"},
    [OPT_JSON] = {"json", 0, NULL, CLI_FLAG, O(json), 0, 0,
                  "print the result as one line of JSON on standard output"},
    [OPT_QUIET] = {"quiet", 'q', NULL, CLI_FLAG, O(quiet), 0, 0, "no progress bar"},
};

const struct cli_option_def *cli_option_def(enum cli_option option)
{
    return &OPTIONS[option];
}

void cli_options_defaults(struct cli_options *options)
{
    memset(options, 0, sizeof *options);
    options->tolerance = 0.1;
}

/* Puts "--name" in front of what units.c found wrong. */
static int named(const struct cli_option_def *def, struct ttf_err *err)
{
    if (err)
        snprintf(err->where, sizeof err->where, "--%s", def->name);
    return -EINVAL;
}

static int check_range(const struct cli_option_def *def, double value, const char *text,
                       struct ttf_err *err)
{
    char lo[40], hi[40];

    if (value >= def->lo && value <= def->hi)
        return 0;
    if (def->type == CLI_TIME) {
        ttf_unit_format(TTF_UNIT_TIME, (int64_t)def->lo, lo, sizeof lo);
        ttf_unit_format(TTF_UNIT_TIME, (int64_t)def->hi, hi, sizeof hi);
    } else {
        snprintf(lo, sizeof lo, "%g", def->lo);
        snprintf(hi, sizeof hi, "%g", def->hi);
    }
    ttf_err_set(err, -EINVAL, NULL, "%.60s is out of its range", text);
    ttf_err_hint(err, "%s: from %s to %s", def->text, lo, hi);
    return named(def, err);
}

static int take_set(struct cli_options *options, const struct cli_option_def *def,
                    const char *value, struct ttf_err *err)
{
    const char *equals = strchr(value, '=');
    char *copy;

    if (!equals || equals == value) {
        ttf_err_set(err, -EINVAL, NULL, "'%.60s' sets nothing", value);
        ttf_err_hint(err, "write KEY=VALUE, as --set sim.optics.blur=0px");
        return named(def, err);
    }
    if (options->n_sets == CLI_SETS_MAX) {
        ttf_err_set(err, -EINVAL, NULL, "more than %d of them", CLI_SETS_MAX);
        return named(def, err);
    }
    copy = strdup(value);
    if (!copy)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory");
    copy[equals - value] = '\0';
    options->set_texts[options->n_sets] = copy;
    options->sets[options->n_sets++] =
        (struct ttf_board_set){.path = copy, .value = copy + (equals - value) + 1};
    return 0;
}

int cli_option_take(struct cli_options *options, enum cli_option option, const char *value,
                    struct ttf_err *err)
{
    const struct cli_option_def *def = &OPTIONS[option];
    char *at = (char *)options + def->offset;
    int64_t whole = 0;
    double number = 0;

    switch (def->type) {
    case CLI_FLAG:
        *(bool *)at = true;
        return 0;
    case CLI_TEXT:
        if (!*value) {
            ttf_err_set(err, -EINVAL, NULL, "is empty");
            ttf_err_hint(err, "%s", def->text);
            return named(def, err);
        }
        *(const char **)at = value;
        return 0;
    case CLI_TIME:
        if (ttf_unit_parse(TTF_UNIT_TIME, value, &whole, err) < 0)
            return named(def, err);
        number = (double)whole;
        break;
    case CLI_SEED:
        options->has_seed = true;
        /* fall through */
    case CLI_WHOLE:
        if (ttf_integer_parse(value, &whole, err) < 0)
            return named(def, err);
        number = (double)whole;
        break;
    case CLI_SIZE:
        return ttf_size_parse(value, (uint32_t *)at, (uint32_t *)at + 1, err) < 0 ? named(def, err)
                                                                                  : 0;
    case CLI_DECIMAL:
        if (ttf_number_parse(value, &number, err) < 0)
            return named(def, err);
        break;
    case CLI_SET:
        return take_set(options, def, value, err);
    }
    if (check_range(def, number, value, err) < 0)
        return -EINVAL;
    if (def->type == CLI_DECIMAL)
        *(double *)at = number;
    else
        *(int64_t *)at = whole;
    return 0;
}

void cli_options_free(struct cli_options *options)
{
    for (unsigned i = 0; i < options->n_sets; i++)
        free(options->set_texts[i]);
    options->n_sets = 0;
}
