/* SPDX-License-Identifier: Apache-2.0 */
/* test_probe_cameras.c: no camera, and why. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "probe_bench.h"

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

/* libcamera is in a process that this one started, and has the camera while it is probed. */
static void what_this_program_started_itself_is_nobody_elses(void **state)
{
    struct bench *b = *state;
    char stat[96];

    load(b, LIBCAMERA);
    put(b, "dev/media0", "");
    put(b, "run/udev/data/c1", "");
    put_holder(b, "812", "ttfbox-libcamer\n", "/dev/media0");
    (void)snprintf(stat, sizeof stat, "812 (ttfbox) (x) S %d 812 1 0\n", (int)getpid());
    put(b, "proc/812/stat", stat);
    cameras(b);
    for (unsigned i = 0; i < b->findings.n; i++)
        assert_null(strstr(b->findings.finding[i].text, "is held by"));
    put(b, "proc/812/stat", "812 (ttfbox-libcamer) S 1 812 1 0\n");
    cameras(b);
    (void)found(b, "/dev/media0 is held by ttfbox-libcamer (process 812)");
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

int main(void)
{
    const struct CMUnitTest tests[] = {
        ON_FILES(a_machine_without_a_camera_says_where_to_look),
        ON_FILES(a_usb_camera_without_its_driver_is_named),
        ON_FILES(a_camera_that_may_not_be_used_says_which_group_may),
        ON_FILES(a_camera_that_is_busy_says_who_has_it),
        ON_FILES(a_device_that_has_another_number_now_is_told),
        ON_FILES(a_camera_behind_libcamera_says_what_is_in_its_way),
        ON_FILES(what_this_program_started_itself_is_nobody_elses),
        ON_FILES(codecs_and_image_processors_of_a_pi_are_no_cameras),
        ON_FILES(a_camera_port_without_a_sensor_says_so),
        ON_FILES(a_sensor_of_a_pi_5_is_known_by_its_subdevice),
        ON_FILES(a_camera_that_libcamera_does_not_give_is_no_dead_end),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
