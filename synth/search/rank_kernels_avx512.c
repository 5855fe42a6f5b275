/* SPDX-License-Identifier: Apache-2.0 */
/* Compiled with -mavx512bw, -mavx512vl, -mavx512dq and -mavx512vnni on x86-64 (synth/CMakeLists.txt); never entered without a look at the processor. */
#include <immintrin.h>

#include "search/rank_four.h"
#include "search/rank_kernels.h"
#include "search/rank_rotate.h"

/* Cells added before the sums are looked at: 16 x 16 x 2046^2 and a clipped sum fit 32 bits. Fewer at first: where a limit is near, they do. */
#define CELLS_AT_ONCE 16
#define CELLS_FIRST   8

/* Vectors of a row that are compared together, at most: they stay in registers, with sixteen places' sums. */
#define FOLLOWERS 8

static __m512i load(const int16_t *p)
{
    return _mm512_loadu_si512((const void *)p);
}

/* Adds the squares of the differences of neighbouring pairs to each lane. */
static __m512i add_squares(__m512i sum, __m512i a, __m512i b)
{
    __m512i d = _mm512_sub_epi16(a, b);

    return _mm512_dpwssd_epi32(sum, d, d);
}

static __m512i load_half(const int16_t *p)
{
    return _mm512_maskz_loadu_epi16(0xffff, p);
}

/* Lanes of 32 bits, taken as unsigned, added to those of 64. */
static __m512i widen(__m512i sum, __m512i part)
{
    sum = _mm512_add_epi64(sum, _mm512_cvtepu32_epi64(_mm512_castsi512_si256(part)));
    return _mm512_add_epi64(sum, _mm512_cvtepu32_epi64(_mm512_extracti64x4_epi64(part, 1)));
}

/* Numbers whose squares fit a lane: 16 vectors of two times 8180^2. */
#define PART_NUMBERS 512u

/* What is no whole vector is masked. */
static __m512i add_run(__m512i sum, const int16_t *a, const int16_t *b, size_t n)
{
    for (size_t i = 0; i < n;) {
        size_t end = n - i < PART_NUMBERS ? n : i + PART_NUMBERS;
        __m512i part = _mm512_setzero_si512();

        for (; i + 32 <= end; i += 32)
            part = add_squares(part, load(a + i), load(b + i));
        if (i < end) {
            part = add_squares(part, load_half(a + i), load_half(b + i));
            i = end;
        }
        sum = widen(sum, part);
    }
    return sum;
}

static uint64_t ssd_i16(const int16_t *a, const int16_t *b, size_t n)
{
    return (uint64_t)_mm512_reduce_add_epi64(add_run(_mm512_setzero_si512(), a, b, n));
}

/*
 * The sums of the halves of eight vectors: vector k holds positions 2 k and 2 k + 1. Pairs are
 * added until one number of each is left, then put in order.
 */
static __m512i gather_sums(const __m512i v[8])
{
    const __m512i order = _mm512_setr_epi32(0, 8, 1, 9, 2, 10, 3, 11, 4, 12, 5, 13, 6, 14, 7, 15);
    __m512i pair[4], four[2], low, high;

    for (int k = 0; k < 4; k++)
        pair[k] = _mm512_add_epi32(_mm512_unpacklo_epi32(v[2 * k], v[2 * k + 1]),
                                   _mm512_unpackhi_epi32(v[2 * k], v[2 * k + 1]));
    for (int k = 0; k < 2; k++)
        four[k] = _mm512_add_epi32(_mm512_unpacklo_epi64(pair[2 * k], pair[2 * k + 1]),
                                   _mm512_unpackhi_epi64(pair[2 * k], pair[2 * k + 1]));
    /* in each 128 bits: vectors 0 to 3 (4 to 7); two such parts make up a position */
    low = _mm512_shuffle_i64x2(four[0], four[1], 0x88);  /* parts 0, 2 of each */
    high = _mm512_shuffle_i64x2(four[0], four[1], 0xdd); /* parts 1, 3 of each */
    low = _mm512_add_epi32(low, high);
    /* now: first positions of 0-3, second of 0-3, first of 4-7, second of 4-7 */
    low = _mm512_shuffle_i64x2(low, low, 0xd8);
    return _mm512_permutexvar_epi32(order, low);
}

