/* SPDX-License-Identifier: Apache-2.0 */
/* flicker.h: bands that a lamp dimmed by pulses leaves in a picture. */
#ifndef CAPTURE_FLICKER_H
#define CAPTURE_FLICKER_H

#include <stdint.h>

/*
 * Light that is on for `permille` of each period_ns, seen for exposure_ns beginning at any moment of the cycle: the
 * most light less the least, as ppm of the mean. 0 if the exposure is whole cycles, the light steady or dark.
 */
int64_t ttf_flicker_ppm(int64_t exposure_ns, int64_t period_ns, unsigned permille);

#endif
