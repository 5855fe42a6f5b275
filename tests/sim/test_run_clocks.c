/* SPDX-License-Identifier: Apache-2.0 */
/* What a clock, and a PC's, may do to a run: its end, and the UTC of its slots; and what better clocks hold against it. */
#include "cmocka_includes.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "until_run.h"

#define S   TTF_NS_PER_S
#define MIN TTF_NS_PER_MIN

/* The network goes, after a while nobody vouches for the clock any more, and somebody's PC offers its time. */
static void a_pc_moves_no_end_that_a_better_clock_of_this_boot_told(void **state)
{
    static const struct until_belief beliefs[] = {{0, TTF_TRUST_NTP, 0},
                                                  {70 * S, TTF_TRUST_NONE, 0},
                                                  {130 * S, TTF_TRUST_HOST, 2 * MIN},
                                                  {190 * S, TTF_TRUST_NONE, 0},
                                                  {250 * S, TTF_TRUST_NTP, -MIN}};
    struct until_clock b;
    char *text;

    (void)state;
    until_clock_init(&b, TTF_END_UNTIL, 8, beliefs, 4);
    assert_int_equal(sim_run_boot(&b.run), 0);
    text = sim_run_text(&b.run, "records.jsonl");
    assert_null(strstr(text, "\"trust\":\"host\"")); /* nor what the segment says of UTC */
    free(text);
    until_expect_end(&b.run, "cccccccc", "until");
    living_finish(&b.run);
    until_clock_init(&b, TTF_END_UNTIL, 8, beliefs, 5); /* the network is back */
    assert_int_equal(sim_run_boot(&b.run), 0);
    until_expect_end(&b.run, "ccccccccc", "until");
    living_finish(&b.run);
}

/* The same when the run was stopped meanwhile, and when another instant is asked for. */
static void what_it_told_holds_in_the_next_run_of_the_boot(void **state)
{
    static const struct until_belief network = {0, TTF_TRUST_NTP, 0};
    static const struct until_belief none[] = {{0, TTF_TRUST_NONE, 0},
                                               {190 * S, TTF_TRUST_HOST, 2 * MIN}};
    struct until_clock b;
    int64_t n;

    (void)state;
    until_clock_init(&b, TTF_END_UNTIL, 8, &network, 1);
    living_ask(&b.run, &(struct ttf_ask){.kind = TTF_ASK_STOP, .from_index = 3});
    assert_int_equal(sim_run_boot(&b.run), 0);
    b.beliefs = none;
    b.n = 2;
    assert_int_equal(sim_run_boot(&b.run), 0); /* the boot clock begins anew, the boot does not */
    until_expect_end(&b.run, "cccccccc", "until");
    living_finish(&b.run);
    until_clock_init(&b, TTF_END_UNTIL, 8, &network, 1);
    living_ask(&b.run, &(struct ttf_ask){.kind = TTF_ASK_STOP, .from_index = 3});
    assert_int_equal(sim_run_boot(&b.run), 0);
    n = living_ask(&b.run, &(struct ttf_ask){.kind = TTF_ASK_UNTIL,
                                             .from_index = 5,
                                             .until_utc_ns = b.run.config.start_utc_ns + 10 * MIN});
    b.beliefs = none;
    b.n = 2;
    assert_int_equal(sim_run_boot(&b.run), 0);
    living_expect_done(&b.run, n);
    until_expect_end(&b.run, "cccccccccc", "until");
    living_finish(&b.run);
}

