/* SPDX-License-Identifier: Apache-2.0 */
/* A run: devices armed, dataset opened, slots one after another, an orderly end. README.md. */
#include "ttf/capture/session.h"

#include <errno.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "asks.h"
#include "commit_place.h"
#include "exposure.h"
#include "manifest_of_plan.h"
#include "plan_change.h"
#include "plan_figures.h"
#include "second_storage.h"
#include "session_private.h"
#include "ttf/dataset/reader.h"

/* Between the slots of a rehearsal. */
#define REHEARSAL_PAUSE_NS (500 * TTF_NS_PER_MS)

/* ---- setting up ---- */

/* Finds or adds the camera a shot names, configured. Its index. */
static int use_camera(struct ttf_session *s, unsigned shot, struct ttf_err *err)
{
    const char *name = s->plan.shots[shot].camera;
    struct ttf_camera_mode native = {0};
    struct ttf_shooter *shooter;
    int r;

    for (unsigned i = 0; i < s->n_cameras; i++) {
        if (strcmp(s->cameras[i].name, name) == 0)
            return (int)i;
    }
    shooter = &s->cameras[s->n_cameras]; /* no more than the box has */
    shooter->camera = ttf_box_camera_find(s->box, name);
    if (!shooter->camera)
        return ttf_err_set(err, -EINVAL, "shots", "the box has no camera '%s'", name);
    ttf_camera_stop(shooter->camera);
    r = ttf_camera_configure(shooter->camera, &native, &shooter->format, err);
    if (r < 0)
        return r;
    memcpy(shooter->name, s->plan.shots[shot].camera, sizeof(shooter->name));
    shooter->pulse = &s->pulse;
    shooter->events = &s->events;
    return (int)s->n_cameras++;
}

static int use_cameras(struct ttf_session *s, struct ttf_err *err)
{
    if (s->plan.n_shots > TTF_PLAN_SHOTS_MAX)
        return ttf_err_set(err, -EINVAL, "shots", "too many shots");
    for (unsigned i = 0; i < s->plan.n_shots; i++) {
        int camera = use_camera(s, i, err);

        if (camera < 0)
            return camera;
        s->camera_of[i] = (unsigned)camera;
    }
    return 0;
}

/* Where the dataset is: as configured, or where the run has moved on to. */
static int find_dataset(struct ttf_session *s, struct ttf_err *err)
{
    struct ttf_committer *c = &s->committer;
    int r;

    if (snprintf(s->path, sizeof(s->path), "%s", s->config->path) >= (int)sizeof(s->path))
        return ttf_err_set(err, -ENAMETOOLONG, NULL, "the dataset's path is too long");
    if (s->config->rehearse > 0)
        return 0;
    r = ttf_second_path(&s->plan, s->path, c->second_path, sizeof(c->second_path), err);
    if (r == 0)
        r = ttf_second_find(s->config->io, s->path, c->second_path, err);
    if (r <= 0)
        return r;
    snprintf(s->path, sizeof(s->path), "%s", c->second_path);
    c->moved = true; /* there is no third */
    return 0;
}

/* The words of the plan in force, for whoever reads plans/ of a second dataset. */
static int find_yaml(struct ttf_session *s, struct ttf_err *err)
{
    char path[4096 + 32];
    size_t bytes;
    int r = 0;

    if (s->moved_on_from < 0) {
        s->given_yaml = s->config->plan_yaml ? strdup(s->config->plan_yaml) : NULL;
        r = s->config->plan_yaml && !s->given_yaml ? -ENOMEM : 0;
    } else {
        snprintf(path, sizeof(path), "%s/plans/%d.yaml", s->path, s->known_plan);
        r = ttf_io_slurp(s->config->io, path, 1 << 20, &s->given_yaml, &bytes, NULL);
    }
    /* Without the words the plan is still whole. */
    return r == -ENOMEM ? ttf_err_set(err, r, s->path, "no memory for the plan's words") : 0;
}

/* A rehearsal is the same plan, a few slots, as fast as the box can expose them. */
static int prepare_plan(struct ttf_session *s, struct ttf_err *err)
{
    int r = ttf_plan_check(&s->plan, s->box, &s->figures, err);

    if (r < 0 || s->config->rehearse <= 0)
        return r;
    s->plan.count = s->config->rehearse;
    s->plan.end = TTF_END_COUNT;
    s->plan.until_utc_ns = s->plan.length_ns = 0;
    s->plan.interval_ns = s->figures.slot_busy_ns + REHEARSAL_PAUSE_NS;
    ttf_plan_figures_fill(&s->plan, s->box, &s->figures);
    return 0;
}

static int load_calibration(struct ttf_session *s, struct ttf_err *err)
{
    int r;

    if (!s->config->calibration_folder)
        return 0;
    r = ttf_calibration_load(s->config->io, s->config->calibration_folder, &s->calibration, err);
    s->has_calibration = r == 0;
    return r;
}

