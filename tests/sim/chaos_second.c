/* SPDX-License-Identifier: Apache-2.0 */
/* The second storage of a run of chaos: how both fail, what cuts a move off, which disk is away. */
#include "chaos.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "second_run.h"
#include "ttf/base/attr.h"

/* ---- drawing ---- */

/* What the drawn faults of storage hit, now that there are two. */
static void draw_targets(struct chaos *c)
{
    for (unsigned i = 0; i < c->run.config.n_faults; i++) {
        struct ttf_fault *f = &c->run.config.faults[i];

        if (f->kind != TTF_FAULT_DISK_FULL && f->kind != TTF_FAULT_IO_ERROR &&
            f->kind != TTF_FAULT_READ_ONLY)
            continue;
        if (chaos_percent(c, 75))
            snprintf(f->target, sizeof(f->target), "%s", chaos_percent(c, 75) ? "first" : "second");
    }
}

static void draw_failing(struct chaos *c)
{
    struct chaos_second *s = &c->second;

    if (chaos_percent(c, 75))
        s->how[0] = (enum chaos_failing)chaos_between(c, 1, CHAOS_FAILING_COUNT - 1);
    s->from[0] = chaos_between(c, chaos_percent(c, 5) ? -1 : 0, c->run.plan.count - 1);
    if (s->how[0] == CHAOS_FAILS_ROOM)
        c->run.plan.reserve_bytes = 8 << 20;
    if (chaos_percent(c, 12))
        s->how[1] = (enum chaos_failing)chaos_between(c, 1, CHAOS_FAILS_ROOM - 1);
    s->from[1] = s->from[0] + chaos_between(c, -2, 5);
    s->mended_after = (unsigned)chaos_below(c, 4);
    s->mended_when_left = chaos_percent(c, 50);
}

/* Close to when the first storage fails: killed at any operation of the move, power gone before or after it. */
static void draw_cuts(struct chaos *c)
{
    struct chaos_second *s = &c->second;
    int64_t interval = c->run.plan.interval_ns;

    for (unsigned i = 0; i < CHAOS_MOVE_KILLS; i++)
        s->kills[i] = chaos_percent(c, 35) ? (int)chaos_between(c, 0, 60) : -1;
    if (chaos_percent(c, 35) && c->run.config.n_faults < TTF_SIM_FAULTS_MAX)
        c->run.config.faults[c->run.config.n_faults++] = (struct ttf_fault){
            .kind = TTF_FAULT_POWER_CUT,
            .at_ns = 12 * TTF_NS_PER_S + (s->from[0] + 1) * interval +
                     chaos_between(c, -interval, 2 * interval),
            .amount = chaos_between(c, 1, 1 + 3 * interval / TTF_NS_PER_S),
        };
    if (chaos_percent(c, 30)) /* and it begins once more, there */
        c->stop_at[0] = s->from[0] + chaos_between(c, 1, 4);
    s->fail_in_move = chaos_percent(c, 20) ? (int)chaos_between(c, 0, 40) : -1;
    s->gone_from = (unsigned)chaos_below(c, 2);
    s->gone_for = chaos_percent(c, 40) ? 1 + (unsigned)chaos_below(c, 4) : 0;
    s->unmounted_at = chaos_percent(c, 15) ? (int)chaos_between(c, 1, 4) : -1;
}

/* Some of what people ask they ask about then. */
static void draw_asks(struct chaos *c)
{
    for (unsigned i = 0; i < c->n_asks; i++) {
        struct chaos_ask *a = &c->asks[i];

        if (!chaos_percent(c, 50))
            continue;
        a->at = c->second.from[0] + chaos_between(c, -2, 2);
        if (a->at < -1)
            a->at = -1;
        if (a->ask.from_index > 0)
            a->ask.from_index = a->at + 1 + (int64_t)chaos_below(c, 3);
    }
}

