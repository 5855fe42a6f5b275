/* SPDX-License-Identifier: Apache-2.0 */
/* watch.c: the dataset under way, from outside. A slot that is due gets a record: records that stop are a capture that stopped. */
#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

#include "alert.h"
#include "ttf/dataset/copy.h"

#define LEAST_NS (500 * TTF_NS_PER_MS) /* that a record may be late, however short the interval */
#define LOOK_NS  (500 * TTF_NS_PER_MS)
#define SOON_NS  (50 * TTF_NS_PER_MS)

static void tell(struct watch *w, const char *kind, enum ttf_alert_severity severity,
                 const char *text)
{
    struct alert alert = {.kind = kind, .severity = severity, .index = w->index};
    struct ttf_utc utc;

    ttf_clock_utc(w->clock, &utc);
    alert.utc_ns = utc.utc_ns;
    (void)snprintf(alert.text, sizeof alert.text, "%s", text);
    (void)snprintf(alert.dataset, sizeof alert.dataset, "%s", w->name);
    w->tell(w->ctx, &alert);
}

static void begin(struct watch *w, const char *name)
{
    memset(&w->records, 0, sizeof w->records);
    memset(&w->events, 0, sizeof w->events);
    (void)snprintf(w->name, sizeof w->name, "%s", name);
    (void)snprintf(w->path, sizeof w->path, "%s/%s", w->folder, name);
    w->fresh = true;
    w->ended = w->stopped = w->losing = false;
    w->interval_ns = w->lost = 0;
    w->index = -1;
    w->seen_ns = ttf_clock_now_ns(w->clock);
}

/* ---- records ---- */

static void on_slot(struct watch *w, const struct ttf_slot_record *record)
{
    bool lost = record->result != TTF_RESULT_CAPTURED && record->result != TTF_RESULT_PAUSED;
    char text[300];

    w->index = record->index;
    w->lost += lost;
    if (w->fresh || lost == w->losing) {
        w->losing = lost;
        w->lost = lost ? w->lost : 0;
        return;
    }
    w->losing = lost;
    if (lost) {
        (void)snprintf(text, sizeof text, "slots are being lost: %s, %s",
                       ttf_result_name(record->result), record->reason);
        tell(w, "slots-lost", TTF_ALERT_WARNING, text);
    } else {
        (void)snprintf(text, sizeof text, "slots are captured again; %" PRId64 " were lost",
                       w->lost);
        w->lost = 0;
        tell(w, "slots-captured", TTF_ALERT_NOTICE, text);
    }
}

static int on_record(void *ctx, const struct ttf_growth_line *line, struct ttf_err *err)
{
    struct watch *w = ctx;
    struct ttf_slot_record record;
    struct ttf_segment segment;

    w->seen_ns = ttf_clock_now_ns(w->clock);
    w->ended = strcmp(line->type, "end") == 0;
    if (strcmp(line->type, "segment") == 0 && ttf_growth_segment(line, &segment, err) == 0)
        w->interval_ns = segment.interval_ns;
    if (strcmp(line->type, "slot") == 0 && ttf_growth_slot(line, &record, err) == 0) {
        on_slot(w, &record);
        ttf_slot_record_free(&record);
    }
    return 0;
}

static int on_event(void *ctx, const struct ttf_growth_line *line, struct ttf_err *err)
{
    static const char *const ALARMS[] = {"storage", "lamp-trip", "disk"};
    struct watch *w = ctx;
    const char *kind = json_string_value(json_object_get(line->json, "kind"));
    const char *text = json_string_value(json_object_get(line->json, "text"));
    enum ttf_alert_severity severity = TTF_ALERT_WARNING;
    char said[380];

    (void)err;
    if (w->fresh || !kind)
        return 0;
    for (unsigned i = 0; i < sizeof ALARMS / sizeof *ALARMS; i++)
        if (strcmp(kind, ALARMS[i]) == 0)
            severity = TTF_ALERT_ALARM;
    (void)snprintf(said, sizeof said, "%s: %s", kind, text ? text : "");
    tell(w, "event", severity, said);
    return 0;
}

static void read_lines(struct watch *w, const char *name, struct ttf_growth *growth,
                       ttf_growth_fn *fn)
{
    char path[4200];

    (void)snprintf(path, sizeof path, "%s/%s", w->path, name);
    if (ttf_growth_read(w->io, path, growth, 0, fn, w, NULL) == -ESTALE)
        w->name[0] =
            '\0'; /* another dataset has come into its place: from its beginning, next time */
}

/* ---- */

static int64_t patience_ns(const struct watch *w)
{
    int64_t late_ns = w->interval_ns / 2;

    return w->interval_ns + (late_ns > LEAST_NS ? late_ns : LEAST_NS);
}

static void judge(struct watch *w, bool ended_before)
{
    int64_t silent_ns = ttf_clock_now_ns(w->clock) - w->seen_ns;
    char text[300];

    if (w->ended) {
        if (!ended_before && !w->fresh)
            tell(w, "ended", TTF_ALERT_NOTICE, "the capture has come to its end");
        w->stopped = false;
        return;
    }
    if (w->interval_ns > 0 && !w->stopped && silent_ns > patience_ns(w)) {
        w->stopped = true;
        (void)snprintf(text, sizeof text,
                       "the capture has stopped: no record for %.1f s, at an interval of %.1f s",
                       (double)silent_ns / 1e9, (double)w->interval_ns / 1e9);
        tell(w, "stopped", TTF_ALERT_ALARM, text);
    } else if (w->stopped && silent_ns <= patience_ns(w)) {
        w->stopped = false;
        tell(w, "going-on", TTF_ALERT_NOTICE, "the capture goes on");
    }
}

void watch_look(struct watch *w)
{
    char newest[65];
    bool ended_before;

    if (ttf_growth_newest(w->io, w->folder, newest) == 0 && strcmp(newest, w->name) != 0) {
        bool first = w->name[0] == '\0' && w->seen_ns == 0;

        begin(w, newest);
        w->fresh = first; /* of one that came while we looked, all is news */
    }
    if (w->name[0] == '\0')
        return;
    ended_before = w->ended;
    read_lines(w, "records.jsonl", &w->records, on_record);
    if (w->name[0] != '\0')
        read_lines(w, "events.jsonl", &w->events, on_event);
    judge(w, ended_before);
    w->fresh = false;
}

int64_t watch_next_ns(const struct watch *w, int64_t now_ns)
{
    int64_t wait_ns = w->interval_ns > 0 ? w->interval_ns / 10 : LOOK_NS;

    if (wait_ns > LOOK_NS)
        wait_ns = LOOK_NS;
    return now_ns + (wait_ns < SOON_NS ? SOON_NS : wait_ns);
}
