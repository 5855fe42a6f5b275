/* SPDX-License-Identifier: Apache-2.0 */
/* The time of a block (eq. 6, 7): properties that hold for every seed, reach and length. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <stdlib.h>
#include <string.h>

#include "quilt/time_jitter.h"

#define ONE ((int64_t)TTF_TIME_ONE)

static void each_time_is_a_walk_near_the_true_one(uint64_t seed, unsigned block, uint32_t e,
                                                  uint32_t every, uint32_t n)
{
    uint32_t *f = malloc(n * sizeof(*f));

    assert_non_null(f);
    ttf_time_jitter(seed, block, e, every, n, f);
    assert_int_equal(f[0], 0);
    for (uint32_t t = 0; t < n; t++) {
        int64_t off = (int64_t)f[t] - t * ONE, step = t > 0 ? (int64_t)f[t] - f[t - 1] : 0;

        assert_true(off <= e * ONE && off >= -(e * ONE));
        assert_true(step >= 0 && step <= 2 * ONE);
    }
    free(f);
}

static void time_begins_at_zero_never_runs_back_and_stays_near(void **state)
{
    (void)state;
    for (uint64_t seed = 0; seed < 400; seed++) {
        uint32_t e = (uint32_t)(seed % 7), n = 1 + (uint32_t)(seed * 37 % 300);

        each_time_is_a_walk_near_the_true_one(seed, (unsigned)(seed % 11), e, 1, n);
        each_time_is_a_walk_near_the_true_one(seed, (unsigned)(seed % 11), e,
                                              2 + (uint32_t)(seed % 15), n);
        each_time_is_a_walk_near_the_true_one(UINT64_MAX - seed, UINT32_MAX, 1u << (seed % 21), 1,
                                              n);
    }
    each_time_is_a_walk_near_the_true_one(3, 4, 1u << 20, 1, 65536); /* the longest */
}

static void the_whole_reach_is_used_and_steps_are_spread_evenly(void **state)
{
    uint32_t f[1000], tenths[20] = {0};
    int64_t least = 0, most = 0;
    double sum = 0.0;

    (void)state;
    for (uint64_t seed = 0; seed < 100; seed++) {
        ttf_time_jitter(seed, 7, 1000, 1, 1000, f);
        for (uint32_t t = 1; t < 1000; t++) {
            uint32_t step = f[t] - f[t - 1];

            tenths[step < 2 * ONE ? step * 10ul / TTF_TIME_ONE : 19]++;
            sum += (double)step / (double)ONE;
        }
    }
    for (int i = 0; i < 20; i++) /* 99,900 steps */
        assert_in_range(tenths[i], 4995 - 500, 4995 + 500);
    assert_true(sum / 99900.0 > 0.98 && sum / 99900.0 < 1.02);
    for (uint64_t seed = 0; seed < 100; seed++) {
        ttf_time_jitter(seed, 7, 2, 1, 1000, f);
        for (uint32_t t = 0; t < 1000; t++) {
            int64_t off = (int64_t)f[t] - t * ONE;

            least = off < least ? off : least;
            most = off > most ? off : most;
        }
    }
    assert_true(least < -19 * ONE / 10 && most > 19 * ONE / 10);
}

static void steps_now_and_then_leave_most_frames_whole(void **state)
{
    uint32_t f[1000], fractions = 0, moved = 0;

    (void)state;
    for (uint64_t seed = 0; seed < 50; seed++) {
        ttf_time_jitter(seed, 7, 4, 12, 1000, f);
        for (uint32_t t = 0; t < 1000; t++) {
            fractions += f[t] % TTF_TIME_ONE != 0;
            moved += f[t] != t * TTF_TIME_ONE;
        }
    }
    assert_in_range(fractions, 1, 50000 / 20); /* one in twenty */
    assert_in_range(moved, 30000, 50000);      /* and still most are elsewhere */
}

static void without_reach_there_is_no_jitter(void **state)
{
    uint32_t f[300];

    (void)state;
    for (uint64_t seed = 0; seed < 50; seed++) {
        ttf_time_jitter(seed, 3, 0, 1, 300, f);
        for (uint32_t t = 0; t < 300; t++)
            assert_int_equal(f[t], t * TTF_TIME_ONE);
    }
}

