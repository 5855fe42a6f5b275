/* SPDX-License-Identifier: Apache-2.0 */
/* test_flicker.c: bands of a lamp that is dimmed by pulses, against windows laid over the pulses one by one. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "flicker.h"

/* Light in a window of `exposure` that begins `from` after a pulse's beginning, counted tick by tick. */
static int64_t light_ns(int64_t from, int64_t exposure, int64_t period, int64_t lit)
{
    int64_t sum = 0;

    for (int64_t t = from; t < from + exposure; t++)
        sum += t % period < lit;
    return sum;
}

static void bands_are_what_rows_that_begin_anywhere_in_a_cycle_see(void **state)
{
    static const int64_t EXPOSURES[] = {37, 100, 130, 250, 999, 1000, 1050};

    (void)state;
    for (unsigned e = 0; e < sizeof EXPOSURES / sizeof *EXPOSURES; e++)
        for (unsigned permille = 100; permille <= 900; permille += 200) {
            int64_t most = 0, least = INT64_MAX, want;

            for (int64_t from = 0; from < 100; from++) {
                int64_t light = light_ns(from, EXPOSURES[e], 100, permille / 10);

                most = light > most ? light : most;
                least = light < least ? light : least;
            }
            want =
                (int64_t)((double)(most - least) * 1e9 / (double)(EXPOSURES[e] * permille) + 0.5);
            assert_int_equal(ttf_flicker_ppm(EXPOSURES[e], 100, permille), want);
        }
}

static void whole_cycles_full_light_and_no_light_leave_no_bands(void **state)
{
    (void)state;
    assert_int_equal(ttf_flicker_ppm(10000000, 50000, 500), 0);
    assert_int_equal(ttf_flicker_ppm(10000001, 50000, 1000), 0);
    assert_int_equal(ttf_flicker_ppm(10000001, 50000, 0), 0);
    assert_int_equal(ttf_flicker_ppm(10000001, 0, 500), 0);
    assert_true(ttf_flicker_ppm(10025000, 50000, 500) > 4000);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bands_are_what_rows_that_begin_anywhere_in_a_cycle_see),
        cmocka_unit_test(whole_cycles_full_light_and_no_light_leave_no_bands),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
