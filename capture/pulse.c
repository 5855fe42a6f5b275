/* SPDX-License-Identifier: Apache-2.0 */
#include "pulse.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

#include "asks.h"
#include "resume.h"

void ttf_pulse_begin(struct ttf_pulse *pulse, struct ttf_box *box, struct ttf_queue *queue,
                     struct ttf_events *events, struct ttf_lamp_driver *lamps,
                     const volatile int *stop)
{
    struct ttf_utc utc;

    memset(pulse, 0, sizeof(*pulse));
    pulse->box = box;
    pulse->queue = queue;
    pulse->events = events;
    pulse->lamps = lamps;
    pulse->stop = stop;
    ttf_clock_utc(box->clock, &utc);
    ttf_utc_watch_init(&pulse->utc, &utc);
    pulse->gap_segment = -1;
    pulse->door_was_opened_ns = TTF_NS_UNKNOWN;
    pulse->door_was_closed_ns = TTF_NS_UNKNOWN;
    if (box->panel)
        pulse->door_open = ttf_panel_door(box->panel) == 1;
    /* If it is, nobody knows since when: since ever. */
}

void ttf_pulse_guard(struct ttf_pulse *pulse)
{
    struct ttf_watchdog *watchdog = pulse->box->watchdog;

    int r = watchdog ? ttf_watchdog_arm(watchdog, TTF_WATCHDOG_NS) : 0;

    if (r < 0)
        ttf_events_emit(pulse->events, "watchdog", "cannot be armed for %d s: %s",
                        (int)(TTF_WATCHDOG_NS / TTF_NS_PER_S), strerrordesc_np(-r));
    pulse->watchdog = watchdog && r == 0;
}

void ttf_pulse_end(struct ttf_pulse *pulse)
{
    if (pulse->watchdog)
        ttf_watchdog_disarm(pulse->box->watchdog);
    pulse->watchdog = false;
}

bool ttf_pulse_stop_wanted(const struct ttf_pulse *pulse)
{
    /* Set by a signal handler or by another thread: nothing else hangs on it, so relaxed will do. */
    return pulse->button_stop ||
           (pulse->stop && __atomic_load_n(pulse->stop, __ATOMIC_RELAXED) != 0);
}

/* A better vouched-for UTC corrects what the segment's line says of its origin. */
static void correct_one(struct ttf_pulse *pulse, struct ttf_segment *s, const struct ttf_utc *utc)
{
    struct ttf_job *job;

    s->origin_utc_ns = utc->utc_ns + (s->origin_ns - utc->boot_ns);
    s->uncertainty_ns = utc->uncertainty_ns;
    snprintf(s->trust, sizeof(s->trust), "%s", ttf_trust_name(utc->trust));
    if (s->segment == pulse->gap_segment && pulse->has_before)
        s->gap_ns = ttf_resume_gap_ns(&pulse->before, s->first_index, s->origin_utc_ns);
    s->corrects = true;
    job = ttf_job_new(pulse->queue, TTF_JOB_SEGMENT);
    if (!job)
        return; /* the next trust or step tries again */
    job->segment = *s;
    ttf_queue_push(pulse->queue, job);
}

static void correct_segment(struct ttf_pulse *pulse, const struct ttf_utc *utc)
{
    pulse->corrected = true;
    /* The one that a resume goes by comes first. */
    correct_one(pulse, &pulse->segment, utc);
    for (unsigned i = 0; i < pulse->n_earlier; i++)
        correct_one(pulse, &pulse->earlier[i], utc);
}

void ttf_pulse_next_segment(struct ttf_pulse *pulse, const struct ttf_segment *segment)
{
    if (pulse->n_earlier == TTF_PULSE_EARLIER)
        memmove(&pulse->earlier[0], &pulse->earlier[1],
                --pulse->n_earlier * sizeof(pulse->earlier[0]));
    pulse->earlier[pulse->n_earlier++] = pulse->segment;
    pulse->segment = *segment;
}

int64_t ttf_pulse_utc_at(const struct ttf_pulse *pulse, int64_t boot_ns)
{
    const struct ttf_segment *s = &pulse->segment;

    if (!pulse->has_segment)
        return ttf_utc_watch_at(&pulse->utc, boot_ns);
    if (s->origin_utc_ns == TTF_NS_UNKNOWN || boot_ns == TTF_NS_UNKNOWN)
        return TTF_NS_UNKNOWN;
    return s->origin_utc_ns + (boot_ns - s->origin_ns);
}

