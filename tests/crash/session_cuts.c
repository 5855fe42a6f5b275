/* SPDX-License-Identifier: Apache-2.0 */
#include "session_cuts.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "session_judge.h"

#define OUTAGE_NS  TTF_NS_PER_MIN
#define DEPTH_MOST 3
#define TEXT_BYTES 400
#define BOOTS_MOST 6 /* of a run without a cut */

/* A disk that a cut has left. */
struct state {
    struct disk *disk;
    struct session_promise promise;
    int64_t elapsed_ns; /* when it was cut */
    char text[TEXT_BYTES];
};

struct session_boot {
    struct session_cuts *cuts;
    const struct session_plan *plan;
    struct session_trouble trouble;
    struct session_box box;
    struct disk *disk; /* owned */
    struct locked_io locked;
    unsigned depth;   /* cuts before this boot */
    int newest;       /* of the living's plans, that people have by now */
    const char *text; /* of the cut before; NULL */
    const struct session_boot *before;
    uint64_t step;
    struct state *states;
    size_t n_states, states_room;
    bool cutting;
};

struct disk *session_fresh_disk(void)
{
    struct disk *disk = disk_create("/data");
    struct ttf_io *io = disk_io(disk);

    disk_hollow(disk, ".events-reserve");
    if (io->ops->mkdir(io, SESSION_SECOND) != 0 || io->ops->sync_dir(io, "/") != 0)
        abort();
    return disk;
}

/* ---- what is wrong ---- */

static void tell_boot(const struct session_boot *b)
{
    if (b->before)
        tell_boot(b->before);
    if (b->text)
        printf("  cut %s\n", b->text);
}

static void tell_living(const struct session_boot *b)
{
    const struct living *living = b->box.living;

    if (!living)
        return;
    printf("  by plan %d of %u; asked (kind, slot):", b->box.given, living->n_plans);
    for (unsigned i = 0; i < living->n_asks; i++)
        printf(" %s%d,%lld", b->box.asks & UINT32_C(1) << i ? "" : "not ",
               (int)living->asks[i].kind, (long long)living->asks[i].from_index);
    printf("\n");
}

static void tell(struct session_boot *b)
{
    struct session_cuts *cuts = b->cuts;

    if (!b->box.broken[0])
        return;
    if (cuts->counts.broken++ >= 10)
        return;
    printf("broken: %s\n  %lld slots%s, trouble %d from step %llu to %llu%s\n", b->box.broken,
           (long long)b->plan->slots, b->plan->second ? ", second storage" : "",
           (int)b->plan->trouble.kind, (unsigned long long)b->plan->trouble.from,
           (unsigned long long)b->plan->trouble.until,
           b->plan->trouble.first_only ? " in the first" : "");
    tell_living(b);
    if (cuts->seed)
        printf("  crash_session random --seed %llu --states 1 --processes 1\n",
               (unsigned long long)cuts->seed);
    tell_boot(b);
    (void)fflush(stdout);
}

bool session_cuts_stopped(const struct session_cuts *cuts)
{
    return cuts->stop_at_first && cuts->counts.broken > 0;
}

/* ---- cutting: called by the disk, with its lock held ---- */

static uint64_t state_hash(const struct disk *disk, const struct session_promise *promise)
{
    const unsigned char *at = (const unsigned char *)promise;
    uint64_t hash = disk_hash(disk);
    size_t i;

    for (i = 0; i < sizeof(*promise); i++)
        hash = (hash ^ at[i]) * UINT64_C(0x100000001b3);
    return hash ^ hash >> 31;
}

static void add_state(struct session_boot *b, const struct disk_kept *kept, unsigned n_kept,
                      const char *op, const char *path)
{
    struct session_cuts *cuts = b->cuts;
    struct disk *after = disk_cut(b->disk, kept);
    struct state *state;

    cuts->counts.cuts++;
    if (cuts->seen && !seen_add(cuts->seen, state_hash(after, &b->box.promise))) {
        disk_destroy(after);
        return;
    }
    if (b->n_states == b->states_room) {
        b->states_room = b->states_room ? 2 * b->states_room : 64;
        b->states = reallocarray(b->states, b->states_room, sizeof(*b->states));
        if (!b->states)
            abort();
    }
    state = &b->states[b->n_states++];
    state->disk = after;
    state->promise = b->box.promise;
    state->elapsed_ns = b->box.box ? session_box_elapsed_ns(&b->box) : b->box.ended_ns;
    snprintf(state->text, sizeof(state->text), "before step %llu, %s %s, %u of %u effects kept",
             (unsigned long long)b->step, op, path, n_kept, disk_effects(b->disk));
}

static void keep_from_to(struct session_boot *b, unsigned from, unsigned to, const char *op,
                         const char *path)
{
    struct disk_kept kept[DISK_EFFECTS_MAX] = {{0, 0}};
    size_t bytes;
    unsigned i;

    for (i = from; i < to; i++) {
        bytes = disk_effect_bytes(b->disk, i);
        kept[i].to = (uint16_t)(bytes ? bytes : 1);
    }
    add_state(b, kept, to - from, op, path);
}

