/* SPDX-License-Identifier: Apache-2.0 */
/* Runs that end at an instant or after a time: they do, whatever happens to the box and its clock; and what their end says. */
#include "cmocka_includes.h"

#include <errno.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "living.h"
#include "ttf/hal/clock_backend.h"

#define S   TTF_NS_PER_S
#define MIN TTF_NS_PER_MIN

/* A slot each minute from power-on + 12 s on, until so many have been due. */
static void until_init(struct sim_run *run, enum ttf_plan_end end, int64_t slots)
{
    living_init(run);
    run->plan.count = slots;
    run->plan.end = end;
    if (end == TTF_END_UNTIL)
        run->plan.until_utc_ns = run->config.start_utc_ns + slots * MIN;
    if (end == TTF_END_LENGTH)
        run->plan.length_ns = (slots - 1) * MIN + 30 * S;
}

static void expect_end(struct sim_run *run, const char *letters, const char *reason)
{
    char *text = sim_run_text(run, "records.jsonl");
    char what[64];
    const char *end;

    assert_non_null(text);
    sim_run_expect(run, letters);
    assert_true(run->result.sealed);
    end = strstr(text, "\"type\":\"end\"");
    assert_non_null(end);
    snprintf(what, sizeof(what), "\"reason\":\"%s\"", reason);
    if (!strstr(end, what))
        print_error("not %s: %s\n", what, end);
    assert_non_null(strstr(end, what));
    free(text);
    run->plan.count = (int64_t)strlen(letters);
    assert_int_equal(run->result.total, run->plan.count);
    sim_run_expect_whole(run, true);
}

/* Of a box that keeps no time, dark from 3:40 on for so long; NTP gives the time `back` after it has power again. */
static void dark(struct sim_run *run, int64_t amount_s, int64_t back)
{
    run->config.rtc = false;
    run->config.utc_back_ns = back;
    sim_run_fault(run, TTF_FAULT_POWER_CUT, 3 * MIN + 40 * S)->amount = amount_s;
}

/* ---- a box that believes what it is told of UTC ---- */

/* From an instant since the first power-on on. */
struct belief {
    int64_t from_ns;
    enum ttf_trust trust;
    int64_t ahead_ns;
};

struct believer {
    struct sim_run run; /* first: its callbacks are given this */
    struct ttf_clock_ops ops;
    const struct belief *beliefs;
    unsigned n;
};

static const struct believer *believer_of(const struct ttf_clock *clock)
{
    return (const struct believer *)((const char *)clock->ops - offsetof(struct believer, ops));
}

static void believed_utc(struct ttf_clock *clock, struct ttf_utc *ret)
{
    const struct believer *b = believer_of(clock);
    int64_t at;
    unsigned i = 0;

    ret->boot_ns = ttf_clock_now_ns(clock);
    at = ttf_sim_elapsed_ns(b->run.box, ret->boot_ns);
    while (i + 1 < b->n && at >= b->beliefs[i + 1].from_ns)
        i++;
    ret->utc_ns = b->run.config.start_utc_ns + at + b->beliefs[i].ahead_ns;
    ret->trust = b->beliefs[i].trust;
    ret->uncertainty_ns = ret->trust == TTF_TRUST_NONE ? TTF_NS_UNKNOWN : S;
    ret->steps = 0;
}

static void believe(struct sim_run *run)
{
    struct believer *b = (struct believer *)run;

    b->ops = *run->box->clock->ops;
    b->ops.utc = believed_utc;
    run->box->clock->ops = &b->ops;
}

static void believer_init(struct believer *b, enum ttf_plan_end end, int64_t slots,
                          const struct belief *beliefs, unsigned n)
{
    until_init(&b->run, end, slots);
    b->run.on_box = believe;
    b->beliefs = beliefs;
    b->n = n;
}

