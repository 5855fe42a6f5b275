/* SPDX-License-Identifier: Apache-2.0 */
/* All cuts of a fixed run, and all cuts of the recoveries from them. */
#include <stdlib.h>
#include <string.h>

#include "cuts.h"
#include "judge.h"

/* One run, or one recovery, that is being cut at each of its steps. */
struct watch {
    struct cuts *cuts;
    struct run *run;
    unsigned level; /* 0: the run; 1: a recovery */
    const struct cuts_moment *before;
    uint64_t step; /* counted through all kinds of old blocks */
};

static int watch_step(void *ctx, struct disk *disk, const char *op, const char *path);

static void one_cut(struct watch *w, const struct disk *disk, const struct disk_kept *kept,
                    const char *op, const char *path)
{
    struct cuts_moment moment = {disk, &w->run->promise, kept, op, path, w->before};
    struct cuts *cuts = w->cuts;
    bool deeper = w->level + 1 < cuts->depth;
    struct watch next;
    struct run judged;
    struct disk *after;
    unsigned looks;

    if (cuts_stopped(cuts))
        return;
    after = disk_cut(disk, kept);
    cuts->counts.cuts++;
    if (!cuts_seen(cuts, after, moment.promise, w->level)) {
        next = (struct watch){cuts, &judged, w->level + 1, &moment, 0};
        looks = JUDGE_BEFORE | (cuts->counts.states % cuts->between_of ? 0 : JUDGE_BETWEEN);
        cuts_judge(cuts, &moment, after, looks, deeper ? watch_step : NULL, &next, &judged);
    }
    disk_destroy(after);
}

struct choice {
    struct watch *watch;
    const struct disk *disk;
    const char *op, *path;
    unsigned n;
    struct disk_kept kept[DISK_EFFECTS_MAX];
};

static void keep(struct choice *c, unsigned i, bool kept)
{
    size_t bytes = disk_effect_bytes(c->disk, i);

    c->kept[i] = (struct disk_kept){0, (uint16_t)(!kept ? 0 : bytes ? bytes : 1)};
}

static void keep_from_to(struct choice *c, unsigned from, unsigned to, bool kept)
{
    unsigned i;

    for (i = 0; i < c->n; i++)
        keep(c, i, (i >= from && i < to) == kept);
}

static void cut(struct choice *c)
{
    one_cut(c->watch, c->disk, c->kept, c->op, c->path);
}

static void all_subsets(struct choice *c)
{
    uint64_t set;
    unsigned i;

    for (set = 0; set < UINT64_C(1) << c->n; set++) {
        for (i = 0; i < c->n; i++)
            keep(c, i, set >> i & 1);
        cut(c);
    }
}

/* None, all, each alone, all but each, the first and the last so many, and the pairs. */
static void some_subsets(struct choice *c, bool pairs)
{
    unsigned i, k;
    int kept;

    for (i = 0; i <= c->n; i++) {
        keep_from_to(c, 0, i, true);
        cut(c);
        keep_from_to(c, 0, i, false);
        cut(c);
    }
    for (kept = 0; kept < 2; kept++)
        for (i = 0; i < c->n; i++) {
            keep_from_to(c, i, i + 1, kept);
            cut(c);
            for (k = i + 1; pairs && k < c->n; k++) {
                keep_from_to(c, i, i + 1, kept);
                keep(c, k, kept);
                cut(c);
            }
        }
}

/* Both sides of a tear, in company of nothing, of all before it, of all. */
static void tear(struct choice *c, unsigned i, uint16_t at, uint16_t bytes)
{
    unsigned company;

    for (company = 0; company < 3; company++) {
        keep_from_to(c, 0, company == 0 ? 0 : company == 1 ? i : c->n, true);
        /* A file's length came before the bytes: else nobody sees them. */
        if (company == 0 && i > 0)
            keep(c, i - 1, true);
        c->kept[i] = (struct disk_kept){0, at};
        cut(c);
        c->kept[i] = (struct disk_kept){at, bytes};
        cut(c);
    }
}

static void all_tears(struct choice *c, unsigned step)
{
    unsigned i, at;
    size_t bytes;

    for (i = 0; i < c->n; i++) {
        bytes = disk_effect_bytes(c->disk, i);
        for (at = 1; at < bytes; at = at == 1 ? step : at + step)
            tear(c, i, (uint16_t)at, (uint16_t)bytes);
        if (bytes > 2)
            tear(c, i, (uint16_t)(bytes - 1), (uint16_t)bytes);
    }
}

static int watch_step(void *ctx, struct disk *disk, const char *op, const char *path)
{
    struct watch *w = ctx;
    const struct cuts_bounds *bounds = &w->cuts->bounds[w->level];
    struct choice c = {.watch = w, .disk = disk, .op = op, .path = path};

    w->step++;
    if (w->level == 0 && !seen_claim(w->cuts->seen, w->step))
        return 0;
    w->cuts->counts.steps++;
    c.n = disk_effects(disk);
    if (c.n <= bounds->subset_bits)
        all_subsets(&c);
    else
        some_subsets(&c, bounds->pairs);
    all_tears(&c, bounds->tear_step);
    return 0;
}

static void one_run(struct cuts *cuts, enum disk_fresh fresh, uint64_t *step)
{
    struct watch watch = {.cuts = cuts, .step = *step};
    struct disk *disk = run_fresh_disk();
    struct run run;
    size_t i;

    run_init(&run, disk);
    watch.run = &run;
    disk_fresh_blocks(disk, fresh);
    disk_on_step(disk, watch_step, &watch);
    for (i = 0; i < cuts->n_steps && run_do(&run, cuts->steps[i]); i++)
        ;
    if (run.broken[0])
        cuts_broken_uncut(cuts, &run);
    else
        (void)watch_step(&watch, disk, "the end", "");
    *step = watch.step;
    run_end(&run);
    disk_destroy(disk);
}

void cuts_exhaustive(struct cuts *cuts)
{
    uint64_t step = 0;

    for (int fresh = 0; fresh < cuts->fresh_kinds; fresh++)
        one_run(cuts, (enum disk_fresh)fresh, &step);
}
