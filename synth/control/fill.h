/* SPDX-License-Identifier: Apache-2.0 */
/* fill.h: what is unknown in a picture, from what is around it, smoothly. */
#ifndef TTF_SYNTH_CONTROL_FILL_H
#define TTF_SYNTH_CONTROL_FILL_H

#include <stdint.h>

#include "ttf/base/attr.h"

/*
 * Values (`samples` interleaved per pixel) where known is 0 become a smooth continuation of
 * those where it is 1: the membrane (Laplace's equation) begun by pull and push over
 * halved pictures. At least one pixel must be known; known ones keep their bits. -EINVAL (no pixels), -ENOMEM.
 */
TTF_MUST_USE int ttf_control_fill(float *values, uint32_t samples, const uint8_t *known,
                                  uint32_t width, uint32_t height);

#endif
