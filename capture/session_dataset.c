/* SPDX-License-Identifier: Apache-2.0 */
/* The dataset of a run: made or opened, its plan compared, its new segment begun. */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "lamp_programme.h"
#include "manifest_of_plan.h"
#include "plan_figures.h"
#include "session_private.h"
#include "ttf/capture/disk_budget.h"
#include "ttf/dataset/reader.h"

#define PLAN_MAX_BYTES (1 << 20)

/* From resolving the grid to the first lamp command of its first slot: a card syncs slowly. */
#define READY_MARGIN_NS (2 * TTF_NS_PER_S)

static bool dataset_exists(const struct ttf_session *s)
{
    struct ttf_io_stat st;
    char path[4096];

    snprintf(path, sizeof(path), "%s/dataset.json", s->config->path);
    return s->config->io->ops->stat(s->config->io, path, &st) == 0;
}

int ttf_session_check_disk(struct ttf_session *s, struct ttf_err *err)
{
    struct ttf_clock *clock = s->config->skip_speed_check ? NULL : s->box->clock;

    /* An unattended run that goes on after a power cut is not refused for a disk that became tight. */
    if (dataset_exists(s) && s->config->rehearse > 0)
        return ttf_err_set(err, -EEXIST, s->config->path,
                           "a rehearsal needs a folder of its own, not a dataset that is there");
    if (dataset_exists(s))
        return 0;
    return ttf_disk_budget_check(s->config->io, s->config->path, clock, &s->plan, &s->figures, NULL,
                                 err);
}

/* Whether the dataset's newest plan is this one. */
static bool plan_is_stored(const struct ttf_session *s, int n_plans, const char *json)
{
    char path[4096];
    char *stored = NULL;
    size_t bytes;
    bool same;

    snprintf(path, sizeof(path), "%s/plans/%d.json", s->config->path, n_plans - 1);
    if (n_plans <= 0 ||
        ttf_io_slurp(s->config->io, path, PLAN_MAX_BYTES, &stored, &bytes, NULL) < 0)
        return false;
    same = strcmp(stored, json) == 0;
    free(stored);
    return same;
}

/* A plan that is not the stored one is stored beside it. Returns the plan's number. */
static int store_plan(struct ttf_session *s, struct ttf_writer *writer, const char *json,
                      struct ttf_err *err)
{
    int n = ttf_writer_state(writer)->n_plans;

    if (plan_is_stored(s, n, json))
        return n - 1;
    return ttf_writer_plan(writer, s->config->plan_yaml, json, err);
}

/* All slots have their records: fine if this plan says so too, else somebody is mistaken. */
static int expect_same_plan(const struct ttf_session *s, int n_plans, struct ttf_err *err)
{
    char *json = NULL;
    bool same;
    int r = ttf_plan_json(&s->plan, &json, err);

    if (r < 0)
        return r;
    same = plan_is_stored(s, n_plans, json);
    free(json);
    if (same)
        return 0;
    ttf_err_set(err, -EINVAL, s->config->path, "is complete, and was captured by another plan");
    return ttf_err_hint(err, "name another folder, or a plan with more slots to go on with it");
}

/* UTC of slot 0 as a dataset that is gone on with has it; TTF_NS_UNKNOWN. */
static int64_t slot0_utc(const struct ttf_segment *segment)
{
    struct ttf_grid grid = {segment->first_index, segment->origin_utc_ns, segment->interval_ns};

    return segment->origin_utc_ns == TTF_NS_UNKNOWN ? TTF_NS_UNKNOWN : ttf_grid_due_ns(&grid, 0);
}

/*
 * The same from whichever segment knows it: after a cut without a clock to be trusted the last one
 * does not. What was resolved once stays, counted in slots, whatever the outages.
 */