/* Whether anything of what was drawn is of this storage. */
static bool troubled(const struct chaos *c, unsigned storage)
{
    static const char *const other[2] = {"second", "first"};

    for (unsigned i = 0; i < c->run.config.n_faults; i++) {
        const struct ttf_fault *f = &c->run.config.faults[i];

        if ((f->kind == TTF_FAULT_DISK_FULL || f->kind == TTF_FAULT_IO_ERROR ||
             f->kind == TTF_FAULT_READ_ONLY) &&
            strcmp(f->target, other[storage]) != 0)
            return true;
    }
    return c->fail_at >= 0 || (storage == 0 && c->full_from >= 0) ||
           c->second.how[storage] != CHAOS_FAILS_NOT;
}

void chaos_second_draw(struct chaos *c)
{
    c->second.kills[0] = c->second.kills[1] = c->second.fail_in_move = -1;
    c->second.unmounted_at = -1;
    c->second.named = chaos_percent(c, 45);
    if (c->second.named) {
        second_run_make(&c->run);
        draw_targets(c);
        draw_failing(c);
        draw_cuts(c);
        draw_asks(c);
    }
    for (unsigned storage = 0; storage < 2; storage++)
        c->troubled[storage] = troubled(c, storage);
    c->troubled[1] |= c->second.fail_in_move >= 0;
}

void chaos_second_describe(const struct chaos *c)
{
    static const char *const names[CHAOS_FAILING_COUNT] = {
        "not",         "by its syncs", "by images", "by records",
        "with errors", "full",         "read-only", "with no room"};
    const struct chaos_second *s = &c->second;

    if (!s->named)
        return;
    printf("  second storage: the first fails %s once %lld is told, it %s once %lld is; mended "
           "after %u%s; "
           "killed %d and %d operations into a move, %d fails; the first gone from %u for %u; "
           "unmounted in run %d\n",
           names[s->how[0]], (long long)s->from[0], names[s->how[1]], (long long)s->from[1],
           s->mended_after, s->mended_when_left ? " or when left" : "", s->kills[0], s->kills[1],
           s->fail_in_move, s->gone_from, s->gone_for, s->unmounted_at);
}

/* ---- while a run lives ---- */

/* An operation in the second storage, as long as the run is not known to be gone on with there: 0, or what it fails with. */
static int in_move(struct chaos *c)
{
    struct chaos_second *s = &c->second;
    const int n = (int)s->operations++;

    if (s->n_kills < CHAOS_MOVE_KILLS && n == s->kills[s->n_kills]) {
        s->n_kills++;
        chaos_kill(c);
    }
    if (n != s->fail_in_move)
        return 0;
    s->fail_in_move = -1;
    return EIO;
}

static int answer(enum chaos_failing how, const char *op, const char *path)
{
    switch (how) {
    case CHAOS_FAILS_SYNC:
        return strncmp(op, "sync", 4) == 0 ? EIO : 0;
    case CHAOS_FAILS_FRAMES:
        return strstr(path, "/frames/") ? EIO : 0;
    case CHAOS_FAILS_RECORDS:
        return sim_run_path_ends(path, "/records.jsonl") ? EIO : 0;
    case CHAOS_FAILS_IO:
        return EIO;
    case CHAOS_FAILS_FULL:
        return strcmp(op, "unlink") == 0 || strcmp(op, "truncate") == 0 ? 0 : ENOSPC;
    case CHAOS_FAILS_READ_ONLY:
        return EROFS;
    default:
        return 0;
    }
}

int chaos_second_fault(struct sim_run *run, const char *op, const char *path)
{
    struct chaos *c = (struct chaos *)run;
    const unsigned storage = second_run_holds(path);

    if (!c->second.named)
        return 0;
    if (!c->second.begun && strstr(path, "/second/dataset") && in_move(c) != 0)
        return EIO;
    return c->told >= c->second.from[storage] ? answer(c->second.how[storage], op, path) : 0;
}

