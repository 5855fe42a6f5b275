/* SPDX-License-Identifier: Apache-2.0 */
/*
 * link_functionfs.c: a box's end of the cable. ep0 is never read unless something is there: a read that blocks on it would keep the
 * gadget from being unbound for ever. Events get lost, so each of DISABLE, UNBIND and BIND stops the endpoints, each ENABLE starts them
 * anew, and so does an end of I/O (ESHUTDOWN) stop them; and a host's reset, which only a configured box hears, starts what stands.
 *
 * An endpoint that is not enabled shows in one way alone: each I/O is taken, and ends at once with EAGAIN. That is no transfer: who
 * queued again would never sleep.
 */
#include <endian.h>
#include <errno.h>
#include <fcntl.h>
#include <linux/usb/functionfs.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/eventfd.h>

#include "aio.h"
#include "frames.h"
#include "ttf/usb/functionfs.h"
#include "ttf/usb/identity.h"

#define FOLDER_SIZE 240

enum slot_state {
    SLOT_FREE = 0,
    SLOT_QUEUED,
    SLOT_CAME
};

struct slot {
    struct iocb iocb;
    enum slot_state state;
    bool dropped; /* of a write: it was cancelled, and may end as it likes */
    uint8_t *data;
    size_t n;
};

struct functionfs_link {
    struct ttf_usb_link base;
    char folder[FOLDER_SIZE];
    int ep0, in, out, ended; /* ended: an eventfd that says that I/O has */
    bool inherited;          /* it may be bound already, without an event to come */
    aio_context_t aio;       /* 0: none */
    struct slot read[TTF_USB_DEPTH], write[TTF_USB_DEPTH];
    unsigned next_read;
    int handed;
    int broken;  /* -errno of an I/O after which nothing is as it was: to be told; 0 */
    bool worked; /* some I/O went well since the start */
};

static struct functionfs_link *of(struct ttf_usb_link *link)
{
    return (struct functionfs_link *)link;
}

static int open_file(const char *folder, const char *name)
{
    char path[FOLDER_SIZE + 8];
    int fd;

    (void)snprintf(path, sizeof path, "%s/%s", folder, name);
    fd = open(path, O_RDWR | O_NONBLOCK | O_CLOEXEC);
    return fd < 0 ? -errno : fd;
}

static void close_fd(int *fd)
{
    if (*fd >= 0)
        (void)close(*fd);
    *fd = -1;
}

/* ---- descriptors ---- */

static int write_descriptors(int ep0)
{
    /* The version as the specification has it, and as kernels up to 6.1 want it. */
    static const unsigned VERSIONS[] = {0x0100, 0x0001};
    uint8_t data[TTF_USB_DESCRIPTORS_MAX];
    int r = -EINVAL;

    for (unsigned i = 0; r == -EINVAL && i < TTF_COUNT_OF(VERSIONS); i++) {
        size_t n = ttf_usb_functionfs_descriptors(data, VERSIONS[i]);

        r = write(ep0, data, n) < 0 ? -errno : 0;
    }
    if (r == 0)
        r = write(ep0, data, ttf_usb_functionfs_strings(data)) < 0 ? -errno : 0;
    return r;
}

int ttf_usb_functionfs_prepare(const char *folder, struct ttf_err *err)
{
    int fd = open_file(folder, "ep0");
    int r;

    if (fd < 0) {
        ttf_err_set(err, fd, folder, "has no ep0: %s", strerrordesc_np(-fd));
        ttf_err_hint(err, "'ttfbox-gadget compose' makes it");
        return fd;
    }
    r = write_descriptors(fd);
    if (r < 0) {
        (void)close(fd);
        return ttf_err_set(err, r, folder, "the kernel does not take the interface: %s",
                           strerrordesc_np(-r));
    }
    return fd;
}

/* ---- I/O ---- */