static int known_slot0_utc(struct ttf_session *s, const struct ttf_writer_state *state,
                           int64_t *ret, struct ttf_err *err)
{
    struct ttf_reader *reader;
    struct ttf_segment segment;
    int r;

    *ret = state->n_segments > 0 ? slot0_utc(&state->last_segment) : TTF_NS_UNKNOWN;
    if (*ret != TTF_NS_UNKNOWN || state->n_segments <= 1)
        return 0;
    r = ttf_reader_open(s->config->io, s->config->path, &reader, err);
    if (r < 0)
        return r;
    for (int i = 0; i < state->n_segments && *ret == TTF_NS_UNKNOWN; i++)
        if (ttf_reader_segment(reader, i, &segment) == 0)
            *ret = slot0_utc(&segment);
    ttf_reader_close(reader);
    return 0;
}

/* A day that starts at a local time becomes a phase since slot 0, once. */
static int resolve_local(struct ttf_session *s, const struct ttf_writer_state *state,
                         const struct ttf_utc *utc, struct ttf_err *err)
{
    struct ttf_plan *plan = &s->plan;
    int64_t slot0;
    int r;

    if (plan->lamps != TTF_LAMPS_PHOTOPERIOD || !plan->photoperiod_local)
        return 0;
    r = known_slot0_utc(s, state, &slot0, err);
    if (r < 0)
        return r;
    if (slot0 == TTF_NS_UNKNOWN && utc->trust != TTF_TRUST_NONE)
        slot0 = utc->utc_ns + (ttf_grid_due_ns(&s->grid, 0) - utc->boot_ns);
    if (slot0 == TTF_NS_UNKNOWN) {
        ttf_err_set(err, -EINVAL, "lamps.day_start",
                    "nobody vouches for this box's clock, so a local time means nothing");
        return ttf_err_hint(err, "use lamps.phase, or let the clock be set first");
    }
    plan->phase_ns = ttf_photoperiod_phase_ns(slot0, plan->zone_offset_s, plan->day_start_s);
    return 0;
}

static int resolve_grid(struct ttf_session *s, const struct ttf_writer_state *state,
                        struct ttf_utc *ret_utc, struct ttf_err *err)
{
    struct ttf_resume_input in = {
        .state = state,
        .boot_id = ttf_clock_boot_id(s->box->clock),
        .now_ns = ttf_clock_now_ns(s->box->clock),
        .interval_ns = s->plan.interval_ns,
        .count = s->plan.count,
        .start_utc_ns = s->config->rehearse > 0 ? 0 : s->plan.start_utc_ns,
    };
    int r;

    ttf_clock_utc(s->box->clock, &in.utc);
    in.ready_ns = in.now_ns + s->first_settle_ns + s->lead_ns + READY_MARGIN_NS;
    r = ttf_resume_resolve(&in, &s->resume, err);
    if (r < 0)
        return r;
    s->grid = s->resume.grid;
    *ret_utc = in.utc;
    if (!s->resume.continued && s->resume.lost_until >= s->plan.count)
        return ttf_err_set(err, -EINVAL, "start", "the plan's last slot lies in the past");
    return 0;
}

