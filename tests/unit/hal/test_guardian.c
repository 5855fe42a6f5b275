/* SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <errno.h>
#include <string.h>

#include "ttf/base/time.h"
#include "ttf/hal/guardian.h"

#define S  TTF_NS_PER_S
#define MS TTF_NS_PER_MS

static const struct ttf_lamp_info plain = {
    .name = "plain", .kind = TTF_LAMP_PWM, .max_duty_permille = TTF_LAMP_FULL};

/* A guardian of one lamp that is leased for ever. */
static struct ttf_guardian leased(struct ttf_lamp_info info)
{
    struct ttf_guardian g;

    ttf_guardian_init(&g, &info, 1, 0);
    assert_int_equal(ttf_guardian_acquire(&g, 0), 0);
    assert_int_equal(ttf_guardian_renew_through(&g, 0, 1000 * TTF_NS_PER_DAY), 0);
    return g;
}

static void a_lease_lapses_400_ms_after_its_last_renewal_and_not_before(void **state)
{
    struct ttf_guardian g;

    (void)state;
    ttf_guardian_init(&g, &plain, 1, 5 * S);
    assert_int_equal(ttf_guardian_acquire(&g, 5 * S), 0);
    assert_int_equal(ttf_guardian_set(&g, 5 * S, 0, 700), 0);
    assert_int_equal(ttf_guardian_renew(&g, 5 * S + 100 * MS), 0);
    assert_true(ttf_guardian_next_ns(&g) == 5 * S + 500 * MS);
    ttf_guardian_advance(&g, 5 * S + 500 * MS - 1);
    assert_int_equal(g.lamp[0].actual_permille, 700);
    ttf_guardian_advance(&g, 5 * S + 500 * MS);
    assert_int_equal(g.lamp[0].actual_permille, 0);
    assert_int_equal(g.lamp[0].commanded_permille, 700);
    assert_int_equal(g.lamp[0].trip, TTF_TRIP_LEASE);
    assert_int_equal(ttf_guardian_renew(&g, 5 * S + 501 * MS), -ESTALE);
    assert_int_equal(ttf_guardian_set(&g, 5 * S + 501 * MS, 0, 700), -ESTALE);
}

static void renewing_in_bulk_is_renewing_every_100_ms(void **state)
{
    struct ttf_guardian bulk, single;

    (void)state;
    for (int64_t until = 0; until < 1000 * MS; until += 37 * MS) {
        ttf_guardian_init(&bulk, &plain, 1, 0);
        single = bulk;
        assert_int_equal(ttf_guardian_acquire(&bulk, 0), 0);
        assert_int_equal(ttf_guardian_renew_through(&bulk, 0, until), 0);
        assert_int_equal(ttf_guardian_acquire(&single, 0), 0);
        for (int64_t t = 0; t <= until; t += TTF_LEASE_RENEW_NS)
            assert_int_equal(ttf_guardian_renew(&single, t), 0);
        assert_true(bulk.lease_until_ns == single.lease_until_ns);
    }
}

static void max_on_strikes_at_its_instant_even_when_looked_at_late(void **state)
{
    struct ttf_lamp_info info = plain;
    struct ttf_guardian g;

    (void)state;
    info.max_on_ns = 60 * S;
    g = leased(info);
    assert_int_equal(ttf_guardian_set(&g, 10 * S, 0, 500), 0);
    assert_int_equal(ttf_guardian_set(&g, 20 * S, 0, 1000), 0); /* no new stretch */
    ttf_guardian_advance(&g, 3600 * S);
    assert_int_equal(g.lamp[0].actual_permille, 0);
    assert_int_equal(g.lamp[0].trip, TTF_TRIP_MAX_ON);
    assert_true(g.lamp[0].on_total_ns == 60 * S);
}

static void after_max_on_only_a_person_gives_the_lamp_back(void **state)
{
    struct ttf_lamp_info info = plain;
    struct ttf_guardian g;

    (void)state;
    info.max_on_ns = 60 * S;
    g = leased(info);
    assert_int_equal(ttf_guardian_set(&g, 0, 0, 1000), 0);
    assert_int_equal(ttf_guardian_set(&g, 100 * S, 0, 1000), -EPERM);
    assert_int_equal(ttf_guardian_set(&g, 101 * S, 0, 0), 0);
    assert_int_equal(ttf_guardian_set(&g, 102 * S, 0, 1000), -EPERM);
    assert_int_equal(ttf_guardian_clear(&g, 103 * S, 0), 0);
    assert_int_equal(g.lamp[0].actual_permille, 0); /* not by itself */
    assert_int_equal(ttf_guardian_set(&g, 104 * S, 0, 1000), 0);
}

