/* SPDX-License-Identifier: Apache-2.0 */
/* test_probe.c: machines made of files, and what is said of them. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "files.h"
#include "probe.h"

struct bench {
    struct probe_machine machine;
    struct ttf_board board;
    struct probe_findings findings;
};

static int setup(void **state)
{
    struct bench *b = calloc(1, sizeof *b);
    char root[] = "/tmp/ttf-probe.XXXXXX";

    if (!b)
        return -1;
    assert_true(mkdtemp(root) != NULL);
    probe_machine_here(&b->machine, root);
    *state = b;
    return 0;
}

static int teardown(void **state)
{
    struct bench *b = *state;
    char command[300];

    (void)snprintf(command, sizeof command, "rm -rf '%s'", b->machine.root);
    /* NOLINTNEXTLINE(cert-env33-c,concurrency-mt-unsafe): a test's own folder */
    assert_int_equal(system(command), 0);
    free(b);
    return 0;
}

static void make_folders(char *path)
{
    for (char *c = strchr(path + 1, '/'); c; c = strchr(c + 1, '/')) {
        *c = '\0';
        (void)mkdir(path, 0755);
        *c = '/';
    }
}

static void put(const struct bench *b, const char *name, const char *text)
{
    char path[512];
    FILE *file;

    (void)probe_path(&b->machine, name, path);
    make_folders(path);
    file = fopen(path, "w");
    assert_true(file != NULL);
    fputs(text, file);
    (void)fclose(file);
}

/* A process that has a device open. */
static void put_holder(const struct bench *b, const char *process, const char *name,
                       const char *device)
{
    char file[128], path[512];

    (void)snprintf(file, sizeof file, "proc/%s/comm", process);
    put(b, file, name);
    (void)snprintf(file, sizeof file, "proc/%s/fd/", process);
    (void)probe_path(&b->machine, file, path);
    make_folders(path);
    (void)snprintf(path + strlen(path), 8, "7");
    assert_int_equal(symlink(device, path), 0);
}

static void load(struct bench *b, const char *text)
{
    struct ttf_err err = {0};

    if (ttf_board_parse("b.yaml", text, strlen(text), NULL, 0, &b->board, &err) < 0)
        fail_msg("%s: %s", err.where, err.what);
}

#define LIBCAMERA "board: t\ncameras: {main: {backend: libcamera}}\nclock: {backend: machine}\n"
#define CAMERA    "board: t\ncameras: {main: {backend: v4l2}}\nclock: {backend: machine}\n"

/* A finding that says this; its hint if it must say something, too. */
static const struct probe_finding *found(const struct bench *b, const char *text)
{
    for (unsigned i = 0; i < b->findings.n; i++)
        if (strstr(b->findings.finding[i].text, text)) {
            const struct probe_finding *f = &b->findings.finding[i];

            assert_true(strlen(f->text) < sizeof f->text - 1); /* none is cut short */
            assert_true(strlen(f->hint) < sizeof f->hint - 1);
            return f;
        }
    for (unsigned i = 0; i < b->findings.n; i++)
        print_message("    %s\n", b->findings.finding[i].text);
    fail_msg("nothing says '%s'", text);
    return &b->findings.finding[0];
}

static void cameras(struct bench *b)
{
    b->findings.n = 0;
    probe_cameras(&b->machine, &b->board, &b->findings);
}

static void a_machine_without_a_camera_says_where_to_look(void **state)
{
    struct bench *b = *state;

    load(b, CAMERA);
    cameras(b);
    assert_int_equal(b->findings.n, 1);
    assert_non_null(strstr(found(b, "there is no /dev/video*")->hint, "plugged in"));
    assert_int_equal(b->findings.finding[0].weight, PROBE_PROBLEM);
    put(b, "proc/device-tree/model", "Raspberry Pi 4 Model B Rev 1.4");
    cameras(b);
    assert_non_null(strstr(found(b, "there is no /dev/video*")->hint, "ribbon"));
    /* a simulated camera needs none */
    load(b, "board: t\ncameras: {main: {backend: sim}}\nclock: {backend: machine}\n");
    cameras(b);
    assert_int_equal(b->findings.n, 0);
}

static void a_usb_camera_without_its_driver_is_named(void **state)
{
    struct bench *b = *state;

    load(b, CAMERA);
    put(b, "sys/bus/usb/devices/1-1/product", "HD Pro Webcam C920\n");
    put(b, "sys/bus/usb/devices/1-1:1.0/bInterfaceClass", "0e\n");
    cameras(b);
    assert_non_null(strstr(found(b, "HD Pro Webcam C920")->hint, "modprobe uvcvideo"));
    /* with a driver it is something else that is wrong */
    put(b, "sys/bus/usb/devices/1-1:1.0/driver/bind", "");
    cameras(b);
    (void)found(b, "the kernel knows no camera");
}

