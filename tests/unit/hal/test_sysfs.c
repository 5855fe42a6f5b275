/* SPDX-License-Identifier: Apache-2.0 */
/* test_sysfs.c: sensors as drivers show them, in a folder laid out like /sys. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/inotify.h>
#include <sys/stat.h>
#include <unistd.h>

#include "alloc/alloc_hook.h"
#include "conformance/conformance.h"
#include "ttf/hal/sysfs.h"

struct sys {
    char root[64];
    struct ttf_clock *clock;
};

/* text becomes ROOT/path; NULL: the file goes. */
static void put(const struct sys *sys, const char *path, const char *text)
{
    char whole[256];
    int file;

    snprintf(whole, sizeof(whole), "%s/%s", sys->root, path);
    if (!text) {
        (void)unlink(whole);
        return;
    }
    for (char *p = whole + 1; (p = strchr(p, '/')) != NULL; p++) {
        *p = '\0';
        (void)mkdir(whole, 0777);
        *p = '/';
    }
    file = open(whole, O_WRONLY | O_CREAT | O_TRUNC, 0666);
    assert_true(file >= 0);
    assert_int_equal(write(file, text, strlen(text)), strlen(text));
    (void)close(file);
}

static void a_weather_sensor(const struct sys *sys, const char *device)
{
    char path[128];

#define PUT(name, text)                                                      \
    do {                                                                     \
        snprintf(path, sizeof(path), "bus/iio/devices/%s/%s", device, name); \
        put(sys, path, text);                                                \
    } while (0)
    PUT("name", "bme280\n");
    PUT("in_temp_input", "23450\n");
    PUT("in_humidityrelative_input", "41328.125\n");
    PUT("in_pressure_input", "101.325\n");
    PUT("in_illuminance_raw", "240\n");
    PUT("in_illuminance_scale", "0.5\n");
#undef PUT
}

static int setup(void **state)
{
    struct sys *sys = calloc(1, sizeof(*sys));

    assert_non_null(sys);
    snprintf(sys->root, sizeof(sys->root), "/tmp/ttf-sysfs.XXXXXX");
    assert_non_null(mkdtemp(sys->root));
    sys->clock = ttf_clock_real_create();
    assert_non_null(sys->clock);
    put(sys, "class/hwmon/hwmon0/name", "cpu_thermal\n");
    put(sys, "class/hwmon/hwmon0/temp1_input", "51200\n");
    put(sys, "class/hwmon/hwmon3/name", "rpi_volt\n");
    put(sys, "class/hwmon/hwmon3/in0_lcrit_alarm", "0\n");
    a_weather_sensor(sys, "iio:device0");
    *state = sys;
    return 0;
}

static int teardown(void **state)
{
    struct sys *sys = *state;
    char command[96];

    ttf_clock_destroy(sys->clock);
    snprintf(command, sizeof(command), "rm -r '%s'", sys->root);
    assert_int_equal(system(command), 0); /* NOLINT: of a folder that we made */
    free(sys);
    return 0;
}

static const struct ttf_sysfs_sensor BOX[] = {
    {.name = "board-temp", .bus = TTF_SYSFS_HWMON, .device = "cpu_thermal"},
    {.name = "box-temp", .bus = TTF_SYSFS_IIO, .device = "bme280"},
    {.name = "box-humidity",
     .kind = TTF_SENSOR_HUMIDITY_MPCT,
     .bus = TTF_SYSFS_IIO,
     .device = "bme280"},
    {.name = "box-pressure",
     .kind = TTF_SENSOR_PRESSURE_PA,
     .bus = TTF_SYSFS_IIO,
     .device = "bme280"},
    {.name = "light",
     .kind = TTF_SENSOR_LIGHT_PERMILLE,
     .bus = TTF_SYSFS_IIO,
     .device = "bme280",
     .full = 200},
    {.name = "supply",
     .kind = TTF_SENSOR_UNDERVOLTAGE,
     .bus = TTF_SYSFS_HWMON,
     .device = "rpi_volt"},
};
#define BOX_N 6

static struct ttf_sensors *sensors_of(const struct sys *sys)
{
    struct ttf_sensors *sensors = NULL;
    struct ttf_err err = {0};

