/* SPDX-License-Identifier: Apache-2.0 */
/*
 * steer.c: the free-running stream's frames moved in time, so that the middle of one meets the instant that a set
 * asks for: a few frames of another duration, then the usual one again.
 */
#include <errno.h>
#include <string.h>

#include "controls_wire.h"
#include "device.h"
#include "ttf/base/time.h"

#define CLOSE_SHARE    16 /* a frame this part of a period off its instant is left where it is */
#define LATENCY_FRAMES 4  /* until a changed duration shows, at most */
#define FRAMES_MAX     4  /* of another duration, one after another */

/* What a steered set needs ahead of its instant, beyond what any does: looked, moved, settled, looked again. */
#define LEAD_FRAMES (1 + FRAMES_MAX + LATENCY_FRAMES)

void v4l2_steer_set_up(struct v4l2_camera *camera)
{
    struct v4l2_steer *steer = &camera->steer;
    struct v4l2_controls *c = &camera->controls;
    struct v4l2_query_ext_ctrl q;
    int64_t blank = 0, line_ns = v4l2_controls_line_ns(c, camera->base.format.width);

    memset(steer, 0, sizeof(*steer));
    if (!camera->config.steer)
        return;
    if (line_ns > 0 && v4l2_control_query(c, V4L2_CID_VBLANK, &q) == 0 &&
        !(q.flags & V4L2_CTRL_FLAG_READ_ONLY) &&
        v4l2_control_get(c, V4L2_CID_VBLANK, &blank) == 0) {
        steer->by = V4L2_STEER_BLANK;
        steer->line_ns = line_ns;
        steer->blank = blank;
        steer->blank_max = q.maximum;
    } else if (camera->rate_settable && strcmp(camera->id.driver, "uvcvideo") != 0) {
        /* That one refuses another rate while it streams; others say so when they are asked. */
        steer->by = V4L2_STEER_RATE;
    }
}

int64_t v4l2_steer_lead_ns(const struct v4l2_camera *camera)
{
    return camera->steer.by == V4L2_STEER_NONE ? 0 : LEAD_FRAMES * camera->period_ns;
}

static int ask_blank(struct v4l2_camera *camera, int64_t period_ns, int64_t *ret_granted_ns)
{
    const struct v4l2_steer *steer = &camera->steer;
    int64_t lines = (period_ns - camera->period_ns + steer->line_ns / 2) / steer->line_ns;
    int64_t blank = steer->blank + lines;
    int r;

    if (blank > steer->blank_max)
        blank = steer->blank_max;
    r = v4l2_control_set(&camera->controls, V4L2_CID_VBLANK, blank);
    *ret_granted_ns = camera->period_ns + (blank - steer->blank) * steer->line_ns;
    return r;
}

static int ask_rate(struct v4l2_camera *camera, int64_t period_ns, int64_t *ret_granted_ns)
{
    struct v4l2_streamparm parm = {.type = V4L2_BUF_TYPE_VIDEO_CAPTURE};
    struct v4l2_fract *per = &parm.parm.capture.timeperframe;
    int r;

    per->numerator = (uint32_t)(period_ns / 100);
    per->denominator = 10 * 1000 * 1000;
    r = v4l2_ioctl(camera, VIDIOC_S_PARM, &parm);
    if (r == 0 && per->denominator == 0)
        r = -EINVAL;
    if (r == 0)
        *ret_granted_ns = (int64_t)((double)per->numerator * 1e9 / per->denominator + 0.5);
    return r;
}

/* A driver that refuses is not asked again. */
static int ask(struct v4l2_camera *camera, int64_t period_ns, int64_t *ret_granted_ns)
{
    struct v4l2_steer *steer = &camera->steer;
    int r = steer->by == V4L2_STEER_BLANK ? ask_blank(camera, period_ns, ret_granted_ns)
                                          : ask_rate(camera, period_ns, ret_granted_ns);

    if (r < 0)
        steer->by = V4L2_STEER_NONE;
    return r;
}

