/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Time in every combination: at which moment of a slot UTC steps, by how much, who
 * vouched for it, when the power goes, and what the clock knows after it.
 *
 *   test_run_time        a part of them, spread evenly
 *   test_run_time all    all
 *
 * Whatever happens: one record for each index and none renumbered; the grid lies on
 * the boot clock; labels are what the clock believed last, within what it vouched for;
 * the lamps keep their days, and their limits.
 */
#include "cmocka_includes.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "sim_run.h"
#include "ttf/base/attr.h"
#include "utc_script.h"

#define S TTF_NS_PER_S

/* Of all cases every so manieth is in the plain test: coprime to each dimension. */
#define STRIDE 29

#define SLOTS     10
#define BOOTS_MAX 4
#define SAMPLES   4096

/* A step is seen at the next tick of 2 s; later it may wait for the committer, in a run that is cut. */
#define SEEN_NS (10 * S)

/* Slots 3 and 4 are where it happens. */
#define SLOT 3

static const struct {
    const char *name;
    int64_t after_due_ns;
} moments[] = {
    {"before it is due", -30 * S},    {"while the lamp settles", -5 * S},
    {"while it is exposed", 0},       {"between exposure and commit", 1 * S},
    {"while it is committed", 3 * S},
};

static const int64_t steps_s[] = {0, 3600, -3600, 86400, -86400, INT64_C(-56) * 366 * 86400};

static const struct {
    enum ttf_trust trust;
    bool late; /* nobody vouches until the step */
} trusts[] = {
    {TTF_TRUST_RTC, false},  {TTF_TRUST_NTP, false}, {TTF_TRUST_HOST, false},
    {TTF_TRUST_NONE, false}, {TTF_TRUST_NTP, true},
};

static const struct {
    const char *name;
    int64_t after_step_ns; /* TTF_NS_NEVER: the power stays */
    bool kept;
    int64_t given_again_ns;
} cuts[] = {
    {"no cut", TTF_NS_NEVER, true, 0},
    {"cut at once, clock kept", S / 2, true, 0},
    {"cut at once, clock lost", S / 2, false, 0},
    {"cut later, clock kept", 50 * S, true, 0},
    {"cut later, clock lost", 50 * S, false, 0},
    {"cut later, clock given again", 50 * S, false, 100 * S},
    {"step in the outage, clock kept", -40 * S, true, 0},
};

struct boot {
    char id[37];
    int64_t power_on_ns, ended_ns;
};

struct sample {
    int64_t at_ns;
    unsigned permille;
    int64_t on_since_ns; /* boot clock */
    int64_t temp_mdegc;
    unsigned boot;
};

struct timed {
    struct sim_run run; /* first: its callbacks are given this */
    struct utc_script script;
    struct boot boots[BOOTS_MAX];
    unsigned n_boots;
    struct sample samples[SAMPLES];
    unsigned n_samples;
    int64_t told;
    bool tight;         /* limits strike */
    unsigned lit, dark; /* samples of days and of nights */
};

/* ---- running a case ---- */

static void play(struct sim_run *run)
{
    struct timed *t = (struct timed *)run;
    struct boot *boot = &t->boots[t->n_boots];

    assert_true(t->n_boots < BOOTS_MAX);
    utc_script_play(&t->script, run->box, run->config.power_on_ns);
    snprintf(boot->id, sizeof(boot->id), "%s", ttf_clock_boot_id(run->box->clock));
    boot->power_on_ns = run->config.power_on_ns;
}

static int64_t box_temp(const struct sim_run *run)
{
    struct ttf_reading readings[TTF_SENSORS_MAX];
    int n = ttf_sensors_read(run->box->sensors, readings, NULL);

    assert_true(n > 0 && readings[0].ok);
    return readings[0].value;
}

static void look_at_lamp(struct sim_run *run)
{
    struct timed *t = (struct timed *)run;
    struct sample *sample = &t->samples[t->n_samples];
    struct ttf_lamp_state state;

    sample->temp_mdegc = box_temp(run);
    if (t->n_samples == SAMPLES || ttf_lamps_state(run->box->lamps, 0, &state) < 0)
        return;
    sample->at_ns = ttf_sim_elapsed_ns(run->box, ttf_clock_now_ns(run->box->clock));
    sample->permille = state.actual_permille;
    sample->on_since_ns = state.on_since_ns;
    sample->boot = t->n_boots;
    t->n_samples++;
}

