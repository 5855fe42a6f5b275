/* SPDX-License-Identifier: Apache-2.0 */
/* What only virtual time promises: it stands while anybody works, and turns come in the same order every time. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <errno.h>
#include <pthread.h>
#include <stdio.h>
#include <string.h>

#include "clock.h"
#include "ttf/base/time.h"

#define S  TTF_NS_PER_S
#define MS TTF_NS_PER_MS

static struct ttf_clock *make(void)
{
    const int64_t cost[TTF_WORK_COUNT] = {[TTF_WORK_DEVELOP] = 30 * MS, [TTF_WORK_COMMIT] = 7 * MS};
    struct ttf_clock *clock =
        sim_clock_virtual_create(S, "00000000-0000-4000-8000-000000000000", cost, NULL);

    assert_non_null(clock);
    return clock;
}

static void a_week_passes_at_once_and_to_the_nanosecond(void **state)
{
    struct ttf_clock *clock = make();

    (void)state;
    ttf_clock_join(clock);
    assert_true(ttf_clock_is_virtual(clock));
    for (int64_t k = 1; k <= 1008; k++) {
        ttf_clock_wait_until(clock, S + k * 600 * S);
        assert_true(ttf_clock_now_ns(clock) == S + k * 600 * S);
    }
    ttf_clock_leave(clock);
    ttf_clock_destroy(clock);
}

static void work_costs_what_the_board_says(void **state)
{
    struct ttf_clock *clock = make();

    (void)state;
    ttf_clock_join(clock);
    ttf_clock_charge(clock, TTF_WORK_DEVELOP, 3);
    assert_true(ttf_clock_now_ns(clock) == S + 90 * MS);
    ttf_clock_charge(clock, TTF_WORK_COMMIT, 1);
    assert_true(ttf_clock_now_ns(clock) == S + 97 * MS);
    ttf_clock_charge(clock, TTF_WORK_COMMIT, 0);
    ttf_clock_charge(clock, TTF_WORK_COUNT, 1);
    assert_true(ttf_clock_now_ns(clock) == S + 97 * MS);
    ttf_clock_leave(clock);
    ttf_clock_destroy(clock);
}

struct worker {
    struct ttf_clock *clock;
    struct ttf_gate *gate;
    pthread_mutex_t *lock;
    char *log; /* who had a turn */
    size_t *n;
    char name;
    int64_t step_ns;
    int rounds;
    int64_t seen_ns;
};

static void write_log(struct worker *w)
{
    pthread_mutex_lock(w->lock);
    w->log[(*w->n)++] = w->name;
    pthread_mutex_unlock(w->lock);
}

static void *work(void *arg)
{
    struct worker *w = arg;

    /* Apart first, so that arrival no longer depends on which thread the system starts first. */
    ttf_clock_wait_until(w->clock, S + (w->name - 'a' + 1));
    for (int k = 1; k <= w->rounds; k++) {
        ttf_clock_wait_until(w->clock, 2 * S + k * w->step_ns);
        write_log(w);
    }
    ttf_clock_leave(w->clock);
    return NULL;
}

static void run_workers(char *log, size_t size, const int64_t step_ns[3], int rounds)
{
    struct ttf_clock *clock = make();
    pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
    struct worker w[3];
    pthread_t threads[3];
    size_t n = 0;

    memset(log, 0, size);
    for (int i = 0; i < 3; i++) {
        w[i] = (struct worker){.clock = clock,
                               .lock = &lock,
                               .log = log,
                               .n = &n,
                               .name = (char)('a' + i),
                               .step_ns = step_ns[i],
                               .rounds = rounds};
        ttf_clock_join_for(clock);
    }
    for (int i = 0; i < 3; i++)
        assert_int_equal(pthread_create(&threads[i], NULL, work, &w[i]), 0);
    for (int i = 0; i < 3; i++)
        pthread_join(threads[i], NULL);
    assert_int_equal(n, 3 * rounds);
    ttf_clock_destroy(clock);
}

static void threads_take_their_turns_in_the_same_order_every_time(void **state)
{
    const int64_t steps[3] = {2 * MS, 3 * MS, 4 * MS};
    char first[256], again[256];

    (void)state;
    run_workers(first, sizeof(first), steps, 60);
    for (int i = 0; i < 20; i++) {
        run_workers(again, sizeof(again), steps, 60);
        assert_string_equal(first, again);
    }
}

