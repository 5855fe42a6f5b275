/* SPDX-License-Identifier: Apache-2.0 */
/* test_places.c: an interface's address is followed as it comes, changes and goes; who came by another one notices nothing. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <errno.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/time.h>
#include <unistd.h>

#include "ttf/http/places.h"

#define PATIENCE 10 /* seconds that a test waits for what must come */

struct fixture {
    struct ttf_http_places sockets;
    struct ttf_http_server *server;
    struct ttf_clock *clock;
    const char *address; /* that usb0 has; NULL: error */
    int error;
    unsigned told[3]; /* times, of each news */
    char folder[64], sys[80];
};

static void tell(void *ctx, enum ttf_http_place_news news, const struct ttf_http_place *place,
                 const struct ttf_err *err)
{
    struct fixture *f = ctx;

    assert_int_equal(place->fd >= 0, news == TTF_HTTP_PLACE_LISTENING);
    assert_int_equal(err != NULL, news == TTF_HTTP_PLACE_UNREACHABLE);
    f->told[news]++;
}

static int address_of(void *ctx, const char *interface, char ret[TTF_HTTP_ADDRESS_SIZE])
{
    struct fixture *f = ctx;

    assert_string_equal(interface, "usb0");
    if (!f->address)
        return f->error;
    (void)snprintf(ret, TTF_HTTP_ADDRESS_SIZE, "%s", f->address);
    return 0;
}

static void begin(struct fixture *f)
{
    struct ttf_http_config config = {.io = ttf_io_posix()};

    *f = (struct fixture){.error = -ENODEV};
    (void)snprintf(f->folder, sizeof f->folder, "/tmp/ttfbox-sockets.XXXXXX");
    if (!mkdtemp(f->folder)) {
        fail_msg("no folder");
        return;
    }
    config.folder = f->folder;
    config.clock = f->clock = ttf_clock_real_create();
    assert_non_null(f->clock);
    assert_int_equal(ttf_http_server_create(&config, &f->server, NULL), 0);
    (void)snprintf(f->sys, sizeof f->sys, "%s/sys", f->folder);
    f->sockets = (struct ttf_http_places){
        .address_of = address_of, .ctx = f, .sys = f->sys, .tell = tell, .tell_ctx = f};
    assert_int_equal(ttf_http_places_add(&f->sockets, "127.0.0.1:0"), 0);
    assert_int_equal(ttf_http_places_add(&f->sockets, "usb0:0"), 0);
}

static void end(struct fixture *f)
{
    ttf_http_server_destroy(f->server);
    ttf_clock_destroy(f->clock);
    assert_int_equal(rmdir(f->folder), 0);
}

/* What usb0 has from now on is found at the next look. */
static void usb0_has(struct fixture *f, const char *address, int error)
{
    f->address = address;
    f->error = error;
    (void)ttf_http_places_look(&f->sockets, f->server, NULL);
}

static struct sockaddr_in place_of(const struct fixture *f, unsigned i)
{
    struct sockaddr_in at = {0};
    socklen_t size = sizeof at;

    assert_true(f->sockets.places[i].fd >= 0);
    assert_int_equal(getsockname(f->sockets.places[i].fd, (struct sockaddr *)&at, &size), 0);
    return at;
}

/* -1: nobody listens there. */
static int dial(const struct sockaddr_in *at)
{
    const struct timeval patience = {.tv_sec = PATIENCE};
    int fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);

    (void)setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    if (connect(fd, (const struct sockaddr *)at, sizeof *at) == 0)
        return fd;
    assert_int_equal(errno, ECONNREFUSED);
    (void)close(fd);
    return -1;
}

static bool answers(int fd)
{
    static const char REQUEST[] = "GET /api/v1/health HTTP/1.1\r\nHost: localhost\r\n\r\n";
    char text[2048];

    return send(fd, REQUEST, sizeof REQUEST - 1, MSG_NOSIGNAL) > 0 &&
           recv(fd, text, sizeof text, 0) > 12 && memcmp(text + 9, "200", 3) == 0;
}

static bool is_answered_at(const struct sockaddr_in *at)
{
    int fd = dial(at);
    bool answered = fd >= 0 && answers(fd);

    if (fd >= 0)
        (void)close(fd);
    return answered;
}

static void an_interface_is_followed_to_the_address_that_it_has(void **state)
{
    struct sockaddr_in first, second, other;
    struct ttf_err err = {0};
    struct fixture f;
    int kept;

    (void)state;
    begin(&f);
    assert_int_equal(ttf_http_places_look(&f.sockets, f.server, &err), -ENODEV);
    assert_string_equal(err.where, "usb0:0");
    assert_int_equal(f.sockets.places[1].fd, -1); /* there is no such interface yet */
    other = place_of(&f, 0);
    kept = dial(&other);
    assert_true(answers(kept));
    usb0_has(&f, NULL, -EADDRNOTAVAIL);
    assert_int_equal(f.sockets.places[1].fd, -1);
    usb0_has(&f, "127.0.0.2", 0);
    first = place_of(&f, 1);
    assert_int_equal(ntohl(first.sin_addr.s_addr), 0x7f000002);
    assert_true(is_answered_at(&first));
    usb0_has(&f, "127.0.0.3", 0);
    second = place_of(&f, 1);
    assert_int_equal(ntohl(second.sin_addr.s_addr), 0x7f000003);
    assert_true(is_answered_at(&second));
    assert_int_equal(dial(&first), -1);
    usb0_has(&f, NULL, -ENODEV);
    assert_int_equal(dial(&second), -1);
    usb0_has(&f, "127.0.0.3", 0);
    second = place_of(&f, 1);
    assert_true(is_answered_at(&second));
    assert_true(answers(kept)); /* all the time, by the address that stayed */
    assert_int_equal(f.told[TTF_HTTP_PLACE_LISTENING], 4);
    assert_int_equal(f.told[TTF_HTTP_PLACE_LEFT], 2);
    assert_int_equal(f.told[TTF_HTTP_PLACE_UNREACHABLE], 2); /* once each time that it went */
    (void)close(kept);
    end(&f);
}

