/* SPDX-License-Identifier: Apache-2.0 */
/* trial.c: what a camera does, looked at before a run, since what libcamera lists is no promise. */
#include <errno.h>
#include <math.h>
#include <stdlib.h>

#include "device.h"
#include "ttf/base/time.h"

#define FRAMES_MAX  64                  /* until settings have settled */
#define PATIENCE_NS (10 * TTF_NS_PER_S) /* for a frame, and for what is no waiting for frames */
#define EXPOSURE_NS (10 * TTF_NS_PER_MS)
#define INTERVALS   8

/* What was seen of frames that came one after another. */
struct seen {
    uint32_t told; /* bit c: some frame told it */
    int64_t last_ns;
    bool any;
    int64_t interval_ns[INTERVALS]; /* the last ones */
    unsigned n;
    struct lc_arrival last;
};

static struct ttf_exposure modest(const struct lc_camera *camera)
{
    const struct lc_limits *l = &camera->can.limits;
    struct ttf_exposure e = {
        .exposure_ns = EXPOSURE_NS, .gain_milli = 1000, .wb_r_milli = 1000, .wb_b_milli = 1000};

    if (l->has & 1u << LC_EXPOSURE) {
        e.exposure_ns = e.exposure_ns < llround(l->min[LC_EXPOSURE] * 1e3)
                            ? llround(l->min[LC_EXPOSURE] * 1e3)
                            : e.exposure_ns;
        e.exposure_ns = e.exposure_ns > llround(l->max[LC_EXPOSURE] * 1e3)
                            ? llround(l->max[LC_EXPOSURE] * 1e3)
                            : e.exposure_ns;
    }
    if (l->has & 1u << LC_GAIN && e.gain_milli < l->min[LC_GAIN] * 1e3)
        e.gain_milli = (uint32_t)lround(l->min[LC_GAIN] * 1e3);
    if (l->has & 1u << LC_LENS)
        e.lens_mdpt = (uint32_t)lround(fmax(l->min[LC_LENS], 0) * 1e3);
    return e;
}

/* Of the frames as they are asked for; one that is not asked may be slow all the same. */
static int64_t frame_ns(const struct lc_camera *camera)
{
    int64_t asked = camera->config.frame_period_ns, base = camera->stream.steer.base_ns;

    return asked > base ? asked : base;
}

/* A frame is long overdue after this, however slow they are. */
static int64_t patience_ns(const struct lc_camera *camera)
{
    int64_t frames = 4 * frame_ns(camera);

    return frames > PATIENCE_NS ? frames : PATIENCE_NS;
}

static int look(struct lc_camera *camera, int64_t deadline_ns, struct seen *seen,
                struct ttf_err *err)
{
    struct lc_arrival *a = &seen->last;
    int64_t overdue_ns = ttf_clock_now_ns(camera->clock) + patience_ns(camera);
    int r = lc_stream_take(camera, overdue_ns < deadline_ns ? overdue_ns : deadline_ns, a, err);

    if (r == -ETIMEDOUT)
        return ttf_err_set(err, -EIO, camera->id.id, "the camera gives no frames");
    if (r < 0)
        return r;
    seen->told |= a->told.set;
    if (a->stamped || a->came_ns > 0) {
        int64_t at = a->stamped ? a->stamp_ns : a->came_ns;

        if (seen->any && a->lost == 0 && at > seen->last_ns)
            seen->interval_ns[seen->n++ % INTERVALS] = at - seen->last_ns;
        seen->last_ns = at;
        seen->any = true;
    }
    return 0;
}

static int by_length(const void *a, const void *b)
{
    int64_t x = *(const int64_t *)a, y = *(const int64_t *)b;

    return x < y ? -1 : x > y;
}

static int64_t median(const struct seen *seen, unsigned of_last)
{
    int64_t sorted[INTERVALS];
    unsigned n = seen->n < of_last ? seen->n : of_last;

    for (unsigned i = 0; i < n; i++)
        sorted[i] = seen->interval_ns[(seen->n - 1 - i) % INTERVALS];
    qsort(sorted, n, sizeof(*sorted), by_length);
    return n ? sorted[n / 2] : 0;
}

static int64_t longest(const struct seen *seen)
{
    int64_t found = 0;

    for (unsigned i = 0; i < INTERVALS && i < seen->n; i++)
        found = seen->interval_ns[i] > found ? seen->interval_ns[i] : found;
    return found;
}

/* Beyond a period it is the machine that was busy, or a camera whose frames no bound holds. */
static int64_t unevenness(const struct seen *seen, int64_t period_ns)
{
    int64_t found = longest(seen) - period_ns;

    return found < period_ns ? found : period_ns;
}

/* So many frames, passed on. */
static int watch(struct lc_camera *camera, unsigned frames, int64_t deadline_ns, struct seen *seen,
                 struct ttf_err *err)
{
    for (unsigned i = 0; i < frames; i++) {
        int r = look(camera, deadline_ns, seen, err);

        if (r == 0)
            r = lc_stream_give(camera, seen->last.index, err);
        if (r < 0)
            return r;
    }
    return 0;
}