/* Slot 0 is due in ten minutes; a clock says that the last one was a day ago. */
static void a_run_that_waits_for_its_start_is_not_sealed_without_a_slot(void **state)
{
    static const struct until_belief pc[] = {{0, TTF_TRUST_HOST, 0},
                                             {60 * S, TTF_TRUST_NONE, 0},
                                             {MIN + 9 * S, TTF_TRUST_HOST, 1440 * MIN}};
    static const struct until_belief network[] = {{0, TTF_TRUST_RTC, 0},
                                                  {60 * S, TTF_TRUST_NTP, 1440 * MIN}};
    static const struct until_belief right = {0, TTF_TRUST_NTP, 0};
    struct until_clock b;

    (void)state;
    until_clock_init(&b, TTF_END_UNTIL, 14, pc, 3);
    b.run.plan.count = 4;
    b.run.plan.start_utc_ns = b.run.config.start_utc_ns + 10 * MIN;
    assert_int_equal(sim_run_boot(&b.run), 0); /* a PC's word alone is not believed */
    assert_int_equal(sim_run_events(&b.run, "plan", "not believed alone"), 1);
    until_expect_end(&b.run, "cccc", "until");
    living_finish(&b.run);
    until_clock_init(&b, TTF_END_UNTIL, 14, network, 2);
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
    until_expect_end(&b.run, "cccc", "until");
    living_finish(&b.run);
}

/* A segment without a slot says where the first was to be, not where the last was: no clock lies behind that. */
static void power_that_fails_before_the_start_lets_a_clock_tell_the_end(void **state)
{
    static const struct until_belief beliefs[] = {
        {0, TTF_TRUST_NTP, 0}, {2 * MIN, TTF_TRUST_NONE, 0}, {4 * MIN + 30 * S, TTF_TRUST_NTP, 0}};
    struct until_clock b;

    (void)state;
    until_clock_init(&b, TTF_END_UNTIL, 34, beliefs, 3);
    b.run.plan.count = 4;
    b.run.plan.start_utc_ns = b.run.config.start_utc_ns + 30 * MIN;
    sim_run_fault(&b.run, TTF_FAULT_POWER_CUT, 2 * MIN + 30 * S)->amount = 60;
    assert_int_equal(sim_run_through_cuts(&b.run), 0);
    assert_int_equal(sim_run_events(&b.run, "clock", "lies before the last slot"), 0);
    /* Without a clock it begins at once, at 3:42. */
    until_expect_end(&b.run, "ccccccccccccccccccccccccccccccc", "until");
    living_finish(&b.run);
}

/* A boot that knows nothing hears a PC that stands before its last slot; the next one hears nothing. */
static void a_pc_that_is_behind_moves_no_end(void **state)
{
    static const struct until_belief beliefs[] = {{0, TTF_TRUST_NTP, 0},
                                                  {4 * MIN, TTF_TRUST_NONE, 0},
                                                  {7 * MIN + 10 * S, TTF_TRUST_HOST, -30 * MIN},
                                                  {9 * MIN, TTF_TRUST_NONE, 0}};

    (void)state;
    for (unsigned i = 0; i < 2; i++) {
        struct until_clock b;

        /* Slots 0 to 3; dark until 6:40; slots at 6:52, 7:52 (the PC is heard before), and so on. */
        until_clock_init(&b, TTF_END_UNTIL, 8, beliefs, 4);
        sim_run_fault(&b.run, TTF_FAULT_POWER_CUT, 3 * MIN + 40 * S)->amount = 180;
        if (i > 0)
            sim_run_fault(&b.run, TTF_FAULT_POWER_CUT, 8 * MIN + 20 * S)->amount = 60;
        assert_int_equal(sim_run_through_cuts(&b.run), 0);
        assert_int_equal(sim_run_events(&b.run, "clock", "lies before the last slot"), 1);
        until_expect_end(&b.run, "cccccccc", "until");
        living_finish(&b.run);
    }
}

