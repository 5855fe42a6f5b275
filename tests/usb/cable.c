/* SPDX-License-Identifier: Apache-2.0 */
/* cable.c: see cable.h. Reads time itself: it is a piece of the world, not of a box. */
#include "cable.h"

#include <errno.h>
#include <poll.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <time.h>
#include <unistd.h>

#include "pipe.h"

#define PIECE     65536
#define STALE_MAX 16    /* pieces that wait for the next host */
#define ANSWER_S  1.0   /* how long a box has for a control request */
#define BURST_S   0.004 /* how long a throttled cable may save up for */

/* One direction: from `from` (our end of the writer's socket) to `to` (our end of the reader's). */
struct direction {
    int from, to;        /* ours */
    int writer, reader;  /* what the ends get copies of; ours keep what lies in them alive */
    uint8_t hand[PIECE]; /* taken from the writer, not given to the reader yet */
    size_t n;
    bool full;
    uint8_t *stale[STALE_MAX]; /* goes first */
    size_t n_stale[STALE_MAX];
    unsigned stales;
};

struct cable {
    int listen, commands, command; /* command: a connection that gives some */
    int box, host;                 /* control connections */
    bool plugged, asleep, lose_down;
    struct direction out, in; /* from the host; to it */
    double megabytes_s;       /* 0: as fast as it goes */
    double allowance, counted;
    double reset_until; /* a control request's; 0: none */
    uint64_t random;
    char line[128];
    size_t n_line;
    char path[108], command_path[108];
};

static double now_s(void)
{
    struct timespec t;

    (void)clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + (double)t.tv_nsec / 1e9;
}

static size_t draw(struct cable *c, size_t below)
{
    c->random ^= c->random << 13;
    c->random ^= c->random >> 7;
    c->random ^= c->random << 17;
    return below ? (size_t)(c->random >> 16) % below : 0;
}

static int listen_at(const char *path, int type)
{
    struct sockaddr_un at = {.sun_family = AF_UNIX};
    int fd = socket(AF_UNIX, type | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);

    (void)unlink(path);
    (void)snprintf(at.sun_path, sizeof at.sun_path, "%s", path);
    if (fd >= 0 && (bind(fd, (struct sockaddr *)&at, sizeof at) < 0 || listen(fd, 8) < 0)) {
        (void)close(fd);
        fd = -1;
    }
    return fd;
}

static void shut(int *fd)
{
    if (*fd >= 0)
        (void)close(*fd);
    *fd = -1;
}

/* ---- directions ---- */

static void direction_close(struct direction *d)
{
    int *fds[] = {&d->from, &d->to, &d->writer, &d->reader};

    for (unsigned i = 0; i < 4; i++) {
        if (*fds[i] >= 0)
            (void)shutdown(*fds[i], SHUT_RDWR);
        shut(fds[i]);
    }
    for (unsigned i = 0; i < d->stales; i++)
        free(d->stale[i]);
    d->stales = 0;
    d->full = false;
}

static bool direction_open(struct direction *d)
{
    int a[2], b[2];

    if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | SOCK_NONBLOCK, 0, a) < 0)
        return false;
    d->writer = a[0];
    d->from = a[1];
    if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | SOCK_NONBLOCK, 0, b) < 0)
        return false;
    d->to = b[0];
    d->reader = b[1];
    return true;
}

static size_t whole_packets(struct cable *c, size_t n)
{
    return draw(c, n / USB_PIPE_PACKET + 1) * USB_PIPE_PACKET;
}

/* The writer died: of what it was sending, some packets have gone; what it had queued behind never goes. */
static void writer_died(struct cable *c, struct direction *d)
{
    uint8_t rest[PIECE];

    if (!d->full) {
        ssize_t n = recv(d->from, d->hand, sizeof d->hand, MSG_DONTWAIT);

        d->full = n > 0;
        d->n = n > 0 ? (size_t)n : 0;
    }
    while (recv(d->from, rest, sizeof rest, MSG_DONTWAIT) > 0)
        ;
    if (d->full)
        d->n = whole_packets(c, d->n);
    d->full = d->n > 0 && d->full;
}

