/* SPDX-License-Identifier: Apache-2.0 */
/*
 * quilt.h: time-varying texture quilting (Enrique et al. 2005, sections 5.1 and
 * 5.2; image quilting: Efros & Freeman 2001).
 *
 * A block is a cuboid: the same spatial block for all frames, chosen by eq. 3 and
 * cut along one minimum-error seam found on errors summed over all frames. Frames
 * are copied, not blended.
 *
 * `run.h` does the whole job: plan, frames, figures. This header is its parts.
 * The map is the same, to the bit, for any number of threads and on any machine.
 */
#ifndef TTF_SYNTH_QUILT_H
#define TTF_SYNTH_QUILT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "ttf/base/attr.h"
#include "ttf/base/err.h"
#include "ttf/dataset/pool.h"
#include "ttf/dataset/sequence.h"
#include "ttf/synth/rate_map.h"

/* Factors as bytes, as keep_factors got them: opaque, of this machine's byte order; for the same input grown longer. */
struct ttf_quilt_factors {
    const void *bytes;
    size_t size;
};

enum ttf_metric {
    TTF_METRIC_DISPLAY = 0, /* 8-bit display-encoded values, as the paper */
    TTF_METRIC_LINEAR,      /* 8-bit codes of linear light: dark parts count less */
    TTF_METRIC_COUNT
};

/* "display", "linear". */
const char *ttf_metric_name(enum ttf_metric metric);
int ttf_metric_find(const char *name); /* -ENOENT */

#define TTF_QUILT_INPUTS_MAX 16
#define TTF_QUILT_RANK_MAX   64
#define TTF_QUILT_RANK_FULL \
    0 /* no compression: the search over all frames (one input, nothing beyond the paper) */

struct ttf_quilt_config {
    uint32_t width, height;             /* of the output, pixels, 1..32768 each */
    uint32_t block_width, block_height; /* default 64 x 64; 4 .. the input's size */
    uint32_t overlap_x, overlap_y;      /* 0: max(2, round(block / 6)); 1 .. block / 2 */
    double tolerance;                   /* of the best-within-tolerance rule; default 0.1; 0..10 */
    uint64_t seed;
    size_t memory_bytes; /* refuse (-EFBIG) to hold more matching data than this; 0: no limit */
    /* Of a sink of 8-bit rows: so many bytes of frames stay in memory, and their rows leave while blocks are looked for;
       within memory_bytes with the matching data. Default 96 MiB; 0: none, rows leave when all blocks lie. */
    size_t keep_bytes;
    enum ttf_metric metric;
    bool per_frame;      /* the baseline that flickers: each frame quilted alone */
    uint32_t feather_px; /* width of a blend across the seam, in linear light; 0: none */

    /* Compression for the search (section 5.2). */
    unsigned rank; /* k: default 15; 1..64, or TTF_QUILT_RANK_FULL */
    double
        rank_error; /* > 0: the smallest k up to 64 whose error e_k is at most this, instead of rank */
    bool per_channel; /* a factorisation of each channel, k of each; default: one of all three */
    struct ttf_quilt_factors known; /* of the input's first frames: gone on with; zeroed: none */
    int (*keep_factors)(void *ctx, const struct ttf_quilt_factors *factors); /* NULL: not kept */
    void *keep_ctx;

    /* Beyond the paper. */
    struct ttf_sequence *const *more; /* further inputs of the same material, frames and encoding */
    unsigned n_more;                  /* 0..15 */
    bool mirror;           /* blocks also mirrored left to right: what stands upright still does */
    bool flips, rotations; /* mirrored either way; turned by 90, 180 and 270 degrees */
    bool tileable;         /* the output's edges fit each other */
    uint32_t
        avoid_px; /* no block from within so many pixels of where one nearby was taken, however turned (halved where nothing would be left); 0: as it comes */

    const struct ttf_quilt_map *
        replay; /* by ttf_quilt_run: this map instead of a search, rounded and at its pace unless `rate` is another; NULL: none */
    bool measure; /* figures of frames for the report; default true */
    unsigned
        agreement_queries; /* compare so many of the map's queries with the full-time search; 0: none */

    /* Time (eq. 6 to 8), of an input of at most 65,536 frames. */
    uint32_t jitter_frames; /* e: each block its own time, at most so far off; 0: none */
    uint32_t
        jitter_every; /* frames from one step of a block's time to the next; default 16; 1: the paper's */
    bool jitter_round;               /* whole frames only; default: interpolated */
    const struct ttf_rate_map *rate; /* M, of the output's size; NULL: 1 everywhere. Borrowed */