static int write_segment(struct ttf_session *s, struct ttf_writer *writer, int plan,
                         const struct ttf_utc *utc, struct ttf_err *err)
{
    const struct ttf_writer_state *state = ttf_writer_state(writer);
    struct ttf_segment *segment = &s->pulse.segment;
    int r;

    memset(segment, 0, sizeof(*segment));
    if (state->n_segments > 0) {
        s->pulse.before = state->last_segment;
        s->pulse.has_before = true;
    }
    segment->segment = state->n_segments;
    segment->first_index = s->grid.first_index;
    snprintf(segment->boot_id, sizeof(segment->boot_id), "%s", ttf_clock_boot_id(s->box->clock));
    segment->origin_ns = s->grid.origin_ns;
    segment->origin_utc_ns = utc->trust == TTF_TRUST_NONE
                                 ? TTF_NS_UNKNOWN
                                 : utc->utc_ns + (s->grid.origin_ns - utc->boot_ns);
    segment->uncertainty_ns = utc->trust == TTF_TRUST_NONE ? TTF_NS_UNKNOWN : utc->uncertainty_ns;
    snprintf(segment->trust, sizeof(segment->trust), "%s", ttf_trust_name(utc->trust));
    segment->interval_ns = s->grid.interval_ns;
    segment->plan = plan;
    snprintf(segment->zone, sizeof(segment->zone), "%s", s->plan.zone);
    segment->zone_offset_s = s->plan.zone_offset_s;
    segment->gap_ns = s->resume.gap_ns;
    if (segment->gap_ns == TTF_NS_UNKNOWN && s->pulse.has_before)
        segment->gap_ns = ttf_resume_gap_ns(&s->pulse.before, segment->first_index,
                                            s->resume.clock_implausible ? TTF_NS_UNKNOWN
                                                                        : segment->origin_utc_ns);
    r = ttf_writer_segment(writer, segment, err);
    if (r < 0)
        return r;
    s->segment = segment->segment;
    s->pulse.has_segment = true;
    return 0;
}

/* What people agreed on once stays: a zone that has changed to summer time in between changes nothing. */
static void keep_zone(struct ttf_plan *plan, const struct ttf_writer_state *state)
{
    if (state->n_segments > 0 && strcmp(plan->zone, state->last_segment.zone) == 0)
        plan->zone_offset_s = state->last_segment.zone_offset_s;
}

/* Makes a new dataset, or sees to it that one that is gone on with has this plan. The plan's number. */
static int dataset_with_plan(struct ttf_session *s, const struct ttf_manifest *manifest,
                             struct ttf_err *err)
{
    struct ttf_writer **writer = &s->committer.writer;
    char *json = NULL;
    int r = ttf_plan_json(&s->plan, &json, err);

    if (r < 0)
        return r;
    if (*writer)
        r = store_plan(s, *writer, json, err);
    else
        r = ttf_writer_create(s->config->io, s->config->path, manifest, s->config->plan_yaml, json,
                              writer, err);
    free(json);
    return r;
}

int ttf_session_open_dataset(struct ttf_session *s, struct ttf_err *err)
{
    static const struct ttf_writer_state nothing = {.last_due_ns = TTF_NS_UNKNOWN};
    const struct ttf_writer_state *state = &nothing;
    struct ttf_manifest manifest;
    struct ttf_utc utc;
    int plan;
    int r = ttf_manifest_of_plan(&s->plan, s->box, s->has_calibration && s->calibration.has_flat,
                                 &manifest, err);

    manifest.rehearsal = r == 0 && s->config->rehearse > 0;
    if (r == 0 && dataset_exists(s)) {
        r = ttf_writer_open(s->config->io, s->config->path, &s->committer.writer, err);
        if (r < 0)
            return r;
        state = ttf_writer_state(s->committer.writer);
        r = ttf_manifest_takes_plan(ttf_writer_manifest(s->committer.writer), &manifest, err);
    }
    if (r < 0)
        return r;
    keep_zone(&s->plan, state);
    r = resolve_grid(s, state, &utc, err);
    if (r == 0)
        r = resolve_local(s, state, &utc, err);
    if (r < 0)
        return r;
    if (s->resume.continued && state->next_index >= s->plan.count)
        /* Cut off before its seal: sealed now, whatever a local day resolves to this time. */
        return state->sealed ? expect_same_plan(s, state->n_plans, err) : 0;
    plan = dataset_with_plan(s, &manifest, err);
    if (plan < 0)
        return plan;
    r = write_segment(s, s->committer.writer, plan, &utc, err);
    if (r == 0 && s->has_calibration)
        r = ttf_writer_calibration(s->committer.writer, s->calibration.id,
                                   s->config->calibration_folder, err);
    return r;
}
