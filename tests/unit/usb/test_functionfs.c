/* SPDX-License-Identifier: Apache-2.0 */
/*
 * test_functionfs.c: a box's end of the cable when I/O ends badly. Pipes stand for endpoints that are not enabled (the kernel takes what is
 * queued, and ends it with EAGAIN), a file for one from which bytes come; tests/rig has the kernel's own.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include <errno.h>
#include <fcntl.h>
#include <linux/usb/functionfs.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include "ttf/usb/functionfs.h"
#include "ttf/usb/identity.h"

struct box {
    struct ttf_usb_link *link;
    char folder[40];
    int kernel; /* the other end of ep0 */
};

static void path_of(const struct box *b, const char *name, char path[64])
{
    (void)snprintf(path, 64, "%s/%s", b->folder, name);
}

/* From which nothing comes. */
static void disabled(const struct box *b, const char *name)
{
    char path[64];

    path_of(b, name, path);
    (void)unlink(path);
    assert_int_equal(mkfifo(path, 0600), 0);
}

/* From which bytes come whenever it is read. */
static void enabled(const struct box *b, const char *name)
{
    static const uint8_t bytes[100];
    char path[64];
    int fd;

    path_of(b, name, path);
    (void)unlink(path);
    fd = open(path, O_WRONLY | O_CREAT | O_CLOEXEC, 0600);
    assert_true(fd >= 0);
    assert_int_equal(write(fd, bytes, sizeof bytes), sizeof bytes);
    (void)close(fd);
}

static int begin(void **state)
{
    struct box *b = calloc(1, sizeof *b);
    struct ttf_err err = {0};
    int ends[2];

    if (!b)
        return -1;
    (void)snprintf(b->folder, sizeof b->folder, "/tmp/ttfbox-ffs-XXXXXX");
    if (!mkdtemp(b->folder) || socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends) < 0)
        return -1;
    b->kernel = ends[1];
    disabled(b, "ep1");
    disabled(b, "ep2");
    *state = b;
    return ttf_usb_functionfs_create(b->folder, ends[0], &b->link, &err);
}

static int end(void **state)
{
    struct box *b = *state;
    char path[64];

    ttf_usb_link_destroy(b->link);
    (void)close(b->kernel);
    for (unsigned i = 1; i <= 2; i++) {
        path_of(b, i == 1 ? "ep1" : "ep2", path);
        (void)unlink(path);
    }
    (void)rmdir(b->folder);
    free(b);
    return 0;
}

static struct ttf_usb_event next(struct box *b)
{
    struct ttf_usb_event event;

    b->link->ops->next(b->link, &event);
    return event;
}

static void happens(struct box *b, uint8_t type)
{
    struct usb_functionfs_event event = {.type = type};

    assert_int_equal(write(b->kernel, &event, sizeof event), sizeof event);
}

static void host_resets(struct box *b)
{
    struct usb_functionfs_event event = {.type = FUNCTIONFS_SETUP};
    const uint8_t nonce[TTF_USB_RESET_SIZE] = {7};

    event.u.setup.bRequestType = TTF_USB_RESET_TYPE;
    event.u.setup.bRequest = TTF_USB_RESET_REQUEST;
    event.u.setup.wLength = TTF_USB_RESET_SIZE; /* of this test's machine: little-endian */
    assert_int_equal(write(b->kernel, &event, sizeof event), sizeof event);
    assert_int_equal(write(b->kernel, nonce, sizeof nonce), sizeof nonce);
}

/* What would wake a program that waits. */
static bool would_wake(struct box *b)
{
    struct pollfd fds[TTF_USB_FDS];
    unsigned n = b->link->ops->fds(b->link, fds);

    return poll(fds, n, 20) > 0;
}

static void before_a_pc_has_configured_it_a_box_sleeps(void **state)
{
    struct box *b = *state;

    for (unsigned i = 0; i < 5; i++)
        assert_int_equal(next(b).kind, TTF_USB_NOTHING);
    assert_false(would_wake(b));
    assert_true(b->link->ops->buffer(b->link) == NULL);
    happens(b, FUNCTIONFS_ENABLE);
    enabled(b, "ep2");
    assert_int_equal(next(b).kind, TTF_USB_UP);
    assert_int_equal(next(b).kind, TTF_USB_CAME);
    assert_true(b->link->ops->buffer(b->link) != NULL);
}

static void a_box_whose_endpoint_was_disabled_unseen_is_down_and_sleeps(void **state)
{
    struct box *b = *state;
    struct ttf_usb_event event = {.kind = TTF_USB_NOTHING};

    enabled(b, "ep2");
    assert_int_equal(next(b).kind, TTF_USB_UP);
    disabled(b, "ep2");
    happens(b, FUNCTIONFS_ENABLE);
    event = next(b);
    assert_int_equal(event.kind, TTF_USB_DOWN);
    assert_int_equal(event.error, -EAGAIN);
    assert_int_equal(next(b).kind, TTF_USB_NOTHING);
    assert_false(would_wake(b));
}

static void a_hosts_reset_starts_a_box_that_stands(void **state)
{
    struct box *b = *state;

    assert_int_equal(next(b).kind, TTF_USB_NOTHING);
    enabled(b, "ep2");
    host_resets(b);
    struct ttf_usb_event event = next(b);

    assert_int_equal(event.kind, TTF_USB_RESET);
    assert_int_equal(event.nonce, 7);
    assert_true(b->link->ops->buffer(b->link) != NULL);
    assert_int_equal(next(b).kind, TTF_USB_CAME);
}

static struct ttf_usb_event after_writes(struct box *b, unsigned n)
{
    struct ttf_usb_event event = {.kind = TTF_USB_NOTHING};

    for (unsigned i = 0; i < n && b->link->ops->buffer(b->link); i++)
        b->link->ops->send(b->link, 50000);
    for (unsigned i = 0; i < 4; i++) {
        event = next(b);
        if (event.kind != TTF_USB_CAME)
            break;
    }
    return event;
}

/* The pipe has room for the first, and for a part of the second. */
static void a_write_that_loses_bytes_begins_everything_anew(void **state)
{
    struct box *b = *state;

    enabled(b, "ep2");
    assert_int_equal(next(b).kind, TTF_USB_UP);
    assert_int_equal(after_writes(b, 1).kind, TTF_USB_CAME); /* all went: nothing is amiss */
    assert_int_equal(after_writes(b, 1).kind, TTF_USB_UP);
}

static void a_folder_whose_name_is_too_long_is_refused_as_such(void **state)
{
    char folder[300];
    struct ttf_usb_link *link = NULL;
    int ep0 = open("/dev/null", O_RDWR | O_CLOEXEC);

    (void)state;
    assert_true(ep0 >= 0);
    memset(folder, 'f', sizeof folder - 1);
    folder[sizeof folder - 1] = '\0';
    assert_int_equal(ttf_usb_functionfs_create(folder, ep0, &link, NULL), -ENAMETOOLONG);
    assert_null(link);
    assert_int_equal(fcntl(ep0, F_GETFD), -1); /* it was taken over, and closed */
}

#define TEST(name) cmocka_unit_test_setup_teardown(name, begin, end)

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(before_a_pc_has_configured_it_a_box_sleeps),
        TEST(a_box_whose_endpoint_was_disabled_unseen_is_down_and_sleeps),
        TEST(a_hosts_reset_starts_a_box_that_stands),
        TEST(a_write_that_loses_bytes_begins_everything_anew),
        cmocka_unit_test(a_folder_whose_name_is_too_long_is_refused_as_such),
    };

    return cmocka_run_group_tests_name("functionfs", tests, NULL, NULL);
}