static void duty_strikes_when_the_window_is_full_and_ends_when_it_has_room(void **state)
{
    struct ttf_lamp_info info = plain;
    struct ttf_guardian g;

    (void)state;
    info.max_duty_permille = 250;
    info.duty_window_ns = 100 * S;
    g = leased(info);
    assert_int_equal(ttf_guardian_set(&g, 0, 0, 1000), 0);
    ttf_guardian_advance(&g, 10 * S);
    assert_int_equal(ttf_guardian_set(&g, 10 * S, 0, 0), 0);
    assert_int_equal(ttf_guardian_set(&g, 50 * S, 0, 1000), 0);
    assert_true(ttf_guardian_next_ns(&g) == 65 * S); /* 10 s then, 15 s now */
    ttf_guardian_advance(&g, 99 * S);
    assert_int_equal(g.lamp[0].trip, TTF_TRIP_MAX_DUTY);
    assert_true(g.lamp[0].on_total_ns == 25 * S);
    assert_int_equal(ttf_guardian_set(&g, 100 * S, 0, 1000), -EPERM);
    assert_int_equal(ttf_guardian_clear(&g, 100 * S, 0), -EPERM);
    /* At 105 s the window has forgotten 5 s of the first stretch; more leave as new ones come, up to 110 s. */
    assert_int_equal(ttf_guardian_set(&g, 105 * S, 0, 1000), 0);
    assert_true(ttf_guardian_next_ns(&g) == 115 * S);
}

static void a_lamp_switched_more_often_than_spans_are_kept_is_not_tripped_wrongly(void **state)
{
    struct ttf_lamp_info info = plain;
    struct ttf_guardian g;

    (void)state;
    info.max_duty_permille = 550;
    info.duty_window_ns = TTF_NS_PER_DAY;
    g = leased(info);
    /* 5 min of 10, a week long: 144 spans in each window. */
    for (int64_t t = 0; t < 7 * TTF_NS_PER_DAY; t += 10 * TTF_NS_PER_MIN) {
        assert_int_equal(ttf_guardian_set(&g, t, 0, 1000), 0);
        assert_int_equal(ttf_guardian_set(&g, t + 5 * TTF_NS_PER_MIN, 0, 0), 0);
        assert_int_equal(g.lamp[0].trip, TTF_TRIP_NONE);
        assert_true(g.lamp[0].n_spans <= TTF_GUARDIAN_SPANS);
    }
}

static void heat_trips_and_only_cooling_below_the_hysteresis_ends_it(void **state)
{
    struct ttf_lamp_info info = plain;
    struct ttf_guardian g;

    (void)state;
    info.max_temp_mdegc = 50000;
    info.hysteresis_mdegc = 5000;
    g = leased(info);
    ttf_guardian_temp(&g, 0, 20000);
    assert_int_equal(ttf_guardian_set(&g, 0, 0, 1000), 0);
    ttf_guardian_temp(&g, 1 * S, 50000);
    assert_int_equal(g.lamp[0].actual_permille, 1000); /* over, not at */
    ttf_guardian_temp(&g, 2 * S, 50001);
    assert_int_equal(g.lamp[0].actual_permille, 0);
    assert_int_equal(g.lamp[0].trip, TTF_TRIP_TEMP);
    ttf_guardian_temp(&g, 3 * S, 45000);
    assert_int_equal(ttf_guardian_set(&g, 3 * S, 0, 1000), -EPERM);
    assert_int_equal(ttf_guardian_clear(&g, 3 * S, 0), -EPERM);
    ttf_guardian_temp(&g, 4 * S, 44999);
    assert_int_equal(g.lamp[0].actual_permille, 0); /* not by itself */
    assert_int_equal(ttf_guardian_set(&g, 4 * S, 0, 1000), 0);
}

