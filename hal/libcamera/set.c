/* SPDX-License-Identifier: Apache-2.0 */
/* set.c: which of the stream's frames are those of a set. */
#include <errno.h>
#include <string.h>

#include "device.h"
#include "ttf/base/time.h"

enum verdict {
    VERDICT_NOT_OURS,
    VERDICT_TAKE,
    VERDICT_OVER,    /* what is left of the set was lost */
    VERDICT_RESTLESS /* its settings do not come to rest */
};

/* A frame that is looked at. */
struct looked {
    struct lc_arrival arrival;
    struct ttf_exposure told;
    bool all_told;
    int64_t start_ns, end_ns;
};

static bool same_wanted(const struct lc_camera *camera, const struct ttf_exposure *a)
{
    struct ttf_exposure settable = lc_controls_settable(&camera->can, a);

    return ttf_exposure_equal(&settable, &camera->settle.wanted);
}

/* The next exposure's settings into the coming requests; frames of other settings follow nothing. */
static void want(struct lc_camera *camera)
{
    struct lc_set *set = &camera->set;

    if (!same_wanted(camera, &set->asked[set->next]))
        set->placed = false;
    lc_settle_want(camera, &set->asked[set->next]);
}

int lc_set_begin(struct lc_camera *camera, const struct ttf_camera_set *begun, struct ttf_err *err)
{
    struct lc_set *set = &camera->set;

    if (!camera->stream.on)
        return ttf_err_set(err, camera->handle ? -EIO : -ENODEV, camera->id.id,
                           "the camera has not come back");
    memcpy(set->asked, begun->settings, begun->n * sizeof(*set->asked));
    set->n = begun->n;
    set->next = 0;
    set->middle_ns = begun->middle_ns;
    set->placed = set->watched = set->starved = set->lost = false;
    set->fresh_ns = ttf_clock_now_ns(camera->clock);
    lc_stream_aim(camera, begun->middle_ns);
    want(camera);
    return 0;
}

/* `lost` frames of the set went by. Not ours, too, is a frame that has the settings of those before. */
static enum verdict pass_over(struct lc_camera *camera, uint32_t lost)
{
    struct lc_set *set = &camera->set;

    for (; lost > 0 && set->next < set->n; lost--) {
        set->next++;
        set->lost = true;
        if (set->next < set->n && !same_wanted(camera, &set->asked[set->next])) {
            set->placed = false;
            return VERDICT_NOT_OURS;
        }
    }
    return set->next < set->n ? VERDICT_TAKE : VERDICT_OVER;
}

/* The frame nearest to the middle wanted begins the set. */
static enum verdict place(struct lc_camera *camera, const struct looked *l)
{
    struct lc_set *set = &camera->set;
    int64_t exposure = l->told.exposure_ns;
    int64_t each = exposure > camera->period_ns ? exposure : camera->period_ns;
    int64_t late = (l->start_ns + l->end_ns) / 2 - (set->middle_ns - each / 2);

    if (late < 0 || each <= 0) {
        set->watched = true;
        return VERDICT_NOT_OURS;
    }
    /* It comes later than the one that was wanted, and frames in between are missing: it was lost. */
    if (set->watched && !set->starved && l->arrival.lost > 0 && late > each + each / 4) {
        int64_t missed = late / each;

        return pass_over(camera, missed < l->arrival.lost ? (uint32_t)missed : l->arrival.lost);
    }
    return VERDICT_TAKE;
}

static enum verdict judge(struct lc_camera *camera, struct looked *l)
{
    struct lc_set *set = &camera->set;
    enum lc_shown shown;

    l->all_told =
        lc_controls_told(&camera->can, &l->arrival.told, &camera->settle.wanted, &l->told);
    lc_arrival_span(camera, &l->arrival, l->told.exposure_ns, &l->start_ns, &l->end_ns);
    if (l->start_ns < set->fresh_ns)
        return VERDICT_NOT_OURS;
    lc_stream_seen(camera, &l->arrival, (l->start_ns + l->end_ns) / 2);
    /* Where something is not told it cannot be compared; once settings have settled the frame is handed out as bad. */
    if ((!l->all_told || l->arrival.error) && camera->settle.settling)
        return VERDICT_NOT_OURS;
    shown = lc_settle_shown(camera, &l->arrival, &l->told);
    if (shown != LC_SHOWN_YES)
        return shown == LC_SHOWN_NEVER ? VERDICT_RESTLESS : VERDICT_NOT_OURS;
    if (set->placed && !set->starved)
        return pass_over(camera, l->arrival.sequence - set->expected);
    if (set->next == 0 && set->middle_ns != 0 && !set->placed)
        return place(camera, l);
    return VERDICT_TAKE;
}

