/* SPDX-License-Identifier: Apache-2.0 */
#include "situation.h"

#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define ALARMS 8

struct alarm {
    int64_t utc_ns; /* TTF_NS_UNKNOWN */
    char text[256];
};

struct situation {
    struct ttf_clock *clock;
    pthread_mutex_t lock; /* over all below */
    enum doing doing;
    char why[512];
    int64_t retry_at_ns; /* TTF_NS_UNKNOWN: never */
    bool has_run, by_request, sealed;
    int64_t run; /* its number */
    char dataset[65], plan[65], second[512];
    int64_t total, slot_bytes; /* 0: not known */
    int64_t counts[TTF_RESULT_COUNT];
    int64_t next_index; /* -1: not known */
    int64_t last_index; /* of a record that was counted; -1: none */
    struct ttf_segment segment;
    bool has_segment, in_second; /* the segment is one of the second storage */
    bool has_last;
    struct letter last;
    char *readings; /* JSON; NULL */
    unsigned n_alarms;
    struct alarm alarms[ALARMS]; /* the oldest first */
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
    s->next_index = s->last_index = -1;
    s->retry_at_ns = TTF_NS_UNKNOWN;
    (void)pthread_mutex_init(&s->lock, NULL);
    return s;
}

void situation_destroy(struct situation *s)
{
    if (!s)
        return;
    (void)pthread_mutex_destroy(&s->lock);
    free(s->readings);
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

static void forget(struct situation *s)
{
    memset(s->counts, 0, sizeof s->counts);
    s->next_index = s->last_index = -1;
    s->has_segment = s->in_second = s->has_last = s->sealed = false;
    free(s->readings);
    s->readings = NULL;
}

/* The lock is held. */
static bool is_about(const struct situation *s, const char *dataset)
{
    return strcmp(s->dataset, dataset) == 0;
}

void situation_forget(struct situation *s, const char *dataset)
{
    lock(s);
    if (is_about(s, dataset))
        forget(s);
    unlock(s);
}

void situation_second(struct situation *s, const char *folder)
{
    lock(s);
    (void)snprintf(s->second, sizeof s->second, "%s", folder);
    unlock(s);
}

void situation_get_second(struct situation *s, char ret[512])
{
    lock(s);
    memcpy(ret, s->second, sizeof s->second);
    unlock(s);
}

int64_t situation_run(struct situation *s, const struct order *order)
{
    int64_t run;

    lock(s);
    if (!s->has_run || strcmp(s->dataset, order->dataset) != 0) {
        s->run += s->has_run;
        forget(s);
        s->total = s->slot_bytes = 0;
        s->second[0] = '\0';
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

void situation_slot_bytes(struct situation *s, int64_t bytes)
{
    lock(s);
    s->slot_bytes = bytes;
    unlock(s);
}

void situation_sealed(struct situation *s)
{
    lock(s);
    s->sealed = true;
    unlock(s);
}

bool situation_set(struct situation *s, enum doing doing, const char *why, int64_t retry_ns)
{
    bool other;

    lock(s);
    other = s->doing != doing || strcmp(s->why, why ? why : "") != 0;
    s->doing = doing;
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
    if (was)
        s->doing = to;
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

static void add_alarm(struct situation *s, const char *text)
{
    struct ttf_utc utc;
    struct alarm *alarm;

    ttf_clock_utc(s->clock, &utc);
    if (s->n_alarms == ALARMS)
        memmove(&s->alarms[0], &s->alarms[1], --s->n_alarms * sizeof s->alarms[0]);
    alarm = &s->alarms[s->n_alarms++];
    alarm->utc_ns = utc.trust == TTF_TRUST_NONE ? TTF_NS_UNKNOWN : utc.utc_ns;
    (void)snprintf(alarm->text, sizeof alarm->text, "%s", text);
}

bool situation_letter(struct situation *s, const struct letter *letter)
{
    enum doing before;
    bool other;

    lock(s);
    before = s->doing;
    if (letter->kind == TTF_PROGRESS_ALARM)
        add_alarm(s, letter->text);
    if (letter->run != s->run) {
        unlock(s);
        return false;
    }
    if (letter->kind == TTF_PROGRESS_ARMED || letter->kind == TTF_PROGRESS_SLOT)
        s->total = letter->total;
    if (letter->kind == TTF_PROGRESS_ARMED) {
        s->sealed = false;
        s->doing = s->doing == DOING_ARMING ? DOING_CAPTURING : s->doing;
    }
    if (letter->kind == TTF_PROGRESS_SLOT) {
        bool paused = letter->result == TTF_RESULT_PAUSED;

        s->last = *letter;
        s->has_last = true;
        s->next_index = letter->index + 1;
        if (s->doing == DOING_CAPTURING || s->doing == DOING_PAUSED)
            s->doing = paused ? DOING_PAUSED : DOING_CAPTURING;
    }
    other = s->doing != before;
    unlock(s);
    return other;
}

bool situation_is_of(struct situation *s, const struct letter *letter)
{
    bool is;

    lock(s);
    is = letter->run == s->run;
    unlock(s);
    return is;
}

void situation_segment(struct situation *s, const char *dataset, bool second,
                       const struct ttf_segment *segment)
{
    lock(s);
    /* A late correction of one that is over is passed over; those of the second storage are numbered anew. */
    if (!is_about(s, dataset) ||
        (s->has_segment && (s->in_second > second ||
                            (s->in_second == second && segment->segment < s->segment.segment)))) {
        unlock(s);
        return;
    }
    s->segment = *segment;
    s->has_segment = true;
    s->in_second = second;
    if (s->next_index < segment->first_index)
        s->next_index = segment->first_index;
    unlock(s);
}

void situation_record(struct situation *s, const char *dataset,
                      const struct ttf_slot_record *record, const char *readings)
{
    char *copy = readings ? strdup(readings) : NULL;

    lock(s);
    if (!is_about(s, dataset) || record->index <= s->last_index) {
        unlock(s);
        free(copy);
        return;
    }
    s->last_index = record->index;
    s->counts[record->result]++;
    if (s->next_index <= record->index)
        s->next_index = record->index + 1;
    if (copy) {
        free(s->readings);
        s->readings = copy;
    }
    unlock(s);
}

bool situation_dataset(struct situation *s, char ret[65])
{
    bool under_way;

    lock(s);
    memcpy(ret, s->dataset, 65);
    under_way = s->doing != DOING_IDLE && s->doing != DOING_STOPPED;
    unlock(s);
    return under_way;
}

/* ---- what is said ---- */

static bool moving(const struct situation *s)
{
    return s->doing == DOING_CAPTURING || s->doing == DOING_PAUSED || s->doing == DOING_STOPPING;
}

/* The slot that comes next, while one does. */
static void put_next(const struct situation *s, struct ttf_json *json)
{
    const struct ttf_segment *g = &s->segment;
    int64_t due_ns = g->origin_ns + (s->next_index - g->first_index) * g->interval_ns;

    if (!moving(s) || !s->has_segment || s->next_index < 0 || s->next_index >= s->total)
        return;
    ttf_json_key(json, "next");
    ttf_json_object(json);
    ttf_json_kint(json, "index", s->next_index);
    ttf_json_kint(json, "due_boot_ns", due_ns);
    if (g->origin_utc_ns != TTF_NS_UNKNOWN && strcmp(g->trust, "none") != 0)
        ttf_json_kint(json, "due_utc_ns", g->origin_utc_ns + (due_ns - g->origin_ns));
    ttf_json_kint(json, "in_ns", due_ns - ttf_clock_now_ns(s->clock));
    ttf_json_object_end(json);
}

static void put_letter(const struct letter *letter, struct ttf_json *json)
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

static void put_counts(const struct situation *s, struct ttf_json *json)
{
    int64_t done = 0;

    for (int i = 0; i < TTF_RESULT_COUNT; i++)
        done += s->counts[i];
    ttf_json_kint(json, "done", done);
    ttf_json_key(json, "results");
    ttf_json_object(json);
    for (int i = 0; i < TTF_RESULT_COUNT; i++)
        ttf_json_kint(json, ttf_result_name((enum ttf_result)i), s->counts[i]);
    ttf_json_object_end(json);
}

static void put_run(const struct situation *s, struct ttf_json *json)
{
    const struct ttf_segment *g = &s->segment;

    ttf_json_key(json, "run");
    ttf_json_object(json);
    ttf_json_kstring(json, "dataset", s->dataset);
    if (*s->plan)
        ttf_json_kstring(json, "plan", s->plan);
    ttf_json_kstring(json, "asked_by", s->by_request ? "request" : "configuration");
    if (s->total > 0)
        ttf_json_kint(json, "slots", s->total);
    put_counts(s, json);
    if (s->has_segment)
        ttf_json_kint(json, "interval_ns", g->interval_ns);
    put_next(s, json);
    if (moving(s) && s->has_segment && s->total > 0)
        ttf_json_kint(json, "ends_in_ns",
                      g->origin_ns + (s->total - 1 - g->first_index) * g->interval_ns -
                          ttf_clock_now_ns(s->clock));
    if (s->has_last) {
        ttf_json_key(json, "last");
        ttf_json_object(json);
        put_letter(&s->last, json);
        ttf_json_object_end(json);
    }
    if (s->slot_bytes > 0)
        ttf_json_kint(json, "slot_bytes", s->slot_bytes);
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
    if (s->readings) {
        ttf_json_key(json, "readings");
        ttf_json_raw(json, s->readings);
    }
    ttf_json_key(json, "alarms");
    ttf_json_array(json);
    for (unsigned i = 0; i < s->n_alarms; i++) {
        ttf_json_object(json);
        if (s->alarms[i].utc_ns != TTF_NS_UNKNOWN)
            ttf_json_kint(json, "utc_ns", s->alarms[i].utc_ns);
        ttf_json_kstring(json, "text", s->alarms[i].text);
        ttf_json_object_end(json);
    }
    ttf_json_array_end(json);
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
    ttf_json_kint(json, "total", s->total);
    put_letter(letter, json);
    put_next(s, json);
    ttf_json_object_end(json);
    unlock(s);
}
