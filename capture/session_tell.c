/* SPDX-License-Identifier: Apache-2.0 */
/* What a run says of itself: how it begins, what it came to, and why it could not go on. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "session_private.h"

/* A granted exposure this part off what was asked for is an event. */
#define EXPOSURE_OFF_SHARE 100

/* A camera that cannot do whole half-periods of the mains shows lamp ripple: somebody should know. */
void ttf_session_tell_exposure(struct ttf_session *s, int64_t asked_ns, int64_t granted_ns)
{
    int64_t off = granted_ns - asked_ns;

    if (granted_ns == 0)
        ttf_events_emit(&s->events, "camera",
                        "%.3f ms were asked for, and the camera's exposure cannot be set",
                        (double)asked_ns / 1e6);
    else if (off > asked_ns / EXPOSURE_OFF_SHARE || -off > asked_ns / EXPOSURE_OFF_SHARE)
        ttf_events_emit(&s->events, "camera", "%.3f ms were asked for, %.3f ms granted and locked",
                        (double)asked_ns / 1e6, (double)granted_ns / 1e6);
}

static void tell_plan(struct ttf_session *s)
{
    if (s->moved_on_from >= 0)
        ttf_events_emit(&s->events, "plan",
                        "the plan given is plan %d, but plan %d has come since and is in force",
                        s->moved_on_from, s->known_plan);
}

/* "7 slots lost: stopped by a person, then 3: the run could not go on" */
static void put_lost(const struct ttf_resume *r, char *ret, size_t size)
{
    const char *before = r->lost_reason;
    int64_t n = 0;
    size_t used = 0;

    for (int64_t k = r->grid.first_index; k <= r->unready_from && used < size; k++) {
        enum ttf_result result;
        const char *reason = k < r->unready_from ? ttf_resume_lost(r, k, &result) : NULL;

        if (n > 0 && reason != before) {
            used += (size_t)snprintf(ret + used, size - used, "%s%lld%s: %s", used ? ", then " : "",
                                     (long long)n, used ? "" : " slots lost", before);
            n = 0;
        }
        before = reason;
        n++;
    }
    if (used == 0)
        (void)snprintf(ret, size, "0 slots lost: %s", r->lost_reason);
}

static void tell_resumed(struct ttf_session *s)
{
    const struct ttf_resume *r = &s->resume;
    char lost[160], after[48] = "";
    int64_t unready = r->lost_until - r->unready_from;

    if (!r->continued)
        return;
    if (r->on_grid)
        put_lost(r, lost, sizeof(lost));
    if (r->outage_ns != TTF_NS_UNKNOWN)
        snprintf(after, sizeof(after), ", %.1f s after the last", (double)r->outage_ns / 1e9);
    if (r->on_grid)
        ttf_events_emit(&s->events, "resume", "on the same grid at slot %lld%s; %s",
                        (long long)r->grid.first_index, after, lost);
    else
        ttf_events_emit(&s->events, "resume", "at once at slot %lld in a new segment: %s",
                        (long long)r->grid.first_index,
                        r->pc_gives_up         ? "a PC's clock alone would leave no slot"
                        : r->waits_in_vain     ? "by UTC the next one would be too far off"
                        : r->clock_implausible ? "UTC lies before the last slot"
                                               : "how long the outage was is not known");
    if (unready > 0)
        ttf_events_emit(&s->events, "resume", "%lld slots lost: %s", (long long)unready,
                        TTF_REASON_NOT_READY);
}

/* A run that goes on in a box of another board, or before another scene, captures something else from there on. */
static void tell_box(struct ttf_session *s)
{
    const char *before = s->pulse.before.box;
    const char *now = s->box->description;
    size_t same = 0;

    if (!s->pulse.has_before || strcmp(before, now) == 0 || before[0] == '\0' || now[0] == '\0')
        return;
    /* From the first of its parts on that differs. */
    for (size_t i = 0; now[i] != '\0' && now[i] == before[i]; i++)
        if (now[i] == ' ')
            same = i + 1;
    ttf_events_emit(&s->events, "box", "described otherwise: '%.100s' instead of '%.100s'",
                    now + same, before + same);
}

