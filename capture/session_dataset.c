/* SPDX-License-Identifier: Apache-2.0 */
/* The dataset of a run: made or opened, its plan compared, its new segment begun. */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "lamp_programme.h"
#include "manifest_of_plan.h"
#include "plan_change.h"
#include "plan_figures.h"
#include "second_storage.h"
#include "session_private.h"
#include "timeline.h"
#include "ttf/capture/disk_budget.h"
#include "ttf/dataset/reader.h"

/* From resolving the grid to the first lamp command of its first slot: a card syncs slowly. */
#define READY_MARGIN_NS (2 * TTF_NS_PER_S)

static bool dataset_exists(const struct ttf_session *s)
{
    struct ttf_io_stat st;
    char path[4096 + 16];

    snprintf(path, sizeof(path), "%s/dataset.json", s->path);
    return s->config->io->ops->stat(s->config->io, path, &st) == 0;
}

/*
 * A run is of a group from its beginning, as dataset.json is written once. Gone on with by a plan that names the
 * group as one of its plans did it needs the other dataset no more; one that names another dataset must name one of
 * the same group. That lies where the run began, wherever the run is by now.
 */
static int expect_group(struct ttf_session *s, struct ttf_err *err)
{
    const bool is_there = dataset_exists(s);
    struct ttf_manifest manifest;
    int r;

    if (s->config->rehearse > 0 || (is_there && (s->known_plan >= 0 || s->names_group)))
        return 0;
    r = ttf_group_of_plan(s->config->io, s->config->path, &s->plan, s->box->simulated, &s->group,
                          err);
    if (r < 0 || !is_there || s->group.uuid[0] == '\0')
        return r;
    r = ttf_manifest_load(s->config->io, s->path, &manifest, err);
    if (r < 0 || strcmp(ttf_manifest_group(&manifest), s->group.uuid) == 0)
        return r;
    ttf_err_set(err, -EINVAL, "group", "the dataset was begun, and not in the group of '%s'",
                s->plan.group);
    ttf_err_hint(err, "begin another dataset with this plan");
    return -EINVAL;
}

int ttf_session_check_disk(struct ttf_session *s, struct ttf_err *err)
{
    struct ttf_clock *clock = s->config->skip_speed_check ? NULL : s->box->clock;
    int r;

    r = expect_group(s, err);
    if (r < 0)
        return r;
    /* An unattended run that goes on after a power cut is not refused for a disk that became tight. */
    if (dataset_exists(s))
        return s->config->rehearse > 0
                   ? ttf_err_set(
                         err, -EEXIST, s->path,
                         "a rehearsal needs a folder of its own, not a dataset that is there")
                   : 0;
    r = s->config->rehearse > 0
            ? 0
            : ttf_second_storage_check(s->config->io, s->path, &s->plan, NULL, err);
    if (r < 0)
        return r;
    return ttf_disk_budget_check(s->config->io, s->path, clock, &s->plan, &s->figures, NULL, err);
}

/* All slots have their records: fine if this plan says so too, else somebody is mistaken. */
static int expect_known_plan(const struct ttf_session *s, struct ttf_err *err)
{
    if (s->known_plan >= 0)
        return 0;
    ttf_err_set(err, -EINVAL, s->path, "is complete, and was captured by another plan");
    ttf_err_hint(err, "name another folder, or a plan with more slots to go on with it");
    return -EINVAL;
}

/* From now to the earliest slot that can still be met: those before are given up. */
static int64_t ready_after_ns(const struct ttf_session *s)
{
    return s->first_settle_ns + s->lead_ns + READY_MARGIN_NS;
}

/* The run's own time, from the segments so far. */
static int read_past(const struct ttf_session *s, struct ttf_resume_input *in, struct ttf_err *err)
{
    struct ttf_segment *segments = NULL;
    int64_t *taken_until = NULL;
    int n = 0;
    int r = 0;

    if (in->state->n_segments > 0)
        r = ttf_timeline_read(s->config->io, s->from_first ? s->config->path : s->path, &segments,
                              &taken_until, &n, err);
    if (r < 0)
        return r;
    if (n > 0) {
        const struct ttf_segment *last = &segments[n - 1];

        in->elapsed_ns = ttf_timeline_elapsed_ns(segments, n) +
                         (in->state->next_index - last->first_index) * last->interval_ns;
    }
    in->past = ttf_timeline_past(segments, taken_until, n, in->state->next_index,
                                 ttf_clock_boot_id(s->box->clock));
    if (in->past.last_moved)
        in->past.last_ahead_ns = ready_after_ns(s);
    free(segments);
    free(taken_until);
    return 0;
}

