/* SPDX-License-Identifier: Apache-2.0 */
/* test_systemd.c: what a service manager hears. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <errno.h>
#include <fcntl.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include "conformance/conformance.h"
#include "ttf/base/time.h"
#include "ttf/hal/systemd.h"

struct manager {
    char path[64];
    int fd;
    struct ttf_clock *clock;
};

static int setup(void **state)
{
    struct manager *m = calloc(1, sizeof(*m));
    struct sockaddr_un at = {.sun_family = AF_UNIX};

    assert_non_null(m);
    snprintf(m->path, sizeof(m->path), "/tmp/ttf-notify.%d", (int)getpid());
    (void)unlink(m->path);
    memcpy(at.sun_path, m->path, sizeof(m->path));
    m->fd = socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    assert_true(m->fd >= 0);
    assert_int_equal(bind(m->fd, (struct sockaddr *)&at, sizeof(at)), 0);
    *state = m;
    return 0;
}

static int teardown(void **state)
{
    struct manager *m = *state;

    (void)close(m->fd);
    (void)unlink(m->path);
    free(m);
    return 0;
}

/* What came, "" if nothing did. */
static const char *heard(struct manager *m, char *ret, size_t size)
{
    ssize_t n = recv(m->fd, ret, size - 1, 0);

    ret[n < 0 ? 0 : n] = '\0';
    return ret;
}

static void states_arrive_as_they_are_said(void **state)
{
    struct manager *m = *state;
    char text[128];

    assert_int_equal(ttf_systemd_notify(m->path, "READY=1\nSTATUS=slot 3 of 10"), 1);
    assert_string_equal(heard(m, text, sizeof(text)), "READY=1\nSTATUS=slot 3 of 10");
    assert_int_equal(ttf_systemd_notify(NULL, "READY=1"), 0);
    assert_int_equal(ttf_systemd_notify("", "READY=1"), 0);
    assert_int_equal(ttf_systemd_notify("vsock:2:1234", "READY=1"), -EAFNOSUPPORT);
    assert_int_equal(ttf_systemd_notify("/nobody/here", "READY=1"), -ENOENT);
    assert_string_equal(heard(m, text, sizeof(text)), "");
}

static void the_watchdog_is_fed_by_the_unit_s_limit(void **state)
{
    struct manager *m = *state;
    struct ttf_watchdog *dog;
    char text[128];

    assert_int_equal(ttf_watchdog_systemd_create(m->path, 5 * TTF_NS_PER_S, &dog, NULL), 0);
    assert_string_equal(heard(m, text, sizeof(text)), "WATCHDOG_USEC=0");
    assert_int_equal(ttf_watchdog_arm(dog, 6 * TTF_NS_PER_S), -EINVAL);
    assert_string_equal(heard(m, text, sizeof(text)), "");
    assert_int_equal(ttf_watchdog_arm(dog, 5 * TTF_NS_PER_S), 0);
    assert_string_equal(heard(m, text, sizeof(text)), "WATCHDOG_USEC=5000000");
    assert_string_equal(heard(m, text, sizeof(text)), "WATCHDOG=1");
    assert_int_equal(ttf_watchdog_feed(dog), 0);
    assert_string_equal(heard(m, text, sizeof(text)), "WATCHDOG=1");
    ttf_watchdog_destroy(dog);
}

/* Opening a long dataset, or sealing it, feeds nothing. */
static void the_manager_counts_no_time_while_it_is_not_armed(void **state)
{
    struct manager *m = *state;
    struct ttf_watchdog *dog;
    char text[128];

    assert_int_equal(ttf_watchdog_systemd_create(m->path, 5 * TTF_NS_PER_S, &dog, NULL), 0);
    assert_string_equal(heard(m, text, sizeof(text)), "WATCHDOG_USEC=0");
    assert_int_equal(ttf_watchdog_arm(dog, TTF_NS_PER_S), 0);
    while (*heard(m, text, sizeof(text)))
        ;
    ttf_watchdog_disarm(dog);
    assert_string_equal(heard(m, text, sizeof(text)), "WATCHDOG_USEC=0");
    assert_int_equal(ttf_watchdog_arm(dog, TTF_NS_PER_S), 0);
    assert_string_equal(heard(m, text, sizeof(text)), "WATCHDOG_USEC=5000000");
    ttf_watchdog_destroy(dog);
}