void ttf_pulse_behind(struct ttf_pulse *pulse, const struct ttf_utc *utc)
{
    pulse->behind = true;
    ttf_events_emit(pulse->events, "clock",
                    "UTC (%s) lies before the last slot of before: it labels no slot, and moves no "
                    "end",
                    ttf_trust_name(utc->trust));
}

/*
 * A clock that was set is believed: were the segment left as it is, the step would look like an outage after the
 * next power cut, and slots would be given up as lost to it. One that is vouched for less than another was before
 * in this boot is not: it says nothing that the boot clock has not kept.
 */
static bool may_correct(const struct ttf_pulse *pulse, const struct ttf_utc *utc)
{
    return pulse->has_segment && utc->trust != TTF_TRUST_NONE &&
           utc->trust >= ttf_segment_trust(&pulse->segment);
}

/*
 * Nor is one that contradicts a boot before, unless it is the box's own that has labelled this one so far: that it was
 * set has been seen. Once it has come past the last slot of that boot it contradicts nothing any more.
 */
static void believe(struct ttf_pulse *pulse, const struct ttf_utc *utc, bool news)
{
    const enum ttf_trust known = ttf_segment_trust(&pulse->segment);
    const bool was_behind = pulse->behind;

    pulse->behind = ttf_resume_clock_behind(pulse->past, utc);
    if (!pulse->behind && was_behind)
        ttf_events_emit(pulse->events, "clock",
                        "UTC (%s) contradicts the last slot of before no more: it is believed",
                        ttf_trust_name(utc->trust));
    if (!pulse->behind || (news && utc->trust == known && known > TTF_TRUST_HOST))
        correct_segment(pulse, utc);
    else if (news)
        ttf_pulse_behind(pulse, utc);
}

static void look_at_utc(struct ttf_pulse *pulse)
{
    struct ttf_utc_news what;
    struct ttf_utc utc;
    bool news;

    ttf_clock_utc(pulse->box->clock, &utc);
    news = ttf_utc_watch_look(&pulse->utc, &utc, &what);
    if (news && what.stepped)
        ttf_events_emit(pulse->events, "clock-step", "UTC stepped by %+.3f s; the grid stays",
                        (double)what.step_ns / 1e9);
    if (news && what.more_trusted)
        ttf_events_emit(pulse->events, "clock", "UTC is now vouched for by %s",
                        ttf_trust_name(utc.trust));
    if ((news || pulse->behind) && may_correct(pulse, &utc))
        believe(pulse, &utc, news);
}

static void note_door(struct ttf_pulse *pulse, bool open, int64_t at_ns)
{
    if (open == pulse->door_open)
        return;
    if (open) {
        pulse->door_opened_ns = at_ns;
    } else {
        pulse->door_was_opened_ns = pulse->door_opened_ns;
        pulse->door_was_closed_ns = at_ns;
    }
    pulse->door_open = open;
    ttf_events_emit(pulse->events, "door", open ? "opened" : "closed");
}

static void look_at_panel(struct ttf_pulse *pulse)
{
    struct ttf_panel *panel = pulse->box->panel;
    struct ttf_panel_event event;
    int door;

    if (!panel)
        return;
    for (int i = 0; i < 16 && ttf_panel_poll(panel, &event) == 1; i++) {
        if (event.kind == TTF_PANEL_BUTTON_LONG) {
            pulse->button_stop = true;
            ttf_events_emit(pulse->events, "button", "held: the run is to end");
        } else if (event.kind == TTF_PANEL_BUTTON_SHORT) {
            /* Told anew, a light that stands for capturing winks: whoever pressed sees that the run lives. */
            (void)!ttf_panel_led(panel, pulse->led);
        } else if (event.kind == TTF_PANEL_DOOR_OPENED || event.kind == TTF_PANEL_DOOR_CLOSED) {
            note_door(pulse, event.kind == TTF_PANEL_DOOR_OPENED, event.at_ns);
        }
    }
    /* Should an event have been lost. */
    door = ttf_panel_door(panel);
    if (door >= 0)
        note_door(pulse, door == 1, ttf_clock_now_ns(pulse->box->clock));
}

