/* SPDX-License-Identifier: Apache-2.0 */
/* test_probe.c: USB device controller, clock, storage, supply, watchdog of machines made of files. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "probe_bench.h"

static void usb(struct bench *b)
{
    b->findings.n = 0;
    probe_usb(&b->machine, &b->board, &b->findings);
}

static void a_pcs_device_without_a_controller_is_a_problem(void **state)
{
    struct bench *b = *state;

    load(b, CAMERA "machine: {usb_role: device, usb_powers: true, power: poe}\n");
    put(b, "proc/device-tree/model", "Raspberry Pi 4 Model B Rev 1.4");
    usb(b);
    assert_int_equal(b->findings.n, 1);
    assert_int_equal(found(b, "no USB device controller")->weight, PROBE_PROBLEM);
    assert_non_null(strstr(b->findings.finding[0].hint, "dtoverlay=dwc2"));
    /* who wants none misses none */
    load(b, CAMERA "machine: {usb_role: host}\n");
    usb(b);
    assert_int_equal(b->findings.n, 0);
    load(b, CAMERA);
    usb(b);
    assert_int_equal(b->findings.n, 0);
}

#define DEVICE CAMERA "machine: {usb_role: device}\n"

static void a_controller_in_the_boxs_own_hands_is_as_it_should_be(void **state)
{
    struct bench *b = *state;

    load(b, DEVICE);
    put(b, "sys/class/udc/fe980000.usb/state", "not attached\n");
    usb(b);
    assert_int_equal(b->findings.n, 1);
    assert_non_null(strstr(found(b, "fe980000.usb has no gadget")->hint, "ttfbox-usbd"));
    put(b, "sys/kernel/config/usb_gadget/ttfbox/UDC", "fe980000.usb\n");
    usb(b);
    assert_int_equal(b->findings.n, 1);
    assert_string_equal(found(b, "is held by this box's own gadget")->hint, "");
    assert_int_equal(b->findings.finding[0].weight, PROBE_NOTE);
    (void)found(b, "no PC at its cable has set it up");
    put(b, "sys/class/udc/fe980000.usb/state", "configured\n");
    usb(b);
    (void)found(b, "a PC has set it up");
}

static void a_controller_in_other_hands_is_a_problem_of_a_pcs_device(void **state)
{
    struct bench *b = *state;

    load(b, DEVICE);
    put(b, "sys/class/udc/fe980000.usb/function", "g_ether\n");
    usb(b);
    assert_int_equal(found(b, "fe980000.usb is held by gadget 'g_ether'")->weight, PROBE_PROBLEM);
    put(b, "sys/kernel/config/usb_gadget/other/UDC", "\n");
    put(b, "sys/kernel/config/usb_gadget/webcam/UDC", "fe980000.usb\n");
    usb(b);
    assert_int_equal(b->findings.n, 1);
    (void)found(b, "fe980000.usb is held by gadget 'webcam'");
    load(b, CAMERA "machine: {usb_role: host}\n");
    usb(b);
    assert_int_equal(found(b, "that port is a device: gadget 'webcam'")->weight, PROBE_NOTE);
    load(b, CAMERA "machine: {usb_role: host, usb_single: true}\n");
    usb(b);
    assert_int_equal(found(b, "that port is a device: gadget 'webcam'")->weight, PROBE_PROBLEM);
}