/* Sixteen positions, two to a vector, and up to CELLS_AT_ONCE cells: one sum per position. */
static __m512i sixteen_positions(const int16_t *cells, const struct ttf_cell_target *targets,
                                 size_t n_targets)
{
    __m512i sums[8];

    for (int k = 0; k < 8; k++)
        sums[k] = _mm512_setzero_si512();
    for (size_t i = 0; i < n_targets; i++) {
        const int16_t *at = cells + (size_t)targets[i].offset * TTF_CELL_DIMS;
        __m512i target = _mm512_broadcast_i64x4(
            _mm256_loadu_si256((const __m256i *)(const void *)targets[i].value));

        for (int k = 0; k < 8; k++)
            sums[k] = add_squares(sums[k], target, load(at + (size_t)k * 2 * TTF_CELL_DIMS));
    }
    return gather_sums(sums);
}

static void bound_group(const int16_t *cells, const struct ttf_cell_target *targets,
                        size_t n_targets, uint32_t limit, uint32_t *bounds)
{
    __m512i sum = _mm512_setzero_si512();
    __m512i most = _mm512_set1_epi32((int)limit);
    __m512i clip = _mm512_set1_epi32((int)TTF_BOUND_MAX);

    for (size_t i = 0, n; i < n_targets; i += n) {
        n = i == 0 ? CELLS_FIRST : CELLS_AT_ONCE;
        n = n_targets - i < n ? n_targets - i : n;
        sum =
            _mm512_min_epu32(_mm512_add_epi32(sum, sixteen_positions(cells, targets + i, n)), clip);
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

/* Two neighbours' sums in the halves of each vector, of vectors with even and with odd indices (one alone would wait for itself). */
struct pairs {
    __m512i even[4], odd[4];
};

static inline __attribute__((always_inline)) struct pairs
sums_of_pairs(const int16_t *const a[4], const uint32_t *offsets, const int16_t *b, size_t n)
{
    const int16_t *a0 = a[0], *a1 = a[1], *a2 = a[2], *a3 = a[3];
    __m512i zero = _mm512_setzero_si512();
    __m512i s0 = zero, s1 = zero, s2 = zero, s3 = zero, t0 = zero, t1 = zero, t2 = zero, t3 = zero;
    size_t i = 0;

    for (; i + 2 <= n; i += 2) {
        size_t first = (size_t)offsets[i] * 16, second = (size_t)offsets[i + 1] * 16;
        __m512i own = _mm512_broadcast_i64x4(load_16(b + i * 16));
        __m512i next = _mm512_broadcast_i64x4(load_16(b + i * 16 + 16));

        s0 = add_squares(s0, own, load(a0 + first));
        s1 = add_squares(s1, own, load(a1 + first));
        s2 = add_squares(s2, own, load(a2 + first));
        s3 = add_squares(s3, own, load(a3 + first));
        t0 = add_squares(t0, next, load(a0 + second));
        t1 = add_squares(t1, next, load(a1 + second));
        t2 = add_squares(t2, next, load(a2 + second));
        t3 = add_squares(t3, next, load(a3 + second));
    }
    if (i < n) {
        size_t last = (size_t)offsets[i] * 16;
        __m512i own = _mm512_broadcast_i64x4(load_16(b + i * 16));

        s0 = add_squares(s0, own, load(a0 + last));
        s1 = add_squares(s1, own, load(a1 + last));
        s2 = add_squares(s2, own, load(a2 + last));
        s3 = add_squares(s3, own, load(a3 + last));
    }
    return (struct pairs){{s0, s1, s2, s3}, {t0, t1, t2, t3}};
}

/* Eight lanes of 64 bits of each of four vectors to the sums of their halves, in order. */
static __m512i sums_of_halves(const __m512i v[4])
{
    const __m512i order = _mm512_setr_epi64(0, 2, 1, 3, 4, 6, 5, 7);
    __m512i low =
        _mm512_add_epi64(_mm512_unpacklo_epi64(v[0], v[1]), _mm512_unpackhi_epi64(v[0], v[1]));
    __m512i high =
        _mm512_add_epi64(_mm512_unpacklo_epi64(v[2], v[3]), _mm512_unpackhi_epi64(v[2], v[3]));

    return _mm512_permutexvar_epi64(order, _mm512_add_epi64(_mm512_shuffle_i64x2(low, high, 0x88),
                                                            _mm512_shuffle_i64x2(low, high, 0xdd)));
}

/* Neighbouring lanes of 32 bits, taken as unsigned, added to theirs of 64: halves stay apart. */
static inline __m512i widen_lanes(__m512i sum, __m512i part, __m512i low)
{
    sum = _mm512_add_epi64(sum, _mm512_and_si512(part, low));
    return _mm512_add_epi64(sum, _mm512_srli_epi64(part, 32));
}

static void ssd_at_pairs(const int16_t *const a[4], const uint32_t *offsets, const int16_t *b,
                         size_t n, uint64_t limit, uint64_t ret[8])
{
    const __m512i low = _mm512_set1_epi64(0xffffffff), most = _mm512_set1_epi64((int64_t)limit);
    __m512i wide[4], sums = _mm512_setzero_si512();

    for (int k = 0; k < 4; k++)
        wide[k] = _mm512_setzero_si512();
    for (size_t i = 0; i < n; i += TOGETHER) {
        struct pairs pairs =
            sums_of_pairs(a, offsets + i, b + i * 16, n - i < TOGETHER ? n - i : TOGETHER);

        for (int k = 0; k < 4; k++)
            wide[k] = widen_lanes(widen_lanes(wide[k], pairs.even[k], low), pairs.odd[k], low);
        sums = sums_of_halves(wide);
        if (_mm512_cmple_epu64_mask(sums, most) == 0)
            break;
    }
    _mm512_storeu_si512((void *)ret, sums);
}

/* Vectors that follow one another at sixteen places, two to a vector of 512 bits; n is known to the compiler. */
static inline __attribute__((always_inline)) void add_followers(__m512i sums[8], const int16_t *a,
                                                                const int16_t *b, const int n)
{
    __m512i own[FOLLOWERS];

#pragma GCC unroll 8
    for (int i = 0; i < n; i++)
        own[i] = _mm512_broadcast_i64x4(load_16(b + i * 16));
#pragma GCC unroll 16
    for (int at = 0; at < n + 7; at++) {
        __m512i there = load(a + at * 32);

#pragma GCC unroll 8
        for (int i = 0; i < n; i++) {
            if (at - i >= 0 && at - i < 8)
                sums[at - i] = add_squares(sums[at - i], own[i], there);
        }
    }
}

/* How many of n vectors follow one another, two places apart. */
static size_t count_followers(const uint32_t *offsets, size_t n)
{
    size_t i = 1;

    n = n < FOLLOWERS ? n : FOLLOWERS;
    while (i < n && offsets[i] == offsets[i - 1] + 2)
        i++;
    return i;
}

static inline __attribute__((always_inline)) void add_vectors_of_row(__m512i sums[8],
                                                                     const int16_t *a,
                                                                     const uint32_t *offsets,
                                                                     const int16_t *b, size_t n)
{
    for (size_t i = 0, m; i < n; i += m) {
        const int16_t *at = a + (size_t)offsets[i] * 16, *own = b + i * 16;

        m = count_followers(offsets + i, n - i);
        if (m == 8)
            add_followers(sums, at, own, 8);
        else if (m >= 5)
            add_followers(sums, at, own, (int)(m = 5));
        else if (m >= 2)
            add_followers(sums, at, own, (int)(m = 2));
        else
            add_followers(sums, at, own, 1);
    }
}

/* A lane holds the squares of TOGETHER cells' pairs of numbers: 64 times two times 2046^2. */
static void ssd_at_row(const int16_t *a, const uint32_t *offsets, const int16_t *b, size_t n,
                       uint64_t limit, uint64_t ret[TTF_ROW_PLACES])
{
    const __m512i low = _mm512_set1_epi64(0xffffffff), most = _mm512_set1_epi64((int64_t)limit);
    __m512i wide[8], first = _mm512_setzero_si512(), second = first;

    for (int k = 0; k < 8; k++)
        wide[k] = first;
    for (size_t i = 0; i < n; i += TOGETHER) {
        __m512i sums[8];

        for (int k = 0; k < 8; k++)
            sums[k] = _mm512_setzero_si512();
        add_vectors_of_row(sums, a, offsets + i, b + i * 16, n - i < TOGETHER ? n - i : TOGETHER);
        for (int k = 0; k < 8; k++)
            wide[k] = widen_lanes(wide[k], sums[k], low);
        first = sums_of_halves(wide);
        second = sums_of_halves(wide + 4);
        if (_mm512_cmple_epu64_mask(first, most) == 0 && _mm512_cmple_epu64_mask(second, most) == 0)
            break;
    }
    _mm512_storeu_si512((void *)ret, first);
    _mm512_storeu_si512((void *)(ret + 8), second);
}

typedef float rotate_v16 __attribute__((vector_size(64)));

/* Sixteen numbers of four pixels. */
static void rotate_16(const float *w, size_t dims, size_t room, const float *in, size_t in_stride,
                      float *out)
{
    rotate_v16 sums[4] = {{0}};

    for (size_t i = 0; i < dims; i++) {
        rotate_v16 row;

        memcpy(&row, w + i * room, sizeof(row));
        for (size_t p = 0; p < 4; p++)
            sums[p] += row * in[p * in_stride + i];
    }
    for (size_t p = 0; p < 4; p++)
        memcpy(out + p * room, &sums[p], sizeof(sums[p]));
}

typedef float rotate_v8 __attribute__((vector_size(32)));

/* Twenty-four, as many as rank 15 has room for: each number of a pixel is loaded once for all. */
static void rotate_24(const float *w, size_t dims, size_t room, const float *in, size_t in_stride,
                      float *out)
{
    rotate_v16 wide[4] = {{0}};
    rotate_v8 rest[4] = {{0}};

    for (size_t i = 0; i < dims; i++) {
        rotate_v16 row;
        rotate_v8 more;

        memcpy(&row, w + i * room, sizeof(row));
        memcpy(&more, w + i * room + 16, sizeof(more));
        for (size_t p = 0; p < 4; p++) {
            wide[p] += row * in[p * in_stride + i];
            rest[p] += more * in[p * in_stride + i];
        }
    }
    for (size_t p = 0; p < 4; p++) {
        memcpy(out + p * room, &wide[p], sizeof(wide[p]));
        memcpy(out + p * room + 16, &rest[p], sizeof(rest[p]));
    }
}

static void rotate4_wide(const float *w, size_t dims, size_t room, const float *in,
                         size_t in_stride, float *out)
{
    size_t r = 0;

    for (; r + 24 <= room; r += 24)
        rotate_24(w + r, dims, room, in, in_stride, out + r);
    for (; r + 16 <= room; r += 16)
        rotate_16(w + r, dims, room, in, in_stride, out + r);
    if (r < room)
        rotate_8(w + r, dims, room, in, in_stride, out + r);
}

const struct ttf_rank_kernels *ttf_rank_kernels_avx512(void)
{
    static const struct ttf_rank_kernels kernels = {
        .name = "avx512",
        .ssd_i16 = ssd_i16,
        .ssd_at4 = ssd_at4,
        .ssd_at_pairs = ssd_at_pairs,
        .ssd_at_row = ssd_at_row,
        .bound_cells = bound_cells,
        .rotate4 = rotate4_wide,
    };

    return __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512vl") &&
                   __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vnni")
               ? &kernels
               : NULL;
}
