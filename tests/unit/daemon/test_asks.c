/* SPDX-License-Identifier: Apache-2.0 */
/* test_asks.c: whoever waits for the answer to one thing never gets that to another. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <errno.h>

#include "asks.h"

static int known(struct asks *asks, int64_t number)
{
    struct ttf_json json;
    int r;

    ttf_json_init(&json, false);
    r = asks_show(asks, number, &json);
    ttf_json_free(&json);
    return r;
}

static void a_box_started_again_does_not_know_the_numbers_of_before(void **state)
{
    struct asks *before = asks_create(UINT64_C(0x1111222233334444));
    struct asks *after = asks_create(UINT64_C(0x5555666677778888));
    int64_t old, young;

    (void)state;
    if (!before || !after) {
        fail();
        return;
    }
    old = asks_stop(before);
    young = asks_stop(after);
    assert_int_equal(known(before, old), 0);
    assert_int_equal(known(after, young), 0);
    assert_int_equal(known(after, old), -ENOENT);
    asks_destroy(before);
    asks_destroy(after);
}

/* JavaScript's, and most of what reads JSON. */
static void a_number_is_one_that_every_client_can_hold(void **state)
{
    struct asks *asks = asks_create(UINT64_MAX);
    int64_t number;

    (void)state;
    if (!asks) {
        fail();
        return;
    }
    for (int i = 0; i < 200; i++) {
        number = asks_stop(asks);
        assert_true(number > 0 && number < INT64_C(1) << 53);
        assert_int_equal(known(asks, number), 0);
    }
    asks_destroy(asks);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_box_started_again_does_not_know_the_numbers_of_before),
        cmocka_unit_test(a_number_is_one_that_every_client_can_hold),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
