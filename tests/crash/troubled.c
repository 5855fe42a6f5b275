/* SPDX-License-Identifier: Apache-2.0 */
/* The fixed run with the disk failing once, or the program killed, at each step; then a power cut. */
#include <stdlib.h>

#include "cuts.h"
#include "judge.h"
#include "trouble.h"

/* What trouble left unsynced shows at the next calls, or is synced by them. */
#define CALLS_SINCE_MOST 6

struct troubled {
    struct trouble trouble;
    struct run run;
};

static int troubled_step(void *ctx, struct disk *disk, const char *op, const char *path)
{
    struct troubled *t = ctx;

    return trouble_step(&t->trouble, &t->run, op, path);
}

static void one_cut(struct cuts *cuts, struct run *run, const struct disk_kept *kept)
{
    struct cuts_moment moment = {run->disk, &run->promise, kept, "the next call", "", NULL};
    struct disk *after;
    struct run judged;

    if (cuts_stopped(cuts))
        return;
    after = disk_cut(run->disk, kept);
    cuts->counts.cuts++;
    if (!cuts_seen(cuts, after, &run->promise, 0))
        cuts_judge(cuts, &moment, after, JUDGE_BEFORE, NULL, NULL, &judged);
    disk_destroy(after);
}

/* Nothing that was not synced is there; or one effect alone. */
static void cut_here(struct cuts *cuts, struct run *run)
{
    struct disk_kept kept[DISK_EFFECTS_MAX] = {{0, 0}};
    unsigned i, n = disk_effects(run->disk);
    size_t bytes;

    cuts->counts.steps++;
    one_cut(cuts, run, kept);
    for (i = 0; i < n; i++) {
        bytes = disk_effect_bytes(run->disk, i);
        kept[i].to = (uint16_t)(bytes ? bytes : 1);
        one_cut(cuts, run, kept);
        kept[i].to = 0;
    }
}

/* False: the trouble never came, the run has fewer steps. */
static bool one_run(struct cuts *cuts, enum trouble_kind kind, unsigned at, bool begin_anew)
{
    struct troubled t = {.trouble = {.kind = kind, .at = at}};
    unsigned since = 0, i;
    bool came = false;

    snprintf(cuts->trouble, sizeof(cuts->trouble), "%s at step %u, then %s", trouble_name(kind), at,
             begin_anew ? "opened anew" : "gone on with");
    run_init(&t.run, run_fresh_disk());
    disk_fresh_blocks(t.run.disk, (enum disk_fresh)(at % (unsigned)cuts->fresh_kinds));
    disk_on_step(t.run.disk, troubled_step, &t);
    for (i = 0; i < cuts->n_steps && since < CALLS_SINCE_MOST && !t.run.broken[0]; i++) {
        if (t.run.writer || i == 0)
            (void)run_do(&t.run, cuts->steps[i]);
        came = came || t.trouble.kind == TROUBLE_NONE;
        if (!came || t.run.broken[0])
            continue;
        if (t.trouble.over && (begin_anew || !t.run.writer || trouble_killed(&t.run)))
            (void)trouble_begin_anew(&t.trouble, &t.run);
        cut_here(cuts, &t.run);
        since++;
    }
    if (t.run.broken[0])
        cuts_broken_uncut(cuts, &t.run);
    run_end(&t.run);
    disk_destroy(t.run.disk);
    return came;
}

void cuts_troubled(struct cuts *cuts)
{
    bool more = true;
    unsigned at;
    int kind;

    for (at = 1 + cuts->part; more && !cuts_stopped(cuts); at += cuts->parts * cuts->trouble_each)
        for (more = false, kind = TROUBLE_KILLED; kind < TROUBLE_KIND_COUNT; kind++) {
            more = one_run(cuts, (enum trouble_kind)kind, at, true) || more;
            if (kind != TROUBLE_KILLED)
                more = one_run(cuts, (enum trouble_kind)kind, at, false) || more;
        }
    cuts->trouble[0] = '\0';
}
