/* SPDX-License-Identifier: Apache-2.0 */
/* One slot: lamps, exposures, hand over. README.md, "The way of a slot". */
#include <errno.h>
#include <stdio.h>
#include <string.h>

#include "exposure.h"
#include "plan_change.h"
#include "plan_figures.h"
#include "session_private.h"

/* A slot begun later than this part of its interval is missed rather than taken late. */
#define LATE_SHARE 10

static int64_t now_ns(const struct ttf_session *s)
{
    return ttf_clock_now_ns(s->box->clock);
}

/* NULL: the committer has them all. */
static struct ttf_slot_work *new_work(struct ttf_session *s, int64_t index)
{
    struct ttf_slot_work *work = ttf_stock_slot(&s->queue.stock);

    if (!work)
        return NULL;
    work->record.index = index;
    work->record.segment = s->segment;
    work->record.due_ns = ttf_grid_due_ns(&s->grid, index);
    work->total = s->plan.count;
    work->begun_ns = now_ns(s);
    return work;
}

/* The later of a slot's wakings counts. */
static void note_wakeup(struct ttf_slot_work *work, int64_t late_ns)
{
    if (late_ns != TTF_NS_UNKNOWN &&
        (work->wakeup_ns == TTF_NS_UNKNOWN || late_ns > work->wakeup_ns))
        work->wakeup_ns = late_ns;
}

static void want_lamps(struct ttf_session *s, const unsigned levels[TTF_LAMPS_MAX])
{
    if (ttf_lamp_driver_want(&s->lamps, levels))
        s->lamps_changed_ns = now_ns(s);
}

static int hand_over(struct ttf_session *s, struct ttf_slot_work *work)
{
    struct ttf_job *job = ttf_job_new(&s->queue, TTF_JOB_SLOT);

    if (!job) { /* there is one for each slot */
        ttf_stock_give_slot(&s->queue.stock, work);
        ttf_queue_tell_fatal(&s->queue, -ENOMEM, NULL);
        return -ENOMEM;
    }
    job->slot = work;
    ttf_queue_push(&s->queue, job);
    return 0;
}

int ttf_session_hand_over_change(struct ttf_session *s, struct ttf_plan_change *change)
{
    struct ttf_slot_work *work = ttf_stock_slot(&s->queue.stock);

    if (!work) {
        ttf_plan_change_free(change);
        return -ENOMEM;
    }
    work->change = change;
    return hand_over(s, work);
}

/* Thousands of lost slots wait for each other, while the disk takes them one by one. */
static int work_by_and_by(struct ttf_session *s, int64_t index, struct ttf_slot_work **ret)
{
    int r = 0;

    while (r == 0 && !(*ret = new_work(s, index)))
        r = ttf_pulse_wait(&s->pulse, now_ns(s) + 10 * TTF_NS_PER_MS, false);
    return r;
}

int ttf_session_no_slot(struct ttf_session *s, int64_t index, enum ttf_result result,
                        const char *reason)
{
    struct ttf_slot_work *work = NULL;
    int r = work_by_and_by(s, index, &work);

    if (r < 0)
        return r;
    work->record.result = result;
    snprintf(work->record.reason, sizeof(work->record.reason), "%s", reason);
    return hand_over(s, work);
}

/* Waits between slots; the lamps follow their programme. *ret_late_ns: how late it woke, if it slept. 1: something was asked, or the clock corrected. */
static int idle_until(struct ttf_session *s, int64_t until_ns, int64_t *ret_late_ns)
{
    for (;;) {
        unsigned levels[TTF_LAMPS_MAX];
        int64_t now = now_ns(s);
        int64_t next = ttf_lamp_programme_next_change(&s->programme, now);
        int r;

        ttf_lamp_programme_background(&s->programme, now, levels);
        want_lamps(s, levels);
        r = ttf_pulse_wait(&s->pulse, next < until_ns ? next : until_ns, true);
        if (r != 0)
            return r;
        if (next >= until_ns) {
            *ret_late_ns = now < until_ns ? now_ns(s) - until_ns : TTF_NS_UNKNOWN;
            return 0;
        }
    }
}

