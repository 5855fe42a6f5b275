/* SPDX-License-Identifier: Apache-2.0 */
/*
 * test_link.c: what both ends of every link do (ttf/usb/link.h). The kernel's FunctionFS with libusb at the other end needs a kernel:
 * tests/rig has it.
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
#include <pthread.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include "cable.h"
#include "ttf/usb/link.h"

#define PATIENCE_MS 5000

struct ends {
    struct ttf_usb_link *host, *box;
    struct cable *cable;
    volatile int stop;
    pthread_t thread;
    int commands;
    char folder[64], path[96];
};

static void *run_cable(void *ctx)
{
    struct ends *e = ctx;

    cable_run(e->cable, &e->stop);
    return NULL;
}

static int control(const char *path)
{
    struct sockaddr_un at = {.sun_family = AF_UNIX};
    int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);

    (void)snprintf(at.sun_path, sizeof at.sun_path, "%.90s.control", path);
    if (fd < 0 || connect(fd, (struct sockaddr *)&at, sizeof at) < 0)
        fail_msg("the cable takes no commands");
    return fd;
}

static void tell(struct ends *e, const char *command)
{
    char answer[16];

    if (write(e->commands, command, strlen(command)) < 0 ||
        read(e->commands, answer, sizeof answer) < 3 || memcmp(answer, "ok\n", 3) != 0)
        fail_msg("the cable does not obey: %s", command);
}

/* The next thing that happens to a link, waited for. */
static struct ttf_usb_event wait_for(struct ttf_usb_link *link, enum ttf_usb_event_kind kind)
{
    struct ttf_usb_event event = {.kind = TTF_USB_NOTHING};

    for (int waited = 0; waited < PATIENCE_MS; waited++) {
        struct pollfd fds[TTF_USB_FDS];

        link->ops->next(link, &event);
        if (event.kind == kind)
            return event;
        if (event.kind != TTF_USB_NOTHING)
            fail_msg("%s: event %d instead of %d", link->ops->name, (int)event.kind, (int)kind);
        (void)poll(fds, link->ops->fds(link, fds), 1);
    }
    fail_msg("%s: event %d does not come", link->ops->name, (int)kind);
    return event;
}

static int begin(void **state)
{
    struct ends *e = calloc(1, sizeof *e);
    struct ttf_err err = {0};

    if (!e)
        return -1;
    (void)snprintf(e->folder, sizeof e->folder, "/tmp/ttfbox-link-XXXXXX");
    if (!mkdtemp(e->folder))
        return -1;
    (void)snprintf(e->path, sizeof e->path, "%s/cable", e->folder);
    e->cable = cable_create(e->path, 7);
    if (!e->cable || pthread_create(&e->thread, NULL, run_cable, e) != 0)
        return -1;
    e->commands = control(e->path);
    if (ttf_usb_pipe_create(e->path, true, -1, &e->box, &err) < 0 ||
        ttf_usb_pipe_create(e->path, false, -1, &e->host, &err) < 0)
        return -1;
    *state = e;
    return 0;
}

static int end(void **state)
{
    struct ends *e = *state;

    ttf_usb_link_destroy(e->host);
    ttf_usb_link_destroy(e->box);
    __atomic_store_n(&e->stop, 1, __ATOMIC_RELAXED);
    (void)pthread_join(e->thread, NULL);
    (void)close(e->commands);
    cable_destroy(e->cable);
    (void)rmdir(e->folder);
    free(e);
    return 0;
}

static void open_both(struct ends *e)
{
    struct ttf_err err = {0};

    assert_int_equal(e->box->ops->open(e->box, &err), 0);
    (void)wait_for(e->box, TTF_USB_UP);
    assert_int_equal(e->host->ops->open(e->host, &err), 0);
}

static void fill(uint8_t *data, size_t n)
{
    for (size_t i = 0; i < n; i++)
        data[i] = (uint8_t)(i * 13 + (i >> 9) + n);
}

static void transfer(struct ttf_usb_link *from, struct ttf_usb_link *to, size_t n)
{
    static uint8_t expected[TTF_USB_TRANSFER];
    uint8_t *buffer = from->ops->buffer(from);
    struct ttf_usb_event event;

    if (!buffer)
        fail_msg("there is no room for a transfer");
    fill(expected, n);
    if (buffer)
        memcpy(buffer, expected, n);
    from->ops->send(from, n);
    event = wait_for(to, TTF_USB_CAME);
    if (event.n != n || memcmp(event.data, expected, n) != 0)
        fail_msg("a transfer of %zu bytes comes as %zu, or other ones", n, event.n);
}

static void transfers_come_as_they_were_sent(void **state)
{
    static const size_t SIZES[] = {1, 8, 63, 65, 511, 513, 1000, 16391, 65472 + 8, 65528};
    struct ends *e = *state;

    open_both(e);
    for (size_t i = 0; i < sizeof SIZES / sizeof *SIZES; i++) {
        transfer(e->host, e->box, SIZES[i]);
        transfer(e->box, e->host, SIZES[i]);
    }
}

static void several_are_under_way_and_keep_their_order(void **state)
{
    struct ends *e = *state;
    unsigned sent = 0, came = 0;
    uint8_t *buffer;

    open_both(e);
    while (sent < 10000 && (buffer = e->box->ops->buffer(e->box))) {
        memset(buffer, (int)(sent % 251), 1001);
        e->box->ops->send(e->box, 1001);
        sent++;
    }
    assert_true(sent >= TTF_USB_DEPTH);
    assert_true(sent < 10000); /* nobody reads: it ends */
    for (; came < sent; came++) {
        struct ttf_usb_event event, none;

        event = wait_for(e->host, TTF_USB_CAME);
        assert_int_equal(event.n, 1001);
        assert_int_equal(event.data[1000], came % 251);
        e->box->ops->next(e->box, &none); /* so that it goes on */
    }
    assert_true(e->box->ops->buffer(e->box) != NULL);
}

