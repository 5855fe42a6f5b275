/* SPDX-License-Identifier: Apache-2.0 */
/* tiff_unpack.h: from samples as a TIFF file packs them to samples in memory. Private to the pictures. */
#ifndef TTF_DATASET_TIFF_UNPACK_H
#define TTF_DATASET_TIFF_UNPACK_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "ttf/dataset/pixbuf.h"

/* How the samples of one decoded strip, tile or plane lie. */
struct tiff_layout {
    unsigned bits;     /* 1..16, 32 */
    bool is_float;     /* 16 or 32 bits */
    bool inverted;     /* white is zero */
    bool spread;       /* below 8 bits: over 0..255; else the code as it is */
    unsigned in_pixel; /* samples of a pixel as they lie: > kept with alpha, 1 in planes */
    unsigned kept;     /* samples of a pixel to take of them, from the first */
    enum ttf_sample format;
};

/* The memory format that samples of these bits come as. */
enum ttf_sample tiff_format_of(unsigned bits, bool is_float);

/* Whether tiff_unpack_row does nothing but copy. */
bool tiff_unpack_copies(const struct tiff_layout *layout, unsigned dst_step);

/*
 * n pixels from packed bytes (a row begins at a byte; 16- and 32-bit words in
 * machine order, as libtiff hands them out) to dst, whose pixels are dst_step samples apart.
 */
void tiff_unpack_row(const struct tiff_layout *layout, const uint8_t *src, size_t n, void *dst,
                     unsigned dst_step);

/* The same of palette indices: dst gets R, G, B from the 3 tables of 2^bits entries. */
void tiff_unpack_palette(const struct tiff_layout *layout, const uint8_t *src, size_t n,
                         const uint16_t *const tables[3], uint8_t *dst);

#endif
