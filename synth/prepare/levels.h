/* SPDX-License-Identifier: Apache-2.0 */
/* levels.h: a series of numbers in time made smooth. Private to preparation. */
#ifndef TTF_SYNTH_PREPARE_LEVELS_H
#define TTF_SYNTH_PREPARE_LEVELS_H

#include <stdint.h>

#include "ttf/base/attr.h"

/*
 * The running median of n >= 3 values over `window` of them (odd, >= 3; less if there are
 * fewer), about the trend there (the median of slopes), and then their running mean. Near
 * the ends, the nearest whole window takes the place of a lopsided one, and a line through it
 * that of the mean: so a straight trend comes out as it was to its last frame. NAN: no value,
 * skipped; NAN comes out where a whole window has none. 0 or -ENOMEM.
 */
TTF_MUST_USE int ttf_levels_smooth(const double *level, uint32_t n, uint32_t window, double *ret);

#endif
