/* SPDX-License-Identifier: Apache-2.0 */
/* Runs, faults and cuts drawn from a seed. */
#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "choose.h"
#include "cuts.h"
#include "judge.h"
#include "trouble.h"

#define STATES_OF_A_RUN 200 /* so that finding one again is quick */

struct drawn_run {
    struct cuts *cuts;
    struct run run;
    struct draw draw;
    uint64_t states_left; /* of this run */
    struct trouble trouble;
    unsigned cut_percent;
};

struct drawn_recovery {
    struct drawn_run *of;
    struct run *judged;
    const struct cuts_moment *before;
};

static int recovery_step(void *ctx, struct disk *disk, const char *op, const char *path);

static void cut_here(struct drawn_run *d, struct disk *disk, const struct run_promise *promise,
                     const char *op, const char *path, const struct cuts_moment *before)
{
    struct disk_kept kept[DISK_EFFECTS_MAX];
    struct cuts_moment moment = {disk, promise, kept, op, path, before};
    struct run judged;
    struct drawn_recovery next = {d, &judged, &moment};
    struct disk *after;
    unsigned looks;

    if (d->states_left == 0)
        return;
    d->states_left--;
    d->cuts->state++;
    d->cuts->counts.cuts++;
    choose_kept(&d->draw, disk, kept);
    after = disk_cut(disk, kept);
    looks = (draw_below(&d->draw, 2) ? JUDGE_BEFORE : 0) |
            (draw_below(&d->draw, d->cuts->between_of) ? 0 : JUDGE_BETWEEN);
    cuts_judge(d->cuts, &moment, after, looks, before ? NULL : recovery_step, &next, &judged);
    disk_destroy(after);
}

/* One in so many steps of a recovery is cut again: about one a recovery. */
static int recovery_step(void *ctx, struct disk *disk, const char *op, const char *path)
{
    struct drawn_recovery *r = ctx;

    if (draw_below(&r->of->draw, 64) == 0)
        cut_here(r->of, disk, &r->judged->promise, op, path, r->before);
    return 0;
}

static int run_step_comes(void *ctx, struct disk *disk, const char *op, const char *path)
{
    struct drawn_run *d = ctx;

    while (d->states_left > 0 && draw_below(&d->draw, 100) < d->cut_percent)
        cut_here(d, disk, &d->run.promise, op, path, NULL);
    return trouble_step(&d->trouble, &d->run, op, path);
}

static enum run_step draw_step(struct draw *draw)
{
    static const enum run_step steps[] = {
        RUN_SEGMENT,   RUN_CORRECT,  RUN_PLAN,     RUN_CALIBRATE, RUN_SLOT_ONE,
        RUN_SLOT_ONE,  RUN_SLOT_TWO, RUN_SLOT_TWO, RUN_SLOT_PAIR, RUN_SLOT_PAIR,
        RUN_SLOT_NONE, RUN_EVENT,    RUN_EVENT,    RUN_NOTE,      RUN_NOTE,
        RUN_SAMPLE,    RUN_SEAL,     RUN_REOPEN,   RUN_ABANDON,
    };

    return steps[draw_below(draw, sizeof(steps) / sizeof(steps[0]))];
}

static void one_run(struct cuts *cuts)
{
    static const enum trouble_kind troubles[] = {TROUBLE_NONE,   TROUBLE_NONE, TROUBLE_KILLED,
                                                 TROUBLE_KILLED, TROUBLE_SYNC, TROUBLE_STEP,
                                                 TROUBLE_FULL};
    struct drawn_run *d = calloc(1, sizeof(*d));
    unsigned i, n;
    bool well;

    if (!d)
        abort();
    d->cuts = cuts;
    draw_seed(&d->draw, cuts->seed);
    d->states_left = STATES_OF_A_RUN;
    if (d->states_left > cuts->states_most - cuts->counts.states)
        d->states_left = cuts->states_most - cuts->counts.states;
    d->trouble.kind = troubles[draw_below(&d->draw, 7)];
    d->trouble.at = (unsigned)draw_below(&d->draw, 250);
    d->cut_percent = (unsigned)draw_below(&d->draw, 50);
    n = 5 + (unsigned)draw_below(&d->draw, 20);
    run_init(&d->run, run_fresh_disk());
    disk_fresh_blocks(d->run.disk,
                      (enum disk_fresh)draw_below(&d->draw, (uint64_t)cuts->fresh_kinds));
    disk_on_step(d->run.disk, run_step_comes, d);
    well = run_do(&d->run, RUN_CREATE);
    for (i = 0; i < n && d->states_left > 0 && !d->run.broken[0] && (well || d->trouble.over);
         i++) {
        if (d->trouble.over)
            well = (!trouble_killed(&d->run) && d->run.writer && draw_below(&d->draw, 2)) ||
                   trouble_begin_anew(&d->trouble, &d->run);
        if (d->run.writer && !d->run.broken[0])
            well = run_do(&d->run, draw_step(&d->draw));
    }
    while (d->states_left > 0 && !d->run.broken[0])
        cut_here(d, d->run.disk, &d->run.promise, "the end", "", NULL);
    if (d->run.broken[0])
        cuts_broken_uncut(cuts, &d->run);
    cuts->counts.steps += d->trouble.step;
    run_end(&d->run);
    disk_destroy(d->run.disk);
    free(d);
}

void cuts_random(struct cuts *cuts)
{
    cuts->seed += cuts->part;
    while (cuts->counts.states < cuts->states_most && !cuts_stopped(cuts)) {
        cuts->state = 0;
        one_run(cuts);
        cuts->seed += cuts->parts;
    }
}
