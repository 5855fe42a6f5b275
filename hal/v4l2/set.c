/* SPDX-License-Identifier: Apache-2.0 */
/* set.c: which of the free-running stream's frames are those of a set. */
#include <errno.h>
#include <string.h>

#include "controls_wire.h"
#include "device.h"
#include "ttf/base/time.h"

enum verdict {
    VERDICT_NOT_OURS,
    VERDICT_TAKE,
    VERDICT_OVER /* what is left of the set was lost */
};

/* The next exposure's settings to the driver, if it has not got them; then its frames have to settle. */
static int apply(struct v4l2_camera *camera, struct ttf_err *err)
{
    struct v4l2_set *set = &camera->set;
    const struct ttf_exposure *wanted = &set->asked[set->next];
    bool anew = ttf_exposure_equal(wanted, &camera->asked);
    int r;

    if (camera->asked_any && anew)
        return 0;
    camera->asked_any = false;
    r = v4l2_controls_apply(&camera->controls, wanted);
    if (r < 0)
        return ttf_err_set(err, r == -ENODEV ? r : -EIO, camera->id.device,
                           "the driver does not take the settings: %s", v4l2_control_reason(r));
    camera->asked = *wanted;
    camera->asked_any = true;
    camera->asked_twice = anew;
    camera->held = anew && camera->held;
    camera->astray = false;
    set->placed = false;
    set->fresh_ns = ttf_clock_now_ns(camera->clock);
    if (camera->controls.mapped) {
        set->settling = true;
        set->counting = false;
    }
    return 0;
}

/* Automatics off and all the rest fixed, as on configure: what lost its exposure has lost more than that. */
static int set_up_anew(struct v4l2_camera *camera, struct ttf_err *err)
{
    struct v4l2_controls controls = camera->controls;
    int r = v4l2_controls_set_up(&controls, &camera->config, camera->base.format.width,
                                 camera->period_ns, err);

    if (r < 0)
        return r == -ENODEV ? r : -EIO;
    camera->controls = controls;
    camera->asked_any = false;
    return 0;
}

/*
 * A camera that lost its settings (a hiccup of its processor) would keep the wrong ones for the whole run: with the next
 * set it is set up anew. Not for ever where a driver makes something else of what it is asked for, and always did.
 */
static void compare(struct v4l2_camera *camera, const struct ttf_exposure *told)
{
    struct ttf_exposure meant;

    v4l2_controls_meant(&camera->controls, &camera->asked, &meant);
    if (ttf_exposure_equal(told, &meant))
        camera->held = true;
    else if (camera->held || !camera->asked_twice)
        camera->astray = true;
}

int v4l2_set_begin(struct v4l2_camera *camera, const struct ttf_camera_set *begun,
                   struct ttf_err *err)
{
    struct v4l2_set *set = &camera->set;
    int r = 0;

    if (!camera->stream.on)
        return ttf_err_set(err, camera->fd < 0 ? -ENODEV : -EIO, camera->id.device,
                           "the camera has not come back");
    memcpy(set->asked, begun->settings, begun->n * sizeof(*set->asked));
    set->n = begun->n;
    set->next = 0;
    set->middle_ns = begun->middle_ns;
    set->placed = set->watched = set->starved = set->lost = false;
    set->fresh_ns = ttf_clock_now_ns(camera->clock);
    if (camera->astray)
        r = set_up_anew(camera, err);
    if (r == 0)
        r = apply(camera, err);
    if (r < 0)
        set->n = 0;
    return r;
}

/* `lost` frames of the set went by. Not ours, too, is a frame that has the settings of those before. */
static enum verdict pass_over(struct v4l2_camera *camera, uint32_t lost)
{
    struct v4l2_set *set = &camera->set;

    for (; lost > 0 && set->next < set->n; lost--) {
        set->next++;
        set->lost = true;
        if (set->next < set->n && !ttf_exposure_equal(&set->asked[set->next], &camera->asked)) {
            set->placed = false;
            return VERDICT_NOT_OURS;
        }
    }
    return set->next < set->n ? VERDICT_TAKE : VERDICT_OVER;
}

/* Whether settings that were changed show in this frame. */
static bool settled(struct v4l2_camera *camera, const struct v4l2_arrival *arrival, int64_t end_ns)
{
    struct v4l2_set *set = &camera->set;

    if (!set->settling)
        return true;
    if (!set->counting) {
        if (end_ns < set->fresh_ns)
            return false;
        set->counting = true;
        /* Where nothing is set there is only the stream's first frame to be passed over. */
        set->settled_at =
            arrival->sequence + (camera->controls.mapped ? camera->config.settle_frames : 1);
    }
    if ((int32_t)(arrival->sequence - set->settled_at) < 0)
        return false;
    set->settling = false;
    return true;
}