static void slot_told(struct sim_run *run, const struct ttf_progress *progress)
{
    struct timed *t = (struct timed *)run;

    if (progress->kind != TTF_PROGRESS_SLOT)
        return;
    assert_int_equal(progress->index, t->told + 1);
    t->told = progress->index;
}

/* Days of 100 s in every 222 s, a lamp that may burn for little more, and slow work. */
static void make_plan(struct timed *t)
{
    struct sim_run *run = &t->run;
    struct ttf_lamp_info *left = &run->config.lamps[0].info;

    sim_run_init(run);
    run->scene = "chart";
    run->config.width = 26;
    run->config.height = 22;
    run->config.cost_develop_ns = 2 * S;
    run->config.cost_commit_ns = 2 * S;
    run->plan.count = SLOTS;
    run->plan.lamps = TTF_LAMPS_PHOTOPERIOD;
    run->plan.period_ns = 222 * S;
    run->plan.day_ns = 100 * S;
    run->plan.phase_ns = 30 * S;
    run->plan.n_day_levels = 1;
    run->plan.day_levels[0] = (struct ttf_lamp_level){.lamp = "left", .permille = 700};
    left->max_on_ns = 130 * S;
    if (t->tight) {
        /* A day and the shots of a night take some 60 % of a period; a day alone heats the box beyond its limit. */
        left->max_duty_permille = 700;
        left->duty_window_ns = run->plan.period_ns;
        run->config.heat_tau_ns = 60 * S;
        run->config.lamps[0].heat_degc = 20;
        left->max_temp_mdegc = 31000;
        left->hysteresis_mdegc = 2000;
    }
    run->on_box = play;
    run->on_file = look_at_lamp;
    run->on_progress = slot_told;
    t->told = -1;
}

static void run_case(struct timed *t)
{
    int r;

    do {
        r = sim_run_boot(&t->run);
        t->boots[t->n_boots++].ended_ns = t->run.ended_ns;
        t->run.config.power_on_ns = t->run.back_ns;
        if (r == -ESHUTDOWN) {
            /* What was written while the power went was not told any more. */
            char results[64];

            sim_run_results(&t->run, results, sizeof(results));
            t->told = (int64_t)strlen(results) - 1;
        }
    } while (r == -ESHUTDOWN);
    assert_int_equal(r, 0);
}

/* ---- what must hold ---- */

struct view {
    const struct timed *t;
    struct ttf_reader *reader;
    struct ttf_slot_record record[SLOTS];
    const struct boot *boot[SLOTS];
    struct ttf_segment segment[SLOTS];
    int64_t due_ns[SLOTS]; /* since the first power-on */
};

static void read_all(struct view *v, const struct timed *t)
{
    v->t = t;
    assert_int_equal(ttf_reader_open(ttf_io_posix(), t->run.path, &v->reader, NULL), 0);
    assert_int_equal(ttf_reader_summary(v->reader)->slots, SLOTS);
    for (int64_t k = 0; k < SLOTS; k++) {
        unsigned b = 0;

        assert_int_equal(ttf_reader_slot(v->reader, k, &v->record[k], NULL), 0);
        assert_int_equal(v->record[k].index, k);
        assert_int_equal(ttf_reader_segment(v->reader, v->record[k].segment, &v->segment[k]), 0);
        while (b < t->n_boots && strcmp(t->boots[b].id, v->segment[k].boot_id) != 0)
            b++;
        assert_true(b < t->n_boots);
        v->boot[k] = &t->boots[b];
        v->due_ns[k] = v->record[k].due_ns + v->boot[k]->power_on_ns;
    }
}

static void forget_all(struct view *v)
{
    for (int64_t k = 0; k < SLOTS; k++)
        ttf_slot_record_free(&v->record[k]);
    ttf_reader_close(v->reader);
}

