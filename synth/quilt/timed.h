/* SPDX-License-Identifier: Apache-2.0 */
/*
 * timed.h: frames whose pixels are of different times: jitter (eq. 6, 7) and control (eq. 8).
 *
 * Output frame t takes of pixel (x, y) the source time f(t M(x, y)), f the time of the block
 * that it is of. Source frames are read into a window of bounded size; where an output
 * frame needs more of them than fit, it is put together in several passes.
 */
#ifndef TTF_SYNTH_QUILT_TIMED_H
#define TTF_SYNTH_QUILT_TIMED_H

#include "search/sources.h"
#include "ttf/base/attr.h"
#include "ttf/dataset/pool.h"
#include "ttf/synth/quilt.h"

struct ttf_timed;

/* config, map and sources must outlive it. window_bytes: for source frames (at least three). -ENOMEM. */
TTF_MUST_USE int ttf_timed_create(const struct ttf_quilt_config *config,
                                  const struct ttf_quilt_map *map,
                                  const struct ttf_sources *sources, size_t window_bytes,
                                  struct ttf_timed **ret);
void ttf_timed_destroy(struct ttf_timed *timed); /* NULL allowed */

/* Output frame t (of those ttf_quilt_output_frames tells): map height x width x 3 codes. The sources' errors. */
TTF_MUST_USE int ttf_timed_frame(struct ttf_timed *timed, uint32_t t, struct ttf_pool *pool,
                                 uint16_t *dst, struct ttf_err *err);

/* Source time of an output pixel in output frame t, frames x 65536. */
uint32_t ttf_timed_at(const struct ttf_timed *timed, uint32_t t, size_t pixel, uint32_t block);

/* Bytes it holds. */
size_t ttf_timed_bytes(const struct ttf_timed *timed);

#endif
