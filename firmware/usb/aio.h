/* SPDX-License-Identifier: Apache-2.0 */
/* aio.h: the kernel's asynchronous I/O, which FunctionFS needs for more than one transfer at a time. The C library has no such calls. */
#ifndef USB_AIO_H
#define USB_AIO_H

#include <errno.h>
#include <linux/aio_abi.h>
#include <stdint.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

static inline int usb_aio_setup(unsigned n, aio_context_t *ret)
{
    return syscall(SYS_io_setup, n, ret) < 0 ? -errno : 0;
}

/* Ends what is queued, and waits until it has ended. */
static inline void usb_aio_destroy(aio_context_t context)
{
    (void)syscall(SYS_io_destroy, context);
}

static inline int usb_aio_submit(aio_context_t context, struct iocb *iocb)
{
    return syscall(SYS_io_submit, context, 1L, &iocb) == 1 ? 0 : -errno;
}

/* Its event comes all the same. */
static inline void usb_aio_cancel(aio_context_t context, struct iocb *iocb)
{
    struct io_event event;

    (void)syscall(SYS_io_cancel, context, iocb, &event);
}

/* How many have ended by now. */
static inline int usb_aio_ended(aio_context_t context, struct io_event *ret, long max)
{
    struct timespec at_once = {0, 0};
    long n = syscall(SYS_io_getevents, context, 0L, max, ret, &at_once);

    return n < 0 ? 0 : (int)n;
}

#endif