static void describe(struct lc_camera *camera, const struct looked *l)
{
    struct lc_slot *slot = &camera->stream.slot[l->arrival.index];
    uint32_t flags = 0;

    if (l->arrival.error || !l->all_told || lc_controls_multiplied(camera, &l->arrival.told))
        flags |= TTF_FRAME_ERROR;
    if (l->arrival.bytes < camera->frame_bytes)
        flags |= TTF_FRAME_SHORT;
    if (camera->set.lost)
        flags |= TTF_FRAME_SEQUENCE_GAP;
    if (!l->arrival.stamped)
        flags |= TTF_FRAME_NO_SENSOR_TIME;
    slot->frame = (struct ttf_frame){
        .format = camera->base.format,
        .data = slot->at,
        .bytes = l->arrival.bytes,
        .start_ns = l->start_ns,
        .end_ns = l->end_ns,
        .sequence = l->arrival.sequence,
        .flags = flags,
        .settings = l->told,
        .set_index = camera->set.next,
        .backend = slot,
    };
}

/* Into the caller's hands; and on to the next. */
static struct ttf_frame *deliver(struct lc_camera *camera, const struct looked *l)
{
    struct lc_set *set = &camera->set;
    struct ttf_frame *frame;

    describe(camera, l);
    frame = lc_stream_hold(camera, l->arrival.index);
    set->next++;
    set->lost = set->starved = false;
    set->placed = true;
    set->expected = l->arrival.sequence + 1;
    lc_stream_aim(camera, 0);
    if (set->next < set->n)
        want(camera); /* the earlier the better */
    return frame;
}

/* 1: *ret_frame; 0: on with the next one. */
static int one(struct lc_camera *camera, int64_t deadline_ns, struct ttf_frame **ret_frame,
               struct ttf_err *err)
{
    struct lc_set *set = &camera->set;
    struct looked l = {0};
    enum verdict verdict;
    int r = lc_stream_take(camera, deadline_ns, &l.arrival, err);

    if (r < 0)
        return r;
    if (camera->stream.slept) { /* the frames of before the sleep are dated wrongly now */
        camera->stream.slept = false;
        set->starved = true;
        set->fresh_ns = l.arrival.came_ns;
    }
    verdict = judge(camera, &l);
    if (verdict == VERDICT_TAKE) {
        *ret_frame = deliver(camera, &l);
        return 1;
    }
    r = lc_stream_give(camera, l.arrival.index, err);
    if (r == 0 && verdict == VERDICT_OVER)
        return ttf_err_set(err, -ENODATA, camera->id.id, "the rest of the set was lost");
    if (r == 0 && verdict == VERDICT_RESTLESS)
        return ttf_err_set(err, -EIO, camera->id.id,
                           "the camera's settings do not come to rest: %.3f ms, gain %.3f",
                           (double)l.told.exposure_ns / 1e6, l.told.gain_milli / 1e3);
    return r;
}

int lc_set_next(struct lc_camera *camera, int64_t deadline_ns, struct ttf_frame **ret_frame,
                struct ttf_err *err)
{
    int r;

    if (!camera->stream.on)
        return ttf_err_set(err, camera->handle ? -EIO : -ENODEV, camera->id.id,
                           "the camera has not come back");
    do {
        r = lc_stream_await_room(camera, deadline_ns);
        if (r < 0)
            return ttf_err_set(err, r, camera->id.id, "no frame was given back in time");
        camera->set.starved |= r > 0;
        if (camera->set.next < camera->set.n)
            want(camera);
        r = one(camera, deadline_ns, ret_frame, err);
    } while (r == 0);
    return r < 0 ? r : 0;
}
