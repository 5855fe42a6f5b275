/* SPDX-License-Identifier: Apache-2.0 */
#include "shoot.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

#include "exposure.h"
#include "frame_check.h"
#include "ledger.h"

/* How long after its last exposure should have ended a set is waited for. */
#define DELIVERY_SLACK_NS (500 * TTF_NS_PER_MS)

/* What a frame may be off the middle asked for, beyond the camera's own bound, before it is flagged. */
#define LATE_SLACK_NS TTF_NS_PER_MS

#define LOCK_ROUNDS 4

/* So often on end the procedure must come to the same settings; so often it is tried. */
#define LOCK_ALIKE 5
#define LOCK_TRIES 12

/* Of the first grant: how far the later ones may be from it. */
#define LOCK_WANDER_SHARE 20

/* What came of one submitted set. */
struct attempt {
    unsigned delivered;  /* buffers of any kind */
    const char *refused; /* the last reason */
    int error;           /* of the camera: -EIO, -ENODEV, -ETIMEDOUT, ...; 0 */
};

static bool ends_run(const struct ttf_shooter *shooter, int r)
{
    return r == -ESHUTDOWN || r == -ENOMEM ||
           (r < 0 && r == ttf_queue_fatal(shooter->pulse->queue));
}

/* The next place in the record. The last is never needed twice: there is one for each exposure that can be. */
static struct ttf_shot *new_shot(struct ttf_take *take)
{
    struct ttf_image *image = take->image;
    struct ttf_shot *shot;

    if (image->n_shots < take->shots_room)
        image->n_shots++;
    shot = &image->shots[image->n_shots - 1];
    memset(shot, 0, sizeof(*shot));
    shot->asked = take->locked->asked;
    shot->start_ns = TTF_NS_UNKNOWN;
    shot->end_ns = TTF_NS_UNKNOWN;
    return shot;
}

static void note_missing(struct ttf_take *take, unsigned n)
{
    while (n-- > 0) {
        struct ttf_shot *shot = new_shot(take);

        snprintf(shot->refused, sizeof(shot->refused), "%s", TTF_REFUSED_MISSING);
    }
}

static void accept_frame(struct ttf_shooter *shooter, struct ttf_take *take,
                         const struct ttf_frame *frame)
{
    int64_t middle = frame->start_ns + (frame->end_ns - frame->start_ns) / 2;
    int64_t off = middle - take->middle_ns;
    int64_t bound = ttf_camera_caps(shooter->camera)->timing_bound_ns + LATE_SLACK_NS;

    if (take->start_ns != TTF_NS_UNKNOWN)
        return;
    take->start_ns = frame->start_ns;
    take->middle_got_ns = middle;
    if (take->middle_ns != 0 && (off > bound || off < -bound)) {
        ttf_image_flag(take->image, "late");
        take->trouble = true;
    }
}

static void note_lamps(struct ttf_shooter *shooter, struct ttf_take *take, struct ttf_shot *shot)
{
    unsigned marks = ttf_lamp_driver_sample(shooter->pulse->lamps, take->settle_ns, shot);
    /* Looked at anew: since the last beat it may have been opened, and closed again. */
    bool door = ttf_pulse_door_was_open(shooter->pulse, shot->start_ns, shot->end_ns);

    if (marks & TTF_LAMP_MARK_TRIPPED)
        ttf_image_flag(take->image, "lamp-tripped");
    if (marks & TTF_LAMP_MARK_LEVEL)
        ttf_image_flag(take->image, "lamp-level");
    if (marks & TTF_LAMP_MARK_UNSETTLED)
        ttf_image_flag(take->image, "lamp-unsettled");
    if (marks & TTF_LAMP_MARK_UNKNOWN)
        ttf_image_flag(take->image, "lamp-unknown");
    if (door)
        ttf_image_flag(take->image, "door-open");
    if (marks || door)
        take->trouble = true;
}

/*
 * Judges a frame and adds it up if it is good. On the last try a frame whose only
 * fault is its settings is better than none, as long as the sum stays of one kind.
 * Why it was refused, or NULL.
 */
