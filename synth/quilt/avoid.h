/* SPDX-License-Identifier: Apache-2.0 */
/* avoid.h: places that a block is not to be taken from, so that one patch does not lie beside itself. */
#ifndef TTF_SYNTH_QUILT_AVOID_H
#define TTF_SYNTH_QUILT_AVOID_H

#include "quilt/plan_private.h"

/* How far around a block, in blocks, repetition is avoided (config->avoid_px). */
#define TTF_AVOID_BLOCKS 3

/* Rectangles that ttf_avoid_find may give. */
#define TTF_AVOID_RECTS_MAX \
    ((2 * TTF_AVOID_BLOCKS + 1) * (2 * TTF_AVOID_BLOCKS + 1) * TTF_TURN_COUNT)

/*
 * Positions that show the place of a block nearby, however turned, or one within config->avoid_px of it: of
 * all blocks before block i in raster order (order.c). Where that would leave no position at
 * all, the distance is halved until one is left. Returns how many rectangles there are.
 */
unsigned ttf_avoid_find(const struct ttf_plan *plan, unsigned i, struct ttf_position_rect *ret);

#endif
