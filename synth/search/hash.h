/* SPDX-License-Identifier: Apache-2.0 */
/*
 * hash.h: all randomness of synthesis: a hash of (seed, what it is for, which
 * one). No state, so nothing depends on threads or on order.
 */
#ifndef TTF_SYNTH_SEARCH_HASH_H
#define TTF_SYNTH_SEARCH_HASH_H

#include <stdint.h>

/* What a random number is for. Values are part of what a seed means: never renumber. */
enum ttf_purpose {
    TTF_PURPOSE_BLOCK = 1,  /* the pick among a block's candidates */
    TTF_PURPOSE_FRAME = 2,  /* the seed of one frame quilted alone */
    TTF_PURPOSE_BASIS = 3,  /* start of the iteration that finds a basis */
    TTF_PURPOSE_JITTER = 4, /* steps of a block's time */
    TTF_PURPOSE_QUERY = 5,  /* queries that two searches are compared by */
    TTF_PURPOSE_CELLS = 6,  /* samples and a first guess of cells' directions */

    /* figures: 20..29 */
    TTF_PURPOSE_COLOUR_DIRECTION = 20, /* directions through RGB */
    TTF_PURPOSE_COLOUR_PIXEL = 21,     /* pixels of a picture too large to look at all */
    TTF_PURPOSE_SYNCHRONY_PARTNER = 22,
    TTF_PURPOSE_SYNCHRONY_PAIR = 23,
    TTF_PURPOSE_PATCH_DIRECTION = 24, /* directions through the space of patches */
    TTF_PURPOSE_PATCH = 25            /* patches whose nearest one is looked for */
};

/* A bijection of 64-bit words whose output bits all depend on all input bits. */
static inline uint64_t ttf_mix64(uint64_t x)
{
    x ^= x >> 32;
    x *= UINT64_C(0xd6e8feb86659fd93);
    x ^= x >> 32;
    x *= UINT64_C(0xd6e8feb86659fd93);
    x ^= x >> 32;
    return x;
}

static inline uint64_t ttf_random64(uint64_t seed, enum ttf_purpose purpose, uint64_t which)
{
    uint64_t x = ttf_mix64(seed + UINT64_C(0x9e3779b97f4a7c15));

    x = ttf_mix64(x ^ ((uint64_t)purpose * UINT64_C(0xbf58476d1ce4e5b9)));
    return ttf_mix64(x + which * UINT64_C(0x94d049bb133111eb));
}

/* 0..n-1 (n >= 1), by the upper bits: the bias is below n / 2^32. */
static inline uint32_t ttf_pick(uint64_t random, uint32_t n)
{
    return (uint32_t)(((random >> 32) * n) >> 32);
}

#endif