    if (ttf_sensors_sysfs_create(sys->root, BOX, BOX_N, sys->clock, &sensors, &err) < 0)
        fail_msg("%s: %s", err.where, err.what);
    return sensors;
}

static void look(struct ttf_sensors *sensors, unsigned i, bool ok, int64_t value)
{
    struct ttf_reading r[TTF_SENSORS_MAX];

    assert_int_equal(ttf_sensors_read(sensors, r, NULL), BOX_N);
    assert_string_equal(r[i].name, BOX[i].name);
    assert_int_equal(r[i].ok, ok);
    assert_int_equal(r[i].value, value);
}

static void values_come_in_the_box_s_units(void **state)
{
    struct ttf_sensors *sensors = sensors_of(*state);

    look(sensors, 0, true, 51200);
    look(sensors, 1, true, 23450);
    look(sensors, 2, true, 41328);
    look(sensors, 3, true, 101325);
    look(sensors, 4, true, 600); /* 240 raw are 120 lux of 200 */
    ttf_sensors_destroy(sensors);
}

static void a_supply_s_alarm_is_read_where_a_driver_has_one(void **state)
{
    const struct sys *sys = *state;
    struct ttf_sensors *sensors = sensors_of(sys);

    look(sensors, 5, true, 0);
    put(sys, "class/hwmon/hwmon3/in0_lcrit_alarm", "1\n");
    look(sensors, 5, true, 1);
    put(sys, "class/hwmon/hwmon3/in0_lcrit_alarm", NULL);
    look(sensors, 5, false, 0);
    put(sys, "class/hwmon/hwmon3/in0_lcrit_alarm", "2\n");
    look(sensors, 5, false, 0);
    ttf_sensors_destroy(sensors);
}

/* A driver that takes its time: it gives its value when it was asked, and not before. */
struct slow {
    const struct sys *sys;
    char path[128];
    int64_t given_ns;
};

static void *give(void *arg)
{
    struct slow *slow = arg;
    int file = open(slow->path, O_WRONLY | O_CLOEXEC);

    slow->given_ns = ttf_clock_now_ns(slow->sys->clock);
    (void)!write(file, "23450\n", 6);
    (void)close(file);
    return NULL;
}

static void what_a_slow_driver_gives_is_as_old_as_the_asking(void **state)
{
    struct slow slow = {.sys = *state};
    struct ttf_sensors *sensors = sensors_of(slow.sys);
    struct ttf_reading r[TTF_SENSORS_MAX];
    pthread_t driver;

    put(slow.sys, "bus/iio/devices/iio:device0/in_temp_input", NULL);
    (void)snprintf(slow.path, sizeof(slow.path), "%s/bus/iio/devices/iio:device0/in_temp_input",
                   slow.sys->root);
    assert_int_equal(mkfifo(slow.path, 0666), 0);
    assert_int_equal(pthread_create(&driver, NULL, give, &slow), 0);
    assert_int_equal(ttf_sensors_read(sensors, r, NULL), BOX_N);
    (void)pthread_join(driver, NULL);
    assert_true(r[1].ok && r[1].value == 23450);
    assert_true(r[1].at_ns <= slow.given_ns);
    ttf_sensors_destroy(sensors);
}

static void raw_values_have_an_offset_too(void **state)
{
    struct sys *sys = *state;
    struct ttf_sensors *sensors = sensors_of(sys);

    put(sys, "bus/iio/devices/iio:device0/in_temp_input", NULL);
    put(sys, "bus/iio/devices/iio:device0/in_temp_raw", "25000\n");
    put(sys, "bus/iio/devices/iio:device0/in_temp_offset", "-4368\n");
    put(sys, "bus/iio/devices/iio:device0/in_temp_scale", "1.5\n");
    look(sensors, 1, true, 30948);
    ttf_sensors_destroy(sensors);
}

/* An mlx90614's attributes, as the kernel names them: what channels share has the type's name alone. */
static void an_infrared_thermometer(const struct sys *sys)
{
    put(sys, "bus/iio/devices/iio:device4/name", "mlx90614\n");
    put(sys, "bus/iio/devices/iio:device4/in_temp_ambient_raw", "14824\n");
    put(sys, "bus/iio/devices/iio:device4/in_temp_object_raw", "16657\n");
    put(sys, "bus/iio/devices/iio:device4/in_temp_offset", "-13657.5\n");
    put(sys, "bus/iio/devices/iio:device4/in_temp_scale", "20\n");
}

