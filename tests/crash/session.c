/* SPDX-License-Identifier: Apache-2.0 */
/*
 * crash_session: whole captures of a simulated box, on a disk whose power is cut everywhere. README.md. Exits 1 if
 * anything promised was broken.
 */
#include <getopt.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "parts.h"
#include "session_cuts.h"

#define SEEN_BITS   20
/* quick: one step in so many is cut */
#define QUICK_STEPS 4

struct asked {
    bool everywhere, random, quick;
    unsigned parts;
    uint64_t seed, states;
};

struct campaign {
    const struct asked *asked;
    struct session_counts sum; /* of all processes */
};

static double now_s(void)
{
    struct timespec t;

    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* Short runs: on a sound disk, and with a first storage that fails for good on the way. */
static const struct session_plan everywhere[] = {
    {.slots = 2, .keep = TTF_KEEP_DEVELOPED},
    {.slots = 3,
     .second = true,
     .keep = TTF_KEEP_DEVELOPED,
     .trouble = {.kind = SESSION_EIO, .from = 90, .until = UINT64_MAX, .first_only = true}},
    {.slots = 3,
     .second = true,
     .keep = TTF_KEEP_BOTH,
     .trouble = {.kind = SESSION_SYNC_FAILS, .from = 90, .until = UINT64_MAX, .first_only = true}},
};

/* Runs of which people ask something meanwhile. */
static const struct session_plan living[] = {
    {.slots = 2,
     .keep = TTF_KEEP_DEVELOPED,
     .n_asks = 5,
     .asks = {{TTF_ASK_NOTE, 1, 0},
              {TTF_ASK_COUNT, 1, 3},
              {TTF_ASK_NOTE, 2, 0},
              {TTF_ASK_PLAN, 2, 40 * TTF_NS_PER_S},
              {TTF_ASK_INTERVAL, 3, 30 * TTF_NS_PER_S}}},
    {.slots = 3,
     .keep = TTF_KEEP_DEVELOPED,
     .days = true,
     .longer = true,
     .n_asks = 5,
     .asks = {{TTF_ASK_PAUSE, 1, 0},
              {TTF_ASK_PHOTOPERIOD, 1, TTF_NS_PER_MIN},
              {TTF_ASK_CONTINUE, 2, 0},
              {TTF_ASK_UNTIL, 2, 4},
              {TTF_ASK_STOP, 3, 0}}},
    {.slots = 3,
     .second = true,
     .keep = TTF_KEEP_DEVELOPED,
     .n_asks = 4,
     .asks = {{TTF_ASK_INTERVAL, 1, 50 * TTF_NS_PER_S},
              {TTF_ASK_NOTE, 1, 0},
              {TTF_ASK_NOTE, 2, 0},
              {TTF_ASK_COUNT, 2, 4}},
     .trouble = {.kind = SESSION_EIO, .from = 110, .until = UINT64_MAX, .first_only = true}},
};

static void cut_everywhere(struct session_cuts *cuts)
{
    size_t i;

    cuts->everywhere = true;
    for (i = 0; i < sizeof(everywhere) / sizeof(everywhere[0]); i++)
        session_cut_run(cuts, &everywhere[i]);
    for (i = 0; i < sizeof(living) / sizeof(living[0]); i++)
        session_cut_run(cuts, &living[i]);
}

static struct session_plan draw_plan(struct draw *draw)
{
    static const enum ttf_keep keeps[] = {TTF_KEEP_DEVELOPED, TTF_KEEP_RAW, TTF_KEEP_BOTH};
    struct session_plan plan = {0};
    struct session_trouble *t = &plan.trouble;

    plan.slots = 2 + (int64_t)draw_below(draw, 4);
    plan.second = draw_below(draw, 2);
    plan.keep = keeps[draw_below(draw, 3)];
    plan.cut_permille = 10 + (unsigned)draw_below(draw, 150);
    plan.drawn = draw_below(draw, 2);
    plan.days = plan.drawn && draw_below(draw, 3) == 0;
    plan.longer = draw_below(draw, 4) == 0;
    plan.fresh = draw_below(draw, 2) ? DISK_NOISE : DISK_ZEROS;
    if (draw_below(draw, 2))
        return plan;
    t->kind = 1 + (enum session_trouble_kind)draw_below(draw, SESSION_TROUBLE_COUNT - 1);
    t->from = 1 + draw_below(draw, 250);
    t->until = draw_below(draw, 2) ? UINT64_MAX : t->from + 1 + draw_below(draw, 20);
    t->first_only = plan.second && draw_below(draw, 4) > 0;
    return plan;
}

static void cut_at_random(struct session_cuts *cuts, const struct asked *asked, uint64_t states)
{
    struct session_plan plan;

    for (cuts->seed = asked->seed + cuts->part;
         cuts->counts.states < states && !session_cuts_stopped(cuts); cuts->seed += cuts->parts) {
        draw_seed(&cuts->draw, cuts->seed);
        plan = draw_plan(&cuts->draw);
        cuts->states_left = 60;
        session_cut_run(cuts, &plan);
    }
}

/* One process's share. */
static void work(void *ctx, unsigned part, void *ret)
{
    const struct asked *asked = ((struct campaign *)ctx)->asked;
    struct session_cuts cuts = {.part = part,
                                .parts = asked->parts * (asked->quick ? QUICK_STEPS : 1),
                                .each = asked->quick ? 1000 : 1,
                                .stop_at_first = asked->quick};

    if (asked->everywhere) {
        cuts.seen = seen_create(SEEN_BITS);
        cut_everywhere(&cuts);
        seen_destroy(cuts.seen);
        cuts.seen = NULL;
        cuts.everywhere = false;
        cuts.parts = asked->parts;
    }
    if (asked->random)
        cut_at_random(&cuts, asked,
                      cuts.counts.states + asked->states / asked->parts +
                          (part < asked->states % asked->parts));
    memcpy(ret, &cuts.counts, sizeof(cuts.counts));
}

static void add(void *ctx, const void *found)
{
    struct session_counts *sum = &((struct campaign *)ctx)->sum;
    const struct session_counts *part = found;

    sum->boots += part->boots;
    sum->cuts += part->cuts;
    sum->states += part->states;
    sum->asked += part->asked;
    sum->deeper += part->deeper;
    sum->troubled += part->troubled;
    sum->moved += part->moved;
    sum->ended_early += part->ended_early;
    sum->broken += part->broken;
}

static bool options(int argc, char **argv, struct asked *asked)
{
    static const struct option known[] = {
        {"quick", no_argument, NULL, 'q'},
        {"seed", required_argument, NULL, 's'},
        {"states", required_argument, NULL, 'n'},
        {"processes", required_argument, NULL, 'p'},
        {NULL, 0, NULL, 0},
    };
    int c;

    /* NOLINTNEXTLINE(concurrency-mt-unsafe): before any thread */
    while ((c = getopt_long(argc, argv, "", known, NULL)) != -1) {
        switch (c) {
        case 'q':
            asked->quick = true;
            break;
        case 's':
            asked->seed = strtoull(optarg, NULL, 10);
            break;
        case 'n':
            asked->states = strtoull(optarg, NULL, 10);
            break;
        case 'p':
            asked->parts = (unsigned)strtoul(optarg, NULL, 10);
            break;
        default:
            return false;
        }
    }
    for (; optind < argc; optind++) {
        if (strcmp(argv[optind], "everywhere") == 0)
            asked->everywhere = true;
        else if (strcmp(argv[optind], "random") == 0)
            asked->random = true;
        else
            return false;
    }
    if (!asked->everywhere && !asked->random)
        asked->everywhere = asked->random = true;
    return asked->parts >= 1 && asked->parts <= PARTS_MAX;
}

int main(int argc, char **argv)
{
    struct asked asked = {.seed = 1, .parts = parts_of_cores()};
    struct campaign campaign = {.asked = &asked};
    const struct session_counts *c = &campaign.sum;
    double begun = now_s();
    bool well;

    if (!options(argc, argv, &asked)) {
        fputs("usage: crash_session [everywhere|random] [--quick] [--seed N] [--states N] "
              "[--processes N]\n",
              stderr);
        return 2;
    }
    if (asked.states == 0)
        asked.states = asked.quick ? 200 : 20000;
    well = parts_work(&(struct parts){.n = asked.parts,
                                      .bytes = sizeof(campaign.sum),
                                      .ctx = &campaign,
                                      .work = work,
                                      .add = add});
    printf("crash session: %" PRIu64 " states of %" PRIu64 " cuts (%" PRIu64
           " of resumed runs), %" PRIu64 " boots (%" PRIu64 " with asks, %" PRIu64
           " on a disk that failed, %" PRIu64 " in the second storage, %" PRIu64
           " ended early), seed %" PRIu64 ", %.0f s; broken: %" PRIu64 "%s\n",
           c->states, c->cuts, c->deeper, c->boots, c->asked, c->troubled, c->moved, c->ended_early,
           asked.seed, now_s() - begun, c->broken, well ? "" : "; a process ended badly");
    return well && c->broken == 0 ? 0 : 1;
}