static void undisturbed_it_ends_as_it_was_reckoned_and_says_why(void **state)
{
    struct sim_run run;

    (void)state;
    until_init(&run, TTF_END_UNTIL, 4);
    assert_int_equal(sim_run_boot(&run), 0);
    sim_run_expect_text(&run, "plans/0.json", "\"end\": \"until\"");
    expect_end(&run, "cccc", "until");
    living_finish(&run);
    until_init(&run, TTF_END_LENGTH, 4);
    assert_int_equal(sim_run_boot(&run), 0);
    sim_run_expect_text(&run, "plans/0.json", "\"end\": \"length\"");
    expect_end(&run, "cccc", "until");
    living_finish(&run);
    until_init(&run, TTF_END_COUNT, 4);
    assert_int_equal(sim_run_boot(&run), 0);
    expect_end(&run, "cccc", "count");
    living_finish(&run);
}

/* Once the clock is back the run ends where it was to end: no slot stands for the outage. */
static void after_an_outage_of_unknown_length_it_ends_at_its_instant(void **state)
{
    static const enum ttf_plan_end ends[] = {TTF_END_UNTIL, TTF_END_LENGTH};

    (void)state;
    for (unsigned i = 0; i < 2; i++) {
        struct sim_run run;

        /* Slots 0 to 3; dark until 6:40; slots at 6:52, 7:52 (the clock is back at 8:10), 8:52, 9:52. */
        until_init(&run, ends[i], 10);
        dark(&run, 180, 90 * S);
        assert_int_equal(sim_run_through_cuts(&run), 0);
        assert_int_equal(
            sim_run_events(&run, "plan", i == 0 ? "8 slots instead of 10" : "7 slots instead"), 1);
        expect_end(&run, i == 0 ? "cccccccc" : "ccccccc", "until"); /* of a length until 9:42 */
        living_finish(&run);
    }
}

static int64_t totals[64];
static unsigned n_totals, told_wrong, told_right;

static void note_total(struct sim_run *run, const struct ttf_progress *p)
{
    (void)run;
    if (n_totals == 0 || p->total != totals[n_totals - 1])
        totals[n_totals++ % 64] = p->total;
    if (p->kind != TTF_PROGRESS_EVENT || !strstr(p->text, " slots instead of "))
        return;
    if (p->total == strtoll(p->text, NULL, 10))
        told_right++;
    else
        told_wrong++;
}

/* After the first boot its records cannot be written from its first minute on, for one. */
static int records_wait(struct sim_run *run, const char *op, const char *path)
{
    int64_t now_ns = run->box ? ttf_clock_now_ns(run->box->clock) : 0;

    (void)op;
    return run->committed >= 4 && now_ns > 60 * S && now_ns < 110 * S &&
                   sim_run_path_ends(path, "/records.jsonl")
               ? EIO
               : 0;
}

/* The event that says so, as the next slot may be hours away; and none tells an older one than is known. */
static void who_watches_is_told_of_another_end_at_once(void **state)
{
    struct sim_run run;

    (void)state;
    until_init(&run, TTF_END_UNTIL, 10);
    dark(&run, 180, 90 * S);
    n_totals = told_right = told_wrong = 0;
    run.on_progress = note_total;
    assert_int_equal(sim_run_through_cuts(&run), 0);
    assert_int_equal(n_totals, 2);
    assert_int_equal(totals[0], 10);
    assert_int_equal(totals[1], 8);
    assert_int_equal(told_right, 1);
    assert_int_equal(told_wrong, 0);
    living_finish(&run);
}

/* The plan as it is stored says 8 slots, and its clock that was two minutes late made 6 of them. */
static void gone_on_with_its_first_event_tells_no_older_end(void **state)
{
    struct sim_run run;

    (void)state;
    until_init(&run, TTF_END_UNTIL, 8);
    sim_run_fault(&run, TTF_FAULT_CLOCK_STEP, 2 * MIN + 40 * S)->amount = 120;
    sim_run_fault(&run, TTF_FAULT_POWER_CUT, 3 * MIN + 40 * S)->amount = 30;
    n_totals = 0;
    run.on_progress = note_total;
    assert_int_equal(sim_run_through_cuts(&run), 0);
    assert_true(sim_run_events(&run, "resume", "on the same grid") > 0);
    assert_int_equal(n_totals, 2);
    assert_int_equal(totals[0], 8);
    assert_int_equal(totals[1], 6);
    living_finish(&run);
}

