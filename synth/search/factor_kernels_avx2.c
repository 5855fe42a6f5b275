/* SPDX-License-Identifier: Apache-2.0 */
/* Compiled with -mavx2 on x86-64 (synth/CMakeLists.txt); never entered without a look at the processor. */
#include <immintrin.h>
#include <string.h>

#include "search/factor_kernels.h"

/* The twelve codes of four pixels, each pixel's with a 0 behind it. */
static __m128i codes_of_four(const uint8_t *codes)
{
    const __m128i apart = _mm_setr_epi8(0, 1, 2, -1, 3, 4, 5, -1, 6, 7, 8, -1, 9, 10, 11, -1);
    int64_t first;
    int32_t last;

    memcpy(&first, codes, sizeof(first));
    memcpy(&last, codes + sizeof(first), sizeof(last));
    return _mm_shuffle_epi8(_mm_insert_epi32(_mm_cvtsi64_si128(first), last, 2), apart);
}

/* Each pixel's squares summed in its own half. */
struct squares {
    __m256 low, high;
};

/* What is too much, behind a frame's three, is overwritten by the next. */
static struct squares codes4(const uint8_t *codes, float *out, size_t out_stride,
                             struct squares sums)
{
    __m128i four = codes_of_four(codes);
    __m256 low = _mm256_cvtepi32_ps(_mm256_cvtepu8_epi32(four));
    __m256 high = _mm256_cvtepi32_ps(_mm256_cvtepu8_epi32(_mm_srli_si128(four, 8)));

    _mm_storeu_ps(out, _mm256_castps256_ps128(low));
    _mm_storeu_ps(out + out_stride, _mm256_extractf128_ps(low, 1));
    _mm_storeu_ps(out + 2 * out_stride, _mm256_castps256_ps128(high));
    _mm_storeu_ps(out + 3 * out_stride, _mm256_extractf128_ps(high, 1));
    sums.low = _mm256_add_ps(sums.low, _mm256_mul_ps(low, low));
    sums.high = _mm256_add_ps(sums.high, _mm256_mul_ps(high, high));
    return sums;
}

static void rows4(const float *coefs, size_t room, const uint8_t *const *frames, unsigned n,
                  size_t pixel, float *out, size_t out_stride, uint32_t energy[4])
{
    struct squares sums = {_mm256_setzero_ps(), _mm256_setzero_ps()};
    float lanes[16];

    for (size_t p = 0; p < 4; p++) {
        for (size_t k = 0; k < room; k += 8)
            _mm256_storeu_ps(out + p * out_stride + k, _mm256_loadu_ps(coefs + p * room + k));
    }
    for (size_t t = 0; t < n; t++)
        sums = codes4(frames[t] + 3 * pixel, out + room + 3 * t, out_stride, sums);
    _mm256_storeu_ps(lanes, sums.low);
    _mm256_storeu_ps(lanes + 8, sums.high);
    for (size_t p = 0; p < 4; p++)
        energy[p] = (uint32_t)(lanes[4 * p] + lanes[4 * p + 1] + lanes[4 * p + 2]);
}

static __m256d add_product(__m256d sum, double own, const double *others)
{
    return _mm256_add_pd(sum, _mm256_mul_pd(_mm256_set1_pd(own), _mm256_loadu_pd(others)));
}

static void add_gram4(const double *rows, size_t row_stride, size_t dims, double *gram)
{
    const double *a = rows, *b = a + row_stride, *c = b + row_stride, *d = c + row_stride;

    for (size_t i = 0; i < dims; i++) {
        double *to = gram + i * dims;
        size_t j = 0;

        for (; j + 4 <= i + 1; j += 4) {
            __m256d sum = _mm256_loadu_pd(to + j);

            sum = add_product(sum, a[i], a + j);
            sum = add_product(sum, b[i], b + j);
            sum = add_product(sum, c[i], c + j);
            sum = add_product(sum, d[i], d + j);
            _mm256_storeu_pd(to + j, sum);
        }
        for (; j <= i; j++)
            to[j] = to[j] + a[i] * a[j] + b[i] * b[j] + c[i] * c[j] + d[i] * d[j];
    }
}

const struct ttf_factor_kernels *ttf_factor_kernels_avx2(void)
{
    static const struct ttf_factor_kernels kernels = {"avx2", rows4, add_gram4};

    return __builtin_cpu_supports("avx2") ? &kernels : NULL;
}