static void queue(struct functionfs_link *l, struct slot *s, bool writes, size_t n)
{
    s->iocb = (struct iocb){.aio_lio_opcode = writes ? IOCB_CMD_PWRITE : IOCB_CMD_PREAD,
                            .aio_fildes = (uint32_t)(writes ? l->in : l->out),
                            .aio_buf = (uint64_t)(uintptr_t)s->data,
                            .aio_nbytes = n,
                            .aio_flags = IOCB_FLAG_RESFD,
                            .aio_resfd = (uint32_t)l->ended,
                            .aio_data = writes ? TTF_USB_DEPTH + (uint64_t)(s - l->write)
                                               : (uint64_t)(s - l->read)};
    int r = usb_aio_submit(l->aio, &s->iocb);

    s->dropped = false;
    s->state = r < 0 ? SLOT_FREE : SLOT_QUEUED;
    if (r < 0)
        l->broken = r;
}

static void stop(struct functionfs_link *l)
{
    if (l->aio)
        usb_aio_destroy(l->aio);
    l->aio = 0;
    close_fd(&l->in);
    close_fd(&l->out);
    for (unsigned i = 0; i < TTF_USB_DEPTH; i++)
        l->read[i].state = l->write[i].state = SLOT_FREE;
    l->handed = -1;
    l->broken = 0;
    l->worked = false;
}

/* What an I/O that has ended says of the whole. */
static void judge(struct functionfs_link *l, const struct slot *s, int64_t result)
{
    bool writes = s->iocb.aio_lio_opcode == IOCB_CMD_PWRITE;

    if (result == -ESHUTDOWN || result == -ENODEV || (!writes && result == -EAGAIN))
        l->broken = (int)result;
    else if (writes && !s->dropped && result != (int64_t)s->iocb.aio_nbytes && l->broken == 0)
        l->broken = result < 0 ? (int)result : -EIO; /* bytes are missing inside of streams */
    l->worked = l->worked || result > 0;
}

static void take_ended(struct functionfs_link *l)
{
    struct io_event events[2 * TTF_USB_DEPTH];
    uint64_t count;
    int n;

    if (!l->aio)
        return;
    (void)!read(l->ended, &count, sizeof count);
    n = usb_aio_ended(l->aio, events, (long)TTF_COUNT_OF(events));
    for (int i = 0; i < n; i++) {
        size_t of_all = (size_t)events[i].data;
        struct slot *s =
            of_all < TTF_USB_DEPTH ? &l->read[of_all] : &l->write[of_all - TTF_USB_DEPTH];
        int64_t result = events[i].res;

        judge(l, s, result);
        /* A transfer that came wrong is told as one of no bytes: streams begin anew. */
        s->n = result > 0 ? (size_t)result : 0;
        s->state = s->iocb.aio_lio_opcode == IOCB_CMD_PREAD ? SLOT_CAME : SLOT_FREE;
    }
}

/* -errno: the endpoints are not there, or not enabled (yet). */
static int start(struct functionfs_link *l)
{
    int r;

    stop(l);
    l->in = open_file(l->folder, "ep1");
    l->out = open_file(l->folder, "ep2");
    r = l->in < 0 ? l->in : l->out < 0 ? l->out : usb_aio_setup(4 * TTF_USB_DEPTH, &l->aio);
    if (r < 0) {
        stop(l);
        return r;
    }
    l->next_read = 0;
    for (unsigned i = 0; i < TTF_USB_DEPTH && !l->broken; i++)
        queue(l, &l->read[i], false, TTF_USB_TRANSFER);
    take_ended(l);
    r = l->broken;
    if (r < 0)
        stop(l);
    return r;
}

/* Anew. UP if it is; DOWN if it is not, and was. */
static void restart(struct functionfs_link *l, struct ttf_usb_event *ret)
{
    bool was = l->aio != 0;
    int r = start(l);

    if (r == 0)
        ret->kind = TTF_USB_UP;
    else if (was)
        *ret = (struct ttf_usb_event){.kind = TTF_USB_DOWN, .error = r};
}

