/* SPDX-License-Identifier: Apache-2.0 */
/* client.c: lamps whose guardian is another process. */
#include <errno.h>
#include <poll.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include "ttf/base/time.h"
#include "ttf/hal/lampd.h"
#include "ttf/hal/lamps_backend.h"
#include "wire.h"

#define ANSWER_NS \
    (300 * TTF_NS_PER_MS) /* an answer takes a moment; a guardian that hangs is none */

struct lampd_lamps {
    struct ttf_lamps base;
    struct ttf_clock *clock;
    struct sockaddr_un at;
    struct ttf_gate *gate; /* opened when there is something to renew, or to end */
    pthread_t renewer;
    pthread_mutex_t lock; /* of what follows; held over a question and its answer */
    int fd;               /* -1: no guardian */
    uint32_t number;      /* of the last question */
    bool leased, ending;
    int64_t alive_until_ns;
};

static struct lampd_lamps *of(struct ttf_lamps *base)
{
    return (struct lampd_lamps *)base;
}

/* ---- the wire; lock held ---- */

static void hang_up(struct lampd_lamps *l)
{
    if (l->fd >= 0)
        (void)close(l->fd);
    l->fd = -1;
    l->leased = false;
}

/* Never waits: one that hangs takes no more callers at some time, nor what they say. -ENODEV: so it is. */
static int dial(struct lampd_lamps *l)
{
    int r;

    if (l->fd >= 0)
        return 0;
    l->fd = socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    if (l->fd < 0)
        return -errno;
    if (connect(l->fd, (const struct sockaddr *)&l->at, sizeof(l->at)) == 0)
        return 0;
    r = errno == EAGAIN ? -ENODEV : -errno;
    hang_up(l);
    return r;
}

/* -ENODEV: the guardian does not answer, or no more. */
static int hear(struct lampd_lamps *l, struct wire_answer *ret)
{
    int64_t deadline_ns = ttf_clock_now_ns(l->clock) + ANSWER_NS;

    for (;;) {
        struct pollfd fd = {.fd = l->fd, .events = POLLIN};
        int64_t left_ms = (deadline_ns - ttf_clock_now_ns(l->clock)) / TTF_NS_PER_MS;
        int n = poll(&fd, 1, left_ms > 0 ? (int)left_ms : 0);

        if (n < 0 && errno == EINTR)
            continue;
        if (n <= 0 || recv(l->fd, ret, sizeof(*ret), 0) != (ssize_t)sizeof(*ret))
            return -ENODEV;
        if (ret->magic != WIRE_MAGIC)
            return -EPROTO;
        if (ret->number == l->number)
            return 0;
    }
}

static int say(struct lampd_lamps *l, enum wire_op op, unsigned flags, unsigned i,
               unsigned permille)
{
    struct wire_request q = {
        .magic = WIRE_MAGIC,
        .op = (uint16_t)op,
        .flags = (uint16_t)flags,
        .number = ++l->number,
        .lamp = i,
        .permille = permille,
    };

    if (l->fd < 0)
        return -ENODEV;
    return send(l->fd, &q, sizeof(q), MSG_NOSIGNAL) == (ssize_t)sizeof(q) ? 0 : -ENODEV;
}

/* The guardian's answer, or -ENODEV without one. */
static int ask(struct lampd_lamps *l, enum wire_op op, unsigned i, unsigned permille,
               struct wire_answer *ret)
{
    int r = say(l, op, 0, i, permille);

    if (r == 0)
        r = hear(l, ret);
    if (r < 0) {
        hang_up(l);
        return r;
    }
    if (op != WIRE_DOOR && op != WIRE_HELLO && ret->result == -ESTALE)
        l->leased = false;
    return ret->result;
}

/* ---- the renewer ---- */

/* Renews if the client's sign of life is not overdue; when to look again. */
static int64_t renew(struct lampd_lamps *l)
{
    int64_t now_ns = ttf_clock_now_ns(l->clock);

    if (!l->leased)
        return TTF_NS_NEVER;
    if (now_ns >= l->alive_until_ns) {
        l->leased = false; /* the client hangs: let the lease lapse */
        return TTF_NS_NEVER;
    }
    if (say(l, WIRE_RENEW, WIRE_SILENT, 0, 0) < 0)
        hang_up(l);
    return now_ns + TTF_LEASE_RENEW_NS;
}

