/* SPDX-License-Identifier: Apache-2.0 */
/* test_charts.c: columns of thousands of slots in a thousand points, no spike hidden. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "chart_points.h"
#include "chart_text.h"
#include "ttf/base/time.h"

static struct chart_lamps no_plan;

static void add(struct chart_points *points, int64_t index, double level, int64_t late_ns)
{
    struct ttf_slot_record record;

    ttf_slot_record_init(&record);
    record.index = index;
    record.due_ns = index * TTF_NS_PER_S;
    record.middle_ns = record.due_ns + late_ns;
    record.result = TTF_RESULT_CAPTURED;
    assert_int_equal(ttf_slot_record_images(&record, 1), 0);
    memcpy(record.images[0].stream, "main", 5);
    record.images[0].mean_level = level;
    record.images[0].reference_level = index % 2 ? NAN : level / 2; /* of every second slot alone */
    record.n_sensors = 2;
    record.sensors[0] = (struct ttf_slot_sensor){"box", "temp_mdegc", true, 20000 + index};
    record.sensors[1] = (struct ttf_slot_sensor){"lid", "temp_mdegc", false, 0};
    assert_int_equal(chart_points_add(points, &no_plan, &record), 0);
    ttf_slot_record_free(&record);
}

static const struct chart_series *series(const struct chart_points *points, enum chart_what what)
{
    static const struct chart_series none;

    for (unsigned i = 0; i < points->n_series; i++)
        if (points->series[i].what == what)
            return &points->series[i];
    fail_msg("there is no such column");
    return &none;
}

static void few_slots_are_points_of_their_own(void **state)
{
    struct chart_points points = {0};
    const struct chart_series *mean, *reference;

    (void)state;
    for (int64_t i = 0; i < 100; i++)
        add(&points, i, (double)i, 1000);
    mean = series(&points, CHART_MEAN);
    assert_int_equal(points.n, 100);
    assert_int_equal(points.width, 1);
    assert_true(mean->value[99].min == 99 && mean->value[99].max == 99);
    assert_int_equal(points.n_series, 4); /* the sensor that was silent has none */
    reference = series(&points, CHART_REFERENCE);
    assert_true(reference->value[98].n == 1 && reference->value[98].max == 49);
    assert_int_equal(reference->value[99].n, 0);
    chart_points_free(&points);
    assert_int_equal(points.n, 0);
}

static void a_spike_of_one_slot_among_a_hundred_thousand_shows(void **state)
{
    struct chart_points points = {0};
    const struct chart_series *mean, *error;
    double most = 0, least = 1, sum = 0;
    int64_t slots = 0;

    (void)state;
    for (int64_t i = 0; i < 100000; i++)
        add(&points, i, i == 77777 ? 0.9 : i == 33333 ? 0.1 : 0.5, i == 5 ? 40000000 : 0);
    mean = series(&points, CHART_MEAN);
    error = series(&points, CHART_ERROR);
    assert_true(points.n <= CHART_POINTS && points.n > CHART_POINTS / 2);
    assert_int_equal(points.width, 128);
    for (unsigned i = 0; i < points.n; i++) {
        most = fmax(most, mean->value[i].max);
        least = fmin(least, mean->value[i].min);
        sum += mean->value[i].sum;
        slots += points.point[i].results[TTF_RESULT_CAPTURED];
    }
    assert_true(most == 0.9 && least == 0.1);
    assert_true(fabs(sum - 50000) < 0.5);
    assert_int_equal(slots, 100000);
    assert_true(mean->value[77777 / 128].max == 0.9);
    assert_true(fabs(error->value[0].max - 0.04) < 1e-12);
    assert_int_equal(points.point[2].index, 256);
    assert_int_equal(points.point[2].due_ns, 256 * TTF_NS_PER_S);
    chart_points_free(&points);
}

static void holes_and_a_late_beginning_are_kept(void **state)
{
    struct chart_points points = {0};

    (void)state;
    add(&points, 5000, 0.5, 0);
    add(&points, 1000005000, 0.5, 0); /* a jump as no plan has it */
    assert_int_equal(points.base, 5000);
    assert_int_equal(points.slots, 2);
    assert_int_equal(points.point[0].index, 5000);
    assert_true(points.n > 1 && points.n <= CHART_POINTS);
    assert_int_equal(points.point[points.n - 1].index, 1000005000);
    chart_points_free(&points);
}