static void cut_everywhere(struct session_boot *b, const char *op, const char *path)
{
    unsigned n = disk_effects(b->disk), k;

    if (b->depth > 0 || b->step % b->cuts->parts != b->cuts->part)
        return;
    keep_from_to(b, 0, n, op, path);
    for (k = 0; k < n; k++) {
        if (k > 0 && (k + b->step) % b->cuts->each != 0)
            continue;
        keep_from_to(b, 0, k, op, path);
        keep_from_to(b, k, n, op, path);
    }
}

static void cut_at_random(struct session_boot *b, const char *op, const char *path)
{
    struct disk_kept kept[DISK_EFFECTS_MAX];
    struct session_cuts *cuts = b->cuts;
    unsigned i, n = 0;

    if (b->depth >= DEPTH_MOST || cuts->states_left == 0)
        return;
    /* Of a run that was resumed, about one cut. */
    if (draw_below(&cuts->draw, 1000) >= (b->depth ? 4 : b->plan->cut_permille))
        return;
    cuts->states_left--;
    choose_kept(&cuts->draw, b->disk, kept);
    for (i = 0; i < disk_effects(b->disk); i++)
        n += kept[i].to > kept[i].from;
    add_state(b, kept, n, op, path);
}

static int trouble_comes(struct session_boot *b, const char *op, const char *path)
{
    static const int errors[SESSION_TROUBLE_COUNT] = {0, -EIO, -ENOSPC, -EROFS, -EIO};
    struct session_trouble *t = &b->trouble;

    if (t->kind == SESSION_SOUND || b->step < t->from || b->step >= t->until ||
        (t->first_only && strncmp(path, "/data", 5) != 0))
        return 0;
    if (t->kind == SESSION_SYNC_FAILS) {
        if (strcmp(op, "sync") != 0)
            return 0;
        disk_lose_dirty(b->disk, path);
    }
    t->came = true;
    b->box.promise.troubled = true;
    return errors[t->kind];
}

static int step_comes(void *ctx, struct disk *disk, const char *op, const char *path)
{
    struct session_boot *b = ctx;

    (void)disk;
    b->step++;
    session_box_hear(&b->box);
    if (b->cutting && b->cuts->everywhere)
        cut_everywhere(b, op, path);
    else if (b->cutting)
        cut_at_random(b, op, path);
    return trouble_comes(b, op, path);
}

/* ---- boots ---- */

static void judge_state(const struct session_boot *of, struct state *state);

/* On a sound disk it ends well; on one that fails it may stop, with a word. */
static void judge_end(struct session_boot *b)
{
    struct session_box *s = &b->box;

    if (!b->trouble.came) {
        session_look_whole(s);
        return;
    }
    b->cuts->counts.troubled++;
    b->cuts->counts.ended_early += s->code < 0;
    if (s->code < 0 && s->err.what[0] == '\0')
        session_box_break(s, "it stops (%d) and does not say why", s->code);
    else if (s->code < 0 && s->armed && s->alarms == 0)
        session_box_break(s, "it stops without an alarm: %s: %s", s->err.where, s->err.what);
    session_look(s, &s->promise);
}

static void boot(struct session_boot *b)
{
    size_t i;

    b->cuts->counts.boots++;
    b->cuts->counts.asked += b->box.asks != 0;
    locked_io_init(&b->locked, disk_io(b->disk));
    b->box.io = &b->locked.io;
    b->box.read_back = true;
    disk_on_step(b->disk, step_comes, b);
    session_box_boot(&b->box);
    (void)step_comes(b, b->disk, "the end", "");
    disk_on_step(b->disk, NULL, NULL);
    b->cuts->counts.moved += b->box.result.second_storage;
    judge_end(b);
    tell(b);
    for (i = 0; i < b->n_states; i++)
        judge_state(b, &b->states[i]);
    free(b->states);
    b->states = NULL;
    b->n_states = b->states_room = 0;
    locked_io_free(&b->locked);
}

/* The next one, on this disk, which it takes. */
static struct session_boot *next_boot(const struct session_boot *before, struct disk *disk,
                                      int64_t power_on_ns)
{
    struct session_boot *b = malloc(sizeof(*b));

    if (!b)
        abort();
    *b = *before;
    b->before = before;
    b->text = NULL;
    b->disk = disk;
    b->step = 0;
    b->states = NULL;
    b->n_states = b->states_room = 0;
    b->trouble = (struct session_trouble){.kind = SESSION_SOUND};
    b->box.power_on_ns = power_on_ns;
    return b;
}

