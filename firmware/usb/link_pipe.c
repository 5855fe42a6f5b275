/* SPDX-License-Identifier: Apache-2.0 */
/* link_pipe.c: either end of a simulated cable (PIPE.md). */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include "pipe.h"
#include "ttf/usb/link.h"

struct pipe_link {
    struct ttf_usb_link base;
    char path[108];
    bool box, up, resetting;
    int control, in, out; /* -1: none */
    uint8_t incoming[TTF_USB_TRANSFER];
    uint8_t rest[TTF_USB_TRANSFER];
    size_t n_incoming, n_rest;
    bool delivered; /* what is in incoming was handed out */
    uint8_t queue[TTF_USB_DEPTH][TTF_USB_TRANSFER];
    size_t length[TTF_USB_DEPTH];
    unsigned first, queued;
};

static struct pipe_link *of(struct ttf_usb_link *link)
{
    return (struct pipe_link *)link;
}

static void close_fd(int *fd)
{
    if (*fd >= 0)
        (void)close(*fd);
    *fd = -1;
}

static void close_data(struct pipe_link *l)
{
    close_fd(&l->in);
    close_fd(&l->out);
    l->up = false;
    l->n_incoming = l->n_rest = 0;
    l->queued = 0;
    l->delivered = l->resetting = false;
}

static int tell(int fd, enum usb_pipe_kind kind, uint64_t nonce)
{
    struct usb_pipe_message m = {.kind = kind, .nonce = nonce};

    return send(fd, &m, sizeof m, MSG_NOSIGNAL) == (ssize_t)sizeof m ? 0 : -errno;
}

static int connect_cable(const char *path, enum usb_pipe_kind who, struct ttf_err *err)
{
    struct sockaddr_un at = {.sun_family = AF_UNIX};
    int fd = socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0), r;

    if (fd < 0)
        return ttf_err_set(err, -errno, path, "no socket: %s", strerrordesc_np(errno));
    (void)snprintf(at.sun_path, sizeof at.sun_path, "%s", path);
    if (connect(fd, (struct sockaddr *)&at, sizeof at) == 0 && tell(fd, who, 0) == 0)
        return fd;
    r = -errno;
    (void)close(fd);
    ttf_err_set(err, -ENODEV, path, "no cable is here: %s", strerrordesc_np(-r));
    return -ENODEV;
}

int ttf_usb_pipe_connect(const char *path, struct ttf_err *err)
{
    return connect_cable(path, USB_PIPE_BOX, err);
}

/* A message of the cable, with the descriptors that came along. 1; 0: none now; -errno, -EPIPE: the cable is gone. */
static int hear(struct pipe_link *l, int flags, struct usb_pipe_message *ret, int fds[2])
{
    union {
        struct cmsghdr align;
        char bytes[CMSG_SPACE(2 * sizeof(int))];
    } control;
    struct iovec part = {ret, sizeof *ret};
    struct msghdr message = {.msg_iov = &part,
                             .msg_iovlen = 1,
                             .msg_control = control.bytes,
                             .msg_controllen = sizeof control.bytes};
    ssize_t n = recvmsg(l->control, &message, flags | MSG_CMSG_CLOEXEC);
    struct cmsghdr *c;

    fds[0] = fds[1] = -1;
    if (n < 0)
        return errno == EAGAIN || errno == EINTR ? 0 : -errno;
    if (n != (ssize_t)sizeof *ret)
        return -EPIPE;
    c = CMSG_FIRSTHDR(&message);
    if (c && c->cmsg_level == SOL_SOCKET && c->cmsg_type == SCM_RIGHTS &&
        c->cmsg_len == CMSG_LEN(2 * sizeof(int)))
        memcpy(fds, CMSG_DATA(c), 2 * sizeof(int));
    return 1;
}

static void take_fds(struct pipe_link *l, const int fds[2])
{
    close_data(l);
    l->in = fds[0];
    l->out = fds[1];
    l->up = l->in >= 0 && l->out >= 0;
}

