/* SPDX-License-Identifier: Apache-2.0 */
/*
 * quilt.h: time-varying texture quilting (Enrique et al. 2005, sections 4 and
 * 4.1; image quilting: Efros & Freeman 2001).
 *
 * A block is a cuboid: the same spatial block for all frames, chosen by eq. 3 and
 * cut along one minimum-error seam found on errors summed over all frames. Frames
 * are copied, not blended.
 */
#ifndef TTF_SYNTH_QUILT_H
#define TTF_SYNTH_QUILT_H

#include <stdbool.h>
#include <stdint.h>

#include "ttf/base/err.h"
#include "ttf/dataset/pool.h"
#include "ttf/dataset/sequence.h"

enum ttf_metric {
    TTF_METRIC_DISPLAY = 0, /* 8-bit display-encoded values, as the paper */
    TTF_METRIC_LINEAR
};

struct ttf_quilt_config {
    uint32_t width, height;             /* of the output, pixels */
    uint32_t block_width, block_height; /* default 64 x 64; at most the input's size */
    uint32_t overlap_x, overlap_y;      /* 0: max(2, round(block / 6)) per axis */
    double tolerance;                   /* of the best-within-tolerance rule; default 0.1 */
    uint64_t seed;
    enum ttf_metric metric;
    bool per_frame;               /* the baseline that flickers: each frame quilted alone */
    uint32_t feather_px;          /* blending across the seam, in linear light; 0: none */
    int64_t (*now_ns)(void *ctx); /* for the report's times; NULL: no times */
    void *now_ctx;
    void (*progress)(void *ctx, double done); /* 0..1; NULL allowed */
    void *progress_ctx;
    const volatile int *cancel; /* non-zero: -ECANCELED; NULL allowed */
};

void ttf_quilt_defaults(struct ttf_quilt_config *config);

/* For each output pixel, the source pixel it was copied from: y * source width + x. One map for all frames. */
struct ttf_quilt_map {
    uint32_t width, height;
    uint32_t source_width, source_height;
    uint32_t *source; /* width x height, row by row */
    unsigned n_blocks;
    struct ttf_quilt_block {
        uint32_t out_x, out_y; /* where the block lies in the output */
        uint32_t src_x, src_y; /* where it was taken from */
        double error;          /* summed squared error over the overlap, eq. 3 */
        double best_error;     /* of the best candidate */
        uint32_t candidates;   /* within tolerance */
    } * blocks;
};

void ttf_quilt_map_free(struct ttf_quilt_map *map);

/*
 * Finds the map. Memory: bounded by the input's own matching data, not by the
 * output's length. -EINVAL naming what is out of range, -ECANCELED, -ENOMEM.
 * per_frame is refused here: see ttf_quilt_frame_map.
 */
TTF_MUST_USE int ttf_quilt_plan(const struct ttf_quilt_config *config, struct ttf_sequence *input,
                                struct ttf_pool *pool, struct ttf_quilt_map *ret,
                                struct ttf_err *err);

/* The baseline: the map of frame t quilted alone, with a seed of its own. */
TTF_MUST_USE int ttf_quilt_frame_map(const struct ttf_quilt_config *config,
                                     struct ttf_sequence *input, uint32_t t, struct ttf_pool *pool,
                                     struct ttf_quilt_map *ret, struct ttf_err *err);

/*
 * Output frame t through the map into dst (height x width x 3 codes, tightly packed).
 * scratch: room for one input frame (source height x width x 3).
 */
TTF_MUST_USE int ttf_quilt_frame(const struct ttf_quilt_config *config,
                                 const struct ttf_quilt_map *map, struct ttf_sequence *input,
                                 uint32_t t, uint16_t *scratch, uint16_t *dst, struct ttf_err *err);

#endif