/* Dark, power for ten seconds, dark again: whoever tells the time then tells both; but a PC, or behind one's word. */
static void power_that_flickers_hides_no_outage_from_a_length(void **state)
{
    static const struct until_belief at_once[] = {{0, TTF_TRUST_NTP, 0},
                                                  {4 * MIN, TTF_TRUST_NONE, 0},
                                                  {7 * MIN + 30 * S, TTF_TRUST_NTP, 0},
                                                  {8 * MIN + 30 * S, TTF_TRUST_NONE, 0}};
    static const struct until_belief later[] = {
        {0, TTF_TRUST_NTP, 0}, {4 * MIN, TTF_TRUST_NONE, 0}, {8 * MIN + 30 * S, TTF_TRUST_NTP, 0}};
    static const struct until_belief a_pc[] = {
        {0, TTF_TRUST_NTP, 0}, {4 * MIN, TTF_TRUST_NONE, 0}, {8 * MIN + 30 * S, TTF_TRUST_HOST, 0}};
    static const struct until_belief after_a_pc[] = {{0, TTF_TRUST_HOST, 0},
                                                     {4 * MIN, TTF_TRUST_NONE, 0},
                                                     {7 * MIN + 30 * S, TTF_TRUST_NTP, 0},
                                                     {8 * MIN + 30 * S, TTF_TRUST_NONE, 0}};
    static const struct {
        const struct until_belief *beliefs;
        unsigned n;
        int64_t cut_ns; /* once more, and no clock behind it; or NTP */
        const char *letters;
    } cases[] = {{at_once, 3, 0, "cccccc"},
                 {later, 3, 0, "cccccc"},
                 {a_pc, 3, 0, "cccccccccc"},
                 {at_once, 4, 8 * MIN + 20 * S, "cccccc"},
                 {after_a_pc, 4, 8 * MIN + 20 * S, "cccccccccc"},
                 {after_a_pc, 3, 8 * MIN + 20 * S, "cccccccccc"}};

    (void)state;
    for (unsigned i = 0; i < sizeof(cases) / sizeof(cases[0]); i++) {
        struct until_clock b;

        /* Slots at 0:12 to 3:12; 8:02, 9:02; the end at 9:42. */
        until_clock_init(&b, TTF_END_LENGTH, 10, cases[i].beliefs, cases[i].n);
        sim_run_fault(&b.run, TTF_FAULT_POWER_CUT, 3 * MIN + 40 * S)->amount = 180;
        sim_run_fault(&b.run, TTF_FAULT_POWER_CUT, 6 * MIN + 50 * S)->amount = 60;
        if (cases[i].cut_ns > 0)
            sim_run_fault(&b.run, TTF_FAULT_POWER_CUT, cases[i].cut_ns)->amount = 20;
        assert_int_equal(sim_run_through_cuts(&b.run), 0);
        until_expect_end(&b.run, cases[i].letters, "until");
        living_finish(&b.run);
    }
}

/* Where nobody knew better its word counts, as long as slots are left. */
static void a_pc_s_word_tells_the_end_where_nothing_better_was_known(void **state)
{
    static const struct until_belief beliefs[] = {
        {0, TTF_TRUST_NONE, 0}, {70 * S, TTF_TRUST_HOST, 2 * MIN}, {130 * S, TTF_TRUST_NTP, 0}};
    struct until_clock b;

    (void)state;
    until_clock_init(&b, TTF_END_UNTIL, 8, beliefs, 2);
    assert_int_equal(sim_run_boot(&b.run), 0);
    until_expect_end(&b.run, "cccccc", "until");
    living_finish(&b.run);
    until_clock_init(&b, TTF_END_UNTIL, 8, beliefs, 3); /* who knows better has the last word */
    assert_int_equal(sim_run_boot(&b.run), 0);
    until_expect_end(&b.run, "cccccccc", "until");
    living_finish(&b.run);
}

static void expect_label(const struct until_clock *b, int64_t index, const char *trust,
                         int64_t ahead_ns)
{
    struct ttf_segment s;
    struct ttf_slot_record record;
    int64_t due_ns;

    (void)sim_run_segment_of(&b->run, index, &s);
    assert_string_equal(s.trust, trust);
    assert_true((s.origin_utc_ns == TTF_NS_UNKNOWN) == (strcmp(trust, "none") == 0));
    assert_true((s.uncertainty_ns == TTF_NS_UNKNOWN) == (strcmp(trust, "none") == 0));
    if (s.origin_utc_ns == TTF_NS_UNKNOWN)
        return;
    sim_run_record(&b->run, index, &record);
    due_ns = record.due_ns + b->run.config.power_on_ns; /* of the last boot */
    assert_int_equal(s.origin_utc_ns + record.due_ns - s.origin_ns,
                     b->run.config.start_utc_ns + due_ns + ahead_ns);
    ttf_slot_record_free(&record);
}

