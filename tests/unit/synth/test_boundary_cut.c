/* SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "seam/boundary_cut.h"

#define STEPS_MAX 8
#define WIDTH_MAX 5

static uint32_t next_random(uint32_t *state)
{
    *state = *state * 1664525u + 1013904223u;
    return *state >> 16;
}

/* The cheapest of all connected paths, one by one. */
static uint64_t cheapest_path(const uint64_t *error, uint32_t steps, uint32_t width, uint32_t step,
                              uint32_t at)
{
    uint64_t best = UINT64_MAX;

    if (step + 1 == steps)
        return error[step * width + at];
    for (int d = -1; d <= 1; d++) {
        int64_t next = (int64_t)at + d;

        if (next >= 0 && next < width) {
            uint64_t cost = cheapest_path(error, steps, width, step + 1, (uint32_t)next);

            best = cost < best ? cost : best;
        }
    }
    return error[step * width + at] + best;
}

static void a_cut_is_as_cheap_as_the_best_of_all_paths(void **state)
{
    uint32_t random = 7;

    (void)state;
    for (int round = 0; round < 300; round++) {
        uint32_t steps = 1 + next_random(&random) % STEPS_MAX;
        uint32_t width = 1 + next_random(&random) % WIDTH_MAX;
        uint64_t error[STEPS_MAX * WIDTH_MAX], best = UINT64_MAX, total, sum = 0;
        uint32_t cut[STEPS_MAX];

        for (uint32_t i = 0; i < steps * width; i++)
            error[i] = next_random(&random) % (round % 2 ? 4 : 1000);
        for (uint32_t j = 0; j < width; j++) {
            uint64_t cost = cheapest_path(error, steps, width, 0, j);

            best = cost < best ? cost : best;
        }
        assert_int_equal(ttf_boundary_cut(error, steps, width, cut, &total), 0);
        for (uint32_t i = 0; i < steps; i++) {
            assert_true(cut[i] < width);
            assert_true(i == 0 || (cut[i] <= cut[i - 1] + 1 && cut[i - 1] <= cut[i] + 1));
            sum += error[i * width + cut[i]];
        }
        assert_int_equal(total, best);
        assert_int_equal(sum, best);
    }
}

static void equal_errors_are_cut_at_the_lowest_index(void **state)
{
    const uint64_t error[4 * 3] = {5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5};
    uint32_t cut[4];

    (void)state;
    assert_int_equal(ttf_boundary_cut(error, 4, 3, cut, NULL), 0);
    for (int i = 0; i < 4; i++)
        assert_int_equal(cut[i], 0);
}

static void a_wall_of_errors_is_crossed_where_it_is_lowest(void **state)
{
    const uint64_t error[3 * 3] = {0, 9, 9, 9, 1, 9, 9, 9, 0};
    uint32_t cut[3];
    uint64_t total;

    (void)state;
    assert_int_equal(ttf_boundary_cut(error, 3, 3, cut, &total), 0);
    assert_int_equal(total, 1);
    assert_int_equal(cut[0], 0);
    assert_int_equal(cut[1], 1);
    assert_int_equal(cut[2], 2);
}

static void sums_beyond_32_bits_are_exact(void **state)
{
    const uint64_t error[2 * 2] = {UINT64_C(1) << 40, (UINT64_C(1) << 40) + 1,
                                   (UINT64_C(1) << 50) + 1, UINT64_C(1) << 50};
    uint32_t cut[2];
    uint64_t total;

    (void)state;
    assert_int_equal(ttf_boundary_cut(error, 2, 2, cut, &total), 0);
    assert_int_equal(total, (UINT64_C(1) << 40) + (UINT64_C(1) << 50));
    assert_int_equal(cut[0], 0);
    assert_int_equal(cut[1], 1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_cut_is_as_cheap_as_the_best_of_all_paths),
        cmocka_unit_test(equal_errors_are_cut_at_the_lowest_index),
        cmocka_unit_test(a_wall_of_errors_is_crossed_where_it_is_lowest),
        cmocka_unit_test(sums_beyond_32_bits_are_exact),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