static int pipe_open(struct ttf_usb_link *link, struct ttf_err *err)
{
    struct pipe_link *l = of(link);

    if (l->control >= 0)
        return 0;
    l->control = connect_cable(l->path, l->box ? USB_PIPE_BOX : USB_PIPE_HOST, err);
    if (l->control < 0)
        return -ENODEV;
    if (l->box)
        return 0;
    /* The cable answers a host at once: this waits for nobody. */
    struct usb_pipe_message m = {.kind = 0};
    int fds[2], r = hear(l, 0, &m, fds);

    if (r == 1 && m.kind == USB_PIPE_UP && fds[0] >= 0) {
        take_fds(l, fds);
        return 0;
    }
    close_fd(&l->control);
    if (m.kind == USB_PIPE_BUSY)
        return ttf_err_set(err, -EBUSY, l->path, "another program has this box");
    return ttf_err_set(err, -ENODEV, l->path, "no box is plugged in");
}

static void pipe_close(struct ttf_usb_link *link)
{
    close_data(of(link));
    close_fd(&of(link)->control);
}

static unsigned pipe_fds(struct ttf_usb_link *link, struct pollfd *ret)
{
    struct pipe_link *l = of(link);
    unsigned n = 0;

    if (l->control >= 0)
        ret[n++] = (struct pollfd){.fd = l->control, .events = POLLIN};
    if (l->in >= 0)
        ret[n++] = (struct pollfd){.fd = l->in, .events = POLLIN};
    if (l->out >= 0 && l->queued > 0)
        ret[n++] = (struct pollfd){.fd = l->out, .events = POLLOUT};
    return n;
}

static struct ttf_usb_event down(struct pipe_link *l, int error)
{
    close_data(l);
    if (!l->box)
        close_fd(&l->control);
    return (struct ttf_usb_event){.kind = TTF_USB_DOWN, .error = error};
}

/* What a message of the cable means. */
static struct ttf_usb_event happened(struct pipe_link *l, const struct usb_pipe_message *m,
                                     const int fds[2])
{
    switch (m->kind) {
    case USB_PIPE_UP:
        take_fds(l, fds);
        return (struct ttf_usb_event){.kind = TTF_USB_UP};
    case USB_PIPE_DOWN:
        return down(l, -ESHUTDOWN);
    case USB_PIPE_SUSPEND:
        return (struct ttf_usb_event){.kind = TTF_USB_SUSPEND};
    case USB_PIPE_RESUME:
        return (struct ttf_usb_event){.kind = TTF_USB_RESUME};
    case USB_PIPE_RESET:
        (void)tell(l->control, USB_PIPE_ANSWER, m->nonce);
        return (struct ttf_usb_event){.kind = TTF_USB_RESET, .nonce = m->nonce};
    case USB_PIPE_ANSWER:
    case USB_PIPE_FAILED:
        l->resetting = false;
        return (struct ttf_usb_event){.kind = TTF_USB_RESET,
                                      .error = m->kind == USB_PIPE_ANSWER ? 0 : -ETIMEDOUT};
    default:
        return (struct ttf_usb_event){.kind = TTF_USB_NOTHING};
    }
}

static void write_queued(struct pipe_link *l)
{
    while (l->queued > 0 && l->out >= 0) {
        if (send(l->out, l->queue[l->first], l->length[l->first], MSG_DONTWAIT | MSG_NOSIGNAL) < 0)
            return; /* full; or unplugged, as the control connection will say */
        l->first = (l->first + 1) % TTF_USB_DEPTH;
        l->queued--;
    }
}

/* What of a piece found no room in the transfer before. Is there any? */
static bool take_rest(struct pipe_link *l)
{
    if (l->n_rest == 0)
        return false;
    memcpy(l->incoming, l->rest, l->n_rest);
    l->n_incoming = l->n_rest;
    l->n_rest = 0;
    return true;
}

/* One more piece behind what there is: its length; 0: there is none now. */
static size_t read_piece(struct pipe_link *l)
{
    size_t room = TTF_USB_TRANSFER - l->n_incoming;
    uint8_t *at = l->n_incoming > 0 ? l->rest : l->incoming;
    ssize_t n = recv(l->in, at, TTF_USB_TRANSFER, MSG_DONTWAIT);

    if (n <= 0)
        return 0;
    if (l->n_incoming > 0) { /* behind a transfer that was cut off: it may not fit in whole */
        size_t fits = (size_t)n < room ? (size_t)n : room;

        memcpy(l->incoming + l->n_incoming, l->rest, fits);
        l->n_rest = (size_t)n - fits;
        memmove(l->rest, l->rest + fits, l->n_rest);
        l->n_incoming += fits;
    } else {
        l->n_incoming = (size_t)n;
    }
    return (size_t)n;
}

