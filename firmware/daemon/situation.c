/* SPDX-License-Identifier: Apache-2.0 */
#include "situation.h"

#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "alarms.h"

struct situation {
    struct ttf_clock *clock;
    pthread_mutex_t lock; /* over all below */
    enum doing doing;
    bool starts; /* WAITING, for the plan's start: all is armed */
    char why[512];
    int64_t retry_at_ns; /* TTF_NS_UNKNOWN: never */
    bool has_run, by_request, sealed;
    int64_t run; /* its number */
    char dataset[65], plan[65], second[512];
    int64_t slot_bytes, reserve_bytes; /* 0: not known */
    struct course course;
    struct alarms alarms;
};

const char *doing_name(enum doing doing)
{
    static const char *const NAMES[] = {"idle",   "waiting",  "arming",   "capturing",
                                        "paused", "stopping", "retrying", "stopped"};

    return NAMES[doing];
}

struct situation *situation_create(struct ttf_clock *clock)
{
    struct situation *s = calloc(1, sizeof *s);

    if (!s)
        return NULL;
    s->clock = clock;
    course_forget(&s->course);
    s->retry_at_ns = TTF_NS_UNKNOWN;
    (void)pthread_mutex_init(&s->lock, NULL);
    return s;
}

void situation_destroy(struct situation *s)
{
    if (!s)
        return;
    (void)pthread_mutex_destroy(&s->lock);
    course_forget(&s->course);
    free(s);
}

static void lock(struct situation *s)
{
    (void)pthread_mutex_lock(&s->lock);
}

static void unlock(struct situation *s)
{
    (void)pthread_mutex_unlock(&s->lock);
}

/* ---- what is written ---- */

/* The lock is held. */
static bool is_about(const struct situation *s, const char *dataset)
{
    return strcmp(s->dataset, dataset) == 0;
}

/* How many slots there are to be, and when its lamps have settled, the run has said itself. */
static void forget_records(struct situation *s)
{
    const struct course said = s->course;

    course_forget(&s->course);
    s->course.total = said.total;
    s->course.lit_ns = said.lit_ns;
    s->course.settled_ns = said.settled_ns;
}

void situation_forget(struct situation *s, const char *dataset)
{
    lock(s);
    if (is_about(s, dataset)) {
        forget_records(s);
        s->sealed = false;
    }
    unlock(s);
}

int64_t situation_run(struct situation *s, const struct order *order, const char *second)
{
    int64_t run;

    lock(s);
    if (!s->has_run || strcmp(s->dataset, order->dataset) != 0) {
        s->run += s->has_run;
        course_forget(&s->course);
        s->sealed = false;
        s->slot_bytes = s->reserve_bytes = 0;
        s->second[0] = '\0';
    }
    if (second && strcmp(s->second, second) != 0) {
        forget_records(s);
        (void)snprintf(s->second, sizeof s->second, "%s", second);
    }
    s->has_run = true;
    s->by_request = order->by_request;
    s->sealed = s->sealed || order->state == ORDER_DONE;
    memcpy(s->dataset, order->dataset, sizeof s->dataset);
    memcpy(s->plan, order->plan, sizeof s->plan);
    run = s->run;
    unlock(s);
    return run;
}

void situation_storage(struct situation *s, int64_t slot_bytes, int64_t reserve_bytes)
{
    lock(s);
    s->slot_bytes = slot_bytes;
    s->reserve_bytes = reserve_bytes;
    unlock(s);
}

void situation_sealed(struct situation *s)
{
    lock(s);
    s->sealed = true;
    (void)alarms_done(&s->alarms, s->run);
    unlock(s);
}

bool situation_set(struct situation *s, enum doing doing, const char *why, int64_t retry_ns)
{
    bool other;

    lock(s);
    other = s->doing != doing || strcmp(s->why, why ? why : "") != 0;
    s->doing = doing;
    s->starts = false;
    (void)snprintf(s->why, sizeof s->why, "%s", why ? why : "");
    s->retry_at_ns =
        retry_ns == TTF_NS_UNKNOWN ? TTF_NS_UNKNOWN : ttf_clock_now_ns(s->clock) + retry_ns;
    unlock(s);
    return other;
}

bool situation_turn(struct situation *s, enum doing from, enum doing to)
{
    bool was;

    lock(s);
    was = s->doing == from;
    if (was) {
        s->doing = to;
        s->starts = false;
    }
    unlock(s);
    return was;
}

enum doing situation_doing(struct situation *s)
{
    enum doing doing;

    lock(s);
    doing = s->doing;
    unlock(s);
    return doing;
}