/* A point's first slot may be one that was missed: who wants to see the point is told of one that was not. */
static void a_point_knows_its_first_slot_with_a_picture(void **state)
{
    struct chart_points points = {0};
    struct chart_segments segments = {0};
    struct ttf_slot_record record;
    char *text = NULL;
    size_t bytes = 0;

    (void)state;
    for (int64_t i = 0; i < 4096; i++) {
        ttf_slot_record_init(&record);
        record.index = i;
        record.result = i < 8     ? TTF_RESULT_MISSED
                        : i == 11 ? TTF_RESULT_PARTIAL
                        : i % 4   ? TTF_RESULT_FAILED
                                  : TTF_RESULT_CAPTURED;
        record.result = i == 8 ? TTF_RESULT_PAUSED : record.result;
        assert_int_equal(chart_points_add(&points, &no_plan, &record), 0);
        ttf_slot_record_free(&record);
    }
    assert_int_equal(points.width, 4);
    assert_int_equal(points.point[0].pictured, -1);
    assert_int_equal(points.point[1].pictured, -1);
    assert_int_equal(points.point[2].pictured, 11);
    assert_int_equal(points.point[2].index, 8);
    assert_int_equal(points.point[3].pictured, 12);
    assert_int_equal(points.point[1023].pictured, 4092);
    assert_int_equal(chart_text("grass", &points, &segments, true, &text, &bytes), 0);
    assert_non_null(strstr(text, "\"pictured\":[null,null,11,12,16,"));
    free(text);
    chart_points_free(&points);
    ttf_slot_record_init(&record); /* and a hole beside a slot that was missed has none */
    record.result = TTF_RESULT_MISSED;
    assert_int_equal(chart_points_add(&points, &no_plan, &record), 0);
    ttf_slot_record_free(&record);
    add(&points, 5000, 0.5, 0);
    assert_int_equal(points.point[0].pictured, -1);
    assert_int_equal(points.point[points.n - 1].pictured, 5000);
    chart_points_free(&points);
}

static void without_a_plan_exposures_are_all_that_is_known_of_lamps(void **state)
{
    struct chart_points points = {0};
    struct ttf_slot_record record;
    const struct chart_series *lamp;

    (void)state;
    for (int64_t i = 0; i < 10; i++) {
        ttf_slot_record_init(&record);
        record.index = i;
        assert_int_equal(ttf_slot_record_images(&record, 1), 0);
        assert_int_equal(ttf_image_shots(&record.images[0], 1), 0);
        record.images[0].shots[0].start_ns = 0;
        record.images[0].shots[0].end_ns = TTF_NS_PER_H;
        record.images[0].shots[0].n_lamps = 1;
        memcpy(record.images[0].shots[0].lamps[0].name, "left", 5);
        record.images[0].shots[0].lamps[0].commanded_permille = i < 5 ? 1000 : 0;
        assert_int_equal(chart_points_add(&points, &no_plan, &record), 0);
        ttf_slot_record_free(&record);
    }
    lamp = series(&points, CHART_LAMP);
    assert_true(fabs(lamp->value[4].max - 5) < 1e-9);
    assert_true(fabs(lamp->value[9].max - 5) < 1e-9);
    chart_points_free(&points);
}

/* ---- by a plan ---- */

#define S TTF_NS_PER_S

