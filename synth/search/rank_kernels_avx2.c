/* SPDX-License-Identifier: Apache-2.0 */
/* Compiled with -mavx2 on x86-64 (synth/CMakeLists.txt); never entered without a look at the processor. */
#include <immintrin.h>

#include "search/rank_four.h"
#include "search/rank_kernels.h"
#include "search/rank_rotate.h"

/* Cells added before the sums are looked at: 16 x 16 x 2046^2 and a clipped sum fit 32 bits. */
#define CELLS_AT_ONCE 16

static __m256i load(const int16_t *p)
{
    return _mm256_loadu_si256((const __m256i *)(const void *)p);
}

static __m256i squares(__m256i a, __m256i b)
{
    __m256i d = _mm256_sub_epi16(a, b);

    return _mm256_madd_epi16(d, d);
}

/* Adds eight 32-bit lanes, none negative, to four of 64 bits. */
static __m256i widen(__m256i sum, __m256i part)
{
    const __m256i zero = _mm256_setzero_si256();

    sum = _mm256_add_epi64(sum, _mm256_unpacklo_epi32(part, zero));
    return _mm256_add_epi64(sum, _mm256_unpackhi_epi32(part, zero));
}

static uint64_t sum_of(__m256i sum)
{
    uint64_t lanes[4];

    _mm256_storeu_si256((__m256i *)(void *)lanes, sum);
    return lanes[0] + lanes[1] + lanes[2] + lanes[3];
}

/* Eight vectors of squares keep a lane below 2^31; then into 64 bits. */
static __m256i add_run(__m256i sum, const int16_t *a, const int16_t *b, size_t n)
{
    for (size_t i = 0; i < n;) {
        size_t end = n - i < 128 ? n : i + 128;
        __m256i part = _mm256_setzero_si256();

        for (; i < end; i += 16)
            part = _mm256_add_epi32(part, squares(load(a + i), load(b + i)));
        sum = widen(sum, part);
    }
    return sum;
}

static uint64_t ssd_i16(const int16_t *a, const int16_t *b, size_t n)
{
    return sum_of(add_run(_mm256_setzero_si256(), a, b, n));
}

/* The sums of the lanes of eight vectors, in order. */
static __m256i gather_sums(const __m256i v[8])
{
    __m256i even = _mm256_hadd_epi32(_mm256_hadd_epi32(v[0], v[1]), _mm256_hadd_epi32(v[2], v[3]));
    __m256i odd = _mm256_hadd_epi32(_mm256_hadd_epi32(v[4], v[5]), _mm256_hadd_epi32(v[6], v[7]));

    return _mm256_add_epi32(_mm256_permute2x128_si256(even, odd, 0x20),
                            _mm256_permute2x128_si256(even, odd, 0x31));
}

/* Eight positions, a vector each, and up to CELLS_AT_ONCE cells: one sum per position. */
static __m256i eight_positions(const int16_t *cells, const struct ttf_cell_target *targets,
                               size_t n_targets)
{
    __m256i sums[8];

    for (int k = 0; k < 8; k++)
        sums[k] = _mm256_setzero_si256();
    for (size_t i = 0; i < n_targets; i++) {
        const int16_t *at = cells + (size_t)targets[i].offset * TTF_CELL_DIMS;
        __m256i target = load(targets[i].value);

        for (int k = 0; k < 8; k++)
            sums[k] =
                _mm256_add_epi32(sums[k], squares(load(at + (size_t)k * TTF_CELL_DIMS), target));
    }
    return gather_sums(sums);
}

static void bound_group(const int16_t *cells, const struct ttf_cell_target *targets,
                        size_t n_targets, uint32_t limit, uint32_t *bounds)
{
    __m256i sum = _mm256_setzero_si256();
    __m256i most = _mm256_set1_epi32((int)limit);
    __m256i clip = _mm256_set1_epi32((int)TTF_BOUND_MAX);

    for (size_t i = 0; i < n_targets; i += CELLS_AT_ONCE) {
        size_t n = n_targets - i < CELLS_AT_ONCE ? n_targets - i : CELLS_AT_ONCE;
        __m256i within;

        sum = _mm256_min_epu32(_mm256_add_epi32(sum, eight_positions(cells, targets + i, n)), clip);
        within = _mm256_cmpeq_epi32(_mm256_min_epu32(sum, most), sum);
        if (_mm256_testz_si256(within, within))
            break;
    }
    _mm256_storeu_si256((__m256i *)(void *)bounds, sum);
}

static void bound_cells(const int16_t *cells, const struct ttf_cell_target *targets,
                        size_t n_targets, size_t n, uint32_t limit, uint32_t *bounds)
{
    size_t x = 0;

    if (n < 8) {
        ttf_rank_kernels_scalar()->bound_cells(cells, targets, n_targets, n, limit, bounds);
        return;
    }
    for (; x + 8 <= n; x += 8)
        bound_group(cells + x * TTF_CELL_DIMS, targets, n_targets, limit, bounds + x);
    if (x < n)
        bound_group(cells + (n - 8) * TTF_CELL_DIMS, targets, n_targets, limit, bounds + n - 8);
}

static void ssd_at_pairs(const int16_t *const a[4], const uint32_t *offsets, const int16_t *b,
                         size_t n, uint64_t limit, uint64_t ret[8])
{
    for (size_t half = 0; half < 2; half++) {
        const int16_t *at[4];

        ttf_places_of_pairs(a + 2 * half, at);
        four_places(at, offsets, b, n, limit, 1, ret + 4 * half);
    }
}

static void ssd_at_row(const int16_t *a, const uint32_t *offsets, const int16_t *b, size_t n,
                       uint64_t limit, uint64_t ret[TTF_ROW_PLACES])
{
    ttf_row_by_pairs(ssd_at_pairs, a, offsets, b, n, limit, ret);
}

const struct ttf_rank_kernels *ttf_rank_kernels_avx2(void)
{
    static const struct ttf_rank_kernels kernels = {
        .name = "avx2",
        .ssd_i16 = ssd_i16,
        .ssd_at4 = ssd_at4,
        .ssd_at_pairs = ssd_at_pairs,
        .ssd_at_row = ssd_at_row,
        .bound_cells = bound_cells,
        .rotate4 = rotate4,
    };

    return __builtin_cpu_supports("avx2") ? &kernels : NULL;
}
