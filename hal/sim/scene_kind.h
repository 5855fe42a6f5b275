/* SPDX-License-Identifier: Apache-2.0 */
/*
 * scene_kind.h: what one procedural sample implements. Private to the scenes.
 *
 * A scene is drawn in three steps, each a pure function of the ones before:
 *   create   from the seed: its features (blades, cracks, spots) as lists, in
 *            the plane's own units, with the times at which they appear;
 *   prepare  once per picture size: fields that do not change (arrival times, noise);
 *   render   for a phase 0..1: the picture.
 * scene.c keeps the fields of the last few sizes; that is only a memory, it never
 * changes a result.
 *
 * Units. Across, the plane is 1 wide; down, SCENE_ASPECT. Points are (x, y) with x
 * in [0, 1] and y in [0, SCENE_ASPECT]; a picture of another shape stretches the plane, so
 * every picture size shows the same sample.
 */
#ifndef TTF_HAL_SIM_SCENE_KIND_H
#define TTF_HAL_SIM_SCENE_KIND_H

#include <stdint.h>

#define SCENE_ASPECT     0.75f
#define SCENE_PLANES_MAX 12

struct scene_canvas {
    uint32_t w, h;
    float sx, sy;                   /* pixels per unit across and down */
    float *plane[SCENE_PLANES_MAX]; /* kind->planes kept fields, then kind->scratch work fields */
};

struct scene_kind {
    const char *name;
    unsigned planes, scratch; /* how many, together <= SCENE_PLANES_MAX */
    /* Features from the seed; NULL: no memory. */
    void *(*create)(uint64_t seed);
    void (*destroy)(void *features);
    void (*prepare)(const void *features, const struct scene_canvas *canvas); /* may be NULL */
    void (*render)(const void *features, const struct scene_canvas *canvas, float phase,
                   float *rgb);
};

extern const struct scene_kind scene_grass, scene_copper, scene_paint, scene_banana, scene_snow,
    scene_chart, scene_dots, scene_white;

#endif
