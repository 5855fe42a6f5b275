/* SPDX-License-Identifier: Apache-2.0 */
#include <string.h>

#include "search/trajectories.h"

#define SECOND_MAX 510    /* of |a - 2 b + c| with 8-bit codes: 2 x 255 */
#define PIXELS_MAX 65536u /* more pixels than these are sampled evenly */

static void count_seconds(const struct ttf_trajectories *trajectories,
                          uint64_t counts[SECOND_MAX + 1])
{
    size_t pixels = (size_t)trajectories->width * trajectories->height;
    size_t step = pixels / PIXELS_MAX + 1;

    memset(counts, 0, (SECOND_MAX + 1) * sizeof(counts[0]));
    for (size_t p = 0; p < pixels; p += step) {
        const uint8_t *codes = ttf_trajectory(trajectories, p);

        for (size_t i = 0; i + 6 < trajectories->dims; i++) {
            int second = codes[i] - 2 * codes[i + 3] + codes[i + 6];

            counts[second < 0 ? -second : second]++;
        }
    }
}

double ttf_trajectories_noise(const struct ttf_trajectories *trajectories)
{
    const double rounding = 1.0 / 12.0;
    uint64_t counts[SECOND_MAX + 1];
    uint64_t all = 0, below = 0, squares = 0, used = 0, limit;
    unsigned median = 0;
    double variance;

    if (trajectories->frames < 3)
        return rounding;
    count_seconds(trajectories, counts);
    for (unsigned i = 0; i <= SECOND_MAX; i++)
        all += counts[i];
    while (2 * (below + counts[median]) < all)
        below += counts[median++];
    limit = median > 0 ? 5 * (uint64_t)median : 2;
    for (uint64_t i = 0; i <= SECOND_MAX && i <= limit; i++) {
        squares += i * i * counts[i];
        used += counts[i];
    }
    variance = (double)squares / (double)used / 6.0;
    return variance > rounding ? variance : rounding;
}