/* The last memory of a run: from now on it allocates nothing. */
static int reserve_memory(struct ttf_session *s, struct ttf_err *err)
{
    for (unsigned i = 0; i < s->n_cameras; i++) {
        int r = ttf_queue_reserve_raw(&s->queue, &s->cameras[i].format);

        if (r < 0)
            return ttf_err_set(err, r, s->cameras[i].name, "no memory for two raw frames");
    }
    return ttf_writer_reserve(s->committer.writer, s->committer.line_bytes, err);
}

static int set_up_darkrooms(struct ttf_session *s, struct ttf_err *err)
{
    const struct ttf_calibration *calibration = s->has_calibration ? &s->calibration : NULL;

    s->pool = ttf_pool_create(s->config->threads);
    if (!s->pool)
        return -ENOMEM;
    for (unsigned i = 0; i < s->n_cameras; i++) {
        struct ttf_darkroom_config config = {
            .plan = &s->plan,
            .camera = s->cameras[i].camera,
            .format = &s->cameras[i].format,
            .calibration =
                ttf_plan_calibrates(&s->plan, calibration, s->cameras[i].name) ? calibration : NULL,
            .pool = s->pool,
            .serial = s->box->serial,
            .software = "ttfbox " TTFBOX_VERSION,
            .simulated = s->box->simulated,
            .zone_offset_s = s->plan.zone_offset_s,
        };
        int r = ttf_darkroom_init(&s->rooms[i], &config, err);

        if (r < 0)
            return r;
    }
    for (unsigned i = 0; i < s->plan.n_shots; i++)
        s->committer.rooms[i] = &s->rooms[s->camera_of[i]];
    return 0;
}

/* Cameras streaming, every setting of the plan locked. */
static int arm_cameras(struct ttf_session *s, struct ttf_err *err)
{
    for (unsigned i = 0; i < s->n_cameras; i++) {
        int r = ttf_camera_start(s->cameras[i].camera, err);

        if (r < 0)
            return r;
    }
    for (unsigned i = 0; i < s->plan.n_shots; i++) {
        struct ttf_shooter *camera = &s->cameras[s->camera_of[i]];
        int64_t max_ns = ttf_camera_caps(camera->camera)->exposure_max_ns;

        for (unsigned b = 0; b < ttf_shot_images(&s->plan.shots[i]); b++) {
            struct ttf_exposure asked =
                ttf_shot_exposure(&s->plan.shots[i], b, s->plan.mains_hz, max_ns);
            int r = ttf_shooter_lock(camera, &asked, &s->locked[i][b], err);

            if (r < 0)
                return r;
            ttf_session_tell_exposure(s, asked.exposure_ns, s->locked[i][b].granted.exposure_ns);
        }
    }
    return 0;
}

static int set_up_committer(struct ttf_session *s, struct ttf_err *err)
{
    struct ttf_committer *c = &s->committer;

    if (pthread_mutex_init(&c->progress_mutex, NULL))
        return ttf_err_set(err, -ENOMEM, NULL, "out of memory");
    c->box = s->box;
    c->queue = &s->queue;
    c->events = &s->events;
    c->io = s->config->io;
    c->path = s->path;
    c->control = s->config->control;
    c->reserve_bytes = s->plan.reserve_bytes;
    c->slot_bytes = s->figures.slot_bytes;
    c->total = s->plan.count;
    c->progress = s->config->progress;
    c->progress_ctx = s->config->progress_ctx;
    if (s->config->rehearse > 0) {
        ttf_rehearsal_init(&s->rehearsal);
        c->rehearsal = &s->rehearsal;
    }
    return 0;
}

/* ---- running ---- */

static int run_slots(struct ttf_session *s)
{
    int64_t k = s->grid.first_index;
    int r = 0;

    for (; k < s->resume.lost_until && r == 0; k++) {
        /* Weeks of lost slots are many records; beats keep lamps and watchdog informed. */
        enum ttf_result result;
        const char *reason = ttf_resume_lost(&s->resume, k, &result);

        r = ttf_pulse_beat(&s->pulse, ttf_clock_now_ns(s->box->clock) + TTF_TICK_NS);
        if (r == 0)
            r = ttf_session_no_slot(s, k, result, reason);
    }
    for (; r == 0 && ttf_session_has_slot(s, k); k++)
        r = ttf_session_slot(s, k);
    return r;
}

