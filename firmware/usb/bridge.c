/* SPDX-License-Identifier: Apache-2.0 */
/* bridge.c: the loop: what happens to the link, what happens to sockets, what is to be sent. */
#include "ttf/usb/bridge.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/random.h>
#include <sys/socket.h>

#include "joints.h"
#include "ttf/base/time.h"

#define HELLO_NS      (300 * TTF_NS_PER_MS) /* of PROTOCOL.md: then another reset, with twice as long */
#define HELLO_MOST_NS (2400 * TTF_NS_PER_MS)
#define AGAIN_NS \
    (100 * TTF_NS_PER_MS)             /* between looking for a box, and after a reset that failed */
#define SUSPEND_NS (3 * TTF_NS_PER_S) /* asleep for longer: streams are over */
#define TELL_NS    TTF_NS_PER_S
#define LOOK_MS    250 /* how soon stop is seen */
#define EVENTS_MAX 16  /* of the link, before sockets have their turn */
#define FDS_MAX    (TTF_USB_FDS + 1 + TTF_MUX_STREAMS)

enum phase {
    AWAY = 0,
    ASKING, /* of a host: the control request is under way */
    WAITING /* transfers may be sent; the other side's HELLO has come, or is to come by hello_ns */
};

struct bridge {
    const struct ttf_usb_bridge_config *config;
    struct ttf_usb_link *link;
    struct ttf_mux *mux;
    struct usb_joints joints;
    enum phase phase;
    int away_why;        /* the last error */
    int64_t again_ns;    /* of a host: when to look for a box, or to reset, again */
    int64_t patience_ns; /* of a host: how long to wait for HELLO, longer each time */
    int64_t hello_ns;    /* of a host: when to have heard HELLO */
    int64_t asleep_ns;   /* of a box: when streams are over; 0: awake */
    int64_t told_ns;
    enum ttf_usb_bridge_state told;
    bool more; /* the link may have more events */
};

static bool is_host(const struct bridge *b)
{
    return b->config->role == TTF_MUX_HOST;
}

/* ---- resets ---- */

static void away(struct bridge *b, int why, int64_t now)
{
    ttf_mux_reset(b->mux, 0);
    b->phase = AWAY;
    b->away_why = why;
    b->again_ns = now + AGAIN_NS;
    b->asleep_ns = 0;
}

/* Of a host: begins from nothing. The nonce is known before the box can answer by it. */
static void ask_reset(struct bridge *b, int64_t now)
{
    uint64_t nonce = 0;
    int r;

    while (nonce == 0)
        if (getrandom(&nonce, sizeof nonce, 0) != (ssize_t)sizeof nonce)
            nonce = (uint64_t)now; /* no attack is warded off by it, only old bytes */
    b->link->ops->drop(b->link);
    ttf_mux_reset(b->mux, nonce);
    r = b->link->ops->reset(b->link, nonce);
    if (r == 0 || r == -EALREADY) {
        b->phase = ASKING;
        b->again_ns = now + 3 * TTF_NS_PER_S; /* in case that nothing comes of it */
    } else {
        b->link->ops->close(b->link);
        away(b, r, now);
    }
}

/* Of a box: all streams over, and what the host hears first is `nonce`. */
static void begin(struct bridge *b, uint64_t nonce)
{
    b->link->ops->drop(b->link);
    ttf_mux_reset(b->mux, nonce);
    b->phase = WAITING;
    b->asleep_ns = 0;
}

/* ---- what happens to the link ---- */

static void on_reset(struct bridge *b, const struct ttf_usb_event *e, int64_t now)
{
    if (!is_host(b)) {
        begin(b, e->nonce);
    } else if (e->error == 0 && b->phase == ASKING) {
        b->phase = WAITING;
        b->hello_ns = now + b->patience_ns;
    } else if (b->phase == ASKING) {
        b->again_ns = now + AGAIN_NS;
    }
}

