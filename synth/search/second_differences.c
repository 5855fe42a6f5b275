/* SPDX-License-Identifier: Apache-2.0 */
#include "search/second_differences.h"

#include <string.h>

static size_t samples_of(size_t pixels)
{
    return pixels < TTF_SECOND_SAMPLES ? pixels : TTF_SECOND_SAMPLES;
}

static const uint8_t *sample_at(const uint8_t *codes, size_t pixels, size_t i)
{
    return codes + 3 * (pixels * i / samples_of(pixels));
}

void ttf_second_differences_add(struct ttf_second_differences *seconds, const uint8_t *codes,
                                size_t pixels)
{
    for (size_t i = 0; i < samples_of(pixels); i++) {
        const uint8_t *now = sample_at(codes, pixels, i);
        uint8_t *before = seconds->last[0][i], *earlier = seconds->last[1][i];

        for (int c = 0; c < 3; c++) {
            int second = now[c] - 2 * before[c] + earlier[c];

            if (seconds->frames >= 2)
                seconds->counts[second < 0 ? -second : second]++;
            earlier[c] = before[c];
            before[c] = now[c];
        }
    }
    seconds->frames++;
}

int ttf_second_differences_is_last(const struct ttf_second_differences *seconds,
                                   const uint8_t *codes, size_t pixels)
{
    for (size_t i = 0; i < samples_of(pixels); i++) {
        if (memcmp(seconds->last[0][i], sample_at(codes, pixels, i), 3) != 0)
            return 0;
    }
    return seconds->frames > 0;
}

double ttf_second_differences_noise(const uint64_t counts[TTF_SECOND_MAX + 1])
{
    const double rounding = 1.0 / 12.0;
    uint64_t all = 0, below = 0, squares = 0, used = 0, limit;
    unsigned median = 0;
    double variance;

    for (unsigned i = 0; i <= TTF_SECOND_MAX; i++)
        all += counts[i];
    if (all == 0)
        return rounding;
    while (median < TTF_SECOND_MAX && 2 * (below + counts[median]) < all)
        below += counts[median++];
    limit = median > 0 ? 5 * (uint64_t)median : 2;
    for (uint64_t i = 0; i <= TTF_SECOND_MAX && i <= limit; i++) {
        squares += i * i * counts[i];
        used += counts[i];
    }
    variance = (double)squares / (double)used / 6.0;
    return variance > rounding ? variance : rounding;
}