static void a_camera_that_may_not_be_used_says_which_group_may(void **state)
{
    struct bench *b = *state;
    char path[512];

    load(b, CAMERA);
    put(b, "dev/video0", "");
    assert_int_equal(chmod(probe_path(&b->machine, "dev/video0", path), 0660), 0);
    b->machine.uid = 4711;
    b->machine.n_groups = 1;
    b->machine.groups[0] = 4711;
    cameras(b);
    assert_non_null(strstr(found(b, "no permission")->hint, "usermod -aG"));
    b->machine.n_groups = 2;
    b->machine.groups[1] = getegid();
    cameras(b);
    assert_int_equal(b->findings.n, 0);
}

static void a_camera_that_is_busy_says_who_has_it(void **state)
{
    struct bench *b = *state;

    load(b, CAMERA);
    put(b, "dev/video0", "");
    put(b, "dev/video1", "");
    put_holder(b, "812", "motion\n", "/dev/video0");
    put_holder(b, "813", "other\n", "/dev/null");
    cameras(b);
    assert_int_equal(b->findings.n, 1);
    (void)found(b, "/dev/video0 is held by motion (process 812)");
}

static void a_device_that_has_another_number_now_is_told(void **state)
{
    struct bench *b = *state;

    load(b, "board: t\ncameras: {main: {backend: v4l2, device: /dev/video2}}\n"
            "clock: {backend: machine}\n");
    put(b, "dev/video0", "");
    put(b, "dev/video4", "");
    cameras(b);
    assert_non_null(strstr(
        found(b, "/dev/video2 is not there; there is /dev/video0, /dev/video4")->hint, "by-id"));
}

static void a_camera_behind_libcamera_says_what_is_in_its_way(void **state)
{
    struct bench *b = *state;

    load(b, LIBCAMERA);
    put(b, "dev/video0", ""); /* alone it is none of libcamera's */
    cameras(b);
    assert_int_equal(b->findings.n, 1);
    assert_non_null(strstr(found(b, "there is no /dev/media*")->hint, "back-end v4l2"));
    put(b, "proc/device-tree/model", "Raspberry Pi 4 Model B Rev 1.4");
    cameras(b);
    assert_non_null(strstr(found(b, "there is no /dev/media*")->hint, "ribbon"));
    put(b, "dev/media0", "");
    cameras(b);
    assert_int_equal(b->findings.n, 1);
    (void)found(b, "told of cameras by udev, which does not run");
    put(b, "run/udev/data/c1", "");
    put_holder(b, "812", "rpicam-vid\n", "/dev/media0");
    cameras(b);
    assert_int_equal(b->findings.n, 1);
    (void)found(b, "/dev/media0 is held by rpicam-vid (process 812)");
}

/* A node and what its driver calls it. */
static void put_node(const struct bench *b, const char *node, const char *called)
{
    char path[96];

    (void)snprintf(path, sizeof path, "dev/%s", node);
    put(b, path, "");
    (void)snprintf(path, sizeof path,
                   strncmp(node, "media", 5) == 0 ? "sys/bus/media/devices/%s/model"
                                                  : "sys/class/video4linux/%s/name",
                   node);
    put(b, path, called);
}

/* What a Raspberry Pi 4 without any camera has (Raspberry Pi's kernel 6.1). */
static void put_codecs(const struct bench *b)
{
    put(b, "proc/device-tree/model", "Raspberry Pi 4 Model B Rev 1.4");
    put(b, "run/udev/data/c1", "");
    put_node(b, "video10", "bcm2835-codec-decode\n");
    put_node(b, "video11", "bcm2835-codec-encode\n");
    put_node(b, "video13", "bcm2835-isp-output0\n");
    put_node(b, "video14", "bcm2835-isp-capture0\n");
    put_node(b, "video19", "rpivid\n");
    put_node(b, "media0", "bcm2835-isp\n");
    put_node(b, "media1", "bcm2835-codec\n");
    put_node(b, "media2", "rpivid\n");
}