static void a_temperature_missing_for_10_s_trips(void **state)
{
    struct ttf_lamp_info info = plain;
    struct ttf_guardian g;

    (void)state;
    info.max_temp_mdegc = 50000;
    g = leased(info);
    ttf_guardian_temp(&g, 3 * S, 20000);
    assert_int_equal(ttf_guardian_set(&g, 4 * S, 0, 1000), 0);
    ttf_guardian_advance(&g, 13 * S - 1);
    assert_int_equal(g.lamp[0].actual_permille, 1000);
    ttf_guardian_advance(&g, 13 * S);
    assert_int_equal(g.lamp[0].trip, TTF_TRIP_TEMP_MISSING);
    assert_int_equal(ttf_guardian_set(&g, 14 * S, 0, 1000), -EPERM);
    ttf_guardian_temp(&g, 15 * S, 20000);
    assert_int_equal(ttf_guardian_set(&g, 15 * S, 0, 1000), 0);
}

static void a_reading_that_comes_late_counts_from_when_it_was_made(void **state)
{
    struct ttf_lamp_info info = plain;
    struct ttf_guardian g;

    (void)state;
    info.max_temp_mdegc = 60000;
    info.hysteresis_mdegc = 5000;
    g = leased(info);
    ttf_guardian_temp_late(&g, 7 * S, 1 * S, 20000);
    assert_int_equal(ttf_guardian_set(&g, 7 * S, 0, 1000), 0);
    assert_true(ttf_guardian_next_ns(&g) == 11 * S);
    ttf_guardian_temp_late(&g, 8 * S, 3 * S, 60001); /* late, and hot all the same */
    assert_int_equal(g.lamp[0].trip, TTF_TRIP_TEMP);
    ttf_guardian_temp_late(&g, 8 * S, 2 * S, 20000); /* it became hot after that */
    assert_int_equal(ttf_guardian_set(&g, 8 * S, 0, 1000), -EPERM);
    ttf_guardian_temp_late(&g, 9 * S, 4 * S, 54999);
    assert_int_equal(ttf_guardian_set(&g, 9 * S, 0, 1000), 0);
    assert_true(ttf_guardian_next_ns(&g) == 14 * S);
}

static void a_reading_older_than_10_s_lights_no_lamp_and_has_cooled_none(void **state)
{
    struct ttf_lamp_info info = plain;
    struct ttf_guardian g;

    (void)state;
    info.max_temp_mdegc = 60000;
    info.hysteresis_mdegc = 5000;
    g = leased(info);
    ttf_guardian_temp(&g, 1 * S, 20000);
    assert_int_equal(ttf_guardian_set(&g, 1 * S, 0, 1000), 0);
    ttf_guardian_advance(&g, 25 * S);
    assert_int_equal(g.lamp[0].trip, TTF_TRIP_TEMP_MISSING);
    ttf_guardian_temp_late(&g, 25 * S, 15 * S, 20000); /* its thread hung behind it */
    ttf_guardian_temp(&g, 26 * S, 57000); /* of now; but it may have been 90 degrees meanwhile */
    assert_int_equal(ttf_guardian_set(&g, 26 * S, 0, 1000), -EPERM);
    assert_int_equal(g.lamp[0].trip, TTF_TRIP_TEMP_MISSING);
    ttf_guardian_advance(&g, 50 * S);
    ttf_guardian_temp_late(&g, 50 * S, 28 * S, 20000);
    assert_int_equal(ttf_guardian_clear(&g, 50 * S, 0), -EPERM);
    assert_int_equal(ttf_guardian_set(&g, 50 * S, 0, 1000), -EPERM);
    ttf_guardian_temp_late(&g, 51 * S, 49 * S, 54999);
    assert_int_equal(ttf_guardian_set(&g, 51 * S, 0, 1000), 0);
}

static void a_hot_lamp_is_not_lit_in_the_first_place(void **state)
{
    struct ttf_lamp_info info = plain;
    struct ttf_guardian g;

    (void)state;
    info.max_temp_mdegc = 50000;
    g = leased(info);
    ttf_guardian_temp(&g, 1 * S, 51000);
    assert_int_equal(ttf_guardian_set(&g, 1 * S, 0, 1000), -EPERM);
    assert_int_equal(g.lamp[0].trip, TTF_TRIP_TEMP);
}

