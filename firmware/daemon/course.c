/* SPDX-License-Identifier: Apache-2.0 */
#include "course.h"

#include <stdlib.h>
#include <string.h>

void course_forget(struct course *c)
{
    free(c->readings);
    *c = (struct course){.next_index = -1, .readings_index = -1};
    for (int part = 0; part < COURSE_PARTS; part++) {
        c->records[part].last_index = -1;
        for (int i = 0; i < COURSE_TAIL; i++)
            c->records[part].tail[i].index = -1;
    }
}

/* ---- what is told ---- */

void course_letter(struct course *c, const struct letter *letter)
{
    if (letter->kind != TTF_PROGRESS_ARMED && letter->kind != TTF_PROGRESS_SLOT &&
        letter->kind != TTF_PROGRESS_EVENT)
        return;
    c->total = letter->total;
    if (letter->kind == TTF_PROGRESS_ARMED) {
        c->lit_ns = letter->lit_ns;
        c->settled_ns = letter->settled_ns;
    }
    if (letter->kind != TTF_PROGRESS_SLOT)
        return;
    c->last = *letter;
    c->has_last = true;
    c->next_index = letter->index + 1;
}

/* Slots that were counted in the first part and turn out to be the second one's. */
static void take_back(struct course_records *records, int64_t from_index)
{
    for (int i = 0; i < COURSE_TAIL; i++) {
        if (records->tail[i].index < from_index)
            continue;
        records->counts[records->tail[i].result]--;
        records->tail[i].index = -1;
    }
}

void course_segment(struct course *c, enum course_part part, const struct ttf_segment *segment)
{
    struct course_records *records = &c->records[part];

    /* A late correction of one that is over is passed over. */
    if (records->has_segment && segment->segment < records->segment.segment)
        return;
    if (!records->has_segment) {
        records->first_index = segment->first_index;
        if (part == COURSE_SECOND)
            take_back(&c->records[COURSE_FIRST], segment->first_index);
    }
    records->segment = *segment;
    records->has_segment = true;
    if (c->next_index < segment->first_index)
        c->next_index = segment->first_index;
}

static bool counts(const struct course *c, enum course_part part, int64_t index)
{
    const struct course_records *second = &c->records[COURSE_SECOND];

    if (index <= c->records[part].last_index)
        return false;
    return part == COURSE_SECOND || !second->has_segment || index < second->first_index;
}

static void keep_readings(struct course *c, int64_t index, const char *readings)
{
    char *copy = readings && index > c->readings_index ? strdup(readings) : NULL;

    if (!copy)
        return;
    free(c->readings);
    c->readings = copy;
    c->readings_index = index;
}

void course_record(struct course *c, enum course_part part, const struct ttf_slot_record *record,
                   const char *readings)
{
    struct course_records *records = &c->records[part];

    if (!counts(c, part, record->index))
        return;
    records->last_index = record->index;
    records->counts[record->result]++;
    records->tail[record->index % COURSE_TAIL].index = record->index;
    records->tail[record->index % COURSE_TAIL].result = record->result;
    if (c->next_index <= record->index)
        c->next_index = record->index + 1;
    keep_readings(c, record->index, readings);
}

/* ---- what is said ---- */

/* The grid that slots come by: in the second storage they are numbered and timed anew. NULL: there is none yet. */
static const struct ttf_segment *grid(const struct course *c)
{
    for (int part = COURSE_PARTS - 1; part >= 0; part--)
        if (c->records[part].has_segment)
            return &c->records[part].segment;
    return NULL;
}

void course_put_next(const struct course *c, bool moving, int64_t now_ns, struct ttf_json *json)
{
    const struct ttf_segment *g = grid(c);
    int64_t due_ns;

    if (!moving || !g || c->next_index < 0 || c->next_index >= c->total)
        return;
    due_ns = g->origin_ns + (c->next_index - g->first_index) * g->interval_ns;
    ttf_json_key(json, "next");
    ttf_json_object(json);
    ttf_json_kint(json, "index", c->next_index);
    ttf_json_kint(json, "due_boot_ns", due_ns);
    if (g->origin_utc_ns != TTF_NS_UNKNOWN && strcmp(g->trust, "none") != 0)
        ttf_json_kint(json, "due_utc_ns", g->origin_utc_ns + (due_ns - g->origin_ns));
    ttf_json_kint(json, "in_ns", due_ns - now_ns);
    ttf_json_object_end(json);
}

void course_put_slot(const struct letter *letter, struct ttf_json *json)
{
    ttf_json_kint(json, "index", letter->index);
    ttf_json_kstring(json, "result", ttf_result_name((enum ttf_result)letter->result));
    if (*letter->text && letter->result != TTF_RESULT_CAPTURED)
        ttf_json_kstring(json, "why", letter->text);
    if (letter->error_ns != TTF_NS_UNKNOWN)
        ttf_json_kint(json, "error_ns", letter->error_ns);
    if (letter->wakeup_ns != TTF_NS_UNKNOWN)
        ttf_json_kint(json, "wakeup_ns", letter->wakeup_ns);
}

static int64_t counted(const struct course *c, int result)
{
    return c->records[COURSE_FIRST].counts[result] + c->records[COURSE_SECOND].counts[result];
}

static void put_counts(const struct course *c, struct ttf_json *json)
{
    int64_t done = 0;

    for (int i = 0; i < TTF_RESULT_COUNT; i++)
        done += counted(c, i);
    ttf_json_kint(json, "done", done);
    ttf_json_key(json, "results");
    ttf_json_object(json);
    for (int i = 0; i < TTF_RESULT_COUNT; i++)
        ttf_json_kint(json, ttf_result_name((enum ttf_result)i), counted(c, i));
    ttf_json_object_end(json);
}

void course_put(const struct course *c, bool moving, int64_t now_ns, struct ttf_json *json)
{
    const struct ttf_segment *g = grid(c);

    if (c->total > 0)
        ttf_json_kint(json, "slots", c->total);
    put_counts(c, json);
    if (g)
        ttf_json_kint(json, "interval_ns", g->interval_ns);
    course_put_next(c, moving, now_ns, json);
    if (moving && g && c->total > 0)
        ttf_json_kint(json, "ends_in_ns",
                      g->origin_ns + (c->total - 1 - g->first_index) * g->interval_ns - now_ns);
    if (moving && c->lit_ns <= now_ns && now_ns < c->settled_ns)
        ttf_json_kint(json, "settled_in_ns", c->settled_ns - now_ns);
    if (c->has_last) {
        ttf_json_key(json, "last");
        ttf_json_object(json);
        course_put_slot(&c->last, json);
        ttf_json_object_end(json);
    }
}
