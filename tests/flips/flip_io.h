/* SPDX-License-Identifier: Apache-2.0 */
/*
 * flip_io.h: an I/O table over another one in which one bit of one file reads flipped.
 * Nothing on the disk changes, so a hundred thousand flips take minutes.
 */
#ifndef FLIP_IO_H
#define FLIP_IO_H

#include <stdint.h>

#include "ttf/dataset/io.h"

struct flip_io {
    struct ttf_io io; /* first: downcast by address */
    struct ttf_io *base;
    const char *path; /* whole path of the file; NULL: nothing is flipped */
    int64_t bit;      /* of the file, from its first byte's lowest */
    int64_t open;     /* handles of that file that are open, a bit each */
};

void flip_io_init(struct flip_io *flip, struct ttf_io *base);

#endif
