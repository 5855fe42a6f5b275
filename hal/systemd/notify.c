/* SPDX-License-Identifier: Apache-2.0 */
#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include "ttf/base/time.h"
#include "ttf/hal/systemd.h"

static ssize_t send_state(int fd, const struct sockaddr_un *at, socklen_t n, const char *state,
                          int with)
{
    union {
        struct cmsghdr head;
        char bytes[CMSG_SPACE(sizeof(int))];
    } control = {.bytes = {0}};
    struct sockaddr_un to = *at;
    struct iovec part = {.iov_len = strlen(state)};
    struct msghdr message = {.msg_name = &to, .msg_namelen = n, .msg_iov = &part, .msg_iovlen = 1};

    memcpy(&part.iov_base, &state, sizeof(state)); /* it is read, and not const for readv's sake */
    if (with >= 0) {
        message.msg_control = control.bytes;
        message.msg_controllen = sizeof(control.bytes);
        control.head.cmsg_level = SOL_SOCKET;
        control.head.cmsg_type = SCM_RIGHTS;
        control.head.cmsg_len = CMSG_LEN(sizeof(int));
        memcpy(CMSG_DATA(&control.head), &with, sizeof(int));
    }
    return sendmsg(fd, &message, MSG_NOSIGNAL | MSG_DONTWAIT);
}

int ttf_systemd_notify(const char *socket_path, const char *state)
{
    return ttf_systemd_notify_fd(socket_path, state, -1);
}

int ttf_systemd_notify_fd(const char *socket_path, const char *state, int with)
{
    struct sockaddr_un at = {.sun_family = AF_UNIX};
    size_t n = socket_path ? strlen(socket_path) : 0;
    ssize_t sent;
    int fd, r;

    if (n == 0)
        return 0;
    if ((socket_path[0] != '/' && socket_path[0] != '@') || n >= sizeof(at.sun_path))
        return -EAFNOSUPPORT;
    memcpy(at.sun_path, socket_path, n);
    if (at.sun_path[0] == '@')
        at.sun_path[0] = '\0'; /* in the abstract namespace */
    fd = socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    if (fd < 0)
        return -errno;
    sent =
        send_state(fd, &at, (socklen_t)(offsetof(struct sockaddr_un, sun_path) + n), state, with);
    r = sent < 0 ? -errno : 1;
    (void)close(fd);
    return r;
}

#define FIRST_FD 3  /* SD_LISTEN_FDS_START */
#define MOST_FDS 64 /* nobody keeps more here */

/* The number-th of "one:two:three" is this name. */
static bool is_named(const char *names, long number, const char *name)
{
    size_t n = strlen(name);

    for (; names && number > 0; number--) {
        names = strchr(names, ':');
        names = names ? names + 1 : NULL;
    }
    return names && strncmp(names, name, n) == 0 && (names[n] == ':' || names[n] == '\0');
}

int ttf_systemd_kept_fd(const char *name)
{
    const char *pid = getenv("LISTEN_PID");       /* NOLINT(concurrency-mt-unsafe) */
    const char *fds = getenv("LISTEN_FDS");       /* NOLINT(concurrency-mt-unsafe) */
    const char *names = getenv("LISTEN_FDNAMES"); /* NOLINT(concurrency-mt-unsafe) */
    long n = fds && pid && strtol(pid, NULL, 10) == (long)getpid() ? strtol(fds, NULL, 10) : 0;
    int found = -ENOENT;

    for (long i = 0; i < n && i < MOST_FDS; i++) {
        if (fcntl(FIRST_FD + (int)i, F_SETFD, FD_CLOEXEC) == 0 && found < 0 &&
            is_named(names, i, name))
            found = FIRST_FD + (int)i;
    }
    (void)unsetenv("LISTEN_PID");     /* NOLINT(concurrency-mt-unsafe) */
    (void)unsetenv("LISTEN_FDS");     /* NOLINT(concurrency-mt-unsafe) */
    (void)unsetenv("LISTEN_FDNAMES"); /* NOLINT(concurrency-mt-unsafe) */
    return found;
}

int64_t ttf_systemd_watchdog_ns(void)
{
    const char *usec = getenv("WATCHDOG_USEC"); /* NOLINT(concurrency-mt-unsafe) */
    const char *pid = getenv("WATCHDOG_PID");   /* NOLINT(concurrency-mt-unsafe) */
    int64_t limit = usec ? strtoll(usec, NULL, 10) : 0;

    if (pid && strtol(pid, NULL, 10) != (long)getpid())
        return 0;
    return limit > 0 && limit < INT64_MAX / TTF_NS_PER_US ? limit * TTF_NS_PER_US : 0;
}

struct systemd_watchdog {
    struct ttf_watchdog base;
    char socket[sizeof(((struct sockaddr_un *)0)->sun_path)];
    int64_t limit_ns;
    bool armed;
};

static int feed(struct ttf_watchdog *base)
{
    struct systemd_watchdog *w = (struct systemd_watchdog *)base;
    int r = w->armed ? ttf_systemd_notify(w->socket, "WATCHDOG=1") : -EPIPE;

    /* A manager that is too busy to take a datagram is told by the next one. */
    return r < 0 && r != -EAGAIN ? r : 0;
}

/* By itself a manager counts from the service's start to its end: sealing a dataset, for one, takes as long as it takes. */
static int set_limit(struct systemd_watchdog *w, int64_t limit_ns)
{
    char text[64];

    (void)snprintf(text, sizeof(text), "WATCHDOG_USEC=%" PRId64, limit_ns / TTF_NS_PER_US);
    return ttf_systemd_notify(w->socket, text);
}

static int arm(struct ttf_watchdog *base, int64_t timeout_ns)
{
    struct systemd_watchdog *w = (struct systemd_watchdog *)base;
    int r;

    if (timeout_ns > w->limit_ns)
        return -EINVAL;
    r = set_limit(w, w->limit_ns);
    if (r < 0)
        return r;
    w->armed = true;
    return feed(base);
}

static void disarm(struct ttf_watchdog *base)
{
    struct systemd_watchdog *w = (struct systemd_watchdog *)base;

    w->armed = false;
    (void)set_limit(w, 0);
}

static void destroy(struct ttf_watchdog *base)
{
    free(base);
}

static const struct ttf_watchdog_ops OPS = {
    .name = "systemd", .arm = arm, .feed = feed, .disarm = disarm, .destroy = destroy};

int ttf_watchdog_systemd_create(const char *socket_path, int64_t limit_ns,
                                struct ttf_watchdog **ret, struct ttf_err *err)
{
    struct systemd_watchdog *w;

    if (!socket_path || socket_path[0] == '\0' || limit_ns <= 0)
        return ttf_err_set(err, -ENOTSUP, "watchdog", "no service manager watches this process");
    if (strlen(socket_path) >= sizeof(w->socket))
        return ttf_err_set(err, -EINVAL, socket_path, "is too long for a socket's path");
    w = calloc(1, sizeof(*w));
    if (!w)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory");
    w->base.ops = &OPS;
    memcpy(w->socket, socket_path, strlen(socket_path) + 1);
    w->limit_ns = limit_ns;
    disarm(&w->base); /* until it is armed */
    *ret = &w->base;
    return 0;
}
