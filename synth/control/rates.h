/* SPDX-License-Identifier: Apache-2.0 */
/* rates.h: from values of some property of the surface to rates: what all maps share. */
#ifndef TTF_SYNTH_CONTROL_RATES_H
#define TTF_SYNTH_CONTROL_RATES_H

#include <stddef.h>
#include <stdint.h>

#include "ttf/base/attr.h"
#include "ttf/base/err.h"
#include "ttf/synth/rate_map.h"

/* Zeros. -EINVAL (size), -ENOMEM. */
TTF_MUST_USE int ttf_rates_alloc(uint32_t width, uint32_t height, struct ttf_rate_map *ret,
                                 struct ttf_err *err);

/* offset + gain * value, at least 0. value is finite. */
struct ttf_rate_scale {
    double offset, gain;
};
TTF_MUST_USE int ttf_rate_scale_check(const struct ttf_rate_scale *scale, struct ttf_err *err);

/* -ERANGE beyond 2^20, where no sequence has that many frames to jump over. */
TTF_MUST_USE int ttf_rate_of_value(const struct ttf_rate_scale *scale, double value, float *ret,
                                   struct ttf_err *err);

/* The least of n values that a share of `share` of them does not exceed; puts values in another order. n >= 1. */
double ttf_control_quantile(double *values, size_t n, double share);

/*
 * Rates of |k| / p99 clipped to 0..1, for n >= 1 curvatures (if 99% are flat, the largest takes
 * p99's place). noise: what rounding alone can make of something straight; nothing
 * beyond it counts as no curvature anywhere.
 */
TTF_MUST_USE int ttf_rates_of_curvature(const double *k, size_t n, double noise,
                                        const struct ttf_rate_scale *scale, float *ret,
                                        struct ttf_err *err);

#endif
