/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Whole captures at random, each boot in a process of its own, which may be killed:
 *
 *   chaos [-v] FIRST_SEED COUNT     so many seeds, one after another
 *   chaos                           fixed ones, as a test
 *
 * Says what did not hold, with the seed that shows it. Exits 1 if anything did not.
 */
#include "chaos.h"

#include <errno.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include "commit.h"
#include "ttf/base/attr.h"

/* A seed that takes longer hangs: the longest need a few seconds. */
#define HANG_S 120

/* As a test: of these every other one names a second storage, and most of those move. */
#define TEST_FIRST 301
#define TEST_SEEDS 50

/* Of one seed, so many failures are told. */
#define SAID_MAX 8

void chaos_fail(struct chaos *c, const char *format, ...)
{
    va_list args;

    if (++c->failures > SAID_MAX)
        return;
    printf("seed %llu, run %u: ", (unsigned long long)c->seed, c->n_boots);
    va_start(args, format);
    vprintf(format, args);
    va_end(args);
    printf("\n");
}

/* No lamp burns on end, or of its window, for longer than it may; the guardian looks every now and then. */
static void check_limits(struct chaos *c)
{
    struct ttf_box *box = c->run.box;
    int64_t now = ttf_clock_now_ns(box->clock);

    for (unsigned i = 0; box->lamps && i < ttf_lamps_count(box->lamps); i++) {
        const struct ttf_lamp_info *info = ttf_lamps_info(box->lamps, i);
        struct ttf_lamp_state state;

        if (ttf_lamps_state(box->lamps, i, &state) < 0)
            continue;
        if (info->max_on_ns > 0 && state.on_since_ns != TTF_NS_UNKNOWN &&
            now - state.on_since_ns > info->max_on_ns + TTF_NS_PER_S)
            chaos_fail(c, "lamp %u has burnt for %.1f s on end", i,
                       (double)(now - state.on_since_ns) / 1e9);
        if (info->max_duty_permille < TTF_LAMP_FULL &&
            state.on_total_ns > (now / info->duty_window_ns + 1) * info->duty_window_ns /
                                        TTF_LAMP_FULL * info->max_duty_permille +
                                    TTF_NS_PER_S)
            chaos_fail(c, "lamp %u has burnt for %.1f s in all of %.1f s", i,
                       (double)state.on_total_ns / 1e9, (double)now / 1e9);
    }
}

static void progress(struct sim_run *run, const struct ttf_progress *p)
{
    struct chaos *c = (struct chaos *)run;

    if (p->kind == TTF_PROGRESS_ARMED)
        chaos_asks_told(c, c->told);
    if (p->kind != TTF_PROGRESS_SLOT)
        return;
    if (p->index != c->told + 1)
        chaos_fail(c, "slot %lld told after slot %lld", (long long)p->index, (long long)c->told);
    c->told = p->index;
    if (p->index < CHAOS_TOLD_MAX)
        c->told_result[p->index] = (char)(p->result + 1);
    check_limits(c);
    chaos_asks_told(c, p->index);
    for (unsigned i = 0; i < TTF_COUNT_OF(c->stop_at); i++) {
        if (c->stop_at[i] != p->index)
            continue;
        c->stop_at[i] = -1;
        c->stopped_ns = p->now_ns;
        __atomic_store_n(&run->stop, 1, __ATOMIC_RELAXED);
    }
    if (p->index == c->fail_at) {
        c->fail_at = -1;
        run->failing = c->fail_count;
    }
    if (run->plan.reserve_bytes > 0)
        run->free_bytes =
            (p->index >= c->full_from && p->index < c->full_until) || chaos_second_no_room(c)
                ? 1 << 20
                : (int64_t)1 << 32;
}

/* A box without power may have waited on for its work; the run saw nothing more. The cut, or earlier. */
static int64_t cut_ns(const struct chaos *c)
{
    const struct ttf_sim_config *config = &c->run.config;
    int64_t outage = config->outage_ns;

    for (unsigned i = 0; i < config->n_faults; i++)
        if (config->faults[i].kind == TTF_FAULT_POWER_CUT &&
            config->faults[i].amount * TTF_NS_PER_S > outage)
            outage = config->faults[i].amount * TTF_NS_PER_S;
    return c->run.back_ns - outage;
}

static void note_boot(struct chaos *c)
{
    struct chaos_boot *boot = &c->boots[c->n_boots];

    snprintf(boot->id, sizeof(boot->id), "%s", ttf_clock_boot_id(c->run.box->clock));
    boot->power_on_ns = c->run.config.power_on_ns;
    boot->ended_ns = c->run.ended_ns;
    boot->storage_away = c->run.code == -EIO || c->run.code == -ENOSPC || c->run.code == -EROFS;
    if (c->run.code == -ESHUTDOWN && cut_ns(c) < boot->ended_ns)
        boot->ended_ns = cut_ns(c);
}

