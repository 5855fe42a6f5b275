/* SPDX-License-Identifier: Apache-2.0 */
#include "search/factor_kernels.h"

#include <string.h>

static void rows4(const float *coefs, size_t room, const uint8_t *const *frames, unsigned n,
                  size_t pixel, float *out, size_t out_stride, uint32_t energy[4])
{
    for (size_t p = 0; p < 4; p++, out += out_stride) {
        memcpy(out, coefs + p * room, room * sizeof(*out));
        energy[p] = 0;
        for (size_t i = 0; i < (size_t)3 * n; i++) {
            uint32_t code = frames[i / 3][3 * (pixel + p) + i % 3];

            out[room + i] = (float)code;
            energy[p] += code * code;
        }
    }
}

static void add_gram4(const double *rows, size_t row_stride, size_t dims, double *gram)
{
    for (size_t i = 0; i < dims; i++) {
        for (size_t j = 0; j <= i; j++) {
            for (size_t r = 0; r < 4; r++)
                gram[i * dims + j] += rows[r * row_stride + i] * rows[r * row_stride + j];
        }
    }
}

const struct ttf_factor_kernels *ttf_factor_kernels_scalar(void)
{
    static const struct ttf_factor_kernels kernels = {"scalar", rows4, add_gram4};

    return &kernels;
}

const struct ttf_factor_kernels *ttf_factor_kernels_best(void)
{
    const struct ttf_factor_kernels *best = ttf_factor_kernels_avx2();

    return best ? best : ttf_factor_kernels_scalar();
}
