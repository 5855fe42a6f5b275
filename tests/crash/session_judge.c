/* SPDX-License-Identifier: Apache-2.0 */
#include "session_judge.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "slot_hash.h"
#include "ttf/dataset/verify.h"

static bool starts(const char *text, const char *with)
{
    return strncmp(text, with, strlen(with)) == 0;
}

static bool there(const struct session_box *s, const char *path)
{
    char file[700];
    struct ttf_io_stat st;

    snprintf(file, sizeof(file), "%s/dataset.json", path);
    return s->io->ops->stat(s->io, file, &st) == 0;
}

/* Deep; true if it is sealed. clean: with no leftovers but plans that the same call writes again. */
static bool look_verify(struct session_box *s, const char *path, bool clean)
{
    const struct ttf_verify_options options = {.deep = true};
    const struct ttf_verify_finding *f;
    struct ttf_verify_report report;
    struct ttf_err err = {0};
    bool sealed;
    unsigned i;
    int r;

    r = ttf_verify(s->io, path, &options, &report, &err);
    if (r < 0) {
        session_box_break(s, "verify cannot look: %s: %s", err.where, err.what);
        return false;
    }
    for (i = 0; i < report.n_findings; i++) {
        f = &report.findings[i];
        if (f->severity == TTF_FINDING_DAMAGE ||
            (clean && !starts(f->file, "plans/") && !s->promise.troubled))
            session_box_break(s, "verify finds %s: %s/%s %s", ttf_severity_name(f->severity), path,
                              f->file, f->text);
    }
    sealed = report.sealed;
    ttf_verify_report_free(&report);
    return sealed;
}

/* ---- slots ---- */

static void look_slot(struct session_box *s, int64_t index, const struct session_slot *as)
{
    struct ttf_slot_record record;
    int r = session_box_record(s, index, &record);

    if (r < 0) {
        session_box_break(s, "slot %lld was acknowledged and is lost (%s)", (long long)index,
                          strerrordesc_np(-r));
        return;
    }
    if ((int)record.result != as->result || (as->hash != 0 && slot_hash(&record) != as->hash))
        session_box_break(s, "slot %lld is not as it was acknowledged", (long long)index);
    ttf_slot_record_free(&record);
}

/* What is there of a slot that was not acknowledged. */
static void look_other_slot(struct session_box *s, int64_t index,
                            const struct session_promise *whole)
{
    struct ttf_slot_record record;

    if (session_box_record(s, index, &record) < 0)
        return;
    if (!whole)
        session_box_break(s, "slot %lld is shown, and was not acknowledged", (long long)index);
    else if (!whole->troubled && whole->slots[index].acknowledged &&
             slot_hash(&record) != whole->slots[index].hash)
        session_box_break(s, "slot %lld is shown otherwise than it was captured", (long long)index);
    else /* who has seen it once sees it ever after */
        s->promise.slots[s->promise.n_slots++] =
            (struct session_slot){true, (int)record.result, slot_hash(&record)};
    ttf_slot_record_free(&record);
}

static void look_slots(struct session_box *s, const struct session_promise *whole)
{
    int64_t i, n = s->promise.n_slots;

    for (i = 0; i < SESSION_SLOTS_MAX; i++)
        if (i < n)
            look_slot(s, i, &s->promise.slots[i]);
        else
            look_other_slot(s, i, i == n ? whole : NULL);
}

/* ---- events ---- */

static char *slurp_events(const struct session_box *s, const char *path)
{
    char file[700], *text = NULL;

    snprintf(file, sizeof(file), "%s/events.jsonl", path);
    if (!there(s, path) || ttf_io_slurp(s->io, file, 1 << 24, &text, NULL, NULL) < 0)
        return NULL;
    return text;
}

/* Each event that was told is in one of the datasets; of a disk that failed none is promised. */
static void look_events(struct session_box *s)
{
    char second[600], *a, *b = NULL;
    unsigned i;

    if (s->promise.troubled || s->promise.n_events == 0)
        return;
    session_box_second_path(s, second);
    a = slurp_events(s, SESSION_PATH);
    if (second[0])
        b = slurp_events(s, second);
    for (i = 0; i < s->promise.n_events; i++)
        if (!strpbrk(s->events[i], "\"\\") && !(a && strstr(a, s->events[i])) &&
            !(b && strstr(b, s->events[i])))
            session_box_break(s, "an event was told and is lost: %s", s->events[i]);
    free(a);
    free(b);
}

/* ---- all ---- */

static bool has_segment(const struct session_box *s, const char *path)
{
    struct ttf_reader *reader = NULL;
    bool has;

    if (path[0] == '\0' || ttf_reader_open(s->io, path, &reader, NULL) < 0)
        return false;
    has = ttf_reader_summary(reader)->n_segments > 0;
    ttf_reader_close(reader);
    return has;
}

void session_look(struct session_box *s, const struct session_promise *whole)
{
    bool sealed = false, moved;
    char second[600];

    session_box_second_path(s, second);
    moved = has_segment(s, second);
    if (s->promise.armed && !moved && !has_segment(s, SESSION_PATH)) {
        session_box_break(s, "the dataset was there, and is not any more");
        return;
    }
    if (there(s, SESSION_PATH))
        sealed = look_verify(s, SESSION_PATH, false);
    if (second[0] && there(s, second))
        sealed = look_verify(s, second, false);
    if (s->promise.sealed && !sealed)
        session_box_break(s, "the seal that was promised is not there");
    if (sealed && !s->promise.sealed && !s->promise.maybe_sealed &&
        s->promise.n_slots < s->plan.count)
        session_box_break(s, "it is sealed, and not all slots were captured");
    look_slots(s, whole);
    look_events(s);
}

void session_look_whole(struct session_box *s)
{
    char second[600];
    bool moved;

    if (s->code != 0) {
        session_box_break(s, "the run does not end: %s: %s", s->err.where, s->err.what);
        return;
    }
    session_box_second_path(s, second);
    moved = has_segment(s, second);
    if (!s->result.sealed || s->promise.n_slots != s->plan.count)
        session_box_break(s, "ended with %lld of %lld slots, %s", (long long)s->promise.n_slots,
                          (long long)s->plan.count, s->result.sealed ? "sealed" : "not sealed");
    if (moved != s->result.second_storage)
        session_box_break(s, "the run says that it ended in the other storage");
    if (!look_verify(s, moved ? second : SESSION_PATH, true))
        session_box_break(s, "it ended and is not sealed");
    if (moved && there(s, SESSION_PATH) && look_verify(s, SESSION_PATH, false))
        session_box_break(s, "it moved on, and the first dataset is sealed");
    look_slots(s, NULL);
    look_events(s);
}