static void a_manager_that_is_busy_does_not_hold_the_loop(void **state)
{
    struct manager *m = *state;
    struct ttf_watchdog *dog;

    assert_int_equal(ttf_watchdog_systemd_create(m->path, 5 * TTF_NS_PER_S, &dog, NULL), 0);
    assert_int_equal(ttf_watchdog_arm(dog, TTF_NS_PER_S), 0);
    for (unsigned i = 0; i < 10000; i++) /* far more than any socket keeps */
        assert_int_equal(ttf_watchdog_feed(dog), 0);
    ttf_watchdog_destroy(dog);
}

static void without_a_manager_there_is_no_watchdog(void **state)
{
    struct ttf_watchdog *dog;
    char text[200];

    (void)state;
    memset(text, 'x', sizeof(text) - 1);
    text[0] = '/';
    text[sizeof(text) - 1] = '\0';
    assert_int_equal(ttf_watchdog_systemd_create(NULL, TTF_NS_PER_S, &dog, NULL), -ENOTSUP);
    assert_int_equal(ttf_watchdog_systemd_create("/x", 0, &dog, NULL), -ENOTSUP);
    assert_int_equal(ttf_watchdog_systemd_create(text, TTF_NS_PER_S, &dog, NULL), -EINVAL);
    assert_int_equal(ttf_systemd_notify(text, "READY=1"), -EAFNOSUPPORT);
}

/* ---- the suite ---- */

static void destroy(struct ttf_box *box)
{
    void *state = box->box_private;

    ttf_watchdog_destroy(box->watchdog);
    (void)teardown(&state);
}

static int make(struct ttf_box *ret)
{
    void *state = NULL;

    (void)setup(&state);
    *ret = (struct ttf_box){.box_private = state, .destroy = destroy};
    return ttf_watchdog_systemd_create(((struct manager *)state)->path, 60 * TTF_NS_PER_S,
                                       &ret->watchdog, NULL);
}

/* The environment is as a manager sets it, and as a child of a service inherits it. */
static void a_watchdog_is_that_of_the_process_it_names(void **state)
{
    char me[24];

    (void)state;
    (void)snprintf(me, sizeof(me), "%d", (int)getpid());
    /* NOLINTBEGIN(concurrency-mt-unsafe): one thread runs */
    assert_int_equal(unsetenv("WATCHDOG_PID"), 0);
    assert_int_equal(unsetenv("WATCHDOG_USEC"), 0);
    assert_true(ttf_systemd_watchdog_ns() == 0);
    assert_int_equal(setenv("WATCHDOG_USEC", "2000000", 1), 0);
    assert_true(ttf_systemd_watchdog_ns() == 2 * TTF_NS_PER_S);
    assert_int_equal(setenv("WATCHDOG_PID", me, 1), 0);
    assert_true(ttf_systemd_watchdog_ns() == 2 * TTF_NS_PER_S);
    assert_int_equal(setenv("WATCHDOG_PID", "1", 1), 0);
    assert_true(ttf_systemd_watchdog_ns() == 0);
    assert_int_equal(unsetenv("WATCHDOG_PID"), 0);
    assert_int_equal(setenv("WATCHDOG_USEC", "-5", 1), 0);
    assert_true(ttf_systemd_watchdog_ns() == 0);
    assert_int_equal(unsetenv("WATCHDOG_USEC"), 0);
    /* NOLINTEND(concurrency-mt-unsafe) */
}

/* ---- descriptors that the manager keeps ---- */

