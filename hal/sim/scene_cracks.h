/* SPDX-License-Identifier: Apache-2.0 */
/*
 * scene_cracks.h: how a network of cracks grows in a drying layer. Private to the scenes.
 *
 * Cracks nucleate one by one, run both ways with a slightly wandering direction and
 * stop where they meet another. New ones start only where no crack has yet relieved
 * the tension; that distance shrinks, so later cracks divide the islands that earlier ones left,
 * many of them starting at right angles from a crack's side.
 */
#ifndef TTF_HAL_SIM_SCENE_CRACKS_H
#define TTF_HAL_SIM_SCENE_CRACKS_H

#include <stdint.h>

/* One straight piece; the tip passed from (x0, y0) at t0 to (x1, y1) at t1 (phases). */
struct crack_piece {
    float x0, y0, x1, y1;
    float t0, t1;
    float width; /* half width when fully open, plane's units */
};

struct crack_net {
    struct crack_piece *piece;
    unsigned n;
};

/* 0 or -ENOMEM. The same net for the same stream. */
int cracks_grow(uint64_t stream, struct crack_net *ret);
void cracks_finish(struct crack_net *net);

#endif
