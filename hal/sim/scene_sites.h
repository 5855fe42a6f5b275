/* SPDX-License-Identifier: Apache-2.0 */
/*
 * scene_sites.h: things that begin at points and spread. Private to the scenes.
 *
 * A site is born at a phase and its front moves outwards; where it reaches each
 * pixel first, over all sites, is an arrival field. A picture at phase p then only
 * compares p with it: what has been reached stays reached.
 */
#ifndef TTF_HAL_SIM_SCENE_SITES_H
#define TTF_HAL_SIM_SCENE_SITES_H

#include "scene_kind.h"

struct site {
    float x, y;
    float birth;
    float pace;    /* phase per unit of distance, > 0 */
    float curve;   /* phase per unit squared: > 0 slows down as it grows */
    float stretch; /* how much farther it runs downwards; 1 = round */
};

/* What bends the fronts: the plane's points are displaced, then the arrival is made uneven. */
struct site_roughness {
    uint32_t seed;
    float shift, shift_scale;   /* displacement (units) and the wavelength it has */
    float jitter, jitter_scale; /* unevenness (phase) and its wavelength */
};

/* dst (canvas w x h): the first arrival of any site, at most `latest`. */
void sites_arrival(const struct site *site, unsigned n, const struct site_roughness *rough,
                   float latest, const struct scene_canvas *canvas, float *dst);

#endif
