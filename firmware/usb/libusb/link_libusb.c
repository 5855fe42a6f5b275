/* SPDX-License-Identifier: Apache-2.0 */
/*
 * link_libusb.c: a PC's end of the cable. As many reads as may be are always queued, each of which takes one transfer. All
 * callbacks of libusb run inside next(), close() and drop(): there is one thread.
 */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "find.h"
#include "ttf/usb/identity.h"

#define CONTROL_MS   1000
#define CONTROL_SIZE (LIBUSB_CONTROL_SETUP_SIZE + TTF_USB_RESET_SIZE)
#define LOST_MAX     (4 * 2 * TTF_USB_DEPTH) /* transfers that may stay away: 4 MiB of them */

enum slot_state {
    SLOT_FREE = 0, /* of a write: to be filled */
    SLOT_QUEUED,   /* libusb has it */
    SLOT_CAME      /* of a read: to be handed out */
};

struct libusb_link;

struct slot {
    struct libusb_link *link;
    struct libusb_transfer *transfer;
    enum slot_state state;
    uint8_t *data;
    size_t n;
};

struct libusb_link {
    struct ttf_usb_link base;
    libusb_context *context;
    libusb_device_handle *handle; /* NULL: none is open */
    struct usb_endpoints ends;
    struct slot in[TTF_USB_DEPTH], out[TTF_USB_DEPTH];
    unsigned next_in; /* the read that completes next: they do in order */
    int handed;       /* the read that was handed out, to be queued again; -1 */
    struct libusb_transfer *control;
    uint8_t *control_data;
    bool control_queued, control_done;
    int control_error;
    int down; /* the error for which the device is to be let go; 0 */
    bool closing;
    unsigned lost; /* transfers that did not come back, with their buffers: libusb's */
    char serial[TTF_USB_SERIAL_SIZE];
};

static struct libusb_link *of(struct ttf_usb_link *link)
{
    return (struct libusb_link *)link;
}

static int status_errno(enum libusb_transfer_status status)
{
    switch (status) {
    case LIBUSB_TRANSFER_COMPLETED:
        return 0;
    case LIBUSB_TRANSFER_TIMED_OUT:
        return -ETIMEDOUT;
    case LIBUSB_TRANSFER_CANCELLED:
        return -ECANCELED;
    case LIBUSB_TRANSFER_NO_DEVICE:
        return -ENODEV;
    case LIBUSB_TRANSFER_STALL:
        return -EPIPE;
    default:
        return -EIO;
    }
}

static void fail(struct libusb_link *l, int error)
{
    if (!l->closing && l->down == 0)
        l->down = error;
}

/* One that was lost has come back after all: another is in its place. */
static bool came_late(struct libusb_link *l, struct libusb_transfer *transfer,
                      const struct libusb_transfer *in_place)
{
    if (transfer == in_place)
        return false;
    l->lost--;
    free(transfer->buffer);
    libusb_free_transfer(transfer);
    return true;
}

static void LIBUSB_CALL read_done(struct libusb_transfer *transfer)
{
    struct slot *s = transfer->user_data;
    int error = status_errno(transfer->status);

    if (came_late(s->link, transfer, s->transfer))
        return;
    s->state = error ? SLOT_FREE : SLOT_CAME;
    s->n = (size_t)transfer->actual_length;
    if (error)
        fail(s->link, error);
}

static void LIBUSB_CALL write_done(struct libusb_transfer *transfer)
{
    struct slot *s = transfer->user_data;
    int error = status_errno(transfer->status);

    if (came_late(s->link, transfer, s->transfer))
        return;
    s->state = SLOT_FREE;
    if (error && error != -ECANCELED)
        fail(s->link, error);
}

static void LIBUSB_CALL control_done(struct libusb_transfer *transfer)
{
    struct libusb_link *l = transfer->user_data;

    if (came_late(l, transfer, l->control))
        return;
    l->control_queued = false;
    l->control_done = true;
    l->control_error = status_errno(transfer->status);
    if (l->control_error == -ENODEV)
        fail(l, -ENODEV);
}

static void queue_read(struct libusb_link *l, unsigned i)
{
    struct slot *s = &l->in[i];
    int r;

    libusb_fill_bulk_transfer(s->transfer, l->handle, l->ends.in, s->data, TTF_USB_TRANSFER,
                              read_done, s, 0);
    r = libusb_submit_transfer(s->transfer);
    s->state = r < 0 ? SLOT_FREE : SLOT_QUEUED;
    if (r < 0)
        fail(l, usb_errno(r));
}

/* What is ready, without waiting. */
static void handle_events(struct libusb_link *l)
{
    struct timeval at_once = {0, 0};

    (void)libusb_handle_events_timeout_completed(l->context, &at_once, NULL);
}

static bool anything_queued(const struct libusb_link *l)
{
    for (unsigned i = 0; i < TTF_USB_DEPTH; i++)
        if (l->in[i].state == SLOT_QUEUED || l->out[i].state == SLOT_QUEUED)
            return true;
    return l->control_queued;
}