static void another_end_is_not_taken_back_by_a_record_that_waited(void **state)
{
    struct sim_run run;

    (void)state;
    until_init(&run, TTF_END_UNTIL, 10);
    dark(&run, 180, 90 * S);
    run.fault = records_wait;
    n_totals = 0;
    run.on_progress = note_total;
    assert_int_equal(sim_run_through_cuts(&run), 0);
    assert_int_equal(n_totals, 2);
    assert_int_equal(totals[1], 8);
    assert_int_equal(run.result.slots, 8);
    assert_true(run.result.sealed);
    living_finish(&run);
}

static void an_outage_past_its_instant_ends_it_as_soon_as_that_is_known(void **state)
{
    static const enum ttf_plan_end ends[] = {TTF_END_UNTIL, TTF_END_LENGTH};

    (void)state;
    for (unsigned i = 0; i < 2; i++) {
        struct sim_run run;

        until_init(&run, ends[i], 10);
        dark(&run, 86400, 90 * S);
        assert_int_equal(sim_run_through_cuts(&run), 0);
        assert_int_equal(sim_run_events(&run, "plan", "the plan's end has come"), 1);
        expect_end(&run, "cccccc", "until"); /* two at once, as nobody knew */
        living_finish(&run);
    }
}

/* With hours between slots it is not waited for the next one. */
static void it_ends_in_the_middle_of_a_long_wait(void **state)
{
    struct sim_run run;
    int64_t power_on;

    (void)state;
    until_init(&run, TTF_END_UNTIL, 10);
    run.plan.interval_ns = 10 * TTF_NS_PER_H;
    run.plan.count = 5;
    run.plan.until_utc_ns = run.config.start_utc_ns + 45 * TTF_NS_PER_H;
    run.config.rtc = false;
    run.config.utc_back_ns = TTF_NS_PER_H;
    sim_run_fault(&run, TTF_FAULT_POWER_CUT, 11 * TTF_NS_PER_H)->amount = 7 * 86400;
    assert_int_equal(sim_run_boot(&run), -ESHUTDOWN);
    power_on = run.config.power_on_ns = run.back_ns;
    assert_int_equal(sim_run_boot(&run), 0);
    expect_end(&run, "ccc", "until");
    assert_in_range(run.ended_ns - power_on, TTF_NS_PER_H, TTF_NS_PER_H + 10 * S);
    living_finish(&run);
}

static void while_nobody_knows_it_comes_to_as_many_as_before(void **state)
{
    struct sim_run run;

    (void)state;
    until_init(&run, TTF_END_UNTIL, 8);
    dark(&run, 86400, 0);
    assert_int_equal(sim_run_through_cuts(&run), 0);
    expect_end(&run, "cccccccc", "until");
    living_finish(&run);
}

/* The outage has its slots, and they are all that there were to be. */
static void an_outage_of_known_length_changes_nothing(void **state)
{
    struct sim_run run;

    (void)state;
    until_init(&run, TTF_END_UNTIL, 8);
    sim_run_fault(&run, TTF_FAULT_POWER_CUT, 3 * MIN + 40 * S)->amount = 86400;
    assert_int_equal(sim_run_through_cuts(&run), 0);
    expect_end(&run, "ccccwwww", "until");
    living_finish(&run);
}

static void another_interval_ends_at_the_same_instant(void **state)
{
    static const enum ttf_plan_end ends[] = {TTF_END_UNTIL, TTF_END_LENGTH};

    (void)state;
    for (unsigned i = 0; i < 2; i++) {
        struct sim_run run;
        int64_t n;

        until_init(&run, ends[i], 6); /* the end at 6:00 or 5:42 */
        n = living_ask(&run, &(struct ttf_ask){
                                 .kind = TTF_ASK_INTERVAL, .from_index = 3, .interval_ns = 25 * S});
        assert_int_equal(sim_run_boot(&run), 0);
        living_expect_done(&run, n);
        /* 0:12, 1:12, 2:12, then 2:37, 3:02, ..., 5:32 (and 5:57 before 6:00) */
        expect_end(&run, i == 0 ? "cccccccccccc" : "ccccccccccc", "until");
        sim_run_expect_text(&run, "plans/1.json", i == 0 ? "\"count\": 12" : "\"count\": 11");
        living_finish(&run);
    }
}

