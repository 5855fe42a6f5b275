/* SPDX-License-Identifier: Apache-2.0 */
/* What is watched for over many slots: sharpness, dew, the supply. */
#include "cmocka_includes.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "climate_watch.h"
#include "focus_watch.h"
#include "ttf/base/attr.h"

/* How often it is told over n pictures of this sharpness; the last fall. */
static unsigned look(struct ttf_focus_watch *watch, double sharpness, unsigned n, double *ret_fall)
{
    unsigned told = 0;

    for (unsigned i = 0; i < n; i++)
        told += ttf_focus_watch_look(watch, sharpness, ret_fall);
    return told;
}

static void a_fall_of_a_tenth_is_told_once_and_each_further_one_again(void **state)
{
    struct ttf_focus_watch watch = {0};
    double fall = 0;

    assert_int_equal(look(&watch, 1.0, 100, &fall), 0);
    assert_int_equal(look(&watch, 0.91, 100, &fall), 0);
    assert_int_equal(look(&watch, 0.89, 100, &fall), 1);
    assert_true(fabs(fall - 0.11) < 1e-9);
    assert_int_equal(look(&watch, 0.81, 100, &fall), 0);
    assert_int_equal(look(&watch, 0.80, 100, &fall), 1);
}

static void a_sample_that_grows_sharper_is_no_news_and_raises_what_is_held_against_it(void **state)
{
    struct ttf_focus_watch watch = {0};
    double fall = 0;

    for (unsigned i = 0; i < 100; i++)
        assert_false(ttf_focus_watch_look(&watch, 1.0 + i, &fall));
    assert_int_equal(look(&watch, 80.0, 5, &fall), 1);
}

static void a_hand_in_the_picture_and_figures_that_are_none_are_no_fall(void **state)
{
    struct ttf_focus_watch watch = {0};
    double fall = 0;

    assert_int_equal(look(&watch, 1.0, 20, &fall), 0);
    for (unsigned i = 0; i < 10; i++) {
        assert_int_equal(look(&watch, 0.1, 2, &fall), 0);
        assert_int_equal(look(&watch, 1.0, 3, &fall), 0);
    }
    assert_int_equal(look(&watch, NAN, 20, &fall), 0);
    assert_int_equal(look(&watch, 0.0, 20, &fall), 0);
    assert_int_equal(look(&watch, 0.5, 2, &fall), 0);
    assert_int_equal(look(&watch, 0.5, 1, &fall), 1);
}

static void too_few_pictures_say_nothing(void **state)
{
    struct ttf_focus_watch watch = {0};
    double fall = 0;

    assert_int_equal(look(&watch, 5.0, 2, &fall) + look(&watch, 1.0, 2, &fall), 0);
    assert_int_equal(look(&watch, 1.0, 1, &fall), 0); /* the first median is the first best */
}

/* Worked out with the other usual constants (17.62, 243.12 degC: WMO-No. 8), which differ by hundredths of a degree. */
static void dew_points_are_those_of_other_constants(void **state)
{
    static const struct {
        int temp, humidity;
        double dew;
    } cases[] = {{20, 100, 20.0}, {20, 50, 9.3},  {25, 60, 16.7},
                 {30, 80, 26.2},  {10, 30, -6.8}, {0, 90, -1.4}};

    for (unsigned i = 0; i < TTF_COUNT_OF(cases); i++) {
        double dew =
            (double)ttf_dew_point_mdegc(cases[i].temp * 1000, cases[i].humidity * 1000) / 1000;

        if (fabs(dew - cases[i].dew) > 0.15)
            fail_msg("%d degC, %d %%: %.2f", cases[i].temp, cases[i].humidity, dew);
    }
    assert_true(ttf_dew_point_mdegc(20000, 0) < -50000);
}

struct box {
    struct ttf_reading r[4];
};