/* Another transfer and buffer in the place of one that libusb keeps. false: no memory, or too many are lost. */
static bool replace(struct libusb_link *l, struct libusb_transfer **transfer, uint8_t **data,
                    size_t n)
{
    struct libusb_transfer *other = l->lost < LOST_MAX ? libusb_alloc_transfer(0) : NULL;
    uint8_t *room = other ? malloc(n) : NULL;

    if (!room) {
        libusb_free_transfer(other);
        return false;
    }
    l->lost++;
    *transfer = other;
    *data = room;
    return true;
}

static void replace_slot(struct libusb_link *l, struct slot *s)
{
    if (s->state == SLOT_QUEUED && replace(l, &s->transfer, &s->data, TTF_USB_TRANSFER))
        s->state = SLOT_FREE;
}

/* A device that was let go with transfers out: what has not come back by now is not waited for. */
static void replace_queued(struct libusb_link *l)
{
    for (unsigned i = 0; i < TTF_USB_DEPTH; i++) {
        replace_slot(l, &l->in[i]);
        replace_slot(l, &l->out[i]);
    }
    if (l->control_queued && replace(l, &l->control, &l->control_data, CONTROL_SIZE))
        l->control_queued = false;
}

static void link_close(struct ttf_usb_link *link)
{
    struct libusb_link *l = of(link);

    if (!l->handle)
        return;
    l->closing = true;
    for (unsigned i = 0; i < TTF_USB_DEPTH; i++) {
        if (l->in[i].state == SLOT_QUEUED)
            (void)libusb_cancel_transfer(l->in[i].transfer);
        if (l->out[i].state == SLOT_QUEUED)
            (void)libusb_cancel_transfer(l->out[i].transfer);
    }
    if (l->control_queued)
        (void)libusb_cancel_transfer(l->control);
    /* Cancelled transfers come back in milliseconds; a bounded number of looks in any case. */
    for (unsigned i = 0; i < 40 && anything_queued(l); i++) {
        struct timeval wait = {0, 50000};

        (void)libusb_handle_events_timeout_completed(l->context, &wait, NULL);
    }
    (void)libusb_release_interface(l->handle, l->ends.interface);
    libusb_close(l->handle);
    l->handle = NULL;
    l->closing = l->control_done = false;
    l->down = 0;
    l->handed = -1;
}

static int link_open(struct ttf_usb_link *link, struct ttf_err *err)
{
    struct libusb_link *l = of(link);
    int r;

    if (l->handle)
        return 0;
    r = usb_find_open(l->context, l->serial[0] ? l->serial : NULL, &l->handle, err);
    if (r < 0)
        return r;
    r = usb_find_endpoints(l->handle, &l->ends);
    if (r == 0)
        r = usb_errno(libusb_claim_interface(l->handle, l->ends.interface));
    if (r < 0) {
        libusb_close(l->handle);
        l->handle = NULL;
        ttf_err_set(err, r, "USB",
                    r == -EBUSY ? "another program has this box" : "the box has no such interface");
        if (r == -EBUSY)
            ttf_err_hint(err,
                         "a running 'ttfbox usb' can be shared: --box and the address it shows");
        return r;
    }
    replace_queued(l);
    if (anything_queued(l)) { /* of the last time: its memory is not to be given away twice */
        libusb_close(l->handle);
        l->handle = NULL;
        return ttf_err_set(err, -EIO, "USB", "transfers of before have not come back");
    }
    l->next_in = 0;
    l->down = 0;
    l->control_done = false;
    for (unsigned i = 0; i < TTF_USB_DEPTH; i++)
        queue_read(l, i);
    return 0;
}

static unsigned link_fds(struct ttf_usb_link *link, struct pollfd *ret)
{
    struct libusb_link *l = of(link);
    const struct libusb_pollfd **fds;
    unsigned n = 0;

    if (!l->handle)
        return 0;
    fds = libusb_get_pollfds(l->context);
    for (unsigned i = 0; fds && fds[i] && n < TTF_USB_FDS; i++)
        ret[n++] = (struct pollfd){.fd = fds[i]->fd, .events = fds[i]->events};
    libusb_free_pollfds(fds);
    return n;
}

static void link_next(struct ttf_usb_link *link, struct ttf_usb_event *ret)
{
    struct libusb_link *l = of(link);
    struct slot *s = &l->in[l->next_in];

    *ret = (struct ttf_usb_event){.kind = TTF_USB_NOTHING};
    if (!l->handle)
        return;
    if (l->handed >= 0 && l->down == 0)
        queue_read(l, (unsigned)l->handed);
    l->handed = -1;
    if (s->state != SLOT_CAME)
        handle_events(l);
    if (l->control_done) {
        l->control_done = false;
        *ret = (struct ttf_usb_event){.kind = TTF_USB_RESET, .error = l->control_error};
    } else if (s->state == SLOT_CAME) {
        s->state = SLOT_FREE;
        l->handed = (int)l->next_in;
        l->next_in = (l->next_in + 1) % TTF_USB_DEPTH;
        *ret = (struct ttf_usb_event){.kind = TTF_USB_CAME, .data = s->data, .n = s->n};
    } else if (l->down != 0) {
        *ret = (struct ttf_usb_event){.kind = TTF_USB_DOWN, .error = l->down};
        link_close(link);
    }
}