    /* for the report's times and the pages that kept frames are taken in, from any of the pool's threads, several at once; NULL: no times */
    int64_t (*now_ns)(void *ctx);
    void *now_ctx;
    void (*progress)(
        void *ctx,
        double done); /* 0..1, from any of the pool's threads, one at a time; NULL allowed */
    void *progress_ctx;
    const volatile int *cancel; /* non-zero (cancel.h): -ECANCELED; NULL allowed */
};

void ttf_quilt_defaults(struct ttf_quilt_config *config);

/* How blocks may be turned under a configuration: a set of bits 1 << turn, bit 0 (as it is) always. */
unsigned ttf_quilt_turns(const struct ttf_quilt_config *config);

/*
 * How a block is turned: bits 0 (mirrored left to right) and 1 (top to bottom), bit 2:
 * rows and columns change places before that. 0: as it is.
 */
#define TTF_TURN_COUNT 8

/* One block of a map. */
struct ttf_quilt_block {
    uint32_t out_x, out_y; /* where the block lies in the output; a tileable one may reach around */
    uint32_t width, height; /* the last ones of a row or column are clipped */
    uint32_t src_x, src_y;  /* where it was taken from: its corner in the input, turned */
    uint8_t input, turn;    /* of which input, and how turned */
    uint16_t left, top, right, bottom; /* widths of its overlaps, 0: none */
    uint32_t
        cuts; /* in the map's cuts: of left and right (height each), of top and bottom (width each), those there are */
    double error;            /* summed squared error over the overlap, eq. 3, codes^2 */
    double best_error;       /* of the best candidate */
    uint32_t overlap_pixels; /* 0 for the first block */
    uint32_t candidates;     /* within tolerance; for the first block, all positions */
};

/*
 * One step of a feathered pixel, applied in order: value += (source - value) *
 * weight / 65536. A pixel's first layer has the whole weight.
 */
struct ttf_quilt_layer {
    uint32_t pixel;  /* y * width + x of the output */
    uint32_t source; /* the source pixel's id */
    uint32_t weight; /* 1..65536 */
    uint32_t block;  /* whose pixel it is */
};

/* The factorisation that matching was done in: section 5.2, figure 5. */
struct ttf_quilt_rank_figures {
    unsigned rank;                         /* k; TTF_QUILT_RANK_FULL: none */
    unsigned numbers;                      /* per pixel: k, or 3 k */
    double error;                          /* e_k */
    double rms;                            /* of the reconstruction, over full scale */
    unsigned n_errors;                     /* ranks 0 .. n_errors - 1 are in the curve */
    double errors[TTF_QUILT_RANK_MAX + 1]; /* e_0 .. : figure 5 */
    uint32_t known_frames;                 /* taken over from factors that were known */
};

/* What a search cost and met: for the report. */
struct ttf_quilt_search_figures {
    uint64_t positions;      /* all blocks together */
    uint64_t survived_cells; /* not excluded by, or not held against, cells of pixels */
    uint64_t survived_rank;  /* full-time search: nor by the second (few coefficients per pixel) */
    uint64_t exact;          /* compared pixel by pixel */
    double noise_variance;   /* of one 8-bit sample, codes squared */
    size_t matching_bytes;   /* memory for matching data */
    int64_t load_ns, prepare_ns, search_ns, cut_ns; /* 0 without a clock */
};

/* No source pixel's id. */
#define TTF_UNKNOWN_ID UINT32_MAX

/* One of a map's inputs. Its pixels' ids are first + y * width + x. */
struct ttf_quilt_input {
    uint32_t width, height, first;
};

/* Neighbouring pixels of one row, from source ids that follow one another. */
struct ttf_quilt_run {
    uint32_t source, length;
};

/*
 * For each output pixel, the source pixel it was copied from, by id, and the block that brought
 * it. One map for all frames.
 */
