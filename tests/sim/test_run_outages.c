/* SPDX-License-Identifier: Apache-2.0 */
/* What clocks, and a PC's, tell of an outage: which of it a length counts, which grid it leaves, and what no waiting makes right. */
#include "cmocka_includes.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

#include "until_run.h"

#define S   TTF_NS_PER_S
#define MIN TTF_NS_PER_MIN
#define DAY TTF_NS_PER_DAY

#define POWER_FAILS (3 * MIN + 40 * S) /* behind slot 3 */
#define POWER_BACK  (POWER_FAILS + S)

/* A run by its length: its slots are due at 0:12, 1:12 and so on; at once it is 12 s after it has power. */
struct length_case {
    const char *what;
    struct {
        int64_t slots, dark_s, again_s; /* from POWER_FAILS on; and once more, for 15 s; 0: not */
        unsigned n;
    } of;
    struct until_belief beliefs[5];
    const char *letters;
};

static void expect_length(const struct length_case *c)
{
    struct until_clock b;

    print_message("%s\n", c->what);
    until_clock_init(&b, TTF_END_LENGTH, c->of.slots, c->beliefs, c->of.n);
    sim_run_fault(&b.run, TTF_FAULT_POWER_CUT, POWER_FAILS)->amount = (double)c->of.dark_s;
    if (c->of.again_s > 0)
        sim_run_fault(&b.run, TTF_FAULT_POWER_CUT, c->of.again_s * S)->amount = 15;
    assert_int_equal(sim_run_through_cuts(&b.run), 0);
    until_expect_end(&b.run, c->letters, "until");
    living_finish(&b.run);
}

/* Whoever was slow: it is the PC's word on one side of the outage, so it is none, or none that is known. */
static void a_clock_that_was_corrected_ends_no_length(void **state)
{
    static const struct length_case cases[] = {
        {"a PC two days slow; nobody, then the network",
         {10, 15, 0, 3},
         {{0, TTF_TRUST_HOST, -2 * DAY},
          {POWER_BACK, TTF_TRUST_NONE, 0},
          {330 * S, TTF_TRUST_NTP, 0}},
         "cccccccccc"},
        {"the same, and power that fails once more",
         {10, 15, 380, 3},
         {{0, TTF_TRUST_HOST, -2 * DAY},
          {POWER_BACK, TTF_TRUST_NONE, 0},
          {330 * S, TTF_TRUST_NTP, 0}},
         "cccccccccc"},
        {"a PC two days slow; the network from power-on on",
         {10, 15, 0, 2},
         {{0, TTF_TRUST_HOST, -2 * DAY}, {POWER_BACK, TTF_TRUST_NTP, 0}},
         "cccccccccc"},
        {"the same, and power that fails once more",
         {10, 15, 380, 2},
         {{0, TTF_TRUST_HOST, -2 * DAY}, {POWER_BACK, TTF_TRUST_NTP, 0}},
         "cccccccccc"},
        {"a PC two days slow, again after the outage, and then the network",
         {10, 15, 0, 4},
         {{0, TTF_TRUST_HOST, -2 * DAY},
          {POWER_BACK, TTF_TRUST_NONE, 0},
          {5 * MIN, TTF_TRUST_HOST, -2 * DAY},
          {390 * S, TTF_TRUST_NTP, 0}},
         "cccccccccc"},
        {"a PC two days slow, and a right one",
         {10, 15, 0, 3},
         {{0, TTF_TRUST_HOST, -2 * DAY},
          {POWER_BACK, TTF_TRUST_NONE, 0},
          {330 * S, TTF_TRUST_HOST, 0}},
         "cccccccccc"},
        {"a PC less slow than what is left: slots are given up, and are none of the run's time",
         {10, 15, 0, 2},
         {{0, TTF_TRUST_HOST, -4 * MIN}, {POWER_BACK, TTF_TRUST_NTP, 0}},
         "ccccwwwwcccccc"},
        {"the same, and power that fails once more",
         {10, 15, 380, 2},
         {{0, TTF_TRUST_HOST, -4 * MIN}, {POWER_BACK, TTF_TRUST_NTP, 0}},
         "ccccwwwwcccccc"}};

    (void)state;
    for (unsigned i = 0; i < sizeof(cases) / sizeof(cases[0]); i++)
        expect_length(&cases[i]);
}

