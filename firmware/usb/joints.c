/* SPDX-License-Identifier: Apache-2.0 */
#include "joints.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include "ttf/base/time.h"

#define CALL_NS (2 * TTF_NS_PER_S) /* how long a server may have no room for a connection */

void usb_joints_init(struct usb_joints *joints, struct ttf_mux *mux, const char *server)
{
    memset(joints, 0, sizeof *joints);
    joints->mux = mux;
    joints->server = server;
    for (unsigned i = 0; i < TTF_MUX_STREAMS; i++)
        joints->joint[i].fd = -1;
}

static void leave(struct usb_joint *j, enum usb_joint_state state)
{
    if (j->fd >= 0)
        (void)close(j->fd);
    *j = (struct usb_joint){.state = state, .fd = -1, .life = j->life};
}

/* The socket is done with, whatever the stream still has. */
static void break_off(struct usb_joints *joints, unsigned id, enum ttf_mux_reason reason)
{
    ttf_mux_end(joints->mux, id, reason);
    leave(&joints->joint[id - 1], USB_JOINT_LEFT);
}

static void join(struct usb_joint *j, int fd)
{
    leave(j, USB_JOINT_JOINED);
    j->fd = fd;
}

/* To the server. A UNIX socket connects at once, or has no room, or nobody is there. */
static void call(struct usb_joints *joints, unsigned id, int64_t now_ns)
{
    struct usb_joint *j = &joints->joint[id - 1];
    struct sockaddr_un at = {.sun_family = AF_UNIX};
    int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);

    if (j->state == USB_JOINT_NONE)
        j->call_until_ns = now_ns + CALL_NS;
    (void)snprintf(at.sun_path, sizeof at.sun_path, "%s", joints->server);
    if (fd >= 0 && connect(fd, (struct sockaddr *)&at, sizeof at) == 0) {
        join(j, fd);
        return;
    }
    bool full = fd >= 0 && errno == EAGAIN && now_ns < j->call_until_ns;

    if (fd >= 0)
        (void)close(fd);
    if (full)
        j->state = USB_JOINT_CALLING;
    else
        break_off(joints, id, TTF_MUX_REFUSED);
}

void usb_joints_add(struct usb_joints *joints, int fd)
{
    int id = ttf_mux_open(joints->mux);

    if (id < 0) {
        (void)close(fd);
        return;
    }
    joints->joint[id - 1].life = ttf_mux_look(joints->mux, (unsigned)id).life;
    join(&joints->joint[id - 1], fd);
}

/* What came for the socket. */
static void move_out(struct usb_joints *joints, unsigned id)
{
    struct usb_joint *j = &joints->joint[id - 1];
    const uint8_t *at = NULL;
    size_t n;

    while ((n = ttf_mux_peek(joints->mux, id, &at)) > 0) {
        ssize_t sent =
            j->write_broken ? (ssize_t)n : send(j->fd, at, n, MSG_DONTWAIT | MSG_NOSIGNAL);

        if (sent < 0 && errno == EAGAIN) {
            j->write_waits = true;
            return;
        }
        /* It takes no more; what it has said before is still to be read. */
        if (sent < 0 && errno != EINTR) {
            j->write_broken = true;
            if (j->read_ended) { /* and it has said all */
                break_off(joints, id, TTF_MUX_GONE);
                return;
            }
        }
        if (sent > 0)
            ttf_mux_taken(joints->mux, id, (size_t)sent);
    }
    j->write_waits = false;
}

/* A TCP client learns that bytes are missing by a reset; a UNIX socket knows no such thing. */
static void reset_on_close(int fd)
{
    const struct linger at_once = {.l_onoff = 1, .l_linger = 0};

    (void)setsockopt(fd, SOL_SOCKET, SO_LINGER, &at_once, sizeof at_once);
}

/* Ends that are due once all that came is delivered. */
static void move_ends(struct usb_joints *joints, unsigned id)
{
    struct usb_joint *j = &joints->joint[id - 1];
    struct ttf_mux_view view = ttf_mux_look(joints->mux, id);

    if (j->state != USB_JOINT_JOINED)
        return;
    if (!view.open) {
        leave(j, USB_JOINT_NONE);
    } else if (view.peer_gone && view.readable == 0) {
        if (view.reason != TTF_MUX_GONE)
            reset_on_close(j->fd);
        leave(j, USB_JOINT_LEFT);
    } else if (view.peer_ended && view.readable == 0 && !j->write_ended) {
        (void)shutdown(j->fd, SHUT_WR);
        j->write_ended = true;
    }
}

