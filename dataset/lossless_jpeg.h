/* SPDX-License-Identifier: Apache-2.0 */
/*
 * lossless_jpeg.h: decodes lossless JPEG (ITU-T T.81, process 14: SOF3, Huffman),
 * as DNG files hold mosaics (TIFF compression 7). Nothing in the bytes is trusted.
 */
#ifndef TTF_DATASET_LOSSLESS_JPEG_H
#define TTF_DATASET_LOSSLESS_JPEG_H

#include <stddef.h>
#include <stdint.h>

#include "ttf/base/attr.h"

struct lossless_jpeg_info {
    uint32_t width, height; /* of the JPEG's own frame */
    unsigned components;    /* 1..4, interleaved */
    unsigned bits;          /* 2..16 */
};

/*
 * All samples in scan order into ret, which has room for `room` of them: a row
 * is width x components. -TTF_EDAMAGED for what is cut or broken, -ENOTSUP for
 * another kind of JPEG, -ENOSPC if there is more than room.
 */
TTF_MUST_USE int lossless_jpeg_decode(const uint8_t *data, size_t bytes, uint16_t *ret, size_t room,
                                      struct lossless_jpeg_info *ret_info);

#endif