static void keep(struct direction *d, const uint8_t *data, size_t n)
{
    if (n == 0 || d->stales == STALE_MAX)
        return;
    d->stale[d->stales] = malloc(n);
    if (!d->stale[d->stales])
        return;
    memcpy(d->stale[d->stales], data, n);
    d->n_stale[d->stales++] = n;
}

/* The reader died: packets that it had are lost, the rest of the transfer and those behind it wait. */
static void reader_died(struct cable *c, struct direction *d)
{
    uint8_t piece[PIECE];
    bool first = true;
    ssize_t n;

    while ((n = recv(d->reader, piece, sizeof piece, MSG_DONTWAIT)) > 0) {
        size_t lost = first ? whole_packets(c, (size_t)n) : 0;

        keep(d, piece + lost, (size_t)n - lost);
        first = false;
    }
}

static void move_stale(struct direction *d)
{
    while (d->stales > 0) {
        if (send(d->to, d->stale[0], d->n_stale[0], MSG_DONTWAIT | MSG_NOSIGNAL) < 0)
            return;
        free(d->stale[0]);
        d->stales--;
        memmove(d->stale, d->stale + 1, d->stales * sizeof d->stale[0]);
        memmove(d->n_stale, d->n_stale + 1, d->stales * sizeof d->n_stale[0]);
    }
}

static bool may_pass(struct cable *c)
{
    double now = now_s();

    if (c->megabytes_s <= 0)
        return true;
    c->allowance += (now - c->counted) * c->megabytes_s * 1e6;
    c->counted = now;
    if (c->allowance > BURST_S * c->megabytes_s * 1e6)
        c->allowance = BURST_S * c->megabytes_s * 1e6;
    return c->allowance > 0;
}

/* Some pieces. */
static void move(struct cable *c, struct direction *d)
{
    move_stale(d);
    for (unsigned i = 0; i < 8 && d->stales == 0; i++) {
        ssize_t n;

        if (!d->full) {
            n = recv(d->from, d->hand, sizeof d->hand, MSG_DONTWAIT);
            if (n <= 0)
                return;
            d->n = (size_t)n;
            d->full = true;
        }
        if (!may_pass(c) || send(d->to, d->hand, d->n, MSG_DONTWAIT | MSG_NOSIGNAL) < 0)
            return;
        c->allowance -= (double)d->n;
        d->full = false;
    }
}

/* ---- ends ---- */

static void tell(int fd, enum usb_pipe_kind kind, uint64_t nonce)
{
    struct usb_pipe_message m = {.kind = kind, .nonce = nonce};

    if (fd >= 0)
        (void)send(fd, &m, sizeof m, MSG_NOSIGNAL | MSG_DONTWAIT);
}

static void give_fds(int fd, int reads, int writes)
{
    struct usb_pipe_message m = {.kind = USB_PIPE_UP};
    struct iovec part = {&m, sizeof m};
    union {
        struct cmsghdr head;
        char bytes[CMSG_SPACE(2 * sizeof(int))];
    } control = {.bytes = {0}};
    struct msghdr message = {.msg_iov = &part,
                             .msg_iovlen = 1,
                             .msg_control = control.bytes,
                             .msg_controllen = sizeof control.bytes};
    const int fds[2] = {reads, writes};

    control.head.cmsg_level = SOL_SOCKET;
    control.head.cmsg_type = SCM_RIGHTS;
    control.head.cmsg_len = CMSG_LEN(sizeof fds);
    memcpy(CMSG_DATA(&control.head), fds, sizeof fds);
    (void)sendmsg(fd, &message, MSG_NOSIGNAL | MSG_DONTWAIT);
}