/* What its pictures say of when they were taken. */
static bool picture_says(const struct until_clock *b, const char *name, const char *when)
{
    char path[160];
    char *text = NULL;
    size_t bytes;
    bool says;

    snprintf(path, sizeof(path), "%s/frames/main/%s.tif", b->run.path, name);
    assert_int_equal(ttf_io_slurp(ttf_io_posix(), path, 1 << 20, &text, &bytes, NULL), 0);
    says = memmem(text, bytes, when, strlen(when)) != NULL;
    free(text);
    return says;
}

/* Stopped and run again in a boot that has lost its network meanwhile: nobody, or a PC, or nobody and then a PC. */
static void what_labels_the_slots_of_a_boot_is_its_best_clock(void **state)
{
    static const struct until_belief network = {0, TTF_TRUST_NTP, 0};
    static const struct until_belief then[][2] = {
        {{0, TTF_TRUST_NONE, 0}, {190 * S, TTF_TRUST_NONE, 0}},
        {{0, TTF_TRUST_HOST, 400 * TTF_NS_PER_DAY}, {190 * S, TTF_TRUST_HOST, 2 * MIN}},
        {{0, TTF_TRUST_NONE, 0}, {190 * S, TTF_TRUST_HOST, -400 * TTF_NS_PER_DAY}}};

    (void)state;
    for (unsigned i = 0; i < 3; i++) {
        struct until_clock b;

        until_clock_init(&b, TTF_END_COUNT, 6, &network, 1);
        living_ask(&b.run, &(struct ttf_ask){.kind = TTF_ASK_STOP, .from_index = 3});
        assert_int_equal(sim_run_boot(&b.run), 0);
        b.beliefs = then[i];
        b.n = 2;
        assert_int_equal(sim_run_boot(&b.run), 0);
        expect_label(&b, 5, "ntp", 0);
        assert_true(picture_says(&b, "000005", "2026:01:01"));
        until_expect_end(&b.run, "cccccc", "count");
        living_finish(&b.run);
    }
}

/* The last slot before an outage says that it is later: from power-on on, or once a PC says it; till a better clock. */
static void a_clock_that_stands_before_the_last_slot_labels_none(void **state)
{
    static const int64_t year = 365 * TTF_NS_PER_DAY;
    static const struct {
        struct until_belief beliefs[5];
        unsigned n;
        const char *trust; /* in the end */
    } cases[] = {
        {{{0, TTF_TRUST_NTP, 0}, {4 * MIN, TTF_TRUST_HOST, -year}}, 2, "none"},
        {{{0, TTF_TRUST_HOST, 0}, {4 * MIN, TTF_TRUST_HOST, -year}}, 2, "none"},
        {{{0, TTF_TRUST_RTC, 0}, {4 * MIN, TTF_TRUST_RTC, -year}}, 2, "none"},
        {{{0, TTF_TRUST_NTP, 0},
          {4 * MIN, TTF_TRUST_NONE, 0},
          {7 * MIN + 10 * S, TTF_TRUST_HOST, -year}},
         3,
         "none"},
        {{{0, TTF_TRUST_NTP, 0},
          {4 * MIN, TTF_TRUST_RTC, -year},
          {8 * MIN + 10 * S, TTF_TRUST_NTP, 0}},
         3,
         "ntp"},
        /* Set right while nobody vouches for it more than before. */
        {{{0, TTF_TRUST_RTC, 0}, {4 * MIN, TTF_TRUST_RTC, -year}, {8 * MIN, TTF_TRUST_RTC, 0}},
         3,
         "rtc"},
        /* It was the first that was wrong. */
        {{{0, TTF_TRUST_HOST, year}, {4 * MIN, TTF_TRUST_NTP, 0}}, 2, "ntp"}};

    (void)state;
    for (unsigned i = 0; i < sizeof(cases) / sizeof(cases[0]); i++) {
        struct until_clock b;

        /* Slots 0 to 3; dark from 3:40 until 6:40; at once from 6:52 on. */
        until_clock_init(&b, TTF_END_COUNT, 8, cases[i].beliefs, cases[i].n);
        sim_run_fault(&b.run, TTF_FAULT_POWER_CUT, 3 * MIN + 40 * S)->amount = 180;
        assert_int_equal(sim_run_through_cuts(&b.run), 0);
        expect_label(&b, 7, cases[i].trust, 0);
        assert_false(picture_says(&b, "000007", "2025:01:01"));
        assert_int_equal(sim_run_events(&b.run, "clock", "lies before the last slot"), i < 6);
        sim_run_expect(&b.run, "cccccccc");
        sim_run_expect_whole(&b.run, true);
        living_finish(&b.run);
    }
}