static void slots_that_a_clock_ahead_gave_up_are_no_time_of_a_length(void **state)
{
    static const struct length_case cases[] = {
        {"the box's own, which the network sets right",
         {10, 15, 0, 3},
         {{0, TTF_TRUST_RTC, 0}, {POWER_BACK, TTF_TRUST_RTC, 4 * MIN}, {280 * S, TTF_TRUST_NTP, 0}},
         "ccccwwwwcccccc"},
        {"the same, and power that fails once more",
         {10, 15, 380, 3},
         {{0, TTF_TRUST_RTC, 0}, {POWER_BACK, TTF_TRUST_RTC, 4 * MIN}, {280 * S, TTF_TRUST_NTP, 0}},
         "ccccwwwwcccccc"},
        {"the box's own until the next outage, and then the network",
         {10, 15, 280, 3},
         {{0, TTF_TRUST_RTC, 0}, {POWER_BACK, TTF_TRUST_RTC, 4 * MIN}, {5 * MIN, TTF_TRUST_NTP, 0}},
         "ccccwwwwcccccc"},
        {"the box's own, which is right again after the next outage: it contradicts itself",
         {26, 15, 280, 3},
         {{0, TTF_TRUST_RTC, 0},
          {POWER_BACK, TTF_TRUST_RTC, 20 * MIN},
          {285 * S, TTF_TRUST_RTC, 0}},
         "ccccwwwwwwwwwwwwwwwwwwwwcccccccccccccccccccccc"},
        {"the box's own, which is set right in the boot behind the next one",
         {26, 15, 280, 3},
         {{0, TTF_TRUST_RTC, 0},
          {POWER_BACK, TTF_TRUST_RTC, 20 * MIN},
          {5 * MIN, TTF_TRUST_RTC, 0}},
         "ccccwwwwwwwwwwwwwwwwwwwwcccccccccccccccccccccc"},
        {"a PC's",
         {10, 15, 0, 2},
         {{0, TTF_TRUST_NTP, 0}, {POWER_BACK, TTF_TRUST_HOST, 4 * MIN}},
         "ccccwwwwcccccc"},
        {"a PC's, and then the network",
         {10, 15, 380, 3},
         {{0, TTF_TRUST_NTP, 0},
          {POWER_BACK, TTF_TRUST_HOST, 4 * MIN},
          {385 * S, TTF_TRUST_NTP, 0}},
         "ccccwwwwcccccc"}};

    (void)state;
    for (unsigned i = 0; i < sizeof(cases) / sizeof(cases[0]); i++)
        expect_length(&cases[i]);
}

/* Four minutes dark: by two clocks of the box's own, whoever spoke in between; by a PC alone it is as if there was none. */
static void an_outage_that_sure_clocks_tell_is_time_of_a_length(void **state)
{
    static const struct length_case cases[] = {
        {"on the same grid",
         {10, 240, 0, 2},
         {{0, TTF_TRUST_RTC, 0}, {5 * MIN, TTF_TRUST_NTP, 0}},
         "ccccwwwwcc"},
        {"by a right PC first, and then the network",
         {10, 240, 520, 3},
         {{0, TTF_TRUST_NTP, 0}, {POWER_BACK, TTF_TRUST_HOST, 0}, {525 * S, TTF_TRUST_NTP, 0}},
         "ccccwwwwcc"},
        {"by a right PC alone",
         {10, 240, 0, 2},
         {{0, TTF_TRUST_NTP, 0}, {POWER_BACK, TTF_TRUST_HOST, 0}},
         "ccccwwwwcccccc"}};

    (void)state;
    for (unsigned i = 0; i < sizeof(cases) / sizeof(cases[0]); i++)
        expect_length(&cases[i]);
}

/*
 * Off the grid, as nobody knew how late it was; the network tells; and the power fails before a slot of that segment was
 * due: its lamps settled. No clock was wrong.
 */
