/* SPDX-License-Identifier: Apache-2.0 */
/* What a run that has moved to its second storage knows of clocks and outages from before: its end, and what was given up. */
#include "cmocka_includes.h"

#include <errno.h>
#include <string.h>

#include "second_run.h"
#include "until_run.h"

#define S   TTF_NS_PER_S
#define MIN TTF_NS_PER_MIN

/* From then on the first storage can only be read; so in the boots to come. */
static int only_read_from(struct sim_run *run, const char *path, int64_t from_ns)
{
    return run->box && !second_run_holds(path) &&
                   ttf_sim_elapsed_ns(run->box, ttf_clock_now_ns(run->box->clock)) > from_ns
               ? EROFS
               : 0;
}

static int first_can_only_be_read(struct sim_run *run, const char *op, const char *path)
{
    (void)op;
    return only_read_from(run, path, 8 * MIN + 40 * S);
}

/* An outage whose length is known before it moves, or after; or only in the boot behind it; or by a PC alone. */
static void a_length_counts_the_outages_of_before_the_run_moved(void **state)
{
    static const struct {
        struct until_belief beliefs[5];
        unsigned n;
        const char *letters;
    } cases[] = {{{{0, TTF_TRUST_NTP, 0},
                   {4 * MIN, TTF_TRUST_NONE, 0},
                   {8 * MIN + 10 * S, TTF_TRUST_NTP, 0},
                   {10 * MIN + 30 * S, TTF_TRUST_NONE, 0},
                   {12 * MIN + 50 * S, TTF_TRUST_NTP, 0}},
                  5,
                  "ccccccccccc"},
                 {{{0, TTF_TRUST_NTP, 0},
                   {4 * MIN, TTF_TRUST_NONE, 0},
                   {9 * MIN + 10 * S, TTF_TRUST_NTP, 0},
                   {10 * MIN + 30 * S, TTF_TRUST_NONE, 0},
                   {12 * MIN + 50 * S, TTF_TRUST_NTP, 0}},
                  5,
                  "ccccccccccc"},
                 {{{0, TTF_TRUST_NTP, 0},
                   {4 * MIN, TTF_TRUST_NONE, 0},
                   {12 * MIN + 50 * S, TTF_TRUST_NTP, 0}},
                  3,
                  "ccccccccccc"},
                 {{{0, TTF_TRUST_HOST, 0},
                   {4 * MIN, TTF_TRUST_NONE, 0},
                   {12 * MIN + 50 * S, TTF_TRUST_HOST, 0}},
                  3,
                  "cccccccccccccc"}};

    (void)state;
    for (unsigned i = 0; i < sizeof(cases) / sizeof(cases[0]); i++) {
        struct until_clock b;

        /* Slots at 0:12 to 3:12; at 6:52 to 9:52; at 11:32 to 13:32; the end at 13:42. */
        until_clock_init(&b, TTF_END_LENGTH, 14, cases[i].beliefs, cases[i].n);
        second_run_make(&b.run);
        b.run.fault = first_can_only_be_read;
        sim_run_fault(&b.run, TTF_FAULT_POWER_CUT, 3 * MIN + 40 * S)->amount = 180;
        sim_run_fault(&b.run, TTF_FAULT_POWER_CUT, 10 * MIN + 20 * S)->amount = 60;
        assert_int_equal(sim_run_through_cuts(&b.run), 0);
        assert_true(b.run.result.second_storage);
        assert_true(b.run.result.sealed);
        second_run_expect_both(&b.run, cases[i].letters);
        living_finish(&b.run);
    }
}

/*
 * By a PC alone: no time of the run. By a clock ahead that was so from the beginning: none were given up. So it is with
 * a second storage, and without.
 */
static void a_length_knows_after_a_move_what_was_given_up_before(void **state)
{
    static const struct {
        double dark_s;
        unsigned n;
        struct until_belief beliefs[2];
        const char *letters;
    } cases[] = {
        {180, 1, {{0, TTF_TRUST_HOST, 0}}, "ccccwwwccccwcccccc"},
        {180, 2, {{0, TTF_TRUST_NTP, 0}, {4 * MIN, TTF_TRUST_HOST, 0}}, "ccccwwwccccwcccccc"},
        {15,
         2,
         {{0, TTF_TRUST_RTC, 4 * MIN}, {10 * MIN + 30 * S, TTF_TRUST_NTP, 0}},
         "cccccccccccccc"},
        {15,
         2,
         {{0, TTF_TRUST_RTC, 60 * MIN}, {10 * MIN + 30 * S, TTF_TRUST_NTP, 0}},
         "cccccccccccccc"}};

    (void)state;
    for (unsigned i = 0; i < 2 * sizeof(cases) / sizeof(cases[0]); i++) {
        const bool moves = i % 2 != 0;
        struct until_clock b;

        until_clock_init(&b, TTF_END_LENGTH, 14, cases[i / 2].beliefs, cases[i / 2].n);
        if (moves) {
            second_run_make(&b.run);
            b.run.fault = first_can_only_be_read;
        }
        sim_run_fault(&b.run, TTF_FAULT_POWER_CUT, 3 * MIN + 40 * S)->amount = cases[i / 2].dark_s;
        sim_run_fault(&b.run, TTF_FAULT_POWER_CUT, 10 * MIN + 20 * S)->amount = 60;
        assert_int_equal(sim_run_through_cuts(&b.run), 0);
        assert_true(b.run.result.sealed);
        assert_int_equal(b.run.result.second_storage, moves);
        if (moves)
            second_run_expect_both(&b.run, cases[i / 2].letters);
        else
            until_expect_end(&b.run, cases[i / 2].letters, "until");
        living_finish(&b.run);
    }
}

