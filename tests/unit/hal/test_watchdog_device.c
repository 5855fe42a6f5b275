/* SPDX-License-Identifier: Apache-2.0 */
/* test_watchdog_device.c: /dev/watchdog, with the test as its driver. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <errno.h>
#include <string.h>

#include "conformance/conformance.h"
#include "device.h"

/* As the kernel's watchdog core: one at a time, stopped only by a 'V' that comes last. */
static struct {
    bool open, runs;
    char last;
    int timeout, longest; /* s */
    bool held;            /* by somebody else */
    unsigned fed;
} driver;

static int driver_open(const char *path)
{
    assert_string_equal(path, "/dev/watchdog");
    if (driver.held || driver.open)
        return -EBUSY;
    driver.open = driver.runs = true;
    driver.last = '\0';
    driver.timeout = 60;
    return 7;
}

static int driver_set_timeout(int fd, int *seconds)
{
    assert_int_equal(fd, 7);
    if (driver.longest == 0)
        return -ENOTTY;
    if (*seconds > driver.longest)
        *seconds = driver.longest;
    driver.timeout = *seconds;
    return 0;
}

static int driver_write(int fd, char byte)
{
    assert_int_equal(fd, 7);
    assert_true(driver.open);
    driver.last = byte;
    driver.fed++;
    return 0;
}

static int driver_close(int fd)
{
    assert_int_equal(fd, 7);
    driver.open = false;
    if (driver.last == 'V')
        driver.runs = false;
    return 0;
}

static const struct watchdog_calls CALLS = {driver_open, driver_set_timeout, driver_write,
                                            driver_close};

static struct ttf_watchdog *made(int longest, bool held)
{
    struct ttf_watchdog *dog = NULL;

    memset(&driver, 0, sizeof(driver));
    driver.longest = longest;
    driver.held = held;
    assert_int_equal(watchdog_device_create_by(&CALLS, "/dev/watchdog", &dog, NULL), 0);
    return dog;
}

static void it_runs_from_its_arming_to_its_disarming_alone(void **state)
{
    struct ttf_watchdog *dog = made(120, false);

    (void)state;
    assert_false(driver.runs);
    assert_int_equal(ttf_watchdog_arm(dog, 15 * TTF_NS_PER_S), 0);
    assert_true(driver.runs);
    assert_int_equal(driver.timeout, 15);
    assert_int_equal(ttf_watchdog_arm(dog, 15 * TTF_NS_PER_S + 1),
                     0); /* armed anew: no second opening */
    assert_int_equal(driver.timeout, 16);
    driver.fed = 0;
    assert_int_equal(ttf_watchdog_feed(dog), 0);
    assert_int_equal(driver.fed, 1);
    ttf_watchdog_disarm(dog);
    assert_false(driver.runs);
    assert_int_equal(ttf_watchdog_arm(dog, 15 * TTF_NS_PER_S), 0);
    ttf_watchdog_destroy(dog);
    assert_false(driver.runs);
}

static void one_that_cannot_wait_so_long_is_refused_and_left_stopped(void **state)
{
    struct ttf_watchdog *dog = made(10, false);

    (void)state;
    assert_int_equal(ttf_watchdog_arm(dog, 15 * TTF_NS_PER_S), -EINVAL);
    assert_false(driver.runs);
    assert_int_equal(ttf_watchdog_feed(dog), -EPIPE);
    assert_int_equal(ttf_watchdog_arm(dog, 10 * TTF_NS_PER_S), 0);
    ttf_watchdog_destroy(dog);
    dog = made(0, false); /* its time cannot be set at all */
    assert_int_equal(ttf_watchdog_arm(dog, 15 * TTF_NS_PER_S), -EINVAL);
    assert_false(driver.runs);
    ttf_watchdog_destroy(dog);
}

static void one_that_another_holds_is_busy(void **state)
{
    struct ttf_watchdog *dog = made(60, true);

    (void)state;
    assert_int_equal(ttf_watchdog_arm(dog, 15 * TTF_NS_PER_S), -EBUSY);
    assert_int_equal(ttf_watchdog_feed(dog), -EPIPE);
    ttf_watchdog_destroy(dog);
}

static void a_machine_without_one_says_so(void **state)
{
    struct ttf_watchdog *dog;
    struct ttf_err err;

    (void)state;
    assert_int_equal(ttf_watchdog_device_create("/nowhere/watchdog", &dog, &err), -ENOENT);
    assert_non_null(strstr(err.what, "no watchdog"));
}

static void destroy(struct ttf_box *box)
{
    ttf_watchdog_destroy(box->watchdog);
}

static int make(struct ttf_box *ret)
{
    *ret = (struct ttf_box){.watchdog = made(120, false), .destroy = destroy};
    return 0;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(it_runs_from_its_arming_to_its_disarming_alone),
        cmocka_unit_test(one_that_cannot_wait_so_long_is_refused_and_left_stopped),
        cmocka_unit_test(one_that_another_holds_is_busy),
        cmocka_unit_test(a_machine_without_one_says_so),
    };
    const struct conformance_factory device = {"device", make};

    return cmocka_run_group_tests(tests, NULL, NULL) + conformance_watchdog(&device);
}