void chaos_kill(struct chaos *c)
{
    struct sim_run *run = &c->run;

    c->killed = true;
    chaos_asks_poll(c);
    run->ended_ns = ttf_sim_elapsed_ns(run->box, ttf_clock_now_ns(run->box->clock));
    run->code = 0;
    run->result.sealed = false;
    note_boot(c);
    fflush(stdout);
    _exit(0);
}

/* Kills the process between two file operations, when its time has come. */
static void maybe_kill(struct sim_run *run)
{
    struct chaos *c = (struct chaos *)run;

    if (c->kill_at < -1 || c->told < c->kill_at || c->kill_after-- > 0)
        return;
    c->kill_at = -2;
    chaos_kill(c);
}

/* The session has ended, the box is still there. */
static void at_end(struct sim_run *run)
{
    struct chaos *c = (struct chaos *)run;

    note_boot(c);
    chaos_asks_poll(c);
    check_limits(c);
    for (unsigned i = 0; run->box->lamps && i < ttf_lamps_count(run->box->lamps); i++) {
        struct ttf_lamp_state state;

        if (ttf_lamps_state(run->box->lamps, i, &state) == 0 && state.actual_permille > 0)
            chaos_fail(c, "lamp %u burns after the end", i);
    }
    if (c->stopped_ns != TTF_NS_UNKNOWN && run->code == 0) {
        int64_t took = ttf_clock_now_ns(run->box->clock) - c->stopped_ns;

        /* A storage that is away is waited for at the end, as during the run. */
        if (c->troubled[0] || c->troubled[1])
            took -= TTF_COMMIT_PATIENCE_NS + TTF_NS_PER_S;
        /* Of frames as small as these 16 may wait to be committed (capture/queue.h). */
        if (took > 2 * chaos_bounds_of(c).interval_ns + 18 * run->config.cost_commit_ns +
                       60 * run->config.cost_develop_ns + 30 * TTF_NS_PER_S)
            chaos_fail(c, "a stop took %.1f s", (double)took / 1e9);
    }
}

/* In virtual time no run may last longer than what is left of its plan, and some work. */
static void check_length(struct chaos *c)
{
    const struct sim_run *run = &c->run;
    int64_t work = run->config.cost_commit_ns + 12 * run->config.cost_develop_ns;
    const struct chaos_bounds b = chaos_bounds_of(c);
    int64_t most = (b.slots + 2) * (b.interval_ns + work) + TTF_NS_PER_H;

    if (run->plan.start_utc_ns > 0) /* by a clock that may have been stepped before */
        most += run->plan.start_utc_ns - run->config.start_utc_ns + 4000 * TTF_NS_PER_S;

    if (run->ended_ns - run->config.power_on_ns > most)
        chaos_fail(c, "the run took %.1f s of virtual time",
                   (double)(run->ended_ns - run->config.power_on_ns) / 1e9);
    if (run->bites > 0)
        chaos_fail(c, "the watchdog bit %u times", run->bites);
}

static bool documented(int code)
{
    return code == 0 || code == -ENOSPC || code == -EIO || code == -EROFS || code == -ENODEV ||
           code == -ESHUTDOWN;
}

/* A plan that does not fit the box gets more time and gentler lamps. */
static bool make_fit(struct chaos *c)
{
    struct ttf_plan *plan = &c->run.plan;

    if (strcmp(c->run.err.where, "interval") == 0) {
        plan->interval_ns *= 2;
        return true;
    }
    if (strcmp(c->run.err.where, "start") == 0) {
        plan->start_utc_ns = 0;
        return true;
    }
    if (strncmp(c->run.err.where, "lamps.", 6) == 0) {
        for (unsigned i = 0; i < c->run.config.n_lamps; i++) {
            c->run.config.lamps[i].info.max_on_ns = 0;
            c->run.config.lamps[i].info.max_duty_permille = TTF_LAMP_FULL;
        }
        return true;
    }
    return false;
}

/* The plan of a dataset that was begun stays; of one that was only made its start may have passed without a clock. */
static bool may_fit(const struct chaos *c)
{
    return !c->kept[0].records || strcmp(c->run.err.where, "start") == 0;
}

/* One boot in a process of its own, since it may be killed. */
static bool boot_apart(struct chaos *c)
{
    int status = 0;
    pid_t child;

    fflush(stdout);
    child = fork();
    if (child == 0) {
        alarm(HANG_S);
        c->run.control = ttf_control_create();
        (void)sim_run_boot(&c->run);
        ttf_control_destroy(c->run.control);
        /* What it leaks is told at exit, and is a failure. No other thread is left. */
        exit(0); /* NOLINT(concurrency-mt-unsafe) */
    }
    while (child > 0 && waitpid(child, &status, 0) < 0 && errno == EINTR)
        ;
    if (child > 0 && status == 0)
        return true;
    if (child > 0 && WIFSIGNALED(status))
        chaos_fail(c, "its process ended by signal %d%s", WTERMSIG(status),
                   WTERMSIG(status) == SIGALRM ? ": it HANGS" : "");
    else
        chaos_fail(c, "its process ended with %d", WEXITSTATUS(status));
    return false;
}

