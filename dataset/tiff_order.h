/* SPDX-License-Identifier: Apache-2.0 */
/*
 * tiff_order.h: a TIFF file's bytes handed to the disk in the order of the file. libtiff writes the header without the folder's
 * place, fills it in when all else is written, and writes a folder part by part, last parts first: whoever hashes what is written
 * would have to read all of it again. Of pixels whose bytes are known before, the place can be told before. Private to the pictures.
 */
#ifndef TTF_DATASET_TIFF_ORDER_H
#define TTF_DATASET_TIFF_ORDER_H

#include <stddef.h>
#include <stdint.h>

#include "ttf/base/attr.h"
#include "ttf/dataset/io.h"

/* Of what is held back: header and first folders, then the last folder. What is more goes as it comes. */
#define TIFF_ORDER_HELD   8192
#define TIFF_ORDER_HEADER 16 /* of a BigTIFF; a classic one has 8 */

/* Zeroed: nothing is held back. */
struct tiff_order {
    enum tiff_order_state {
        TIFF_ORDER_NONE,
        TIFF_ORDER_HEAD, /* all is held */
        TIFF_ORDER_TAIL  /* pixels go as they come, what is behind them is held */
    } state;
    int64_t from;  /* of what is held, the place in the file */
    size_t n;      /* bytes held */
    size_t header; /* bytes of the header that was handed on */
    unsigned char head[TIFF_ORDER_HEADER];
    unsigned char held[TIFF_ORDER_HELD];
};

/* Of an empty file that is about to be written. */
void tiff_order_begin(struct tiff_order *order);

/* So many bytes of pixels come next, from `size` on, and behind them the last folder. A negative errno of the disk. */
TTF_MUST_USE int tiff_order_pixels(struct tiff_order *order, struct ttf_io *io, int file,
                                   int64_t size, int64_t bytes);

/* 1: taken. 0: to be written by the caller, now. A negative errno of the disk. */
TTF_MUST_USE int tiff_order_write(struct tiff_order *order, struct ttf_io *io, int file, int64_t at,
                                  const void *bytes, size_t n);

/* What is held goes to the disk; from now on nothing is held back. */
TTF_MUST_USE int tiff_order_release(struct tiff_order *order, struct ttf_io *io, int file);

#endif