static void a_reset_reaches_the_box_before_what_is_sent_behind_it(void **state)
{
    struct ends *e = *state;
    struct ttf_usb_event event;

    open_both(e);
    assert_int_equal(e->host->ops->reset(e->host, UINT64_C(0x1122334455667788)), 0);
    assert_int_equal(e->host->ops->reset(e->host, 9), -EALREADY);
    event = wait_for(e->box, TTF_USB_RESET);
    assert_true(event.nonce == UINT64_C(0x1122334455667788));
    event = wait_for(e->host, TTF_USB_RESET);
    assert_int_equal(event.error, 0);
    transfer(e->host, e->box, 24);
}

static void a_reset_that_no_box_answers_fails(void **state)
{
    struct ends *e = *state;

    open_both(e);
    assert_int_equal(e->host->ops->reset(e->host, 5), 0);
    assert_true(wait_for(e->host, TTF_USB_RESET).error < 0);
}

static void unplugged_both_ends_are_told_and_both_are_the_same_again(void **state)
{
    struct ends *e = *state;
    struct ttf_err err = {0};

    open_both(e);
    transfer(e->host, e->box, 100);
    tell(e, "unplug\n");
    (void)wait_for(e->box, TTF_USB_DOWN);
    (void)wait_for(e->host, TTF_USB_DOWN);
    assert_true(e->host->ops->buffer(e->host) == NULL);
    assert_true(e->box->ops->buffer(e->box) == NULL);
    assert_int_equal(e->host->ops->open(e->host, &err), -ENODEV);
    tell(e, "replug\n");
    (void)wait_for(e->box, TTF_USB_UP);
    assert_int_equal(e->host->ops->open(e->host, &err), 0);
    transfer(e->host, e->box, 100);
    transfer(e->box, e->host, 100);
}

static void an_end_that_was_not_told_is_followed_by_a_beginning(void **state)
{
    struct ends *e = *state;
    struct ttf_err err = {0};

    open_both(e);
    tell(e, "lose-down\n");
    tell(e, "unplug\n");
    (void)wait_for(e->host, TTF_USB_DOWN);
    tell(e, "replug\n");
    (void)wait_for(e->box, TTF_USB_UP);
    assert_int_equal(e->host->ops->open(e->host, &err), 0);
    transfer(e->box, e->host, 5000);
}

static void what_a_dead_host_left_is_found_by_the_next(void **state)
{
    struct ends *e = *state;
    struct ttf_err err = {0};
    uint8_t *buffer;

    open_both(e);
    buffer = e->box->ops->buffer(e->box);
    if (!buffer) {
        fail();
        return;
    }
    fill(buffer, 65528);
    e->box->ops->send(e->box, 65528);
    (void)usleep(20000);
    e->host->ops->close(e->host); /* with the transfer in its endpoint, of which some may be lost */
    for (int i = 0; i < 200 && e->host->ops->open(e->host, &err) == -EBUSY; i++)
        (void)usleep(5000);
    transfer(e->host, e->box, 77);
    buffer = e->box->ops->buffer(e->box);
    if (!buffer) {
        fail();
        return;
    }
    memset(buffer, 1, 8);
    e->box->ops->send(e->box, 8);
    struct ttf_usb_event event = wait_for(e->host, TTF_USB_CAME);

    /* Its rest ends in a short packet of its own: what comes behind it comes by itself. */
    if (event.n != 8) {
        assert_int_equal(event.n % 512, 65528 % 512);
        event = wait_for(e->host, TTF_USB_CAME);
    }
    assert_int_equal(event.n, 8);
}

static void the_box_is_one_programs_at_a_time(void **state)
{
    struct ends *e = *state;
    struct ttf_usb_link *other = NULL;
    struct ttf_err err = {0};

    open_both(e);
    assert_int_equal(ttf_usb_pipe_create(e->path, false, -1, &other, &err), 0);
    if (!other)
        return;
    assert_int_equal(other->ops->open(other, &err), -EBUSY);
    ttf_usb_link_destroy(other);
}

static void a_bus_that_sleeps_is_told(void **state)
{
    struct ends *e = *state;

    open_both(e);
    tell(e, "suspend\n");
    (void)wait_for(e->box, TTF_USB_SUSPEND);
    tell(e, "resume\n");
    (void)wait_for(e->box, TTF_USB_RESUME);
    transfer(e->host, e->box, 10);
}

#define TEST(name) cmocka_unit_test_setup_teardown(name, begin, end)

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(transfers_come_as_they_were_sent),
        TEST(several_are_under_way_and_keep_their_order),
        TEST(a_reset_reaches_the_box_before_what_is_sent_behind_it),
        TEST(a_reset_that_no_box_answers_fails),
        TEST(unplugged_both_ends_are_told_and_both_are_the_same_again),
        TEST(an_end_that_was_not_told_is_followed_by_a_beginning),
        TEST(what_a_dead_host_left_is_found_by_the_next),
        TEST(the_box_is_one_programs_at_a_time),
        TEST(a_bus_that_sleeps_is_told),
    };

    return cmocka_run_group_tests_name("pipe", tests, NULL, NULL);
}