static const char *judge_frame(struct ttf_shooter *shooter, struct ttf_take *take,
                               const struct ttf_frame *frame, bool last_try)
{
    struct ttf_shot *shot = new_shot(take);
    const char *refused = ttf_frame_refused(frame, &shooter->format, &take->locked->granted);

    shot->granted = frame->settings;
    shot->start_ns = frame->start_ns;
    shot->end_ns = frame->end_ns;
    note_lamps(shooter, take, shot);
    if (refused && last_try && strcmp(refused, TTF_REFUSED_SETTINGS) == 0 &&
        (take->raw->n == 0 || ttf_exposure_equal(&take->raw->settings, &frame->settings))) {
        ttf_image_flag(take->image, "wrong-settings");
        refused = NULL;
    }
    if (!refused) {
        if (ttf_raw_sum_add(take->raw, frame) < 0)
            refused = TTF_REFUSED_FORMAT;
        else
            accept_frame(shooter, take, frame);
    }
    if (refused)
        snprintf(shot->refused, sizeof(shot->refused), "%s", refused);
    return refused;
}

static int64_t delivery_deadline(const struct ttf_shooter *shooter, int64_t middle_ns,
                                 int64_t exposure_ns, unsigned n)
{
    const struct ttf_camera_caps *caps = ttf_camera_caps(shooter->camera);
    int64_t now = ttf_clock_now_ns(shooter->pulse->box->clock);
    int64_t first = now + ttf_exposure_lead_ns(caps, exposure_ns);

    if (middle_ns > first)
        first = middle_ns;
    return first + ttf_exposures_span_ns(caps, exposure_ns, n) + DELIVERY_SLACK_NS;
}

/* Submits n equal exposures. */
static int submit(struct ttf_shooter *shooter, const struct ttf_exposure *asked, unsigned n,
                  int64_t middle_ns)
{
    struct ttf_exposure settings[TTF_CAMERA_SET_MAX];
    struct ttf_camera_set set = {.settings = settings, .n = n, .middle_ns = middle_ns};

    for (unsigned i = 0; i < n; i++)
        settings[i] = *asked;
    return ttf_camera_submit(shooter->camera, &set, &shooter->said);
}

/* One set of n exposures. 0 and *ret; negative only for what ends the run. */
static int attempt(struct ttf_shooter *shooter, struct ttf_take *take, unsigned n, bool last_try,
                   struct attempt *ret)
{
    int64_t exposure = take->locked->granted.exposure_ns;
    int64_t deadline = delivery_deadline(shooter, take->middle_ns, exposure, n);
    struct attempt a = {0};
    int r = submit(shooter, &take->locked->asked, n, take->middle_ns);

    if (r < 0) {
        a.error = r;
        a.refused = TTF_REFUSED_MISSING;
        *ret = a;
        return 0;
    }
    while (a.delivered < n) {
        struct ttf_frame *frame = NULL;
        const char *refused;

        r = ttf_pulse_next(shooter->pulse, shooter->camera, deadline, &frame, &shooter->said);
        if (r < 0)
            break;
        a.delivered++;
        refused = judge_frame(shooter, take, frame, last_try);
        ttf_camera_release(shooter->camera, frame);
        if (refused)
            a.refused = refused;
    }
    if (r < 0 && ends_run(shooter, r))
        return r;
    if (a.delivered < n) {
        ttf_camera_cancel(shooter->camera);
        a.refused = TTF_REFUSED_MISSING;
        a.error = r;
        note_missing(take, n - a.delivered);
    }
    *ret = a;
    return 0;
}

static bool gone(const struct attempt *a)
{
    return a->delivered == 0 && a->error < 0;
}

static bool time_left(const struct ttf_shooter *shooter, const struct ttf_take *take)
{
    return ttf_clock_now_ns(shooter->pulse->box->clock) < take->give_up_ns;
}

/* One step of the ladder. 0: the camera says it streams again; 1: it does not; negative: end of the run. */
static int climb(struct ttf_shooter *shooter)
{
    enum ttf_camera_recovery step = shooter->next_step;
    struct ttf_err err = {0};
    int r = ttf_pulse_beat_blocking(shooter->pulse);

    if (r < 0)
        return r;
    shooter->recoveries++;
    if (shooter->next_step < TTF_CAMERA_REOPEN)
        shooter->next_step++;
    r = ttf_camera_recover(shooter->camera, step, &err);
    ttf_events_emit(shooter->events, "camera", "%s delivers nothing: %s%s%s", shooter->name,
                    ttf_camera_recovery_name(step), r < 0 ? " failed: " : "",
                    r < 0 ? err.what : "");
    if (r < 0)
        shooter->said = err;
    return r < 0 ? 1 : 0;
}