/* UTC of slot 0; TTF_NS_UNKNOWN. */
static int64_t slot0_utc(const struct ttf_session *s, const struct ttf_resume_input *in)
{
    if (in->past.slot0_utc_ns != TTF_NS_UNKNOWN || in->utc.trust == TTF_TRUST_NONE)
        return in->past.slot0_utc_ns;
    return in->utc.utc_ns + (s->run.slot0_ns - in->utc.boot_ns);
}

static int resolve_grid(struct ttf_session *s, struct ttf_resume_input *in, struct ttf_err *err)
{
    int r;

    in->boot_id = ttf_clock_boot_id(s->box->clock);
    in->plan = &s->plan;
    in->same_plan = s->goes_on;
    in->start_utc_ns = s->config->rehearse > 0 ? 0 : s->plan.start_utc_ns;
    in->absence = s->config->absence;
    in->now_ns = ttf_clock_now_ns(s->box->clock);
    in->ready_ns = in->now_ns + ready_after_ns(s);
    ttf_clock_utc(s->box->clock, &in->utc);
    r = ttf_resume_resolve(in, &s->resume, err);
    if (r < 0)
        return r;
    s->grid = s->grid_before = s->resume.grid;
    s->run = s->resume.clock;
    s->past = in->past;
    s->plan.count = s->resume.count;
    if (!s->resume.continued && s->resume.lost_until >= s->plan.count)
        return ttf_err_set(err, -EINVAL, s->plan.end == TTF_END_UNTIL ? "until" : "start",
                           "the plan's last slot lies in the past");
    return 0;
}

/* The clock that labels the segment: what is believed of it. */
static void label_segment(struct ttf_session *s, const struct ttf_utc *now)
{
    struct ttf_segment *segment = &s->pulse.segment;
    const struct ttf_utc utc = ttf_resume_utc(&s->past, now);

    segment->origin_utc_ns = TTF_NS_UNKNOWN;
    segment->uncertainty_ns = TTF_NS_UNKNOWN;
    if (utc.trust != TTF_TRUST_NONE) {
        segment->origin_utc_ns = utc.utc_ns + (segment->origin_ns - utc.boot_ns);
        segment->uncertainty_ns = utc.uncertainty_ns;
    }
    snprintf(segment->trust, sizeof(segment->trust), "%s", ttf_trust_name(utc.trust));
    if (ttf_resume_clock_behind(&s->past, now))
        ttf_pulse_behind(&s->pulse, now);
}

/* state: of the dataset that is gone on with, which may be another one. */
static int write_segment(struct ttf_session *s, struct ttf_writer *writer, int plan,
                         const struct ttf_writer_state *state, const struct ttf_utc *utc,
                         struct ttf_err *err)
{
    struct ttf_segment *segment = &s->pulse.segment;
    int r;

    memset(segment, 0, sizeof(*segment));
    if (state->n_segments > 0) {
        s->pulse.before = state->last_segment;
        s->pulse.has_before = true;
    }
    segment->segment = ttf_writer_state(writer)->n_segments;
    segment->first_index = s->grid.first_index;
    snprintf(segment->boot_id, sizeof(segment->boot_id), "%s", ttf_clock_boot_id(s->box->clock));
    segment->origin_ns = s->grid.origin_ns;
    label_segment(s, utc);
    segment->interval_ns = s->grid.interval_ns;
    segment->plan = plan;
    snprintf(segment->zone, sizeof(segment->zone), "%s", s->plan.zone);
    segment->zone_offset_s = s->plan.zone_offset_s;
    if (s->from_first) {
        segment->run_ns = ttf_timeline_run_ns(segment, s->run.slot0_ns);
        ttf_timeline_run_utc(segment, &s->past, s->run.slot0_ns, &s->resume.outage);
    }
    snprintf(segment->box, sizeof(segment->box), "%s", s->box->description);
    segment->gap_ns = s->resume.gap_ns;
    if (segment->gap_ns == TTF_NS_UNKNOWN && s->pulse.has_before)
        segment->gap_ns = ttf_resume_gap_ns(&s->pulse.before, segment->first_index,
                                            s->resume.clock_implausible ? TTF_NS_UNKNOWN
                                                                        : segment->origin_utc_ns);
    if (segment->gap_ns == TTF_NS_UNKNOWN)
        s->pulse.gap_segment = segment->segment;
    r = ttf_writer_segment(writer, segment, err);
    if (r < 0)
        return r;
    s->segment = segment->segment;
    s->pulse.has_segment = true;
    s->pulse.past = &s->past;
    return 0;
}

