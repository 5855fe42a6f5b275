/* SPDX-License-Identifier: Apache-2.0 */
/*
 * crash: cuts the power of a dataset being written, everywhere, and looks at what
 * is left. README.md. Exits 1 if anything promised was broken.
 */
#include <getopt.h>
#include <inttypes.h>
#include <malloc.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "cuts.h"
#include "parts.h"

#define SEEN_BITS      26 /* half a GiB, as far as it is touched */
#define STATES_DEFAULT 1000000

enum campaign {
    EXHAUSTIVE,
    TROUBLED,
    RANDOM,
    DEEP,
    CAMPAIGN_COUNT
};

struct asked {
    bool campaigns[CAMPAIGN_COUNT], quick;
    unsigned depth, parts;
    int fresh_kinds;
    uint64_t seed, states;
};

/* Everything that a writer does. */
static const enum run_step fixed_run[] = {
    RUN_CREATE, RUN_SEGMENT,  RUN_CALIBRATE, RUN_SLOT_ONE, RUN_EVENT,     RUN_NOTE,
    RUN_SAMPLE, RUN_SLOT_TWO, RUN_PLAN,      RUN_SEGMENT,  RUN_SLOT_PAIR, RUN_CORRECT,
    RUN_NOTE,   RUN_REOPEN,   RUN_SLOT_NONE, RUN_SLOT_ONE, RUN_SEAL,      RUN_NOTE,
    RUN_SAMPLE, RUN_REOPEN,   RUN_SEGMENT,   RUN_SLOT_TWO, RUN_EVENT,     RUN_SEAL,
};

/* What every run does, short enough to be cut twice everywhere. */
static const enum run_step small_run[] = {
    RUN_CREATE, RUN_SEGMENT, RUN_SLOT_ONE, RUN_SLOT_TWO, RUN_EVENT,
    RUN_SEAL,   RUN_REOPEN,  RUN_SLOT_ONE, RUN_SEAL,
};

#define COUNT_OF(array) (sizeof(array) / sizeof((array)[0]))

static const char *const campaign_names[CAMPAIGN_COUNT] = {"exhaustive", "troubled", "random",
                                                           "deep"};

