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

/*
 * The most of the inputs that config.memory_bytes and --time allow. config is for inputs as they are,
 * width 0: twice the first; timed: pixels will be of different times. -EFBIG if nothing does.
 */
TTF_MUST_USE int quilt_preview_choose(struct cli *cli, struct ttf_clock *clock,
                                      const struct quilt_input *inputs, unsigned n,
                                      const struct ttf_quilt_config *config, bool timed,
                                      struct quilt_preview *ret);

#endif
