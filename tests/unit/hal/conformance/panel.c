/* SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <errno.h>

#include "conformance.h"

static void the_light_shows_each_state_or_says_that_it_cannot(void **state)
{
    struct ttf_panel *panel = ((struct ttf_box *)*state)->panel;

    for (int led = 0; led < TTF_LED_COUNT; led++) {
        int r = ttf_panel_led(panel, (enum ttf_led)led);

        assert_true(r == 0 || r == -ENOTSUP);
    }
    assert_int_equal(ttf_panel_led(panel, TTF_LED_COUNT), -EINVAL);
}

static void the_door_is_open_closed_or_not_watched(void **state)
{
    int r = ttf_panel_door(((struct ttf_box *)*state)->panel);

    assert_true(r == 0 || r == 1 || r == -ENOTSUP);
}

static void polling_without_events_does_not_block(void **state)
{
    struct ttf_panel *panel = ((struct ttf_box *)*state)->panel;
    struct ttf_panel_event event;

    for (int i = 0; i < 1000; i++)
        if (ttf_panel_poll(panel, &event) == 0)
            return;
    fail_msg("events do not end");
}

int conformance_panel(const struct conformance_factory *factory)
{
    const struct CMUnitTest tests[] = {
        CONFORMANCE_TEST(the_light_shows_each_state_or_says_that_it_cannot, factory),
        CONFORMANCE_TEST(the_door_is_open_closed_or_not_watched, factory),
        CONFORMANCE_TEST(polling_without_events_does_not_block, factory),
    };

    return _cmocka_run_group_tests(factory->name, tests, TTF_COUNT_OF(tests), NULL, NULL);
}
