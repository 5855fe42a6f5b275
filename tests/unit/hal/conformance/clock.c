/* SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <errno.h>
#include <pthread.h>
#include <string.h>

#include "conformance.h"

#define MS TTF_NS_PER_MS

static struct ttf_clock *clock_of(void **state)
{
    return ((struct ttf_box *)*state)->clock;
}

static void the_boot_clock_does_not_go_back(void **state)
{
    struct ttf_clock *clock = clock_of(state);
    int64_t last = ttf_clock_now_ns(clock);

    for (int i = 0; i < 1000; i++) {
        int64_t now = ttf_clock_now_ns(clock);

        assert_true(now >= last);
        last = now;
    }
}

static void a_wait_ends_at_or_after_its_deadline(void **state)
{
    struct ttf_clock *clock = clock_of(state);

    ttf_clock_join(clock);
    for (int i = 1; i <= 3; i++) {
        int64_t deadline = ttf_clock_now_ns(clock) + i * 3 * MS;

        assert_int_equal(ttf_clock_wait_until(clock, deadline), 0);
        assert_true(ttf_clock_now_ns(clock) >= deadline);
        assert_true(ttf_clock_now_ns(clock) < deadline + 2000 * MS);
    }
    ttf_clock_leave(clock);
}

static void a_past_deadline_does_not_wait(void **state)
{
    struct ttf_clock *clock = clock_of(state);
    int64_t before = ttf_clock_now_ns(clock);

    ttf_clock_join(clock);
    assert_int_equal(ttf_clock_wait_until(clock, before), 0);
    assert_int_equal(ttf_clock_wait_until(clock, 0), 0);
    assert_int_equal(ttf_clock_wait_until(clock, -MS), 0);
    assert_true(ttf_clock_now_ns(clock) < before + 1000 * MS);
    ttf_clock_leave(clock);
}

static void utc_is_told_for_now_with_its_trust(void **state)
{
    struct ttf_clock *clock = clock_of(state);
    int64_t before = ttf_clock_now_ns(clock);
    struct ttf_utc utc;

    ttf_clock_utc(clock, &utc);
    assert_true(utc.boot_ns >= before);
    assert_true(utc.boot_ns <= ttf_clock_now_ns(clock));
    assert_true((unsigned)utc.trust < TTF_TRUST_COUNT);
    if (utc.trust == TTF_TRUST_NONE)
        assert_true(utc.uncertainty_ns == TTF_NS_UNKNOWN);
    else
        assert_true(utc.uncertainty_ns >= 0);
}

static void utc_runs_as_the_boot_clock_does(void **state)
{
    struct ttf_clock *clock = clock_of(state);
    struct ttf_utc a, b;
    int64_t apart;

    ttf_clock_join(clock);
    ttf_clock_utc(clock, &a);
    ttf_clock_wait_until(clock, ttf_clock_now_ns(clock) + 20 * MS);
    ttf_clock_utc(clock, &b);
    ttf_clock_leave(clock);
    apart = (b.utc_ns - a.utc_ns) - (b.boot_ns - a.boot_ns);
    if (a.steps == b.steps)
        assert_true(apart < 6 * MS && apart > -6 * MS);
}

static void the_boot_id_has_36_characters_and_stays(void **state)
{
    struct ttf_clock *clock = clock_of(state);
    const char *id = ttf_clock_boot_id(clock);

    assert_int_equal(strlen(id), 36);
    assert_int_equal(id[8], '-');
    assert_string_equal(id, ttf_clock_boot_id(clock));
}

static void an_opening_is_remembered_for_one_wait(void **state)
{
    struct ttf_clock *clock = clock_of(state);
    struct ttf_gate *gate = ttf_gate_create(clock);

    assert_non_null(gate);
    ttf_clock_join(clock);
    ttf_gate_open(gate);
    ttf_gate_open(gate);
    assert_int_equal(ttf_gate_wait(gate, TTF_NS_NEVER), 0);
    assert_int_equal(ttf_gate_wait(gate, ttf_clock_now_ns(clock) + 2 * MS), -ETIMEDOUT);
    ttf_clock_leave(clock);
    ttf_gate_destroy(gate);
}

static void an_open_gate_lets_through_even_past_the_deadline(void **state)
{
    struct ttf_clock *clock = clock_of(state);
    struct ttf_gate *gate = ttf_gate_create(clock);

    ttf_gate_open(gate);
    assert_int_equal(ttf_gate_wait(gate, 0), 0);
    assert_int_equal(ttf_gate_wait(gate, 0), -ETIMEDOUT);
    ttf_gate_destroy(gate);
}

static void a_closed_gate_times_out_at_its_deadline(void **state)
{
    struct ttf_clock *clock = clock_of(state);
    struct ttf_gate *gate = ttf_gate_create(clock);
    int64_t deadline;

    ttf_clock_join(clock);
    deadline = ttf_clock_now_ns(clock) + 5 * MS;
    assert_int_equal(ttf_gate_wait(gate, deadline), -ETIMEDOUT);
    assert_true(ttf_clock_now_ns(clock) >= deadline);
    ttf_clock_leave(clock);
    ttf_gate_destroy(gate);
}

/* --- two threads that hand a counter back and forth through gates --- */

