/* SPDX-License-Identifier: Apache-2.0 */
/* judge.c: whether a capture that is wanted goes on. A slot that is due gets a record: records that do not come are one that does not. */
#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "alert.h"
#include "ttf/base/checked.h"

#define LEAST_NS   (500 * TTF_NS_PER_MS) /* that a record may be late, however short the interval */
/* A button's stop is written down once its run has ended: until then nobody knows who wanted it. */
#define DECIDED_NS (5 * TTF_NS_PER_S)

/* What a line of a dataset says may be any number: what lies beyond all time never comes. */
static int64_t later_ns(int64_t at_ns, int64_t by_ns)
{
    int64_t sum_ns;

    return at_ns != TTF_NS_NEVER && ttf_add_i64(at_ns, by_ns, &sum_ns) ? sum_ns : TTF_NS_NEVER;
}

/* When the next slot is due; UNKNOWN: its segment is of another boot, or there is none. */
static int64_t due_ns(const struct watch *w)
{
    const struct ttf_segment *s = &w->segment;
    int64_t next = later_ns(w->index, 1) > s->first_index ? later_ns(w->index, 1) : s->first_index;
    int64_t slots, since_ns;

    if (s->segment < 0 || strcmp(s->boot_id, ttf_clock_boot_id(w->clock)) != 0)
        return TTF_NS_UNKNOWN;
    if (__builtin_sub_overflow(next, s->first_index, &slots) ||
        !ttf_mul_i64(slots, s->interval_ns, &since_ns))
        return TTF_NS_NEVER;
    return later_ns(s->origin_ns, since_ns);
}

/* When the next record will have come, if all is well; NEVER: none is to come. */
static int64_t awaited_ns(const struct watch *w)
{
    int64_t late_ns = w->interval_ns / 2 > LEAST_NS ? w->interval_ns / 2 : LEAST_NS;
    int64_t at_ns = later_ns(w->since_ns, w->config->begin_ns), next_ns = due_ns(w);

    if (w->wanted.wants == WANTS_NOTHING && !w->came)
        return TTF_NS_NEVER;
    if (w->came && w->interval_ns > 0)
        at_ns = later_ns(later_ns(w->seen_ns, w->interval_ns), late_ns);
    else if (w->came)
        at_ns = later_ns(w->seen_ns, w->config->begin_ns);
    /* Lamps settle before the first slot, and a plan may have a start that is still to come. */
    if (next_ns != TTF_NS_UNKNOWN && at_ns < later_ns(next_ns, late_ns))
        at_ns = later_ns(next_ns, late_ns);
    return at_ns;
}

/* Behind an alarm: what the daemon says of it. */
static void alarm_with_words(struct watch *w, const char *kind, const char *text)
{
    char words[200] = "", whole[400];

    if (w->says)
        w->says(w->ctx, words, sizeof words);
    (void)snprintf(whole, sizeof whole, "%.190s%s%s", text, *words ? "; the box says: " : "",
                   words);
    w->stopped = true;
    watch_tell(w, kind, TTF_ALERT_ALARM, whole);
}

static void does_not_come(struct watch *w)
{
    int64_t now_ns = ttf_clock_now_ns(w->clock);
    char text[300];

    if (w->came) {
        (void)snprintf(text, sizeof text,
                       "the capture has stopped: no record for %.1f s, at an interval of %.1f s",
                       (double)(now_ns - w->seen_ns) / 1e9, (double)w->interval_ns / 1e9);
        alarm_with_words(w, "stopped", text);
        return;
    }
    (void)snprintf(text, sizeof text, "the capture has not %s: it should have for %.0f s",
                   w->index >= 0 ? "gone on" : "begun", (double)(now_ns - w->since_ns) / 1e9);
    alarm_with_words(w, "not-begun", text);
}

/* Told by its events to end, and no person is known to have wanted that. */
static void tell_ending(struct watch *w)
{
    if (w->told_end_ns == TTF_NS_UNKNOWN ||
        ttf_clock_now_ns(w->clock) - w->told_end_ns < DECIDED_NS)
        return;
    w->told_end_ns = TTF_NS_UNKNOWN;
    watch_tell(w, "event", TTF_ALERT_WARNING,
               w->by_button ? "stop: the button was held" : "stop: the program was told to end");
}