static void an_address_that_stays_and_one_that_cannot_be_asked_for_stay_listened_on(void **state)
{
    struct sockaddr_in at;
    struct fixture f;
    int kept;

    (void)state;
    begin(&f);
    usb0_has(&f, "127.0.0.2", 0);
    at = place_of(&f, 1);
    kept = dial(&at);
    assert_true(answers(kept));
    for (int i = 0; i < 3; i++)
        usb0_has(&f, "127.0.0.2", 0);
    usb0_has(&f, NULL, -EMFILE);
    assert_true(answers(kept));
    assert_true(is_answered_at(&at));
    (void)close(kept);
    end(&f);
}

/* Of a place that the network's address makes loopback, and then not: what may be read freely goes with the address. */
static void whoever_may_read_freely_is_told_by_the_address_of_the_moment(void **state)
{
    struct fixture f;

    (void)state;
    begin(&f);
    usb0_has(&f, "127.0.0.2", 0);
    assert_false(f.sockets.places[0].free_to_read); /* a box: loopback as well is asked */
    assert_false(f.sockets.places[1].free_to_read);
    end(&f);
    begin(&f);
    f.sockets.free_loopback = true;
    usb0_has(&f, "127.0.0.2", 0);
    assert_true(f.sockets.places[0].free_to_read);
    assert_true(f.sockets.places[1].free_to_read);
    usb0_has(&f, "0.0.0.0", 0);
    assert_true(f.sockets.places[0].free_to_read);
    assert_false(f.sockets.places[1].free_to_read);
    end(&f);
}

/* As of a network that is set up again and again. */
static void an_address_may_change_as_often_as_it_likes(void **state)
{
    struct sockaddr_in at;
    struct fixture f;
    char address[20];

    (void)state;
    begin(&f);
    for (int i = 0; i < 40; i++) {
        (void)snprintf(address, sizeof address, "127.0.1.%d", 1 + i % 3);
        usb0_has(&f, address, 0);
        at = place_of(&f, 1);
        assert_true(is_answered_at(&at));
    }
    end(&f);
}

/* usb0 in the kernel's folder, as that of a device plugged in here has it, and as a gadget's. */
static void usb0_is_of_a_device(const struct fixture *f, bool is)
{
    static const char *const FOLDERS[] = {"", "/class", "/class/net", "/class/net/usb0",
                                          "/class/net/usb0/device"};
    const size_t n = sizeof FOLDERS / sizeof *FOLDERS;
    char path[200];

    for (size_t i = 0; is && i < n; i++) {
        (void)snprintf(path, sizeof path, "%s%s", f->sys, FOLDERS[i]);
        assert_int_equal(mkdir(path, 0700), 0);
    }
    (void)snprintf(path, sizeof path, "%s%s/bInterfaceNumber", f->sys, FOLDERS[n - 1]);
    if (is) {
        int fd = open(path, O_WRONLY | O_CREAT | O_CLOEXEC, 0600);

        assert_true(fd >= 0);
        (void)close(fd);
        return;
    }
    assert_int_equal(unlink(path), 0);
    for (size_t i = n; i > 0; i--) {
        (void)snprintf(path, sizeof path, "%s%s", f->sys, FOLDERS[i - 1]);
        assert_int_equal(rmdir(path), 0);
    }
}

/* A tethered phone's network is usb0 as well, and whoever is there was never meant. */
static void the_network_of_a_device_is_listened_on_only_if_somebody_asked_for_it(void **state)
{
    struct sockaddr_in at;
    struct fixture f;

    (void)state;
    begin(&f);
    f.sockets.as_ever = true;
    usb0_is_of_a_device(&f, true);
    usb0_has(&f, "127.0.0.2", 0);
    assert_int_equal(f.sockets.places[1].fd, -1);
    at = place_of(&f, 0);
    assert_true(is_answered_at(&at));
    usb0_is_of_a_device(&f, false); /* a gadget's has come in its place, */
    usb0_has(&f, "127.0.0.2", 0);
    at = place_of(&f, 1);
    assert_true(is_answered_at(&at));
    usb0_is_of_a_device(&f, true); /* and the other way round */
    usb0_has(&f, "127.0.0.2", 0);
    assert_int_equal(f.sockets.places[1].fd, -1);
    assert_int_equal(dial(&at), -1);
    f.sockets.as_ever = false;
    usb0_has(&f, "127.0.0.2", 0);
    at = place_of(&f, 1);
    assert_true(is_answered_at(&at));
    usb0_is_of_a_device(&f, false);
    end(&f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(an_interface_is_followed_to_the_address_that_it_has),
        cmocka_unit_test(an_address_that_stays_and_one_that_cannot_be_asked_for_stay_listened_on),
        cmocka_unit_test(the_network_of_a_device_is_listened_on_only_if_somebody_asked_for_it),
        cmocka_unit_test(whoever_may_read_freely_is_told_by_the_address_of_the_moment),
        cmocka_unit_test(an_address_may_change_as_often_as_it_likes),
    };

    (void)alarm(100); /* what waits for ever fails */
    return cmocka_run_group_tests(tests, NULL, NULL);
}
