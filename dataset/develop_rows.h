/* SPDX-License-Identifier: Apache-2.0 */
/*
 * develop_rows.h: the arithmetic of development, a row at a time. Loops over
 * floats that depend on nothing but their own column, so that a compiler may do
 * several columns at once and every machine gets the same bits.
 */
#ifndef TTF_DATASET_DEVELOP_ROWS_H
#define TTF_DATASET_DEVELOP_ROWS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* How far demosaicing and the replacement of pixels look beyond a pixel. */
#define DEVELOP_REACH  2
#define DEVELOP_MARGIN (2 * DEVELOP_REACH)

/* ret = (sum * mean - black - dark / 16) * gain / 16384 * level; dark and gain may be NULL. */
void develop_correct(const uint32_t *sum, const int32_t *dark_16, const uint16_t *gain, size_t n,
                     float mean, float black, float level, float *ret);

/* Rows y - 2 .. y + 2 of the mosaic, at the first pixel to make; two more lie left and right. */
struct develop_window {
    const float *row[5];
};

/*
 * Linear interpolation with gradient correction (Malvar, He, Cutler, "High-quality
 * linear interpolation for demosaicing of Bayer-patterned color images", ICASSP
 * 2004, figure 2). The row has green and its own colour (red or blue); own_first
 * tells whether the first pixel is of that colour. other: the third colour.
 */
void develop_demosaic(const struct develop_window *window, bool own_first, size_t n, float *own,
                      float *green, float *other);

/* In place: the 3 x 3 matrix, row-major. */
void develop_matrix(const float matrix[9], float *r, float *g, float *b, size_t n);

/* Codes, interleaved R, G, B: rounded value * scale + pedestal, clipped. */
void develop_encode(const float *r, const float *g, const float *b, size_t n, float scale,
                    float pedestal, uint16_t *ret);

#endif
