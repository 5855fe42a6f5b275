/* SPDX-License-Identifier: Apache-2.0 */
/* Power cuts: resumed on the same grid with a clock to be trusted, at once without. */
#include "cmocka_includes.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

#include "sim_run.h"

static void segment_of(const struct sim_run *run, int i, struct ttf_segment *ret)
{
    struct ttf_reader *reader;

    assert_int_equal(ttf_reader_open(ttf_io_posix(), run->path, &reader, NULL), 0);
    assert_int_equal(ttf_reader_segment(reader, i, ret), 0);
    ttf_reader_close(reader);
}

/* UTC of a slot's due time by the dataset alone. */
static int64_t due_utc(const struct sim_run *run, int64_t index)
{
    struct ttf_slot_record record;
    struct ttf_reader *reader;
    int64_t utc;

    sim_run_record(run, index, &record);
    assert_int_equal(ttf_reader_open(ttf_io_posix(), run->path, &reader, NULL), 0);
    utc = ttf_reader_due_utc_ns(reader, &record);
    ttf_reader_close(reader);
    ttf_slot_record_free(&record);
    return utc;
}

static void with_a_trusted_clock_the_grid_is_kept(void **state)
{
    struct sim_run run;

    (void)state;
    sim_run_init(&run);
    run.plan.count = 12;
    /* The box goes dark between slots 3 and 4, for two minutes and a bit. */
    sim_run_fault(&run, TTF_FAULT_POWER_CUT, 3 * TTF_NS_PER_MIN + 40 * TTF_NS_PER_S)->amount = 130;
    assert_int_equal(sim_run_through_cuts(&run), 0);
    assert_true(run.result.resumed);
    sim_run_expect(&run, "ccccwwcccccc");
    sim_run_expect_reason(&run, 4, "the box was without power");
    assert_int_equal(due_utc(&run, 11) - due_utc(&run, 0), 11 * TTF_NS_PER_MIN);
    assert_int_equal(sim_run_events(&run, "resume", "same grid"), 1);
    assert_true(run.result.error_max_ns < TTF_NS_PER_MS);
    sim_run_expect_whole(&run, true);
    sim_run_finish(&run);
}

static void without_one_it_goes_on_at_once_and_nothing_is_renumbered(void **state)
{
    struct sim_run run;
    struct ttf_segment segment;

    (void)state;
    sim_run_init(&run);
    run.plan.count = 8;
    run.config.rtc = false;
    sim_run_fault(&run, TTF_FAULT_POWER_CUT, 3 * TTF_NS_PER_MIN + 40 * TTF_NS_PER_S)->amount = 150;
    assert_int_equal(sim_run_through_cuts(&run), 0);
    sim_run_expect(&run, "cccccccc");
    segment_of(&run, 1, &segment);
    assert_int_equal(segment.first_index, 4);
    assert_int_equal(segment.gap_ns, TTF_NS_UNKNOWN);
    assert_int_equal(segment.origin_utc_ns, TTF_NS_UNKNOWN);
    assert_string_equal(segment.trust, "none");
    assert_int_equal(due_utc(&run, 5), TTF_NS_UNKNOWN);
    sim_run_expect_whole(&run, true);
    sim_run_finish(&run);
}

static void a_gap_is_measured_once_the_clock_is_trusted_again(void **state)
{
    struct sim_run run;
    struct ttf_segment segment;
    int64_t cut = 3 * TTF_NS_PER_MIN + 40 * TTF_NS_PER_S;
    int64_t began;

    (void)state;
    sim_run_init(&run);
    run.plan.count = 8;
    run.config.rtc = false;
    run.config.utc_back_ns = 2 * TTF_NS_PER_MIN;
    sim_run_fault(&run, TTF_FAULT_POWER_CUT, cut)->amount = 150;
    assert_int_equal(sim_run_boot(&run), -ESHUTDOWN);
    began = sim_run_due_ns(&run, 4); /* slot 4, had there been no cut */
    run.config.power_on_ns = run.back_ns;
    assert_int_equal(sim_run_boot(&run), 0);
    sim_run_expect(&run, "cccccccc");
    segment_of(&run, 1, &segment);
    assert_string_equal(segment.trust, "ntp");
    assert_true(segment.corrects);
    /* It began again at cut + 150 s + a few seconds; slot 4 had been due at `began`. */
    assert_in_range(segment.gap_ns, cut + 150 * TTF_NS_PER_S - began,
                    cut + 170 * TTF_NS_PER_S - began);
    assert_int_equal(due_utc(&run, 4) - due_utc(&run, 3), TTF_NS_PER_MIN + segment.gap_ns);
    assert_int_equal(sim_run_events(&run, "clock", "ntp"), 1);
    sim_run_expect_whole(&run, true);
    sim_run_finish(&run);
}