/* The loop, with the committer beside it. */
static int run(struct ttf_session *s, struct ttf_err *err)
{
    int r;

    s->committer.ledger.next_index = s->grid.first_index;
    r = ttf_committer_begin(&s->committer);
    if (r < 0)
        return ttf_err_set(err, r, NULL, "no thread for committing");
    ttf_pulse_guard(&s->pulse);
    ttf_session_tell_beginning(s);
    ttf_pulse_led(&s->pulse, TTF_LED_CAPTURING);
    r = run_slots(s);
    if (r == -ECANCELED)
        ttf_events_emit(&s->events, "stop", "ended as asked");
    ttf_lamp_driver_end(&s->lamps);
    ttf_committer_end(&s->committer, &s->pulse);
    ttf_pulse_end(&s->pulse);
    if (r == 0 || r == -ECANCELED) {
        int fatal = ttf_queue_fatal(&s->queue);

        r = fatal < 0 ? fatal : r;
    }
    return r;
}

/* ---- the end ---- */

static int read_digest(const struct ttf_session *s, char ret[65], struct ttf_err *err)
{
    struct ttf_reader *reader;
    int r = ttf_reader_open(s->config->io, s->committer.path, &reader, err);

    if (r < 0)
        return r;
    r = ttf_reader_digest(reader, ret, err);
    ttf_reader_close(reader);
    return r;
}

/* A box without power does nothing more, whatever else went wrong with it. */
static bool power_lost(const struct ttf_session *s)
{
    return s->box->power_lost && s->box->power_lost(s->box->box_private);
}

/* Nothing more is to come: a storage that fails at this moment is given the time it has during the run. */
static int seal(struct ttf_session *s, char ret_digest[65], struct ttf_err *err)
{
    struct ttf_writer **writer = &s->committer.writer;
    struct ttf_clock *clock = s->box->clock;
    int64_t until = ttf_clock_now_ns(clock) + TTF_COMMIT_PATIENCE_NS;
    const char *reason = ttf_session_end_reason(s);
    struct ttf_writer *old;
    int r = ttf_committer_come_back(&s->committer, err);

    if (r == 0)
        r = ttf_writer_seal(*writer, reason, ret_digest, err);

    while (ttf_storage_may_pass(r) && !power_lost(s) && ttf_clock_now_ns(clock) < until) {
        (void)ttf_clock_wait_until(clock, ttf_clock_now_ns(clock) + TTF_TICK_NS);
        if (power_lost(s))
            break;
        /* After a write that failed nobody knows what is on the disk. */
        old = *writer;
        *writer = NULL;
        r = ttf_writer_open_anew(s->config->io, s->committer.path, old, &s->committer.doubt, writer,
                                 err);
        if (r == 0) /* once more even if it is seen: it may not have got there */
            r = ttf_writer_seal(*writer, reason, ret_digest, err);
    }
    return r;
}

/* A clock says that the plan's end passed while the run waited for its start: nothing to seal, and that clock may be wrong. */
static int never_began(struct ttf_session *s, struct ttf_err *err)
{
    if (s->pulse.has_segment) /* it waited in here; tried again each minute, it says so no more */
        ttf_committer_alarm(&s->committer, TTF_ALARM_UNTIL_ARMED,
                            "the plan's end has passed by this box's clock, and no slot was taken: "
                            "the dataset is not sealed; run again once the clock is right");
    ttf_err_set(err, -EINVAL, "until", "has passed by this box's clock, and no slot was taken");
    ttf_err_hint(err, "set the clock and run again, or give a plan that ends later");
    return -EINVAL;
}

static int finish_dataset(struct ttf_session *s, int r, struct ttf_session_result *ret,
                          struct ttf_err *err)
{
    struct ttf_writer *writer = s->committer.writer;
    bool complete = r == 0 && writer && s->config->rehearse <= 0 &&
                    ttf_writer_state(writer)->next_index >= s->plan.count;

    ttf_session_fill_result(s, ret);
    if (r == -ESHUTDOWN || power_lost(s)) {
        ttf_writer_abandon(writer);
        s->committer.writer = NULL;
        return -ESHUTDOWN;
    }
    if (complete && ttf_writer_state(writer)->sealed && !s->pulse.has_segment) {
        ret->sealed = true; /* it was complete before, and nothing was added */
        r = read_digest(s, ret->digest, err);
    } else if (complete && ttf_writer_state(writer)->next_index == 0) {
        r = never_began(s, err);
    } else if (complete) {
        r = seal(s, ret->digest, err);
        ret->sealed = r == 0;
        if (r < 0 && !power_lost(s))
            ttf_committer_alarm(&s->committer, TTF_ALARM_UNTIL_ARMED,
                                r == -ESTALE ? TTF_PLACE_ALARM
                                             : "the dataset cannot be sealed: all slots have their "
                                               "records; run again to seal it");
    }
    if (ttf_committer_place(&s->committer) == TTF_PLACE_SAME)
        ttf_writer_close(s->committer.writer);
    else
        ttf_writer_abandon(s->committer.writer); /* it would put right what lies there now */
    s->committer.writer = NULL;
    return r;
}

