/* SPDX-License-Identifier: Apache-2.0 */
/* gaussian.h: smoothing of a plane of doubles in place. */
#ifndef TTF_SYNTH_CONTROL_GAUSSIAN_H
#define TTF_SYNTH_CONTROL_GAUSSIAN_H

#include <stdint.h>

#include "ttf/base/attr.h"

#define TTF_GAUSSIAN_SIGMA_MAX 256.0 /* pixels: the kernel is applied directly */

/* How the plane goes on beyond its borders. */
enum ttf_gaussian_border {
    TTF_BORDER_HOLD, /* its last value: what is bounded stays within its bounds */
    TTF_BORDER_ODD /* reflected in the border's point, 2 f(0) - f(i): slopes go on, so a tilted plane stays one */
};

/* sigma_px 0..TTF_GAUSSIAN_SIGMA_MAX; 0 changes nothing. -EINVAL, -ENOMEM. */
TTF_MUST_USE int ttf_control_gaussian(double *plane, uint32_t width, uint32_t height,
                                      double sigma_px, enum ttf_gaussian_border border);

#endif
