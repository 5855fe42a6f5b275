/* SPDX-License-Identifier: Apache-2.0 */
/* scene_blade.h: draws one blade of grass with its shadow. Private to the grass scene. */
#ifndef TTF_HAL_SIM_SCENE_BLADE_H
#define TTF_HAL_SIM_SCENE_BLADE_H

#include "scene_kind.h"

struct blade_look {
    float colour[3];    /* lit, at the tip */
    float root_light;   /* light at the root, 0..1: what neighbours leave */
    float shadow;       /* darkening beside it, 0..1 */
    float shadow_width; /* plane's units */
};

/* A ribbon that starts at its root, tapers to a point and bends as an arc. Plane's units, radians. */
struct blade_shape {
    float x, y;       /* root */
    float length;     /* along the ribbon */
    float half;       /* half width where it is widest */
    float lean, bend; /* angle from straight up at the root; what is added until the tip */
    struct blade_look look;
};

/* Paints over rgb (canvas w x h x 3); what lies right of it is shadowed. */
void blade_draw(const struct blade_shape *shape, const struct scene_canvas *canvas, float *rgb);

#endif