static struct box box_of(int64_t air, int64_t humidity, int64_t lens, int64_t low)
{
    return (struct box){
        {{.name = "air", .kind = TTF_SENSOR_TEMP_MDEGC, .ok = true, .value = air},
         {.name = "air-h", .kind = TTF_SENSOR_HUMIDITY_MPCT, .ok = true, .value = humidity},
         {.name = "lens", .kind = TTF_SENSOR_TEMP_MDEGC, .ok = true, .value = lens},
         {.name = "pi", .kind = TTF_SENSOR_UNDERVOLTAGE, .ok = true, .value = low}}};
}

static void fog_is_told_before_it_comes_and_when_it_is_over(void **state)
{
    struct ttf_climate_watch watch = {0};
    struct box dry = box_of(20000, 50000, 18000, 0); /* dew point 9.3 */
    struct box cold = box_of(20000, 50000, 11000, 0), near = box_of(20000, 50000, 12000, 0);
    char text[192];

    assert_int_equal(ttf_climate_watch_look(&watch, dry.r, 4, text, sizeof(text)),
                     TTF_CLIMATE_NOTHING);
    assert_int_equal(ttf_climate_watch_look(&watch, near.r, 4, text, sizeof(text)),
                     TTF_CLIMATE_NOTHING);
    assert_int_equal(ttf_climate_watch_look(&watch, cold.r, 4, text, sizeof(text)),
                     TTF_CLIMATE_DEW);
    assert_non_null(strstr(text, "may fog: dew point 9.3 degC, lens 11.0 degC"));
    assert_int_equal(ttf_climate_watch_look(&watch, cold.r, 4, text, sizeof(text)),
                     TTF_CLIMATE_NOTHING);
    assert_int_equal(ttf_climate_watch_look(&watch, near.r, 4, text, sizeof(text)),
                     TTF_CLIMATE_NOTHING);
    cold.r[1].ok = false; /* whoever does not answer changes nothing */
    assert_int_equal(ttf_climate_watch_look(&watch, cold.r, 4, text, sizeof(text)),
                     TTF_CLIMATE_NOTHING);
    assert_int_equal(ttf_climate_watch_look(&watch, dry.r, 4, text, sizeof(text)), TTF_CLIMATE_DEW);
    assert_non_null(strstr(text, "no fog"));
}

static void a_sagging_supply_is_told_beside_the_fog(void **state)
{
    struct ttf_climate_watch watch = {0};
    struct box bad = box_of(20000, 99000, 18000, 1), good = box_of(20000, 10000, 18000, 0);
    char text[192];

    assert_int_equal(ttf_climate_watch_look(&watch, bad.r, 4, text, sizeof(text)), TTF_CLIMATE_DEW);
    assert_int_equal(ttf_climate_watch_look(&watch, bad.r, 4, text, sizeof(text)),
                     TTF_CLIMATE_SUPPLY);
    assert_non_null(strstr(text, "pi: the supply voltage was too low"));
    assert_int_equal(ttf_climate_watch_look(&watch, bad.r, 4, text, sizeof(text)),
                     TTF_CLIMATE_NOTHING);
    assert_int_equal(ttf_climate_watch_look(&watch, good.r, 3, text, sizeof(text)),
                     TTF_CLIMATE_DEW);
    assert_int_equal(ttf_climate_watch_look(&watch, good.r, 3, text, sizeof(text)),
                     TTF_CLIMATE_NOTHING);
    assert_int_equal(ttf_climate_watch_look(&watch, good.r, 4, text, sizeof(text)),
                     TTF_CLIMATE_SUPPLY);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_fall_of_a_tenth_is_told_once_and_each_further_one_again),
        cmocka_unit_test(a_sample_that_grows_sharper_is_no_news_and_raises_what_is_held_against_it),
        cmocka_unit_test(a_hand_in_the_picture_and_figures_that_are_none_are_no_fall),
        cmocka_unit_test(too_few_pictures_say_nothing),
        cmocka_unit_test(dew_points_are_those_of_other_constants),
        cmocka_unit_test(fog_is_told_before_it_comes_and_when_it_is_over),
        cmocka_unit_test(a_sagging_supply_is_told_beside_the_fog),
    };

    return cmocka_run_group_tests_name("watches", tests, NULL, NULL);
}
