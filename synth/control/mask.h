/* SPDX-License-Identifier: Apache-2.0 */
/* mask.h: sets of pixels, one byte each, 0 or 1. All of it fails with -EINVAL (no pixels) and -ENOMEM. */
#ifndef TTF_SYNTH_CONTROL_MASK_H
#define TTF_SYNTH_CONTROL_MASK_H

#include <stddef.h>
#include <stdint.h>

#include "ttf/base/attr.h"

struct ttf_mask {
    uint32_t width, height;
    uint8_t *at; /* not owned */
};

/* Leaves only the largest set of pixels that touch, corners included (ties: the first from the top). */
TTF_MUST_USE int ttf_mask_keep_largest(struct ttf_mask *mask, size_t *ret_pixels);

/* Adds what cannot be left towards the border without crossing the mask. */
TTF_MUST_USE int ttf_mask_fill_holes(struct ttf_mask *mask, size_t *ret_pixels);

/* Adds all pixels at most `px` rows and columns away; negative: takes away those so near to the outside. */
TTF_MUST_USE int ttf_mask_grow(struct ttf_mask *mask, int px);

/*
 * Closing: fills bays and gaps that a square of 2 px + 1 pixels does not fit into. Beyond the
 * picture's border lies nothing of the mask.
 */
TTF_MUST_USE int ttf_mask_close(struct ttf_mask *mask, unsigned px);

#endif