/* After an I/O that failed. An endpoint that is still there begins again, so that the host is told; but one that has not worked since
 * it began is left alone, or it would go round and round. */
static void mend(struct functionfs_link *l, struct ttf_usb_event *ret)
{
    int why = l->broken;

    if (l->worked && why != -ESHUTDOWN && why != -ENODEV && why != -EAGAIN) {
        restart(l, ret);
    } else {
        stop(l);
        *ret = (struct ttf_usb_event){.kind = TTF_USB_DOWN, .error = why};
    }
}

/* ---- ep0 ---- */

static void stall(int ep0, const struct usb_ctrlrequest *setup)
{
    uint8_t nothing;

    /* I/O against the direction of the request is how FunctionFS is told. */
    if (setup->bRequestType & USB_DIR_IN)
        (void)!read(ep0, &nothing, 0);
    else
        (void)!write(ep0, &nothing, 0);
}

static struct ttf_usb_event on_setup(struct functionfs_link *l, const struct usb_ctrlrequest *setup)
{
    uint8_t data[TTF_USB_RESET_SIZE];

    if (setup->bRequestType != TTF_USB_RESET_TYPE || setup->bRequest != TTF_USB_RESET_REQUEST ||
        le16toh(setup->wLength) != sizeof data) {
        stall(l->ep0, setup);
    } else if (read(l->ep0, data, sizeof data) == (ssize_t)sizeof data) {
        return (struct ttf_usb_event){.kind = TTF_USB_RESET, .nonce = usb_get64(data)};
    }
    return (struct ttf_usb_event){.kind = TTF_USB_NOTHING};
}

/* One event of ep0. False: there is none. */
static bool hear(struct functionfs_link *l, struct ttf_usb_event *ret)
{
    struct usb_functionfs_event event;

    if (read(l->ep0, &event, sizeof event) != (ssize_t)sizeof event)
        return false;
    switch (event.type) {
    case FUNCTIONFS_ENABLE:
        restart(l, ret);
        break;
    case FUNCTIONFS_BIND:
    case FUNCTIONFS_UNBIND:
    case FUNCTIONFS_DISABLE:
        stop(l);
        *ret = (struct ttf_usb_event){.kind = TTF_USB_DOWN, .error = -ESHUTDOWN};
        break;
    case FUNCTIONFS_SETUP:
        *ret = on_setup(l, &event.u.setup);
        if (ret->kind == TTF_USB_RESET && !l->aio)
            (void)start(l);
        break;
    case FUNCTIONFS_SUSPEND:
        ret->kind = TTF_USB_SUSPEND;
        break;
    case FUNCTIONFS_RESUME:
        ret->kind = TTF_USB_RESUME;
        break;
    default:
        break;
    }
    return true;
}

/* ---- the table ---- */

static int link_open(struct ttf_usb_link *link, struct ttf_err *err)
{
    (void)link;
    (void)err;
    return 0;
}

static unsigned link_fds(struct ttf_usb_link *link, struct pollfd *ret)
{
    ret[0] = (struct pollfd){.fd = of(link)->ep0, .events = POLLIN};
    ret[1] = (struct pollfd){.fd = of(link)->ended, .events = POLLIN};
    return 2;
}

static void link_next(struct ttf_usb_link *link, struct ttf_usb_event *ret)
{
    struct functionfs_link *l = of(link);
    struct slot *s;

    *ret = (struct ttf_usb_event){.kind = TTF_USB_NOTHING};
    if (l->inherited) {
        l->inherited = false;
        restart(l, ret);
    }
    /* First: a reset is heard of before what comes behind it. */
    while (ret->kind == TTF_USB_NOTHING && hear(l, ret))
        ;
    if (ret->kind != TTF_USB_NOTHING || !l->aio)
        return;
    if (l->handed >= 0)
        queue(l, &l->read[l->handed], false, TTF_USB_TRANSFER);
    l->handed = -1;
    take_ended(l);
    s = &l->read[l->next_read];
    if (l->broken) {
        mend(l, ret);
    } else if (s->state == SLOT_CAME) {
        s->state = SLOT_FREE;
        l->handed = (int)l->next_read;
        l->next_read = (l->next_read + 1) % TTF_USB_DEPTH;
        *ret = (struct ttf_usb_event){.kind = TTF_USB_CAME, .data = s->data, .n = s->n};
    }
}