static void a_port_that_is_the_power_input_too_is_told(void **state)
{
    struct bench *b = *state;

    load(b, CAMERA "machine: {usb_role: device, usb_powers: true, power: poe}\n");
    put(b, "sys/class/udc/fe980000.usb/state", "configured\n");
    put(b, "sys/kernel/config/usb_gadget/ttfbox/UDC", "fe980000.usb\n");
    usb(b);
    assert_int_equal(b->findings.n, 2);
    assert_non_null(strstr(found(b, "is the power input, too")->hint, "VBUS"));
    load(b, CAMERA "machine: {usb_role: host, usb_powers: true, power: poe}\n");
    put(b, "sys/kernel/config/usb_gadget/ttfbox/UDC", "\n");
    usb(b);
    assert_int_equal(b->findings.n, 0);
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
    put(b, "sys/class/rtc/rtc0/name", "rtc-ds1307 1-0068\n");
    put(b, "sys/class/rtc/rtc0/hctosys", "1\n");
    put(b, "sys/class/rtc/rtc0/since_epoch", "1790000000\n");
    probe_clock(&b->machine, TTF_TRUST_RTC, &b->findings);
    assert_int_equal(b->findings.n, 0);
}

static void clocks(struct bench *b)
{
    b->findings.n = 0;
    probe_clock(&b->machine, TTF_TRUST_NTP, &b->findings);
}

static void a_clock_that_is_there_and_not_asked_is_told(void **state)
{
    struct bench *b = *state;

    put(b, "sys/class/rtc/rtc0/name", "rpi_rtc soc:rpi_rtc\n");
    put(b, "sys/class/rtc/rtc0/hctosys", "1\n");
    put(b, "sys/class/rtc/rtc0/since_epoch", "86\n");
    clocks(b);
    assert_int_equal(b->findings.n, 1);
    assert_non_null(
        strstr(found(b, "rtc0 (rpi_rtc soc:rpi_rtc) has lost its date")->hint, "hwclock"));
    put(b, "sys/class/rtc/rtc1/name", "rtc-ds1307 1-0068\n");
    put(b, "sys/class/rtc/rtc1/hctosys", "0\n");
    put(b, "sys/class/rtc/rtc1/since_epoch", "1790000000\n");
    clocks(b);
    assert_int_equal(b->findings.n, 1);
    assert_non_null(strstr(found(b, "nobody asks rtc1 (rtc-ds1307")->hint, "dtparam=rtc=off"));
    put(b, "sys/class/rtc/rtc0/since_epoch", "1790000000\n");
    clocks(b);
    assert_int_equal(b->findings.n, 1);
    assert_non_null(
        strstr(found(b, "it is rtc0 (rpi_rtc soc:rpi_rtc) that sets")->hint, "dtparam=rtc=off"));
    put(b, "sys/class/rtc/rtc0/hctosys", "0\n");
    clocks(b);
    (void)found(b, "did not set this machine's time at boot");
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

static void a_file_system_with_errors_is_told(void **state)
{
    struct bench *b = *state;

    put(b, "sys/fs/ext4/features/metadata_csum_seed", "supported\n");
    put(b, "sys/fs/ext4/sda1/errors_count", "0\n");
    probe_fs_errors(&b->machine, &b->findings);
    assert_int_equal(b->findings.n, 0);
    put(b, "sys/fs/ext4/mmcblk0p2/errors_count", "7\n");
    probe_fs_errors(&b->machine, &b->findings);
    assert_int_equal(b->findings.n, 1);
    assert_int_equal(found(b, "on mmcblk0p2 has found errors in itself: 7 since")->weight,
                     PROBE_PROBLEM);
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
    const struct CMUnitTest tests[] = {
        ON_FILES(a_pcs_device_without_a_controller_is_a_problem),
        ON_FILES(a_controller_in_the_boxs_own_hands_is_as_it_should_be),
        ON_FILES(a_controller_in_other_hands_is_a_problem_of_a_pcs_device),
        ON_FILES(a_port_that_is_the_power_input_too_is_told),
        ON_FILES(a_board_for_another_machine_is_told),
        ON_FILES(a_clock_that_forgets_is_told),
        ON_FILES(a_clock_that_is_there_and_not_asked_is_told),
        ON_FILES(each_kind_of_storage_has_its_words),
        ON_FILES(a_file_system_with_errors_is_told),
        ON_FILES(a_disk_is_measured_and_nothing_is_left_behind),
        ON_FILES(a_supply_that_sagged_and_a_watchdog_in_other_hands_are_told),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