/* The ladder, from where the last slot left it. As attempt. */
static int ladder(struct ttf_shooter *shooter, struct ttf_take *take, struct attempt *a)
{
    bool top = false;

    while (gone(a) && !top && time_left(shooter, take)) {
        int r;

        top = shooter->next_step == TTF_CAMERA_REOPEN;
        r = climb(shooter);
        if (r < 0)
            return r;
        if (r > 0)
            continue;
        r = attempt(shooter, take, take->average - take->raw->n, true, a);
        if (r < 0)
            return r;
    }
    return 0;
}

/* before: frames that were in the sum already. */
static void conclude(struct ttf_shooter *shooter, struct ttf_take *take, unsigned before,
                     const struct attempt *a)
{
    struct ttf_image *image = take->image;

    shooter->revived = false;
    image->n_averaged = take->raw->n;
    if (take->raw->n > before) {
        if (take->raw->n < take->average) {
            ttf_image_flag(image, "short-average");
            take->trouble = true;
        }
        if (shooter->down || shooter->next_step != TTF_CAMERA_REQUEUE)
            ttf_events_emit(shooter->events, "camera", "%s delivers again", shooter->name);
        shooter->down = false;
        shooter->next_step = TTF_CAMERA_REQUEUE;
        return;
    }
    take->trouble = true;
    shooter->down = gone(a);
    snprintf(image->lacking, sizeof(image->lacking), "%s",
             shooter->down ? TTF_REASON_NO_CAMERA
             : a->refused  ? a->refused
                           : TTF_REASON_NO_TIME);
    ttf_events_emit(shooter->events, "camera", "%s: image of %s given up: %s", shooter->name,
                    image->stream, image->lacking);
}

int ttf_shoot(struct ttf_shooter *shooter, struct ttf_take *take)
{
    unsigned before = take->raw->n;
    struct attempt a;
    int r;

    take->start_ns = TTF_NS_UNKNOWN;
    take->middle_got_ns = TTF_NS_UNKNOWN;
    r = attempt(shooter, take, take->average - before, false, &a);
    if (r < 0)
        return r;
    if (take->raw->n < take->average && a.error != -ENODEV && a.error != -EIO &&
        a.error != -EPIPE && time_left(shooter, take)) {
        take->trouble = true;
        ttf_events_emit(shooter->events, "retry", "%s: %u of %u frames of %s taken again: %s",
                        shooter->name, take->average - take->raw->n, take->average,
                        take->image->stream, a.refused);
        r = attempt(shooter, take, take->average - take->raw->n, true, &a);
        if (r < 0)
            return r;
    }
    if (take->raw->n == before && gone(&a)) {
        r = ladder(shooter, take, &a);
        if (r < 0)
            return r;
    }
    conclude(shooter, take, before, &a);
    return 0;
}

int ttf_shooter_revive(struct ttf_shooter *shooter)
{
    int r;

    /* Once is enough: where a step takes longer than is left between slots, none would ever come to its turn. */
    if (!shooter->down || shooter->revived)
        return 0;
    r = climb(shooter);
    shooter->revived = r == 0;
    return r < 0 ? r : 0;
}

/* ---- locking ---- */

/* One frame at these settings, to see what the driver makes of them. */
static int probe(struct ttf_shooter *shooter, const struct ttf_exposure *asked,
                 struct ttf_exposure *ret_granted)
{
    int64_t deadline = delivery_deadline(shooter, 0, asked->exposure_ns, 1);
    struct ttf_frame *frame = NULL;
    int r = submit(shooter, asked, 1, 0);

    if (r < 0)
        return r;
    r = ttf_pulse_next(shooter->pulse, shooter->camera, deadline, &frame, &shooter->said);
    if (r < 0) {
        ttf_camera_cancel(shooter->camera);
        return r;
    }
    r = frame->flags & TTF_FRAME_ERROR ? -EAGAIN : 0;
    if (r == 0)
        *ret_granted = frame->settings;
    ttf_camera_release(shooter->camera, frame);
    return r;
}

/* The same, with the ladder behind it. */
static int probe_hard(struct ttf_shooter *shooter, const struct ttf_exposure *asked,
                      struct ttf_exposure *ret_granted)
{
    int r = probe(shooter, asked, ret_granted);