static void codecs_and_image_processors_of_a_pi_are_no_cameras(void **state)
{
    struct bench *b = *state;

    put_codecs(b);
    put_holder(b, "812", "ffmpeg\n", "/dev/video10"); /* who decodes is in nobody's way */
    load(b, CAMERA);
    cameras(b);
    assert_int_equal(b->findings.n, 1);
    assert_non_null(
        strstr(found(b, "only processes pictures: bcm2835-codec-decode")->hint, "ribbon"));
    put_node(b, "video0", "HD Pro Webcam C920\n");
    cameras(b);
    assert_int_equal(b->findings.n, 0);
    load(b, LIBCAMERA);
    cameras(b);
    assert_int_equal(b->findings.n, 1);
    assert_non_null(strstr(
        found(b, "each /dev/media* only processes pictures: bcm2835-isp, bcm2835-codec")->hint,
        "ribbon"));
}

static void a_camera_port_without_a_sensor_says_so(void **state)
{
    struct bench *b = *state;

    load(b, LIBCAMERA);
    put_codecs(b);
    put_node(b, "media3", "unicam\n"); /* its overlay is on; video nodes come with the sensor */
    cameras(b);
    assert_int_equal(b->findings.n, 1);
    assert_non_null(
        strstr(found(b, "camera port is on (unicam), but no sensor answers")->hint, "ribbon"));
    put_node(b, "video0", "unicam-image\n");
    cameras(b);
    assert_int_equal(b->findings.n, 0);
}

static void a_sensor_of_a_pi_5_is_known_by_its_subdevice(void **state)
{
    struct bench *b = *state;

    load(b, LIBCAMERA);
    put(b, "proc/device-tree/model", "Raspberry Pi 5 Model B Rev 1.0");
    put(b, "run/udev/data/c1", "");
    put_node(b, "video20", "pispbe-input\n");
    put_node(b, "media0", "pispbe\n");
    put_node(b, "media1", "rpi-hevc-dec\n");
    put_node(b, "v4l-subdev0", "csi2\n");
    put_node(b, "v4l-subdev1", "pisp-fe\n");
    cameras(b);
    (void)found(b, "only processes pictures: pispbe, rpi-hevc-dec");
    put_node(b, "media2", "rp1-cfe\n");
    cameras(b);
    (void)found(b, "camera port is on (rp1-cfe), but no sensor answers");
    put_node(b, "v4l-subdev2", "imx477 10-001a\n");
    cameras(b);
    assert_int_equal(b->findings.n, 0);
}

static void a_camera_that_libcamera_does_not_give_is_no_dead_end(void **state)
{
    struct bench *b = *state;

    load(b, LIBCAMERA);
    put_codecs(b);
    cameras(b);
    probe_silent_camera(&b->machine, &b->board, &b->findings);
    assert_int_equal(b->findings.n, 1); /* why is said already */
    put_node(b, "media3", "unicam\n");
    put_node(b, "v4l-subdev0", "imx219 10-0010\n");
    cameras(b);
    assert_int_equal(b->findings.n, 0);
    probe_silent_camera(&b->machine, &b->board, &b->findings);
    assert_non_null(strstr(
        found(b, "has a camera: imx219 10-0010, and yet libcamera does not give")->hint, "cam -l"));
    b->findings.n = 0;
    load(b, CAMERA);
    probe_silent_camera(&b->machine, &b->board, &b->findings);
    assert_int_equal(b->findings.n, 0);
}

#define WIRES                                                                             \
    CAMERA "lamps:\n  left: {backend: gpiod, line: GPIO17}\n"                             \
           "  low: {backend: gpiod, line: GPIO1}\n  i2c: {backend: gpiod, line: GPIO2}\n" \
           "  serial: {backend: gpiod, chip: gpiochip0, line: 14}\n"                      \
           "  usb: {backend: gpiod, chip: cp2112_gpio, line: 2}\n"                        \
           "panel: {backend: gpiod, button: {line: GPIO9}}\n"

static void lines_of_a_pi_that_are_something_else_are_told(void **state)
{
    struct bench *b = *state;

    load(b, WIRES);
    put(b, "dev/i2c-1", "");
    probe_lines(&b->machine, &b->board, &b->findings);
    assert_int_equal(b->findings.n, 0); /* only a Pi's header is so */
    put(b, "proc/device-tree/model", "Raspberry Pi 5 Model B Rev 1.0");
    put(b, "proc/device-tree/hat/product", "Sense HAT");
    probe_lines(&b->machine, &b->board, &b->findings);
    assert_int_equal(b->findings.n, 5);
    assert_int_equal(found(b, "ID EEPROM")->weight, PROBE_PROBLEM);
    assert_string_equal(found(b, "ID EEPROM")->about, "line low");
    assert_int_equal(found(b, "I2C bus")->weight, PROBE_PROBLEM);
    assert_int_equal(found(b, "SPI bus, which is switched off here")->weight, PROBE_NOTE);
    assert_int_equal(found(b, "serial console (UART), which is switched off")->weight, PROBE_NOTE);
    assert_int_equal(found(b, "a HAT is plugged on: Sense HAT")->weight, PROBE_NOTE);
}

