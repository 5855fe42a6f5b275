/* SPDX-License-Identifier: Apache-2.0 */
/* shadow_parts.h: the steps of taking an object and its shadow out of a photograph. */
#ifndef TTF_SYNTH_CONTROL_SHADOW_PARTS_H
#define TTF_SYNTH_CONTROL_SHADOW_PARTS_H

#include <stddef.h>
#include <stdint.h>

#include "control/mask.h"
#include "ttf/base/attr.h"
#include "ttf/base/err.h"
#include "ttf/dataset/pixbuf.h"

/* B: what the ground would look like everywhere, at + across u + down v per channel, u and v from the middle. */
struct ttf_ground {
    uint32_t width, height;
    double at[3], across[3], down[3];
};

/*
 * Fitted to the border of a linear photograph (F32 x 3). What differs from the rest of the
 * border (an object or shadow that reaches it, up to a third of it) has no say.
 * -EINVAL: the ground is too dark to tell shadows; -ENOMEM.
 */
TTF_MUST_USE int ttf_ground_fit(const struct ttf_pixbuf *photo, struct ttf_ground *ret,
                                struct ttf_err *err);

void ttf_ground_at(const struct ttf_ground *ground, uint32_t x, uint32_t y, float ret[3]);

/* How different in colour, whatever the brightness, 0..1; what is nearly black has the ground's colour. */
float ttf_chroma_distance(const float rgb[3], const float ground[3]);

/*
 * The object's pixels. threshold 0: found; *ret_threshold is what was used.
 * mask: of the photograph's size, all written. -EINVAL with a hint: none, or touching all borders; -ENOMEM.
 */
TTF_MUST_USE int ttf_object_find(const struct ttf_pixbuf *photo, const struct ttf_ground *ground,
                                 double threshold, struct ttf_mask *mask, double *ret_threshold,
                                 size_t *ret_pixels, struct ttf_err *err);

#endif
