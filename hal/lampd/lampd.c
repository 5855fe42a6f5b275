/* SPDX-License-Identifier: Apache-2.0 */
/* lampd.c: the guardian's loop: time, lines, temperature and clients in; levels out. */
#include <errno.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <time.h>
#include <unistd.h>

#include "lampd_private.h"
#include "ttf/base/time.h"

#define ROUND_NS  (50 * TTF_NS_PER_MS) /* the longest that the loop sleeps */
#define REOPEN_NS TTF_NS_PER_S         /* how often a chip that is gone is looked for */
#define LOOK_NS   TTF_NS_PER_S         /* and one with a lit lamp is asked whether it is there */

/* An input that floats gives edges without end: more than these wait for the next round. */
#define EDGES_A_ROUND 32

/* ---- lines ---- */

static void drive_lamp(struct ttf_lampd *d, unsigned i)
{
    unsigned want = d->guardian.lamp[i].actual_permille;
    int r;

    if (want == d->driven[i] && !d->failed[i])
        return;
    r = ttf_lines_set(d->config.lines, i, want);
    d->failed[i] = r < 0;
    if (r == -ENODEV)
        d->lost = true;
    if (r == 0)
        d->driven[i] = want;
}

/* A move that the guardian knows of already is none. */
static void feel_door(struct ttf_lampd *d, int64_t now_ns, bool open)
{
    if (open != d->guardian.door_open)
        *(open ? &d->door_opened_ns : &d->door_closed_ns) = now_ns;
    ttf_guardian_door(&d->guardian, now_ns, open);
}

/* A switch that cannot be read is a door that may be open. */
static void look_at_door(struct ttf_lampd *d, int64_t now_ns)
{
    if (d->config.door >= 0)
        feel_door(d, now_ns, ttf_lines_get(d->config.lines, (unsigned)d->config.door) != 0);
}

/* Lines that come back are dark; what was commanded before is not lit again by itself. */
static void look_for_chip(struct ttf_lampd *d, int64_t now_ns)
{
    if (now_ns < d->reopen_at_ns)
        return;
    d->reopen_at_ns = now_ns + REOPEN_NS;
    for (unsigned i = 0; i < d->guardian.n; i++)
        (void)ttf_guardian_set(&d->guardian, now_ns, i, 0);
    if (ttf_lines_reopen(d->config.lines, NULL) < 0)
        return;
    d->lost = false;
    for (unsigned i = 0; i < d->guardian.n; i++) {
        d->driven[i] = 0;
        d->failed[i] = false;
    }
    look_at_door(d, now_ns);
}

void lampd_drive(struct ttf_lampd *d, int64_t now_ns)
{
    ttf_guardian_advance(&d->guardian, now_ns);
    if (!d->guardian.leased)
        d->holder = -1;
    for (unsigned i = 0; i < d->guardian.n; i++)
        drive_lamp(d, i);
    if (d->lost)
        look_for_chip(d, now_ns);
}

/* A chip that goes while a lamp is lit and no wire moves is noticed by asking it. */
static void look_at_lit(struct ttf_lampd *d, int64_t now_ns)
{
    if (now_ns < d->look_at_ns)
        return;
    d->look_at_ns = now_ns + LOOK_NS;
    for (unsigned i = 0; i < d->guardian.n; i++)
        if (d->driven[i] > 0 && ttf_lines_get(d->config.lines, i) == -ENODEV)
            d->lost = true;
}

static void feel_lines(struct ttf_lampd *d, int64_t now_ns)
{
    struct ttf_line_event event;
    bool moved = false;
    int r = 1;

    for (unsigned n = 0; r > 0 && n < EDGES_A_ROUND; n++) {
        r = ttf_lines_event(d->config.lines, &event);
        if (r <= 0 || (int)event.i != d->config.door)
            continue;
        feel_door(d, now_ns, event.active);
        moved = true;
    }
    if (r == -ENODEV)
        d->lost = true;
    else if (moved) /* the kernel drops edges of a switch that bounces: see where it came to rest */
        look_at_door(d, now_ns);
}