/* Controls of which nothing is told. */
static int believe(struct lc_camera *camera, uint32_t told, struct ttf_err *err)
{
    struct lc_abilities *can = &camera->can;

    if ((can->mapped & TTF_LIBCAMERA_EXPOSURE) && !(told & 1u << LC_EXPOSURE)) {
        ttf_err_set(err, -ENOTSUP, camera->id.id,
                    "the camera takes an exposure time and does not tell what it made of it");
        ttf_err_hint(err, "if it is a USB camera, use back-end v4l2");
        return -ENOTSUP;
    }
    if ((can->mapped & TTF_LIBCAMERA_GAIN) && !(told & 1u << LC_GAIN))
        lc_controls_unmap(can, TTF_LIBCAMERA_GAIN);
    if ((can->mapped & TTF_LIBCAMERA_BALANCE) && !(told & 1u << LC_COLOUR_GAINS))
        lc_controls_unmap(can, TTF_LIBCAMERA_BALANCE);
    can->lens_told = told & 1u << LC_LENS;
    return 0;
}

static int refuse_restless(struct lc_camera *camera, const struct ttf_exposure *told,
                           const struct ttf_exposure *asked, struct ttf_err *err)
{
    return ttf_err_set(err, -ENOTSUP, camera->id.id,
                       "its exposure stays automatic: asked for %.3f ms and gain %.3f it tells "
                       "%.3f ms and %.3f",
                       (double)asked->exposure_ns / 1e6, asked->gain_milli / 1e3,
                       (double)told->exposure_ns / 1e6, told->gain_milli / 1e3);
}

static int obeys(struct lc_camera *camera, struct seen *seen, int64_t deadline_ns,
                 struct ttf_err *err)
{
    struct ttf_exposure asked = modest(camera), told = {0};
    const struct lc_settings *last = &seen->last.told;
    enum lc_shown shown = LC_SHOWN_NO;
    int r = 0;

    camera->settle.set = false;
    lc_settle_want(camera, &asked);
    asked = camera->settle.wanted;
    for (unsigned i = 0; shown == LC_SHOWN_NO && i < FRAMES_MAX && r == 0; i++) {
        r = look(camera, deadline_ns, seen, err);
        if (r == 0 && !seen->last.error && lc_controls_told(&camera->can, last, &asked, &told))
            shown = lc_settle_shown(camera, &seen->last, &told);
        if (r == 0)
            r = lc_stream_give(camera, seen->last.index, err);
    }
    if (r < 0)
        return r;
    if (shown != LC_SHOWN_YES ||
        (asked.exposure_ns > 0 &&
         llabs(told.exposure_ns - asked.exposure_ns) > asked.exposure_ns / 5 + TTF_NS_PER_MS / 2))
        return refuse_restless(camera, &told, &asked, err);
    if (lc_controls_multiplied(camera, last))
        return ttf_err_set(err, -ENOTSUP, camera->id.id,
                           "the camera multiplies its pixels by a digital gain of %.3f",
                           last->value[LC_DIGITAL_GAIN][0]);
    return 0;
}

/* Whether frames become longer by a quarter when they are asked to, to within a fiftieth. */
static int steers(struct lc_camera *camera, struct seen *seen, int64_t deadline_ns,
                  struct ttf_err *err)
{
    struct lc_steer *steer = &camera->stream.steer;
    int64_t usual = median(seen, 4), base = steer->base_ns, longer, took;
    int r;

    if (usual > steer->base_ns)
        base = usual < steer->most_ns ? usual : steer->most_ns; /* its mode goes no faster */
    longer = base + base / 4;
    if (longer > steer->most_ns) {
        lc_controls_unmap(&camera->can, TTF_LIBCAMERA_PLACING);
        return 0;
    }
    steer->base_ns = longer;
    r = watch(camera, camera->stream.n + steer->delay + 4, deadline_ns, seen, err);
    took = median(seen, 3);
    steer->base_ns = base;
    if (r == 0 && llabs(took - longer) > longer / 50)
        lc_controls_unmap(&camera->can, TTF_LIBCAMERA_PLACING);
    return r;
}

static int all(struct lc_camera *camera, struct ttf_err *err)
{
    int64_t deadline =
        ttf_clock_now_ns(camera->clock) + PATIENCE_NS + 2 * FRAMES_MAX * frame_ns(camera);
    struct ttf_exposure asked = modest(camera);
    struct seen seen = {0};
    int r;

    camera->settle.set = false;
    lc_settle_want(camera, &asked);
    r = lc_stream_start(camera, err);
    if (r == 0)
        r = watch(camera, camera->stream.n + camera->config.settle_frames, deadline, &seen, err);
    if (r == 0)
        r = believe(camera, seen.told, err);
    if (r == 0)
        r = obeys(camera, &seen, deadline, err);
    if (r == 0)
        r = watch(camera, camera->config.settle_frames, deadline, &seen, err);
    if (r == 0)
        camera->period_ns = median(&seen, INTERVALS);
    if (r == 0)
        camera->uneven_ns = unevenness(&seen, camera->period_ns);
    if (r == 0 && (camera->can.mapped & TTF_LIBCAMERA_PLACING))
        r = steers(camera, &seen, deadline, err);
    if (r == 0 && camera->period_ns <= 0)
        r = ttf_err_set(err, -EIO, camera->id.id, "the camera's frames do not follow each other");
    return r;
}

int lc_trial(struct lc_camera *camera, struct ttf_err *err)
{
    int r = all(camera, err);

    lc_stream_stop(camera);
    return r;
}