/* Somebody mends a storage that can only be read, sooner or later. */
static void repair(struct chaos *c)
{
    struct ttf_sim_config *b = &c->run.config;

    if (c->run.code != -EROFS || c->repaired_after-- > 0)
        return;
    for (unsigned i = 0; i < b->n_faults; i++)
        if (b->faults[i].kind == TTF_FAULT_READ_ONLY)
            b->faults[i--] = b->faults[--b->n_faults];
}

/* 1: go on; 0: done, or no use. */
static int one_run(struct chaos *c)
{
    struct sim_run *run = &c->run;
    bool unmounted;
    int code;

    c->stopped_ns = TTF_NS_UNKNOWN;
    __atomic_store_n(&run->stop, 0, __ATOMIC_RELAXED);
    c->killed = false;
    run->alarms = 0;
    chaos_second_before(c);
    if (!boot_apart(c))
        return 0;
    chaos_asks_over(c);
    code = run->code;
    unmounted = chaos_second_was_unmounted(c);
    if (c->verbose)
        printf("  run %u from %.3f s to %.3f s: %d %s: %s (told %lld)\n", c->n_boots,
               (double)run->config.power_on_ns / 1e9, (double)run->ended_ns / 1e9, code,
               run->err.where, run->err.what, (long long)c->told);
    if (code == -EINVAL && c->told < 0 && may_fit(c) && make_fit(c))
        return 1;
    c->n_boots++;
    if (!documented(code) && !unmounted)
        chaos_fail(c, "ended with %d: %s: %s", code, run->err.where, run->err.what);
    if (code < 0 && run->err.code != code)
        chaos_fail(c, "ended with %d but says %d", code, run->err.code);
    check_length(c);
    chaos_check_boot(c);
    if (code == 0 && run->result.sealed)
        return 0;
    if (code == 0 && c->stopped_ns == TTF_NS_UNKNOWN && !c->killed)
        chaos_fail(c, "neither sealed nor stopped");
    repair(c);
    chaos_second_after(c);
    run->config.power_on_ns =
        code == -ESHUTDOWN
            ? run->back_ns
            : run->ended_ns +
                  chaos_between(c, 1, 1 + 3 * run->plan.interval_ns / TTF_NS_PER_S) * TTF_NS_PER_S;
    return documented(code) || unmounted;
}

/* Of all seeds. */
struct tally {
    unsigned bad, named, moved, killed, gone;
};

static void count_in(struct tally *t, const struct chaos *c)
{
    t->bad += c->failures > 0;
    t->named += c->second.named;
    t->moved += c->second.begun;
    t->killed += c->second.n_kills > 0;
    t->gone += c->second.began > c->second.gone_from && c->second.gone_for > 0;
}

static void campaign(uint64_t seed, bool verbose, struct tally *tally)
{
    /* Shared with the processes of its boots. */
    struct chaos *c =
        mmap(NULL, sizeof(*c), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    struct chaos_kept kept[2] = {{NULL, NULL}, {NULL, NULL}};
    int tries = 0;

    if (c == MAP_FAILED) {
        tally->bad++;
        return;
    }
    c->seed = seed;
    c->verbose = verbose;
    c->told = -1;
    c->kept = kept;
    chaos_draw(c);
    c->run.on_progress = progress;
    c->run.on_file = maybe_kill;
    c->run.fault = chaos_second_fault;
    c->run.at_end = at_end;
    if (verbose)
        chaos_describe(c);
    while (one_run(c) == 1 && ++tries < CHAOS_RUNS_MAX)
        ;
    chaos_second_over(c);
    chaos_check_end(c, c->run.code == 0 && c->run.result.sealed);
    if (verbose)
        chaos_asks_describe(c);
    if (c->failures > 0 && !verbose)
        chaos_describe(c);
    if (c->failures > 0 && verbose)
        printf("  left in %s\n", c->run.path);
    else
        sim_run_finish(&c->run);
    count_in(tally, c);
    for (unsigned storage = 0; storage < 2; storage++) {
        free(kept[storage].records);
        free(kept[storage].events);
    }
    munmap(c, sizeof(*c));
}

int main(int argc, char **argv)
{
    bool verbose = argc > 1 && strcmp(argv[1], "-v") == 0;
    uint64_t first;
    uint64_t count;
    struct tally t = {0};

    argv += verbose;
    argc -= verbose;
    first = argc == 3 ? strtoull(argv[1], NULL, 10) : TEST_FIRST;
    count = argc == 3 ? strtoull(argv[2], NULL, 10) : TEST_SEEDS;
    for (uint64_t i = 0; i < count; i++)
        campaign(first + i, verbose, &t);
    printf("%llu seeds, %u bad; %u with a second storage, %u went on there; %u killed in the move, "
           "%u with the first disk gone behind it\n",
           (unsigned long long)count, t.bad, t.named, t.moved, t.killed, t.gone);
    return t.bad > 0;
}
