/* SPDX-License-Identifier: Apache-2.0 */
/*
 * history.h: what is remembered of datasets' records: columns for charts, and where each slot's line lies. Of the
 * datasets that were asked for last; one that grows is read on from where it was read to. Any thread.
 */
#ifndef HTTP_HISTORY_H
#define HTTP_HISTORY_H

#include <stddef.h>
#include <stdint.h>

#include "chart_points.h"
#include "chart_text.h"
#include "request.h"
#include "ttf/dataset/growth.h"

struct history;

/* Of one dataset; valid while it is held. */
struct history_of {
    struct ttf_growth growth;
    uint64_t begun; /* counts up when it was begun anew: the dataset is another one */
    struct chart_points points;
    struct chart_lamps lamps;
    struct chart_segments segments;
    struct history_line {
        int64_t index, offset;
    } * lines; /* in rising order of index */
    size_t n_lines, lines_room;
};

/* What a request reads at the most, some tenths of a second on a small board: who asks again gets more. */
#define HISTORY_AT_ONCE ((int64_t)4 << 20)

struct history *history_create(void); /* NULL: no memory */
void history_destroy(struct history *history);

/*
 * Reads what is new of the request's dataset, at most about max_bytes (0: all), and holds it until history_release.
 * 0; 1: there is more to read; a negative errno with request->err set, and nothing is held.
 */
TTF_MUST_USE int history_hold(struct ttf_http_request *request, int64_t max_bytes,
                              const struct history_of **ret);
void history_release(struct ttf_http_request *request);

/* Where in records.jsonl a slot's line begins; -ENOENT: there is none of this index. */
int64_t history_find(const struct history_of *of, int64_t index);

#endif