static void feel_heat(struct ttf_lampd *d)
{
    int32_t temp_mdegc;
    int64_t at_ns;

    /* Other sensors may have hung their thread since it was read: it counts from then on. */
    if (lampd_heat_take(&d->heat, &temp_mdegc, &at_ns))
        ttf_guardian_temp_late(&d->guardian, ttf_clock_now_ns(d->config.clock), at_ns, temp_mdegc);
}

/* ---- the loop ---- */

static void welcome(struct ttf_lampd *d)
{
    int fd = accept4(d->listening, NULL, NULL, SOCK_CLOEXEC | SOCK_NONBLOCK);

    if (fd < 0)
        return;
    for (unsigned c = 0; c < LAMPD_CLIENTS_MAX; c++) {
        if (d->client[c] >= 0)
            continue;
        d->client[c] = fd;
        return;
    }
    (void)close(fd); /* a full house: this one is told by its end */
}

static struct timespec until_next(const struct ttf_lampd *d, int64_t now_ns)
{
    int64_t wait_ns = ttf_guardian_next_ns(&d->guardian) - now_ns;

    if (wait_ns > ROUND_NS)
        wait_ns = ROUND_NS;
    if (wait_ns < 0)
        wait_ns = 0;
    return (struct timespec){.tv_nsec = (long)wait_ns};
}

/* Waits for whatever comes first. */
static void one_round(struct ttf_lampd *d)
{
    struct pollfd fds[2 + LAMPD_CLIENTS_MAX];
    int64_t now_ns = ttf_clock_now_ns(d->config.clock);
    struct timespec wait = until_next(d, now_ns);

    fds[0] = (struct pollfd){.fd = d->listening, .events = POLLIN};
    fds[1] = (struct pollfd){.fd = d->lost ? -1 : ttf_lines_fd(d->config.lines), .events = POLLIN};
    for (unsigned c = 0; c < LAMPD_CLIENTS_MAX; c++)
        fds[2 + c] = (struct pollfd){.fd = d->client[c], .events = POLLIN};
    if (ppoll(fds, 2 + LAMPD_CLIENTS_MAX, &wait, NULL) < 0)
        for (unsigned k = 0; k < 2 + LAMPD_CLIENTS_MAX; k++)
            fds[k].revents = 0;
    now_ns = ttf_clock_now_ns(d->config.clock);
    feel_heat(d);
    if (!d->lost)
        feel_lines(d, now_ns);
    if (!d->lost)
        look_at_lit(d, now_ns);
    lampd_drive(d, now_ns);
    for (unsigned c = 0; c < LAMPD_CLIENTS_MAX; c++)
        if (fds[2 + c].revents)
            lampd_hear(d, c);
    if (fds[0].revents)
        welcome(d);
    lampd_drive(d, ttf_clock_now_ns(d->config.clock));
}

int ttf_lampd_run(struct ttf_lampd *d, const volatile int *stop)
{
    bool armed =
        d->config.watchdog && ttf_watchdog_arm(d->config.watchdog, d->config.watchdog_ns) == 0;

    while (__atomic_load_n(stop, __ATOMIC_RELAXED) == 0) {
        int fed;

        one_round(d);
        fed = armed ? ttf_watchdog_feed(d->config.watchdog) : 0;
        (void)fed; /* what it did not take this time it may take the next */
    }
    ttf_guardian_release(&d->guardian, ttf_clock_now_ns(d->config.clock));
    d->holder = -1;
    lampd_drive(d, ttf_clock_now_ns(d->config.clock));
    if (armed)
        ttf_watchdog_disarm(d->config.watchdog);
    return 0;
}

/* ---- beginning and end ---- */

static int address(const char *path, struct sockaddr_un *ret, struct ttf_err *err)
{
    *ret = (struct sockaddr_un){.sun_family = AF_UNIX};
    if (strlen(path) >= sizeof(ret->sun_path))
        return ttf_err_set(err, -ENAMETOOLONG, path, "is too long for a socket's path");
    memcpy(ret->sun_path, path, strlen(path) + 1);
    return 0;
}

