/* SPDX-License-Identifier: Apache-2.0 */
/*
 * samples.h: a sample of some of many things, one hashed from each of `samples` equal
 * strata: as even as a lattice, but never in step with what repeats in a picture.
 */
#ifndef TTF_SYNTH_METRICS_SAMPLES_H
#define TTF_SYNTH_METRICS_SAMPLES_H

#include "search/hash.h"

/* The sample `which` (0..samples-1) of things 0..n-1; all differ. n < 2^32, samples <= n; all, in order, if equal. */
static inline uint32_t ttf_stratum(uint64_t seed, enum ttf_purpose purpose, uint64_t which,
                                   uint64_t n, uint64_t samples)
{
    uint64_t from = which * n / samples;
    uint64_t to = (which + 1) * n / samples;

    return (uint32_t)(from + ttf_pick(ttf_random64(seed, purpose, which), (uint32_t)(to - from)));
}

#endif