static double now_s(void)
{
    struct timespec t;

    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

struct shares {
    const struct asked *asked;
    enum campaign campaign;
    struct seen *seen;
    struct cuts_counts *sum;
};

static void add(void *ctx, const void *found)
{
    struct cuts_counts *sum = ((struct shares *)ctx)->sum;
    const struct cuts_counts *part = found;
    unsigned i;

    sum->cuts += part->cuts;
    sum->states += part->states;
    sum->deeper += part->deeper;
    sum->steps += part->steps;
    for (i = 0; i < RUN_FAULT_COUNT; i++)
        sum->of[i] += part->of[i];
}

/* One process's share. */
static void work(void *ctx, unsigned part, void *ret)
{
    const struct shares *shares = ctx;
    const struct asked *asked = shares->asked;
    enum campaign campaign = shares->campaign;
    struct cuts cuts = {
        .bounds = {{.subset_bits = 10, .tear_step = 16, .pairs = true},
                   {.subset_bits = 4, .tear_step = 512, .pairs = false}},
        .depth = asked->depth,
        .seen = shares->seen,
        .steps = fixed_run,
        .n_steps = COUNT_OF(fixed_run),
        .fresh_kinds = asked->fresh_kinds,
        .part = part,
        .parts = asked->parts,
        .stop_at_first = asked->quick,
        .between_of = campaign == RANDOM || asked->quick ? 4 : 1,
        .trouble_each = asked->quick ? 20 : 1,
        .seed = asked->seed,
    };

    if (asked->quick)
        cuts.bounds[0] = (struct cuts_bounds){.subset_bits = 5, .tear_step = 128, .pairs = false};
    switch (campaign) {
    case DEEP:
        cuts.bounds[0] = (struct cuts_bounds){.subset_bits = 10, .tear_step = 64, .pairs = true};
        cuts.bounds[1] = cuts.bounds[0];
        cuts.steps = small_run;
        cuts.n_steps = COUNT_OF(small_run);
        cuts_exhaustive(&cuts);
        break;
    case EXHAUSTIVE:
        cuts_exhaustive(&cuts);
        break;
    case TROUBLED:
        cuts_troubled(&cuts);
        break;
    case RANDOM:
        cuts.states_most = asked->states / asked->parts + (part < asked->states % asked->parts);
        cuts_random(&cuts);
        break;
    default:
        break;
    }
    memcpy(ret, &cuts.counts, sizeof(cuts.counts));
}

/* All shares. False: a process ended badly. */
static bool work_all(const struct asked *asked, enum campaign campaign, struct cuts_counts *ret)
{
    struct shares shares = {
        .asked = asked, .campaign = campaign, .seen = seen_create(SEEN_BITS), .sum = ret};
    bool well = parts_work(&(struct parts){
        .n = asked->parts, .bytes = sizeof(*ret), .ctx = &shares, .work = work, .add = add});

    seen_destroy(shares.seen);
    return well;
}

static void print(const char *name, const struct cuts_counts *c, double seconds, bool well)
{
    printf("crash %s: %" PRIu64 " states of %" PRIu64 " cuts at %" PRIu64 " steps (%" PRIu64
           " in recoveries), %.0f s; lost %" PRIu64 ", shown %" PRIu64 ", unopenable %" PRIu64
           ", otherwise broken %" PRIu64 "%s\n",
           name, c->states, c->cuts, c->steps, c->deeper, seconds, c->of[RUN_LOST],
           c->of[RUN_SHOWN], c->of[RUN_UNOPENABLE], c->of[RUN_OTHER],
           well ? "" : "; a process ended badly");
    (void)fflush(stdout);
}

/* What was asked for, one after another; quick: one line of all, and no more after something is broken. */
static bool campaigns(const struct asked *asked)
{
    struct cuts_counts c = {0};
    double begun = now_s();
    bool well = true, all_well = true;
    unsigned i;

    for (i = 0; i < CAMPAIGN_COUNT; i++) {
        if (!asked->campaigns[i] || (asked->quick && !all_well))
            continue;
        well = work_all(asked, (enum campaign)i, &c);
        all_well = all_well && well && c.of[RUN_WELL] == c.states;
        if (asked->quick)
            continue;
        print(campaign_names[i], &c, now_s() - begun, well);
        memset(&c, 0, sizeof(c));
        begun = now_s();
    }
    if (asked->quick)
        print("quick", &c, now_s() - begun, well);
    return all_well;
}

static int usage(void)
{
    fputs("usage: crash [exhaustive|troubled|random|deep|--quick] [--depth 1|2] [--seed N]\n"
          "             [--states N] [--processes N] [--fresh 1|2|3]\n",
          stderr);
    return 2;
}

static bool ask_campaign(struct asked *asked, const char *name)
{
    unsigned i;

    for (i = 0; i < CAMPAIGN_COUNT; i++)
        if (strcmp(name, campaign_names[i]) == 0) {
            asked->campaigns[i] = true;
            return true;
        }
    return false;
}

static bool options(int argc, char **argv, struct asked *asked)
{
    static const struct option known[] = {
        {"quick", no_argument, NULL, 'q'},
        {"depth", required_argument, NULL, 'd'},
        {"seed", required_argument, NULL, 's'},
        {"states", required_argument, NULL, 'n'},
        {"processes", required_argument, NULL, 'p'},
        {"fresh", required_argument, NULL, 'f'},
        {NULL, 0, NULL, 0},
    };
    int c;

    /* NOLINTNEXTLINE(concurrency-mt-unsafe): before any thread */
    while ((c = getopt_long(argc, argv, "", known, NULL)) != -1) {
        switch (c) {
        case 'q':
            asked->quick = true;
            break;
        case 'd':
            asked->depth = (unsigned)strtoul(optarg, NULL, 10);
            break;
        case 's':
            asked->seed = strtoull(optarg, NULL, 10);
            break;
        case 'n':
            asked->states = strtoull(optarg, NULL, 10);
            break;
        case 'f':
            asked->fresh_kinds = (int)strtol(optarg, NULL, 10);
            break;
        case 'p':
            asked->parts = (unsigned)strtoul(optarg, NULL, 10);
            break;
        default:
            return false;
        }
    }
    for (; optind < argc; optind++) {
        if (!ask_campaign(asked, argv[optind]))
            return false;
    }
    return asked->fresh_kinds >= 1 && asked->fresh_kinds <= DISK_FRESH_COUNT && asked->depth >= 1 &&
           asked->depth <= 2 && asked->parts >= 1 && asked->parts <= PARTS_MAX;
}

int main(int argc, char **argv)
{
    struct asked asked = {.depth = 2, .fresh_kinds = 2, .seed = 1, .states = STATES_DEFAULT};
    unsigned i;
    bool any;

    asked.parts = parts_of_cores();
    if (!options(argc, argv, &asked))
        return usage();
    if (asked.quick) {
        asked.depth = 1;
        asked.states = asked.states == STATES_DEFAULT ? 2000 : asked.states;
    }
    for (i = 0, any = false; i < CAMPAIGN_COUNT; i++)
        any = any || asked.campaigns[i];
    for (i = 0; !any && i < DEEP; i++) /* that one takes as long as all others: only if asked for */
        asked.campaigns[i] = true;
    /* Readers take 128 KiB and give them back, a thousand times a second: not from the kernel each time. */
    /* NOLINTNEXTLINE(concurrency-mt-unsafe): before any thread */
    (void)mallopt(M_MMAP_THRESHOLD, 16 << 20);
    /* NOLINTNEXTLINE(concurrency-mt-unsafe): before any thread */
    (void)mallopt(M_TRIM_THRESHOLD, 64 << 20);
    return campaigns(&asked) ? 0 : 1;
}
