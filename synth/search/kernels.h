/* SPDX-License-Identifier: Apache-2.0 */
/*
 * kernels.h: the three inner loops of the search, behind a table: a scalar
 * reference and faster versions of the same. Integer results are the same bits
 * in all versions; floats differ in rounding, within the margins that
 * block_search.c grants (they bound, they never decide).
 */
#ifndef TTF_SYNTH_SEARCH_KERNELS_H
#define TTF_SYNTH_SEARCH_KERNELS_H

#include <stddef.h>
#include <stdint.h>

#define TTF_CELL_PLANES 8  /* values per cell of the first bound */
#define TTF_PIXEL_COEFS 16 /* values per pixel of the second bound */

struct ttf_kernels {
    const char *name;
    /* Sum of squared differences of n bytes. */
    uint64_t (*ssd_u8)(const uint8_t *a, const uint8_t *b, size_t n);
    /* The same of floats; n a multiple of TTF_PIXEL_COEFS. */
    float (*ssd_f32)(const float *a, const float *b, size_t n);
    /* acc[x] += sum over planes d of (plane[d][x] - target[d])^2, x = 0..n-1. */
    void (*add_cells)(float *acc, const float *const plane[TTF_CELL_PLANES],
                      const float target[TTF_CELL_PLANES], size_t n);
};

/* The reference. */
const struct ttf_kernels *ttf_kernels_scalar(void);

/* The fastest that this processor runs. */
const struct ttf_kernels *ttf_kernels_best(void);

/* Of kernels_avx2.c; NULL where it is not built. */
const struct ttf_kernels *ttf_kernels_avx2(void);

#endif