bool chaos_second_no_room(const struct chaos *c)
{
    return c->second.how[0] == CHAOS_FAILS_ROOM && c->told >= c->second.from[0];
}

/* ---- between runs ---- */

static void away(const char *path, bool back)
{
    char other[sizeof(((struct ttf_plan *)0)->second_storage) + 8];

    snprintf(other, sizeof(other), "%s.away", path);
    (void)rename(back ? other : path, back ? path : other);
}

static void mount_second(const struct chaos *c, bool back)
{
    away(c->run.plan.second_storage, back);
}

/* Who has no first dataset needs no second one to go on beside it. And one that is sealed was never gone on from. */
static bool can_be_unmounted(struct chaos *c)
{
    struct chaos_parts parts;
    bool open_end;

    if (c->second.gone || !chaos_part_exists(c, 0) || !chaos_parts_open(c, &parts))
        return false;
    open_end = parts.n > 0 && !ttf_reader_summary(parts.part[0].reader)->sealed &&
               ttf_reader_summary(parts.part[0].reader)->n_segments > 0;
    chaos_parts_close(&parts);
    return open_end;
}

/* A dataset that is sealed there, beside none, is rather another one by this name: who has the first brings it back. */
static bool sealed_there(const struct chaos *c)
{
    struct stat st;
    char path[160], dataset[128];

    chaos_part_path(c, 1, dataset);
    snprintf(path, sizeof(path), "%s/SHA256SUMS", dataset);
    return stat(path, &st) == 0;
}

void chaos_second_before(struct chaos *c)
{
    struct chaos_second *s = &c->second;
    bool gone;

    s->operations = 0;
    if (!s->named)
        return;
    gone = s->begun && s->began >= s->gone_from && s->began < s->gone_from + s->gone_for &&
           !sealed_there(c);
    if (gone != s->gone)
        away(c->run.path, s->gone);
    s->gone = gone;
    if (s->unmounted_at >= 0 && (unsigned)s->unmounted_at <= c->n_boots && can_be_unmounted(c))
        mount_second(c, false);
    else if (s->begun)
        s->began++;
}

void chaos_second_over(struct chaos *c)
{
    if (c->second.gone)
        away(c->run.path, true);
    c->second.gone = false;
}

bool chaos_second_was_unmounted(struct chaos *c)
{
    struct stat st;

    if (!c->second.named || stat(c->run.plan.second_storage, &st) == 0)
        return false;
    c->second.unmounted_at = -1;
    if ((c->run.code != -EINVAL && c->run.code != -ENODEV) ||
        strcmp(c->run.err.where, "storage.second") != 0)
        chaos_fail(c, "without its second storage it ended with %d: %s: %s", c->run.code,
                   c->run.err.where, c->run.err.what);
    mount_second(c, true);
    return true;
}

static void mend(struct chaos *c, unsigned storage)
{
    static const char *const names[2] = {"first", "second"};
    struct ttf_sim_config *b = &c->run.config;

    c->second.how[storage] = CHAOS_FAILS_NOT;
    c->run.free_bytes =
        storage == 0 && c->run.free_bytes > 0 ? (int64_t)1 << 32 : c->run.free_bytes;
    for (unsigned i = 0; i < b->n_faults; i++)
        if (b->faults[i].kind == TTF_FAULT_READ_ONLY &&
            strcmp(b->faults[i].target, names[storage]) == 0)
            b->faults[i--] = b->faults[--b->n_faults];
}

void chaos_second_after(struct chaos *c)
{
    struct chaos_second *s = &c->second;

    if (!s->named)
        return;
    if (s->begun && s->mended_when_left)
        mend(c, 0);
    if (c->run.code == 0 || c->run.code == -ESHUTDOWN || s->mended_after-- > 0)
        return;
    s->mended_after = 1;
    mend(c, 0);
    mend(c, 1);
}