static void an_outage_past_the_end_names_every_slot(void **state)
{
    struct sim_run run;

    (void)state;
    sim_run_init(&run);
    sim_run_fault(&run, TTF_FAULT_POWER_CUT, 2 * TTF_NS_PER_MIN)->amount = 86400;
    assert_int_equal(sim_run_through_cuts(&run), 0);
    sim_run_expect(&run, "ccwwww");
    assert_true(run.result.sealed);
    sim_run_expect_whole(&run, true);
    sim_run_finish(&run);
}

/* Cuts at many instants of a slot's life: settling, exposing, developing, committing. */
static void a_cut_at_any_moment_of_a_slot_loses_no_committed_frame(void **state)
{
    (void)state;
    for (int64_t at = 0; at < 24; at++) {
        /* Slot 2 is due about 133 s after power-on; its lamp goes on 10 s before. */
        int64_t cut = 132 * TTF_NS_PER_S + at * 100 * TTF_NS_PER_MS;
        char results[16];
        struct sim_run run;

        sim_run_init(&run);
        sim_run_fault(&run, TTF_FAULT_POWER_CUT, cut)->amount = 70;
        assert_int_equal(sim_run_boot(&run), -ESHUTDOWN);
        assert_in_range(run.slots_told, 2, 3);
        run.config.power_on_ns = run.back_ns;
        assert_int_equal(sim_run_boot(&run), 0);
        sim_run_results(&run, results, sizeof(results));
        assert_int_equal(strlen(results), 6);
        assert_memory_equal(results, "cc", 2);
        assert_true(results[4] == 'c' && results[5] == 'c');
        sim_run_expect_whole(&run, true);
        sim_run_finish(&run);
    }
}

/* Before the first slot: while cameras are armed and the dataset is made. */
static void a_cut_while_arming_leaves_nothing_that_hinders(void **state)
{
    (void)state;
    for (int64_t at = 0; at < 16; at++) {
        struct sim_run run;

        sim_run_init(&run);
        sim_run_fault(&run, TTF_FAULT_POWER_CUT, TTF_NS_PER_S + at * 40 * TTF_NS_PER_MS);
        assert_int_equal(sim_run_boot(&run), -ESHUTDOWN);
        run.config.power_on_ns = run.back_ns;
        assert_int_equal(sim_run_boot(&run), 0);
        assert_int_equal(run.result.slots, 6);
        assert_true(run.result.captured >= 4);
        sim_run_expect_whole(&run, true);
        sim_run_finish(&run);
    }
}

static void thousands_of_lost_slots_have_their_records(void **state)
{
    struct sim_run run;

    (void)state;
    sim_run_init(&run);
    run.plan.lamps = TTF_LAMPS_CONTINUOUS;
    run.plan.settle_ns = TTF_NS_PER_MS;
    run.plan.interval_ns = TTF_NS_PER_S;
    run.plan.count = 2700;
    sim_run_fault(&run, TTF_FAULT_POWER_CUT, 20 * TTF_NS_PER_S)->amount = 2600;
    assert_int_equal(sim_run_through_cuts(&run), 0);
    assert_int_equal(run.result.slots, 2700);
    assert_in_range(run.result.power, 2590, 2610);
    sim_run_expect_whole(&run, true);
    sim_run_finish(&run);
}

static unsigned warmed; /* boots that said how long their lamps settle */

static void say_warming(struct sim_run *run, const struct ttf_progress *progress)
{
    (void)run;
    if (progress->kind != TTF_PROGRESS_ARMED)
        return;
    assert_true(progress->lit_ns >= progress->now_ns);
    assert_true(progress->lit_ns <= progress->now_ns + 2 * TTF_NS_PER_S); /* arming's margin */
    assert_true(progress->settled_ns - progress->lit_ns == 180 * TTF_NS_PER_S);
    warmed++;
}

/* Lamps that must warm up for three minutes first: what is due meanwhile was not lost to the power. */
static void slots_due_while_lamps_settle_are_not_called_without_power(void **state)
{
    struct sim_run run;

    (void)state;
    sim_run_init(&run);
    run.plan.count = 14;
    run.plan.lamps = TTF_LAMPS_CONTINUOUS;
    run.plan.settle_ns = 180 * TTF_NS_PER_S;
    run.on_progress = say_warming;
    warmed = 0;
    sim_run_fault(&run, TTF_FAULT_POWER_CUT, 6 * TTF_NS_PER_MIN + 40 * TTF_NS_PER_S)->amount = 130;
    assert_int_equal(sim_run_through_cuts(&run), 0);
    sim_run_expect(&run, "ccccwwmmmccccc");
    sim_run_expect_reason(&run, 5, "the box was without power");
    sim_run_expect_reason(&run, 6, "the box was getting ready");
    sim_run_expect_reason(&run, 8, "the box was getting ready");
    assert_int_equal(sim_run_events(&run, "resume", "3 slots lost: the box was getting ready"), 1);
    assert_int_equal(warmed, 2);
    sim_run_expect_whole(&run, true);
    sim_run_finish(&run);
}

