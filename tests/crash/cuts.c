/* SPDX-License-Identifier: Apache-2.0 */
#include "cuts.h"

#include <stdlib.h>
#include <string.h>

#include "judge.h"

static uint64_t state_hash(const struct disk *disk, const struct run_promise *promise)
{
    const unsigned char *at = (const unsigned char *)promise;
    uint64_t hash = disk_hash(disk);
    size_t i;

    for (i = 0; i < sizeof(*promise); i++)
        hash = (hash ^ at[i]) * UINT64_C(0x100000001b3);
    return hash ^ hash >> 31;
}

/* What was judged as a first cut was cut again everywhere: as a second one there is nothing more to it. */
bool cuts_seen(struct cuts *cuts, const struct disk *disk, const struct run_promise *promise,
               unsigned level)
{
    uint64_t hash = state_hash(disk, promise);

    if (level > 0 && seen_has(cuts->seen, hash))
        return true;
    return !seen_add(cuts->seen, level > 0 ? hash * UINT64_C(0x9e3779b97f4a7c15) + level : hash);
}

bool cuts_stopped(const struct cuts *cuts)
{
    return cuts->stop_at_first && cuts->counts.of[RUN_WELL] < cuts->counts.states;
}

/* What the disk kept and what it lost, and the same of the cut before. */
static void tell(const struct cuts_moment *m)
{
    char text[220];
    unsigned i;
    size_t bytes;

    if (m->before)
        tell(m->before);
    printf("  cut %s %s %s\n", m->before ? "in the recovery, before" : "before", m->op, m->path);
    for (i = 0; i < disk_effects(m->disk); i++) {
        disk_effect_text(m->disk, i, text, sizeof(text));
        bytes = disk_effect_bytes(m->disk, i);
        if (m->kept[i].to <= m->kept[i].from)
            printf("    lost  %s\n", text);
        else if (bytes == 0 || (m->kept[i].from == 0 && m->kept[i].to == bytes))
            printf("    kept  %s\n", text);
        else
            printf("    torn  %s: kept %u..%u of it\n", text, m->kept[i].from, m->kept[i].to);
    }
}

/* Where it was, so that it can be found again. */
static void tell_where(const struct cuts *cuts)
{
    if (cuts->states_most > 0)
        printf("  seed %llu, state %llu: crash random --seed %llu --states %llu --processes 1\n",
               (unsigned long long)cuts->seed, (unsigned long long)cuts->state,
               (unsigned long long)cuts->seed, (unsigned long long)cuts->state);
    if (cuts->trouble[0])
        printf("  first: %s\n", cuts->trouble);
}

/* The first ten are enough to look at. */
static bool to_be_told(struct cuts *cuts, const struct run *run)
{
    cuts->counts.states++;
    cuts->counts.of[run->fault]++;
    if (run->fault == RUN_WELL || cuts->counts.of[RUN_WELL] + 10 < cuts->counts.states)
        return false;
    printf("broken: %s\n", run->broken);
    tell_where(cuts);
    return true;
}

void cuts_broken_uncut(struct cuts *cuts, const struct run *run)
{
    if (to_be_told(cuts, run))
        printf("  without a cut\n");
}

void cuts_judge(struct cuts *cuts, const struct cuts_moment *moment, struct disk *after,
                unsigned looks, disk_step_fn *then, void *then_ctx, struct run *judged)
{
    run_init(judged, after);
    judged->promise = *moment->promise;
    disk_on_step(after, then, then_ctx);
    cuts->counts.deeper += moment->before != NULL;
    judge_go_on(judged, looks);
    disk_on_step(after, NULL, NULL);
    run_end(judged);
    if (to_be_told(cuts, judged))
        tell(moment);
    (void)fflush(stdout);
}