static void among_equal_deadlines_whoever_asked_first_comes_first(void **state)
{
    const int64_t steps[3] = {MS, MS, MS};
    char log[256];

    (void)state;
    run_workers(log, sizeof(log), steps, 3);
    assert_string_equal(log, "abcabcabc");
}

static void *wait_at_gate(void *arg)
{
    struct worker *w = arg;

    assert_int_equal(ttf_gate_wait(w->gate, TTF_NS_NEVER), 0);
    w->seen_ns = ttf_clock_now_ns(w->clock);
    ttf_clock_leave(w->clock);
    return NULL;
}

static void a_thread_let_through_a_gate_runs_before_time_goes_on(void **state)
{
    (void)state;
    for (int i = 0; i < 50; i++) {
        struct ttf_clock *clock = make();
        struct worker w = {.clock = clock, .gate = ttf_gate_create(clock)};
        pthread_t thread;

        ttf_clock_join(clock);
        ttf_clock_join_for(clock);
        assert_int_equal(pthread_create(&thread, NULL, wait_at_gate, &w), 0);
        ttf_clock_wait_until(clock, 2 * S);
        ttf_gate_open(w.gate);
        ttf_clock_wait_until(clock, 100 * S);
        assert_true(w.seen_ns == 2 * S);
        ttf_clock_leave(clock);
        pthread_join(thread, NULL);
        ttf_gate_destroy(w.gate);
        ttf_clock_destroy(clock);
    }
}

static void time_stands_still_while_a_joined_thread_works(void **state)
{
    struct ttf_clock *clock = make();
    struct worker w = {.clock = clock, .gate = ttf_gate_create(clock)};
    pthread_t thread;

    (void)state;
    ttf_clock_join(clock);
    ttf_clock_join_for(clock);
    assert_int_equal(pthread_create(&thread, NULL, wait_at_gate, &w), 0);
    for (volatile int spin = 0; spin < 3000000; spin++)
        ;
    assert_true(ttf_clock_now_ns(clock) == S);
    ttf_gate_open(w.gate);
    ttf_clock_leave(clock);
    pthread_join(thread, NULL);
    assert_true(w.seen_ns == S);
    ttf_gate_destroy(w.gate);
    ttf_clock_destroy(clock);
}

static void *open_late(void *arg)
{
    struct worker *w = arg;

    for (int k = 1; k <= w->rounds; k++) {
        ttf_clock_wait_until(w->clock, S + k * 10 * MS);
        ttf_gate_open(w->gate);
    }
    ttf_clock_leave(w->clock);
    return NULL;
}

static void an_opening_at_the_deadline_itself_is_not_lost(void **state)
{
    struct ttf_clock *clock = make();
    struct worker w = {.clock = clock, .gate = ttf_gate_create(clock), .rounds = 200};
    pthread_t thread;
    int passed = 0;

    (void)state;
    ttf_clock_join(clock);
    ttf_clock_join_for(clock);
    assert_int_equal(pthread_create(&thread, NULL, open_late, &w), 0);
    for (int k = 1; k <= w.rounds; k++) {
        int r = ttf_gate_wait(w.gate, S + k * 10 * MS);

        assert_true(r == 0 || r == -ETIMEDOUT);
        passed += r == 0;
        if (r < 0)
            passed += ttf_gate_wait(w.gate, S + k * 10 * MS + MS) == 0;
    }
    assert_int_equal(passed, w.rounds);
    ttf_clock_leave(clock);
    pthread_join(thread, NULL);
    ttf_gate_destroy(w.gate);
    ttf_clock_destroy(clock);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_week_passes_at_once_and_to_the_nanosecond),
        cmocka_unit_test(work_costs_what_the_board_says),
        cmocka_unit_test(threads_take_their_turns_in_the_same_order_every_time),
        cmocka_unit_test(among_equal_deadlines_whoever_asked_first_comes_first),
        cmocka_unit_test(a_thread_let_through_a_gate_runs_before_time_goes_on),
        cmocka_unit_test(time_stands_still_while_a_joined_thread_works),
        cmocka_unit_test(an_opening_at_the_deadline_itself_is_not_lost),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