/* What people agreed on once stays: a zone that has changed to summer time in between changes nothing. */
static void keep_zone(struct ttf_plan *plan, const struct ttf_writer_state *state)
{
    if (state->n_segments > 0 && strcmp(plan->zone, state->last_segment.zone) == 0)
        plan->zone_offset_s = state->last_segment.zone_offset_s;
}

/* The second dataset, begun by reading the first. The plan's number there. */
static int second_with_plan(struct ttf_session *s, const struct ttf_manifest *manifest,
                            const char *json, struct ttf_err *err)
{
    const struct ttf_plan_text in_force = {json, s->given_yaml};
    struct ttf_plan_text given = {NULL, s->config->plan_yaml};
    char *given_json = NULL;
    int r = s->moved_on_from < 0 ? 0 : ttf_plan_json(s->config->plan, &given_json, err);

    given.json = given_json;
    if (r == 0)
        r = ttf_second_open(s->config->io, s->path, manifest, given_json ? &given : NULL, &in_force,
                            &s->committer.writer, err);
    free(given_json);
    return r;
}

/* Makes a new dataset, or sees to it that one that is gone on with has this plan. The plan's number. */
static int dataset_with_plan(struct ttf_session *s, const struct ttf_manifest *manifest,
                             struct ttf_err *err)
{
    struct ttf_writer **writer = &s->committer.writer;
    char *json = NULL;
    int r;

    if (*writer && !s->from_first && s->known_plan >= 0)
        return s->known_plan;
    r = ttf_plan_json(&s->plan, &json, err);
    if (r < 0)
        return r;
    if (*writer)
        r = ttf_writer_plan(*writer, s->given_yaml, json, err);
    else if (s->from_first)
        r = second_with_plan(s, manifest, json, err);
    else
        r = ttf_writer_create(s->config->io, s->path, manifest, s->given_yaml, json, writer, err);
    free(json);
    return r;
}

/* Of a dataset that is gone on with. */
struct found {
    struct ttf_writer_state state;
    struct ttf_manifest manifest;
};

/* Not: in use, damaged, no memory. Those are for a person, or pass. */
static bool cannot_be_written(int code)
{
    return code == -EROFS || code == -EIO || code == -ENOSPC || code == -EDQUOT ||
           code == -EACCES || code == -EPERM;
}

/*
 * A dataset whose storage can be read and not written any more, at the beginning of a boot: what it says is
 * where the second one goes on.
 */
static int start_second(struct ttf_session *s, int code, struct found *found, struct ttf_err *err)
{
    struct ttf_err why = {0};

    if (s->committer.second_path[0] == '\0' || strcmp(s->committer.second_path, s->path) == 0 ||
        !cannot_be_written(code) ||
        ttf_second_state_of(s->config->io, s->path, &found->state, &found->manifest, &why) < 0)
        return code;
    ttf_events_emit(&s->events, "storage",
                    "cannot be written at the start: begun here; before it: %.150s", s->path);
    snprintf(s->path, sizeof(s->path), "%s", s->committer.second_path);
    s->from_first = true;
    s->first_code = code;
    s->committer.moved = true;
    return ttf_second_manifest(&found->manifest, &found->manifest, err);
}

static int open_there(struct ttf_session *s, struct found *found, struct ttf_err *err)
{
    int r = ttf_writer_open(s->config->io, s->path, &s->committer.writer, err);

    if (r < 0)
        return start_second(s, r, found, err);
    found->state = *ttf_writer_state(s->committer.writer);
    found->manifest = *ttf_writer_manifest(s->committer.writer);
    return 0;
}

/* A run with a second storage is of a group from the beginning: that of its plan, or its own, by the first dataset's uuid. */
static void begin_group(struct ttf_session *s, struct ttf_manifest *manifest)
{
    snprintf(manifest->group_uuid, sizeof(manifest->group_uuid), "%s", s->group.uuid);
    snprintf(manifest->group_member, sizeof(manifest->group_member), "%s", s->group.member);
    if (s->committer.second_path[0] == '\0')
        return;
    if (s->group.uuid[0] == '\0')
        memcpy(manifest->group_uuid, manifest->uuid, sizeof(manifest->group_uuid));
    snprintf(manifest->group_member, sizeof(manifest->group_member), "%s", TTF_MEMBER_FIRST);
}

