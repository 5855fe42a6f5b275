/* SPDX-License-Identifier: Apache-2.0 */
/* rig_usb_raw.c: as many transfers queued as may be at both ends, of bytes that mean nothing. */
#include <errno.h>
#include <fcntl.h>
#include <linux/usb/functionfs.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "aio.h"
#include "find.h"
#include "rig_usb.h"
#include "ttf/base/time.h"
#include "ttf/usb/functionfs.h"

/* ---- a box's ---- */

static int open_endpoint(const char *folder)
{
    char path[300];
    int fd;

    (void)snprintf(path, sizeof path, "%s/ep1", folder);
    fd = open(path, O_RDWR | O_CLOEXEC);
    return fd < 0 ? -errno : fd;
}

/* Until a PC has configured it. */
static int wait_for_enable(int ep0)
{
    struct usb_functionfs_event event = {0};
    struct pollfd p = {.fd = ep0, .events = POLLIN};

    while (poll(&p, 1, -1) >= 0) {
        if (read(ep0, &event, sizeof event) != (ssize_t)sizeof event)
            continue;
        if (event.type == FUNCTIONFS_ENABLE)
            return 0;
    }
    return -errno;
}

static int give(int fd, const uint8_t *bytes)
{
    struct iocb iocbs[RIG_USB_DEPTH];
    struct io_event events[RIG_USB_DEPTH];
    aio_context_t aio = 0;
    int r = usb_aio_setup(RIG_USB_DEPTH, &aio);

    for (unsigned i = 0; r == 0 && i < RIG_USB_DEPTH; i++) {
        iocbs[i] = (struct iocb){.aio_lio_opcode = IOCB_CMD_PWRITE,
                                 .aio_fildes = (uint32_t)fd,
                                 .aio_buf = (uint64_t)(uintptr_t)bytes,
                                 .aio_nbytes = RIG_USB_TRANSFER,
                                 .aio_data = i};
        r = usb_aio_submit(aio, &iocbs[i]);
    }
    while (r == 0) {
        long n = syscall(SYS_io_getevents, aio, 1L, (long)RIG_USB_DEPTH, events, NULL);

        for (long i = 0; r == 0 && i < n; i++)
            r = events[i].res < 0 ? (int)events[i].res
                                  : usb_aio_submit(aio, &iocbs[events[i].data]);
    }
    if (aio)
        usb_aio_destroy(aio);
    return r;
}

int rig_usb_source(const char *folder)
{
    struct ttf_err err = {0};
    uint8_t *bytes = calloc(1, RIG_USB_TRANSFER);
    int ep0 = ttf_usb_functionfs_prepare(folder, &err), fd, r;

    if (ep0 < 0 || !bytes) {
        r = ep0 < 0 ? ep0 : -ENOMEM;
    } else {
        printf("ready\n");
        (void)fflush(stdout);
        r = wait_for_enable(ep0);
    }
    fd = r < 0 ? r : open_endpoint(folder);
    r = fd < 0 ? fd : give(fd, bytes);
    if (fd >= 0)
        (void)close(fd);
    if (ep0 >= 0)
        (void)close(ep0);
    free(bytes);
    return r;
}

/* ---- a PC's ---- */

struct drain {
    libusb_context *context;
    libusb_device_handle *handle;
    struct usb_endpoints ends;
    struct libusb_transfer *transfer[RIG_USB_DEPTH];
    unsigned char *data[RIG_USB_DEPTH];
    int64_t bytes, wanted;
    unsigned queued;
    int error;
};

static void LIBUSB_CALL came(struct libusb_transfer *transfer)
{
    struct drain *d = transfer->user_data;

    d->queued--;
    d->bytes += transfer->actual_length;
    if (transfer->status != LIBUSB_TRANSFER_COMPLETED && d->bytes < d->wanted)
        d->error = -EIO;
    if (d->error == 0 && d->bytes < d->wanted && libusb_submit_transfer(transfer) == 0)
        d->queued++;
}

static int queue_all(struct drain *d)
{
    for (unsigned i = 0; i < RIG_USB_DEPTH; i++) {
        d->transfer[i] = libusb_alloc_transfer(0);
        d->data[i] = malloc(RIG_USB_TRANSFER);
        if (!d->transfer[i] || !d->data[i])
            return -ENOMEM;
        libusb_fill_bulk_transfer(d->transfer[i], d->handle, d->ends.in, d->data[i],
                                  (int)RIG_USB_TRANSFER, came, d, 0);
        if (libusb_submit_transfer(d->transfer[i]) < 0)
            return -EIO;
        d->queued++;
    }
    return 0;
}

static void let_go(struct drain *d)
{
    for (unsigned i = 0; i < RIG_USB_DEPTH && d->queued > 0; i++)
        if (d->transfer[i])
            (void)libusb_cancel_transfer(d->transfer[i]);
    while (d->queued > 0 && libusb_handle_events(d->context) == 0)
        ;
    for (unsigned i = 0; i < RIG_USB_DEPTH; i++) {
        libusb_free_transfer(d->transfer[i]);
        free(d->data[i]);
    }
    (void)libusb_release_interface(d->handle, d->ends.interface);
    libusb_close(d->handle);
}

int64_t rig_usb_drain(struct ttf_clock *clock, int64_t bytes)
{
    struct drain d = {.wanted = bytes};
    struct ttf_err err = {0};
    int64_t begun, took = 0;
    int r = libusb_init(&d.context);

    if (r < 0)
        return usb_errno(r);
    r = usb_find_open(d.context, NULL, &d.handle, &err);
    if (r == 0) {
        r = usb_find_endpoints(d.handle, &d.ends);
        if (r == 0)
            r = usb_errno(libusb_claim_interface(d.handle, d.ends.interface));
        begun = ttf_clock_now_ns(clock);
        if (r == 0)
            r = queue_all(&d);
        while (r == 0 && d.error == 0 && d.bytes < d.wanted)
            r = usb_errno(libusb_handle_events(d.context));
        took = ttf_clock_now_ns(clock) - begun;
        let_go(&d);
    }
    libusb_exit(d.context);
    if (r == 0)
        r = d.error;
    return r < 0 ? r : (int64_t)((double)d.bytes * (double)TTF_NS_PER_S / (double)took);
}
