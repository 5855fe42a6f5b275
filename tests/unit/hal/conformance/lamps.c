/* SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <errno.h>
#include <string.h>

#include "conformance.h"

#define MS TTF_NS_PER_MS

static struct ttf_lamps *lamps_of(void **state)
{
    return ((struct ttf_box *)*state)->lamps;
}

static struct ttf_clock *clock_of(void **state)
{
    return ((struct ttf_box *)*state)->clock;
}

static int64_t in(void **state, int64_t ns)
{
    return ttf_clock_now_ns(clock_of(state)) + ns;
}

static struct ttf_lamp_state look(struct ttf_lamps *lamps, unsigned i)
{
    struct ttf_lamp_state s;

    assert_int_equal(ttf_lamps_state(lamps, i, &s), 0);
    return s;
}

static void every_lamp_is_found_by_its_name(void **state)
{
    struct ttf_lamps *lamps = lamps_of(state);

    assert_true(ttf_lamps_count(lamps) >= 1 && ttf_lamps_count(lamps) <= TTF_LAMPS_MAX);
    for (unsigned i = 0; i < ttf_lamps_count(lamps); i++)
        assert_int_equal(ttf_lamps_find(lamps, ttf_lamps_info(lamps, i)->name), (int)i);
    assert_int_equal(ttf_lamps_find(lamps, "no-such-lamp"), -ENOENT);
    assert_null(ttf_lamps_info(lamps, ttf_lamps_count(lamps)));
}

static void without_a_lease_nothing_lights_but_off_works(void **state)
{
    struct ttf_lamps *lamps = lamps_of(state);

    assert_int_equal(ttf_lamps_set(lamps, 0, 1000, NULL), -ESTALE);
    assert_int_equal(look(lamps, 0).actual_permille, 0);
    assert_int_equal(ttf_lamps_set(lamps, 0, 0, NULL), 0);
    assert_int_equal(ttf_lamps_alive(lamps, in(state, TTF_NS_PER_S), NULL), -ESTALE);
}

static void a_commanded_lamp_is_lit_and_counts_its_hours(void **state)
{
    struct ttf_lamps *lamps = lamps_of(state);
    struct ttf_lamp_state s;

    ttf_clock_join(clock_of(state));
    assert_int_equal(ttf_lamps_acquire(lamps, in(state, TTF_NS_PER_S), NULL), 0);
    assert_int_equal(ttf_lamps_set(lamps, 0, 1000, NULL), 0);
    s = look(lamps, 0);
    assert_int_equal(s.commanded_permille, 1000);
    assert_int_equal(s.actual_permille, 1000);
    assert_int_equal(s.trip, TTF_TRIP_NONE);
    assert_true(s.on_since_ns != TTF_NS_UNKNOWN);
    ttf_clock_wait_until(clock_of(state), in(state, 50 * MS));
    assert_true(look(lamps, 0).on_total_ns >= 50 * MS);
    assert_int_equal(ttf_lamps_set(lamps, 0, 0, NULL), 0);
    s = look(lamps, 0);
    assert_int_equal(s.actual_permille, 0);
    assert_true(s.on_since_ns == TTF_NS_UNKNOWN);
    ttf_lamps_release(lamps);
    ttf_clock_leave(clock_of(state));
}

static void impossible_commands_are_refused(void **state)
{
    struct ttf_lamps *lamps = lamps_of(state);
    struct ttf_lamp_state s;

    assert_int_equal(ttf_lamps_acquire(lamps, in(state, TTF_NS_PER_S), NULL), 0);
    assert_int_equal(ttf_lamps_set(lamps, 0, 1001, NULL), -EINVAL);
    assert_int_equal(ttf_lamps_set(lamps, ttf_lamps_count(lamps), 0, NULL), -EINVAL);
    assert_int_equal(ttf_lamps_state(lamps, ttf_lamps_count(lamps), &s), -EINVAL);
    assert_int_equal(ttf_lamps_clear(lamps, ttf_lamps_count(lamps), NULL), -EINVAL);
}

static void only_one_client_holds_the_lease(void **state)
{
    struct ttf_lamps *lamps = lamps_of(state);

    assert_int_equal(ttf_lamps_acquire(lamps, in(state, TTF_NS_PER_S), NULL), 0);
    assert_int_equal(ttf_lamps_acquire(lamps, in(state, TTF_NS_PER_S), NULL), -EBUSY);
    ttf_lamps_release(lamps);
    assert_int_equal(ttf_lamps_acquire(lamps, in(state, TTF_NS_PER_S), NULL), 0);
    ttf_lamps_release(lamps);
}

static void a_declared_long_exposure_is_no_hang(void **state)
{
    struct ttf_lamps *lamps = lamps_of(state);

    ttf_clock_join(clock_of(state));
    assert_int_equal(ttf_lamps_acquire(lamps, in(state, TTF_NS_PER_S), NULL), 0);
    assert_int_equal(ttf_lamps_set(lamps, 0, 1000, NULL), 0);
    ttf_clock_wait_until(clock_of(state), in(state, 700 * MS));
    assert_int_equal(look(lamps, 0).actual_permille, 1000);
    assert_int_equal(ttf_lamps_alive(lamps, in(state, TTF_NS_PER_S), NULL), 0);
    ttf_clock_leave(clock_of(state));
}

static void an_overdue_sign_of_life_turns_everything_off(void **state)
{
    struct ttf_lamps *lamps = lamps_of(state);

    ttf_clock_join(clock_of(state));
    assert_int_equal(ttf_lamps_acquire(lamps, in(state, 200 * MS), NULL), 0);
    assert_int_equal(ttf_lamps_set(lamps, 0, 1000, NULL), 0);
    ttf_clock_wait_until(clock_of(state), in(state, 200 * MS + TTF_LEASE_LAPSE_NS + 20 * MS));
    assert_int_equal(look(lamps, 0).actual_permille, 0);
    assert_int_equal(look(lamps, 0).trip, TTF_TRIP_LEASE);
    assert_int_equal(ttf_lamps_set(lamps, 0, 1000, NULL), -ESTALE);
    assert_int_equal(ttf_lamps_alive(lamps, in(state, TTF_NS_PER_S), NULL), -ESTALE);
    assert_int_equal(ttf_lamps_acquire(lamps, in(state, TTF_NS_PER_S), NULL), 0);
    assert_int_equal(look(lamps, 0).actual_permille, 0);
    assert_int_equal(ttf_lamps_set(lamps, 0, 1000, NULL), 0);
    ttf_clock_leave(clock_of(state));
}

static void release_turns_everything_off_without_a_trip(void **state)
{
    struct ttf_lamps *lamps = lamps_of(state);

    assert_int_equal(ttf_lamps_acquire(lamps, in(state, TTF_NS_PER_S), NULL), 0);
    assert_int_equal(ttf_lamps_set(lamps, 0, 1000, NULL), 0);
    ttf_lamps_release(lamps);
    assert_int_equal(look(lamps, 0).actual_permille, 0);
    assert_int_equal(look(lamps, 0).trip, TTF_TRIP_NONE);
}

int conformance_lamps(const struct conformance_factory *factory)
{
    const struct CMUnitTest tests[] = {
        CONFORMANCE_TEST(every_lamp_is_found_by_its_name, factory),
        CONFORMANCE_TEST(without_a_lease_nothing_lights_but_off_works, factory),
        CONFORMANCE_TEST(a_commanded_lamp_is_lit_and_counts_its_hours, factory),
        CONFORMANCE_TEST(impossible_commands_are_refused, factory),
        CONFORMANCE_TEST(only_one_client_holds_the_lease, factory),
        CONFORMANCE_TEST(a_declared_long_exposure_is_no_hang, factory),
        CONFORMANCE_TEST(an_overdue_sign_of_life_turns_everything_off, factory),
        CONFORMANCE_TEST(release_turns_everything_off_without_a_trip, factory),
    };

    return _cmocka_run_group_tests(factory->name, tests, TTF_COUNT_OF(tests), NULL, NULL);
}