/* By when the second boot is over: at the beginning of the third. */
static int first_can_only_be_read_later(struct sim_run *run, const char *op, const char *path)
{
    (void)op;
    return only_read_from(run, path, 9 * MIN + 38 * S);
}

static int first_can_only_be_read_sooner(struct sim_run *run, const char *op, const char *path)
{
    (void)op;
    return only_read_from(run, path, 5 * MIN + 40 * S);
}

/* The network sets a slow RTC right: before the move, or after it; in a later boot, or when stopped and run again in one. */
static void what_a_clock_was_corrected_by_before_the_run_moved_is_no_outage(void **state)
{
    static const struct {
        int64_t ntp_ns;
        bool stopped,
            at_start; /* by a person at slot 3; the move is by the last boot, at its beginning */
    } cases[] = {{6 * MIN + 30 * S, false, false}, {9 * MIN, false, false},
                 {4 * MIN + 30 * S, true, false},  {6 * MIN + 30 * S, true, false},
                 {6 * MIN + 30 * S, false, true},  {11 * MIN, false, true}};

    (void)state;
    for (unsigned i = 0; i < sizeof(cases) / sizeof(cases[0]); i++) {
        const struct until_belief beliefs[] = {{0, TTF_TRUST_RTC, -4 * MIN},
                                               {cases[i].ntp_ns, TTF_TRUST_NTP, 0}};
        struct until_clock b;

        until_clock_init(&b, TTF_END_LENGTH, 14, beliefs, 2);
        second_run_make(&b.run);
        if (cases[i].stopped) {
            b.run.fault = first_can_only_be_read_sooner;
            living_ask(&b.run, &(struct ttf_ask){.kind = TTF_ASK_STOP, .from_index = 3});
            assert_int_equal(sim_run_boot(&b.run), 0);
        } else {
            b.run.fault = cases[i].at_start ? first_can_only_be_read_later : first_can_only_be_read;
            sim_run_fault(&b.run, TTF_FAULT_POWER_CUT, 3 * MIN + 40 * S)->amount = 15;
        }
        sim_run_fault(&b.run, TTF_FAULT_POWER_CUT, 9 * MIN + 40 * S)->amount = 15;
        if (cases[i].at_start)
            sim_run_fault(&b.run, TTF_FAULT_POWER_CUT, 11 * MIN + 40 * S)->amount = 15;
        assert_int_equal(sim_run_through_cuts(&b.run), 0);
        assert_true(b.run.result.second_storage);
        assert_true(b.run.result.sealed);
        second_run_expect_both(&b.run, "cccccccccccccc");
        living_finish(&b.run);
    }
}

struct moved_while_given_up {
    struct until_clock b; /* first */
    int left; /* pieces of records that the first storage still takes in the second boot */
};

/* While lamps settle, and slots are given up for that. */
static int first_can_only_be_read_after_records(struct sim_run *run, const char *op,
                                                const char *path)
{
    int *left = &((struct moved_while_given_up *)run)->left;

    if (!run->box || second_run_holds(path) ||
        ttf_sim_elapsed_ns(run->box, ttf_clock_now_ns(run->box->clock)) < 24 * MIN)
        return 0;
    if (*left > 0 && strcmp(op, "append") == 0 && strstr(path, "/records.jsonl"))
        --*left;
    return *left > 0 ? 0 : EROFS;
}

/* The run moves on while they are given up, as lamps settle: the second dataset does not know which slot was taken last. */
static void slots_given_up_before_the_run_moved_make_no_clock_wrong(void **state)
{
    static const struct until_belief rtc[] = {{0, TTF_TRUST_RTC, 0}};
    struct moved_while_given_up m = {.left = 40};
    struct sim_run *run = &m.b.run;
    struct sim_run second;

    (void)state;
    until_clock_init(&m.b, TTF_END_COUNT, 28, rtc, 1);
    second_run_make(run);
    run->fault = first_can_only_be_read_after_records;
    run->plan.lamps = TTF_LAMPS_CONTINUOUS;
    run->plan.settle_ns = 20 * MIN;
    sim_run_fault(run, TTF_FAULT_POWER_CUT, 23 * MIN + 40 * S)->amount = 30;
    sim_run_fault(run, TTF_FAULT_POWER_CUT, 24 * MIN + 40 * S)->amount = 20;
    assert_int_equal(sim_run_through_cuts(run), 0);
    assert_true(run->result.second_storage);
    second = second_run_of(run);
    assert_int_equal(sim_run_events(&second, "clock", "lies before the last slot"), 0);
    assert_int_equal(sim_run_events(&second, "resume", "on the same grid"), 1);
    second_run_expect_both(run, "ccccwmmmmmmmmmmmmmmmmmmmmccc");
    living_finish(run);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_length_counts_the_outages_of_before_the_run_moved),
        cmocka_unit_test(a_length_knows_after_a_move_what_was_given_up_before),
        cmocka_unit_test(what_a_clock_was_corrected_by_before_the_run_moved_is_no_outage),
        cmocka_unit_test(slots_given_up_before_the_run_moved_make_no_clock_wrong),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
