/* SPDX-License-Identifier: Apache-2.0 */
/* Numbers of 16 bits with a point, as f16 streams store them. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <math.h>

#include "half.h"

#define INFINITE 0x7c00u

static void every_half_comes_back(void **state)
{
    (void)state;
    for (uint32_t h = 0; h <= 0xffffu; h++) {
        if ((h & 0x7fffu) > INFINITE)
            assert_true(isnan(ttf_half_to_float((uint16_t)h)));
        else
            assert_int_equal(ttf_half_of_float(ttf_half_to_float((uint16_t)h)), h);
    }
    assert_true((ttf_half_of_float(NAN) & 0x7fffu) > INFINITE);
}

static void known_numbers_have_their_codes(void **state)
{
    (void)state;
    assert_true(ttf_half_to_float(0x3c00) == 1.0f);
    assert_true(ttf_half_to_float(0xc000) == -2.0f);
    assert_true(ttf_half_to_float(0x7bff) == 65504.0f);
    assert_true(ttf_half_to_float(0x0001) == 0x1p-24f);
    assert_true(isinf(ttf_half_to_float(INFINITE)));
    assert_int_equal(ttf_half_of_float(65519.0f), 0x7bff);
    assert_int_equal(ttf_half_of_float(65520.0f), INFINITE);
    assert_int_equal(ttf_half_of_float(-1e30f), 0xfc00);
    assert_int_equal(ttf_half_of_float(0x1p-26f), 0);
}

/* Between two neighbours: the nearer one; of two equally near the even one. */
static void others_go_to_the_nearest(void **state)
{
    (void)state;
    for (uint16_t h = 0; h < 0x7bff; h++) {
        float low = ttf_half_to_float(h), high = ttf_half_to_float((uint16_t)(h + 1));
        float middle = (low + high) / 2; /* exact: a float has 13 bits more */

        assert_true(low < high);
        assert_int_equal(ttf_half_of_float(nextafterf(middle, low)), h);
        assert_int_equal(ttf_half_of_float(middle), h & 1u ? h + 1 : h);
        assert_int_equal(ttf_half_of_float(nextafterf(middle, high)), h + 1);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_half_comes_back),
        cmocka_unit_test(known_numbers_have_their_codes),
        cmocka_unit_test(others_go_to_the_nearest),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