static void a_lamp_that_must_cool_is_not_lit_sooner_for_having_met_the_door_meanwhile(void **state)
{
    struct ttf_lamp_info info = plain;
    struct ttf_guardian g;

    (void)state;
    info.max_temp_mdegc = 50000;
    info.hysteresis_mdegc = 5000;
    info.interlock_door = true;
    g = leased(info);
    ttf_guardian_temp(&g, 0, 20000);
    assert_int_equal(ttf_guardian_set(&g, 0, 0, 1000), 0);
    ttf_guardian_temp(&g, 1 * S, 50001);
    ttf_guardian_door(&g, 2 * S, true);
    assert_int_equal(ttf_guardian_set(&g, 3 * S, 0, 1000), -EPERM);
    assert_int_equal(g.lamp[0].trip, TTF_TRIP_DOOR);
    ttf_guardian_door(&g, 4 * S, false);
    ttf_guardian_temp(&g, 5 * S, 49000);
    assert_int_equal(ttf_guardian_set(&g, 5 * S, 0, 1000), -EPERM);
    assert_int_equal(g.lamp[0].trip, TTF_TRIP_TEMP);
    ttf_guardian_temp(&g, 6 * S, 44999);
    assert_int_equal(ttf_guardian_set(&g, 6 * S, 0, 1000), 0);
}

static void a_guardian_that_begins_trusts_no_lamp_to_be_cool(void **state)
{
    struct ttf_lamp_info info = plain;
    struct ttf_guardian g;

    (void)state;
    info.max_temp_mdegc = 50000;
    info.hysteresis_mdegc = 5000;
    g = leased(info);
    assert_int_equal(ttf_guardian_set(&g, 1 * S, 0, 1000), -EPERM);
    assert_int_equal(g.lamp[0].trip, TTF_TRIP_TEMP_MISSING);
    ttf_guardian_temp(&g, 2 * S, 45000); /* perhaps it was switched off for its heat a moment ago */
    assert_int_equal(ttf_guardian_set(&g, 2 * S, 0, 1000), -EPERM);
    ttf_guardian_temp(&g, 3 * S, 44999);
    assert_int_equal(ttf_guardian_set(&g, 3 * S, 0, 1000), 0);
}

static void after_a_restart_a_window_counts_as_used_up(void **state)
{
    struct ttf_lamp_info info[2] = {plain, plain};
    struct ttf_guardian g;

    (void)state;
    info[0].max_duty_permille = 250;
    info[0].duty_window_ns = 100 * S;
    ttf_guardian_init(&g, info, 2, 5 * S);
    ttf_guardian_assume_used(&g);
    assert_int_equal(ttf_guardian_acquire(&g, 5 * S), 0);
    assert_int_equal(ttf_guardian_renew_through(&g, 5 * S, 1000 * S), 0);
    assert_int_equal(ttf_guardian_set(&g, 5 * S, 1, 1000), 0); /* no limit, no wait */
    assert_int_equal(ttf_guardian_set(&g, 80 * S, 0, 1000), -EPERM);
    assert_int_equal(g.lamp[0].trip, TTF_TRIP_MAX_DUTY);
    /* 25 s of the 100 before may have been lit, until 5 s: room comes at 80 s. */
    assert_int_equal(ttf_guardian_set(&g, 81 * S, 0, 1000), 0);
    assert_true(ttf_guardian_next_ns(&g) == 106 * S);
}

static void the_door_darkens_interlocked_lamps_only(void **state)
{
    struct ttf_lamp_info info[2] = {plain, plain};
    struct ttf_guardian g;

    (void)state;
    info[0].interlock_door = true;
    ttf_guardian_init(&g, info, 2, 0);
    assert_int_equal(ttf_guardian_acquire(&g, 0), 0);
    assert_int_equal(ttf_guardian_renew_through(&g, 0, 100 * S), 0);
    assert_int_equal(ttf_guardian_set(&g, 1 * S, 0, 1000), 0);
    assert_int_equal(ttf_guardian_set(&g, 1 * S, 1, 1000), 0);
    ttf_guardian_door(&g, 2 * S, true);
    assert_int_equal(g.lamp[0].actual_permille, 0);
    assert_int_equal(g.lamp[0].trip, TTF_TRIP_DOOR);
    assert_int_equal(g.lamp[1].actual_permille, 1000);
    assert_int_equal(ttf_guardian_set(&g, 3 * S, 0, 1000), -EPERM);
    ttf_guardian_door(&g, 4 * S, false);
    assert_int_equal(g.lamp[0].actual_permille, 0);
    assert_int_equal(ttf_guardian_set(&g, 5 * S, 0, 1000), 0);
}

