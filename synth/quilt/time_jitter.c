/* SPDX-License-Identifier: Apache-2.0 */
#include "quilt/time_jitter.h"

#include <errno.h>
#include <stdlib.h>

#include "search/hash.h"

/* Frames that the offset takes from one whole number to the next. */
#define RAMP 2

/* The next d, or 0 where the offset would leave its bounds. */
static int64_t step(uint64_t own, uint32_t t, int64_t off, int64_t most)
{
    int64_t d = (int64_t)ttf_pick(ttf_random64(own, TTF_PURPOSE_JITTER, t), 2 * TTF_TIME_ONE + 1) -
                TTF_TIME_ONE;

    return off + d <= most && off + d >= -most ? d : 0;
}

static int64_t whole(int64_t off)
{
    int64_t half = TTF_TIME_ONE / 2;

    return off >= 0 ? (off + half) / TTF_TIME_ONE * TTF_TIME_ONE
                    : -((-off + half) / TTF_TIME_ONE * TTF_TIME_ONE);
}

/* Beyond the end of any input all times are the last one. */
static uint32_t clamped(int64_t time)
{
    return time < UINT32_MAX ? (uint32_t)time : UINT32_MAX;
}

void ttf_time_jitter(uint64_t seed, unsigned block, uint32_t e_frames, uint32_t every, uint32_t n,
                     uint32_t *ret)
{
    int64_t most = (int64_t)e_frames * TTF_TIME_ONE;
    uint64_t own = ttf_random64(seed, TTF_PURPOSE_JITTER, block);
    uint32_t phase = ttf_pick(ttf_mix64(own), every);
    int64_t walk = 0, off = 0; /* where f(t) - t is to go, and where it is */

    ret[0] = 0;
    for (uint32_t t = 1; t < n; t++) {
        int64_t target;

        if (t % every == phase || every == 1)
            walk += step(own, t, walk, most);
        target = every == 1 ? walk : whole(walk);
        if (every == 1 || off - target == 0)
            off = target;
        else
            off += target > off ? TTF_TIME_ONE / RAMP : -(int64_t)(TTF_TIME_ONE / RAMP);
        ret[t] = clamped((int64_t)t * TTF_TIME_ONE + off);
    }
}

int ttf_time_jitter_fill(uint64_t seed, uint32_t e_frames, uint32_t every, uint32_t n,
                         struct ttf_quilt_map *map)
{
    map->times = malloc((size_t)map->n_blocks * n * sizeof(*map->times));
    if (!map->times)
        return -ENOMEM;
    map->n_times = n;
    for (unsigned i = 0; i < map->n_blocks; i++)
        ttf_time_jitter(seed, i, e_frames, every, n, map->times + (size_t)i * n);
    return 0;
}

uint32_t ttf_time_at(const uint32_t *times, uint32_t n, uint64_t time)
{
    uint64_t last = (uint64_t)(n - 1) * TTF_TIME_ONE;
    uint32_t frame, part;
    uint64_t value;

    if (time > last)
        time = last;
    if (!times)
        return (uint32_t)time;
    frame = (uint32_t)(time / TTF_TIME_ONE);
    part = (uint32_t)(time % TTF_TIME_ONE);
    value = times[frame];
    if (part > 0)
        value += ((uint64_t)(times[frame + 1] - times[frame]) * part) >> 16;
    return (uint32_t)(value < last ? value : last);
}
