/* SPDX-License-Identifier: Apache-2.0 */
/* compose.h: frames through a map, by rows, so that several threads can share a frame. */
#ifndef TTF_SYNTH_QUILT_COMPOSE_H
#define TTF_SYNTH_QUILT_COMPOSE_H

#include "ttf/dataset/pool.h"
#include "ttf/synth/quilt.h"

/* ttf_quilt_compose with the rows shared out. */
void ttf_compose_frame(const struct ttf_quilt_map *map, struct ttf_pool *pool,
                       const uint16_t *source, uint16_t *dst);

/* Rows y0..y1-1 of it, without the layers; of 16-bit and of 8-bit codes. */
void ttf_compose_rows(const struct ttf_quilt_map *map, const uint16_t *source, uint32_t y0,
                      uint32_t y1, uint16_t *dst);
void ttf_compose_rows8(const struct ttf_quilt_map *map, const uint8_t *source, uint32_t y0,
                       uint32_t y1, uint8_t *dst);

/* The layers over it. */
void ttf_compose_layers(const struct ttf_quilt_map *map, const uint16_t *source, uint16_t *dst);

/* One layer's step. Codes are linear in light, so blending them is blending light. */
uint16_t ttf_blend(uint16_t below, uint16_t above, uint32_t weight);

#endif
