/* SPDX-License-Identifier: Apache-2.0 */
/*
 * ahead.h: rows of output that are handed on while blocks further down are still looked for. What a file system takes, it takes from
 * one thread at a time; so one thread writes what is final already while the others search.
 *
 * A strip is some rows that are final, of all kept frames; a piece is a strip of some frames, the work of one thread at a time. A band is
 * what of a strip's frame is put together and handed on at once. Where there are no rows to hand on, and nobody is at any, a piece is some of the
 * room that the rows will take, as long as not all of it was asked for while frames were read: who writes does not wait for that, either.
 * When the last block lies, what is to be known of the whole map is a piece, too: one thread reckons it while another writes the last rows.
 *
 * Threads: take and done under one lock of the caller's; `run` from any, each piece once. What goes on while frames are read is over before.
 */
#ifndef TTF_SYNTH_QUILT_AHEAD_H
#define TTF_SYNTH_QUILT_AHEAD_H

#include <stdbool.h>
#include <stdint.h>

#include "search/kept.h"
#include "search/learner.h"
#include "ttf/base/attr.h"
#include "ttf/base/err.h"
#include "ttf/synth/metrics.h"
#include "ttf/synth/run.h"

struct ttf_ahead;

enum ttf_ahead_kind {
    TTF_AHEAD_ROWS, /* of a strip */
    TTF_AHEAD_ROOM, /* the next part of the file's room */
    TTF_AHEAD_MAP   /* whole: its runs, its sums */
};

struct ttf_ahead_piece {
    enum ttf_ahead_kind kind;
    uint32_t from, to; /* frames of rows */
};

/* Of the whole map. */
struct ttf_ahead_sums {
    uint64_t digest; /* ttf_quilt_map_digest */
    struct ttf_repetition_figures repetition;
};

/* All borrowed; kept: read before the first piece. -ENOMEM. */
TTF_MUST_USE int ttf_ahead_create(const struct ttf_quilt_config *config, struct ttf_kept *kept,
                                  const struct ttf_quilt_sink *sink, unsigned threads,
                                  struct ttf_ahead **ret);
void ttf_ahead_destroy(struct ttf_ahead *ahead); /* NULL allowed */

/* What is done while frames are read: they are kept, and the sink takes room. Valid as long as `ahead` is. */
const struct ttf_aside *ttf_ahead_aside(const struct ttf_ahead *ahead);

/*
 * Is there a piece to hand on, of the map's first final_rows rows, or of room, or the map itself, when all rows are final? alone: only if no other
 * thread is at one of rows. The map is borrowed, the same each time; its runs are filled in the end. -ENOMEM; 0: there is none now; 1: *ret, to be run and reported as done.
 */
TTF_MUST_USE int ttf_ahead_take(struct ttf_ahead *ahead, struct ttf_quilt_map *map,
                                uint32_t final_rows, bool alone, struct ttf_ahead_piece *ret);

/* -ENOMEM, the sink's errors. */
TTF_MUST_USE int ttf_ahead_run(struct ttf_ahead *ahead, const struct ttf_ahead_piece *piece,
                               unsigned worker, struct ttf_err *err);
void ttf_ahead_done(struct ttf_ahead *ahead, const struct ttf_ahead_piece *piece);

/* Are all rows handed on, and is the map summed up? */
bool ttf_ahead_finished(const struct ttf_ahead *ahead);

/* Memory that summing up a map of so many source pixels takes meanwhile. */
size_t ttf_ahead_sums_bytes(size_t source_pixels);

/* When it is finished. */
const struct ttf_ahead_sums *ttf_ahead_sums(const struct ttf_ahead *ahead);

/* ttf_quilt_plan, which hands rows on as they become final (in k-space and not tileable: only there are there any before the end). */
TTF_MUST_USE int ttf_plan_ahead(const struct ttf_quilt_config *config, struct ttf_sequence *input,
                                struct ttf_pool *pool, struct ttf_ahead *ahead,
                                struct ttf_quilt_map *ret, struct ttf_err *err);

/* Adds times and memory to the report. */
void ttf_ahead_costs(const struct ttf_ahead *ahead, struct ttf_quilt_report *report);

#endif
