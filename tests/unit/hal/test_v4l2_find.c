/* SPDX-License-Identifier: Apache-2.0 */
/* test_v4l2_find.c: which of several video devices a camera is, when it was pulled and put in again somewhere. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <errno.h>
#include <linux/videodev2.h>
#include <stdio.h>
#include <string.h>

#include "find.h"

#define DEVICES 4

struct device {
    const char *path, *name, *bus, *serial; /* path NULL: none */
};

struct machine {
    struct device device[DEVICES];
    unsigned open; /* descriptors that are */
};

static int list(void *ctx, unsigned i, char ret_path[64])
{
    const struct machine *m = ctx;

    for (unsigned k = 0; k < DEVICES; k++)
        if (m->device[k].path && i-- == 0) {
            (void)snprintf(ret_path, 64, "%s", m->device[k].path);
            return 1;
        }
    return 0;
}

static int open_path(void *ctx, const char *path)
{
    struct machine *m = ctx;

    for (int k = 0; k < DEVICES; k++)
        if (m->device[k].path && strcmp(m->device[k].path, path) == 0) {
            m->open++;
            return k;
        }
    return -ENOENT;
}

static void close_fd(void *ctx, int fd)
{
    (void)fd;
    ((struct machine *)ctx)->open--;
}

static int request(void *ctx, int fd, unsigned long what, void *arg)
{
    const struct device *d = &((struct machine *)ctx)->device[fd];
    struct v4l2_capability *cap = arg;

    if (what != VIDIOC_QUERYCAP)
        return -ENOTTY;
    (void)snprintf((char *)cap->card, sizeof cap->card, "%s", d->name);
    (void)snprintf((char *)cap->bus_info, sizeof cap->bus_info, "%s", d->bus);
    cap->capabilities = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING;
    return 0;
}

static void serial(void *ctx, int fd, char ret[64])
{
    (void)snprintf(ret, 64, "%s", ((struct machine *)ctx)->device[fd].serial);
}

static const struct v4l2_sys SYS = {
    .list = list, .open = open_path, .close = close_fd, .ioctl = request, .serial = serial};

/* The path of what is found; "" if nothing is. */
static const char *found(struct machine *m, const struct ttf_v4l2_config *config,
                         const struct v4l2_identity *known, struct v4l2_identity *ret)
{
    static struct v4l2_identity id;
    int fd = v4l2_find(&SYS, m, config, known, &id, NULL);

    assert_int_equal(m->open, fd >= 0); /* nothing else is left open */
    if (fd < 0)
        return "";
    close_fd(m, fd);
    if (ret)
        *ret = id;
    return id.device;
}

static const struct ttf_v4l2_config ANY = {.name = "C920"};

static void a_serial_number_finds_a_camera_in_any_socket_beside_its_twin(void **state)
{
    struct machine m = {
        {{"/dev/video0", "C920", "usb-1", "A"}, {"/dev/video1", "C920", "usb-2", "B"}}, 0};
    struct v4l2_identity known;

    (void)state;
    assert_string_equal(found(&m, &ANY, NULL, &known), "/dev/video0");
    m.device[0] = (struct device){0};
    assert_string_equal(found(&m, &ANY, &known, NULL), "");
    m.device[2] = (struct device){"/dev/video2", "C920", "usb-7", "A"};
    assert_string_equal(found(&m, &ANY, &known, NULL), "/dev/video2");
    /* Swapped: each is where the other was. */
    m.device[2] = (struct device){0};
    m.device[1] = (struct device){"/dev/video1", "C920", "usb-1", "B"};
    m.device[3] = (struct device){"/dev/video3", "C920", "usb-2", "A"};
    assert_string_equal(found(&m, &ANY, &known, NULL), "/dev/video3");
}

static void without_serial_numbers_only_one_that_was_and_is_alone_is_found(void **state)
{
    struct machine m = {{{"/dev/video0", "C920", "usb-1", ""}}, 0};
    struct v4l2_identity known;

    (void)state;
    assert_string_equal(found(&m, &ANY, NULL, &known), "/dev/video0");
    m.device[0].bus = "usb-5";
    assert_string_equal(found(&m, &ANY, &known, NULL), "/dev/video0");
    m.device[1] = (struct device){"/dev/video1", "C920", "usb-6", ""};
    assert_string_equal(found(&m, &ANY, &known, NULL), ""); /* which of the two? */
    m.device[1].name = "other";
    assert_string_equal(found(&m, &ANY, &known, NULL), "/dev/video0");
    m.device[0].serial = "C"; /* it had none */
    assert_string_equal(found(&m, &ANY, &known, NULL), "");
}

static void one_of_two_without_serial_numbers_is_not_taken_for_the_other(void **state)
{
    struct machine m = {
        {{"/dev/video0", "C920", "usb-1", ""}, {"/dev/video1", "C920", "usb-2", ""}}, 0};
    struct v4l2_identity known, again;

    (void)state;
    assert_string_equal(found(&m, &ANY, NULL, &known), "/dev/video0");
    m.device[0].path = "/dev/video8"; /* a new number, the old socket */
    assert_string_equal(found(&m, &ANY, &known, &again), "/dev/video8");
    m.device[0] = (struct device){0};
    assert_string_equal(found(&m, &ANY, &again, NULL), ""); /* what it knew it still knows */
}

static void a_board_that_names_a_bus_means_that_socket(void **state)
{
    const struct ttf_v4l2_config there = {.bus = "usb-1"};
    struct machine m = {{{"/dev/video0", "C920", "usb-1", "A"}}, 0};
    struct v4l2_identity known;

    (void)state;
    assert_string_equal(found(&m, &there, NULL, &known), "/dev/video0");
    m.device[0].bus = "usb-2";
    assert_string_equal(found(&m, &there, &known, NULL), "");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_serial_number_finds_a_camera_in_any_socket_beside_its_twin),
        cmocka_unit_test(without_serial_numbers_only_one_that_was_and_is_alone_is_found),
        cmocka_unit_test(one_of_two_without_serial_numbers_is_not_taken_for_the_other),
        cmocka_unit_test(a_board_that_names_a_bus_means_that_socket),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
