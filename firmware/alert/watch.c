/* SPDX-License-Identifier: Apache-2.0 */
/* watch.c: the dataset under way, from outside: what comes to its records and its events. */
#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

#include "alert.h"
#include "ttf/dataset/copy.h"
#include "ttf/dataset/manifest.h"
#include "ttf/dataset/reader.h"

#define LOOK_NS (500 * TTF_NS_PER_MS)
#define SOON_NS (50 * TTF_NS_PER_MS)

/* dataset/FORMAT.md: of slots that nobody wanted. */
#define BY_PERSON "stopped by a person"

void watch_tell(struct watch *w, const char *kind, enum ttf_alert_severity severity,
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

/* From now on records are waited for. */
static void expect(struct watch *w)
{
    w->since_ns = ttf_clock_now_ns(w->clock);
    w->came = false;
    w->told_end_ns = TTF_NS_UNKNOWN;
}

static void begin(struct watch *w, const char *name, const char *path)
{
    memset(&w->records, 0, sizeof w->records);
    memset(&w->events, 0, sizeof w->events);
    (void)snprintf(w->name, sizeof w->name, "%s", name);
    (void)snprintf(w->path, sizeof w->path, "%s", path);
    w->ended = w->losing = w->by_button = false;
    w->interval_ns = w->lost = 0;
    w->index = w->segment.segment = -1;
    expect(w);
}

void watch_init(struct watch *watch, const struct ttf_alerts_config *config, struct ttf_io *io,
                struct ttf_clock *clock)
{
    memset(watch, 0, sizeof *watch);
    watch->config = config;
    watch->io = io;
    watch->clock = clock;
    begin(watch, "", "");
}

/* ---- records ---- */

static void on_slot(struct watch *w, const struct ttf_slot_record *record)
{
    bool lost = record->result != TTF_RESULT_CAPTURED && record->result != TTF_RESULT_PAUSED &&
                strcmp(record->reason, BY_PERSON) != 0;
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
        watch_tell(w, "slots-lost", TTF_ALERT_WARNING, text);
    } else {
        (void)snprintf(text, sizeof text, "slots are captured again; %" PRId64 " were lost",
                       w->lost);
        w->lost = 0;
        watch_tell(w, "slots-captured", TTF_ALERT_NOTICE, text);
    }
}

static int on_record(void *ctx, const struct ttf_growth_line *line, struct ttf_err *err)
{
    struct watch *w = ctx;
    struct ttf_slot_record record;
    struct ttf_segment segment;

    w->seen_ns = ttf_clock_now_ns(w->clock);
    w->came = w->came || !w->fresh;
    w->ended = strcmp(line->type, "end") == 0;
    if (strcmp(line->type, "segment") == 0 && ttf_growth_segment(line, &segment, err) == 0 &&
        segment.segment >= w->segment.segment) { /* else it corrects one that is over */
        w->segment = segment;
        w->interval_ns = segment.interval_ns;
    }
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
    /* Who wanted it is found out first (judge.c). */
    if (strcmp(kind, "button") == 0 || strcmp(kind, "stop") == 0) {
        w->by_button = w->by_button || strcmp(kind, "button") == 0;
        w->told_end_ns = ttf_clock_now_ns(w->clock);
        return 0;
    }
    for (unsigned i = 0; i < sizeof ALARMS / sizeof *ALARMS; i++)
        if (strcmp(kind, ALARMS[i]) == 0)
            severity = TTF_ALERT_ALARM;
    (void)snprintf(said, sizeof said, "%s: %s", kind, text ? text : "");
    watch_tell(w, "event", severity, said);
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

/* ---- which one ---- */

static bool is_there(const struct watch *w, const char *path)
{
    char file[4200];
    struct ttf_io_stat st;

    (void)snprintf(file, sizeof file, "%s/dataset.json", path);
    return w->io->ops->stat(w->io, file, &st) == 0;
}

/*
 * Has the run gone on in the second storage? As capture/second_storage.c judges it: another dataset of this name may lie there, and one
 * that has ended, without its first, is of a run before.
 */
static bool went_on_in(const struct watch *w, const char *second, const char *first)
{
    struct ttf_manifest of_first, of_second;
    struct ttf_reader *reader;
    bool goes_on;

    if (ttf_manifest_load(w->io, second, &of_second, NULL) < 0 ||
        strcmp(of_second.group_member, "second") != 0)
        return false;
    if (ttf_manifest_load(w->io, first, &of_first, NULL) == 0)
        return strcmp(of_second.group_uuid, ttf_manifest_group(&of_first)) == 0;
    if (ttf_reader_open(w->io, second, &reader, NULL) < 0)
        return false;
    goes_on = ttf_reader_summary(reader)->n_segments > 0 && !ttf_reader_summary(reader)->sealed;
    ttf_reader_close(reader);
    return goes_on;
}

/* It was found there before, is watched and goes on. */
static bool is_watched(const struct watch *w, const char *name, const char *path)
{
    return !w->ended && strcmp(w->name, name) == 0 && strcmp(w->path, path) == 0 &&
           is_there(w, path);
}

/* The one that is to be captured; where nobody wants one, the newest: it may be captured without the daemon. */
static bool find(const struct watch *w, char ret_name[65], char ret_path[1200])
{
    const struct wanted *wanted = &w->wanted;
    char first[1200];

    if (wanted->wants != WANTS_NOTHING && *wanted->dataset)
        memcpy(ret_name, wanted->dataset, 65);
    else if (ttf_growth_newest(w->io, w->config->data, ret_name) < 0)
        return false;
    (void)snprintf(first, sizeof first, "%s/%s", w->config->data, ret_name);
    (void)snprintf(ret_path, 1200, "%s/%s", wanted->second, ret_name);
    if (!*wanted->second || (!is_watched(w, ret_name, ret_path) &&
                             (!is_there(w, ret_path) || !went_on_in(w, ret_path, first))))
        memcpy(ret_path, first, sizeof first);
    return true;
}

/* true: something else is wanted than before. */
static bool look_at_wanted(struct watch *w)
{
    struct wanted before = w->wanted;

    wanted_look(&w->wanted, w->config, w->io);
    if (w->wanted.wants == before.wants && strcmp(w->wanted.dataset, before.dataset) == 0)
        return false;
    expect(w);
    if (w->wanted.wants == WANTS_REST)
        w->rests = false;
    return true;
}

void watch_look(struct watch *w)
{
    char name[65], path[1200];
    bool other = look_at_wanted(w), ended_before;

    w->fresh = !w->looked; /* of one that came while we looked, all is news */
    if (find(w, name, path) && (strcmp(name, w->name) != 0 || strcmp(path, w->path) != 0)) {
        begin(w, name, path);
        w->fresh = w->fresh || (other && is_there(w, path)); /* it is gone on with */
    }
    ended_before = w->ended;
    if (w->name[0] != '\0')
        read_lines(w, "records.jsonl", &w->records, on_record);
    if (w->name[0] != '\0')
        read_lines(w, "events.jsonl", &w->events, on_event);
    judge(w, ended_before);
    w->looked = true;
    w->fresh = false;
}

int64_t watch_next_ns(const struct watch *w, int64_t now_ns)
{
    int64_t wait_ns = w->interval_ns > 0 ? w->interval_ns / 10 : LOOK_NS;

    if (wait_ns > LOOK_NS)
        wait_ns = LOOK_NS;
    return now_ns + (wait_ns < SOON_NS ? SOON_NS : wait_ns);
}