static void asked_for_while_it_runs_it_holds_over_all_of_that(void **state)
{
    struct sim_run run;
    int64_t until, interval;

    (void)state;
    until_init(&run, TTF_END_COUNT, 4);
    until = living_ask(&run, &(struct ttf_ask){.kind = TTF_ASK_UNTIL,
                                               .from_index = 1,
                                               .until_utc_ns = run.config.start_utc_ns + 10 * MIN});
    interval = living_ask(
        &run, &(struct ttf_ask){.kind = TTF_ASK_INTERVAL, .from_index = 3, .interval_ns = 30 * S});
    dark(&run, 180, 90 * S);
    assert_int_equal(sim_run_through_cuts(&run), 0);
    living_expect_done(&run, until);
    living_expect_done(&run, interval);
    sim_run_expect_text(&run, "plans/2.json", "\"until_utc_ns\"");
    /* 0:12, 1:12, 2:12, 2:42, 3:12; dark; each half minute from 6:52 on, seven before 10:00 */
    expect_end(&run, "cccccccccccc", "until");
    living_finish(&run);
}

static void a_clock_that_is_corrected_moves_it(void **state)
{
    static const struct {
        int64_t step_s;
        const char *letters;
    } cases[] = {{120, "cccc"}, {-120, "cccccccc"}, {7200, "ccc"}};

    (void)state;
    for (unsigned i = 0; i < 3; i++) {
        struct sim_run run;

        until_init(&run, TTF_END_UNTIL, 6);
        sim_run_fault(&run, TTF_FAULT_CLOCK_STEP, 2 * MIN + 40 * S)->amount = cases[i].step_s;
        assert_int_equal(sim_run_boot(&run), 0);
        expect_end(&run, cases[i].letters, "until");
        living_finish(&run);
        /* Of a length there is nothing that UTC could say. */
        until_init(&run, TTF_END_LENGTH, 6);
        sim_run_fault(&run, TTF_FAULT_CLOCK_STEP, 2 * MIN + 40 * S)->amount = cases[i].step_s;
        assert_int_equal(sim_run_boot(&run), 0);
        expect_end(&run, "cccccc", "until");
        living_finish(&run);
    }
}

/* While the last slot is exposed: there are more to come, though it was the last. */
static void a_clock_corrected_in_the_last_slot_makes_it_another_than_the_last(void **state)
{
    struct sim_run run;

    (void)state;
    until_init(&run, TTF_END_UNTIL, 4);
    run.plan.shots[0].exposure.exposure_ns = 5 * S;
    sim_run_fault(&run, TTF_FAULT_CLOCK_STEP, 3 * MIN + 14 * S)->amount = -120;
    assert_int_equal(sim_run_boot(&run), 0);
    expect_end(&run, "cccccc", "until");
    living_finish(&run);
}

static void once_ended_it_has_ended_whatever_the_clock_says_later(void **state)
{
    struct sim_run run;
    char digest[65];

    (void)state;
    until_init(&run, TTF_END_UNTIL, 4);
    assert_int_equal(sim_run_boot(&run), 0);
    memcpy(digest, run.result.digest, sizeof(digest));
    run.config.power_on_ns = run.ended_ns + MIN;
    sim_run_fault(&run, TTF_FAULT_CLOCK_STEP, 1)->amount = -120;
    assert_int_equal(sim_run_boot(&run), 0);
    assert_string_equal(run.result.digest, digest);
    expect_end(&run, "cccc", "until");
    living_finish(&run);
}

/* The network goes, after a while nobody vouches for the clock any more, and somebody's PC offers its time. */
static void a_pc_moves_no_end_that_a_better_clock_of_this_boot_told(void **state)
{
    static const struct belief beliefs[] = {{0, TTF_TRUST_NTP, 0},
                                            {70 * S, TTF_TRUST_NONE, 0},
                                            {130 * S, TTF_TRUST_HOST, 2 * MIN},
                                            {190 * S, TTF_TRUST_NONE, 0},
                                            {250 * S, TTF_TRUST_NTP, -MIN}};
    struct believer b;
    char *text;

    (void)state;
    believer_init(&b, TTF_END_UNTIL, 8, beliefs, 4);
    assert_int_equal(sim_run_boot(&b.run), 0);
    text = sim_run_text(&b.run, "records.jsonl");
    assert_null(strstr(text, "\"trust\":\"host\"")); /* nor what the segment says of UTC */
    free(text);
    expect_end(&b.run, "cccccccc", "until");
    living_finish(&b.run);
    believer_init(&b, TTF_END_UNTIL, 8, beliefs, 5); /* the network is back */
    assert_int_equal(sim_run_boot(&b.run), 0);
    expect_end(&b.run, "ccccccccc", "until");
    living_finish(&b.run);
}