static void plug(struct cable *c)
{
    if (c->plugged)
        return;
    c->plugged = direction_open(&c->out) && direction_open(&c->in);
    c->asleep = false;
    if (c->box >= 0)
        give_fds(c->box, c->out.reader, c->in.writer);
}

static void unplug(struct cable *c)
{
    if (!c->plugged)
        return;
    direction_close(&c->out);
    direction_close(&c->in);
    c->plugged = false;
    if (!c->lose_down)
        tell(c->box, USB_PIPE_DOWN, 0);
    c->lose_down = false;
    shut(&c->host);
}

/* A socket's first message says who it is. */
static void welcome(struct cable *c)
{
    struct usb_pipe_message m = {.kind = 0};
    int fd = accept4(c->listen, NULL, NULL, SOCK_CLOEXEC);

    if (fd < 0)
        return;
    if (recv(fd, &m, sizeof m, 0) != (ssize_t)sizeof m) {
        shut(&fd);
    } else if (m.kind == USB_PIPE_BOX) {
        shut(&c->box);
        c->box = fd;
        if (c->plugged)
            give_fds(fd, c->out.reader, c->in.writer);
        else
            plug(c);
    } else if (!c->plugged || c->host >= 0) {
        tell(fd, c->plugged ? USB_PIPE_BUSY : USB_PIPE_NOBODY, 0);
        shut(&fd);
    } else {
        c->host = fd;
        give_fds(fd, c->in.reader, c->out.writer);
    }
}

static void host_speaks(struct cable *c)
{
    struct usb_pipe_message m;
    ssize_t n = recv(c->host, &m, sizeof m, MSG_DONTWAIT);

    if (n == (ssize_t)sizeof m && m.kind == USB_PIPE_RESET) {
        tell(c->box, USB_PIPE_RESET, m.nonce);
        c->reset_until = now_s() + ANSWER_S;
    } else if (n == 0 || (n < 0 && errno != EAGAIN)) {
        shut(&c->host);
        c->reset_until = 0;
        writer_died(c, &c->out);
        reader_died(c, &c->in);
    }
}

static void box_speaks(struct cable *c)
{
    struct usb_pipe_message m;
    ssize_t n = recv(c->box, &m, sizeof m, MSG_DONTWAIT);

    if (n == (ssize_t)sizeof m && m.kind == USB_PIPE_ANSWER && c->reset_until > 0) {
        c->reset_until = 0;
        tell(c->host, USB_PIPE_ANSWER, 0);
    } else if (n == (ssize_t)sizeof m && m.kind == USB_PIPE_BOX) {
        writer_died(c, &c->in); /* a new process at the same connection */
        if (c->plugged)
            give_fds(c->box, c->out.reader, c->in.writer);
    } else if (n == 0 || (n < 0 && errno != EAGAIN)) {
        shut(&c->box); /* nobody holds the gadget any more: it unbinds */
        unplug(c);
    }
}

/* ---- commands ---- */

static void obey(struct cable *c, const char *line)
{
    double n;

    if (strcmp(line, "unplug") == 0)
        unplug(c);
    else if (strcmp(line, "replug") == 0)
        plug(c);
    else if (strcmp(line, "lose-down") == 0)
        c->lose_down = true;
    else if (strcmp(line, "suspend") == 0 || strcmp(line, "resume") == 0) {
        c->asleep = line[0] == 's';
        tell(c->box, c->asleep ? USB_PIPE_SUSPEND : USB_PIPE_RESUME, 0);
    } else if (strncmp(line, "throttle ", 9) == 0) {
        n = strtod(line + 9, NULL);
        c->megabytes_s = n;
        c->counted = now_s();
        c->allowance = 0;
    } else {
        (void)send(c->command, "what?\n", 6, MSG_NOSIGNAL);
        return;
    }
    (void)send(c->command, "ok\n", 3, MSG_NOSIGNAL);
}