/* What the committer needs to go on with elsewhere: plan, segment, calibration, who the dataset is. */
static int set_in_force(struct ttf_session *s, const struct ttf_manifest *manifest,
                        struct ttf_err *err)
{
    struct ttf_committer *c = &s->committer;

    c->in_force = ttf_plan_change_new(&s->plan, s->given_yaml);
    if (!c->in_force)
        return ttf_err_set(err, -ENOMEM, s->path, "no memory");
    c->in_force->segment = s->pulse.segment;
    c->in_force->as_given = s->moved_on_from < 0;
    c->given = s->config->plan;
    c->given_yaml = s->config->plan_yaml;
    c->slot0_ns = s->run.slot0_ns;
    c->past = &s->past;
    c->from_first = s->from_first;
    c->outage = s->resume.outage;
    c->total = s->plan.count; /* as resolved */
    c->in_force->slot_bytes = s->figures.slot_bytes;
    c->n_plans = s->next_plan = ttf_writer_state(c->writer)->n_plans;
    c->manifest = *manifest;
    if (s->has_calibration) {
        snprintf(c->calibration_id, sizeof(c->calibration_id), "%s", s->calibration.id);
        c->calibration_folder = s->config->calibration_folder;
    }
    return 0;
}

/* Where it is gone on with, and with which plan. */
static int resolve(struct ttf_session *s, const struct ttf_writer_state *state,
                   struct ttf_utc *ret_utc, struct ttf_err *err)
{
    struct ttf_resume_input in = {.state = state};
    int r;

    if (s->known_plan < 0)
        keep_zone(&s->plan, state);
    r = read_past(s, &in, err);
    if (r == 0)
        r = resolve_grid(s, &in, err);
    if (r == 0 && s->known_plan < 0)
        r = ttf_session_resolve_phase(&s->plan, slot0_utc(s, &in), err);
    *ret_utc = in.utc;
    return r;
}

/* A new plan that has fewer slots than there are, or ends before the last of them. */
static int expect_enough(const struct ttf_session *s, int64_t next_index, struct ttf_err *err)
{
    if (next_index > s->plan.count) {
        ttf_err_set(err, -EINVAL, "count", "%lld slots, and the dataset has %lld already",
                    (long long)s->plan.count, (long long)next_index);
        ttf_err_hint(err, "count: %lld ends it here", (long long)next_index);
        return -EINVAL;
    }
    if (s->known_plan < 0 && next_index == 0 && s->plan.count == 0)
        return ttf_err_set(err, -EINVAL, "until", "has passed by this box's clock");
    if (s->known_plan < 0 && s->resume.end_passed) {
        ttf_err_set(err, -EINVAL, "until", "comes before slot %lld, which has its record already",
                    (long long)next_index - 1);
        ttf_err_hint(err, "count: %lld ends it here", (long long)next_index);
        return -EINVAL;
    }
    return 0;
}

int ttf_session_open_dataset(struct ttf_session *s, struct ttf_err *err)
{
    struct found found = {0};
    struct ttf_manifest manifest;
    struct ttf_utc utc = {0};
    int plan;
    int r = ttf_manifest_of_plan(&s->plan, s->box, s->has_calibration ? &s->calibration : NULL,
                                 &manifest, err);

    if (r == 0) {
        manifest.rehearsal = s->config->rehearse > 0;
        begin_group(s, &manifest);
    }
    if (r == 0 && dataset_exists(s)) {
        r = open_there(s, &found, err);
        if (r == 0)
            r = ttf_manifest_takes_plan(&found.manifest, &manifest, err);
        manifest = found.manifest;
    }
    if (r == 0)
        r = resolve(s, &found.state, &utc, err);
    if (r < 0)
        return r;
    if (s->resume.continued && !found.state.sealed)
        r = expect_enough(s, found.state.next_index, err);
    if (r < 0)
        return r;
    if (s->resume.continued && found.state.next_index >= s->plan.count) {
        if (s->from_first)
            return s->first_code;
        /* Cut off before its seal: sealed now. A new plan comes into force first, so that it finds nothing to do again. */
        if (found.state.sealed || s->known_plan >= 0)
            return found.state.sealed ? expect_known_plan(s, err) : 0;
    }
    plan = dataset_with_plan(s, &manifest, err);
    if (plan < 0)
        return plan;
    r = write_segment(s, s->committer.writer, plan, &found.state, &utc, err);
    if (r == 0 && s->has_calibration)
        r = ttf_writer_calibration(s->committer.writer, s->calibration.id,
                                   s->config->calibration_folder, err);
    return r < 0 ? r : set_in_force(s, &manifest, err);
}