static void *renewer(void *arg)
{
    struct lampd_lamps *l = arg;
    int64_t due_ns = TTF_NS_NEVER;
    bool ending = false;

    while (!ending) {
        int why = ttf_gate_wait(l->gate, due_ns);

        (void)why; /* opened or due: it looks either way */
        pthread_mutex_lock(&l->lock);
        ending = l->ending;
        due_ns = ending ? TTF_NS_NEVER : renew(l);
        pthread_mutex_unlock(&l->lock);
    }
    ttf_clock_leave(l->clock);
    return NULL;
}

/* ---- operations ---- */

static int no_guardian(const struct lampd_lamps *l, int code, struct ttf_err *err)
{
    ttf_err_set(err, code, l->at.sun_path, "the lamp guardian does not answer");
    ttf_err_hint(err, "is ttfbox-lampd running?");
    return code;
}

static int lampd_acquire(struct ttf_lamps *base, int64_t alive_until_ns, struct ttf_err *err)
{
    struct lampd_lamps *l = of(base);
    struct wire_answer a;
    int r;

    pthread_mutex_lock(&l->lock);
    r = dial(l);
    r = r < 0 ? -ENODEV : ask(l, WIRE_ACQUIRE, 0, 0, &a);
    if (r == 0) {
        l->leased = true;
        l->alive_until_ns = alive_until_ns;
    }
    pthread_mutex_unlock(&l->lock);
    if (r == 0)
        ttf_gate_open(l->gate);
    if (r == -EBUSY)
        return ttf_err_set(err, r, "lamps", "another client holds the lamps' lease");
    return r < 0 ? no_guardian(l, r, err) : 0;
}

static int lampd_alive(struct ttf_lamps *base, int64_t alive_until_ns, struct ttf_err *err)
{
    struct lampd_lamps *l = of(base);
    struct wire_answer a;
    int r;

    pthread_mutex_lock(&l->lock);
    r = l->leased ? ask(l, WIRE_RENEW, 0, 0, &a) : -ESTALE;
    if (r == 0)
        l->alive_until_ns = alive_until_ns;
    pthread_mutex_unlock(&l->lock);
    if (r == 0)
        ttf_gate_open(l->gate);
    if (r == -ENODEV)
        return no_guardian(l, -ESTALE, err);
    return r < 0 ? ttf_err_set(err, r, "lamps", "the lease has lapsed; acquire it again") : 0;
}

static int lampd_set(struct ttf_lamps *base, unsigned i, unsigned permille, struct ttf_err *err)
{
    struct lampd_lamps *l = of(base);
    const char *name = base->info[i].name;
    struct wire_answer a;
    int r;

    pthread_mutex_lock(&l->lock);
    (void)dial(l); /* off needs no lease */
    r = permille > 0 && !l->leased ? -ESTALE : ask(l, WIRE_SET, i, permille, &a);
    if (r < 0 && permille > 0 && l->fd < 0)
        r = -ESTALE; /* no guardian, no lease; -ENODEV is its word for a line that is gone */
    pthread_mutex_unlock(&l->lock);
    switch (r) {
    case 0:
        return 0;
    case -EPERM:
        return ttf_err_set(err, r, name, "the guardian keeps the lamp dark: %s",
                           ttf_lamp_trip_name(a.state.trip));
    case -ESTALE:
        return ttf_err_set(err, r, name, "no lease is held on the lamps");
    case -ENODEV:
        return ttf_err_set(err, r, name, "the guardian does not answer, or its line is gone");
    default:
        return ttf_err_set(err, r, name, "the guardian refuses");
    }
}

static int lampd_state(struct ttf_lamps *base, unsigned i, struct ttf_lamp_state *ret)
{
    struct lampd_lamps *l = of(base);
    struct wire_answer a;
    int r;

    pthread_mutex_lock(&l->lock);
    (void)dial(l);
    r = ask(l, WIRE_STATE, i, 0, &a);
    pthread_mutex_unlock(&l->lock);
    if (r == 0)
        *ret = a.state;
    return r;
}

static int lampd_clear(struct ttf_lamps *base, unsigned i, struct ttf_err *err)
{
    struct lampd_lamps *l = of(base);
    struct wire_answer a;
    int r;

    pthread_mutex_lock(&l->lock);
    (void)dial(l);
    r = ask(l, WIRE_CLEAR, i, 0, &a);
    pthread_mutex_unlock(&l->lock);
    if (r == -ENODEV)
        return no_guardian(l, r, err);
    return r < 0 ? ttf_err_set(err, r, base->info[i].name, "the trip's cause persists") : 0;
}

