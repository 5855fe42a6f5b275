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

/*
 * Makes the devices. io: for pictures that a simulated camera looks at; must
 * outlive the box. Free with ttf_box_destroy. -ENOTSUP for a back-end that is not
 * built in, -EINVAL, -ENOMEM, errors of the pictures.
 */
TTF_MUST_USE int box_create(const struct ttf_board *board, struct ttf_io *io, struct ttf_box *ret,
                            struct ttf_err *err);

/* Configures all cameras as the board asks. */
TTF_MUST_USE int box_configure(const struct ttf_board *board, const struct ttf_box *box,
                               struct ttf_err *err);

/*
 * The disk: that of the machine, but failing when the simulated box says so
 * (disk-full, io-error). box must stay where it is until box_disk_destroy.
 */
struct ttf_io *box_disk_create(struct ttf_io *machine, const struct ttf_box *box);
void box_disk_destroy(struct ttf_io *disk, struct ttf_io *machine);

#endif
