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

enum ttf_metric {
    TTF_METRIC_DISPLAY = 0, /* 8-bit display-encoded values, as the paper */
    TTF_METRIC_LINEAR,      /* 8-bit codes of linear light: dark parts count less */
    TTF_METRIC_COUNT
};

/* "display", "linear". */
const char *ttf_metric_name(enum ttf_metric metric);
int ttf_metric_find(const char *name); /* -ENOENT */

struct ttf_quilt_config {
    uint32_t width, height;             /* of the output, pixels, 1..32768 each */
    uint32_t block_width, block_height; /* default 64 x 64; 4 .. the input's size */
    uint32_t overlap_x, overlap_y;      /* 0: max(2, round(block / 6)); 1 .. block / 2 */
    double tolerance;                   /* of the best-within-tolerance rule; default 0.1; 0..10 */
    uint64_t seed;
    size_t memory_bytes; /* refuse (-EFBIG) to hold more matching data than this; 0: no limit */
    enum ttf_metric metric;
    bool per_frame;               /* the baseline that flickers: each frame quilted alone */
    uint32_t feather_px;          /* width of a blend across the seam, in linear light; 0: none */
    int64_t (*now_ns)(void *ctx); /* for the report's times; NULL: no times */
    void *now_ctx;
    void (*progress)(void *ctx, double done); /* 0..1; NULL allowed */
    void *progress_ctx;
    const volatile int *cancel; /* non-zero: -ECANCELED; NULL allowed */
};

void ttf_quilt_defaults(struct ttf_quilt_config *config);

/* One block of a map. */
struct ttf_quilt_block {
    uint32_t out_x, out_y;   /* where the block lies in the output */
    uint32_t width, height;  /* the last ones of a row or column are clipped */
    uint32_t src_x, src_y;   /* where it was taken from */
    double error;            /* summed squared error over the overlap, eq. 3 (an integer) */
    double best_error;       /* of the best candidate (an integer) */
    uint32_t overlap_pixels; /* 0 for the first block */
    uint32_t candidates;     /* within tolerance; for the first block, all positions */
};

/*
 * One step of a feathered pixel, applied in order: value += (source - value) *
 * weight / 65536. A pixel's first layer has the whole weight.
 */
struct ttf_quilt_layer {
    uint32_t pixel;  /* y * width + x of the output */
    uint32_t source; /* y * source width + x */
    uint32_t weight; /* 1..65536 */
};

/* What a search cost and met: for the report. */
struct ttf_quilt_search_figures {
    uint64_t positions;      /* all blocks together */
    uint64_t survived_cells; /* not excluded by the first bound (sums over cells of pixels) */
    uint64_t survived_rank;  /* nor by the second (few coefficients per pixel) */
    uint64_t exact;          /* compared over the full time sequence */
    double noise_variance;   /* of one 8-bit sample, codes squared */
    size_t matching_bytes;   /* memory for matching data */
    int64_t load_ns, prepare_ns, search_ns, cut_ns; /* 0 without a clock */
};

/* For each output pixel, the source pixel it was copied from: y * source width + x. One map for all frames. */
struct ttf_quilt_map {
    uint32_t width, height;
    uint32_t source_width, source_height;
    uint32_t *source; /* width x height, row by row */
    unsigned n_blocks;
    struct ttf_quilt_block *blocks; /* raster order */
    size_t n_layers;                /* 0 without feathering */
    struct ttf_quilt_layer *layers;
    uint32_t overlap_x, overlap_y; /* as used */
    struct ttf_quilt_search_figures figures;
};

/* Frees what the map holds and zeroes it. A zeroed map is fine. */
void ttf_quilt_map_free(struct ttf_quilt_map *map);

/* 64 bits that name what is copied from where: equal maps give equal digests. */
uint64_t ttf_quilt_map_digest(const struct ttf_quilt_map *map);

/* -EINVAL naming the field that is out of range or does not suit an input of this size; -EFBIG. */
TTF_MUST_USE int ttf_quilt_validate(const struct ttf_quilt_config *config,
                                    const struct ttf_sequence *input, struct ttf_err *err);

/* What ttf_quilt_plan will hold while it searches: about 3 n + 96 bytes per input pixel. */
size_t ttf_quilt_matching_bytes(uint32_t width, uint32_t height, uint32_t n);

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

/*
 * Output frame t through the map into dst (height x width x 3 codes, tightly packed).
 * scratch: room for one input frame (source height x width x 3); holds it afterwards.
 */
TTF_MUST_USE int ttf_quilt_frame(const struct ttf_quilt_config *config,
                                 const struct ttf_quilt_map *map, struct ttf_sequence *input,
                                 uint32_t t, uint16_t *scratch, uint16_t *dst, struct ttf_err *err);

/* The same from a frame in memory (source height x width x 3): pure. */
void ttf_quilt_compose(const struct ttf_quilt_map *map, const uint16_t *source, uint16_t *dst);

#endif