/* Slots of an interval, each with one exposure of 20 ms that begins when it is due, lit by "left". */
static double hours_of(struct chart_lamps *lamps, int64_t first, int64_t last, int64_t interval_ns)
{
    struct chart_points points = {0};
    double hours;

    for (int64_t i = first; i <= last; i++) {
        struct ttf_slot_record record;
        struct ttf_shot *shot;

        ttf_slot_record_init(&record);
        record.index = i;
        record.segment = lamps->segment.segment;
        record.due_ns = lamps->segment.origin_ns + (i - lamps->segment.first_index) * interval_ns;
        assert_int_equal(ttf_slot_record_images(&record, 1), 0);
        assert_int_equal(ttf_image_shots(&record.images[0], 1), 0);
        shot = &record.images[0].shots[0];
        shot->start_ns = record.due_ns;
        shot->end_ns = record.due_ns + 20 * TTF_NS_PER_MS;
        shot->n_lamps = 1;
        memcpy(shot->lamps[0].name, "left", 5);
        shot->lamps[0].commanded_permille = 1000;
        assert_int_equal(chart_points_add(&points, lamps, &record), 0);
        ttf_slot_record_free(&record);
    }
    hours = series(&points, CHART_LAMP)->total;
    chart_points_free(&points);
    return hours;
}

static void plan(struct chart_lamps *lamps, const char *text, int64_t interval_ns)
{
    const struct ttf_segment segment = {
        .origin_ns = 5000 * S, .origin_utc_ns = TTF_NS_UNKNOWN, .interval_ns = interval_ns};

    memset(lamps, 0, sizeof *lamps);
    chart_lamps_plan(lamps, text, strlen(text));
    chart_lamps_segment(lamps, &segment);
}

#define SHOTS "\"shots\":[{\"lamps_permille\":{\"left\":1000,\"right\":0}}]"

static void a_lamp_that_burns_all_the_time_counts_between_slots(void **state)
{
    struct chart_lamps lamps;

    (void)state;
    plan(&lamps, "{\"lamps\":{\"mode\":\"continuous\",\"settle_ns\":200000000}," SHOTS "}", S);
    /* ten slots at 1 s: nine intervals, an exposure, and what it settled for before the first */
    assert_true(fabs(hours_of(&lamps, 0, 9, S) * 3600 - 9.22) < 1e-6);
}

static void a_lamp_for_the_frames_alone_counts_with_its_settling(void **state)
{
    struct chart_lamps lamps;

    (void)state;
    plan(&lamps, "{\"lamps\":{\"mode\":\"capture-only\",\"settle_ns\":2000000000}," SHOTS "}",
         60 * S);
    assert_true(fabs(hours_of(&lamps, 0, 9, 60 * S) * 3600 - 20.2) < 1e-6);
}

static void by_day_a_lamp_counts_whole_and_at_night_for_the_frames(void **state)
{
    static const char TEXT[] = "{\"lamps\":{\"mode\":\"photoperiod\",\"settle_ns\":30000000000,"
                               "\"day_ns\":43200000000000,\"period_ns\":86400000000000,"
                               "\"phase_ns\":0,\"day_levels_permille\":{\"left\":800}}," SHOTS "}";
    struct chart_lamps lamps;
    double hours;

    (void)state;
    plan(&lamps, TEXT, 3600 * S);
    hours = hours_of(&lamps, 0, 48, 3600 * S); /* two whole days and nights, and a slot */
    /* 24 h of days; each night 11 slots of 30.02 s, at dusk an exposure, at dawn the settling; so before the first day, and 20 ms of
     * the last one */
    assert_true(fabs((hours - 24) * 3600 - (2 * (0.02 + 11 * 30.02 + 30) + 30 + 0.02)) < 1e-6);
}

static void a_boot_s_outage_is_not_counted(void **state)
{
    struct ttf_segment segment = {.segment = 1,
                                  .first_index = 100,
                                  .origin_ns = 7 * S,
                                  .origin_utc_ns = TTF_NS_UNKNOWN,
                                  .interval_ns = S};
    struct chart_lamps lamps;

    (void)state;
    plan(&lamps, "{\"lamps\":{\"mode\":\"continuous\",\"settle_ns\":0}," SHOTS "}", S);
    assert_true(fabs(hours_of(&lamps, 0, 9, S) * 3600 - 9.02) < 1e-6);
    chart_lamps_segment(&lamps, &segment);
    assert_true(fabs(hours_of(&lamps, 100, 109, S) * 3600 - 9.02) < 1e-6);
}

/* ---- as no box writes them ---- */

#define EARLIEST (INT64_MIN + 1) /* that is not "unknown" */