static const char *described;

static void describe(struct sim_run *run)
{
    snprintf(run->box->description, sizeof(run->box->description), "%s", described);
}

static void cut_and_gone_on_with(struct sim_run *run, const char *now)
{
    sim_run_init(run);
    run->on_box = describe;
    described = "sim, scene grass, sim.optics.blur=1px";
    sim_run_fault(run, TTF_FAULT_POWER_CUT, 3 * TTF_NS_PER_MIN + 40 * TTF_NS_PER_S);
    assert_int_equal(sim_run_boot(run), -ESHUTDOWN);
    described = now;
    run->config.power_on_ns = run->back_ns;
    assert_int_equal(sim_run_boot(run), 0);
}

/* Somebody went on with a simulated run before another scene. */
static void a_run_gone_on_with_in_another_box_says_what_changed(void **state)
{
    struct sim_run run;

    (void)state;
    cut_and_gone_on_with(&run, "sim, scene copper, sim.optics.blur=1px");
    assert_int_equal(sim_run_events(&run, "box",
                                    "'copper, sim.optics.blur=1px' instead of 'grass, "
                                    "sim.optics.blur=1px'"),
                     1);
    sim_run_expect_whole(&run, true);
    sim_run_finish(&run);
    cut_and_gone_on_with(&run, "sim, scene grass");
    assert_int_equal(sim_run_events(&run, "box", "'grass' instead of 'grass, sim.optics.blur=1px'"),
                     1);
    sim_run_finish(&run);
}

static void the_same_box_and_one_that_does_not_say_leave_no_event(void **state)
{
    struct sim_run run;

    (void)state;
    cut_and_gone_on_with(&run, "sim, scene grass, sim.optics.blur=1px");
    assert_int_equal(sim_run_events(&run, "box", NULL), 0);
    sim_run_finish(&run);
    cut_and_gone_on_with(&run, "");
    assert_int_equal(sim_run_events(&run, "box", NULL), 0);
    sim_run_finish(&run);
}

static void cuts_in_a_row_are_survived(void **state)
{
    struct sim_run run;
    char results[256];

    (void)state;
    sim_run_init(&run);
    run.plan.count = 120;
    run.config.outage_ns = 100 * TTF_NS_PER_S;
    for (int64_t i = 0; i < 12; i++)
        sim_run_fault(&run, TTF_FAULT_POWER_CUT,
                      i * 9 * TTF_NS_PER_MIN + i * i * 7 * TTF_NS_PER_S + 30 * TTF_NS_PER_S);
    assert_int_equal(sim_run_through_cuts(&run), 0);
    sim_run_results(&run, results, sizeof(results));
    assert_int_equal(strlen(results), 120);
    assert_null(strpbrk(results, "fpz"));
    for (int64_t k = 0; results[k]; k++)
        if (results[k] == 'm') {
            assert_int_equal(results[k + 1],
                             'c'); /* the box had power, and was ready for the next one */
            sim_run_expect_reason(&run, k, "the box was getting ready");
        }
    assert_int_equal(due_utc(&run, 119) - due_utc(&run, 0), 119 * TTF_NS_PER_MIN);
    sim_run_expect_whole(&run, true);
    sim_run_finish(&run);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(with_a_trusted_clock_the_grid_is_kept),
        cmocka_unit_test(without_one_it_goes_on_at_once_and_nothing_is_renumbered),
        cmocka_unit_test(a_gap_is_measured_once_the_clock_is_trusted_again),
        cmocka_unit_test(an_outage_past_the_end_names_every_slot),
        cmocka_unit_test(a_cut_at_any_moment_of_a_slot_loses_no_committed_frame),
        cmocka_unit_test(a_cut_while_arming_leaves_nothing_that_hinders),
        cmocka_unit_test(thousands_of_lost_slots_have_their_records),
        cmocka_unit_test(cuts_in_a_row_are_survived),
        cmocka_unit_test(a_run_gone_on_with_in_another_box_says_what_changed),
        cmocka_unit_test(the_same_box_and_one_that_does_not_say_leave_no_event),
        cmocka_unit_test(slots_due_while_lamps_settle_are_not_called_without_power),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
