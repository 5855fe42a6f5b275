/* SPDX-License-Identifier: Apache-2.0 */
#include "search/rank_kernels.h"

#include "search/rank_rotate.h"

static uint64_t ssd_i16(const int16_t *a, const int16_t *b, size_t n)
{
    uint64_t sum = 0;

    for (size_t i = 0; i < n; i += 4) {
        uint32_t part = 0;

        for (size_t k = i; k < i + 4; k++) {
            int32_t d = a[k] - b[k];

            part += (uint32_t)(d * d);
        }
        sum += part;
    }
    return sum;
}

static void ssd_at4(const int16_t *const a[4], const uint32_t *offsets, const int16_t *b, size_t n,
                    uint64_t limit, uint64_t ret[4])
{
    for (int k = 0; k < 4; k++) {
        ret[k] = 0;
        for (size_t i = 0; i < n && ret[k] <= limit; i++)
            ret[k] += ssd_i16(a[k] + (size_t)offsets[i] * TTF_COEF_LANES, b + i * TTF_COEF_LANES,
                              TTF_COEF_LANES);
    }
}

static void ssd_at_pairs(const int16_t *const a[4], const uint32_t *offsets, const int16_t *b,
                         size_t n, uint64_t limit, uint64_t ret[8])
{
    for (size_t half = 0; half < 2; half++) {
        const int16_t *at[4];

        ttf_places_of_pairs(a + 2 * half, at);
        ssd_at4(at, offsets, b, n, limit, ret + 4 * half);
    }
}

static void ssd_at_row(const int16_t *a, const uint32_t *offsets, const int16_t *b, size_t n,
                       uint64_t limit, uint64_t ret[TTF_ROW_PLACES])
{
    ttf_row_by_pairs(ssd_at_pairs, a, offsets, b, n, limit, ret);
}

static void bound_cells(const int16_t *cells, const struct ttf_cell_target *targets,
                        size_t n_targets, size_t n, uint32_t limit, uint32_t *bounds)
{
    for (size_t x = 0; x < n; x++) {
        uint32_t sum = 0;

        for (size_t i = 0; i < n_targets && sum <= limit; i++) {
            const int16_t *cell = cells + (targets[i].offset + x) * TTF_CELL_DIMS;

            for (int k = 0; k < TTF_CELL_DIMS; k++) {
                int32_t d = cell[k] - targets[i].value[k];

                sum += (uint32_t)(d * d);
            }
            sum = sum < TTF_BOUND_MAX ? sum : TTF_BOUND_MAX;
        }
        bounds[x] = sum;
    }
}

static void rotate4_plain(const float *w, size_t dims, size_t room, const float *in,
                          size_t in_stride, float *out)
{
    for (size_t p = 0; p < 4; p++) {
        for (size_t r = 0; r < room; r++) {
            float sum = 0.0f;

            for (size_t i = 0; i < dims; i++)
                sum += in[p * in_stride + i] * w[i * room + r];
            out[p * room + r] = sum;
        }
    }
}

const struct ttf_rank_kernels *ttf_rank_kernels_scalar(void)
{
    static const struct ttf_rank_kernels kernels = {
        .name = "scalar",
        .ssd_i16 = ssd_i16,
        .ssd_at4 = ssd_at4,
        .ssd_at_pairs = ssd_at_pairs,
        .ssd_at_row = ssd_at_row,
        .bound_cells = bound_cells,
        .rotate4 = rotate4_plain,
    };

    return &kernels;
}

const struct ttf_rank_kernels *ttf_rank_kernels_best(void)
{
    static const struct ttf_rank_kernels vector = {
        .name = "vector",
        .ssd_i16 = ssd_i16,
        .ssd_at4 = ssd_at4,
        .ssd_at_pairs = ssd_at_pairs,
        .ssd_at_row = ssd_at_row,
        .bound_cells = bound_cells,
        .rotate4 = rotate4,
    };
    const struct ttf_rank_kernels *best = ttf_rank_kernels_avx512();

    if (!best)
        best = ttf_rank_kernels_avx2();
    return best ? best : &vector;
}
