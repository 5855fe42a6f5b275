/* SPDX-License-Identifier: Apache-2.0 */
/* Memory for numbers that are read a vector at a time. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <string.h>

#include "search/lanes.h"

#define LARGE ((size_t)2 << 20)

static void numbers_are_aligned_and_zero(void **state)
{
    const size_t bytes[] = {2, 62, 64, 4098, LARGE - 2, LARGE, LARGE + 2, 3 * LARGE};

    (void)state;
    /* again and again: memory that was used before, too */
    for (unsigned round = 0; round < 3; round++) {
        for (size_t i = 0; i < sizeof(bytes) / sizeof(bytes[0]); i++) {
            int16_t *numbers = ttf_lanes_alloc(bytes[i] / 2);

            assert_non_null(numbers);
            assert_int_equal((uintptr_t)numbers % (bytes[i] < LARGE ? 64 : LARGE), 0);
            for (size_t k = 0; k < bytes[i] / 2; k++)
                assert_int_equal(numbers[k], 0);
            memset(numbers, 0xff, bytes[i]);
            ttf_lanes_free(numbers);
        }
    }
    ttf_lanes_free(NULL);
}

static void too_many_are_refused(void **state)
{
    (void)state;
    assert_null(ttf_lanes_alloc(SIZE_MAX / 2));
    assert_null(ttf_lanes_alloc(SIZE_MAX - 1));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(numbers_are_aligned_and_zero),
        cmocka_unit_test(too_many_are_refused),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