static void add_absurd(struct chart_points *points, struct chart_lamps *lamps, int64_t index,
                       const int64_t times[4])
{
    struct ttf_slot_record record;
    struct ttf_shot *shot;

    ttf_slot_record_init(&record);
    record.index = index;
    record.segment = lamps->segment.segment;
    record.due_ns = times[0];
    record.middle_ns = times[1];
    assert_int_equal(ttf_slot_record_images(&record, 1), 0);
    assert_int_equal(ttf_image_shots(&record.images[0], 1), 0);
    shot = &record.images[0].shots[0];
    shot->start_ns = times[2];
    shot->end_ns = times[3];
    shot->n_lamps = 1;
    memcpy(shot->lamps[0].name, "left", 5);
    shot->lamps[0].commanded_permille = 1000;
    assert_int_equal(chart_points_add(points, lamps, &record), 0);
    ttf_slot_record_free(&record);
}

static void an_error_beyond_all_times_is_none(void **state)
{
    static const int64_t BEYOND[4] = {EARLIEST, 1, 0, 0}, JUST[4] = {EARLIEST, 0, 0, 0};
    struct chart_points points = {0};

    (void)state;
    add_absurd(&points, &no_plan, 0, BEYOND);
    add_absurd(&points, &no_plan, 1, JUST);
    assert_int_equal(series(&points, CHART_ERROR)->value[0].n, 0);
    assert_true(series(&points, CHART_ERROR)->value[1].min > 9e9);
    chart_points_free(&points);
}

#define SPAN_H (9223372036854775807.0 / 3600e9) /* all that can be said */

static void a_lamp_that_burned_since_before_all_times_burned_no_longer_than_they(void **state)
{
    static const int64_t ALL[4] = {0, 0, EARLIEST, INT64_MAX};
    static const char *const PLANS[] = {
        "{\"lamps\":{\"mode\":\"continuous\",\"settle_ns\":9223372036854775807}," SHOTS "}",
        "{\"lamps\":{\"mode\":\"capture-only\",\"settle_ns\":9223372036854775807}," SHOTS "}",
        "{\"lamps\":{\"mode\":\"photoperiod\",\"settle_ns\":0,\"day_ns\":9223372036854775807,"
        "\"period_ns\":2,\"day_levels_permille\":{\"left\":800}}," SHOTS "}",
        "not to be read"};

    (void)state;
    for (size_t i = 0; i < sizeof PLANS / sizeof *PLANS; i++) {
        struct chart_points points = {0};
        struct chart_lamps lamps;

        plan(&lamps, PLANS[i], S);
        add_absurd(&points, &lamps, 0, ALL);
        assert_true(series(&points, CHART_LAMP)->total <= SPAN_H);
        assert_true(series(&points, CHART_LAMP)->total > 0.99 * SPAN_H);
        chart_points_free(&points);
    }
}

static uint32_t any(uint32_t *chance, uint32_t n)
{
    *chance = *chance * 1664525 + 1013904223;
    return *chance / 65536 % n;
}

/* Whatever stands there in whatever order: hours that are none are a bug, and arithmetic that overflows is for the sanitizer to say. */
static void absurd_times_give_hours(void **state)
{
    static const int64_t TIMES[] = {EARLIEST, EARLIEST + 1,  -S,        -1,           0, 1,
                                    S,        INT64_MAX / 2, INT64_MAX, INT64_MAX - 1};
    static const char DAYS[] =
        "{\"lamps\":{\"mode\":\"photoperiod\",\"settle_ns\":-9223372036854775807,"
        "\"day_ns\":%s,\"period_ns\":%s,\"phase_ns\":%s,\"local\":%s,"
        "\"day_start_s\":-9223372036854775807,\"day_levels_permille\":{\"left\":800}}," SHOTS "}";
    static const char *const WHOLE[] = {"-9223372036854775807", "1", "7", "9223372036854775807"};
    uint32_t chance = 1;

    (void)state;
    for (int round = 0; round < 20000; round++) {
        struct ttf_segment segment = {.segment = 0, .zone_offset_s = round % 3 * 86400 - 86400};
        struct chart_points points = {0};
        struct chart_lamps lamps;
        const char *whole[3];
        char text[512];

        segment.origin_ns = TIMES[any(&chance, 10)];
        segment.origin_utc_ns = TIMES[any(&chance, 10)];
        segment.interval_ns = TIMES[any(&chance, 10)];
        segment.run_ns = TIMES[any(&chance, 10)];
        segment.first_index = round;
        for (int k = 0; k < 3; k++)
            whole[k] = WHOLE[any(&chance, 4)];
        (void)snprintf(text, sizeof text, DAYS, whole[0], whole[1], whole[2],
                       round % 2 ? "true" : "false");
        memset(&lamps, 0, sizeof lamps);
        chart_lamps_plan(&lamps, text, strlen(text));
        chart_lamps_segment(&lamps, &segment);
        for (int i = 0; i < 4; i++) {
            int64_t times[4];

            for (int t = 0; t < 4; t++)
                times[t] = TIMES[any(&chance, 10)];

            add_absurd(&points, &lamps, i == 3 ? INT64_MAX - 1 : i, times);
        }
        assert_true(series(&points, CHART_LAMP)->total >= 0);
        chart_points_free(&points);
    }
}