static void tell_armed(struct ttf_session *s)
{
    int64_t now_ns = ttf_clock_now_ns(s->box->clock);
    int64_t begin_ns = ttf_grid_due_ns(&s->grid, 0) - s->lead_ns - s->first_settle_ns;
    struct ttf_progress p = {.kind = TTF_PROGRESS_ARMED,
                             .index = s->resume.lost_until,
                             .total = s->plan.count,
                             .waits = s->plan.start_utc_ns != 0 && s->config->rehearse <= 0 &&
                                      s->resume.lost_until == 0 && begin_ns > now_ns,
                             .text = "",
                             .now_ns = now_ns,
                             .error_ns = TTF_NS_UNKNOWN,
                             .wakeup_ns = TTF_NS_UNKNOWN};

    if (s->first_settle_ns > 0) { /* one that goes on is behind its begin, and lights them now */
        p.lit_ns = begin_ns > now_ns ? begin_ns : now_ns;
        p.settled_ns = p.lit_ns + s->first_settle_ns;
    }
    ttf_committer_tell(&s->committer, &p);
}

/* A lens that no plan moves is in no frame's settings: where it stands is told at each beginning. */
static void tell_lenses(struct ttf_session *s)
{
    for (unsigned i = 0; i < s->box->n_cameras; i++) {
        const struct ttf_camera_caps *caps = ttf_camera_caps(s->box->cameras[i].camera);

        if (caps->lens_held)
            ttf_events_emit(&s->events, "camera",
                            "%s: the lens is held at %lld, the driver's own number",
                            s->box->cameras[i].name, (long long)caps->lens_code);
    }
}

/* The first one's disk needs a person as after a move; told once the run is armed, which ends what others said before. */
static void tell_begun_in_second(struct ttf_session *s)
{
    char text[2 * 4096 + 256];

    if (!s->from_first)
        return;
    snprintf(
        text, sizeof(text),
        "cannot be written at the start: the run goes on in the second storage, from slot %lld "
        "on: %s; before it: %s",
        (long long)s->grid.first_index, s->path, s->config->path);
    ttf_committer_alarm(&s->committer, TTF_ALARM_UNTIL_NEW, text);
}

void ttf_session_tell_beginning(struct ttf_session *s)
{
    tell_plan(s);
    tell_resumed(s);
    tell_box(s);
    tell_lenses(s);
    tell_armed(s);
    tell_begun_in_second(s);
}

void ttf_session_fill_result(const struct ttf_session *s, struct ttf_session_result *ret)
{
    const struct ttf_ledger *ledger = &s->committer.ledger;
    const struct ttf_rehearsal *h = &s->rehearsal;

    if (s->committer.writer) {
        const int64_t *n = ttf_writer_state(s->committer.writer)->counts;

        ret->captured = n[TTF_RESULT_CAPTURED];
        ret->partial = n[TTF_RESULT_PARTIAL];
        ret->missed = n[TTF_RESULT_MISSED];
        ret->failed = n[TTF_RESULT_FAILED];
        ret->paused = n[TTF_RESULT_PAUSED];
        ret->power = n[TTF_RESULT_POWER];
        ret->slots =
            ret->captured + ret->partial + ret->missed + ret->failed + ret->paused + ret->power;
    }
    ret->error_p99_ns = ttf_quantile_ns(&ledger->error, 0.99);
    ret->error_max_ns = ledger->error.max_ns;
    ret->wakeup_p99_ns = ttf_quantile_ns(&ledger->wakeup, 0.99);
    ret->wakeup_max_ns = ledger->wakeup.max_ns;
    ret->resumed = s->resume.continued;
    ret->second_storage = s->committer.moved;
    ret->moved_on_from = s->moved_on_from;
    ret->total = s->plan.count;
    if (s->config->rehearse > 0) {
        int64_t slowest = h->expose_ns > h->commit_ns ? h->expose_ns : h->commit_ns;

        ret->busy_ns = h->busy_ns;
        ret->headroom_stops = isinf(h->headroom_stops) ? NAN : h->headroom_stops;
        ret->sharpness = h->sharpness;
        ret->settle_change =
            h->first_level > 0 ? (h->last_level - h->first_level) / h->first_level : NAN;
        ret->slot_bytes = h->slot_bytes;
        ret->sustained_interval_ns = slowest + slowest / 10;
    }
}

void ttf_session_say_why(const struct ttf_session *s, int r, struct ttf_err *err)
{
    if (!err || err->code == r)
        return;
    if (s->queue.fatal == r && s->queue.fatal_err.code != 0) {
        *err = s->queue.fatal_err;
        err->code = r;
        return;
    }
    ttf_err_set(err, r, s->committer.path, "the run could not go on");
}