/* A free raw sum, waited for until a deadline: 1; 0: none came; or as beat. */
static int raw_by(struct ttf_session *s, const struct ttf_frame_format *format, int64_t deadline_ns,
                  struct ttf_raw_sum **ret)
{
    for (;;) {
        int r = ttf_queue_take_raw(&s->queue, format, ret);

        if (r != 0)
            return r;
        if (now_ns(s) >= deadline_ns)
            return 0;
        r = ttf_pulse_gate(&s->pulse, s->queue.room, deadline_ns);
        if (r < 0 && r != -ETIMEDOUT)
            return r;
    }
}

/* What one shot of a slot needs to know. */
struct shooting {
    struct ttf_session *s;
    struct ttf_slot_work *work;
    unsigned shot;
    unsigned image;          /* of the record */
    unsigned shots_used;     /* of the places in the work's room */
    int64_t give_up_ns;      /* the next slot needs the loop by then */
    struct ttf_raw_sum *raw; /* taken for the first image already; NULL */
};

static int push_image(struct shooting *g, const struct ttf_take *take)
{
    struct ttf_job *job = ttf_job_new(&g->s->queue, TTF_JOB_IMAGE);

    if (!job)
        return -ENOMEM;
    job->slot = g->work;
    job->image = g->image;
    job->shot = g->shot;
    job->raw = take->raw;
    job->start_utc_ns = ttf_pulse_utc_at(&g->s->pulse, take->start_ns);
    ttf_queue_push(&g->s->queue, job);
    return 0;
}

/*
 * By the exposures that were granted: the mains' grid and the camera's steps may keep them from the
 * plan's own numbers. 0 without brackets.
 */
static double relative_exposure(const struct ttf_session *s, unsigned shot, unsigned bracket)
{
    const struct ttf_plan_shot *plan = &s->plan.shots[shot];
    unsigned reference = 0;

    if (plan->n_brackets <= 1)
        return 0;
    while (reference + 1 < plan->n_brackets && plan->brackets[reference] != 1)
        reference++;
    return (double)s->locked[shot][bracket].granted.exposure_ns /
           (double)s->locked[shot][reference].granted.exposure_ns;
}

/* Takes image `bracket` of the shot. middle_ns as of ttf_take. */
static int take_image(struct shooting *g, unsigned bracket, int64_t middle_ns)
{
    struct ttf_session *s = g->s;
    const struct ttf_plan_shot *shot = &s->plan.shots[g->shot];
    struct ttf_shooter *camera = &s->cameras[s->camera_of[g->shot]];
    struct ttf_image *image = &g->work->record.images[g->image];
    struct ttf_take take = {.locked = &s->locked[g->shot][bracket],
                            .average = shot->average,
                            .middle_ns = middle_ns,
                            .give_up_ns = g->give_up_ns,
                            .settle_ns = ttf_lamp_settle_ns(&s->plan, shot, s->box->lamps),
                            .raw = g->raw,
                            .image = image,
                            .shots_room = shot->average * TTF_SHOOT_TRIES};
    int r = 1;

    snprintf(image->stream, sizeof(image->stream), "%s", shot->stream);
    image->shots = g->work->room->shots + g->shots_used;
    image->bracket = shot->n_brackets > 1 ? (int)bracket : -1;
    image->relative_exposure = relative_exposure(s, g->shot, bracket);
    g->raw = NULL;
    if (!take.raw)
        r = raw_by(s, &camera->format, g->give_up_ns, &take.raw);
    if (r < 0)
        return r;
    if (r == 0) {
        snprintf(image->lacking, sizeof(image->lacking), "%s", TTF_REASON_STORAGE_SLOW);
        s->trouble = true;
        return 0;
    }
    r = ttf_shoot(camera, &take);
    s->trouble |= take.trouble;
    g->shots_used += image->n_shots;
    if (g->image == 0)
        g->work->record.middle_ns = take.middle_got_ns;
    if (r == 0 && image->lacking[0] == '\0') {
        r = push_image(g, &take);
        if (r == 0)
            return 0;
    }
    ttf_queue_give_raw(&s->queue, take.raw);
    return r;
}