static void read_alone(const struct sys *sys, const struct ttf_sysfs_sensor *spec, bool ok,
                       int64_t value, const char *said)
{
    struct ttf_reading r[TTF_SENSORS_MAX];
    struct ttf_sensors *sensors = NULL;
    struct ttf_err why = {0};

    assert_int_equal(ttf_sensors_sysfs_create(sys->root, spec, 1, sys->clock, &sensors, NULL), 0);
    assert_int_equal(ttf_sensors_read(sensors, r, &why), 1);
    assert_int_equal(why.code != 0, !ok);
    if (!ok && (strcmp(why.where, spec->name) != 0 || !strstr(why.what, said)))
        fail_msg("%s: %s", why.where, why.what);
    assert_int_equal(r[0].ok, ok);
    assert_int_equal(r[0].value, value);
    ttf_sensors_destroy(sensors);
}

static void scale_and_offset_may_be_those_of_all_channels_of_the_type(void **state)
{
    static const struct ttf_sysfs_sensor leaf = {
        .name = "leaf", .bus = TTF_SYSFS_IIO, .device = "mlx90614", .channel = "in_temp_object"};
    const struct sys *sys = *state;

    an_infrared_thermometer(sys);
    read_alone(sys, &leaf, true, 59990, "");
    /* Its own counts before the shared one. */
    put(sys, "bus/iio/devices/iio:device4/in_temp_object_scale", "10\n");
    read_alone(sys, &leaf, true, 29995, "");
}

static void an_index_is_left_out_of_a_shared_name_too(void **state)
{
    static const struct ttf_sysfs_sensor second = {
        .name = "second", .bus = TTF_SYSFS_IIO, .device = "two", .channel = "in_temp1"};
    const struct sys *sys = *state;

    put(sys, "bus/iio/devices/iio:device5/name", "two\n");
    put(sys, "bus/iio/devices/iio:device5/in_temp1_raw", "250\n");
    put(sys, "bus/iio/devices/iio:device5/in_temp_scale", "100\n");
    read_alone(sys, &second, true, 25000, "");
}

/* 16657 counts are no 16.7 degrees. */
static void counts_without_a_scale_are_no_reading(void **state)
{
    static const struct ttf_sysfs_sensor leaf = {
        .name = "leaf", .bus = TTF_SYSFS_IIO, .device = "mlx90614", .channel = "in_temp_object"};
    const struct sys *sys = *state;

    an_infrared_thermometer(sys);
    put(sys, "bus/iio/devices/iio:device4/in_temp_scale", NULL);
    read_alone(sys, &leaf, false, 0, "neither in_temp_object_input nor a scale");
    put(sys, "bus/iio/devices/iio:device4/in_temp_scale", "n/a\n");
    read_alone(sys, &leaf, false, 0, "in_temp_object of mlx90614");
}

static void counts_of_light_need_no_scale_as_the_board_says_what_is_full(void **state)
{
    static const struct ttf_sysfs_sensor light = {.name = "light",
                                                  .kind = TTF_SENSOR_LIGHT_PERMILLE,
                                                  .bus = TTF_SYSFS_IIO,
                                                  .device = "diode",
                                                  .channel = "in_intensity_both",
                                                  .full = 2000};
    const struct sys *sys = *state;

    put(sys, "bus/iio/devices/iio:device6/name", "diode\n");
    put(sys, "bus/iio/devices/iio:device6/in_intensity_both_raw", "500\n");
    read_alone(sys, &light, true, 250, "");
}

static void what_does_not_answer_or_cannot_be_is_not_ok(void **state)
{
    struct sys *sys = *state;
    struct ttf_sensors *sensors = sensors_of(sys);

    put(sys, "class/hwmon/hwmon0/temp1_input", NULL);
    look(sensors, 0, false, 0);
    put(sys, "class/hwmon/hwmon0/temp1_input", "");
    look(sensors, 0, false, 0);
    put(sys, "class/hwmon/hwmon0/temp1_input", "n/a\n");
    look(sensors, 0, false, 0);
    put(sys, "class/hwmon/hwmon0/temp1_input", "-127000\n"); /* a wire that is off */
    look(sensors, 0, false, 0);
    put(sys, "bus/iio/devices/iio:device0/in_humidityrelative_input", "100001\n");
    look(sensors, 2, false, 0);
    put(sys, "class/hwmon/hwmon0/temp1_input", "-5000\n");
    look(sensors, 0, true, -5000);
    ttf_sensors_destroy(sensors);
}

