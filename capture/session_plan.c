/* SPDX-License-Identifier: Apache-2.0 */
/* Which plan a run follows: that of the dataset's last segment, unless the one given is new. README.md, "Living runs". */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "lamp_programme.h"
#include "session_private.h"
#include "ttf/dataset/reader.h"

#define PLAN_MAX_BYTES (1 << 20)

static int read_plan(struct ttf_session *s, int number, struct ttf_plan *ret)
{
    char path[4096 + 32];
    char *text = NULL;
    size_t bytes;
    int r;

    snprintf(path, sizeof(path), "%s/plans/%d.json", s->path, number);
    r = ttf_io_slurp(s->config->io, path, PLAN_MAX_BYTES, &text, &bytes, NULL);
    if (r == 0)
        r = ttf_plan_read(text, bytes, path, ret, NULL);
    free(text);
    return r;
}

/*
 * The newest stored plan that asks for the same as the one given into *ret; -1: none. Whether one names its group.
 * -ENOMEM: who took that for "none" would change the plan of a run that is only to be gone on with.
 */
static int find_plan(struct ttf_session *s, int n_plans, int *ret)
{
    for (*ret = n_plans - 1; *ret >= 0; --*ret) {
        struct ttf_plan stored;
        int r = read_plan(s, *ret, &stored);

        if (r == 0) {
            s->names_group = s->names_group || strcmp(stored.group, s->plan.group) == 0;
            r = ttf_plan_same(&stored, &s->plan);
        }
        if (r == 1 || r == -ENOMEM)
            return r == 1 ? 0 : r;
    }
    return 0;
}

/* Of a dataset with so many plans, of which this one is in force. */
static int choose(struct ttf_session *s, int n_plans, int in_force, struct ttf_err *err)
{
    int given;
    int r = find_plan(s, n_plans, &given);

    if (r < 0)
        return ttf_err_set(err, r, s->path, "no memory to look for the plan given");
    s->known_plan = given;
    s->goes_on = given == in_force;
    if (given < 0)
        return 0; /* new: a change */
    if (given < in_force && !s->config->plan_as_given) {
        s->moved_on_from = given;
        s->known_plan = given = in_force;
        s->goes_on = true;
    }
    if (given < in_force)
        s->known_plan = -1; /* an old one again: a change too, with a number of its own */
    /* What was resolved once stays: the phase of its day, the zone's offset. */
    r = read_plan(s, given, &s->plan);
    if (r < 0)
        return ttf_err_set(err, r == -ENOMEM ? r : -EINVAL, s->path, "plans/%d.json cannot be read",
                           given);
    return 0;
}

int ttf_session_plan_in_force(struct ttf_session *s, struct ttf_err *err)
{
    struct ttf_reader *reader = NULL;
    struct ttf_segment last;
    int in_force = -1;
    int n_plans;
    int r;

    s->known_plan = s->moved_on_from = -1;
    if (s->config->rehearse > 0)
        return 0;
    r = ttf_reader_open(s->config->io, s->path, &reader, err);
    if (r == -ENOMEM)
        return r;
    if (r < 0) { /* new; or opening it for writing will say what is wrong with it */
        if (err)
            *err = (struct ttf_err){0};
        return 0;
    }
    n_plans = ttf_reader_summary(reader)->n_plans;
    if (ttf_reader_segment(reader, ttf_reader_summary(reader)->n_segments - 1, &last) == 0)
        in_force = last.plan;
    ttf_reader_close(reader);
    return n_plans > 0 ? choose(s, n_plans, in_force, err) : 0;
}

int ttf_session_resolve_phase(struct ttf_plan *plan, int64_t slot0_utc_ns, struct ttf_err *err)
{
    if (plan->lamps != TTF_LAMPS_PHOTOPERIOD || !plan->photoperiod_local)
        return 0;
    if (slot0_utc_ns == TTF_NS_UNKNOWN) {
        ttf_err_set(err, -EINVAL, "lamps.day_start",
                    "nobody vouches for this box's clock, so a local time means nothing");
        ttf_err_hint(err, "let the clock be set (the box's page offers it this PC's time; a "
                          "network or a battery-backed clock keeps it), or use lamps.phase");
        return -EINVAL;
    }
    plan->phase_ns = ttf_photoperiod_phase_ns(slot0_utc_ns, plan->zone_offset_s, plan->day_start_s);
    return 0;
}
