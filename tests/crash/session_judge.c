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

/* A plan that the same call writes again; what was begun of a note before a cut. */
static bool may_stay(const char *file)
{
    return starts(file, "plans/") || starts(file, "notes.jsonl");
}

/* Deep; true if it is sealed. clean: with no leftovers but such as may stay. */
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
            (clean && !may_stay(f->file) && !s->promise.troubled))
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

/* ---- what was asked for ---- */

struct noted {
    const struct living *living;
    uint32_t seen; /* of its asks */
};

static void see_note(void *ctx, const struct ttf_note *note)
{
    struct noted *noted = ctx;

    for (unsigned i = 0; i < noted->living->n_asks; i++)
        if (noted->living->asks[i].kind == TTF_ASK_NOTE &&
            strcmp(note->text, living_note(noted->living, i)) == 0)
            noted->seen |= UINT32_C(1) << i;
}

/* Each note that was answered is in one of the datasets. */
static void look_notes(struct session_box *s, const char *second)
{
    struct noted noted = {.living = s->living};
    const struct ttf_note_visitor visitor = {.note = see_note, .ctx = &noted};

    if (ttf_notes_read(s->io, SESSION_PATH, &visitor, NULL) < 0 ||
        (second[0] && ttf_notes_read(s->io, second, &visitor, NULL) < 0))
        session_box_break(s, "notes cannot be read");
    for (unsigned i = 0; i < s->living->n_asks; i++)
        if (s->living->asks[i].kind == TTF_ASK_NOTE && (s->promise.done & UINT32_C(1) << i) &&
            !(noted.seen & UINT32_C(1) << i))
            session_box_break(s, "a note was answered and is lost: %s", living_note(s->living, i));
}

/* Its words are there as they were given, or not at all where none were. */
static void look_words(struct session_box *s, const char *path, int number)
{
    char file[700], *text = NULL;

    snprintf(file, sizeof(file), "%s/plans/%d.yaml", path, number);
    if (ttf_io_slurp(s->io, file, 1 << 20, &text, NULL, NULL) == 0 &&
        strcmp(text, "# as given\n") != 0 && strcmp(text, LIVING_YAML) != 0)
        session_box_break(s, "the words of plan %d are others: %s", number, text);
    free(text);
}

/* Which of the living's plans the dataset is left with. */
static int plan_there(struct session_box *s, const char *path)
{
    struct ttf_reader *reader = NULL;
    struct ttf_segment last = {0};
    struct ttf_plan plan = {0};
    char file[700], *text = NULL;
    size_t bytes;
    int i, r;

    r = ttf_reader_open(s->io, path, &reader, NULL);
    if (r == 0)
        r = ttf_reader_segment(reader, ttf_reader_summary(reader)->n_segments - 1, &last);
    ttf_reader_close(reader);
    if (r < 0)
        return r;
    snprintf(file, sizeof(file), "%s/plans/%d.json", path, last.plan);
    r = ttf_io_slurp(s->io, file, 1 << 20, &text, &bytes, NULL);
    if (r == 0)
        r = ttf_plan_read(text, bytes, file, &plan, NULL);
    free(text);
    if (r < 0 || plan.interval_ns != last.interval_ns)
        return -EINVAL;
    look_words(s, path, last.plan);
    for (i = 0; i < (int)s->living->n_plans; i++)
        if (ttf_plan_same(&plan, &s->living->plans[i]) == 1)
            return i;
    return -EINVAL;
}

/* The one that comes next, if it was asked for. */
static int plan_asked(const struct session_box *s)
{
    for (unsigned i = 0; i < s->living->n_asks; i++)
        if ((s->asks & UINT32_C(1) << i) && s->living->plan_of[i] > s->promise.plan)
            return s->living->plan_of[i];
    return s->promise.plan;
}

/* The plan in force is the last that was answered, the one asked for next, or the one that this boot was given. */
static void look_plan(struct session_box *s, const char *path)
{
    int plan = plan_there(s, path);

    if (plan < 0)
        session_box_break(s, "the plan in force cannot be read, or is none that was asked for");
    else if (plan < s->promise.plan)
        session_box_break(s, "plan %d was answered, and plan %d is in force", s->promise.plan,
                          plan);
    else if (plan != s->promise.plan && plan != s->given && plan != plan_asked(s))
        session_box_break(s, "plan %d is in force, and was not asked for after plan %d", plan,
                          s->promise.plan);
    else
        s->promise.plan = plan; /* who has seen it once sees it ever after */
}

/* No slot came in this boot at which it could be heard, but such as were lost before it, or behind the stop. */
static bool not_due(const struct session_box *s, unsigned ask)
{
    int64_t k = s->living->asks[ask].from_index;

    if (s->stopped)
        return true;
    for (k = k < s->slots_before ? s->slots_before : k; k < s->promise.n_slots; k++)
        if (s->promise.slots[k].result != TTF_RESULT_POWER &&
            s->promise.slots[k].result != TTF_RESULT_MISSED)
            return false;
    return true;
}

/* On a sound disk what is asked is done, unless it came too late. */
static void look_answers(struct session_box *s)
{
    for (unsigned i = 0; s->living && i < s->living->n_asks; i++) {
        int plan = s->living->plan_of[i], r = s->answers[i];

        if (r == 0 || r == -ENOENT || (r == -EAGAIN && not_due(s, i)) ||
            (r == -EINVAL && plan > 0 && s->living->plans[plan].count < s->promise.n_slots))
            continue;
        session_box_break(s, "ask %u is answered with %s", i, strerrordesc_np(-r));
    }
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
    if (s->living)
        look_notes(s, second);
    if (s->living && (moved || has_segment(s, SESSION_PATH)))
        look_plan(s, moved ? second : SESSION_PATH);
    if (there(s, SESSION_PATH))
        sealed = look_verify(s, SESSION_PATH, false);
    if (second[0] && there(s, second))
        sealed = look_verify(s, second, false);
    if (s->promise.sealed && !sealed)
        session_box_break(s, "the seal that was promised is not there");
    if (sealed && !s->promise.sealed && !s->promise.maybe_sealed &&
        s->promise.n_slots < session_box_count(s))
        session_box_break(s, "it is sealed, and not all slots were captured");
    look_slots(s, whole);
    look_events(s);
}

/* How a run that was not stopped ends, and one that was. */
static void look_end(struct session_box *s, const char *path)
{
    bool whole = s->promise.n_slots == session_box_count(s);

    if (s->result.sealed != !s->stopped || whole != !s->stopped)
        session_box_break(s, "ended with %lld of %lld slots, %s", (long long)s->promise.n_slots,
                          (long long)session_box_count(s),
                          s->result.sealed ? "sealed" : "not sealed");
    if (look_verify(s, path, true) != !s->stopped)
        session_box_break(s, s->stopped ? "it was stopped and is sealed"
                                        : "it ended and is not sealed");
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
    if (s->living) {
        look_notes(s, second);
        look_plan(s, moved ? second : SESSION_PATH);
        look_answers(s);
    }
    if (moved != s->result.second_storage)
        session_box_break(s, "the run says that it ended in the other storage");
    look_end(s, moved ? second : SESSION_PATH);
    if (moved && there(s, SESSION_PATH) && look_verify(s, SESSION_PATH, false))
        session_box_break(s, "it moved on, and the first dataset is sealed");
    look_slots(s, NULL);
    look_events(s);
}
