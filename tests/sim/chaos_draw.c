/* SPDX-License-Identifier: Apache-2.0 */
/* What a seed stands for: a plan, a board, faults. */
#include "chaos.h"

#include <stdio.h>
#include <string.h>

#include "ttf/base/attr.h"

/* splitmix64 (Steele, Lea, Flood 2014). */
static uint64_t next(struct chaos *c)
{
    uint64_t x = c->state += UINT64_C(0x9e3779b97f4a7c15);

    x = (x ^ (x >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
    x = (x ^ (x >> 27)) * UINT64_C(0x94d049bb133111eb);
    return x ^ (x >> 31);
}

uint64_t chaos_below(struct chaos *c, uint64_t n)
{
    return n > 0 ? next(c) % n : 0;
}

int64_t chaos_between(struct chaos *c, int64_t low, int64_t high)
{
    return low + (int64_t)chaos_below(c, (uint64_t)(high - low) + 1);
}

bool chaos_percent(struct chaos *c, unsigned percent)
{
    return chaos_below(c, 100) < percent;
}

static int64_t one_of(struct chaos *c, const int64_t *values, unsigned n)
{
    return values[chaos_below(c, n)];
}

/* ---- the plan ---- */

static void draw_levels(struct chaos *c, struct ttf_lamp_level *levels, unsigned *n, unsigned lamps)
{
    static const char *const names[] = {"left", "right"};

    *n = 0;
    for (unsigned i = 0; i < lamps && i < TTF_COUNT_OF(names); i++) {
        if (chaos_percent(c, 30))
            continue;
        snprintf(levels[*n].lamp, sizeof(levels[*n].lamp), "%s", names[i]);
        levels[(*n)++].permille =
            chaos_percent(c, 70) ? 1000 : (unsigned)chaos_between(c, 0, TTF_LAMP_FULL);
    }
}

static void draw_shot(struct chaos *c, unsigned i)
{
    static const char *const streams[3] = {"main", "raking", "hdr"};
    static const int64_t exposures_ms[] = {1, 10, 20, 20, 20, 30, 100, 500};
    struct ttf_plan *plan = &c->run.plan;
    struct ttf_plan_shot *shot = &plan->shots[i];

    *shot = plan->shots[0];
    snprintf(shot->stream, sizeof(shot->stream), "%s", streams[i % 3]);
    snprintf(shot->channel, sizeof(shot->channel), "light-%u", i);
    shot->n_levels = 0;
    if (plan->lamps != TTF_LAMPS_NONE)
        draw_levels(c, shot->levels, &shot->n_levels, c->run.config.n_lamps);
    shot->exposure.exposure_ns =
        one_of(c, exposures_ms, TTF_COUNT_OF(exposures_ms)) * TTF_NS_PER_MS +
        (chaos_percent(c, 20) ? chaos_between(c, 0, 999999) : 0);
    shot->exposure.gain_milli =
        chaos_percent(c, 80) ? 1000 : 1000 + 100 * (uint32_t)chaos_below(c, 30);
    shot->n_brackets = chaos_percent(c, 25) ? (unsigned)chaos_between(c, 2, 3) : 0;
    for (unsigned b = 0; b < shot->n_brackets; b++)
        shot->brackets[b] = b == 0 ? 1 : (b == 1 ? 2 : 4);
    shot->average = chaos_percent(c, 60) ? 1 : (unsigned)chaos_between(c, 2, 5);
}

static void draw_day(struct chaos *c)
{
    struct ttf_plan *plan = &c->run.plan;

    plan->photoperiod_local = chaos_percent(c, 30);
    plan->period_ns = plan->photoperiod_local
                          ? TTF_NS_PER_DAY
                          : chaos_between(c, 1, 20) * plan->interval_ns / 2 + TTF_NS_PER_S;
    plan->day_ns = (int64_t)chaos_below(c, (uint64_t)plan->period_ns);
    plan->phase_ns =
        plan->photoperiod_local ? 0 : (int64_t)chaos_below(c, (uint64_t)plan->period_ns);
    plan->day_start_s = plan->photoperiod_local ? (int)chaos_below(c, 86400) : 0;
    draw_levels(c, plan->day_levels, &plan->n_day_levels, c->run.config.n_lamps);
}

static void draw_plan(struct chaos *c)
{
    static const int64_t intervals_ms[] = {300,   500,   1000,  2000,  5000,  10000,
                                           20000, 60000, 60000, 60000, 600000};
    struct ttf_plan *plan = &c->run.plan;

    plan->interval_ns = one_of(c, intervals_ms, TTF_COUNT_OF(intervals_ms)) * TTF_NS_PER_MS;
    plan->count = chaos_between(c, 5, 40);
    plan->lamps = (enum ttf_lamp_mode)chaos_below(c, 4);
    plan->settle_ns = chaos_percent(c, 10) ? 0 : chaos_between(c, 1, plan->interval_ns / 6);
    plan->n_shots = (unsigned)chaos_between(c, 1, 3);
    for (unsigned i = plan->n_shots; i-- > 0;)
        draw_shot(c, i);
    if (plan->lamps == TTF_LAMPS_PHOTOPERIOD)
        draw_day(c);
    plan->keep = (enum ttf_keep)chaos_below(c, 4);
    plan->mains_hz = chaos_percent(c, 80) ? 50 : 0;
    if (chaos_percent(c, 15))
        plan->start_utc_ns =
            c->run.config.start_utc_ns + chaos_between(c, -2, 20) * plan->interval_ns / 2;
    if (chaos_percent(c, 20))
        plan->reference = (struct ttf_region){2, 2, 8, 8};
    plan->reserve_bytes = chaos_percent(c, 20) ? 8 << 20 : 0;
}

/* ---- the board ---- */

static void draw_lamp(struct chaos *c, struct ttf_sim_lamp *lamp)
{
    lamp->info.interlock_door = chaos_percent(c, 70);
    if (chaos_percent(c, 15)) {
        lamp->info.max_duty_permille = (unsigned)chaos_between(c, 100, 999);
        lamp->info.duty_window_ns = chaos_between(c, 10, 3600) * TTF_NS_PER_S;
    }
    if (chaos_percent(c, 15))
        lamp->info.max_on_ns = chaos_between(c, 5, 7200) * TTF_NS_PER_S;
    if (chaos_percent(c, 10)) {
        lamp->info.max_temp_mdegc = (int32_t)chaos_between(c, 23000, 34000);
        lamp->info.hysteresis_mdegc = (int32_t)chaos_between(c, 0, 3000);
    }
    if (chaos_percent(c, 10)) {
        lamp->info.kind = TTF_LAMP_STEPS;
        lamp->info.steps = 10;
    }
    lamp->info.warm_up_ns = chaos_between(c, 0, 5) * TTF_NS_PER_S;
}

static void draw_board(struct chaos *c)
{
    struct ttf_sim_config *b = &c->run.config;

    b->seed = c->seed;
    b->width = 16 + 2 * (uint32_t)chaos_below(c, 17);
    b->height = 16 + 2 * (uint32_t)chaos_below(c, 9);
    b->steerable = chaos_percent(c, 60);
    b->rtc = chaos_percent(c, 60);
    b->utc_back_ns = chaos_percent(c, 60) ? chaos_between(c, 1, 600) * TTF_NS_PER_S : 0;
    b->door_switch = chaos_percent(c, 80);
    b->outage_ns = chaos_between(c, 1, 900) * TTF_NS_PER_S;
    b->jitter_ns = chaos_percent(c, 60) ? b->jitter_ns : chaos_between(c, 0, 5 * TTF_NS_PER_MS);
    b->readout_ns = chaos_percent(c, 60) ? b->readout_ns : chaos_between(c, 0, 30 * TTF_NS_PER_MS);
    b->control_delay_frames = (unsigned)chaos_below(c, 5);
    b->buffers = (unsigned)chaos_between(c, 2, 6);
    for (unsigned i = 0; i < b->n_lamps; i++)
        draw_lamp(c, &b->lamps[i]);
}

/* Work that is slow, up to more than the plan leaves time for. */
static void draw_cost(struct chaos *c)
{
    struct ttf_sim_config *b = &c->run.config;
    uint64_t interval = (uint64_t)c->run.plan.interval_ns;

    if (chaos_percent(c, 15))
        b->cost_commit_ns = (int64_t)chaos_below(c, interval * 3 / 2);
    if (chaos_percent(c, 15))
        b->cost_develop_ns = (int64_t)chaos_below(c, interval / 2);
}

/* ---- faults ---- */

static int64_t draw_amount(struct chaos *c, enum ttf_fault_kind kind)
{
    if (chaos_percent(c, 40))
        return 0;
    switch (kind) {
    case TTF_FAULT_FRAME_LATE:
        return chaos_between(c, 1, 10000);
    case TTF_FAULT_FRAME_SHORT:
    case TTF_FAULT_LAMP_FADING:
        return chaos_between(c, 1, 1000);
    case TTF_FAULT_CAMERA_HANG:
        return chaos_between(c, 0, 3);
    case TTF_FAULT_WRONG_SETTINGS:
        return chaos_between(c, -500, 2000);
    case TTF_FAULT_CLOCK_STEP:
        return chaos_between(c, -4000, 4000);
    case TTF_FAULT_POWER_CUT:
        return chaos_between(c, 1, 1 + 5 * c->run.plan.interval_ns / TTF_NS_PER_S);
    default:
        return 0;
    }
}

static void draw_fault(struct chaos *c, int64_t span_ns)
{
    static const uint32_t rates[] = {1000, 10000, 50000, 200000};
    struct ttf_fault *fault = &c->run.config.faults[c->run.config.n_faults++];
    enum ttf_fault_kind kind = (enum ttf_fault_kind)chaos_below(c, TTF_FAULT_READ_ONLY);

    *fault = (struct ttf_fault){.kind = kind, .at_ns = chaos_between(c, 1, span_ns)};
    if (chaos_percent(c, 50))
        fault->duration_ns = chaos_between(c, 1, span_ns / (chaos_percent(c, 50) ? 3 : 20));
    if (chaos_percent(c, 15))
        fault->at_ns = chaos_between(c, 1, 3 * TTF_NS_PER_S); /* while it is arming */
    if (kind == TTF_FAULT_DISK_FULL || kind == TTF_FAULT_IO_ERROR ? chaos_percent(c, 60)
                                                                  : chaos_percent(c, 25))
        fault->rate_per_million = rates[chaos_below(c, TTF_COUNT_OF(rates))];
    if (kind == TTF_FAULT_POWER_CUT && fault->rate_per_million > 50000)
        fault->rate_per_million = 50000;
    fault->amount = draw_amount(c, kind);
    if (kind == TTF_FAULT_LAMP_DEAD || kind == TTF_FAULT_LAMP_FADING ||
        kind == TTF_FAULT_LAMP_STUCK)
        snprintf(fault->target, sizeof(fault->target), "%s",
                 chaos_percent(c, 50) ? "left" : "right");
    if (kind == TTF_FAULT_SENSOR_GONE)
        snprintf(fault->target, sizeof(fault->target), "%s",
                 chaos_percent(c, 50) ? "box-temp" : "box-humidity");
}

/* One that stays so, until somebody mends it. */
static void draw_read_only(struct chaos *c, int64_t span_ns)
{
    if (!chaos_percent(c, 12))
        return;
    c->run.config.faults[c->run.config.n_faults++] =
        (struct ttf_fault){.kind = TTF_FAULT_READ_ONLY, .at_ns = chaos_between(c, 1, span_ns)};
    c->repaired_after = (unsigned)chaos_below(c, 4);
}

void chaos_draw(struct chaos *c)
{
    int64_t span_ns;
    uint64_t n;

    c->state = c->seed * UINT64_C(0xd1342543de82ef95) + 1;
    sim_run_init(&c->run);
    c->run.scene = "chart"; /* bright, and does not change */
    c->run.no_waiting =
        true; /* a killed process loses nothing that it wrote: whether it is synced nobody sees here */
    draw_board(c);
    draw_plan(c);
    draw_cost(c);
    span_ns = c->run.plan.interval_ns * c->run.plan.count + 15 * TTF_NS_PER_S;
    c->run.scene_span_ns = span_ns;
    n = chaos_below(c, 7);
    for (uint64_t i = 0; i < n; i++)
        draw_fault(c, span_ns);
    for (unsigned i = 0; i < TTF_COUNT_OF(c->stop_at); i++)
        c->stop_at[i] =
            chaos_percent(c, 20) ? (int64_t)chaos_below(c, (uint64_t)c->run.plan.count) : -1;
    c->fail_at = chaos_percent(c, 30) ? chaos_between(c, 0, c->run.plan.count - 1) : -1;
    c->fail_count = (unsigned)chaos_between(c, 1, chaos_percent(c, 50) ? 6 : 60);
    c->kill_at = chaos_percent(c, 40) ? chaos_between(c, -1, c->run.plan.count - 1) : -2;
    c->kill_after = (int)chaos_between(c, 1, 80);
    c->full_from = c->full_until = -1;
    if (c->run.plan.reserve_bytes > 0 && chaos_percent(c, 60)) {
        c->full_from = (int64_t)chaos_below(c, (uint64_t)c->run.plan.count);
        c->full_until = c->full_from + (int64_t)chaos_below(c, 6);
    }
    draw_read_only(c, span_ns);
    chaos_asks_draw(c);
    chaos_second_draw(c);
}

static void describe_shot(const struct ttf_plan_shot *shot)
{
    printf("  shot %s: %.3f ms gain %u average %u brackets %u", shot->stream,
           (double)shot->exposure.exposure_ns / 1e6, shot->exposure.gain_milli, shot->average,
           shot->n_brackets);
    for (unsigned i = 0; i < shot->n_levels; i++)
        printf(" %s=%u", shot->levels[i].lamp, shot->levels[i].permille);
    printf("\n");
}

void chaos_describe(const struct chaos *c)
{
    const struct ttf_sim_config *b = &c->run.config;
    const struct ttf_plan *p = &c->run.plan;

    printf("  plan: interval %.3f s, %lld slots, lamps %d, settle %.3f s, keep %d, start %+.3f s, "
           "day %.1f of %.1f s%s\n",
           (double)p->interval_ns / 1e9, (long long)p->count, p->lamps, (double)p->settle_ns / 1e9,
           p->keep, p->start_utc_ns ? (double)(p->start_utc_ns - b->start_utc_ns) / 1e9 : 0,
           (double)p->day_ns / 1e9, (double)p->period_ns / 1e9,
           p->photoperiod_local ? " local" : "");
    for (unsigned i = 0; i < p->n_shots; i++)
        describe_shot(&p->shots[i]);
    printf(
        "  board: %ux%u steerable %d rtc %d utc_back %.0f s door %d outage %.0f s jitter %.3f ms "
        "delay %u buffers %u readout %.1f ms commit %.3f s develop %.3f s\n",
        b->width, b->height, b->steerable, b->rtc, (double)b->utc_back_ns / 1e9, b->door_switch,
        (double)b->outage_ns / 1e9, (double)b->jitter_ns / 1e6, b->control_delay_frames, b->buffers,
        (double)b->readout_ns / 1e6, (double)b->cost_commit_ns / 1e9,
        (double)b->cost_develop_ns / 1e9);
    for (unsigned i = 0; i < b->n_faults; i++)
        printf("  fault %s at %.3f s for %.3f s rate %u amount %lld %s\n",
               ttf_fault_name(b->faults[i].kind), (double)b->faults[i].at_ns / 1e9,
               (double)b->faults[i].duration_ns / 1e9, b->faults[i].rate_per_million,
               (long long)b->faults[i].amount, b->faults[i].target);
    printf("  stops %lld %lld %lld, little room %lld to %lld, %u failures at %lld, "
           "killed %d operations after %lld\n",
           (long long)c->stop_at[0], (long long)c->stop_at[1], (long long)c->stop_at[2],
           (long long)c->full_from, (long long)c->full_until, c->fail_count, (long long)c->fail_at,
           c->kill_after, (long long)c->kill_at);
    chaos_second_describe(c);
    chaos_asks_describe(c);
}
