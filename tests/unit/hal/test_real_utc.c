/* SPDX-License-Identifier: Apache-2.0 */
/* Which movements of the machine's wall clock count as steps. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/stat.h>

#include "ttf/base/time.h"
#include "utc.h"

#define S  TTF_NS_PER_S
#define MS TTF_NS_PER_MS

static uint32_t steps_after(int64_t passed_ns, int64_t utc_passed_ns, int64_t reading_ns)
{
    struct real_utc u = {0};

    real_utc_note(&u, 100 * S, 1000000 * S, 0);
    real_utc_note(&u, 100 * S + passed_ns, 1000000 * S + utc_passed_ns, reading_ns);
    return u.steps;
}

static void jumps_either_way_are_steps(void **state)
{
    (void)state;
    assert_int_equal(steps_after(S, S + 100 * MS, 0), 1);
    assert_int_equal(steps_after(S, S - 100 * MS, 0), 1);
    assert_int_equal(steps_after(S, -3600 * S, 0), 1);
}

static void slewing_and_slow_reading_are_not(void **state)
{
    (void)state;
    assert_int_equal(steps_after(S, S, 0), 0);
    assert_int_equal(steps_after(3600 * S, 3600 * S + 1700 * MS, 0), 0); /* adjtime at 500 ppm */
    assert_int_equal(steps_after(S, S + 20 * MS, 0), 1);
    assert_int_equal(steps_after(S, S + 20 * MS, 30 * MS), 0); /* preempted between two readings */
}

static void the_first_look_is_no_step(void **state)
{
    struct real_utc u = {0};

    (void)state;
    real_utc_note(&u, 5 * S, 1000000 * S, 0);
    assert_int_equal(u.steps, 0);
}

static void put(const char *sys, const char *rtc, const char *name, const char *text)
{
    char path[300];
    FILE *file;

    snprintf(path, sizeof(path), "%s/class", sys);
    (void)mkdir(path, 0755);
    snprintf(path, sizeof(path), "%s/class/rtc", sys);
    (void)mkdir(path, 0755);
    snprintf(path, sizeof(path), "%s/class/rtc/%s", sys, rtc);
    (void)mkdir(path, 0755);
    snprintf(path, sizeof(path), "%s/class/rtc/%s/%s", sys, rtc, name);
    file = fopen(path, "w");
    assert_non_null(file);
    fputs(text, file);
    fclose(file);
}

static bool trusted(const char *sys)
{
    struct real_utc u;

    real_utc_init(&u, sys);
    return u.rtc;
}

static void a_battery_backed_clock_is_one_that_set_the_time_and_has_a_date(void **state)
{
    char sys[] = "/tmp/ttf-rtc.XXXXXX", command[64];

    (void)state;
    assert_non_null(mkdtemp(sys));
    assert_false(trusted(sys));
    /* A Raspberry Pi 5's own without its battery: it is the first, and its date is that of no date. */
    put(sys, "rtc0", "hctosys", "1\n");
    put(sys, "rtc0", "since_epoch", "86\n");
    put(sys, "rtc1", "hctosys", "0\n");
    put(sys, "rtc1", "since_epoch", "1790000000\n");
    assert_false(trusted(sys));
    put(sys, "rtc1", "hctosys", "1\n"); /* a kernel that asks the second */
    assert_true(trusted(sys));
    put(sys, "rtc1", "hctosys", "0\n");
    put(sys, "rtc0", "since_epoch", "1790000000\n");
    assert_true(trusted(sys));
    snprintf(command, sizeof(command), "rm -rf '%s'", sys);
    /* NOLINTNEXTLINE(cert-env33-c,concurrency-mt-unsafe): a test's own folder */
    assert_int_equal(system(command), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(jumps_either_way_are_steps),
        cmocka_unit_test(slewing_and_slow_reading_are_not),
        cmocka_unit_test(the_first_look_is_no_step),
        cmocka_unit_test(a_battery_backed_clock_is_one_that_set_the_time_and_has_a_date),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