static void blocks_and_seeds_have_times_of_their_own(void **state)
{
    uint32_t a[50], b[50];

    (void)state;
    for (unsigned block = 0; block < 100; block++) {
        ttf_time_jitter(1, block, 5, 1, 50, a);
        ttf_time_jitter(1, block + 1, 5, 1, 50, b);
        assert_memory_not_equal(a, b, sizeof(a));
        ttf_time_jitter(2, block, 5, 1, 50, b);
        assert_memory_not_equal(a, b, sizeof(a));
        ttf_time_jitter(1, block, 5, 1, 50, b);
        assert_memory_equal(a, b, sizeof(a));
        ttf_time_jitter(1, block, 5, 1, 20, b); /* a longer input begins the same */
        assert_memory_equal(a, b, 20 * sizeof(*a));
    }
}

static void all_blocks_of_a_map_are_filled(void **state)
{
    struct ttf_quilt_map map = {.n_blocks = 4};
    uint32_t f[30];

    (void)state;
    assert_int_equal(ttf_time_jitter_fill(9, 3, 1, 30, &map), 0);
    assert_int_equal(map.n_times, 30);
    for (unsigned i = 0; i < 4; i++) {
        ttf_time_jitter(9, i, 3, 1, 30, f);
        assert_memory_equal(map.times + i * 30ul, f, sizeof(f));
    }
    ttf_quilt_map_free(&map);
}

static void times_between_frames_lie_between_and_ends_are_clamped(void **state)
{
    static const uint32_t f[4] = {0, 0, 2 * TTF_TIME_ONE, 4 * TTF_TIME_ONE}; /* beyond the end */

    (void)state;
    assert_int_equal(ttf_time_at(f, 4, 0), 0);
    assert_int_equal(ttf_time_at(f, 4, TTF_TIME_ONE / 2), 0);
    assert_int_equal(ttf_time_at(f, 4, TTF_TIME_ONE), 0);
    assert_int_equal(ttf_time_at(f, 4, TTF_TIME_ONE + 1), 2);
    assert_int_equal(ttf_time_at(f, 4, 3 * TTF_TIME_ONE / 2), TTF_TIME_ONE);
    assert_int_equal(ttf_time_at(f, 4, 2 * TTF_TIME_ONE), 2 * TTF_TIME_ONE);
    assert_int_equal(ttf_time_at(f, 4, 9 * TTF_TIME_ONE / 4), 5 * TTF_TIME_ONE / 2);
    assert_int_equal(ttf_time_at(f, 4, 11 * TTF_TIME_ONE / 4), 3 * TTF_TIME_ONE);
    assert_int_equal(ttf_time_at(f, 4, 3 * TTF_TIME_ONE), 3 * TTF_TIME_ONE);
    assert_int_equal(ttf_time_at(f, 4, UINT64_MAX), 3 * TTF_TIME_ONE);
}

static void without_jitter_time_is_what_it_is_up_to_the_end(void **state)
{
    (void)state;
    assert_int_equal(ttf_time_at(NULL, 5, 0), 0);
    assert_int_equal(ttf_time_at(NULL, 5, 12345), 12345);
    assert_int_equal(ttf_time_at(NULL, 5, 4 * TTF_TIME_ONE), 4 * TTF_TIME_ONE);
    assert_int_equal(ttf_time_at(NULL, 5, 4 * TTF_TIME_ONE + 1), 4 * TTF_TIME_ONE);
    assert_int_equal(ttf_time_at(NULL, 1, TTF_TIME_ONE), 0); /* a still stays one */
    assert_int_equal(ttf_time_at(NULL, 65536, UINT64_MAX), 65535u * TTF_TIME_ONE);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(time_begins_at_zero_never_runs_back_and_stays_near),
        cmocka_unit_test(the_whole_reach_is_used_and_steps_are_spread_evenly),
        cmocka_unit_test(steps_now_and_then_leave_most_frames_whole),
        cmocka_unit_test(without_reach_there_is_no_jitter),
        cmocka_unit_test(blocks_and_seeds_have_times_of_their_own),
        cmocka_unit_test(all_blocks_of_a_map_are_filled),
        cmocka_unit_test(times_between_frames_lie_between_and_ends_are_clamped),
        cmocka_unit_test(without_jitter_time_is_what_it_is_up_to_the_end),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