struct relay {
    struct ttf_clock *clock;
    struct ttf_gate *there, *back;
    int rounds;
    int count; /* handed over by the gates alone */
};

static void *relay_thread(void *arg)
{
    struct relay *relay = arg;

    for (int i = 0; i < relay->rounds; i++) {
        if (ttf_gate_wait(relay->there, TTF_NS_NEVER) != 0)
            break;
        relay->count++;
        ttf_clock_wait_until(relay->clock, ttf_clock_now_ns(relay->clock) + MS / 10);
        ttf_gate_open(relay->back);
    }
    ttf_clock_leave(relay->clock);
    return NULL;
}

static void gates_hand_over_what_was_written_before_they_opened(void **state)
{
    struct ttf_clock *clock = clock_of(state);
    struct relay relay = {.clock = clock,
                          .there = ttf_gate_create(clock),
                          .back = ttf_gate_create(clock),
                          .rounds = 200};
    pthread_t thread;

    ttf_clock_join(clock);
    ttf_clock_join_for(clock);
    assert_int_equal(pthread_create(&thread, NULL, relay_thread, &relay), 0);
    for (int i = 0; i < relay.rounds; i++) {
        relay.count++;
        ttf_gate_open(relay.there);
        assert_int_equal(ttf_gate_wait(relay.back, TTF_NS_NEVER), 0);
        assert_int_equal(relay.count, 2 * (i + 1));
    }
    ttf_clock_leave(clock);
    pthread_join(thread, NULL);
    ttf_gate_destroy(relay.there);
    ttf_gate_destroy(relay.back);
}

static void *sleeper(void *arg)
{
    struct ttf_clock *clock = arg;
    int64_t start = ttf_clock_now_ns(clock);

    for (int i = 1; i <= 20; i++)
        ttf_clock_wait_until(clock, start + i * MS);
    ttf_clock_leave(clock);
    return NULL;
}

static void threads_wait_side_by_side(void **state)
{
    struct ttf_clock *clock = clock_of(state);
    int64_t start = ttf_clock_now_ns(clock);
    pthread_t threads[4];

    for (int i = 0; i < 4; i++)
        ttf_clock_join_for(clock);
    for (int i = 0; i < 4; i++)
        assert_int_equal(pthread_create(&threads[i], NULL, sleeper, clock), 0);
    for (int i = 0; i < 4; i++)
        pthread_join(threads[i], NULL);
    assert_true(ttf_clock_now_ns(clock) >= start + 20 * MS);
    assert_true(ttf_clock_now_ns(clock) < start + 4000 * MS);
}

int conformance_clock(const struct conformance_factory *factory)
{
    const struct CMUnitTest tests[] = {
        CONFORMANCE_TEST(the_boot_clock_does_not_go_back, factory),
        CONFORMANCE_TEST(a_wait_ends_at_or_after_its_deadline, factory),
        CONFORMANCE_TEST(a_past_deadline_does_not_wait, factory),
        CONFORMANCE_TEST(utc_is_told_for_now_with_its_trust, factory),
        CONFORMANCE_TEST(utc_runs_as_the_boot_clock_does, factory),
        CONFORMANCE_TEST(the_boot_id_has_36_characters_and_stays, factory),
        CONFORMANCE_TEST(an_opening_is_remembered_for_one_wait, factory),
        CONFORMANCE_TEST(an_open_gate_lets_through_even_past_the_deadline, factory),
        CONFORMANCE_TEST(a_closed_gate_times_out_at_its_deadline, factory),
        CONFORMANCE_TEST(gates_hand_over_what_was_written_before_they_opened, factory),
        CONFORMANCE_TEST(threads_wait_side_by_side, factory),
    };

    return _cmocka_run_group_tests(factory->name, tests, TTF_COUNT_OF(tests), NULL, NULL);
}