static void a_driver_that_comes_later_or_moves_is_found(void **state)
{
    struct sys *sys = *state;
    struct ttf_sensors *sensors;
    char was[128], away[128];

    snprintf(was, sizeof(was), "%s/bus/iio/devices/iio:device0", sys->root);
    snprintf(away, sizeof(away), "%s/bus/iio/devices/iio:device12", sys->root);
    assert_int_equal(rename(was, away), 0);
    sensors = sensors_of(sys);
    look(sensors, 1, true, 23450);
    put(sys, "bus/iio/devices/iio:device3/name", "other\n");
    put(sys, "bus/iio/devices/iio:device3/in_temp_input", "1\n");
    assert_int_equal(rename(away, was), 0);
    look(sensors, 1, true, 23450);
    assert_int_equal(rename(was, away), 0);
    put(sys, "bus/iio/devices/iio:device12/name", "gone\n");
    look(sensors, 1, false, 0);
    ttf_sensors_destroy(sensors);
}

/* How often a file of this name was opened in the folder that is watched. */
static unsigned opened(int watch, const char *name)
{
    _Alignas(struct inotify_event) char buf[4096];
    unsigned n = 0;
    ssize_t got;

    while ((got = read(watch, buf, sizeof(buf))) > 0)
        for (ssize_t at = 0; at < got;) {
            const struct inotify_event *e = (const void *)(buf + at);

            n += e->len > 0 && strcmp(e->name, name) == 0;
            at += (ssize_t)(sizeof(*e) + e->len);
        }
    return n;
}

/* A bus that is stuck costs its driver's whole patience each time it is asked. */
static void a_sensor_whose_bus_fails_is_asked_once(void **state)
{
    struct sys *sys = *state;
    struct ttf_sensors *sensors = sensors_of(sys);
    int watch = inotify_init1(IN_NONBLOCK | IN_CLOEXEC);
    char folder[256];

    look(sensors, 1, true, 23450);
    snprintf(folder, sizeof(folder), "%s/bus/iio/devices/iio:device0", sys->root);
    assert_true(watch >= 0 && inotify_add_watch(watch, folder, IN_OPEN) >= 0);
    put(sys, "bus/iio/devices/iio:device0/in_temp_input", NULL);
    /* Reading a folder fails, and not for want of it. */
    put(sys, "bus/iio/devices/iio:device0/in_temp_input/nothing", "");
    (void)opened(watch, "in_temp_input");
    look(sensors, 1, false, 0);
    assert_int_equal(opened(watch, "in_temp_input"), 1);
    put(sys, "bus/iio/devices/iio:device0/in_temp_input/nothing", NULL);
    snprintf(folder, sizeof(folder), "%s/bus/iio/devices/iio:device0/in_temp_input", sys->root);
    assert_int_equal(rmdir(folder), 0);
    put(sys, "bus/iio/devices/iio:device0/in_temp_input", "24000\n");
    look(sensors, 1, true, 24000);
    (void)close(watch);
    ttf_sensors_destroy(sensors);
}

/* Drivers were loaded anew, and its old number is another's, which gives no reading either. */
static void a_sensor_whose_number_is_another_s_now_is_found_again(void **state)
{
    struct sys *sys = *state;
    struct ttf_sensors *sensors = sensors_of(sys);

    look(sensors, 1, true, 23450);
    put(sys, "bus/iio/devices/iio:device0/name", "adc\n");
    put(sys, "bus/iio/devices/iio:device0/in_temp_input", NULL);
    put(sys, "bus/iio/devices/iio:device0/in_temp_raw", "25000\n"); /* of no scale */
    a_weather_sensor(sys, "iio:device7");
    look(sensors, 1, true, 23450);
    ttf_sensors_destroy(sensors);
}

static void of_two_of_one_name_the_first_is_taken(void **state)
{
    struct sys *sys = *state;
    struct ttf_sensors *sensors;

    a_weather_sensor(sys, "iio:device2");
    put(sys, "bus/iio/devices/iio:device2/in_temp_input", "30000\n");
    a_weather_sensor(sys, "iio:device10");
    put(sys, "bus/iio/devices/iio:device10/in_temp_input", "40000\n");
    sensors = sensors_of(sys);
    look(sensors, 1, true, 23450);
    ttf_sensors_destroy(sensors);
}