bool ttf_pulse_door_was_open(struct ttf_pulse *pulse, int64_t from_ns, int64_t until_ns)
{
    look_at_panel(pulse);
    if (pulse->door_open && pulse->door_opened_ns <= until_ns)
        return true;
    return pulse->door_was_closed_ns != TTF_NS_UNKNOWN && pulse->door_was_closed_ns >= from_ns &&
           pulse->door_was_opened_ns <= until_ns;
}

int ttf_pulse_beat(struct ttf_pulse *pulse, int64_t next_ns)
{
    const struct ttf_box *box = pulse->box;

    if (box->power_lost && box->power_lost(box->box_private))
        return -ESHUTDOWN;
    /* Declared before the wait, never after: overdue means stuck. */
    ttf_lamp_driver_alive(pulse->lamps, next_ns + TTF_ALIVE_MARGIN_NS);
    if (pulse->watchdog && ttf_watchdog_feed(box->watchdog) == -EPIPE)
        ttf_pulse_guard(pulse);
    look_at_panel(pulse);
    look_at_utc(pulse);
    return ttf_queue_fatal(pulse->queue);
}

int ttf_pulse_beat_blocking(struct ttf_pulse *pulse)
{
    return ttf_pulse_beat(pulse, ttf_clock_now_ns(pulse->box->clock) + TTF_BLOCKING_MAX_NS);
}

/* The end of this tick. */
static int64_t tick_end(const struct ttf_pulse *pulse, int64_t deadline_ns)
{
    int64_t tick = ttf_clock_now_ns(pulse->box->clock) + TTF_TICK_NS;

    return deadline_ns < tick ? deadline_ns : tick;
}

int ttf_pulse_wait(struct ttf_pulse *pulse, int64_t deadline_ns, bool stoppable)
{
    for (;;) {
        int64_t until = tick_end(pulse, deadline_ns);
        int r = ttf_pulse_beat(pulse, until);

        if (r < 0)
            return r;
        if (stoppable && ttf_pulse_stop_wanted(pulse))
            return -ECANCELED;
        if (stoppable && (pulse->corrected || ttf_asks_due(pulse->control, pulse->next_index)))
            return 1;
        if (ttf_clock_now_ns(pulse->box->clock) >= deadline_ns)
            return 0;
        r = ttf_clock_wait_until(pulse->box->clock, until);
        if (r < 0)
            return r;
        if (until == deadline_ns)
            return 0; /* on time: what a beat costs must not come between */
    }
}

int ttf_pulse_gate(struct ttf_pulse *pulse, struct ttf_gate *gate, int64_t deadline_ns)
{
    for (;;) {
        int64_t until = tick_end(pulse, deadline_ns);
        int r = ttf_pulse_beat(pulse, until);

        if (r < 0)
            return r;
        r = ttf_gate_wait(gate, until);
        if (r != -ETIMEDOUT || until == deadline_ns)
            return r;
    }
}

void ttf_pulse_last_gate(struct ttf_pulse *pulse, struct ttf_gate *gate)
{
    for (;;) {
        int64_t until = tick_end(pulse, TTF_NS_NEVER);

        /* Even a run that failed is brought to its end alive; one without power has nothing left to feed. */
        if (ttf_pulse_beat(pulse, until) == -ESHUTDOWN)
            ttf_pulse_end(pulse);
        if (ttf_gate_wait(gate, until) == 0)
            return;
    }
}

int ttf_pulse_next(struct ttf_pulse *pulse, struct ttf_camera *camera, int64_t deadline_ns,
                   struct ttf_frame **ret_frame, struct ttf_err *err)
{
    for (;;) {
        int64_t until = tick_end(pulse, deadline_ns);
        int r = ttf_pulse_beat(pulse, until);

        if (r < 0)
            return r;
        r = ttf_camera_next(camera, until, ret_frame, err);
        if (r != -ETIMEDOUT || until >= deadline_ns)
            return r;
    }
}

void ttf_pulse_led(struct ttf_pulse *pulse, enum ttf_led led)
{
    /* Told anew at each slot, a light that stands for capturing shows that slots are taken. */
    if (!pulse->box->panel || (pulse->led == led && led != TTF_LED_CAPTURING))
        return;
    if (ttf_panel_led(pulse->box->panel, led) == 0)
        pulse->led = led;
}