static void columns_are_bounded(void **state)
{
    struct chart_points points = {0};
    struct ttf_slot_record record;

    (void)state;
    for (int i = 0; i < 100; i++) {
        ttf_slot_record_init(&record);
        record.index = i;
        record.n_sensors = 1;
        record.sensors[0] = (struct ttf_slot_sensor){"", "light_permille", true, 1};
        record.sensors[0].name[0] = (char)('0' + i / 10);
        record.sensors[0].name[1] = (char)('0' + i % 10);
        assert_int_equal(chart_points_add(&points, &no_plan, &record), 0);
        ttf_slot_record_free(&record);
    }
    assert_int_equal(points.n_series, CHART_SERIES);
    chart_points_free(&points);
}

static void times_are_those_of_the_segment_as_corrected(void **state)
{
    struct chart_points points = {0};
    struct chart_segments segments = {0};
    struct ttf_segment segment = {.segment = 0, .origin_ns = 0, .origin_utc_ns = TTF_NS_UNKNOWN};
    char *text = NULL;
    size_t bytes = 0;

    (void)state;
    add(&points, 3, 0.25, 0);
    assert_int_equal(chart_segments_put(&segments, &segment), 0);
    assert_int_equal(chart_text("grass", &points, &segments, true, &text, &bytes), 0);
    assert_non_null(strstr(text, "\"due_utc_ns\":[null]"));
    free(text);
    segment.origin_utc_ns = 1790000000000000000;
    assert_int_equal(chart_segments_put(&segments, &segment), 0);
    assert_int_equal(chart_text("grass", &points, &segments, true, &text, &bytes), 0);
    assert_int_equal(strlen(text), bytes);
    assert_non_null(
        strstr(text, "\"index\":[3],\"pictured\":[3],\"due_utc_ns\":[1790000003000000000]"));
    assert_non_null(strstr(text, "\"what\":\"mean_level\",\"stream\":\"main\",\"min\":[0.25]"));
    free(text);
    chart_segments_free(&segments);
    chart_points_free(&points);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(few_slots_are_points_of_their_own),
        cmocka_unit_test(a_spike_of_one_slot_among_a_hundred_thousand_shows),
        cmocka_unit_test(holes_and_a_late_beginning_are_kept),
        cmocka_unit_test(a_point_knows_its_first_slot_with_a_picture),
        cmocka_unit_test(without_a_plan_exposures_are_all_that_is_known_of_lamps),
        cmocka_unit_test(a_lamp_that_burns_all_the_time_counts_between_slots),
        cmocka_unit_test(a_lamp_for_the_frames_alone_counts_with_its_settling),
        cmocka_unit_test(by_day_a_lamp_counts_whole_and_at_night_for_the_frames),
        cmocka_unit_test(a_boot_s_outage_is_not_counted),
        cmocka_unit_test(an_error_beyond_all_times_is_none),
        cmocka_unit_test(a_lamp_that_burned_since_before_all_times_burned_no_longer_than_they),
        cmocka_unit_test(absurd_times_give_hours),
        cmocka_unit_test(columns_are_bounded),
        cmocka_unit_test(times_are_those_of_the_segment_as_corrected),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