/* The same when the run was stopped meanwhile, and when another instant is asked for. */
static void what_it_told_holds_in_the_next_run_of_the_boot(void **state)
{
    static const struct belief network = {0, TTF_TRUST_NTP, 0};
    static const struct belief none[] = {{0, TTF_TRUST_NONE, 0},
                                         {190 * S, TTF_TRUST_HOST, 2 * MIN}};
    struct believer b;
    int64_t n;

    (void)state;
    believer_init(&b, TTF_END_UNTIL, 8, &network, 1);
    living_ask(&b.run, &(struct ttf_ask){.kind = TTF_ASK_STOP, .from_index = 3});
    assert_int_equal(sim_run_boot(&b.run), 0);
    b.beliefs = none;
    b.n = 2;
    assert_int_equal(sim_run_boot(&b.run), 0); /* the boot clock begins anew, the boot does not */
    expect_end(&b.run, "cccccccc", "until");
    living_finish(&b.run);
    believer_init(&b, TTF_END_UNTIL, 8, &network, 1);
    living_ask(&b.run, &(struct ttf_ask){.kind = TTF_ASK_STOP, .from_index = 3});
    assert_int_equal(sim_run_boot(&b.run), 0);
    n = living_ask(&b.run, &(struct ttf_ask){.kind = TTF_ASK_UNTIL,
                                             .from_index = 5,
                                             .until_utc_ns = b.run.config.start_utc_ns + 10 * MIN});
    b.beliefs = none;
    b.n = 2;
    assert_int_equal(sim_run_boot(&b.run), 0);
    living_expect_done(&b.run, n);
    expect_end(&b.run, "cccccccccc", "until");
    living_finish(&b.run);
}

/* Slot 0 is due in ten minutes; a clock says that the last one was a day ago. */
static void a_run_that_waits_for_its_start_is_not_sealed_without_a_slot(void **state)
{
    static const struct belief pc[] = {{0, TTF_TRUST_HOST, 0},
                                       {60 * S, TTF_TRUST_NONE, 0},
                                       {MIN + 9 * S, TTF_TRUST_HOST, 1440 * MIN}};
    static const struct belief network[] = {{0, TTF_TRUST_RTC, 0},
                                            {60 * S, TTF_TRUST_NTP, 1440 * MIN}};
    static const struct belief right = {0, TTF_TRUST_NTP, 0};
    struct believer b;

    (void)state;
    believer_init(&b, TTF_END_UNTIL, 14, pc, 3);
    b.run.plan.count = 4;
    b.run.plan.start_utc_ns = b.run.config.start_utc_ns + 10 * MIN;
    assert_int_equal(sim_run_boot(&b.run), 0); /* a PC's word alone is not believed */
    assert_int_equal(sim_run_events(&b.run, "plan", "not believed alone"), 1);
    expect_end(&b.run, "cccc", "until");
    living_finish(&b.run);
    believer_init(&b, TTF_END_UNTIL, 14, network, 2);
    b.run.plan.count = 4;
    b.run.plan.start_utc_ns = b.run.config.start_utc_ns + 10 * MIN;
    assert_int_equal(sim_run_boot(&b.run), -EINVAL);
    assert_string_equal(b.run.err.where, "until");
    assert_int_equal(b.run.alarms, 1);
    assert_false(b.run.result.sealed);
    sim_run_expect_undamaged(&b.run, false);
    assert_int_equal(sim_run_boot(&b.run), -EINVAL); /* nor when it is run again */
    assert_int_equal(b.run.alarms, 1);               /* which a box does each minute */
    sim_run_expect_undamaged(&b.run, false);
    b.run.plan.until_utc_ns +=
        S; /* a new plan of the kind comes into force no more than the first would */
    assert_int_equal(sim_run_boot(&b.run), -EINVAL);
    assert_string_equal(b.run.err.where, "until");
    assert_null(sim_run_text(&b.run, "plans/1.json"));
    b.run.plan.until_utc_ns -= S;
    b.beliefs = &right;
    b.n = 1;
    assert_int_equal(sim_run_boot(&b.run), 0);
    expect_end(&b.run, "cccc", "until");
    living_finish(&b.run);
}

