/* SPDX-License-Identifier: Apache-2.0 */
/*
 * noise.h: random numbers by counting, not by state. Private to hal/sim's image
 * model and scenes.
 *
 * Every draw is a hash of (stream, index), so the same place and time get the same
 * number in any order, on any thread. A stream is itself a hash of the seed, a
 * purpose and whatever else tells two uses apart.
 */
#ifndef TTF_HAL_SIM_NOISE_H
#define TTF_HAL_SIM_NOISE_H

#include <stdint.h>

/* What a stream is for; streams of different purposes are independent. */
enum noise_purpose {
    NOISE_PRNU = 1,
    NOISE_HOT_PLACE,
    NOISE_HOT_RATE,
    NOISE_SHOT_READ,
    NOISE_SCENE = 64 /* + a scene's own numbering */
};

/* A bijection of 64 bits with good avalanche (Steele et al. 2014, SplittableRandom, mix64). */
static inline uint64_t noise_mix(uint64_t z)
{
    z = (z ^ (z >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
    z = (z ^ (z >> 27)) * UINT64_C(0x94d049bb133111eb);
    return z ^ (z >> 31);
}

static inline uint64_t noise_stream(uint64_t seed, uint64_t purpose, uint64_t key)
{
    uint64_t s = noise_mix(seed + UINT64_C(0x9e3779b97f4a7c15));

    s = noise_mix(s ^ (purpose * UINT64_C(0xd1342543de82ef95)));
    return noise_mix(s + key * UINT64_C(0x9e3779b97f4a7c15));
}

static inline uint64_t noise_draw(uint64_t stream, uint64_t index)
{
    return noise_mix(stream + (index + 1) * UINT64_C(0x9e3779b97f4a7c15));
}

/* The top 24 bits as a float in [0, 1). */
static inline float noise_unit(uint64_t bits)
{
    return (float)(uint32_t)(bits >> 40) * (1.0f / 16777216.0f);
}

/* The index-th uniform number of a stream, [0, 1). */
static inline float noise_uniform(uint64_t stream, uint64_t index)
{
    return noise_unit(noise_draw(stream, index));
}

#define NOISE_NORMAL_CELLS 4096

/* The normal distribution's inverse, tabulated; the two end cells are worked out exactly. */
struct noise_normal {
    float at[NOISE_NORMAL_CELLS + 1];
};

void noise_normal_init(struct noise_normal *ret);

/* x with P(N(0,1) < x) = p, 0 < p < 1. */
double noise_normal_inverse(double p);

/* 32 random bits to a normal number of mean 0 and variance 1. */
static inline float noise_normal(const struct noise_normal *n, uint32_t bits)
{
    const uint32_t cell = bits >> 20;
    const float f = (float)(bits & 0xfffffu) * (1.0f / 1048576.0f);

    if (cell == 0 || cell == NOISE_NORMAL_CELLS - 1)
        return (float)noise_normal_inverse(((double)bits + 0.5) / 4294967296.0);
    return n->at[cell] + f * (n->at[cell + 1] - n->at[cell]);
}

/* 32 random bits to a Poisson number of this mean (>= 0). */
float noise_poisson(const struct noise_normal *n, float mean, uint32_t bits);

#endif