/* Pieces until one is a transfer's last, or the buffer is full. Is there a transfer? */
static bool read_transfer(struct pipe_link *l)
{
    if (l->delivered)
        l->n_incoming = 0;
    l->delivered = false;
    if (l->n_incoming == 0 && take_rest(l) && l->n_incoming % USB_PIPE_PACKET != 0)
        return true;
    while (l->in >= 0 && l->n_incoming < TTF_USB_TRANSFER) {
        size_t n = read_piece(l);

        if (n == 0)
            return false;
        if (n % USB_PIPE_PACKET != 0)
            break;
    }
    return l->n_incoming > 0;
}

static void pipe_next(struct ttf_usb_link *link, struct ttf_usb_event *ret)
{
    struct pipe_link *l = of(link);
    struct usb_pipe_message m;
    int fds[2], r;

    *ret = (struct ttf_usb_event){.kind = TTF_USB_NOTHING};
    /* First: a reset is heard of before what comes behind it. */
    if (l->control >= 0 && (r = hear(l, MSG_DONTWAIT, &m, fds)) != 0) {
        if (r < 0 && l->box)
            close_fd(&l->control);
        *ret = r < 0 ? down(l, -ENODEV) : happened(l, &m, fds);
        if (ret->kind != TTF_USB_NOTHING)
            return;
    }
    if (!l->up)
        return;
    write_queued(l);
    if (read_transfer(l)) {
        l->delivered = true;
        *ret =
            (struct ttf_usb_event){.kind = TTF_USB_CAME, .data = l->incoming, .n = l->n_incoming};
    }
}

static uint8_t *pipe_buffer(struct ttf_usb_link *link)
{
    struct pipe_link *l = of(link);

    return l->up && l->queued < TTF_USB_DEPTH ? l->queue[(l->first + l->queued) % TTF_USB_DEPTH]
                                              : NULL;
}

static void pipe_send(struct ttf_usb_link *link, size_t n)
{
    struct pipe_link *l = of(link);

    l->length[(l->first + l->queued++) % TTF_USB_DEPTH] = n;
    write_queued(l);
}

static void pipe_drop(struct ttf_usb_link *link)
{
    of(link)->queued = 0;
}

static int pipe_reset(struct ttf_usb_link *link, uint64_t nonce)
{
    struct pipe_link *l = of(link);

    if (l->resetting)
        return -EALREADY;
    if (l->control < 0 || tell(l->control, USB_PIPE_RESET, nonce) < 0)
        return -ENODEV;
    l->resetting = true;
    return 0;
}

static void pipe_destroy(struct ttf_usb_link *link)
{
    pipe_close(link);
    free(link);
}

static const struct ttf_usb_link_ops OPS = {.name = "pipe",
                                            .open = pipe_open,
                                            .fds = pipe_fds,
                                            .next = pipe_next,
                                            .buffer = pipe_buffer,
                                            .send = pipe_send,
                                            .drop = pipe_drop,
                                            .reset = pipe_reset,
                                            .close = pipe_close,
                                            .destroy = pipe_destroy};

int ttf_usb_pipe_create(const char *path, bool box, int fd, struct ttf_usb_link **ret,
                        struct ttf_err *err)
{
    struct pipe_link *l;

    if (strlen(path) >= sizeof l->path)
        return ttf_err_set(err, -EINVAL, path, "is too long for a socket's path");
    l = calloc(1, sizeof *l);
    if (!l)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory");
    l->base.ops = &OPS;
    (void)snprintf(l->path, sizeof l->path, "%s", path);
    l->box = box;
    l->control = fd;
    l->in = l->out = -1;
    if (fd >= 0)
        (void)tell(fd, USB_PIPE_BOX, 0);
    *ret = &l->base;
    return 0;
}