/* Somebody starts it again: by its first plan or by the newest one, and asks again for what was not done, or not. */
static void choose_start(struct session_boot *b)
{
    struct session_cuts *cuts = b->cuts;
    struct session_box *s = &b->box;
    uint64_t how;
    int given;

    if (!s->living)
        return;
    how = cuts->everywhere ? cuts->counts.states % 3 : draw_below(&cuts->draw, 3);
    given = how == 0 || s->given > 0 ? b->newest : 0;
    /* Refused where that plan has fewer slots than there are already. */
    if (s->living->plans[given].count <= s->promise.n_slots + 1)
        given = s->given;
    session_box_go_on(s, given, how == 1);
}

static void end_boot(struct session_boot *b)
{
    disk_destroy(b->disk);
    free(b);
}

static void judge_state(const struct session_boot *of, struct state *state)
{
    struct session_cuts *cuts = of->cuts;
    struct session_boot *b;

    if (session_cuts_stopped(cuts)) {
        disk_destroy(state->disk);
        return;
    }
    cuts->counts.states++;
    cuts->counts.deeper += of->depth > 0;
    b = next_boot(of, state->disk, state->elapsed_ns + OUTAGE_NS);
    b->text = state->text;
    b->depth = of->depth + 1;
    b->box.promise = state->promise;
    b->box.broken[0] = '\0';
    /* The storage that failed fails again, or is sound. */
    if (!cuts->everywhere && of->plan->second && of->trouble.came && of->trouble.first_only &&
        of->trouble.until == UINT64_MAX && draw_below(&cuts->draw, 2) == 0) {
        b->trouble = of->trouble;
        b->trouble.from = 1;
        b->trouble.came = false;
    }
    locked_io_init(&b->locked, disk_io(b->disk));
    b->box.io = &b->locked.io;
    session_look(&b->box, &of->box.promise);
    locked_io_free(&b->locked);
    if (b->box.broken[0]) {
        tell(b);
    } else {
        choose_start(b);
        boot(b);
    }
    end_boot(b);
}

/* ---- a run ---- */

static void make_living(struct living *living, const struct session_plan *plan,
                        struct session_cuts *cuts, struct ttf_plan base)
{
    if (plan->days) {
        base.lamps = TTF_LAMPS_PHOTOPERIOD;
        base.day_ns = 2 * TTF_NS_PER_MIN;
        base.period_ns = 4 * TTF_NS_PER_MIN;
        base.n_day_levels = 1;
        snprintf(base.day_levels[0].lamp, sizeof(base.day_levels[0].lamp), "right");
        base.day_levels[0].permille = 1000;
    }
    living_init(living, &base);
    if (plan->drawn)
        living_draw(living, &cuts->draw);
    for (unsigned i = 0; i < plan->n_asks; i++)
        living_ask(living, plan->asks[i].kind, plan->asks[i].from, plan->asks[i].value);
}

/* The next boot of a run that was not cut: after a stop, a disk that failed, or its end. */
static struct session_boot *go_on(struct session_boot *before, int given, bool ask_again)
{
    struct session_boot *b;

    disk_revive(before->disk);
    b = next_boot(before, before->disk, before->box.ended_ns + OUTAGE_NS);
    session_box_go_on(&b->box, given, ask_again);
    boot(b);
    return b;
}

static bool stops_here(const struct session_boot *b)
{
    return b->box.broken[0] || session_cuts_stopped(b->cuts);
}

/* With two slots more, after its end. */
static struct session_boot *go_on_longer(struct session_boot *before, struct living *living)
{
    int longer = living_longer(living, 2);

    before->newest = longer;
    before->box.promise.sealed = false;
    before->box.promise.maybe_sealed = true;
    return go_on(before, longer, false);
}

void session_cut_run(struct session_cuts *cuts, const struct session_plan *plan)
{
    struct session_boot *boots[BOOTS_MOST + 1] = {calloc(1, sizeof(*boots[0]))}, *b = boots[0];
    struct living *living = calloc(1, sizeof(*living));
    unsigned n = 1;

    if (!b || !living)
        abort();
    b->cuts = cuts;
    b->plan = plan;
    b->trouble = plan->trouble;
    b->disk = session_fresh_disk();
    disk_fresh_blocks(b->disk, plan->fresh);
    b->cutting = true;
    session_box_init(&b->box, NULL, plan->slots, plan->second);
    b->box.plan.keep = plan->keep;
    make_living(living, plan, cuts, b->box.plan);
    if (plan->days || living->n_asks > 0 || plan->longer)
        session_box_live(&b->box, living);
    b->newest = (int)living->n_plans - 1;
    boot(b);
    /* Started again, by somebody who has seen to the disk: it ends well. */
    if (!stops_here(b) && b->trouble.came) {
        b->cutting = false;
        boots[n++] = b = go_on(b, 0, true);
    }
    while (!stops_here(b) && b->box.stopped && n < BOOTS_MOST)
        boots[n++] = b = go_on(b, 0, true);
    if (plan->longer && !stops_here(b) && b->box.result.sealed)
        boots[n++] = go_on_longer(b, living);
    disk_destroy(boots[0]->disk);
    while (n > 0)
        free(boots[--n]);
    free(living);
}