static int on_transfer(struct bridge *b, const struct ttf_usb_event *e, int64_t now)
{
    int r = ttf_mux_take(b->mux, e->data, e->n);

    usb_joints_follow(&b->joints, now);
    if (r == 0 || r == -ENOMEM)
        return r;
    if (r == -EPROTONOSUPPORT)
        return is_host(b) ? r : 0;
    if (is_host(b))
        ask_reset(b, now);
    else
        begin(b, 0); /* the host is to know */
    return 0;
}

static int on_event(struct bridge *b, const struct ttf_usb_event *e, int64_t now)
{
    int r = 0;

    switch (e->kind) {
    case TTF_USB_UP:
        if (is_host(b))
            ask_reset(b, now);
        else
            begin(b, 0);
        break;
    case TTF_USB_DOWN:
        if (is_host(b))
            b->link->ops->close(b->link);
        away(b, e->error, now);
        break;
    case TTF_USB_SUSPEND:
        if (b->asleep_ns == 0 && b->phase != AWAY) /* what is away has no streams to end */
            b->asleep_ns = now + SUSPEND_NS;
        break;
    case TTF_USB_RESUME:
        b->asleep_ns = 0;
        break;
    case TTF_USB_RESET:
        on_reset(b, e, now);
        break;
    case TTF_USB_CAME:
        r = on_transfer(b, e, now);
        break;
    case TTF_USB_NOTHING:
        break;
    }
    usb_joints_follow(&b->joints, now);
    return r;
}

static int take_events(struct bridge *b, int64_t now)
{
    b->more = true;
    for (unsigned i = 0; i < EVENTS_MAX; i++) {
        struct ttf_usb_event e;
        int r;

        b->link->ops->next(b->link, &e);
        if (e.kind == TTF_USB_NOTHING) {
            b->more = false;
            return 0;
        }
        r = on_event(b, &e, now);
        if (r < 0)
            return r;
    }
    return 0;
}

static void give_transfers(struct bridge *b, int64_t now)
{
    uint8_t *buffer;

    if (b->phase != WAITING)
        return;
    while (ttf_mux_has_transfer(b->mux) && (buffer = b->link->ops->buffer(b->link))) {
        b->link->ops->send(b->link, ttf_mux_give(b->mux, buffer));
        usb_joints_follow(&b->joints, now);
    }
}

/* ---- what time asks for ---- */

/* Of a host: looks for a box, or resets again. Returns when it has to be called again. */
static int64_t host_time(struct bridge *b, int64_t now)
{
    bool silent = b->phase == WAITING && !ttf_mux_is_ready(b->mux) && now >= b->hello_ns;

    if (silent && b->patience_ns < HELLO_MOST_NS)
        b->patience_ns *= 2; /* a busy machine would never be in time otherwise */
    if (b->phase == WAITING && ttf_mux_is_ready(b->mux))
        b->patience_ns = HELLO_NS;
    if (b->phase == AWAY && now >= b->again_ns) {
        struct ttf_err err = {0};
        int r = b->link->ops->open(b->link, &err);

        if (r < 0)
            away(b, r, now);
        else
            ask_reset(b, now);
    } else if (silent || (b->phase == ASKING && now >= b->again_ns)) {
        ask_reset(b, now);
    }
    if (b->phase == WAITING)
        return ttf_mux_is_ready(b->mux) ? TTF_NS_NEVER : b->hello_ns;
    return b->again_ns;
}

static int64_t box_time(struct bridge *b, int64_t now)
{
    if (b->asleep_ns != 0 && now >= b->asleep_ns)
        begin(b, 0); /* if it was no pulled cable, the host learns it when it wakes the bus */
    usb_joints_follow(&b->joints, now);
    if (usb_joints_are_calling(&b->joints))
        return now + 10 * TTF_NS_PER_MS;
    return b->asleep_ns ? b->asleep_ns : TTF_NS_NEVER;
}

static void tell(struct bridge *b, int64_t now)
{
    enum ttf_usb_bridge_state state = b->phase == AWAY           ? TTF_USB_BRIDGE_AWAY
                                      : ttf_mux_is_ready(b->mux) ? TTF_USB_BRIDGE_READY
                                                                 : TTF_USB_BRIDGE_RESETTING;

    if (state == b->told && now < b->told_ns + TELL_NS)
        return;
    b->told = state;
    b->told_ns = now;
    if (b->config->tell)
        b->config->tell(b->config->tell_ctx, state, state == TTF_USB_BRIDGE_AWAY ? b->away_why : 0);
}