static void reading_what_is_there_allocates_nothing(void **state)
{
    struct ttf_sensors *sensors = sensors_of(*state);
    struct alloc_counts before, after;

    look(sensors, 0, true, 51200);
    before = alloc_hook_counts(ALLOC_ALL);
    for (unsigned i = 0; i < 20; i++)
        look(sensors, 4, true, 600);
    after = alloc_hook_counts(ALLOC_ALL);
    assert_int_equal(after.calls - before.calls, 0);
    ttf_sensors_destroy(sensors);
}

static void descriptions_that_mean_nothing_are_refused(void **state)
{
    struct sys *sys = *state;
    const struct ttf_sysfs_sensor wrong[] = {
        {.name = "", .device = "x"},
        {.name = "Box Temp", .device = "x"},
        {.name = "a", .device = ""},
        {.name = "light", .kind = TTF_SENSOR_LIGHT_PERMILLE, .bus = TTF_SYSFS_IIO, .device = "x"},
        {.name = "p", .kind = TTF_SENSOR_PRESSURE_PA, .bus = TTF_SYSFS_HWMON, .device = "x"},
    };
    const struct ttf_sysfs_sensor twice[2] = {BOX[0], BOX[0]};
    struct ttf_sensors *sensors;
    struct ttf_err err;

    for (unsigned i = 0; i < sizeof(wrong) / sizeof(*wrong); i++) {
        memset(&err, 0, sizeof(err));
        assert_int_equal(
            ttf_sensors_sysfs_create(sys->root, &wrong[i], 1, sys->clock, &sensors, &err), -EINVAL);
        assert_true(err.what[0] != '\0');
    }
    assert_int_equal(ttf_sensors_sysfs_create(sys->root, twice, 2, sys->clock, &sensors, &err),
                     -EINVAL);
    assert_int_equal(ttf_sensors_sysfs_create(sys->root, BOX, 0, sys->clock, &sensors, &err),
                     -EINVAL);
}

/* ---- the suite ---- */

static void destroy(struct ttf_box *box)
{
    void *sys = box->box_private;

    ttf_sensors_destroy(box->sensors);
    (void)teardown(&sys);
}

static int make(struct ttf_box *ret)
{
    void *state = NULL;
    struct sys *sys;

    (void)setup(&state);
    sys = state;
    *ret = (struct ttf_box){.clock = sys->clock, .box_private = sys, .destroy = destroy};
    return ttf_sensors_sysfs_create(sys->root, BOX, BOX_N, sys->clock, &ret->sensors, NULL);
}

int main(void)
{
#define IN_SYS(test) cmocka_unit_test_setup_teardown(test, setup, teardown)
    const struct CMUnitTest tests[] = {
        IN_SYS(values_come_in_the_box_s_units),
        IN_SYS(a_supply_s_alarm_is_read_where_a_driver_has_one),
        IN_SYS(what_a_slow_driver_gives_is_as_old_as_the_asking),
        IN_SYS(raw_values_have_an_offset_too),
        IN_SYS(scale_and_offset_may_be_those_of_all_channels_of_the_type),
        IN_SYS(an_index_is_left_out_of_a_shared_name_too),
        IN_SYS(counts_without_a_scale_are_no_reading),
        IN_SYS(counts_of_light_need_no_scale_as_the_board_says_what_is_full),
        IN_SYS(what_does_not_answer_or_cannot_be_is_not_ok),
        IN_SYS(a_driver_that_comes_later_or_moves_is_found),
        IN_SYS(a_sensor_whose_bus_fails_is_asked_once),
        IN_SYS(a_sensor_whose_number_is_another_s_now_is_found_again),
        IN_SYS(of_two_of_one_name_the_first_is_taken),
        IN_SYS(reading_what_is_there_allocates_nothing),
        IN_SYS(descriptions_that_mean_nothing_are_refused),
    };
    const struct conformance_factory sysfs = {"sysfs", make};

    return cmocka_run_group_tests(tests, NULL, NULL) + conformance_sensors(&sysfs);
}