/*
 * Slots that are given up while lamps settle are recorded before they are due: a right clock is not behind them,
 * though they lie further ahead than a clock may be wrong.
 */
static void power_that_flickers_while_lamps_settle_makes_no_clock_wrong(void **state)
{
    static const struct until_belief rtc[] = {{0, TTF_TRUST_RTC, 0}};
    static const int64_t cuts_ns[] = {23 * MIN + 40 * S, 24 * MIN + 40 * S, 25 * MIN + 40 * S,
                                      50 * MIN + 30 * S};
    static const char *const letters[] = {"ccccwmmmmmmmmmmmmmmmmmmmmccccccccccccccccccccccccccccc",
                                          "ccccwmmmmmmmmmmmmmmmmmmmmccccccccccccccccccccccccccccc",
                                          "ccccwmmmmmmmmmmmmmmmmmmmmmcccccccccccccccccccccccccccc",
                                          "ccccwmmmmmmmmmmmmmmmmmmmmmcccccmmmmmmmmmmmmmmmmmmmmccc"};

    (void)state;
    for (unsigned n = 1; n <= 4; n++) {
        struct until_clock b;

        /* Slots from 20:03 on; four until 23:40, and dark for 20 s each time. */
        until_clock_init(&b, TTF_END_COUNT, 54, rtc, 1);
        b.run.plan.lamps = TTF_LAMPS_CONTINUOUS;
        b.run.plan.settle_ns = 20 * MIN;
        for (unsigned i = 0; i < n; i++)
            sim_run_fault(&b.run, TTF_FAULT_POWER_CUT, cuts_ns[i])->amount = i == 0 ? 30 : 20;
        assert_int_equal(sim_run_through_cuts(&b.run), 0);
        assert_int_equal(sim_run_events(&b.run, "clock", "lies before the last slot"), 0);
        expect_label(&b, 53, "rtc", 0);
        until_expect_end(&b.run, letters[n - 1], "count");
        living_finish(&b.run);
    }
}

/* How many outages of unknown length its segments tell of, as corrected or not. */
static int gaps_unknown(const struct until_clock *b)
{
    char *text = sim_run_text(&b->run, "records.jsonl");
    int n = 0;

    for (const char *at = text; (at = strstr(at, "\"gap_ns\":null")); at++)
        n++;
    free(text);
    return n;
}