/* A segment without a slot says where the first was to be, not where the last was: no clock lies behind that. */
static void power_that_fails_before_the_start_lets_a_clock_tell_the_end(void **state)
{
    static const struct belief beliefs[] = {
        {0, TTF_TRUST_NTP, 0}, {2 * MIN, TTF_TRUST_NONE, 0}, {4 * MIN + 30 * S, TTF_TRUST_NTP, 0}};
    struct believer b;

    (void)state;
    believer_init(&b, TTF_END_UNTIL, 34, beliefs, 3);
    b.run.plan.count = 4;
    b.run.plan.start_utc_ns = b.run.config.start_utc_ns + 30 * MIN;
    sim_run_fault(&b.run, TTF_FAULT_POWER_CUT, 2 * MIN + 30 * S)->amount = 60;
    assert_int_equal(sim_run_through_cuts(&b.run), 0);
    assert_int_equal(sim_run_events(&b.run, "plan", "UTC lies before the last slot"), 0);
    /* Without a clock it begins at once, at 3:42. */
    expect_end(&b.run, "ccccccccccccccccccccccccccccccc", "until");
    living_finish(&b.run);
}

/* A boot that knows nothing hears a PC that stands before its last slot; the next one hears nothing. */
static void a_pc_that_is_behind_moves_no_end(void **state)
{
    static const struct belief beliefs[] = {{0, TTF_TRUST_NTP, 0},
                                            {4 * MIN, TTF_TRUST_NONE, 0},
                                            {7 * MIN + 10 * S, TTF_TRUST_HOST, -30 * MIN},
                                            {9 * MIN, TTF_TRUST_NONE, 0}};

    (void)state;
    for (unsigned i = 0; i < 2; i++) {
        struct believer b;

        /* Slots 0 to 3; dark until 6:40; slots at 6:52, 7:52 (the PC is heard before), and so on. */
        believer_init(&b, TTF_END_UNTIL, 8, beliefs, 4);
        sim_run_fault(&b.run, TTF_FAULT_POWER_CUT, 3 * MIN + 40 * S)->amount = 180;
        if (i > 0)
            sim_run_fault(&b.run, TTF_FAULT_POWER_CUT, 8 * MIN + 20 * S)->amount = 60;
        assert_int_equal(sim_run_through_cuts(&b.run), 0);
        assert_int_equal(sim_run_events(&b.run, "plan", "UTC lies before the last slot"), 1);
        expect_end(&b.run, "cccccccc", "until");
        living_finish(&b.run);
    }
}

/* Dark, power for ten seconds, dark again: whoever tells the time then tells both. */
static void power_that_flickers_hides_no_outage_from_a_length(void **state)
{
    static const struct belief at_once[] = {{0, TTF_TRUST_NTP, 0},
                                            {4 * MIN, TTF_TRUST_NONE, 0},
                                            {7 * MIN + 30 * S, TTF_TRUST_NTP, 0},
                                            {8 * MIN + 30 * S, TTF_TRUST_NONE, 0}};
    static const struct belief later[] = {
        {0, TTF_TRUST_NTP, 0}, {4 * MIN, TTF_TRUST_NONE, 0}, {8 * MIN + 30 * S, TTF_TRUST_NTP, 0}};
    static const struct belief a_pc[] = {
        {0, TTF_TRUST_NTP, 0}, {4 * MIN, TTF_TRUST_NONE, 0}, {8 * MIN + 30 * S, TTF_TRUST_HOST, 0}};
    static const struct {
        const struct belief *beliefs;
        unsigned n;
        int64_t cut_ns; /* once more, and no clock behind it */
    } cases[] = {{at_once, 3, 0}, {later, 3, 0}, {a_pc, 3, 0}, {at_once, 4, 8 * MIN + 20 * S}};

    (void)state;
    for (unsigned i = 0; i < sizeof(cases) / sizeof(cases[0]); i++) {
        struct believer b;

        /* Slots at 0:12 to 3:12; 8:02, 9:02; the end at 9:42. */
        believer_init(&b, TTF_END_LENGTH, 10, cases[i].beliefs, cases[i].n);
        sim_run_fault(&b.run, TTF_FAULT_POWER_CUT, 3 * MIN + 40 * S)->amount = 180;
        sim_run_fault(&b.run, TTF_FAULT_POWER_CUT, 6 * MIN + 50 * S)->amount = 60;
        if (cases[i].cut_ns > 0)
            sim_run_fault(&b.run, TTF_FAULT_POWER_CUT, cases[i].cut_ns)->amount = 30;
        assert_int_equal(sim_run_through_cuts(&b.run), 0);
        expect_end(&b.run, "cccccc", "until");
        living_finish(&b.run);
    }
}

