/* SPDX-License-Identifier: Apache-2.0 */
/*
 * box.h: from a board's description to its devices, and to the disk as a box of
 * that board sees it.
 */
#ifndef FIRMWARE_BOX_H
#define FIRMWARE_BOX_H

#include "ttf/base/err.h"
#include "ttf/config/board_file.h"
#include "ttf/dataset/io.h"
#include "ttf/hal/box.h"
#include "ttf/hal/host_time.h"

/* What the machine around a box offers. All of it may be missing: NULL stands for this machine as a program by hand finds it. */
struct box_host {
    const char *notify;  /* the service manager's socket (NOTIFY_SOCKET), "" or NULL: none */
    int64_t watchdog_ns; /* within which it wants to be told (WATCHDOG_USEC); 0: not at all */
    const char *sys;     /* "/sys", or a folder laid out like it; NULL: "/sys" */
    const char *etc;     /* "/etc", likewise */
    struct ttf_host_time *
        host_time; /* what a PC said, for a clock that knows no better; outlives the box; NULL: none */
};

/*
 * Makes the devices, simulated and real ones. io: for pictures that a simulated camera looks at; must
 * outlive the box. host: NULL allowed; its texts must outlive the box. Free with ttf_box_destroy. -ENOTSUP for a
 * back-end that is not built in, -EINVAL, -ENOMEM, errors of the pictures, -ENODEV, -ENOENT, -EACCES, -EBUSY,
 * -ECONNREFUSED: a device does not answer; err says which and what to do.
 */
TTF_MUST_USE int box_create(const struct ttf_board *board, struct ttf_io *io,
                            const struct box_host *host, struct ttf_box *ret, struct ttf_err *err);

/* Whether such an error may pass by itself: a device that is not there yet, busy, or lost. */
bool box_may_answer_later(int error);

/*
 * The same, but a device that does not answer is left out: errs[kind].code says so, in words. Fails only without a
 * clock (errs[TTF_DEVICE_CLOCK]).
 */
TTF_MUST_USE int box_create_what_answers(const struct ttf_board *board, struct ttf_io *io,
                                         const struct box_host *host, struct ttf_box *ret,
                                         struct ttf_err errs[TTF_DEVICE_KIND_COUNT]);

/* Configures all cameras of a box that has all its board's, as the board asks. */
TTF_MUST_USE int box_configure(const struct ttf_board *board, const struct ttf_box *box,
                               struct ttf_err *err);

/* The machine's disks as a box sees them. Private but for io. */
struct box_disk {
    struct ttf_io *io; /* to be used */
    struct ttf_io *faulty;
    const struct ttf_box *box;
    const char *second;
};

/*
 * Those of the machine, but failing, full or read-only when the simulated box says so. second: folder of the
 * plan's second storage, which has faults of its own; empty: none. disk, box and second must stay where they are
 * until box_disk_destroy. -ENOMEM.
 */
TTF_MUST_USE int box_disk_create(struct box_disk *disk, struct ttf_io *machine,
                                 const struct ttf_box *box, const char *second);
void box_disk_destroy(struct box_disk *disk); /* a zeroed one is fine */

#endif
