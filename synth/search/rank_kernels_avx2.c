/* SPDX-License-Identifier: Apache-2.0 */
/* Compiled with -mavx2 on x86-64 (synth/CMakeLists.txt); never entered without a look at the processor. */
#include <immintrin.h>

#include "search/rank_kernels.h"
#include "search/rank_rotate.h"

/* Cells added before the sums are looked at. */
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

/* Eight vectors of squares keep a lane below 2^31; then into 64 bits. */
static uint64_t ssd_i16(const int16_t *a, const int16_t *b, size_t n)
{
    const __m256i zero = _mm256_setzero_si256();
    __m256i sum = zero;
    uint64_t lanes[4];

    for (size_t i = 0; i < n;) {
        size_t end = n - i < 128 ? n : i + 128;
        __m256i part = zero;

        for (; i < end; i += 16)
            part = _mm256_add_epi32(part, squares(load(a + i), load(b + i)));
        sum = _mm256_add_epi64(sum, _mm256_unpacklo_epi32(part, zero));
        sum = _mm256_add_epi64(sum, _mm256_unpackhi_epi32(part, zero));
    }
    _mm256_storeu_si256((__m256i *)(void *)lanes, sum);
    return lanes[0] + lanes[1] + lanes[2] + lanes[3];
}

/* Eight positions and up to CELLS_AT_ONCE cells: one sum per position. */
static __m256i eight_positions(const int16_t *cells, const struct ttf_cell_target *targets,
                               size_t n_targets)
{
    __m256i a = _mm256_setzero_si256(), b = a, c = a, d = a, ab, cd;

    for (size_t i = 0; i < n_targets; i++) {
        const int16_t *at = cells + (size_t)targets[i].offset * TTF_CELL_DIMS;
        __m256i target = _mm256_broadcastsi128_si256(
            _mm_loadu_si128((const __m128i *)(const void *)targets[i].value));

        a = _mm256_add_epi32(a, squares(load(at), target));
        b = _mm256_add_epi32(b, squares(load(at + 16), target));
        c = _mm256_add_epi32(c, squares(load(at + 32), target));
        d = _mm256_add_epi32(d, squares(load(at + 48), target));
    }
    ab = _mm256_hadd_epi32(a, b);   /* 0 0 2 2 | 1 1 3 3 */
    cd = _mm256_hadd_epi32(c, d);   /* 4 4 6 6 | 5 5 7 7 */
    ab = _mm256_hadd_epi32(ab, cd); /* 0 2 4 6 | 1 3 5 7 */
    return _mm256_permutevar8x32_epi32(ab, _mm256_setr_epi32(0, 4, 1, 5, 2, 6, 3, 7));
}

static void bound_group(const int16_t *cells, const struct ttf_cell_target *targets,
                        size_t n_targets, uint32_t limit, uint32_t *bounds)
{
    __m256i sum = _mm256_setzero_si256();
    __m256i most = _mm256_set1_epi32((int)limit);

    for (size_t i = 0; i < n_targets; i += CELLS_AT_ONCE) {
        size_t n = n_targets - i < CELLS_AT_ONCE ? n_targets - i : CELLS_AT_ONCE;
        __m256i within;

        sum = _mm256_add_epi32(sum, eight_positions(cells, targets + i, n));
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

const struct ttf_rank_kernels *ttf_rank_kernels_avx2(void)
{
    static const struct ttf_rank_kernels kernels = {
        .name = "avx2",
        .ssd_i16 = ssd_i16,
        .bound_cells = bound_cells,
        .rotate4 = rotate4,
    };

    return __builtin_cpu_supports("avx2") ? &kernels : NULL;
}