/* Captured, at its time; lost only to a box without power, or just back. */
static void check_slots(const struct view *v)
{
    for (int64_t k = 0; k < SLOTS; k++) {
        const struct ttf_slot_record *r = &v->record[k];

        if (r->result == TTF_RESULT_POWER ||
            strcmp(r->reason, "the box was getting ready") == 0) /* after it */
            continue;
        assert_int_equal(r->result, TTF_RESULT_CAPTURED);
        assert_string_equal(r->images[0].flags, "");
        assert_in_range(r->middle_ns - r->due_ns + TTF_NS_PER_MS, 0, 2 * TTF_NS_PER_MS);
    }
}

/* On one boot's clock the grid is rigid, whatever UTC did. */
static void check_grid(const struct view *v)
{
    for (int64_t k = 1; k < SLOTS; k++)
        if (v->boot[k] == v->boot[k - 1])
            assert_true(v->due_ns[k] - v->due_ns[k - 1] == TTF_NS_PER_MIN);
}

/* UTC offset that the segment's line gives in the end; TTF_NS_UNKNOWN. */
static int64_t label_offset(const struct view *v, int64_t k)
{
    const struct ttf_segment *s = &v->segment[k];

    if (s->origin_utc_ns == TTF_NS_UNKNOWN)
        return TTF_NS_UNKNOWN;
    return s->origin_utc_ns - (s->origin_ns + v->boot[k]->power_on_ns);
}

static bool trusted_at(const struct view *v, const struct boot *boot, int64_t at, int64_t *ret)
{
    enum ttf_trust trust;

    *ret = utc_script_offset_ns(&v->t->script, boot->power_on_ns, at, &trust);
    return trust != TTF_TRUST_NONE;
}

/* Such a clock stands before the last slot of the boot before, and is vouched for no better than that was. */
static bool contradicts(const struct view *v, int64_t k, int64_t offset_ns, enum ttf_trust trust)
{
    while (k > 0 && v->boot[k - 1] == v->boot[k])
        k--;
    if (k == 0 || label_offset(v, k - 1) == TTF_NS_UNKNOWN ||
        strcmp(ttf_trust_name(trust), v->segment[k - 1].trust) != 0)
        return false; /* the only other one that comes is NTP, the best */
    return v->boot[k]->power_on_ns + 3 * S + offset_ns < v->due_ns[k - 1] + label_offset(v, k - 1);
}

/* For slot k; trusted, and not contradicted. */
static bool believed_at(const struct view *v, int64_t k, int64_t at, int64_t *ret)
{
    enum ttf_trust trust;

    *ret = utc_script_offset_ns(&v->t->script, v->boot[k]->power_on_ns, at, &trust);
    return trust != TTF_TRUST_NONE && !contradicts(v, k, *ret, trust);
}

/* What the clock believed last, while somebody vouched for it, and nothing spoke against it. */
static void check_labels(const struct view *v)
{
    for (int64_t k = 0; k < SLOTS; k++) {
        const struct boot *boot = v->boot[k];
        int64_t label = label_offset(v, k);
        int64_t seen, end, first;
        bool known = believed_at(v, k, boot->ended_ns - SEEN_NS, &seen);
        bool known_end = believed_at(v, k, boot->ended_ns, &end);
        bool known_first = believed_at(v, k, boot->power_on_ns + S, &first);

        if (!known && !known_end && !known_first) {
            assert_true(label == TTF_NS_UNKNOWN);
            assert_string_equal(v->segment[k].trust, "none");
            continue;
        }
        if (label == TTF_NS_UNKNOWN) {
            assert_false(known || known_first); /* at the last moment, unseen */
            continue;
        }
        /* A clock that lost its trust corrects nothing. */
        assert_true((known && label == seen) || (known_end && label == end) ||
                    (!known && known_first && label == first) ||
                    (!known_end && known_first && label == first));
        assert_true(strcmp(v->segment[k].trust, "none") != 0);
        assert_true(
            v->segment[k].uncertainty_ns ==
            utc_script_uncertainty_ns(strcmp(v->segment[k].trust, "rtc") == 0   ? TTF_TRUST_RTC
                                      : strcmp(v->segment[k].trust, "ntp") == 0 ? TTF_TRUST_NTP
                                                                                : TTF_TRUST_HOST));
        assert_true(ttf_reader_due_utc_ns(v->reader, &v->record[k]) == v->due_ns[k] + label);
    }
}