static void lampd_release(struct ttf_lamps *base)
{
    struct lampd_lamps *l = of(base);
    struct wire_answer a;

    pthread_mutex_lock(&l->lock);
    if (l->fd >= 0)
        (void)ask(l, WIRE_RELEASE, 0, 0,
                  &a); /* unheard: the guardian is gone, or lets the lease lapse */
    l->leased = false;
    pthread_mutex_unlock(&l->lock);
}

static void free_lamps(struct lampd_lamps *l)
{
    hang_up(l);
    ttf_gate_destroy(l->gate);
    pthread_mutex_destroy(&l->lock);
    free(l);
}

static void lampd_destroy(struct ttf_lamps *base)
{
    struct lampd_lamps *l = of(base);

    pthread_mutex_lock(&l->lock);
    l->ending = true;
    pthread_mutex_unlock(&l->lock);
    ttf_gate_open(l->gate);
    pthread_join(l->renewer, NULL);
    free_lamps(l);
}

static const struct ttf_lamps_ops OPS = {
    .name = "lampd",
    .acquire = lampd_acquire,
    .alive = lampd_alive,
    .set = lampd_set,
    .state = lampd_state,
    .clear = lampd_clear,
    .release = lampd_release,
    .destroy = lampd_destroy,
};

/* What the lamps are. */
static int learn(struct lampd_lamps *l, struct ttf_err *err)
{
    struct wire_answer a;
    int r = dial(l);

    if (r < 0)
        return no_guardian(l, r, err);
    r = ask(l, WIRE_HELLO, 0, 0, &a);
    if (r == 0 && a.n_lamps > TTF_LAMPS_MAX)
        r = -EPROTO;
    l->base.n = r == 0 ? a.n_lamps : 0;
    for (unsigned i = 0; i < l->base.n && r == 0; i++) {
        r = ask(l, WIRE_INFO, i, 0, &a);
        l->base.info[i] = a.info;
        l->base.info[i].name[sizeof(a.info.name) - 1] = '\0';
    }
    return r < 0 ? no_guardian(l, r, err) : 0;
}

static int start(struct lampd_lamps *l, struct ttf_err *err)
{
    int r;

    l->gate = ttf_gate_create(l->clock);
    if (!l->gate)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory");
    r = learn(l, err);
    if (r < 0)
        return r;
    ttf_clock_join_for(l->clock);
    r = pthread_create(&l->renewer, NULL, renewer, l);
    if (r == 0)
        return 0;
    ttf_clock_leave(l->clock);
    return ttf_err_set(err, -r, NULL, "no thread to renew the lamps' lease");
}

int ttf_lamps_lampd_create(const char *socket, struct ttf_clock *clock, struct ttf_lamps **ret,
                           struct ttf_err *err)
{
    struct lampd_lamps *l;
    int r;

    if (strlen(socket) >= sizeof(l->at.sun_path))
        return ttf_err_set(err, -ENAMETOOLONG, socket, "is too long for a socket's path");
    l = calloc(1, sizeof(*l));
    if (!l)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory");
    pthread_mutex_init(&l->lock, NULL);
    l->base.ops = &OPS;
    l->clock = clock;
    l->fd = -1;
    l->at.sun_family = AF_UNIX;
    memcpy(l->at.sun_path, socket, strlen(socket) + 1);
    r = start(l, err);
    if (r < 0) {
        free_lamps(l);
        return r;
    }
    *ret = &l->base;
    return 0;
}

int ttf_lamps_lampd_door(struct ttf_lamps *base, struct ttf_door_past *ret_past)
{
    struct lampd_lamps *l = of(base);
    struct wire_answer a;
    int r;

    if (base->ops != &OPS)
        return -ENOTSUP;
    pthread_mutex_lock(&l->lock);
    (void)dial(l);
    r = ask(l, WIRE_DOOR, 0, 0, &a);
    pthread_mutex_unlock(&l->lock);
    if (r >= 0 && ret_past)
        *ret_past = (struct ttf_door_past){a.door_opened_ns, a.door_closed_ns};
    return r;
}