void v4l2_steer_rest(struct v4l2_camera *camera)
{
    struct v4l2_steer *steer = &camera->steer;
    int64_t granted_ns;
    int r;

    if (!steer->moving)
        return;
    steer->moving = false;
    r = steer->by == V4L2_STEER_NONE ? 0 : ask(camera, camera->period_ns, &granted_ns);
    (void)r; /* a stream that goes on at another rate is one whose frames are dated as they come */
}

/* How far a frame is from the instant, whichever side. */
static int64_t off_ns(int64_t ahead_ns, int64_t period_ns)
{
    int64_t rest = ((ahead_ns % period_ns) + period_ns) % period_ns;

    return rest < period_ns - rest ? rest : period_ns - rest;
}

struct move {
    unsigned frames;
    int64_t period_ns; /* granted */
    int64_t off_ns;    /* left over */
};

/* Asks for `frames` frames of this duration; kept if it leaves less over than the best before. */
static int try(struct v4l2_camera *camera, int64_t period_ns, unsigned frames, int64_t ahead_ns,
               struct move *best)
{
    struct move move = {.frames = frames};
    int r = ask(camera, period_ns, &move.period_ns);

    if (r < 0)
        return r;
    move.off_ns =
        off_ns(ahead_ns - frames * (move.period_ns - camera->period_ns), camera->period_ns);
    if (move.off_ns < best->off_ns)
        *best = move;
    return 0;
}

/* A driver that took one duration and refuses another is not left with the first. */
static void restore(struct v4l2_camera *camera, enum v4l2_steer_by by)
{
    int64_t granted_ns;

    camera->steer.by = by;
    (void)ask(camera, camera->period_ns, &granted_ns);
    camera->steer.by = V4L2_STEER_NONE;
}

/* Drivers know some durations and not others: longer frames or, where no exposure may be cut by them, shorter ones. */
static int choose(struct v4l2_camera *camera, int64_t ahead_ns, struct move *best)
{
    int64_t period_ns = camera->period_ns, later_ns = ahead_ns % period_ns, granted_ns;
    int64_t close_ns = period_ns / CLOSE_SHARE, shorter_ns;
    enum v4l2_steer_by by = camera->steer.by;
    bool may_shorten = !camera->controls.exposure.id && by == V4L2_STEER_RATE, taken = false;
    int r = 0;

    for (unsigned k = 1; k <= FRAMES_MAX && r == 0 && best->off_ns > close_ns; k++) {
        r = try(camera, period_ns + later_ns / k, k, ahead_ns, best);
        taken |= r == 0;
        shorter_ns = period_ns - (period_ns - later_ns) / k;
        if (r == 0 && may_shorten && best->off_ns > close_ns && shorter_ns > period_ns / 2)
            r = try(camera, shorter_ns, k, ahead_ns, best);
    }
    if (r == 0)
        r = ask(camera, best->frames > 0 ? best->period_ns : period_ns, &granted_ns);
    if (r < 0 && taken)
        restore(camera, by);
    return r;
}

void v4l2_steer_look(struct v4l2_camera *camera, uint32_t sequence, int64_t middle_ns)
{
    struct v4l2_steer *steer = &camera->steer;
    int64_t ahead_ns = camera->set.middle_ns - middle_ns;
    struct move best = {.off_ns = off_ns(ahead_ns, camera->period_ns)};

    if (steer->by == V4L2_STEER_NONE)
        return;
    if (steer->moving) {
        if ((int32_t)(sequence - steer->moved_at) < 0)
            return;
        v4l2_steer_rest(camera);
        steer->settling = true;
        steer->settled_at = sequence + LATENCY_FRAMES;
        return;
    }
    if (steer->settling && (int32_t)(sequence - steer->settled_at) < 0)
        return;
    steer->settling = false;
    if (best.off_ns <= camera->period_ns / CLOSE_SHARE ||
        ahead_ns < (FRAMES_MAX + LATENCY_FRAMES) * camera->period_ns ||
        choose(camera, ahead_ns, &best) < 0 || best.frames == 0)
        return;
    steer->moving = true;
    steer->moved_at = sequence + best.frames;
}