    for (int again = 0; r < 0 && again < 2 && !ends_run(shooter, r); again++)
        r = probe(shooter, asked, ret_granted);
    while (r < 0 && !ends_run(shooter, r)) {
        bool top = shooter->next_step == TTF_CAMERA_REOPEN;
        int c = climb(shooter);

        if (c < 0)
            return c;
        r = probe(shooter, asked, ret_granted);
        if (top && r < 0 && !ends_run(shooter, r))
            return -ENODEV;
    }
    if (r == 0)
        shooter->next_step = TTF_CAMERA_REQUEUE;
    return r;
}

/* Asks for what was granted until both agree. */
static int converge(struct ttf_shooter *shooter, const struct ttf_exposure *asked,
                    struct ttf_locked *ret)
{
    int64_t first_ns = 0;

    ret->asked = *asked;
    for (int round = 0; round < LOCK_ROUNDS; round++) {
        int r = probe_hard(shooter, &ret->asked, &ret->granted);
        int64_t off_ns;

        if (r < 0)
            return r;
        if (round == 0)
            first_ns = ret->granted.exposure_ns;
        /* What was rounded is rounded no further: a grant that wanders off is none. */
        off_ns = ret->granted.exposure_ns - first_ns;
        if (off_ns > first_ns / LOCK_WANDER_SHARE || -off_ns > first_ns / LOCK_WANDER_SHARE)
            return -EIO;
        if (ttf_exposure_equal(&ret->asked, &ret->granted))
            return 0;
        ret->asked = ret->granted;
    }
    return -EIO;
}

/* Just what was asked for; a control that the camera lacks is read back 0, whatever was asked of it. */
static bool granted_as_asked(const struct ttf_shooter *shooter, const struct ttf_exposure *asked,
                             const struct ttf_exposure *granted)
{
    const struct ttf_camera_caps *caps = ttf_camera_caps(shooter->camera);
    struct ttf_exposure possible = *asked;

    if (caps->exposure_max_ns == 0)
        possible.exposure_ns = 0;
    if (caps->gain_max_milli == 0)
        possible.gain_milli = 0;
    if (!caps->has_white_balance)
        possible.wb_r_milli = possible.wb_b_milli = 0;
    if (!caps->has_lens)
        possible.lens_mdpt = 0;
    return ttf_exposure_equal(&possible, granted);
}

/*
 * A driver rounds, and does so each time alike; a frame whose settings went wrong is
 * another matter: what it carried must not become the setting of the whole run. No such
 * frame comes out just as asked for, so what does is right the first time. Anything else
 * counts only if it comes out alike several times.
 */
static int lock_steady(struct ttf_shooter *shooter, const struct ttf_exposure *asked,
                       struct ttf_locked *ret)
{
    struct ttf_exposure before = {0};
    int alike = 0;

    for (int try = 0; try < LOCK_TRIES && alike < LOCK_ALIKE; try++) {
        int r = converge(shooter, asked, ret);

        if (r < 0 && (r != -EIO || ends_run(shooter, r)))
            return r;
        if (r == 0 && granted_as_asked(shooter, asked, &ret->granted))
            return 0;
        alike = r < 0 ? 0 : ttf_exposure_equal(&before, &ret->granted) ? alike + 1 : 1;
        before = ret->granted;
    }
    return alike < LOCK_ALIKE ? -EIO : 0;
}

int ttf_shooter_lock(struct ttf_shooter *shooter, const struct ttf_exposure *asked,
                     struct ttf_locked *ret, struct ttf_err *err)
{
    struct ttf_locked locked = {.asked = *asked};
    int r = lock_steady(shooter, asked, &locked);

    if (r == 0)
        *ret = locked;
    else if (r == -ENODEV)
        return ttf_err_set(err, r, shooter->name,
                           "the camera gives no frame, also after it was opened anew%s%s",
                           shooter->said.what[0] ? ": " : "", shooter->said.what);
    else if (r == -EIO && !ends_run(shooter, r))
        return ttf_err_set(err, r, shooter->name,
                           "the camera grants other settings than it was asked for, each time anew "
                           "(%.3f ms, gain %.3f)",
                           (double)locked.granted.exposure_ns / 1e6,
                           locked.granted.gain_milli / 1e3);
    else
        return ttf_err_set(err, r, shooter->name, "the exposure could not be locked");
    return 0;
}
