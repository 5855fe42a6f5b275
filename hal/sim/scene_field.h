/* SPDX-License-Identifier: Apache-2.0 */
/* scene_field.h: smooth random fields that the scenes are made of. Private to the scenes. */
#ifndef TTF_HAL_SIM_SCENE_FIELD_H
#define TTF_HAL_SIM_SCENE_FIELD_H

#include <stdint.h>

#include "scene_kind.h"

/* Gradient noise at (x, y), lattice of unit cells; about -0.7..0.7, mean 0 (Perlin 2002). */
float field_noise(uint32_t seed, float x, float y);

/* Octaves of it, each twice as fine and `roughness` as strong; scaled to about -1..1. */
float field_fractal(uint32_t seed, float x, float y, unsigned octaves, float roughness);

/* Distance to the nearest of one random point per unit cell, 0..about 1.2; *ret_id tells the points apart. */
float field_cells(uint32_t seed, float x, float y, uint32_t *ret_id);

/* How many octaves of wavelength `coarsest` units are not finer than two pixels: 1..most. */
unsigned field_octaves(const struct scene_canvas *c, float coarsest, unsigned most);

static inline uint32_t field_hash(uint32_t seed, uint32_t a, uint32_t b)
{
    uint32_t h = seed ^ (a * 0x9e3779b1u) ^ (b * 0x85ebca77u);

    h = (h ^ (h >> 16)) * 0x7feb352du;
    h = (h ^ (h >> 15)) * 0x846ca68bu;
    return h ^ (h >> 16);
}

static inline float field_clamp(float x, float lo, float hi)
{
    return x < lo ? lo : x > hi ? hi : x;
}

/* 0 below a, 1 above b, an S between. */
static inline float field_step(float a, float b, float x)
{
    const float t = field_clamp((x - a) / (b - a), 0.0f, 1.0f);

    return t * t * (3.0f - 2.0f * t);
}

static inline float field_mix(float a, float b, float t)
{
    return a + t * (b - a);
}

/* The middle of pixel x (y) in the plane's units. */
static inline float field_x(const struct scene_canvas *c, uint32_t x)
{
    return ((float)x + 0.5f) / c->sx;
}

static inline float field_y(const struct scene_canvas *c, uint32_t y)
{
    return ((float)y + 0.5f) / c->sy;
}

#endif