/* Where nobody knew better its word counts, as long as slots are left. */
static void a_pc_s_word_tells_the_end_where_nothing_better_was_known(void **state)
{
    static const struct belief beliefs[] = {
        {0, TTF_TRUST_NONE, 0}, {70 * S, TTF_TRUST_HOST, 2 * MIN}, {130 * S, TTF_TRUST_NTP, 0}};
    struct believer b;

    (void)state;
    believer_init(&b, TTF_END_UNTIL, 8, beliefs, 2);
    assert_int_equal(sim_run_boot(&b.run), 0);
    expect_end(&b.run, "cccccc", "until");
    living_finish(&b.run);
    believer_init(&b, TTF_END_UNTIL, 8, beliefs, 3); /* who knows better has the last word */
    assert_int_equal(sim_run_boot(&b.run), 0);
    expect_end(&b.run, "cccccccc", "until");
    living_finish(&b.run);
}

static void a_run_that_a_person_ends_at_once_was_stopped(void **state)
{
    struct sim_run run;

    (void)state;
    until_init(&run, TTF_END_UNTIL, 6);
    living_ask(&run, &(struct ttf_ask){.kind = TTF_ASK_COUNT, .from_index = 3, .count = 3});
    assert_int_equal(sim_run_boot(&run), 0);
    expect_end(&run, "ccc", "stopped");
    living_finish(&run);
}

/* The same plan, given again in another boot. */
static void expect_nothing_to_do(struct sim_run *run)
{
    char digest[65];

    memcpy(digest, run->result.digest, sizeof(digest));
    run->config.power_on_ns = run->ended_ns + S;
    assert_int_equal(sim_run_boot(run), 0);
    assert_true(run->result.sealed);
    assert_string_equal(run->result.digest, digest);
}

/* Stopped, then given a plan that says: so many are enough. */
static void a_plan_that_ends_what_is_there_stops_it(void **state)
{
    struct sim_run run;

    (void)state;
    until_init(&run, TTF_END_COUNT, 6);
    living_ask(&run, &(struct ttf_ask){.kind = TTF_ASK_STOP, .from_index = 3});
    assert_int_equal(sim_run_boot(&run), 0);
    assert_false(run.result.sealed);
    run.plan.count = 3;
    run.config.power_on_ns = run.ended_ns + S;
    assert_int_equal(sim_run_boot(&run), 0);
    expect_end(&run, "ccc", "stopped");
    expect_nothing_to_do(&run);
    living_finish(&run);
}

static void a_new_plan_that_ends_before_what_is_there_is_refused(void **state)
{
    struct sim_run run;

    (void)state;
    until_init(&run, TTF_END_UNTIL, 6);
    living_ask(&run, &(struct ttf_ask){.kind = TTF_ASK_STOP, .from_index = 4});
    assert_int_equal(sim_run_boot(&run), 0);
    run.plan.until_utc_ns -= 4 * MIN;
    run.config.power_on_ns = run.ended_ns + S;
    assert_int_equal(sim_run_boot(&run), -EINVAL);
    assert_string_equal(run.err.where, "until");
    assert_non_null(strstr(run.err.what, "slot 3"));
    run.plan.until_utc_ns += 2 * MIN; /* the last one was due before it, the next is not */
    assert_int_equal(sim_run_boot(&run), 0);
    expect_end(&run, "cccc", "until");
    expect_nothing_to_do(&run);
    living_finish(&run);
}

