/* SPDX-License-Identifier: Apache-2.0 */
/* Plans and segments on their way to the disk: a changed plan's files and line, then the segment that puts it in force. */
#include <errno.h>
#include <string.h>

#include "asks.h"
#include "commit_storage.h"
#include "plan_change.h"
#include "timeline.h"

int ttf_committer_segment_number(const struct ttf_committer *c, int segment)
{
    return segment - c->segment_base;
}

int ttf_committer_plan_number(const struct ttf_committer *c, int plan)
{
    int number = plan - c->plan_base;

    return c->has_continued && number < c->continued.plan ? c->continued.plan : number;
}

/*
 * What of it is there already is not written again: after a failure the dataset was opened anew and says
 * what is. A plan without the segment that follows it is not in force.
 */
static int write_once(struct ttf_committer *c, const struct ttf_plan_change *change,
                      struct ttf_err *err)
{
    const struct ttf_writer_state *state = c->writer ? ttf_writer_state(c->writer) : NULL;
    struct ttf_segment segment = change->segment;
    int r;

    if (!state)
        return -EIO;
    segment.segment = ttf_committer_segment_number(c, segment.segment);
    segment.plan = ttf_committer_plan_number(c, segment.plan);
    if (state->n_segments > segment.segment)
        return 0;
    if (state->n_plans <= segment.plan) {
        r = ttf_writer_plan(c->writer, change->yaml, change->json, err);
        if (r < 0)
            return r;
    }
    return ttf_writer_segment(c->writer, &segment, err);
}

static void in_force(struct ttf_committer *c, struct ttf_plan_change *change)
{
    struct ttf_plan_change *before = c->in_force;

    c->total = change->count;
    c->n_plans = change->segment.plan + 1;
    c->reserve_bytes = change->reserve_bytes;
    c->slot_bytes = change->slot_bytes;
    ttf_asks_answer(c->control, change->ask, 0, NULL);
    c->in_force = change;
    ttf_plan_change_free(before);
}

int ttf_committer_write_change(struct ttf_committer *c, struct ttf_plan_change **change,
                               struct ttf_err *err)
{
    int r = write_once(c, *change, err);

    if (r < 0 && !ttf_committer_power_lost(c)) {
        int reopened = ttf_committer_reopen(c);

        r = reopened < 0 ? ttf_err_set(err, reopened, c->path, "the dataset cannot be opened anew")
                         : write_once(c, *change, err);
    }
    if (r < 0)
        return r;
    in_force(c, *change);
    *change = NULL;
    return 0;
}

void ttf_committer_another_end(struct ttf_committer *c, int64_t total)
{
    c->total = total;
    for (struct ttf_slot_work *work = c->pending; work; work = work->next) {
        work->total = total;
        if (work->change)
            work->change->count = total;
    }
}

int ttf_committer_write_correction(struct ttf_committer *c, const struct ttf_segment *of_session)
{
    struct ttf_segment segment = *of_session;

    segment.segment = ttf_committer_segment_number(c, of_session->segment);
    segment.plan = ttf_committer_plan_number(c, of_session->plan);
    if (c->in_force && c->in_force->segment.segment == of_session->segment)
        c->in_force->segment = *of_session;
    if (segment.segment < 0)
        return 0; /* of the dataset before */
    if (c->has_continued && segment.segment == 0) {
        /* Of the second dataset's first segment, which begins later than the session's. */
        int64_t later_ns = c->continued.origin_ns - segment.origin_ns;

        segment.origin_ns = c->continued.origin_ns;
        segment.first_index = c->continued.first_index;
        segment.run_ns = c->continued.run_ns;
        segment.gap_ns = 0;
        segment.origin_utc_ns += segment.origin_utc_ns == TTF_NS_UNKNOWN ? 0 : later_ns;
    }
    if ((c->has_continued || c->from_first) && segment.segment == 0)
        ttf_timeline_run_utc(&segment, c->past, c->slot0_ns, &c->outage);
    return c->writer ? ttf_writer_segment(c->writer, &segment, NULL) : -EIO;
}