/* A system clock that gained 45 s on the RTC chip, and an outage of 15 s; a network that was ten minutes ahead. */
static void a_right_clock_that_is_merely_earlier_is_believed(void **state)
{
    static const struct until_belief beliefs[][2] = {
        {{0, TTF_TRUST_RTC, 45 * S}, {3 * MIN + 41 * S, TTF_TRUST_RTC, 0}},
        {{0, TTF_TRUST_NTP, 10 * MIN}, {3 * MIN + 41 * S, TTF_TRUST_NTP, 0}}};

    (void)state;
    for (unsigned i = 0; i < 2; i++) {
        struct until_clock b;

        until_clock_init(&b, TTF_END_COUNT, 14, beliefs[i], 2);
        sim_run_fault(&b.run, TTF_FAULT_POWER_CUT, 3 * MIN + 40 * S)->amount = 15;
        sim_run_fault(&b.run, TTF_FAULT_POWER_CUT, 9 * MIN + 20 * S)->amount = 15;
        assert_int_equal(sim_run_through_cuts(&b.run), 0);
        assert_int_equal(sim_run_events(&b.run, "clock", "lies before the last slot"), 0);
        expect_label(&b, 13, i == 0 ? "rtc" : "ntp", 0);
        /* On the grid, but for what would come ten minutes later by that. */
        assert_int_equal(gaps_unknown(&b), i);
        until_expect_end(&b.run, "cccccccccccccc", "count");
        living_finish(&b.run);
    }
}

/* By a clock ten minutes ahead it would end at 14:00; by a right one of the same trust, or a better, at 24:00. */
static void a_clock_that_was_ahead_does_not_tell_a_right_one_the_end(void **state)
{
    static const enum ttf_trust was[] = {TTF_TRUST_NTP, TTF_TRUST_RTC, TTF_TRUST_HOST};

    (void)state;
    for (unsigned i = 0; i < 3; i++) {
        const enum ttf_trust then = i == 2 ? TTF_TRUST_HOST : TTF_TRUST_NTP;
        const struct until_belief beliefs[] = {{0, was[i], 10 * MIN}, {3 * MIN + 41 * S, then, 0}};
        struct until_clock b;

        until_clock_init(&b, TTF_END_UNTIL, 24, beliefs, 2);
        sim_run_fault(&b.run, TTF_FAULT_POWER_CUT, 3 * MIN + 40 * S)->amount = 15;
        assert_int_equal(sim_run_through_cuts(&b.run), 0);
        expect_label(&b, 23, ttf_trust_name(then), 0);
        until_expect_end(&b.run, "cccccccccccccccccccccccc", "until");
        living_finish(&b.run);
    }
}

/* An hour ahead in the boot between, which gave up the slots of that hour and took none: the right one waits for none. */
static void what_a_clock_ahead_gave_up_is_not_waited_for(void **state)
{
    static const struct until_belief beliefs[] = {{0, TTF_TRUST_RTC, 0},
                                                  {24 * MIN, TTF_TRUST_RTC, TTF_NS_PER_H},
                                                  {25 * MIN, TTF_TRUST_NTP, 0}};
    struct ttf_slot_record record;
    struct until_clock b;

    (void)state;
    until_clock_init(&b, TTF_END_COUNT, 88, beliefs, 3);
    b.run.plan.lamps = TTF_LAMPS_CONTINUOUS;
    b.run.plan.settle_ns = 20 * MIN;
    sim_run_fault(&b.run, TTF_FAULT_POWER_CUT, 23 * MIN + 40 * S)->amount = 20;
    sim_run_fault(&b.run, TTF_FAULT_POWER_CUT, 24 * MIN + 40 * S)->amount = 20;
    assert_int_equal(sim_run_through_cuts(&b.run), 0);
    assert_int_equal(sim_run_events(&b.run, "resume", "at once"), 1);
    expect_label(&b, 87, "ntp", 0);
    sim_run_record(&b.run, 87, &record);
    assert_true(record.due_ns + b.run.config.power_on_ns < 55 * MIN);
    ttf_slot_record_free(&record);
    until_expect_end(&b.run,
                     "cccc"
                     "wwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwwww"
                     "mmmmmmmmmmmmmmmmmmmmcccc",
                     "count");
    living_finish(&b.run);
}