static void a_new_run_whose_end_has_passed_names_it(void **state)
{
    struct sim_run run;

    (void)state;
    until_init(&run, TTF_END_UNTIL, 4);
    run.plan.until_utc_ns = run.config.start_utc_ns - MIN;
    assert_int_equal(sim_run_boot(&run), -EINVAL);
    assert_string_equal(run.err.where, "until");
    living_finish(&run);
    until_init(&run, TTF_END_COUNT, 4);
    run.plan.start_utc_ns = run.config.start_utc_ns - TTF_NS_PER_H;
    assert_int_equal(sim_run_boot(&run), -EINVAL);
    assert_string_equal(run.err.where, "start");
    living_finish(&run);
}

/* As plans were stored before: without what ends them. The plan of then, given again, is the same. */
static void a_dataset_that_does_not_tell_its_end_is_gone_on_with_by_its_count(void **state)
{
    struct sim_run run;
    char *text;

    (void)state;
    until_init(&run, TTF_END_UNTIL, 6);
    run.plan.end = TTF_END_UNTOLD;
    run.plan.until_utc_ns = 0;
    sim_run_fault(&run, TTF_FAULT_POWER_CUT, 2 * MIN + 40 * S)->amount = 60;
    assert_int_equal(sim_run_boot(&run), -ESHUTDOWN);
    text = sim_run_text(&run, "plans/0.json");
    assert_null(strstr(text, "\"end\""));
    free(text);
    run.plan.end = TTF_END_LENGTH;
    run.plan.length_ns = 6 * MIN;
    run.config.power_on_ns = run.back_ns;
    assert_int_equal(sim_run_boot(&run), 0);
    assert_null(sim_run_text(&run, "plans/1.json"));
    expect_end(&run, "cccwcc", "count");
    living_finish(&run);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(undisturbed_it_ends_as_it_was_reckoned_and_says_why),
        cmocka_unit_test(after_an_outage_of_unknown_length_it_ends_at_its_instant),
        cmocka_unit_test(who_watches_is_told_of_another_end_at_once),
        cmocka_unit_test(gone_on_with_its_first_event_tells_no_older_end),
        cmocka_unit_test(another_end_is_not_taken_back_by_a_record_that_waited),
        cmocka_unit_test(an_outage_past_its_instant_ends_it_as_soon_as_that_is_known),
        cmocka_unit_test(it_ends_in_the_middle_of_a_long_wait),
        cmocka_unit_test(while_nobody_knows_it_comes_to_as_many_as_before),
        cmocka_unit_test(an_outage_of_known_length_changes_nothing),
        cmocka_unit_test(another_interval_ends_at_the_same_instant),
        cmocka_unit_test(asked_for_while_it_runs_it_holds_over_all_of_that),
        cmocka_unit_test(a_clock_that_is_corrected_moves_it),
        cmocka_unit_test(a_clock_corrected_in_the_last_slot_makes_it_another_than_the_last),
        cmocka_unit_test(once_ended_it_has_ended_whatever_the_clock_says_later),
        cmocka_unit_test(a_pc_moves_no_end_that_a_better_clock_of_this_boot_told),
        cmocka_unit_test(what_it_told_holds_in_the_next_run_of_the_boot),
        cmocka_unit_test(a_run_that_waits_for_its_start_is_not_sealed_without_a_slot),
        cmocka_unit_test(power_that_fails_before_the_start_lets_a_clock_tell_the_end),
        cmocka_unit_test(a_pc_that_is_behind_moves_no_end),
        cmocka_unit_test(power_that_flickers_hides_no_outage_from_a_length),
        cmocka_unit_test(a_pc_s_word_tells_the_end_where_nothing_better_was_known),
        cmocka_unit_test(a_run_that_a_person_ends_at_once_was_stopped),
        cmocka_unit_test(a_plan_that_ends_what_is_there_stops_it),
        cmocka_unit_test(a_new_plan_that_ends_before_what_is_there_is_refused),
        cmocka_unit_test(a_new_run_whose_end_has_passed_names_it),
        cmocka_unit_test(a_dataset_that_does_not_tell_its_end_is_gone_on_with_by_its_count),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
