/* SPDX-License-Identifier: Apache-2.0 */
/* rank_four.h: sums of four places side by side in vectors of 256 bits, compiled once per instruction set; all is static. */
#ifndef TTF_SYNTH_SEARCH_RANK_FOUR_H
#define TTF_SYNTH_SEARCH_RANK_FOUR_H

#include <immintrin.h>
#include <stddef.h>
#include <stdint.h>

/* Vectors whose squares fit a lane, even and odd ones apart: 32 times two times 8180^2. */
#define TOGETHER 64u

/* Sums of four places: of vectors with even and with odd indices (one alone would wait for itself), and what has been moved out of them. */
struct four {
    __m256i even[4], odd[4], sums[4];
};

/* Half vectors: pixels and cells are of that size, and none lies across two lines of the cache. */
static inline __m256i load_16(const int16_t *p)
{
    return _mm256_loadu_si256((const __m256i *)(const void *)p);
}

static inline __m256i add_squares_16(__m256i sum, const int16_t *a, __m256i b)
{
    __m256i d = _mm256_sub_epi16(b, load_16(a)); /* this way around it is read by the subtraction */

#ifdef __AVX512VNNI__
    return _mm256_dpwssd_epi32(sum, d, d);
#else
    return _mm256_add_epi32(sum, _mm256_madd_epi16(d, d));
#endif
}

/* Lanes of 32 bits, taken as unsigned, added to those of 64. */
static inline __m256i widen_16(__m256i sum, __m256i part)
{
    sum = _mm256_add_epi64(sum, _mm256_cvtepu32_epi64(_mm256_castsi256_si128(part)));
    return _mm256_add_epi64(sum, _mm256_cvtepu32_epi64(_mm256_extracti128_si256(part, 1)));
}

static inline __attribute__((always_inline)) void move_out(struct four *f)
{
    for (int k = 0; k < 4; k++) {
        f->sums[k] = widen_16(widen_16(f->sums[k], f->even[k]), f->odd[k]);
        f->even[k] = f->odd[k] = _mm256_setzero_si256();
    }
}

static inline __attribute__((always_inline)) void add_vectors(struct four *f,
                                                              const int16_t *const a[4],
                                                              const uint32_t *offsets,
                                                              const int16_t *b, size_t n)
{
    size_t i = 0;

    for (; i + 2 <= n; i += 2) {
        size_t first = (size_t)offsets[i] * 16, second = (size_t)offsets[i + 1] * 16;
        __m256i own = load_16(b + i * 16), next = load_16(b + i * 16 + 16);

        for (int k = 0; k < 4; k++) {
            f->even[k] = add_squares_16(f->even[k], a[k] + first, own);
            f->odd[k] = add_squares_16(f->odd[k], a[k] + second, next);
        }
    }
    for (int k = 0; i < n && k < 4; k++)
        f->even[k] =
            add_squares_16(f->even[k], a[k] + (size_t)offsets[i] * 16, load_16(b + i * 16));
}

/* The sums of the lanes of four vectors. */
static inline __m256i sums_of_four(const __m256i v[4])
{
    __m256i low =
        _mm256_add_epi64(_mm256_unpacklo_epi64(v[0], v[1]), _mm256_unpackhi_epi64(v[0], v[1]));
    __m256i high =
        _mm256_add_epi64(_mm256_unpacklo_epi64(v[2], v[3]), _mm256_unpackhi_epi64(v[2], v[3]));

    return _mm256_add_epi64(_mm256_permute2x128_si256(low, high, 0x20),
                            _mm256_permute2x128_si256(low, high, 0x31));
}

/* look: vectors between looks at the limit, in TOGETHERs. */
static inline __attribute__((always_inline)) void
four_places(const int16_t *const a[4], const uint32_t *offsets, const int16_t *b, size_t n,
            uint64_t limit, size_t look, uint64_t ret[4])
{
    /* compared as signed numbers */
    const __m256i limits = _mm256_set1_epi64x((int64_t)(limit < INT64_MAX ? limit : INT64_MAX));
    const int16_t *const at[4] = {a[0], a[1], a[2], a[3]};
    __m256i sums = _mm256_setzero_si256();
    struct four f;

    for (int k = 0; k < 4; k++)
        f.even[k] = f.odd[k] = f.sums[k] = sums;
    for (size_t i = 0; i < n;) {
        size_t end = n - i < TOGETHER * look ? n : i + TOGETHER * look;

        for (size_t most; i < end; i += most) {
            most = end - i < TOGETHER ? end - i : TOGETHER;
            add_vectors(&f, at, offsets + i, b + i * 16, most);
            move_out(&f);
        }
        sums = sums_of_four(f.sums);
        if (_mm256_movemask_epi8(_mm256_cmpgt_epi64(sums, limits)) == -1)
            break;
    }
    _mm256_storeu_si256((__m256i *)(void *)ret, sums);
}

static void ssd_at4(const int16_t *const a[4], const uint32_t *offsets, const int16_t *b, size_t n,
                    uint64_t limit, uint64_t ret[4])
{
    four_places(a, offsets, b, n, limit, 2, ret);
}

#endif
