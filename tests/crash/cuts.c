/* SPDX-License-Identifier: Apache-2.0 */
#include "cuts.h"

#include <stdlib.h>
#include <string.h>

#include "judge.h"

bool cuts_seen(struct cuts *cuts, uint64_t hash)
{
    uint64_t *old = cuts->seen;
    size_t i, room = cuts->seen_room;

    hash += hash == 0;
    if (2 * cuts->seen_n >= room) {
        cuts->seen_room = room ? 2 * room : 4096;
        cuts->seen = calloc(cuts->seen_room, sizeof(*cuts->seen));
        if (!cuts->seen)
            abort();
        cuts->seen_n = 0;
        for (i = 0; i < room; i++)
            if (old[i])
                (void)cuts_seen(cuts, old[i]);
        free(old);
    }
    i = (hash ^ hash >> 32) & (cuts->seen_room - 1);
    for (; cuts->seen[i]; i = (i + 1) & (cuts->seen_room - 1))
        if (cuts->seen[i] == hash)
            return true;
    cuts->seen[i] = hash;
    cuts->seen_n++;
    return false;
}

void cuts_free(struct cuts *cuts)
{
    free(cuts->seen);
    cuts->seen = NULL;
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

void cuts_judge(struct cuts *cuts, const struct cuts_moment *moment, struct disk *after,
                disk_step_fn *then, void *then_ctx, struct run *judged)
{
    run_init(judged, after);
    judged->promise = *moment->promise;
    disk_on_step(after, then, then_ctx);
    cuts->counts.states++;
    cuts->counts.deeper += moment->before != NULL;
    judge_go_on(judged);
    disk_on_step(after, NULL, NULL);
    run_end(judged);
    cuts->counts.of[judged->fault]++;
    if (judged->fault == RUN_WELL || cuts->counts.of[RUN_WELL] + 10 < cuts->counts.states)
        return; /* the first ten are enough to look at */
    printf("broken: %s\n", judged->broken);
    if (cuts->states_most > 0)
        printf("  seed %llu, state %llu: crash random --seed %llu --states %llu\n",
               (unsigned long long)cuts->seed, (unsigned long long)cuts->state,
               (unsigned long long)cuts->seed, (unsigned long long)cuts->state);
    tell(moment);
    (void)fflush(stdout);
}
