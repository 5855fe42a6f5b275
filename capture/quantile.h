/* SPDX-License-Identifier: Apache-2.0 */
/*
 * quantile.h: quantiles of durations in fixed memory, whatever the length of the
 * run: a histogram whose bins are 1/64 of their value wide (and 1 ns below 64 ns). Pure.
 */
#ifndef TTF_CAPTURE_PRIVATE_QUANTILE_H
#define TTF_CAPTURE_PRIVATE_QUANTILE_H

#include <stdint.h>

#define TTF_QUANTILE_BINS (64 * 58)

struct ttf_quantile {
    int64_t n;
    int64_t max_ns;
    uint32_t bins[TTF_QUANTILE_BINS];
};

/* Zero-initialise it. Negative values count as their absolute value. */
void ttf_quantile_add(struct ttf_quantile *q, int64_t ns);

/* An upper bound, at most 1/64 too high and never above the maximum, of the q-th quantile (0..1); 0 if empty. */
int64_t ttf_quantile_ns(const struct ttf_quantile *q, double quantile);

#endif