/* From armed devices to the dataset's end. */
static int armed(struct ttf_session *s, struct ttf_session_result *ret, struct ttf_err *err)
{
    int r = arm_cameras(s, err);

    if (r == 0)
        r = ttf_pulse_beat_blocking(&s->pulse);
    if (r == 0)
        r = ttf_session_open_dataset(s, err); /* s->path may be another afterwards */
    if (r == 0 && s->grid.first_index >= s->plan.count)
        return finish_dataset(s, 0, ret, err); /* nothing is left to do but to seal it */
    if (r == 0)
        r = set_up_darkrooms(s, err);
    if (r == 0)
        r = reserve_memory(s, err);
    if (r == 0)
        r = ttf_lamp_programme_init(&s->programme, &s->plan, s->box->lamps, s->run.slot0_ns, err);
    s->programme.begin_ns = s->run.slot0_ns - s->lead_ns - s->first_settle_ns;
    if (r == 0)
        r = run(s, err);
    if (r == -ECANCELED)
        r = 0;
    return finish_dataset(s, r, ret, err);
}

static bool needs_lamps(const struct ttf_session *s)
{
    return s->box->lamps && s->plan.lamps != TTF_LAMPS_NONE;
}

static int with_devices(struct ttf_session *s, struct ttf_session_result *ret, struct ttf_err *err)
{
    int64_t now = ttf_clock_now_ns(s->box->clock);
    const struct ttf_stock_size size = ttf_stock_size_of(&s->plan);
    int r = ttf_queue_init(&s->queue, s->box->clock, &size);

    if (r < 0)
        return ttf_err_set(err, r, NULL, "no memory for the slots under way: %.1f MB",
                           (double)ttf_stock_bytes(&size) / 1e6);
    s->committer.line_bytes = ttf_slot_line_bytes(
        size.n_images, size.n_shots, s->box->lamps ? ttf_lamps_count(s->box->lamps) : 0);
    s->events.queue = &s->queue;
    s->events.clock = s->box->clock;
    r = ttf_lamp_driver_begin(&s->lamps, needs_lamps(s) ? s->box->lamps : NULL, &s->events,
                              now + TTF_BLOCKING_MAX_NS, err);
    if (r == 0) {
        ttf_pulse_begin(&s->pulse, s->box, &s->queue, &s->events, &s->lamps, s->config->stop);
        s->pulse.control = s->config->control;
        r = armed(s, ret, err);
        ttf_pulse_led(&s->pulse, r < 0 ? TTF_LED_STOPPED : TTF_LED_IDLE);
    }
    if (r < 0)
        ttf_session_say_why(s, r, err);
    ttf_lamp_driver_end(&s->lamps);
    for (unsigned i = 0; i < s->n_cameras; i++)
        ttf_camera_stop(s->cameras[i].camera);
    for (unsigned i = 0; i < s->n_cameras; i++)
        ttf_darkroom_finish(&s->rooms[i]);
    ttf_pool_destroy(s->pool);
    ttf_queue_finish(&s->queue);
    return r;
}

int ttf_session_run(const struct ttf_session_config *config, struct ttf_session_result *ret,
                    struct ttf_err *err)
{
    struct ttf_session *s = calloc(1, sizeof(*s));
    int r;

    memset(ret, 0, sizeof(*ret));
    ret->moved_on_from = -1;
    if (!s)
        return ttf_err_set(err, -ENOMEM, NULL, "out of memory");
    s->config = config;
    s->box = config->box;
    s->plan = *config->plan;
    ttf_clock_join(s->box->clock);
    r = find_dataset(s, err);
    if (r == 0)
        r = ttf_session_plan_in_force(s, err);
    if (r == 0)
        r = find_yaml(s, err);
    if (r == 0)
        r = use_cameras(s, err);
    if (r == 0)
        r = prepare_plan(s, err);
    if (r == 0)
        r = load_calibration(s, err);
    if (r == 0)
        r = ttf_session_check_disk(s, err);
    if (r == 0) {
        s->lead_ns = ttf_slot_lead_ns(&s->plan, s->box);
        s->first_settle_ns = ttf_first_settle_ns(&s->plan, s->box);
        r = set_up_committer(s, err);
    }
    if (r == 0) {
        r = with_devices(s, ret, err);
        pthread_mutex_destroy(&s->committer.progress_mutex);
    }
    if (r < 0 && power_lost(s))
        r = ttf_err_set(err, -ESHUTDOWN, config->path, "the box lost power");
    if (s->has_calibration)
        ttf_calibration_free(&s->calibration);
    ttf_clock_leave(s->box->clock);
    ttf_asks_end(config->control);
    ttf_plan_change_free(s->committer.in_force);
    free(s->given_yaml);
    free(s);
    return r;
}