/* It is what it was wanted to be: no alarm, and told once. Of one that was found so, it was told before. */
static void rest(struct watch *w)
{
    char text[300];

    w->stopped = false;
    w->told_end_ns = TTF_NS_UNKNOWN;
    if (w->rests)
        return;
    w->rests = true;
    if (!w->looked)
        return;
    (void)snprintf(text, sizeof text,
                   "the capture was stopped by a person%s, and stays so until it is gone on with",
                   w->by_button ? ", by the button" : "");
    watch_tell(w, "stopped-by-person", TTF_ALERT_WARNING, text);
}

static void run(struct watch *w)
{
    tell_ending(w);
    if (!w->stopped && ttf_clock_now_ns(w->clock) > awaited_ns(w)) {
        does_not_come(w);
    } else if ((w->stopped || w->rests) && w->came && ttf_clock_now_ns(w->clock) <= awaited_ns(w)) {
        w->stopped = w->rests = w->by_button = false;
        watch_tell(w, "going-on", TTF_ALERT_NOTICE, "the capture goes on");
    }
}

/* ---- behind its end ---- */

static void settle(struct watch *w, bool is_news)
{
    if (is_news)
        watch_tell(w, "ended", TTF_ALERT_NOTICE, "the capture has come to its end");
    w->stopped = w->rests = w->doubted = false;
    w->asked_ns = ttf_clock_now_ns(w->clock);
}

/* The plan's file was written behind the end: it may be a longer one now. Also before we looked. */
static bool plan_is_newer(const struct watch *w)
{
    const struct ttf_io_stat *plan = &w->wanted.seen[1];
    struct ttf_io_stat records;
    char path[4200];

    (void)snprintf(path, sizeof path, "%s/records.jsonl", w->path);
    if (!plan->is_regular || w->io->ops->stat(w->io, path, &records) < 0)
        return false;
    return plan->mtime_ns != w->plan_mtime_ns || plan->mtime_ns > records.mtime_ns;
}

static void doubt(struct watch *w)
{
    w->doubted = true;
    w->came = false;
    w->since_ns = w->asked_ns = ttf_clock_now_ns(w->clock);
}

/*
 * What has ended is wanted by the configuration for ever, as nothing says that its plan is done but the daemon, which is asked each `begin`: one
 * that is idle has nothing to do. One that tries in vain has, and one that says nothing may have.
 */
static void ask_behind_end(struct watch *w)
{
    char words[200] = "";

    w->asked_ns = ttf_clock_now_ns(w->clock);
    if (w->says)
        w->says(w->ctx, words, sizeof words);
    if (strncmp(words, "idle", 4) == 0)
        settle(w, w->stopped);
    else if (!w->doubted && strncmp(words, "retrying", 8) == 0)
        doubt(w);
    else if (w->doubted && !w->stopped)
        does_not_come(w);
}

static void judge_ended(struct watch *w, bool ended_before)
{
    if (!ended_before ||
        w->seen_ns > w->asked_ns) { /* also one that went on and ended between two looks */
        w->plan_mtime_ns = w->wanted.seen[1].mtime_ns;
        settle(w, !w->fresh);
    }
    if (w->wanted.wants != WANTS_RUN)
        settle(w, false);
    else if (!w->doubted && plan_is_newer(w))
        doubt(w);
    else if (ttf_clock_now_ns(w->clock) - w->asked_ns > w->config->begin_ns)
        ask_behind_end(w);
}

void judge(struct watch *w, bool ended_before)
{
    if (w->ended) {
        judge_ended(w, ended_before);
        return;
    }
    w->doubted = false;
    switch (w->wanted.wants) {
    case WANTS_REST:
        rest(w);
        break;
    case WANTS_PERSON:
        if (!w->stopped)
            watch_tell(w, "stopped", TTF_ALERT_ALARM, w->wanted.why);
        w->stopped = true;
        break;
    case WANTS_NOTHING:
        w->stopped = w->stopped && w->came;
        run(w);
        break;
    case WANTS_RUN:
        run(w);
        break;
    }
}
