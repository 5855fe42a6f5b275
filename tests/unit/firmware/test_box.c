/* SPDX-License-Identifier: Apache-2.0 */
/* test_box.c: boxes made of simulated and real devices, with a guardian and kernel files of the test's own. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include "box.h"
#include "lampd_fixture.h"

struct bench {
    struct lampd_fixture *guardian;
    char sys[160];
    struct ttf_io *io;
    struct ttf_board board;
};

static void put(const char *folder, const char *name, const char *text)
{
    char path[256];
    FILE *file;

    (void)snprintf(path, sizeof path, "%s/%s", folder, name);
    file = fopen(path, "w");
    assert_true(file != NULL);
    fputs(text, file);
    (void)fclose(file);
}

static void make_folder(char *path, const char *below)
{
    size_t n = strlen(path);

    (void)snprintf(path + n, 200 - n, "%s", below);
    assert_int_equal(mkdir(path, 0700), 0);
}

/* A thermometer, and a serial number as firmware tells it. */
static void make_sys(struct bench *b)
{
    char path[200];

    (void)snprintf(path, sizeof path, "%s", b->guardian->folder);
    make_folder(path, "/sys");
    memcpy(b->sys, path, sizeof b->sys);
    make_folder(path, "/class");
    make_folder(path, "/hwmon");
    make_folder(path, "/hwmon0");
    put(path, "name", "bme280\n");
    put(path, "temp1_input", "21500\n");
    (void)snprintf(path, sizeof path, "%s", b->sys);
    make_folder(path, "/firmware");
    make_folder(path, "/devicetree");
    make_folder(path, "/base");
    put(path, "serial-number", "10000000deadbeef");
}

static int setup(void **state)
{
    struct bench *b = calloc(1, sizeof *b);

    if (!b)
        return -1;
    b->guardian = lampd_fixture_make();
    lampd_fixture_start(b->guardian);
    make_sys(b);
    b->io = ttf_io_posix();
    *state = b;
    return 0;
}

static int teardown(void **state)
{
    struct bench *b = *state;
    char command[256];

    (void)snprintf(command, sizeof command, "rm -rf '%s' '%s/panel'", b->sys, b->guardian->folder);
    /* NOLINTNEXTLINE(cert-env33-c,concurrency-mt-unsafe): a test's own folder */
    assert_int_equal(system(command), 0);
    lampd_fixture_free(b->guardian);
    free(b);
    return 0;
}

/* A board whose texts may name the bench's folder as @. */
static void load(struct bench *b, const char *text)
{
    char whole[2048];
    struct ttf_err err = {0};
    size_t n = 0;

    for (; *text; text++) {
        if (*text == '@')
            n += (size_t)snprintf(whole + n, sizeof whole - n, "%s", b->guardian->folder);
        else
            whole[n++] = *text;
    }
    if (ttf_board_parse("b.yaml", whole, n, NULL, 0, &b->board, &err) < 0)
        fail_msg("%s: %s", err.where, err.what);
}

#define CAMERA "board: t\ncameras: {main: {backend: sim}}\nclock: {backend: machine}\n"
#define LAMPS                                                                    \
    "lamps: {left: {backend: file, line: 0}, right: {backend: file, line: 1}}\n" \
    "guardian: {socket: @/socket, file: @/wires, door: {line: 2}}\n"
#define SENSORS "sensors: {t: {backend: sysfs, kind: temperature, device: bme280}}\n"
#define PANEL   "panel: {backend: file, file: @/panel, button: {line: 0}, led: {line: 1}}\n"

static void real_devices_stand_beside_a_simulated_camera_and_all_says_simulated(void **state)
{
    struct bench *b = *state;
    const struct box_host host = {.sys = b->sys};
    struct ttf_reading readings[TTF_SENSORS_MAX];
    struct ttf_lamp_state lamp;
    struct ttf_box box;
    struct ttf_err err = {0};

    load(b, CAMERA LAMPS SENSORS PANEL);
    if (box_create(&b->board, b->io, &host, &box, &err) < 0)
        fail_msg("%s: %s", err.where, err.what);
    assert_true(box.simulated);
    assert_false(ttf_clock_is_virtual(box.clock));
    assert_int_equal(box.n_cameras, 1);
    assert_int_equal(box_configure(&b->board, &box, NULL), 0);
    assert_true(ttf_camera_caps(box.cameras[0].camera)->simulated);
    /* the lamps are the guardian's, and so is the door */
    assert_int_equal(ttf_lamps_count(box.lamps), 2);
    assert_int_equal(ttf_lamps_acquire(box.lamps, ttf_clock_now_ns(box.clock) + TTF_NS_PER_H, NULL),
                     0);
    assert_int_equal(ttf_lamps_set(box.lamps, 0, 1000, NULL), 0);
    assert_int_equal(wire(b->guardian, 0), '1');
    assert_int_equal(ttf_lamps_state(box.lamps, 0, &lamp), 0);
    assert_int_equal(lamp.actual_permille, 1000);
    assert_int_equal(ttf_panel_door(box.panel), 0);
    /* the thermometer is the kernel's */
    assert_int_equal(ttf_sensors_read(box.sensors, readings, NULL), 1);
    assert_true(readings[0].ok);
    assert_int_equal(readings[0].value, 21500);
    assert_null(box.watchdog);
    ttf_box_destroy(&box);
    wait_for_wire(b->guardian, 0, '0', 10 * TTF_NS_PER_S);
}