struct ttf_quilt_map {
    uint32_t width, height;
    unsigned n_inputs;
    struct ttf_quilt_input inputs[TTF_QUILT_INPUTS_MAX];
    uint32_t source_pixels; /* of all inputs */
    uint32_t *source;       /* width x height ids, row by row */
    uint32_t *owner;        /* width x height indices of blocks */
    unsigned n_blocks;
    struct ttf_quilt_block *blocks; /* raster order */
    size_t n_cuts;
    uint16_t *cuts;  /* all blocks' cuts, behind one another */
    size_t n_layers; /* 0 without feathering */
    struct ttf_quilt_layer *layers;
    uint32_t overlap_x, overlap_y; /* as used; of a tileable one the least */
    bool tileable;
    uint32_t feather_px;
    /* As it was asked for, and the frames that blocks' errors are summed over; 0: not known (a file that does not say). */
    uint32_t block_width, block_height, frames;
    /* source again, as runs of pixels that are neighbours in both: what frames are copied by (ttf_quilt_map_index) */
    struct ttf_quilt_run *runs;
    uint32_t *row_runs; /* height + 1: where each row's begin */
    /* time: of jitter, one f for each block, n_times values each (frames x 65536); NULL: none */
    uint32_t n_times;
    uint32_t *times;
    bool rounded;             /* times between frames are taken as whole ones */
    struct ttf_rate_map rate; /* M, of the output's size; m NULL: 1 everywhere */
    struct ttf_quilt_search_figures figures;
    struct ttf_quilt_rank_figures rank;
};

/* The id of a source pixel's neighbour, as the output shows it under `turn`; false: beyond the input. */
bool ttf_quilt_neighbour(const struct ttf_quilt_map *map, uint32_t id, unsigned turn, int dx,
                         int dy, uint32_t *ret);

/* Frees what the map holds and zeroes it. A zeroed map is fine. */
void ttf_quilt_map_free(struct ttf_quilt_map *map);

/* Fills runs and row_runs from source; plans, copies and replays have them. A map without is composed slower. -ENOMEM. */
TTF_MUST_USE int ttf_quilt_map_index(struct ttf_quilt_map *map);

/* -ENOMEM. */
TTF_MUST_USE int ttf_quilt_map_copy(const struct ttf_quilt_map *map, struct ttf_quilt_map *ret);

/* 64 bits that name what is copied from where: equal maps give equal digests. */
uint64_t ttf_quilt_map_digest(const struct ttf_quilt_map *map);

/* -EINVAL naming the field that is out of range or does not suit an input of this size; -EFBIG. */
TTF_MUST_USE int ttf_quilt_validate(const struct ttf_quilt_config *config,
                                    struct ttf_sequence *input, struct ttf_err *err);

/* Frames of the output: n, or eq. 8's where there is a rate map. -ERANGE. */
TTF_MUST_USE int ttf_quilt_output_frames(const struct ttf_quilt_config *config, uint32_t n,
                                         uint32_t *ret, struct ttf_err *err);

/*
 * About what ttf_quilt_plan will hold while it searches `pixels` (of all inputs) with one thread (each
 * further one has bounds and a template of its own: 4 bytes a pixel and view, and some
 * 200 a pixel of a block): in k-space whatever the number of frames; in a full-time search about 3 n + 96 bytes per pixel;
 * both together where they are compared (agreement_queries).
 */
size_t ttf_quilt_matching_bytes(const struct ttf_quilt_config *config, uint32_t pixels, uint32_t n);

/*
 * May what is known (config->known) be gone on with for this input? As ttf_quilt_run will find it, before anything is begun. 0 also
 * where nothing is known. -EINVAL with words, *ret_other then: they are sound and made by such a configuration, but not of this
 * input. -ENOMEM, the sequences'.
 */
TTF_MUST_USE int ttf_quilt_factors_check(const struct ttf_quilt_config *config,
                                         struct ttf_sequence *input, bool *ret_other,
                                         struct ttf_err *err);

/*
 * Finds the map. Memory: bounded by the input's own matching data (see above),
 * not by the output's length. -EINVAL naming what is out of range, -EFBIG if
 * the matching data pass config->memory_bytes, -ECANCELED, -ENOMEM.
 * per_frame is refused here: see ttf_quilt_frame_map. Free *ret with
 * ttf_quilt_map_free.
 */
TTF_MUST_USE int ttf_quilt_plan(const struct ttf_quilt_config *config, struct ttf_sequence *input,
                                struct ttf_pool *pool, struct ttf_quilt_map *ret,
                                struct ttf_err *err);

/* The baseline (figure 4b): the map of frame t quilted alone, with a seed of its own. */
TTF_MUST_USE int ttf_quilt_frame_map(const struct ttf_quilt_config *config,
                                     struct ttf_sequence *input, uint32_t t, struct ttf_pool *pool,
                                     struct ttf_quilt_map *ret, struct ttf_err *err);

/* A frame in memory (source pixels x 3 codes, of all inputs) through the map into dst (height x width x 3 codes), at its own time: pure. */
void ttf_quilt_compose(const struct ttf_quilt_map *map, const uint16_t *source, uint16_t *dst);

#endif