/* A PC alone says that the outage took all slots from k on: it is not believed in that. */
static bool gives_up_all(const struct view *v, int64_t k, int64_t utc_ns, int64_t last_utc_ns)
{
    return v->t->script.trust == TTF_TRUST_HOST &&
           utc_ns > last_utc_ns + (SLOTS - k) * TTF_NS_PER_MIN;
}

/* Over a cut: the same grid in UTC where UTC tells it, else on at once; and the gap says which. */
static void check_over_cut(const struct view *v, int64_t k)
{
    const struct boot *boot = v->boot[k];
    const struct ttf_segment *s = &v->segment[k];
    int64_t before = label_offset(v, k - 1);
    int64_t after = label_offset(v, k);
    int64_t now;
    bool known = trusted_at(v, boot, boot->power_on_ns + S, &now);
    int64_t last_utc = before == TTF_NS_UNKNOWN ? 0 : v->due_ns[k - 1] + before;

    assert_int_equal(s->first_index, k);
    if (known && before != TTF_NS_UNKNOWN && boot->power_on_ns + 3 * S + now >= last_utc &&
        !gives_up_all(v, k, boot->power_on_ns + 3 * S + now, last_utc)) {
        assert_true(v->due_ns[k] + now == last_utc + TTF_NS_PER_MIN);
        if (now == before)
            assert_true(v->due_ns[k] - v->due_ns[k - 1] == TTF_NS_PER_MIN);
        assert_int_equal(s->gap_ns, 0);
        return;
    }
    assert_int_equal(v->record[k].result, TTF_RESULT_CAPTURED);
    assert_in_range(v->due_ns[k] - boot->power_on_ns, 10 * S, 20 * S);
    if (before == TTF_NS_UNKNOWN || after == TTF_NS_UNKNOWN || known) {
        assert_true(s->gap_ns == TTF_NS_UNKNOWN);
    } else {
        int64_t gap = v->due_ns[k] + after - (last_utc + TTF_NS_PER_MIN);

        assert_true(s->gap_ns == (gap > 0 ? gap : gap < -TTF_NS_PER_MIN ? TTF_NS_UNKNOWN : 0));
    }
}

/* Lit in the days that count from slot 0's place on the grid; never longer than it may. */
static void check_days(const struct view *v, unsigned *ret_lit, unsigned *ret_dark)
{
    const struct ttf_plan *plan = &v->t->run.plan;
    unsigned lit = 0;
    unsigned dark = 0;

    for (unsigned i = 0; i < v->t->n_samples; i++) {
        const struct sample *sample = &v->t->samples[i];
        int64_t grid = TTF_NS_UNKNOWN;
        int64_t in_slot, in_day;

        if (sample->on_since_ns != TTF_NS_UNKNOWN)
            assert_true(sample->at_ns - v->t->boots[sample->boot].power_on_ns -
                            sample->on_since_ns <=
                        v->t->run.config.lamps[0].info.max_on_ns);
        for (int64_t k = 0; k < SLOTS && grid == TTF_NS_UNKNOWN; k++)
            if (v->boot[k] == &v->t->boots[sample->boot])
                grid = v->due_ns[k] - k * plan->interval_ns;
        if (grid == TTF_NS_UNKNOWN)
            continue;
        in_slot = (sample->at_ns - grid + 1000 * plan->interval_ns) % plan->interval_ns;
        in_day = (sample->at_ns - grid - plan->phase_ns + 1000 * plan->period_ns) % plan->period_ns;
        /* Between slots, from the first one of this boot on. */
        if (in_slot < S || in_slot > plan->interval_ns - 20 * S || in_day < S ||
            llabs(in_day - plan->day_ns) < S ||
            sample->at_ns < v->t->boots[sample->boot].power_on_ns + 20 * S ||
            sample->at_ns > v->due_ns[SLOTS - 1])
            continue;
        assert_int_equal(sample->permille, in_day < plan->day_ns ? 700 : 0);
        lit += in_day < plan->day_ns;
        dark += in_day >= plan->day_ns;
    }
    *ret_lit += lit;
    *ret_dark += dark;
}

