/* SPDX-License-Identifier: Apache-2.0 */
#include "search/kernels.h"

#include "search/kernels_vector.h"

static uint64_t scalar_ssd_u8(const uint8_t *a, const uint8_t *b, size_t n)
{
    uint64_t sum = 0;

    for (size_t i = 0; i < n; i++) {
        int d = a[i] - b[i];

        sum += (uint64_t)(d * d);
    }
    return sum;
}

static float scalar_ssd_f32(const float *a, const float *b, size_t n)
{
    double sum = 0.0;

    for (size_t i = 0; i < n; i++) {
        double d = (double)a[i] - b[i];

        sum += d * d;
    }
    return (float)sum;
}

static void scalar_add_cells(float *acc, const float *const plane[TTF_CELL_PLANES],
                             const float target[TTF_CELL_PLANES], size_t n)
{
    for (size_t x = 0; x < n; x++) {
        double sum = acc[x];

        for (int d = 0; d < TTF_CELL_PLANES; d++) {
            double diff = (double)plane[d][x] - target[d];

            sum += diff * diff;
        }
        acc[x] = (float)sum;
    }
}

const struct ttf_kernels *ttf_kernels_scalar(void)
{
    static const struct ttf_kernels kernels = {
        .name = "scalar",
        .ssd_u8 = scalar_ssd_u8,
        .ssd_f32 = scalar_ssd_f32,
        .add_cells = scalar_add_cells,
    };

    return &kernels;
}

const struct ttf_kernels *ttf_kernels_best(void)
{
    static const struct ttf_kernels vector = {
        .name = "vector",
        .ssd_u8 = ssd_u8,
        .ssd_f32 = ssd_f32,
        .add_cells = add_cells,
    };

#ifdef TTF_KERNELS_AVX2
    if (__builtin_cpu_supports("avx2"))
        return ttf_kernels_avx2();
#endif
    return &vector;
}