static void what_does_not_answer_is_named_and_the_rest_is_made(void **state)
{
    struct bench *b = *state;
    const struct box_host host = {.sys = b->sys};
    struct ttf_err errs[TTF_DEVICE_KIND_COUNT], err = {0};
    struct ttf_box box;

    load(b, "board: t\ncameras: {main: {backend: v4l2, device: /dev/no-camera}}\n"
            "clock: {backend: machine}\n" LAMPS SENSORS);
    lampd_fixture_stop(b->guardian);
    assert_int_equal(box_create_what_answers(&b->board, b->io, &host, &box, errs), 0);
    assert_false(box.simulated);
    assert_string_equal(box.serial, "10000000deadbeef");
    assert_int_equal(box.n_cameras, 0);
    assert_true(errs[TTF_DEVICE_CAMERA].code < 0 && errs[TTF_DEVICE_CAMERA].what[0]);
    assert_null(box.lamps);
    assert_non_null(strstr(errs[TTF_DEVICE_LAMPS].what, "guardian does not answer"));
    assert_non_null(strstr(errs[TTF_DEVICE_LAMPS].hint, "ttfbox-lampd"));
    assert_int_equal(errs[TTF_DEVICE_SENSORS].code, 0);
    assert_non_null(box.sensors);
    ttf_box_destroy(&box);
    /* as a whole it is refused, and may be there later */
    assert_true(box_may_answer_later(box_create(&b->board, b->io, &host, &box, &err)));
    assert_string_equal(err.what, errs[TTF_DEVICE_CAMERA].what);
}

static void a_guardian_of_other_lamps_is_refused(void **state)
{
    struct bench *b = *state;
    struct ttf_box box;
    struct ttf_err err = {0};

    load(b, CAMERA "lamps: {raking: {backend: file, line: 0}}\n"
                   "guardian: {socket: @/socket, file: @/wires}\n");
    assert_int_equal(box_create(&b->board, b->io, NULL, &box, &err), -ENODEV);
    assert_non_null(strstr(err.what, "no lamp 'raking'"));
    assert_non_null(strstr(err.hint, "another board"));
}

static void a_managed_watchdog_needs_a_manager_and_is_none_without(void **state)
{
    struct bench *b = *state;
    struct box_host host = {.sys = b->sys};
    struct sockaddr_un at = {.sun_family = AF_UNIX};
    int fd = socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    struct ttf_box box;

    load(b, CAMERA "watchdog: {backend: systemd}\n");
    assert_int_equal(box_create(&b->board, b->io, &host, &box, NULL), 0);
    assert_null(box.watchdog);
    ttf_box_destroy(&box);
    (void)snprintf(at.sun_path, sizeof at.sun_path, "%s/notify", b->guardian->folder);
    assert_int_equal(bind(fd, (struct sockaddr *)&at, sizeof at), 0);
    host.notify = at.sun_path;
    host.watchdog_ns = 20 * TTF_NS_PER_S;
    assert_int_equal(box_create(&b->board, b->io, &host, &box, NULL), 0);
    assert_non_null(box.watchdog);
    assert_int_equal(ttf_watchdog_arm(box.watchdog, 15 * TTF_NS_PER_S), 0);
    ttf_box_destroy(&box);
    (void)close(fd);
    (void)unlink(at.sun_path);
}

static void a_machine_without_a_watchdog_says_so(void **state)
{
    struct bench *b = *state;
    struct ttf_box box;
    struct ttf_err err = {0};

    load(b, CAMERA "watchdog: {backend: device, device: @/none}\n");
    assert_int_equal(box_create(&b->board, b->io, NULL, &box, &err), -ENOENT);
    assert_non_null(strstr(err.what, "no watchdog"));
}

static void the_simulated_box_is_as_it_was(void **state)
{
    struct bench *b = *state;
    struct ttf_box box;

    load(b, "board: t\ncameras: {main: {backend: sim}}\nclock: {backend: sim}\n"
            "lamps: {left: {backend: sim}}\nwatchdog: {backend: sim}\n"
            "sim: {faults: [{kind: disk-full, at: 0s}]}\n");
    assert_int_equal(box_create(&b->board, b->io, NULL, &box, NULL), 0);
    assert_true(box.simulated && ttf_clock_is_virtual(box.clock));
    assert_string_equal(box.serial, "SIM-0001");
    assert_true(box.lamps && box.watchdog && !box.panel);
    assert_true(ttf_sim_storage_fault(&box, TTF_FAULT_DISK_FULL));
    ttf_box_destroy(&box);
    load(b, "board: t\ncameras: {side: {backend: sim}}\nclock: {backend: sim}\n");
    assert_int_equal(box_create(&b->board, b->io, NULL, &box, NULL), -ENOTSUP);
}

int main(void)
{
#define ON_BENCH(test) cmocka_unit_test_setup_teardown(test, setup, teardown)
    const struct CMUnitTest tests[] = {
        ON_BENCH(real_devices_stand_beside_a_simulated_camera_and_all_says_simulated),
        ON_BENCH(what_does_not_answer_is_named_and_the_rest_is_made),
        ON_BENCH(a_guardian_of_other_lamps_is_refused),
        ON_BENCH(a_managed_watchdog_needs_a_manager_and_is_none_without),
        ON_BENCH(a_machine_without_a_watchdog_says_so),
        ON_BENCH(the_simulated_box_is_as_it_was),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