/* All images of a shot; lamps are set and settled here. submit_ns: not before (the first shot); 0. */
static int take_shot(struct shooting *g, int64_t submit_ns, int64_t due_ns)
{
    struct ttf_session *s = g->s;
    const struct ttf_plan_shot *shot = &s->plan.shots[g->shot];
    bool first = submit_ns != 0;
    int64_t ready;
    bool asleep;
    int r;

    want_lamps(s, s->programme.shot[g->shot]);
    ready = s->lamps_changed_ns + ttf_lamp_settle_ns(&s->plan, shot, s->box->lamps);
    if (ready < submit_ns)
        ready = submit_ns;
    asleep = now_ns(s) < ready;
    r = ttf_pulse_wait(&s->pulse, ready, false);
    if (r < 0)
        return r;
    if (first && asleep)
        note_wakeup(g->work, now_ns(s) - ready);
    for (unsigned b = 0; b < ttf_shot_images(shot); b++, g->image++) {
        r = take_image(g, b, first && b == 0 ? due_ns : 0);
        if (r < 0)
            return r;
    }
    return 0;
}

/* What the readings of one moment mean together. */
static void watch_climate(struct ttf_session *s, const struct ttf_reading *readings, unsigned n)
{
    enum ttf_climate_news news;
    char text[192];

    while ((news = ttf_climate_watch_look(&s->climate, readings, n, text, sizeof(text))) !=
           TTF_CLIMATE_NOTHING)
        ttf_events_emit(&s->events, news == TTF_CLIMATE_DEW ? "dew" : "supply", "%s", text);
}

static void read_sensors(struct ttf_session *s, struct ttf_slot_record *record)
{
    struct ttf_reading readings[TTF_SENSORS_MAX];
    int n = s->box->sensors ? ttf_sensors_read(s->box->sensors, readings, NULL) : 0;

    record->n_sensors = 0;
    for (int i = 0; i < n && i < TTF_SLOT_SENSORS_MAX; i++) {
        struct ttf_slot_sensor *sensor = &record->sensors[record->n_sensors++];

        snprintf(sensor->name, sizeof(sensor->name), "%.31s", readings[i].name);
        snprintf(sensor->kind, sizeof(sensor->kind), "%s", ttf_sensor_kind_name(readings[i].kind));
        sensor->ok = readings[i].ok;
        sensor->value = readings[i].ok ? readings[i].value : 0;
        if (s->sensor_silent[i] != !readings[i].ok)
            ttf_events_emit(&s->events, "sensor",
                            readings[i].ok ? "%s answers again" : "%s does not answer",
                            readings[i].name);
        s->sensor_silent[i] = !readings[i].ok;
    }
    if (n > 0)
        watch_climate(s, readings, (unsigned)n);
}

/* Why a slot cannot even begin, or NULL. */
static const char *cannot_begin(const struct ttf_session *s, int64_t due_ns)
{
    if (now_ns(s) > due_ns + s->plan.interval_ns / LATE_SHARE) {
        for (unsigned i = 0; i < s->n_cameras; i++) {
            if (s->cameras[i].down)
                return TTF_REASON_RECOVERING;
        }
        return TTF_REASON_LATE;
    }
    return ttf_queue_disk_full((struct ttf_queue *)&s->queue) ? TTF_REASON_DISK_FULL : NULL;
}

/* The images of a slot that has a first raw sum. Consumes it. */
static int take_slot(struct ttf_session *s, struct ttf_slot_work *work, struct ttf_raw_sum *raw,
                     int64_t submit_ns)
{
    struct ttf_grid *grid = &s->grid;
    int64_t due = work->record.due_ns;
    struct shooting g = {.s = s,
                         .work = work,
                         .raw = raw,
                         .give_up_ns = ttf_grid_due_ns(grid, work->record.index + 1) - s->lead_ns};
    int r = 0;

    for (g.shot = 0; g.shot < s->plan.n_shots && r == 0; g.shot++)
        r = take_shot(&g, g.shot == 0 ? submit_ns : 0, due);
    ttf_queue_give_raw(&s->queue, g.raw);
    return r;
}