static struct slot *free_slot(struct libusb_link *l)
{
    for (unsigned i = 0; l->handle && l->down == 0 && i < TTF_USB_DEPTH; i++)
        if (l->out[i].state == SLOT_FREE)
            return &l->out[i];
    return NULL;
}

static uint8_t *link_buffer(struct ttf_usb_link *link)
{
    struct slot *s = free_slot(of(link));

    return s ? s->data : NULL;
}

static void link_send(struct ttf_usb_link *link, size_t n)
{
    struct libusb_link *l = of(link);
    struct slot *s = free_slot(l);
    int r;

    if (!s)
        return;
    libusb_fill_bulk_transfer(s->transfer, l->handle, l->ends.out, s->data, (int)n, write_done, s,
                              0);
    r = libusb_submit_transfer(s->transfer);
    s->state = r < 0 ? SLOT_FREE : SLOT_QUEUED;
    if (r < 0)
        fail(l, usb_errno(r));
}

static void link_drop(struct ttf_usb_link *link)
{
    struct libusb_link *l = of(link);

    for (unsigned i = 0; l->handle && i < TTF_USB_DEPTH; i++)
        if (l->out[i].state == SLOT_QUEUED)
            (void)libusb_cancel_transfer(l->out[i].transfer);
}

static int link_reset(struct ttf_usb_link *link, uint64_t nonce)
{
    struct libusb_link *l = of(link);
    int r;

    if (!l->handle)
        return -ENODEV;
    if (l->control_queued)
        return -EALREADY;
    libusb_fill_control_setup(l->control_data, TTF_USB_RESET_TYPE, TTF_USB_RESET_REQUEST,
                              TTF_USB_RESET_VERSION, l->ends.interface, TTF_USB_RESET_SIZE);
    for (unsigned i = 0; i < TTF_USB_RESET_SIZE; i++)
        l->control_data[LIBUSB_CONTROL_SETUP_SIZE + i] = (uint8_t)(nonce >> (8 * i));
    libusb_fill_control_transfer(l->control, l->handle, l->control_data, control_done, l,
                                 CONTROL_MS);
    r = libusb_submit_transfer(l->control);
    if (r < 0)
        return usb_errno(r);
    l->control_queued = true;
    return 0;
}

static void free_slot_of(struct slot *s)
{
    libusb_free_transfer(s->transfer);
    free(s->data);
}

static void link_destroy(struct ttf_usb_link *link)
{
    struct libusb_link *l = of(link);

    link_close(link);
    /* What libusb did not give back is still its own, down to this struct, which its callback writes to: better lost than freed. */
    if (anything_queued(l) || l->lost > 0)
        return;
    for (unsigned i = 0; i < TTF_USB_DEPTH; i++) {
        free_slot_of(&l->in[i]);
        free_slot_of(&l->out[i]);
    }
    libusb_free_transfer(l->control);
    free(l->control_data);
    if (l->context)
        libusb_exit(l->context);
    free(l);
}

static const struct ttf_usb_link_ops OPS = {.name = "libusb",
                                            .open = link_open,
                                            .fds = link_fds,
                                            .next = link_next,
                                            .buffer = link_buffer,
                                            .send = link_send,
                                            .drop = link_drop,
                                            .reset = link_reset,
                                            .close = link_close,
                                            .destroy = link_destroy};

static bool make_slot(struct libusb_link *l, struct slot *s)
{
    *s = (struct slot){
        .link = l, .transfer = libusb_alloc_transfer(0), .data = malloc(TTF_USB_TRANSFER)};
    return s->transfer && s->data;
}

int ttf_usb_libusb_create(const char *serial, struct ttf_usb_link **ret, struct ttf_err *err)
{
    struct libusb_link *l = calloc(1, sizeof *l);
    bool made = l != NULL;
    int r;

    if (!l)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory");
    l->base.ops = &OPS;
    l->handed = -1;
    if (serial)
        (void)snprintf(l->serial, sizeof l->serial, "%s", serial);
    r = libusb_init(&l->context);
    l->control = r < 0 ? NULL : libusb_alloc_transfer(0);
    l->control_data = malloc(CONTROL_SIZE);
    for (unsigned i = 0; r == 0 && i < TTF_USB_DEPTH; i++)
        made = make_slot(l, &l->in[i]) && make_slot(l, &l->out[i]) && made;
    if (r < 0 || !made || !l->control || !l->control_data) {
        if (r < 0)
            l->context = NULL;
        link_destroy(&l->base);
        return r < 0 ? ttf_err_set(err, usb_errno(r), "USB", "libusb: %s", libusb_strerror(r))
                     : ttf_err_set(err, -ENOMEM, NULL, "no memory");
    }
    *ret = &l->base;
    return 0;
}