static void a_descriptor_goes_along_and_is_the_same_file(void **state)
{
    struct manager *m = *state;
    char text[100] = "", byte = 0;
    union {
        struct cmsghdr head;
        char bytes[CMSG_SPACE(sizeof(int))];
    } control;
    struct iovec part = {text, sizeof(text) - 1};
    struct msghdr message = {.msg_iov = &part,
                             .msg_iovlen = 1,
                             .msg_control = control.bytes,
                             .msg_controllen = sizeof(control.bytes)};
    const struct cmsghdr *first;
    int ends[2], kept;

    assert_int_equal(pipe(ends), 0);
    assert_int_equal(ttf_systemd_notify_fd(m->path, "FDSTORE=1\nFDNAME=ep0", ends[0]), 1);
    assert_int_equal(ttf_systemd_notify_fd(NULL, "FDSTORE=1", ends[0]), 0);
    (void)close(ends[0]);
    assert_true(recvmsg(m->fd, &message, 0) > 0);
    assert_string_equal(text, "FDSTORE=1\nFDNAME=ep0");
    first = CMSG_FIRSTHDR(&message);
    if (!first || first->cmsg_len != CMSG_LEN(sizeof(kept))) {
        fail_msg("no descriptor came along");
        return;
    }
    memcpy(&kept, CMSG_DATA(first), sizeof(kept));
    assert_int_equal(write(ends[1], "x", 1), 1);
    assert_int_equal(read(kept, &byte, 1), 1);
    assert_int_equal(byte, 'x');
    (void)close(kept);
    (void)close(ends[1]);
}

/* Of a process with descriptors 3 and 4 from its manager: which is ep0. In a process of its own, whose 3 and 4 may be anything. */
static int kept_of(const char *names, const char *fds, bool is_ours)
{
    int status = 0;
    pid_t child = fork();

    if (child == 0) {
        char pid[16];
        int found, again;

        (void)snprintf(pid, sizeof(pid), "%d", is_ours ? (int)getpid() : 1);
        /* NOLINTBEGIN(concurrency-mt-unsafe): one thread runs */
        (void)setenv("LISTEN_PID", pid, 1);
        (void)setenv("LISTEN_FDS", fds, 1);
        (void)setenv("LISTEN_FDNAMES", names, 1);
        if (dup2(0, 3) < 0 || dup2(0, 4) < 0)
            _exit(100);
        found = ttf_systemd_kept_fd("ep0");
        again = ttf_systemd_kept_fd("ep0");
        /* No child of this one is to think that it is meant, nor to keep what it got. */
        if (again != -ENOENT || getenv("LISTEN_FDS") || getenv("LISTEN_PID"))
            _exit(101);
        /* NOLINTEND(concurrency-mt-unsafe) */
        if (found > 0 && !(fcntl(found, F_GETFD) & FD_CLOEXEC))
            _exit(102);
        _exit(found == -ENOENT ? 0 : found);
    }
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_true(WIFEXITED(status));
    return WEXITSTATUS(status);
}

static void what_was_kept_is_found_by_its_name(void **state)
{
    (void)state;
    assert_int_equal(kept_of("ep0", "1", true), 3);
    assert_int_equal(kept_of("stored:ep0", "2", true), 4);
    assert_int_equal(kept_of("ep0:ep0", "2", true), 3);
    assert_int_equal(kept_of("ep01:xep0", "2", true), 0);
    assert_int_equal(kept_of("stored:ep0", "1", true), 0); /* named, but not there */
    assert_int_equal(kept_of("", "2", true), 0);
    assert_int_equal(kept_of("ep0", "0", true), 0);
    assert_int_equal(kept_of("ep0", "x", true), 0);
    assert_int_equal(kept_of("ep0", "-1", true), 0);
    assert_int_equal(kept_of("ep0", "1", false), 0); /* another process is meant */
}

int main(void)
{
#define MANAGED(test) cmocka_unit_test_setup_teardown(test, setup, teardown)
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_watchdog_is_that_of_the_process_it_names),
        MANAGED(states_arrive_as_they_are_said),
        MANAGED(the_watchdog_is_fed_by_the_unit_s_limit),
        MANAGED(the_manager_counts_no_time_while_it_is_not_armed),
        MANAGED(a_manager_that_is_busy_does_not_hold_the_loop),
        MANAGED(without_a_manager_there_is_no_watchdog),
        MANAGED(a_descriptor_goes_along_and_is_the_same_file),
        cmocka_unit_test(what_was_kept_is_found_by_its_name),
    };
    const struct conformance_factory systemd = {"systemd", make};

    return cmocka_run_group_tests(tests, NULL, NULL) + conformance_watchdog(&systemd);
}