static void rehearsed(struct ttf_session *s, const struct ttf_slot_work *work)
{
    int64_t took = now_ns(s) - work->begun_ns;

    if (took > s->rehearsal.expose_ns)
        s->rehearsal.expose_ns = took;
}

static int revive_cameras(struct ttf_session *s)
{
    for (unsigned i = 0; i < s->n_cameras; i++) {
        int r = ttf_shooter_revive(&s->cameras[i]);

        if (r < 0)
            return r;
    }
    return 0;
}

/* From the first lamp command on. */
static int do_slot(struct ttf_session *s, int64_t index, int64_t submit_ns, int64_t late_ns)
{
    const struct ttf_shooter *camera = &s->cameras[s->camera_of[0]];
    unsigned levels[TTF_LAMPS_MAX];
    struct ttf_slot_work *work;
    struct ttf_raw_sum *raw = NULL;
    int r;

    /* Lamps first: they settle while room is waited for. */
    work = new_work(s, index);
    if (!work || !ttf_stock_images(&s->queue.stock, work)) {
        ttf_stock_give_slot(&s->queue.stock, work);
        return ttf_session_no_slot(s, index, TTF_RESULT_MISSED, TTF_REASON_STORAGE_SLOW);
    }
    note_wakeup(work, late_ns);
    want_lamps(s, s->programme.shot[0]);
    r = raw_by(s, &camera->format, submit_ns, &raw);
    if (r <= 0) {
        ttf_stock_give_slot(&s->queue.stock, work);
        return r < 0 ? r
                     : ttf_session_no_slot(s, index, TTF_RESULT_MISSED, TTF_REASON_STORAGE_SLOW);
    }
    r = take_slot(s, work, raw, submit_ns);
    if (r < 0) {
        /* The run is over, but the committer may hold images of this slot: it frees it, unwritten. */
        ttf_queue_tell_fatal(&s->queue, r, NULL);
        (void)hand_over(s, work);
        return r;
    }
    ttf_lamp_programme_background(&s->programme, now_ns(s), levels);
    want_lamps(s, levels);
    read_sensors(s, &work->record);
    rehearsed(s, work);
    return hand_over(s, work);
}

/* Until a slot's first lamp command is due. What is asked meanwhile may move it, or do away with it. */
static int await_slot(struct ttf_session *s, int64_t index, int64_t *ret_late_ns)
{
    int r;

    do {
        r = ttf_session_hear(s, index);
        if (r < 0 || !ttf_session_has_slot(s, index))
            return r;
        r = idle_until(s, ttf_grid_due_ns(&s->grid, index) - s->lead_ns, ret_late_ns);
    } while (r == 1);
    return r;
}

int ttf_session_slot(struct ttf_session *s, int64_t index)
{
    const struct ttf_camera_caps *caps = ttf_camera_caps(s->cameras[s->camera_of[0]].camera);
    int64_t late = TTF_NS_UNKNOWN;
    int64_t due;
    int64_t submit;
    const char *reason;
    int r = revive_cameras(s);

    if (r == 0)
        r = await_slot(s, index, &late);
    if (r < 0 || index >= s->plan.count)
        return r;
    if (s->paused)
        return ttf_session_no_slot(s, index, TTF_RESULT_PAUSED, s->pause_reason);
    due = ttf_grid_due_ns(&s->grid, index);
    submit = due - ttf_exposure_lead_ns(caps, s->locked[0][0].granted.exposure_ns);
    reason = cannot_begin(s, due);
    if (reason) {
        if (strcmp(reason, TTF_REASON_DISK_FULL) == 0) /* nobody else makes room */
            ttf_pulse_led(&s->pulse, TTF_LED_STOPPED);
        return ttf_session_no_slot(s, index, TTF_RESULT_MISSED, reason);
    }
    s->trouble = false;
    r = do_slot(s, index, submit, late);
    ttf_pulse_led(&s->pulse, s->trouble ? TTF_LED_WARNING : TTF_LED_CAPTURING);
    return r;
}
