/* SPDX-License-Identifier: Apache-2.0 */
/*
 * time_jitter.h: each pasted block its own time t' = f(t) (Enrique et al. 2005, eq. 6, 7), so that
 * a block pasted twice does not do the same thing twice at once.
 */
#ifndef TTF_SYNTH_QUILT_TIME_JITTER_H
#define TTF_SYNTH_QUILT_TIME_JITTER_H

#include <stdint.h>

#include "ttf/base/attr.h"
#include "ttf/synth/quilt.h"

#define TTF_TIME_ONE 65536u /* a frame, in the fixed-point numbers of times */

/*
 * f of one block: f(0) = 0, f(t+1) = f(t) + 1 + d, d uniform in [-1, 1], or 0 where the step would
 * leave |f(t) - t| <= e. Non-decreasing; not yet clamped to the input's end. n values.
 *
 * every 1: a d for each frame, as the paper. Interpolating at ever new fractions then averages the
 * noise of neighbouring frames away. every > 1 (ours): a d now and then, at moments of the block's own;
 * the offset f(t) - t is a whole number but for short ramps, so that most frames are copies.
 */
void ttf_time_jitter(uint64_t seed, unsigned block, uint32_t e_frames, uint32_t every, uint32_t n,
                     uint32_t *ret);

/* map->times, for all blocks. -ENOMEM. */
TTF_MUST_USE int ttf_time_jitter_fill(uint64_t seed, uint32_t e_frames, uint32_t every, uint32_t n,
                                      struct ttf_quilt_map *map);

/* f at a time between frames (fixed point), clamped to 0 .. (n - 1) frames. times NULL: f(t) = t. */
uint32_t ttf_time_at(const uint32_t *times, uint32_t n, uint64_t time);

#endif
