/* SPDX-License-Identifier: Apache-2.0 */
/* compose.h: frames through a map, by rows, so that several threads can share a frame. */
#ifndef TTF_SYNTH_QUILT_COMPOSE_H
#define TTF_SYNTH_QUILT_COMPOSE_H

#include "ttf/dataset/pool.h"
#include "ttf/synth/quilt.h"

/* ttf_quilt_compose with the rows shared out. */
void ttf_compose_frame(const struct ttf_quilt_map *map, struct ttf_pool *pool,
                       const uint16_t *source, uint16_t *dst);

#endif
