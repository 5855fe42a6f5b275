/* SPDX-License-Identifier: Apache-2.0 */
/*
 * factor_kernels.h: the inner loops of factoring that are not matching's, behind a table: a scalar reference and a faster version. Both
 * come to the same bits: each number's terms are added in the same order.
 */
#ifndef TTF_SYNTH_SEARCH_FACTOR_KERNELS_H
#define TTF_SYNTH_SEARCH_FACTOR_KERNELS_H

#include <stddef.h>
#include <stdint.h>

struct ttf_factor_kernels {
    const char *name;
    /*
     * Rows of [C D] of four neighbouring pixels: out[p][0 .. room-1] = coefs[p], then the three codes of pixel + p in each of n frames.
     * energy[p] = the sum of its squared codes. room: a multiple of 8. n <= 85: so that sums of squares are exact as floats. out: 4 rows
     * of out_stride floats, of which one behind the last code is written, too.
     */
    void (*rows4)(const float *coefs, size_t room, const uint8_t *const *frames, unsigned n,
                  size_t pixel, float *out, size_t out_stride, uint32_t energy[4]);
    /* gram[i][j] += sum over rows r = 0 .. 3, in this order, of rows[r][i] * rows[r][j], for j <= i < dims. gram: dims x dims. */
    void (*add_gram4)(const double *rows, size_t row_stride, size_t dims, double *gram);
};

/* The reference. */
const struct ttf_factor_kernels *ttf_factor_kernels_scalar(void);

/* The fastest that this processor runs. */
const struct ttf_factor_kernels *ttf_factor_kernels_best(void);

/* NULL where they are not built or the processor lacks them. */
const struct ttf_factor_kernels *ttf_factor_kernels_avx2(void);

#endif