static void take_commands(struct cable *c)
{
    ssize_t n = recv(c->command, c->line + c->n_line, sizeof c->line - 1 - c->n_line, MSG_DONTWAIT);
    char *end;

    if (n == 0 || (n < 0 && errno != EAGAIN)) {
        shut(&c->command);
        c->n_line = 0;
        return;
    }
    c->n_line += n > 0 ? (size_t)n : 0;
    c->line[c->n_line] = '\0';
    while ((end = strchr(c->line, '\n'))) {
        *end = '\0';
        obey(c, c->line);
        c->n_line -= (size_t)(end + 1 - c->line);
        memmove(c->line, end + 1, c->n_line + 1);
    }
}

/* ---- the loop ---- */

static unsigned add(struct pollfd *fds, unsigned n, int fd, short events)
{
    fds[n] = (struct pollfd){.fd = fd, .events = events};
    return n + 1;
}

static unsigned add_direction(const struct direction *d, struct pollfd *fds, unsigned n)
{
    if (d->full || d->stales > 0)
        return add(fds, n, d->to, POLLOUT);
    return add(fds, n, d->from, POLLIN);
}

static void look(struct cable *c, int timeout_ms)
{
    struct pollfd fds[8];
    unsigned n = 0;
    /* A full hand that is held back by a throttle waits for time, not for room. */
    bool held = c->megabytes_s > 0 && !may_pass(c);

    n = add(fds, n, c->listen, POLLIN);
    n = add(fds, n, c->command >= 0 ? c->command : c->commands, POLLIN);
    n = add(fds, n, c->box, POLLIN);
    n = add(fds, n, c->host, POLLIN);
    if (c->plugged && !c->asleep && !held) {
        n = add_direction(&c->out, fds, n);
        n = add_direction(&c->in, fds, n);
    }
    if (poll(fds, n, held ? 1 : timeout_ms) <= 0)
        return;
    if (fds[2].revents)
        box_speaks(c);
    if (fds[3].revents && c->host >= 0)
        host_speaks(c);
    if (fds[0].revents)
        welcome(c);
    if (fds[1].revents) {
        if (c->command < 0)
            c->command = accept4(c->commands, NULL, NULL, SOCK_CLOEXEC);
        else
            take_commands(c);
    }
}

void cable_run(struct cable *c, const volatile int *stop)
{
    while (!__atomic_load_n(stop, __ATOMIC_RELAXED)) {
        look(c, 50);
        if (c->plugged && !c->asleep) {
            move(c, &c->out);
            move(c, &c->in);
        }
        if (c->reset_until > 0 && now_s() > c->reset_until) {
            c->reset_until = 0;
            tell(c->host, USB_PIPE_FAILED, 0);
        }
    }
}

struct cable *cable_create(const char *path, uint64_t seed)
{
    struct cable *c = calloc(1, sizeof *c);

    if (!c)
        return NULL;
    c->box = c->host = c->command = -1;
    c->out.from = c->out.to = c->out.writer = c->out.reader = -1;
    c->in.from = c->in.to = c->in.writer = c->in.reader = -1;
    c->random = seed ? seed : 1;
    (void)snprintf(c->path, sizeof c->path, "%s", path);
    (void)snprintf(c->command_path, sizeof c->command_path, "%.99s.control", path);
    c->listen = listen_at(c->path, SOCK_SEQPACKET);
    c->commands = listen_at(c->command_path, SOCK_STREAM);
    if (c->listen < 0 || c->commands < 0) {
        cable_destroy(c);
        return NULL;
    }
    return c;
}

void cable_destroy(struct cable *c)
{
    if (!c)
        return;
    c->lose_down = true;
    unplug(c);
    shut(&c->box);
    shut(&c->listen);
    shut(&c->commands);
    shut(&c->command);
    (void)unlink(c->path);
    (void)unlink(c->command_path);
    free(c);
}