/* ---- limits that strike ---- */

/* A lamp that got hot between two readings, a second apart. */
#define HEAT_A_SECOND_MDEGC 350

struct lit_stretch {
    int64_t from, to; /* since the first power-on: as far as it was seen */
};

/* What was seen of the lamp's burning: no more than it did. */
static unsigned seen_lit(const struct timed *t, struct lit_stretch *ret)
{
    unsigned n = 0;

    for (unsigned i = 0; i < t->n_samples; i++) {
        const struct sample *sample = &t->samples[i];
        int64_t from;

        if (sample->on_since_ns == TTF_NS_UNKNOWN)
            continue;
        from = t->boots[sample->boot].power_on_ns + sample->on_since_ns;
        if (n == 0 || ret[n - 1].from != from)
            ret[n++] = (struct lit_stretch){from, from};
        ret[n - 1].to = sample->at_ns;
    }
    return n;
}

/* In no window that ends with a stretch is it lit longer than it may, over cuts as well; nor is it ever lit too hot. */
static void check_limits(const struct timed *t)
{
    static struct lit_stretch lit[SAMPLES];
    const struct ttf_lamp_info *left = &t->run.config.lamps[0].info;
    unsigned n = seen_lit(t, lit);

    for (unsigned a = 0; a < n; a++) {
        int64_t begin = lit[a].to - left->duty_window_ns, used = 0;

        assert_true(lit[a].to - lit[a].from <= left->max_on_ns);
        for (unsigned b = 0; b <= a; b++)
            if (lit[b].to > begin)
                used += lit[b].to - (lit[b].from > begin ? lit[b].from : begin);
        assert_true(used <= left->duty_window_ns / 1000 * left->max_duty_permille);
    }
    for (unsigned i = 0; i < t->n_samples; i++)
        if (t->samples[i].permille > 0)
            assert_true(t->samples[i].temp_mdegc <= left->max_temp_mdegc + HEAT_A_SECOND_MDEGC);
}

static void check_tight(struct timed *t, unsigned *ret_hot, unsigned *ret_duty)
{
    struct view v;

    sim_run_expect_whole(&t->run, true);
    read_all(&v, t);
    check_grid(&v);
    check_limits(t);
    *ret_hot += sim_run_events(&t->run, "lamp-trip", "temp");
    *ret_duty += sim_run_events(&t->run, "lamp-trip", "duty");
    forget_all(&v);
}

/* Steps that were seen are told, once each. */
static void check_events(const struct view *v)
{
    const struct timed *t = v->t;
    const struct boot *boot = NULL;
    unsigned steps = sim_run_events(&t->run, "clock-step", NULL);
    bool moves = t->script.step_ns != 0 || t->script.trusted_at_ns == t->script.step_at_ns;

    for (unsigned b = 0; b < t->n_boots; b++)
        if (t->script.step_at_ns > t->boots[b].power_on_ns + S &&
            t->script.step_at_ns < t->boots[b].ended_ns - SEEN_NS)
            boot = &t->boots[b];
    if (t->script.trusted_at_ns == TTF_NS_NEVER)
        moves = false;
    if (boot && boot == &t->boots[0] && moves)
        assert_true(steps >= 1);
    assert_true(steps <= 2);
    assert_int_equal(sim_run_events(&t->run, "lamp-trip", NULL), 0);
}

static void check_case(struct timed *t)
{
    struct view v;

    sim_run_expect_whole(&t->run, true);
    read_all(&v, t);
    check_slots(&v);
    check_grid(&v);
    check_labels(&v);
    for (int64_t k = 1; k < SLOTS; k++)
        if (v.boot[k] != v.boot[k - 1])
            check_over_cut(&v, k);
    check_days(&v, &t->lit, &t->dark);
    check_events(&v);
    forget_all(&v);
}

/* ---- the cases ---- */

#define CASES \
    (TTF_COUNT_OF(moments) * TTF_COUNT_OF(steps_s) * TTF_COUNT_OF(trusts) * TTF_COUNT_OF(cuts))

