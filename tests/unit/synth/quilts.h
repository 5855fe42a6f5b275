/* SPDX-License-Identifier: Apache-2.0 */
/* quilts.h: what tests of quilting share: plans, whole runs, sinks, inputs made of other inputs. */
#ifndef TTF_TESTS_SYNTH_QUILTS_H
#define TTF_TESTS_SYNTH_QUILTS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "textures.h"
#include "ttf/synth/run.h"

/* A plan, or the test fails with what it says. */
void quilt_plan_ok(const struct ttf_quilt_config *config, struct ttf_sequence *input,
                   struct ttf_pool *pool, struct ttf_quilt_map *ret);

/* Neither planned nor run, and the error names `where`. */
void quilt_refused(const struct ttf_quilt_config *config, struct ttf_sequence *input, int code,
                   const char *where);

/* The source pixel that a block shows at its (x, y), by the words of quilt.h on turns. */
uint32_t quilt_block_shows(const struct ttf_quilt_map *map, const struct ttf_quilt_block *block,
                           uint32_t x, uint32_t y);

/* Every output pixel is the one that its block shows there. */
void quilt_blocks_are_what_is_shown(const struct ttf_quilt_map *map);

/*
 * Keeps all frames, or fails at one, or cancels at one. From any thread: what went wrong is kept,
 * not asserted.
 */
struct quilt_taker {
    uint16_t *codes; /* room frames */
    uint8_t *codes8; /* of rows8 */
    uint8_t *rows;   /* how often each row of each frame came by rows8 */
    uint32_t height;
    size_t frame; /* codes of one */
    uint32_t room, next, fail_at, cancel_at;
    bool out_of_order;
    int cancel;
};
struct quilt_taker quilt_taker_make(const struct ttf_quilt_config *config, uint32_t frames);
void quilt_taker_free(struct quilt_taker *taker);

/* Each row of each frame came by rows8, once. */
bool quilt_taker_has_all_rows(const struct quilt_taker *taker);

/* As if nothing had been taken. */
void quilt_taker_reset(struct quilt_taker *taker);

/* narrow: with rows8 as well. */
struct ttf_quilt_sink quilt_sink(struct quilt_taker *taker, bool narrow);

/* A whole run of the 16-bit sink, all frames in order. */
void quilt_run_ok(const struct ttf_quilt_config *config, struct ttf_sequence *input,
                  struct ttf_pool *pool, struct quilt_taker *taker, struct ttf_quilt_report *report,
                  struct ttf_quilt_map *map);

/* What was taken, as a sequence. */
struct ttf_sequence *quilt_taken(const struct quilt_taker *taker,
                                 const struct ttf_quilt_config *config);

/* width x height pixels of another texture from (x, y) on. */
struct texture_sequence texture_crop(const struct texture_sequence *from, uint32_t x, uint32_t y,
                                     uint32_t width, uint32_t height);

#endif
