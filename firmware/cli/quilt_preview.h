/* SPDX-License-Identifier: Apache-2.0 */
/* quilt_preview.h: how much smaller and rarer an input must be for a synthesis to stay within memory and time. */
#ifndef CLI_QUILT_PREVIEW_H
#define CLI_QUILT_PREVIEW_H

#include "cli.h"
#include "quilt_input.h"
#include "ttf/hal/clock.h"
#include "ttf/synth/quilt.h"

struct quilt_preview {
    uint32_t shrink, step;
    size_t bytes; /* estimates with these */
    int64_t total_ns;
    int64_t read_ns; /* measured: one frame of all inputs */
};

struct quilt_preview_ask {
    const struct quilt_input *inputs;
    unsigned n_inputs;
    const struct ttf_quilt_config *config; /* for inputs as they are; width 0: twice the first */
    bool timed;                            /* pixels will be of different times */
    uint32_t keep_shrink, keep_step;       /* taken if they stay within all; 0: none */
    /* The pace of the fastest pixel of an output of this size, by which it gets longer; NULL: 1. */
    int (*fastest)(void *ctx, uint32_t width, uint32_t height, float *ret);
    void *ctx;
};

/* The most of the inputs that config.memory_bytes and --time allow. -EFBIG if nothing does. */
TTF_MUST_USE int quilt_preview_choose(struct cli *cli, struct ttf_clock *clock,
                                      const struct quilt_preview_ask *ask,
                                      struct quilt_preview *ret);

#endif
