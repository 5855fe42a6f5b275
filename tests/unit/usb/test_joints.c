/* SPDX-License-Identifier: Apache-2.0 */
/* test_joints.c: a box's streams joined to a server's socket, where a host does what ours never does. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include <errno.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include "frames.h"
#include "joints.h"

struct box {
    struct ttf_mux *mux;
    struct usb_joints joints;
    int server;
    char folder[64], path[96];
    uint8_t out[TTF_MUX_TRANSFER_MAX];
};

struct made {
    uint8_t data[1024];
    size_t n;
};

static void frame(struct made *m, unsigned stream, enum usb_frame_type type, const void *payload,
                  size_t n)
{
    usb_frame_write(m->data + m->n, stream, type, n);
    if (n > 0)
        memcpy(m->data + m->n + USB_HEADER, payload, n);
    m->n += USB_HEADER + n;
}

static void close_frame(struct made *m, unsigned stream, enum ttf_mux_reason reason)
{
    uint8_t number[USB_NUMBER_SIZE];

    usb_put32(number, reason);
    frame(m, stream, USB_FRAME_CLOSE, number, sizeof number);
}

/* A transfer of the host's, taken as the bridge takes it. */
static void take(struct box *box, struct made *m)
{
    if (m->n % USB_SHORTEST == 0)
        frame(m, 0, USB_FRAME_PAD, NULL, 0);
    assert_int_equal(ttf_mux_take(box->mux, m->data, m->n), 0);
    usb_joints_follow(&box->joints, 0);
    m->n = 0;
}

static void give_all(struct box *box)
{
    while (ttf_mux_has_transfer(box->mux)) {
        (void)!ttf_mux_give(box->mux, box->out);
        usb_joints_follow(&box->joints, 0);
    }
}

/* What poll would find at the server's connections. */
static void look(struct box *box)
{
    for (unsigned id = 1; id <= TTF_MUX_STREAMS; id++)
        (void)!usb_joints_ready(&box->joints, id, POLLIN);
    usb_joints_follow(&box->joints, 0);
}

static void begin(struct box *box)
{
    struct sockaddr_un at = {.sun_family = AF_UNIX};
    uint8_t hello[USB_HELLO_SIZE] = {1, 0, 32, 0, 0, 0, 4, 0, 9};
    struct made m = {.n = 0};

    memset(box, 0, sizeof *box);
    (void)snprintf(box->folder, sizeof box->folder, "/tmp/ttf-joints-XXXXXX");
    if (!mkdtemp(box->folder))
        fail_msg("no folder");
    (void)snprintf(box->path, sizeof box->path, "%s/server", box->folder);
    (void)snprintf(at.sun_path, sizeof at.sun_path, "%s", box->path);
    box->server = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    if (box->server < 0 || bind(box->server, (struct sockaddr *)&at, sizeof at) < 0 ||
        listen(box->server, 8) < 0)
        fail_msg("no server");
    assert_int_equal(ttf_mux_create(TTF_MUX_BOX, &box->mux), 0);
    usb_joints_init(&box->joints, box->mux, box->path);
    ttf_mux_reset(box->mux, 9);
    give_all(box);
    frame(&m, 0, USB_FRAME_HELLO, hello, sizeof hello);
    take(box, &m);
    assert_true(ttf_mux_is_ready(box->mux));
}

static void end(struct box *box)
{
    usb_joints_close(&box->joints);
    ttf_mux_destroy(box->mux);
    (void)close(box->server);
    (void)unlink(box->path);
    (void)rmdir(box->folder);
}

/* The server's end of the next connection; -1: there is none. */
static int accepted(const struct box *box)
{
    return accept4(box->server, NULL, NULL, SOCK_CLOEXEC | SOCK_NONBLOCK);
}

static void says(int fd, const char *expected)
{
    char got[64] = "";
    ssize_t n = recv(fd, got, sizeof got - 1, 0);

    if (n < 0 || strcmp(got, expected) != 0)
        fail_msg("the server reads '%s' (%zd) instead of '%s'", got, n, expected);
}

/* Both have ended stream 1, the box by END; the host's CLOSE, and the OPEN of the next stream with its first bytes, come in one. */
static void opens_again_at_once(struct box *box, struct made *m)
{
    close_frame(m, 1, TTF_MUX_END);
    frame(m, 1, USB_FRAME_OPEN, NULL, 0);
    frame(m, 1, USB_FRAME_DATA, "second", 6);
    take(box, m);
}

static void a_stream_whose_server_has_left_is_served_again_when_it_is_opened_at_once(void **state)
{
    static struct box box;
    struct made m = {.n = 0};
    int first, second;

    (void)state;
    begin(&box);
    frame(&m, 1, USB_FRAME_OPEN, NULL, 0);
    take(&box, &m);
    first = accepted(&box);
    if (first < 0)
        fail_msg("the server is not called");
    (void)close(first); /* GONE: the joint is left, the stream ends */
    look(&box);
    give_all(&box);
    opens_again_at_once(&box, &m);
    second = accepted(&box);
    if (second < 0)
        fail_msg("the next stream is not served");
    says(second, "second");
    (void)close(second);
    end(&box);
}

static void a_stream_opened_at_once_is_not_given_to_the_server_of_the_one_before(void **state)
{
    static struct box box;
    struct made m = {.n = 0};
    int first, second;

    (void)state;
    begin(&box);
    frame(&m, 1, USB_FRAME_OPEN, NULL, 0);
    take(&box, &m);
    first = accepted(&box);
    if (first < 0)
        fail_msg("the server is not called");
    (void)shutdown(first, SHUT_WR); /* END: it still reads */
    look(&box);
    give_all(&box);
    opens_again_at_once(&box, &m);
    second = accepted(&box);
    if (second < 0)
        fail_msg("the next stream is not served by a connection of its own");
    says(second, "second");
    says(first, ""); /* the end of the first, and nothing of the second */
    (void)close(first);
    (void)close(second);
    end(&box);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_stream_whose_server_has_left_is_served_again_when_it_is_opened_at_once),
        cmocka_unit_test(a_stream_opened_at_once_is_not_given_to_the_server_of_the_one_before),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
