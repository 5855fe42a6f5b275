/* SPDX-License-Identifier: Apache-2.0 */
/* draw.h: numbers from a seed (splitmix64), the same on every machine. */
#ifndef TTF_TESTS_CRASH_DRAW_H
#define TTF_TESTS_CRASH_DRAW_H

#include <stdint.h>

struct draw {
    uint64_t state;
};

static inline uint64_t draw_next(struct draw *draw)
{
    uint64_t z = draw->state += UINT64_C(0x9e3779b97f4a7c15);

    z = (z ^ z >> 30) * UINT64_C(0xbf58476d1ce4e5b9);
    z = (z ^ z >> 27) * UINT64_C(0x94d049bb133111eb);
    return z ^ z >> 31;
}

/* From 0 to n - 1; n > 0, small. */
static inline uint64_t draw_below(struct draw *draw, uint64_t n)
{
    return (draw_next(draw) >> 11) % n;
}

static inline void draw_seed(struct draw *draw, uint64_t seed)
{
    draw->state = seed * UINT64_C(0xd1342543de82ef95) + 1;
}

#endif