/* ---- the loop ---- */

static void accept_clients(struct bridge *b, int64_t now)
{
    int fd = accept4(b->config->listen_fd, NULL, NULL, SOCK_CLOEXEC | SOCK_NONBLOCK);

    if (fd >= 0)
        usb_joints_add(&b->joints, fd);
    usb_joints_follow(&b->joints, now);
}

/* A client waits in the socket's queue while there is no box, or no stream for it. */
static bool takes_clients(const struct bridge *b)
{
    if (!is_host(b) || !ttf_mux_is_ready(b->mux))
        return false;
    for (unsigned i = 0; i < TTF_MUX_STREAMS; i++)
        if (b->joints.joint[i].state == USB_JOINT_NONE)
            return true;
    return false;
}

static int wait_ms(const struct bridge *b, int64_t until, int64_t now)
{
    int64_t ms = until <= now ? 0 : (until - now) / TTF_NS_PER_MS + 1;

    if (b->more)
        return 0;
    return ms < LOOK_MS ? (int)ms : LOOK_MS;
}

static int step(struct bridge *b, int64_t until)
{
    struct pollfd fds[FDS_MAX];
    uint8_t which[TTF_MUX_STREAMS];
    bool accepts = takes_clients(b);
    unsigned n = b->link->ops->fds(b->link, fds), first, of_joints;
    int64_t now = ttf_clock_now_ns(b->config->clock);
    int r = 0;

    if (accepts)
        fds[n++] = (struct pollfd){.fd = b->config->listen_fd, .events = POLLIN};
    first = n;
    of_joints = usb_joints_fds(&b->joints, fds + first, which);
    if (poll(fds, first + of_joints, wait_ms(b, until, now)) < 0)
        return errno == EINTR ? 0 : -errno;
    now = ttf_clock_now_ns(b->config->clock);
    r = take_events(b, now);
    for (unsigned i = 0; r == 0 && i < of_joints; i++)
        if (fds[first + i].revents)
            r = usb_joints_ready(&b->joints, which[i], fds[first + i].revents);
    if (r == 0 && accepts && fds[first - 1].revents && takes_clients(b))
        accept_clients(b, now);
    give_transfers(b, now);
    return r;
}

static int run(struct bridge *b)
{
    int64_t until = 0;
    int r = 0;

    while (r == 0 && !(b->config->stop && *b->config->stop)) {
        int64_t now;

        r = step(b, until);
        now = ttf_clock_now_ns(b->config->clock);
        until = is_host(b) ? host_time(b, now) : box_time(b, now);
        give_transfers(b, now);
        tell(b, now);
    }
    return r;
}

int ttf_usb_bridge_run(const struct ttf_usb_bridge_config *config, struct ttf_err *err)
{
    struct bridge *b = calloc(1, sizeof *b);
    int r;

    if (!b)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory");
    b->config = config;
    b->link = config->link;
    b->patience_ns = HELLO_NS;
    b->told = TTF_USB_BRIDGE_READY; /* whatever it is, it is told */
    r = ttf_mux_create(config->role, &b->mux);
    if (r == 0) {
        usb_joints_init(&b->joints, b->mux, config->server);
        away(b, -ENODEV, 0);
        b->again_ns = 0;
        if (!is_host(b))
            r = b->link->ops->open(b->link, err);
        if (r == 0)
            r = run(b);
        usb_joints_close(&b->joints);
        b->link->ops->close(b->link);
    }
    ttf_mux_destroy(b->mux);
    free(b);
    if (r == -EPROTONOSUPPORT)
        return ttf_err_set(err, r, "USB", "the box speaks another version of the protocol");
    if (r < 0 && (!err || err->code != r)) /* not told yet */
        ttf_err_set(err, r, "USB", "failed: %s", strerrordesc_np(-r));
    return r;
}
