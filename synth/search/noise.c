/* SPDX-License-Identifier: Apache-2.0 */
#include <string.h>

#include "search/second_differences.h"
#include "search/trajectories.h"

#define PIXELS_MAX 65536u /* more pixels than these are sampled evenly */

double ttf_trajectories_noise(const struct ttf_trajectories *trajectories)
{
    size_t pixels = (size_t)trajectories->width * trajectories->height;
    size_t step = pixels / PIXELS_MAX + 1;
    uint64_t counts[TTF_SECOND_MAX + 1];

    memset(counts, 0, sizeof(counts));
    for (size_t p = 0; p < pixels; p += step) {
        const uint8_t *codes = ttf_trajectory(trajectories, p);

        for (size_t i = 0; i + 6 < trajectories->dims; i++) {
            int second = codes[i] - 2 * codes[i + 3] + codes[i + 6];

            counts[second < 0 ? -second : second]++;
        }
    }
    return ttf_second_differences_noise(counts);
}
