/* SPDX-License-Identifier: Apache-2.0 */
/* Compiled with -mavx512bw on x86-64 (synth/CMakeLists.txt); never entered without a look at the processor. */
#include <immintrin.h>

#include "search/rank_kernels.h"
#include "search/rank_rotate.h"

/* Cells added before the sums are looked at. */
#define CELLS_AT_ONCE 16

static __m512i load(const int16_t *p)
{
    return _mm512_loadu_si512((const void *)p);
}

static __m512i squares(__m512i a, __m512i b)
{
    __m512i d = _mm512_sub_epi16(a, b);

    return _mm512_madd_epi16(d, d);
}

/* Eight vectors of squares keep a lane below 2^31; then into 64 bits. What is no whole vector is masked. */
static uint64_t ssd_i16(const int16_t *a, const int16_t *b, size_t n)
{
    __m512i sum = _mm512_setzero_si512();

    for (size_t i = 0; i < n;) {
        size_t end = n - i < 256 ? n : i + 256;
        __m512i part = _mm512_setzero_si512();

        for (; i + 32 <= end; i += 32)
            part = _mm512_add_epi32(part, squares(load(a + i), load(b + i)));
        if (i < end) {
            part = _mm512_add_epi32(part, squares(_mm512_maskz_loadu_epi16(0xffff, a + i),
                                                  _mm512_maskz_loadu_epi16(0xffff, b + i)));
            i = end;
        }
        sum = _mm512_add_epi64(sum, _mm512_cvtepu32_epi64(_mm512_castsi512_si256(part)));
        sum = _mm512_add_epi64(sum, _mm512_cvtepu32_epi64(_mm512_extracti64x4_epi64(part, 1)));
    }
    return (uint64_t)_mm512_reduce_add_epi64(sum);
}

/* The sums of four lanes each of four vectors, in the order of positions. */
static __m512i gather_sums(__m512i a, __m512i b, __m512i c, __m512i d)
{
    const __m512i order = _mm512_setr_epi32(0, 4, 8, 12, 1, 5, 9, 13, 2, 6, 10, 14, 3, 7, 11, 15);
    __m512i ab = _mm512_add_epi32(_mm512_unpacklo_epi32(a, b), _mm512_unpackhi_epi32(a, b));
    __m512i cd = _mm512_add_epi32(_mm512_unpacklo_epi32(c, d), _mm512_unpackhi_epi32(c, d));
    __m512i all = _mm512_add_epi32(_mm512_unpacklo_epi64(ab, cd), _mm512_unpackhi_epi64(ab, cd));

    /* in each 128 bits now: a, b, c, d of one position */
    return _mm512_permutexvar_epi32(order, all);
}

static __m512i sixteen_positions(const int16_t *cells, const struct ttf_cell_target *targets,
                                 size_t n_targets)
{
    __m512i a = _mm512_setzero_si512(), b = a, c = a, d = a;

    for (size_t i = 0; i < n_targets; i++) {
        const int16_t *at = cells + (size_t)targets[i].offset * TTF_CELL_DIMS;
        __m512i target = _mm512_broadcast_i32x4(
            _mm_loadu_si128((const __m128i *)(const void *)targets[i].value));

        a = _mm512_add_epi32(a, squares(load(at), target));
        b = _mm512_add_epi32(b, squares(load(at + 32), target));
        c = _mm512_add_epi32(c, squares(load(at + 64), target));
        d = _mm512_add_epi32(d, squares(load(at + 96), target));
    }
    return gather_sums(a, b, c, d);
}

static void bound_group(const int16_t *cells, const struct ttf_cell_target *targets,
                        size_t n_targets, uint32_t limit, uint32_t *bounds)
{
    __m512i sum = _mm512_setzero_si512();
    __m512i most = _mm512_set1_epi32((int)limit);

    for (size_t i = 0; i < n_targets; i += CELLS_AT_ONCE) {
        size_t n = n_targets - i < CELLS_AT_ONCE ? n_targets - i : CELLS_AT_ONCE;

        sum = _mm512_add_epi32(sum, sixteen_positions(cells, targets + i, n));
        if (_mm512_cmple_epu32_mask(sum, most) == 0)
            break;
    }
    _mm512_storeu_si512((void *)bounds, sum);
}

static void bound_cells(const int16_t *cells, const struct ttf_cell_target *targets,
                        size_t n_targets, size_t n, uint32_t limit, uint32_t *bounds)
{
    size_t x = 0;

    if (n < 16) {
        ttf_rank_kernels_scalar()->bound_cells(cells, targets, n_targets, n, limit, bounds);
        return;
    }
    for (; x + 16 <= n; x += 16)
        bound_group(cells + x * TTF_CELL_DIMS, targets, n_targets, limit, bounds + x);
    if (x < n)
        bound_group(cells + (n - 16) * TTF_CELL_DIMS, targets, n_targets, limit, bounds + n - 16);
}

const struct ttf_rank_kernels *ttf_rank_kernels_avx512(void)
{
    static const struct ttf_rank_kernels kernels = {
        .name = "avx512",
        .ssd_i16 = ssd_i16,
        .bound_cells = bound_cells,
        .rotate4 = rotate4,
    };

    return __builtin_cpu_supports("avx512bw") ? &kernels : NULL;
}