static void power_that_fails_again_before_a_slot_of_a_new_grid_leaves_that_grid(void **state)
{
    static const struct until_belief beliefs[] = {
        {0, TTF_TRUST_NTP, 0}, {24 * MIN, TTF_TRUST_NONE, 0}, {27 * MIN, TTF_TRUST_NTP, 0}};
    struct until_clock b;

    (void)state;
    /* Slots from 20:03 on, four until 23:40; the fifth is to be at 44:03, and lamps settle until 50:23. */
    until_clock_init(&b, TTF_END_COUNT, 14, beliefs, 3);
    b.run.plan.lamps = TTF_LAMPS_CONTINUOUS;
    b.run.plan.settle_ns = 20 * MIN;
    sim_run_fault(&b.run, TTF_FAULT_POWER_CUT, 23 * MIN + 40 * S)->amount = 20;
    sim_run_fault(&b.run, TTF_FAULT_POWER_CUT, 30 * MIN)->amount = 20;
    assert_int_equal(sim_run_through_cuts(&b.run), 0);
    assert_int_equal(sim_run_events(&b.run, "resume", "lies before the last slot"), 0);
    assert_int_equal(sim_run_events(&b.run, "resume", "on the same grid"), 1);
    until_expect_end(&b.run, "ccccmmmmmmmccc", "count");
    living_finish(&b.run);
}

/* Half an hour slow it stood before the last slot, and is as slow when it has come past it. */
static void a_pc_that_contradicted_the_box_s_own_clock_is_no_better_later(void **state)
{
    static const struct until_belief beliefs[] = {{0, TTF_TRUST_NTP, 0},
                                                  {POWER_BACK, TTF_TRUST_HOST, -30 * MIN}};
    struct ttf_segment segment;
    struct until_clock b;

    (void)state;
    until_clock_init(&b, TTF_END_COUNT, 45, beliefs, 2);
    sim_run_fault(&b.run, TTF_FAULT_POWER_CUT, POWER_FAILS)->amount = 15;
    assert_int_equal(sim_run_through_cuts(&b.run), 0);
    (void)sim_run_segment_of(&b.run, 44, &segment);
    assert_string_equal(segment.trust, "none");
    assert_int_equal(sim_run_events(&b.run, "clock", "lies before the last slot"), 1);
    assert_int_equal(sim_run_events(&b.run, "clock", "contradicts the last slot of before no more"),
                     0);
    until_expect_end(&b.run, "ccccccccccccccccccccccccccccccccccccccccccccc", "count");
    living_finish(&b.run);
}

struct fills_up {
    struct until_clock b; /* first */
    bool full;
    int left; /* pieces of records that it still takes when it is full */
};

static int no_room_for_records(struct sim_run *run, const char *op, const char *path)
{
    struct fills_up *f = (struct fills_up *)run;

    if (!run->box || !f->full || strcmp(op, "append") != 0 || !strstr(path, "/records.jsonl"))
        return 0;
    return f->left-- > 0 ? 0 : ENOSPC;
}

/* By a PC alone. The run fails before all that are given up have their records, and is run again in the same boot. */
static void
slots_given_up_are_no_time_of_a_length_whichever_run_of_the_boot_records_them(void **state)
{
    static const struct until_belief pc = {0, TTF_TRUST_HOST, 0};
    static const struct {
        int left;
        const char *letters;
    } cases[] = {{1, "ccccmmmcccccccccc"}, {3, "ccccwmmcccccccccc"}, {5, "ccccwwmcccccccccc"}};

    (void)state;
    for (unsigned i = 0; i < sizeof(cases) / sizeof(cases[0]); i++) {
        struct fills_up f = {.left = cases[i].left}; /* its segment, and some of the slots */
        struct sim_run *run = &f.b.run;

        until_clock_init(&f.b, TTF_END_LENGTH, 14, &pc, 1);
        run->fault = no_room_for_records;
        sim_run_fault(run, TTF_FAULT_POWER_CUT, POWER_FAILS)->amount = 180;
        assert_int_equal(sim_run_boot(run), -ESHUTDOWN);
        run->config.power_on_ns = run->back_ns;
        f.full = true;
        assert_int_equal(sim_run_boot(run), -ENOSPC);
        f.full = false;
        assert_int_equal(sim_run_boot(run), 0);
        until_expect_end(run, cases[i].letters, "until");
        living_finish(run);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_clock_that_was_corrected_ends_no_length),
        cmocka_unit_test(slots_that_a_clock_ahead_gave_up_are_no_time_of_a_length),
        cmocka_unit_test(
            slots_given_up_are_no_time_of_a_length_whichever_run_of_the_boot_records_them),
        cmocka_unit_test(an_outage_that_sure_clocks_tell_is_time_of_a_length),
        cmocka_unit_test(power_that_fails_again_before_a_slot_of_a_new_grid_leaves_that_grid),
        cmocka_unit_test(a_pc_that_contradicted_the_box_s_own_clock_is_no_better_later),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