/* The last slot of before was at 23:12 by a network twenty minutes ahead; by another clock, or one of less trust. */
static void a_clock_that_was_behind_is_believed_once_it_has_come_past(void **state)
{
    static const enum ttf_trust then[] = {TTF_TRUST_NTP, TTF_TRUST_RTC};

    (void)state;
    for (unsigned i = 0; i < 2; i++) {
        const struct until_belief beliefs[] = {{0, TTF_TRUST_NTP, 20 * MIN},
                                               {3 * MIN + 41 * S, then[i], 0}};
        struct until_clock b;

        until_clock_init(&b, TTF_END_COUNT, 25, beliefs, 2);
        sim_run_fault(&b.run, TTF_FAULT_POWER_CUT, 3 * MIN + 40 * S)->amount = 60;
        assert_int_equal(sim_run_through_cuts(&b.run), 0);
        assert_int_equal(sim_run_events(&b.run, "clock", "lies before the last slot"), 1);
        assert_int_equal(
            sim_run_events(&b.run, "clock", "contradicts the last slot of before no more"), 1);
        expect_label(&b, 4, ttf_trust_name(then[i]), 0); /* all of this boot */
        until_expect_end(&b.run, "ccccccccccccccccccccccccc", "count");
        living_finish(&b.run);
    }
}

/* Seen to be set, it is the same clock: no later boot takes the step for an outage. It moves no end. */
static void the_box_s_own_clock_set_back_in_a_boot_leaves_the_grid(void **state)
{
    static const struct until_belief beliefs[] = {{0, TTF_TRUST_RTC, 0},
                                                  {8 * MIN, TTF_TRUST_RTC, -30 * MIN}};

    (void)state;
    for (unsigned i = 0; i < 2; i++) {
        struct until_clock b;

        until_clock_init(&b, i == 0 ? TTF_END_COUNT : TTF_END_UNTIL, 12, beliefs, 2);
        sim_run_fault(&b.run, TTF_FAULT_POWER_CUT, 3 * MIN + 40 * S)->amount = 180;
        if (i == 0)
            sim_run_fault(&b.run, TTF_FAULT_POWER_CUT, 8 * MIN + 40 * S)->amount = 60;
        assert_int_equal(sim_run_through_cuts(&b.run), 0);
        expect_label(&b, 11, "rtc", -30 * MIN);
        until_expect_end(&b.run, i == 0 ? "ccccwwwccwcc" : "ccccwwwccccc",
                         i == 0 ? "count" : "until");
        living_finish(&b.run);
    }
}

/* It would come half an hour late. */
static void an_instant_by_a_clock_that_is_behind_is_refused(void **state)
{
    static const struct until_belief beliefs[] = {{0, TTF_TRUST_NTP, 0},
                                                  {4 * MIN, TTF_TRUST_HOST, -30 * MIN}};
    struct until_clock b;
    int64_t n;

    (void)state;
    until_clock_init(&b, TTF_END_COUNT, 7, beliefs, 2);
    sim_run_fault(&b.run, TTF_FAULT_POWER_CUT, 3 * MIN + 40 * S)->amount = 180;
    n = living_ask(&b.run, &(struct ttf_ask){.kind = TTF_ASK_UNTIL,
                                             .from_index = 5,
                                             .until_utc_ns = b.run.config.start_utc_ns + 20 * MIN});
    assert_int_equal(sim_run_through_cuts(&b.run), 0);
    living_expect_refused(&b.run, n, "until", "stands before the last slot");
    until_expect_end(&b.run, "ccccccc", "count");
    living_finish(&b.run);
}

