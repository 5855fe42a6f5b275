/* SPDX-License-Identifier: Apache-2.0 */
/*
 * kernels_vector.h: the kernels in GCC vector types, compiled once for the
 * baseline and once for AVX2. Include it in one .c file per instruction set; all is static.
 */
#ifndef TTF_SYNTH_SEARCH_KERNELS_VECTOR_H
#define TTF_SYNTH_SEARCH_KERNELS_VECTOR_H

#include <string.h>

#include "search/kernels.h"

#ifdef __AVX2__
#define LANES 8
#else
#define LANES 4
#endif

typedef float vector_f32 __attribute__((vector_size(LANES * sizeof(float))));

/* 255^2 times this many bytes fits 31 bits. */
#define SSD_CHUNK ((size_t)32768)

/* Left to the compiler's vectorizer: differences as 16 bits, products summed in 32. */
static uint32_t ssd_chunk(const uint8_t *a, const uint8_t *b, size_t n)
{
    int32_t sum = 0;

    for (size_t i = 0; i < n; i++) {
        int16_t d = (int16_t)(a[i] - b[i]);

        sum += d * d;
    }
    return (uint32_t)sum;
}

static uint64_t ssd_u8(const uint8_t *a, const uint8_t *b, size_t n)
{
    uint64_t sum = 0;

    while (n > SSD_CHUNK) {
        sum += ssd_chunk(a, b, SSD_CHUNK);
        a += SSD_CHUNK;
        b += SSD_CHUNK;
        n -= SSD_CHUNK;
    }
    return sum + ssd_chunk(a, b, n);
}

static vector_f32 load(const float *p)
{
    vector_f32 v;

    memcpy(&v, p, sizeof(v));
    return v;
}

static float ssd_f32(const float *a, const float *b, size_t n)
{
    vector_f32 even = {0}, odd = {0};
    float sum = 0.0f;

    for (size_t i = 0; i < n; i += 2 * (size_t)LANES) {
        vector_f32 d = load(a + i) - load(b + i);
        vector_f32 e = load(a + i + LANES) - load(b + i + LANES);

        even += d * d;
        odd += e * e;
    }
    even += odd;
    for (int i = 0; i < LANES; i++)
        sum += even[i];
    return sum;
}

static void add_cells(float *acc, const float *const plane[TTF_CELL_PLANES],
                      const float target[TTF_CELL_PLANES], size_t n)
{
    size_t x = 0;

    for (; x + LANES <= n; x += LANES) {
        vector_f32 sum = load(acc + x);

        for (int d = 0; d < TTF_CELL_PLANES; d++) {
            vector_f32 diff = load(plane[d] + x) - target[d];

            sum += diff * diff;
        }
        memcpy(acc + x, &sum, sizeof(sum));
    }
    for (; x < n; x++) {
        for (int d = 0; d < TTF_CELL_PLANES; d++) {
            float diff = plane[d][x] - target[d];

            acc[x] += diff * diff;
        }
    }
}

#endif
