/* SPDX-License-Identifier: Apache-2.0 */
/* layers.h: pixels that are blended across a seam, as a list of steps applied in order. */
#ifndef TTF_SYNTH_QUILT_LAYERS_H
#define TTF_SYNTH_QUILT_LAYERS_H

#include <stdint.h>

#include "ttf/base/attr.h"
#include "ttf/synth/quilt.h"

/* Zero-initialise, then ttf_layers_begin. */
struct ttf_layers {
    struct ttf_quilt_layer *list;
    size_t n, room;
    uint8_t *layered; /* one per output pixel: has steps */
};

TTF_MUST_USE int ttf_layers_begin(struct ttf_layers *layers, size_t pixels);
void ttf_layers_free(struct ttf_layers *layers);

/* Lays `source` (of `block`) over a pixel that showed `before` (of `before_block`). weight 0..65536: 65536 hides all below. */
TTF_MUST_USE int ttf_layers_add(struct ttf_layers *layers, uint32_t pixel, uint32_t before,
                                uint32_t before_block, uint32_t source, uint32_t block,
                                uint32_t weight);

/*
 * Weight of the new block, 0..65536, for a pixel whose centre is at index + 1/2
 * of a strip of `width` pixels cut before `cut`: a ramp of `feather` pixels,
 * narrower where the strip's edge is near, so that blending never leaves the overlap.
 */
uint32_t ttf_layers_weight(uint32_t index, uint32_t cut, uint32_t width, uint32_t feather);

#endif
