/* SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <errno.h>

#include "conformance.h"

static void it_is_fed_only_when_armed(void **state)
{
    struct ttf_watchdog *dog = ((struct ttf_box *)*state)->watchdog;

    assert_int_equal(ttf_watchdog_feed(dog), -EPIPE);
    assert_int_equal(ttf_watchdog_arm(dog, 0), -EINVAL);
    assert_int_equal(ttf_watchdog_arm(dog, -TTF_NS_PER_S), -EINVAL);
    assert_int_equal(ttf_watchdog_arm(dog, 10 * TTF_NS_PER_S), 0);
    assert_int_equal(ttf_watchdog_feed(dog), 0);
    ttf_watchdog_disarm(dog);
    assert_int_equal(ttf_watchdog_feed(dog), -EPIPE);
    ttf_watchdog_disarm(dog);
}

int conformance_watchdog(const struct conformance_factory *factory)
{
    const struct CMUnitTest tests[] = {
        CONFORMANCE_TEST(it_is_fed_only_when_armed, factory),
    };

    return _cmocka_run_group_tests(factory->name, tests, TTF_COUNT_OF(tests), NULL, NULL);
}