static struct slot *free_slot(struct functionfs_link *l)
{
    for (unsigned i = 0; l->aio && !l->broken && i < TTF_USB_DEPTH; i++)
        if (l->write[i].state == SLOT_FREE)
            return &l->write[i];
    return NULL;
}

static uint8_t *link_buffer(struct ttf_usb_link *link)
{
    struct slot *s = free_slot(of(link));

    return s ? s->data : NULL;
}

static void link_send(struct ttf_usb_link *link, size_t n)
{
    struct slot *s = free_slot(of(link));

    if (s)
        queue(of(link), s, true, n);
}

static void link_drop(struct ttf_usb_link *link)
{
    struct functionfs_link *l = of(link);

    for (unsigned i = 0; l->aio && i < TTF_USB_DEPTH; i++)
        if (l->write[i].state == SLOT_QUEUED) {
            l->write[i].dropped = true;
            usb_aio_cancel(l->aio, &l->write[i].iocb);
        }
}

static int link_reset(struct ttf_usb_link *link, uint64_t nonce)
{
    (void)link;
    (void)nonce;
    return -ENODEV; /* a host's */
}

static void link_close(struct ttf_usb_link *link)
{
    stop(of(link));
}

static void link_destroy(struct ttf_usb_link *link)
{
    struct functionfs_link *l = of(link);

    stop(l);
    close_fd(&l->ep0);
    close_fd(&l->ended);
    for (unsigned i = 0; i < TTF_USB_DEPTH; i++) {
        free(l->read[i].data);
        free(l->write[i].data);
    }
    free(l);
}

static const struct ttf_usb_link_ops OPS = {.name = "functionfs",
                                            .open = link_open,
                                            .fds = link_fds,
                                            .next = link_next,
                                            .buffer = link_buffer,
                                            .send = link_send,
                                            .drop = link_drop,
                                            .reset = link_reset,
                                            .close = link_close,
                                            .destroy = link_destroy};

static bool make_slot(struct slot *s)
{
    s->data = malloc(TTF_USB_TRANSFER);
    return s->data != NULL;
}

int ttf_usb_functionfs_create(const char *folder, int ep0, struct ttf_usb_link **ret,
                              struct ttf_err *err)
{
    bool fits = strlen(folder) < FOLDER_SIZE, made = true;
    struct functionfs_link *l = fits ? calloc(1, sizeof *l) : NULL;

    if (!l) {
        int r = fits ? -ENOMEM : -ENAMETOOLONG;

        (void)close(ep0);
        return ttf_err_set(err, r, folder, "cannot be used: %s", strerrordesc_np(-r));
    }
    l->base.ops = &OPS;
    (void)snprintf(l->folder, sizeof l->folder, "%s", folder);
    l->ep0 = ep0;
    l->in = l->out = l->handed = -1;
    l->inherited = true;
    l->ended = eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC);
    for (unsigned i = 0; i < TTF_USB_DEPTH; i++)
        made = make_slot(&l->read[i]) && make_slot(&l->write[i]) && made;
    /* Inherited, it may have been made to block. */
    if (!made || l->ended < 0 || fcntl(ep0, F_SETFL, O_RDWR | O_NONBLOCK) < 0) {
        int r = made ? -errno : -ENOMEM;

        link_destroy(&l->base);
        return ttf_err_set(err, r, folder, "cannot be used: %s", strerrordesc_np(-r));
    }
    *ret = &l->base;
    return 0;
}