bool situation_letter(struct situation *s, const struct letter *letter)
{
    enum doing before;
    int64_t total;
    bool other, over;

    lock(s);
    before = s->doing;
    total = s->course.total;
    if (letter->kind == TTF_PROGRESS_ALARM)
        alarms_add(&s->alarms, s->clock, letter->run, letter->until, letter->text);
    over = letter->kind == TTF_PROGRESS_ALARM_OVER && alarms_over(&s->alarms, letter->text);
    over = (letter->kind == TTF_PROGRESS_ARMED && alarms_armed(&s->alarms, letter->run)) || over;
    if (letter->run != s->run) {
        unlock(s);
        return over;
    }
    course_letter(&s->course, letter);
    if (letter->kind == TTF_PROGRESS_ARMED) {
        s->sealed = false;
        if (s->doing == DOING_ARMING)
            s->doing = letter->waits ? DOING_WAITING : DOING_CAPTURING;
        s->starts = s->doing == DOING_WAITING;
    }
    if (letter->kind == TTF_PROGRESS_SLOT) {
        bool paused = letter->result == TTF_RESULT_PAUSED;

        if (s->doing == DOING_CAPTURING || s->doing == DOING_PAUSED || s->starts)
            s->doing = paused ? DOING_PAUSED : DOING_CAPTURING;
        s->starts = false;
    }
    other = s->doing != before;
    if (letter->kind == TTF_PROGRESS_EVENT && s->course.total != total)
        other = true; /* the next slot, which would say so, may be hours away */
    unlock(s);
    return other || over;
}

bool situation_is_of(struct situation *s, const struct letter *letter)
{
    bool is;

    lock(s);
    is = letter->run == s->run;
    unlock(s);
    return is;
}

void situation_segment(struct situation *s, const char *dataset, enum course_part part,
                       const struct ttf_segment *segment)
{
    lock(s);
    if (is_about(s, dataset))
        course_segment(&s->course, part, segment);
    unlock(s);
}

void situation_record(struct situation *s, const char *dataset, enum course_part part,
                      const struct ttf_slot_record *record, const char *readings)
{
    lock(s);
    if (is_about(s, dataset))
        course_record(&s->course, part, record, readings);
    unlock(s);
}

void situation_dataset(struct situation *s, char ret[65])
{
    char second[512];

    situation_records(s, ret, second);
}

void situation_records(struct situation *s, char ret[65], char ret_second[512])
{
    lock(s);
    memcpy(ret, s->dataset, sizeof s->dataset);
    memcpy(ret_second, s->second, sizeof s->second);
    unlock(s);
}

/* ---- what is said ---- */

static bool moving(const struct situation *s)
{
    return s->doing == DOING_CAPTURING || s->doing == DOING_PAUSED || s->doing == DOING_STOPPING ||
           s->starts;
}

static void put_run(const struct situation *s, struct ttf_json *json)
{
    ttf_json_key(json, "run");
    ttf_json_object(json);
    ttf_json_kstring(json, "dataset", s->dataset);
    if (*s->plan)
        ttf_json_kstring(json, "plan", s->plan);
    ttf_json_kstring(json, "asked_by", s->by_request ? "request" : "configuration");
    course_put(&s->course, moving(s), ttf_clock_now_ns(s->clock), json);
    if (s->slot_bytes > 0)
        ttf_json_kint(json, "slot_bytes", s->slot_bytes);
    if (s->reserve_bytes > 0)
        ttf_json_kint(json, "reserve_bytes", s->reserve_bytes);
    ttf_json_kbool(json, "sealed", s->sealed);
    ttf_json_object_end(json);
}

static void put_doing(const struct situation *s, struct ttf_json *json)
{
    ttf_json_kstring(json, "state", doing_name(s->doing));
    if (*s->why)
        ttf_json_kstring(json, "why", s->why);
    if (s->retry_at_ns != TTF_NS_UNKNOWN)
        ttf_json_kint(json, "retry_in_ns", s->retry_at_ns - ttf_clock_now_ns(s->clock));
}

static void put_time(const struct situation *s, struct ttf_json *json)
{
    struct ttf_utc utc;

    ttf_clock_utc(s->clock, &utc);
    ttf_json_key(json, "time");
    ttf_json_object(json);
    ttf_json_kint(json, "utc_ns", utc.utc_ns);
    ttf_json_kstring(json, "trust", ttf_trust_name(utc.trust));
    ttf_json_kint(json, "boot_ns", utc.boot_ns);
    ttf_json_object_end(json);
}

void situation_status(struct situation *s, struct ttf_json *json)
{
    lock(s);
    put_doing(s, json);
    put_time(s, json);
    if (s->has_run)
        put_run(s, json);
    if (s->course.readings) {
        ttf_json_key(json, "readings");
        ttf_json_raw(json, s->course.readings);
    }
    ttf_json_key(json, "alarms");
    alarms_put(&s->alarms, json);
    unlock(s);
}

void situation_state_event(struct situation *s, struct ttf_json *json)
{
    lock(s);
    ttf_json_object(json);
    put_doing(s, json);
    if (s->has_run)
        ttf_json_kstring(json, "dataset", s->dataset);
    ttf_json_object_end(json);
    unlock(s);
}

void situation_slot_event(struct situation *s, const struct letter *letter, struct ttf_json *json)
{
    lock(s);
    ttf_json_object(json);
    ttf_json_kstring(json, "dataset", s->dataset);
    ttf_json_kint(json, "total", s->course.total);
    course_put_slot(letter, json);
    course_put_next(&s->course, moving(s), ttf_clock_now_ns(s->clock), json);
    ttf_json_object_end(json);
    unlock(s);
}
