/* SPDX-License-Identifier: Apache-2.0 */
#include "metrics/sliced.h"

#include <math.h>

/*
 * A sum of twelve uniform numbers is so near to normal that directions made of such
 * sums are even over the sphere, and it takes no function of libm whose last bit
 * depends on the machine.
 */
static int32_t nearly_normal(enum ttf_purpose purpose, uint64_t which)
{
    int32_t sum = -12 * 65535 / 2;

    for (unsigned word = 0; word < 3; word++) {
        uint64_t random = ttf_random64(0, purpose, which * 3 + word);

        for (unsigned i = 0; i < 4; i++)
            sum += (int32_t)(random >> (16 * i) & 0xffff);
    }
    return sum;
}

void ttf_sliced_direction(enum ttf_purpose purpose, unsigned which, unsigned n, int16_t *ret)
{
    int32_t v[TTF_SLICED_DIMENSIONS];
    uint64_t square = 0;
    double scale;

    for (unsigned i = 0; i < n; i++) {
        v[i] = nearly_normal(purpose, (uint64_t)which * n + i);
        square += (uint64_t)((int64_t)v[i] * v[i]);
    }
    /* the square root of IEEE 754 is rounded exactly, as are products: the same bits everywhere */
    scale = TTF_SLICED_UNIT / sqrt((double)square);
    for (unsigned i = 0; i < n; i++)
        ret[i] = (int16_t)floor(v[i] * scale + 0.5);
}

int32_t ttf_sliced_offset(const int16_t *direction, unsigned n)
{
    int32_t sum = 0;

    for (unsigned i = 0; i < n; i++)
        sum += direction[i] < 0 ? -255 * direction[i] : 0;
    return sum;
}

unsigned ttf_sliced_bins(const int16_t *direction, unsigned n)
{
    int32_t span = 0;

    for (unsigned i = 0; i < n; i++)
        span += 255 * (direction[i] < 0 ? -direction[i] : direction[i]);
    return ((unsigned)span >> TTF_SLICED_SHIFT) + 1;
}

double ttf_sliced_distance(const uint32_t *a, uint64_t n_a, const uint32_t *b, uint64_t n_b,
                           unsigned bins)
{
    uint64_t below_a = 0, below_b = 0;
    double sum = 0.0;

    /* the area between the two cumulative distributions, each step an exact integer */
    for (unsigned i = 0; i < bins; i++) {
        below_a += a[i];
        below_b += b[i];
        uint64_t x = below_a * n_b, y = below_b * n_a;

        sum += (double)(x > y ? x - y : y - x);
    }
    return sum / ((double)n_a * (double)n_b) / TTF_SLICED_BINS_PER_CODE;
}