static void a_lamp_on_a_pwm_channel_that_is_not_there_is_told(void **state)
{
    struct bench *b = *state;
    char link[512];

    load(b, CAMERA "lamps:\n"
                   "  left: {backend: gpiod, pwm: {chip: fe20c000.pwm, channel: 1, period: 50us}}\n"
                   "  right: {backend: gpiod, pwm: {chip: pwmchip3, channel: 2, period: 50us}}\n");
    probe_lines(&b->machine, &b->board, &b->findings);
    assert_int_equal(b->findings.n, 2);
    assert_non_null(strstr(found(b, "no PWM chip fe20c000.pwm")->hint, "dtoverlay"));
    b->findings.n = 0;
    put(b, "sys/class/pwm/pwmchip3/npwm", "2");
    assert_int_equal(symlink("../../fe20c000.pwm",
                             probe_path(&b->machine, "sys/class/pwm/pwmchip3/device", link)),
                     0);
    probe_lines(&b->machine, &b->board, &b->findings);
    assert_int_equal(b->findings.n, 1); /* the left lamp's is found by its device */
    assert_string_equal(found(b, "has 2 channels: there is no channel 2")->about, "lamp right");
}

static void a_line_that_is_taken_says_by_whom(void **state)
{
    struct bench *b = *state;

    load(b, WIRES);
    put(b, "sys/kernel/debug/gpio",
        "gpiochip0: GPIOs 512-565, parent: platform/fe200000.gpio, pinctrl-bcm2711:\n"
        " gpio-513 (GPIO1               |low                 ) out lo\n"
        " gpio-529 (GPIO17              |onewire@11          ) out hi\n"
        " gpio-521 (GPIO9               )\n");
    probe_lines(&b->machine, &b->board, &b->findings);
    assert_int_equal(b->findings.n,
                     1); /* the guardian's own, and free ones, are as they should be */
    assert_string_equal(found(b, "line GPIO17 is taken by 'onewire@11'")->about, "line left");
}

static void who_holds_the_usb_controller_is_told(void **state)
{
    struct bench *b = *state;

    probe_usb(&b->machine, &b->findings);
    (void)found(b, "no USB device controller");
    b->findings.n = 0;
    put(b, "sys/class/udc/fe980000.usb/state", "configured\n");
    probe_usb(&b->machine, &b->findings);
    assert_int_equal(b->findings.n, 0);
    put(b, "sys/class/udc/fe980000.usb/function", "g_ether\n");
    probe_usb(&b->machine, &b->findings);
    (void)found(b, "fe980000.usb is held by g_ether");
    b->findings.n = 0;
    put(b, "sys/kernel/config/usb_gadget/other/UDC", "\n");
    put(b, "sys/kernel/config/usb_gadget/webcam/UDC", "fe980000.usb\n");
    probe_usb(&b->machine, &b->findings);
    (void)found(b, "fe980000.usb is held by gadget 'webcam'");
}

static void a_board_for_another_machine_is_told(void **state)
{
    struct bench *b = *state;

    load(b, CAMERA "machine: {model: Raspberry Pi 4}\n");
    put(b, "proc/device-tree/model", "Raspberry Pi 4 Model B Rev 1.4");
    probe_is_meant(&b->machine, &b->board, &b->findings);
    assert_int_equal(b->findings.n, 0);
    put(b, "proc/device-tree/model", "Raspberry Pi 5 Model B Rev 1.0");
    probe_is_meant(&b->machine, &b->board, &b->findings);
    (void)found(b, "is for a Raspberry Pi 4; this is Raspberry Pi 5 Model B");
}

static void a_clock_that_forgets_is_told(void **state)
{
    struct bench *b = *state;

    probe_clock(&b->machine, TTF_TRUST_NONE, &b->findings);
    assert_int_equal(b->findings.n, 2);
    (void)found(b, "no battery-backed clock");
    (void)found(b, "nobody vouches");
    b->findings.n = 0;
    put(b, "sys/class/rtc/rtc0/name", "rtc-ds1307\n");
    probe_clock(&b->machine, TTF_TRUST_RTC, &b->findings);
    assert_int_equal(b->findings.n, 0);
}