/* A path that nobody listens at is a dead guardian's. One that hangs may have too many callers already: EAGAIN. */
static bool answers(const struct sockaddr_un *at)
{
    int fd = socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    bool yes =
        fd >= 0 && (connect(fd, (const struct sockaddr *)at, sizeof(*at)) == 0 || errno == EAGAIN);

    if (fd >= 0)
        (void)close(fd);
    return yes;
}

static int open_socket(struct ttf_lampd *d, struct ttf_err *err)
{
    struct sockaddr_un at;
    int r = address(d->config.socket, &at, err);

    if (r < 0)
        return r;
    if (answers(&at)) {
        ttf_err_set(err, -EADDRINUSE, d->config.socket, "another lamp guardian answers here");
        ttf_err_hint(err, "two must not hold the same lamps: stop the other one first");
        return -EADDRINUSE;
    }
    (void)unlink(d->config.socket);
    d->listening = socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    if (d->listening < 0 || bind(d->listening, (struct sockaddr *)&at, sizeof(at)) < 0 ||
        chmod(d->config.socket, 0660) < 0 || listen(d->listening, LAMPD_CLIENTS_MAX) < 0)
        return ttf_err_set(err, -errno, d->config.socket, "cannot be made a socket: %s",
                           strerrordesc_np(errno));
    memcpy(d->path, at.sun_path, sizeof(d->path));
    return 0;
}

static int check(const struct ttf_lampd_config *config, struct ttf_err *err)
{
    if (config->n == 0 || config->n > TTF_LAMPS_MAX || config->n > ttf_lines_count(config->lines))
        return ttf_err_set(err, -EINVAL, "lamps", "%u lamps on %u lines", config->n,
                           ttf_lines_count(config->lines));
    for (unsigned i = 0; i < config->n; i++)
        if (ttf_lines_spec(config->lines, i)->input)
            return ttf_err_set(err, -EINVAL, config->info[i].name, "its line is an input");
    if (config->door >= 0 && ((unsigned)config->door >= ttf_lines_count(config->lines) ||
                              !ttf_lines_spec(config->lines, (unsigned)config->door)->input))
        return ttf_err_set(err, -EINVAL, "door", "line %d is no input", config->door);
    return 0;
}

int ttf_lampd_create(const struct ttf_lampd_config *config, struct ttf_lampd **ret,
                     struct ttf_err *err)
{
    struct ttf_lampd *d;
    int64_t now_ns;
    int r = check(config, err);

    if (r < 0)
        return r;
    d = calloc(1, sizeof(*d));
    if (!d)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory");
    d->config = *config;
    d->listening = d->holder = -1;
    d->door_opened_ns = d->door_closed_ns = TTF_NS_UNKNOWN;
    for (unsigned c = 0; c < LAMPD_CLIENTS_MAX; c++)
        d->client[c] = -1;
    now_ns = ttf_clock_now_ns(config->clock);
    ttf_guardian_init(&d->guardian, config->info, config->n, now_ns);
    ttf_guardian_assume_used(&d->guardian);
    if (config->door >= 0) /* a switch that cannot be read is a door that may be open */
        ttf_guardian_door(&d->guardian, now_ns,
                          ttf_lines_get(config->lines, (unsigned)config->door) != 0);
    r = open_socket(d, err);
    if (r == 0) /* last: who fails here leaves no thread that may hang */
        r = lampd_heat_start(&d->heat, config, err);
    if (r < 0) {
        (void)ttf_lampd_destroy(d);
        return r;
    }
    *ret = d;
    return 0;
}

static void shut(int *fd)
{
    if (*fd >= 0)
        (void)close(*fd);
    *fd = -1;
}

int ttf_lampd_destroy(struct ttf_lampd *d)
{
    if (!d)
        return 0;
    for (unsigned c = 0; c < LAMPD_CLIENTS_MAX; c++)
        shut(&d->client[c]);
    shut(&d->listening);
    if (d->path[0])
        (void)unlink(d->path);
    d->path[0] = '\0';
    if (lampd_heat_stop(&d->heat) < 0)
        return -EBUSY;
    free(d);
    return 0;
}