/* The frame nearest to the middle wanted begins the set. */
static enum verdict place(struct v4l2_camera *camera, const struct v4l2_arrival *arrival,
                          int64_t middle_ns, int64_t exposure_ns)
{
    struct v4l2_set *set = &camera->set;
    int64_t each = exposure_ns > camera->period_ns ? exposure_ns : camera->period_ns;
    int64_t late = middle_ns - (set->middle_ns - each / 2);

    if (late < 0 || each <= 0) {
        set->watched = true;
        v4l2_steer_look(camera, arrival->sequence, middle_ns);
        return VERDICT_NOT_OURS;
    }
    /* It comes later than the one that was wanted, and frames in between are missing: it was lost. */
    if (set->watched && !set->starved && arrival->lost > 0 && late > each + each / 4) {
        int64_t missed = late / each;

        return pass_over(camera,
                         missed < arrival->lost ? (uint32_t)missed : (uint32_t)arrival->lost);
    }
    return VERDICT_TAKE;
}

static enum verdict judge(struct v4l2_camera *camera, const struct v4l2_arrival *arrival,
                          int64_t *ret_start, int64_t *ret_end)
{
    struct v4l2_set *set = &camera->set;
    int64_t exposure = camera->controls.exposure.id ? camera->asked.exposure_ns : 0;

    v4l2_arrival_span(camera, arrival, exposure, ret_start, ret_end);
    if (!settled(camera, arrival, *ret_end) || *ret_start < set->fresh_ns)
        return VERDICT_NOT_OURS;
    if (set->placed && !set->starved)
        return pass_over(camera, arrival->sequence - set->expected);
    if (set->next == 0 && set->middle_ns != 0 && !set->placed)
        return place(camera, arrival, *ret_start + (*ret_end - *ret_start) / 2, exposure);
    return VERDICT_TAKE;
}

static void describe(struct v4l2_camera *camera, const struct v4l2_arrival *arrival,
                     int64_t start_ns, int64_t end_ns, const struct ttf_exposure *settings)
{
    struct v4l2_slot *slot = &camera->stream.slot[arrival->index];
    uint32_t flags = 0;

    if (arrival->error)
        flags |= TTF_FRAME_ERROR;
    if (arrival->bytes < camera->frame_bytes)
        flags |= TTF_FRAME_SHORT;
    if (camera->set.lost)
        flags |= TTF_FRAME_SEQUENCE_GAP;
    if (arrival->stamp == V4L2_STAMP_NONE)
        flags |= TTF_FRAME_NO_SENSOR_TIME;
    slot->frame = (struct ttf_frame){
        .format = camera->base.format,
        .data = slot->at,
        .bytes = arrival->bytes,
        .start_ns = start_ns,
        .end_ns = end_ns,
        .sequence = arrival->sequence,
        .flags = flags,
        .settings = *settings,
        .set_index = camera->set.next,
        .backend = slot,
    };
}

/* Into the caller's hands, with what the driver says of it now; and on to the next. */
static int deliver(struct v4l2_camera *camera, const struct v4l2_arrival *arrival, int64_t start_ns,
                   int64_t end_ns, struct ttf_frame **ret_frame, struct ttf_err *err)
{
    struct v4l2_set *set = &camera->set;
    struct ttf_exposure settings = {0};
    struct v4l2_arrival taken = *arrival;
    int r = v4l2_controls_read(&camera->controls, &settings);

    if (r == -ENODEV)
        return ttf_err_set(err, r, camera->id.device, "the camera is gone");
    if (r < 0)
        taken.error = true; /* what it was taken with cannot be told */
    else
        compare(camera, &settings);
    v4l2_steer_rest(camera);
    describe(camera, &taken, start_ns, end_ns, &settings);
    *ret_frame = v4l2_stream_hold(camera, arrival->index);
    set->next++;
    set->lost = set->starved = false;
    set->placed = true;
    set->expected = arrival->sequence + 1;
    if (set->next < set->n)
        (void)apply(camera,
                    NULL); /* the earlier the better; if it fails, next tries again and says so */
    return 0;
}

int v4l2_set_next(struct v4l2_camera *camera, int64_t deadline_ns, struct ttf_frame **ret_frame,
                  struct ttf_err *err)
{
    struct v4l2_set *set = &camera->set;
    struct v4l2_arrival arrival = {0};
    int64_t start_ns = 0, end_ns = 0;
    enum verdict verdict;
    int r;

    if (!camera->stream.on)
        return ttf_err_set(err, camera->fd < 0 ? -ENODEV : -EIO, camera->id.device,
                           "the camera has not come back");
    for (;;) {
        r = v4l2_stream_await_room(camera, deadline_ns);
        if (r < 0)
            return ttf_err_set(err, r, camera->id.device, "no frame was given back in time");
        set->starved |= r > 0;
        r = apply(camera, err);
        if (r == 0)
            r = v4l2_stream_take(camera, deadline_ns, &arrival, err);
        if (r < 0)
            return r;
        if (camera->stream.slept) { /* the frames of before the sleep are dated wrongly now */
            camera->stream.slept = false;
            set->starved = true;
            set->fresh_ns = arrival.came_ns;
        }
        verdict = judge(camera, &arrival, &start_ns, &end_ns);
        r = verdict == VERDICT_TAKE ? deliver(camera, &arrival, start_ns, end_ns, ret_frame, err)
                                    : v4l2_stream_give(camera, arrival.index, err);
        if (r < 0 || verdict == VERDICT_TAKE)
            return r;
        if (verdict == VERDICT_OVER)
            return ttf_err_set(err, -ENODATA, camera->id.device, "the rest of the set was lost");
    }
}