static void follow_one(struct usb_joints *joints, unsigned id, int64_t now_ns)
{
    struct usb_joint *j = &joints->joint[id - 1];

    if (j->state == USB_JOINT_NONE || j->state == USB_JOINT_CALLING)
        call(joints, id, now_ns);
    if (j->state != USB_JOINT_JOINED)
        return;
    move_out(joints, id);
    move_ends(joints, id);
}

void usb_joints_follow(struct usb_joints *joints, int64_t now_ns)
{
    uint32_t changed = ttf_mux_changed(joints->mux);

    for (unsigned id = 1; id <= TTF_MUX_STREAMS; id++) {
        struct usb_joint *j = &joints->joint[id - 1];
        struct ttf_mux_view view = ttf_mux_look(joints->mux, id);

        if (!(changed & UINT32_C(1) << (id - 1)) && j->state != USB_JOINT_CALLING)
            continue;
        if (!view.open || view.life != j->life) /* what was joined was joined to another stream */
            leave(j, USB_JOINT_NONE);
        j->life = view.life;
        if (view.open)
            follow_one(joints, id, now_ns);
    }
}

unsigned usb_joints_fds(const struct usb_joints *joints, struct pollfd *ret, uint8_t *which)
{
    unsigned n = 0;

    for (unsigned id = 1; id <= TTF_MUX_STREAMS; id++) {
        const struct usb_joint *j = &joints->joint[id - 1];
        short events = 0;

        if (j->state != USB_JOINT_JOINED)
            continue;
        if (!j->read_ended && ttf_mux_look(joints->mux, id).room > 0)
            events = POLLIN;
        if (j->write_waits)
            events |= POLLOUT;
        if (events ==
            0) /* poll would report a hang-up that cannot be acted upon, again and again */
            continue;
        which[n] = (uint8_t)id;
        ret[n++] = (struct pollfd){.fd = j->fd, .events = events};
    }
    return n;
}

/* Nothing more comes from the socket. Of a UNIX socket it is known whether both directions are closed. */
static void end_of_socket(struct usb_joints *joints, unsigned id)
{
    struct usb_joint *j = &joints->joint[id - 1];
    struct pollfd p = {.fd = j->fd};

    j->read_ended = true;
    if ((poll(&p, 1, 0) == 1 && p.revents & POLLHUP) || j->write_broken)
        break_off(joints, id, TTF_MUX_GONE);
    else
        ttf_mux_end(joints->mux, id, TTF_MUX_END);
}

/* A peer that closes with bytes unread resets, behind all that it had sent. */
static int broken(struct usb_joints *joints, unsigned id, int error)
{
    if (error != EAGAIN && error != EINTR)
        break_off(joints, id, TTF_MUX_FAILED);
    return 0;
}

static int move_in(struct usb_joints *joints, unsigned id)
{
    struct usb_joint *j = &joints->joint[id - 1];
    size_t room;

    while ((room = ttf_mux_look(joints->mux, id).room) > 0) {
        ssize_t n = recv(j->fd, joints->buffer,
                         room < sizeof joints->buffer ? room : sizeof joints->buffer, MSG_DONTWAIT);

        if (n < 0)
            return broken(joints, id, errno);
        if (n == 0) {
            end_of_socket(joints, id);
            return 0;
        }
        n = ttf_mux_write(joints->mux, id, joints->buffer, (size_t)n);
        if (n < 0)
            return n == -ENOMEM ? -ENOMEM : 0;
    }
    return 0;
}

int usb_joints_ready(struct usb_joints *joints, unsigned id, short events)
{
    struct usb_joint *j = &joints->joint[id - 1];
    int r = 0;

    if (j->state != USB_JOINT_JOINED)
        return 0;
    if (events & POLLOUT) {
        move_out(joints, id);
        move_ends(joints, id);
    }
    if (j->state == USB_JOINT_JOINED && events & (POLLIN | POLLHUP | POLLERR))
        r = move_in(joints, id);
    return r;
}

bool usb_joints_are_calling(const struct usb_joints *joints)
{
    for (unsigned i = 0; i < TTF_MUX_STREAMS; i++)
        if (joints->joint[i].state == USB_JOINT_CALLING)
            return true;
    return false;
}

void usb_joints_close(struct usb_joints *joints)
{
    for (unsigned i = 0; i < TTF_MUX_STREAMS; i++)
        leave(&joints->joint[i], USB_JOINT_NONE);
}