/* What a PC said is not believed, as the end had passed by it, and the next boot knows nothing: of an instant that is to come. */
static void another_interval_is_taken_where_nobody_knows_when_the_instant_comes(void **state)
{
    static const struct until_belief beliefs[] = {{0, TTF_TRUST_HOST, 0},
                                                  {150 * S, TTF_TRUST_HOST, 2 * TTF_NS_PER_DAY},
                                                  {3 * MIN + 41 * S, TTF_TRUST_NONE, 0},
                                                  {10 * MIN + 30 * S, TTF_TRUST_NTP, 0}};

    (void)state;
    for (unsigned n = 3; n <= 4; n++) {
        struct until_clock b;
        int64_t ask;

        /* Slots at 0:12 to 3:12; at 4:07 and 5:07; at 6:37, 8:07 and so on; the end at 14:00, once that is known. */
        until_clock_init(&b, TTF_END_UNTIL, 14, beliefs, n);
        sim_run_fault(&b.run, TTF_FAULT_POWER_CUT, 3 * MIN + 40 * S)->amount = 15;
        ask = living_ask(
            &b.run,
            &(struct ttf_ask){.kind = TTF_ASK_INTERVAL, .from_index = 6, .interval_ns = 90 * S});
        assert_int_equal(sim_run_through_cuts(&b.run), 0);
        living_expect_done(&b.run, ask);
        until_expect_end(&b.run, n == 3 ? "cccccccccccccc" : "ccccccccccc", "until");
        living_finish(&b.run);
    }
}

/* More pictures are asked for: the old number of slots would be over before anybody knows that the end has not come. */
static void a_shorter_one_ends_no_run_before_a_clock_tells_its_instant(void **state)
{
    static const struct until_belief beliefs[] = {{0, TTF_TRUST_HOST, 0},
                                                  {150 * S, TTF_TRUST_HOST, 2 * TTF_NS_PER_DAY},
                                                  {3 * MIN + 41 * S, TTF_TRUST_NONE, 0},
                                                  {10 * MIN + 30 * S, TTF_TRUST_NTP, 0}};
    struct until_clock b;
    int64_t ask;

    (void)state;
    /* Slots at 0:12 to 3:12; at 4:07 and 5:07; at 5:27, 5:47 and so on, to the end at 14:00. */
    until_clock_init(&b, TTF_END_UNTIL, 14, beliefs, 4);
    sim_run_fault(&b.run, TTF_FAULT_POWER_CUT, 3 * MIN + 40 * S)->amount = 15;
    ask = living_ask(&b.run, &(struct ttf_ask){
                                 .kind = TTF_ASK_INTERVAL, .from_index = 6, .interval_ns = 20 * S});
    assert_int_equal(sim_run_through_cuts(&b.run), 0);
    living_expect_done(&b.run, ask);
    until_expect_end(&b.run, "cccccccccccccccccccccccccccccccc", "until");
    living_finish(&b.run);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_pc_moves_no_end_that_a_better_clock_of_this_boot_told),
        cmocka_unit_test(what_it_told_holds_in_the_next_run_of_the_boot),
        cmocka_unit_test(a_run_that_waits_for_its_start_is_not_sealed_without_a_slot),
        cmocka_unit_test(power_that_fails_before_the_start_lets_a_clock_tell_the_end),
        cmocka_unit_test(a_pc_that_is_behind_moves_no_end),
        cmocka_unit_test(power_that_flickers_hides_no_outage_from_a_length),
        cmocka_unit_test(a_pc_s_word_tells_the_end_where_nothing_better_was_known),
        cmocka_unit_test(what_labels_the_slots_of_a_boot_is_its_best_clock),
        cmocka_unit_test(a_clock_that_stands_before_the_last_slot_labels_none),
        cmocka_unit_test(the_box_s_own_clock_set_back_in_a_boot_leaves_the_grid),
        cmocka_unit_test(an_instant_by_a_clock_that_is_behind_is_refused),
        cmocka_unit_test(another_interval_is_taken_where_nobody_knows_when_the_instant_comes),
        cmocka_unit_test(a_shorter_one_ends_no_run_before_a_clock_tells_its_instant),
        cmocka_unit_test(power_that_flickers_while_lamps_settle_makes_no_clock_wrong),
        cmocka_unit_test(a_right_clock_that_is_merely_earlier_is_believed),
        cmocka_unit_test(a_clock_that_was_ahead_does_not_tell_a_right_one_the_end),
        cmocka_unit_test(a_clock_that_was_behind_is_believed_once_it_has_come_past),
        cmocka_unit_test(what_a_clock_ahead_gave_up_is_not_waited_for),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