static unsigned stride = STRIDE;
static int64_t slot_due_ns;

/* Where slot SLOT is due without any trouble: found by a run. */
static int64_t find_due(void)
{
    struct timed *t = calloc(1, sizeof(*t));
    int64_t due;

    assert_non_null(t);
    make_plan(t);
    t->script = (struct utc_script){.start_utc_ns = t->run.config.start_utc_ns,
                                    .trust = TTF_TRUST_NTP,
                                    .step_at_ns = TTF_NS_NEVER,
                                    .kept = true};
    run_case(t);
    check_case(t);
    due = sim_run_due_ns(&t->run, SLOT);
    sim_run_finish(&t->run);
    free(t);
    return due;
}

/* Of an ordinary case: samples by day and by night; of a tight one: trips for heat and for duty. */
static void one_case(unsigned i, bool tight, unsigned *ret_lit, unsigned *ret_dark)
{
    unsigned m = i % TTF_COUNT_OF(moments);
    unsigned s = i / TTF_COUNT_OF(moments) % TTF_COUNT_OF(steps_s);
    unsigned w = i / TTF_COUNT_OF(moments) / TTF_COUNT_OF(steps_s) % TTF_COUNT_OF(trusts);
    unsigned c = i / TTF_COUNT_OF(moments) / TTF_COUNT_OF(steps_s) / TTF_COUNT_OF(trusts);
    struct timed *t = calloc(1, sizeof(*t));
    int64_t at = slot_due_ns + moments[m].after_due_ns;

    assert_non_null(t);
    t->tight = tight;
    make_plan(t);
    t->script = (struct utc_script){
        .start_utc_ns = t->run.config.start_utc_ns,
        .trust = trusts[w].trust,
        .trusted_at_ns = trusts[w].late                      ? at
                         : trusts[w].trust == TTF_TRUST_NONE ? TTF_NS_NEVER
                                                             : 0,
        .step_at_ns = at,
        .step_ns = steps_s[s] * S,
        .kept = cuts[c].kept,
        .given_again_ns = cuts[c].given_again_ns,
    };
    if (cuts[c].after_step_ns != TTF_NS_NEVER)
        sim_run_fault(&t->run, TTF_FAULT_POWER_CUT, at + cuts[c].after_step_ns)->amount = 130;
    print_message("%u: UTC (%s%s) steps by %+d s %s of slot %d, %s\n", i,
                  ttf_trust_name(trusts[w].trust), trusts[w].late ? " from then on" : "",
                  (int)steps_s[s], moments[m].name, SLOT, cuts[c].name);
    run_case(t);
    if (tight) {
        check_tight(t, ret_lit, ret_dark);
    } else {
        check_case(t);
        *ret_lit += t->lit;
        *ret_dark += t->dark;
    }
    sim_run_finish(&t->run);
    free(t);
}

static void time_in_every_combination_costs_no_slot_and_no_label(void **state)
{
    unsigned lit = 0;
    unsigned dark = 0;

    (void)state;
    slot_due_ns = find_due();
    for (unsigned i = 0; i < CASES; i += stride)
        one_case(i, false, &lit, &dark);
    /* The lamps were looked at by day and by night. */
    assert_true(lit > CASES / stride && dark > CASES / stride);
}

static void limits_that_strike_are_kept_through_steps_and_cuts(void **state)
{
    unsigned hot = 0;
    unsigned duty = 0;

    (void)state;
    slot_due_ns = find_due();
    /* Fewer than the others: 43 is coprime to each dimension, too. */
    for (unsigned i = 0; i < CASES; i += stride == 1 ? 1 : 43)
        one_case(i, true, &hot, &duty);
    print_message("%u trips for heat, %u for duty\n", hot, duty);
    assert_true(hot > 0 && duty > 0);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(time_in_every_combination_costs_no_slot_and_no_label),
        cmocka_unit_test(limits_that_strike_are_kept_through_steps_and_cuts),
    };

    if (argc > 1 && strcmp(argv[1], "all") == 0)
        stride = 1;
    return cmocka_run_group_tests(tests, NULL, NULL);
}
