/* SPDX-License-Identifier: Apache-2.0 */
/*
 * run.h: a whole synthesis, streamed: plan, then frame after frame into a sink,
 * with figures on the way; and the check of what came out.
 */
#ifndef TTF_SYNTH_RUN_H
#define TTF_SYNTH_RUN_H

#include <stdint.h>

#include "ttf/base/attr.h"
#include "ttf/base/err.h"
#include "ttf/synth/quilt.h"
#include "ttf/synth/report.h"

/* Where output frames go. Plain struct, copied. */
struct ttf_quilt_sink {
    /*
     * Output frame t = 0, 1, ... : config height x width x 3 codes in the input's
     * encoding, tightly packed, valid during the call. Frames come one at a time and in
     * order, but from any of the pool's threads. A negative errno ends the run with it.
     */
    int (*frame)(void *ctx, uint32_t t, const uint16_t *codes, struct ttf_err *err);
    /*
     * Rows y0 .. y1-1 of frame t as 8-bit display codes, for a sink that wants no more: used instead where no
     * blend or time between frames needs more (and nothing is measured). Each row of each frame once, in any order (rows
     * of all frames may come before the next rows of any), from several of the pool's threads at once. NULL: never.
     */
    int (*rows8)(void *ctx, uint32_t t, uint32_t y0, uint32_t y1, const uint8_t *codes,
                 struct ttf_err *err);
    /*
     * Part `part` of `parts` of the room that all rows will take, one after another, from one thread at a time, while others compute: what a file
     * system does for one thread at a time is done the sooner. Most come before the first rows8, some perhaps between them or at the same time, as
     * many as there is time for; perhaps none. NULL: nothing to do.
     */
    int (*reserve)(void *ctx, unsigned part, unsigned parts, struct ttf_err *err);
    void *ctx;
};

/*
 * Synthesizes all frames (ttf_quilt_output_frames; config->per_frame: each alone). With
 * config->replay nothing is searched for, that map is used. pool: may be NULL.
 * ret_report, ret_map: may be NULL; the map is to be freed with
 * ttf_quilt_map_free, and is of frame 0 if per frame; it has a copy of config->rate. Errors as ttf_quilt_plan,
 * the sequence's, the sink's; on failure nothing is given back, and what the sink
 * already took is for the caller to discard.
 */
TTF_MUST_USE int ttf_quilt_run(const struct ttf_quilt_config *config, struct ttf_sequence *input,
                               struct ttf_pool *pool, const struct ttf_quilt_sink *sink,
                               struct ttf_quilt_report *ret_report, struct ttf_quilt_map *ret_map,
                               struct ttf_err *err);

struct ttf_quilt_check {
    uint64_t pixels;           /* of the output */
    uint64_t unmatched;        /* pixels whose trajectory is no source pixel's: 0 = all is copied */
    uint32_t first_x, first_y; /* the first such pixel */
};

/*
 * Is every output trajectory, bit for bit, that of one source pixel? With a
 * map: of the pixel the map names. Without (NULL): of any, found by hashing the
 * trajectories and then compared in full. config: only for its further inputs (`more`) and `cancel` (-ECANCELED). Reads both sequences frame by frame;
 * memory: a frame of each and about 16 bytes per pixel of each. -EINVAL if lengths or the
 * map's sizes differ.
 */
TTF_MUST_USE int ttf_quilt_verify(const struct ttf_quilt_config *config,
                                  struct ttf_sequence *source, struct ttf_sequence *output,
                                  const struct ttf_quilt_map *map, struct ttf_quilt_check *ret,
                                  struct ttf_err *err);

#endif