static void storage(struct bench *b, const char *folder)
{
    b->findings.n = 0;
    probe_storage(&b->machine, folder, &b->findings);
}

static void each_kind_of_storage_has_its_words(void **state)
{
    struct bench *b = *state;

    put(b, "proc/self/mounts",
        "/dev/mmcblk0p2 / ext4 rw,noatime 0 0\n"
        "/dev/sda1 /data ext4 ro,errors=remount-ro 0 0\n"
        "/dev/sdb1 /data/usb vfat rw 0 0\n"
        "tmpfs /tmp tmpfs rw 0 0\n"
        "/dev/sdc1 /database ext4 rw 0 0\n");
    storage(b, "/var/lib/ttfbox");
    assert_int_equal(found(b, "memory card (/dev/mmcblk0p2)")->weight, PROBE_NOTE);
    storage(b, "/data/grass");
    assert_int_equal(found(b, "/data (ext4) can only be read")->weight, PROBE_PROBLEM);
    storage(b, "/data/usb");
    (void)found(b, "/data/usb is vfat");
    storage(b, "/tmp/x");
    (void)found(b, "lies in memory");
    storage(b, "/database/x");
    assert_int_equal(b->findings.n, 0);
}

static void a_disk_is_measured_and_nothing_is_left_behind(void **state)
{
    struct bench *b = *state;
    struct ttf_clock *clock = ttf_clock_real_create();
    char path[512];
    struct stat st;

    put(b, "data/x", "");
    assert_true(probe_write_speed(probe_path(&b->machine, "data", path), clock, &b->findings) > 0);
    assert_false(probe_stat(&b->machine, "data/.ttfbox-speed", &st));
    assert_int_equal(probe_write_speed("/nowhere", clock, &b->findings), -ENOENT);
    (void)found(b, "/nowhere cannot be written");
    ttf_clock_destroy(clock);
}

static void a_supply_that_sagged_and_a_watchdog_in_other_hands_are_told(void **state)
{
    struct bench *b = *state;

    load(b, CAMERA "watchdog: {backend: device}\n");
    put(b, "sys/class/hwmon/hwmon0/name", "cpu_thermal\n");
    put(b, "sys/class/hwmon/hwmon1/name", "rpi_volt\n");
    put(b, "sys/class/hwmon/hwmon1/in0_lcrit_alarm", "0\n");
    probe_power(&b->machine, &b->board, &b->findings);
    assert_int_equal(b->findings.n, 0);
    put(b, "sys/class/hwmon/hwmon1/in0_lcrit_alarm", "1\n");
    put_holder(b, "1", "systemd\n", "/dev/watchdog");
    probe_power(&b->machine, &b->board, &b->findings);
    assert_int_equal(found(b, "voltage has been too low")->weight, PROBE_PROBLEM);
    assert_non_null(
        strstr(found(b, "/dev/watchdog is held by systemd (process 1)")->hint, "backend: systemd"));
}

int main(void)
{
#define ON_FILES(test) cmocka_unit_test_setup_teardown(test, setup, teardown)
    const struct CMUnitTest tests[] = {
        ON_FILES(a_machine_without_a_camera_says_where_to_look),
        ON_FILES(a_usb_camera_without_its_driver_is_named),
        ON_FILES(a_camera_that_may_not_be_used_says_which_group_may),
        ON_FILES(a_camera_that_is_busy_says_who_has_it),
        ON_FILES(a_device_that_has_another_number_now_is_told),
        ON_FILES(a_camera_behind_libcamera_says_what_is_in_its_way),
        ON_FILES(codecs_and_image_processors_of_a_pi_are_no_cameras),
        ON_FILES(a_camera_port_without_a_sensor_says_so),
        ON_FILES(a_sensor_of_a_pi_5_is_known_by_its_subdevice),
        ON_FILES(a_camera_that_libcamera_does_not_give_is_no_dead_end),
        ON_FILES(lines_of_a_pi_that_are_something_else_are_told),
        ON_FILES(a_lamp_on_a_pwm_channel_that_is_not_there_is_told),
        ON_FILES(a_line_that_is_taken_says_by_whom),
        ON_FILES(who_holds_the_usb_controller_is_told),
        ON_FILES(a_board_for_another_machine_is_told),
        ON_FILES(a_clock_that_forgets_is_told),
        ON_FILES(each_kind_of_storage_has_its_words),
        ON_FILES(a_disk_is_measured_and_nothing_is_left_behind),
        ON_FILES(a_supply_that_sagged_and_a_watchdog_in_other_hands_are_told),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