static void a_new_lease_starts_dark_and_clears_the_lapse(void **state)
{
    struct ttf_guardian g;

    (void)state;
    ttf_guardian_init(&g, &plain, 1, 0);
    assert_int_equal(ttf_guardian_acquire(&g, 0), 0);
    assert_int_equal(ttf_guardian_acquire(&g, 100 * MS), -EBUSY);
    assert_int_equal(ttf_guardian_set(&g, 0, 0, 1000), 0);
    assert_int_equal(ttf_guardian_acquire(&g, 1 * S), 0);
    assert_int_equal(g.lamp[0].trip, TTF_TRIP_NONE);
    assert_int_equal(g.lamp[0].commanded_permille, 0);
    assert_int_equal(g.lamp[0].actual_permille, 0);
}

static void levels_are_rounded_to_what_a_lamp_can_do(void **state)
{
    struct ttf_lamp_info steps = {
        .kind = TTF_LAMP_STEPS, .steps = 4, .max_duty_permille = TTF_LAMP_FULL};
    struct ttf_lamp_info sw = {.kind = TTF_LAMP_SWITCH, .max_duty_permille = TTF_LAMP_FULL};
    struct ttf_guardian g = leased(steps);

    (void)state;
    assert_int_equal(ttf_guardian_set(&g, 0, 0, 630), 0);
    assert_int_equal(g.lamp[0].actual_permille, 750);
    assert_int_equal(ttf_guardian_set(&g, 0, 0, 120), 0);
    assert_int_equal(g.lamp[0].actual_permille, 0);
    g = leased(sw);
    assert_int_equal(ttf_guardian_set(&g, 0, 0, 500), 0);
    assert_int_equal(g.lamp[0].actual_permille, 1000);
    assert_int_equal(ttf_guardian_set(&g, 0, 0, 499), 0);
    assert_int_equal(g.lamp[0].actual_permille, 0);
}

static void time_does_not_run_backwards(void **state)
{
    struct ttf_lamp_info info = plain;
    struct ttf_guardian g;

    (void)state;
    info.max_on_ns = 60 * S;
    g = leased(info);
    assert_int_equal(ttf_guardian_set(&g, 10 * S, 0, 1000), 0);
    ttf_guardian_advance(&g, 5 * S);
    assert_int_equal(ttf_guardian_set(&g, 1 * S, 0, 500), 0);
    assert_true(g.now_ns == 10 * S);
    assert_true(ttf_guardian_next_ns(&g) == 70 * S);
    ttf_guardian_advance(&g, TTF_NS_NEVER);
    assert_int_equal(g.lamp[0].actual_permille, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_lease_lapses_400_ms_after_its_last_renewal_and_not_before),
        cmocka_unit_test(renewing_in_bulk_is_renewing_every_100_ms),
        cmocka_unit_test(max_on_strikes_at_its_instant_even_when_looked_at_late),
        cmocka_unit_test(after_max_on_only_a_person_gives_the_lamp_back),
        cmocka_unit_test(duty_strikes_when_the_window_is_full_and_ends_when_it_has_room),
        cmocka_unit_test(a_lamp_switched_more_often_than_spans_are_kept_is_not_tripped_wrongly),
        cmocka_unit_test(heat_trips_and_only_cooling_below_the_hysteresis_ends_it),
        cmocka_unit_test(a_temperature_missing_for_10_s_trips),
        cmocka_unit_test(a_reading_that_comes_late_counts_from_when_it_was_made),
        cmocka_unit_test(a_reading_older_than_10_s_lights_no_lamp_and_has_cooled_none),
        cmocka_unit_test(a_hot_lamp_is_not_lit_in_the_first_place),
        cmocka_unit_test(a_lamp_that_must_cool_is_not_lit_sooner_for_having_met_the_door_meanwhile),
        cmocka_unit_test(a_guardian_that_begins_trusts_no_lamp_to_be_cool),
        cmocka_unit_test(after_a_restart_a_window_counts_as_used_up),
        cmocka_unit_test(the_door_darkens_interlocked_lamps_only),
        cmocka_unit_test(a_new_lease_starts_dark_and_clears_the_lapse),
        cmocka_unit_test(levels_are_rounded_to_what_a_lamp_can_do),
        cmocka_unit_test(time_does_not_run_backwards),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
