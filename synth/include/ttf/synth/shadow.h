/* SPDX-License-Identifier: Apache-2.0 */
/*
 * shadow.h: an object and its shadow, taken from a photograph on a plain ground and
 * laid over a time-varying texture whose pace the shadow sets (Enrique et al. 2005,
 * figure 10).
 *
 * B: a plane fitted to the photograph's border, per channel, heedless of what else reaches it;
 * s = min(1, lum(I)/lum(B)); the object: the largest component of chroma distance from B over a
 * threshold (Otsu's, or given), its holes filled; M = least + (1 - least) s; output = s * texture
 * under the object.
 */
#ifndef TTF_SYNTH_SHADOW_H
#define TTF_SYNTH_SHADOW_H

#include <stdint.h>

#include "ttf/base/attr.h"
#include "ttf/base/err.h"
#include "ttf/dataset/colour.h"
#include "ttf/dataset/pixbuf.h"
#include "ttf/dataset/pool.h"
#include "ttf/synth/rate_map.h"

struct ttf_shadow_config {
    double least;     /* M where the shadow is darkest, 0..1; default 0.2 */
    double threshold; /* of chroma distance, 0 to below 1; 0: found (Otsu) */
    double soften_px; /* Gaussian of the object's edge (alpha), 0..64; default 1 */
};
void ttf_shadow_defaults(struct ttf_shadow_config *config);

struct ttf_shadow {
    uint32_t width, height;
    float *shade; /* s, height x width, 0..1; under the object what its surroundings say */
    float *alpha; /* of the object, 0..1 */
    float *
        object; /* its linear RGB, height x width x 3, 0..1; continued outwards, so that no ground fringes it */
    double threshold;    /* as used */
    double object_share; /* of the picture */
};

/*
 * photo: U16 x 3, linear (65535 = 1), at its own size; the result is of width x height
 * (0: the photograph's), where all is done; at least 16 x 16. -EINVAL with a hint where no object stands
 * out, it touches all borders, or the ground is nearly black.
 */
TTF_MUST_USE int ttf_shadow_find(const struct ttf_shadow_config *config,
                                 const struct ttf_pixbuf *photo, uint32_t width, uint32_t height,
                                 struct ttf_shadow *ret, struct ttf_err *err);
void ttf_shadow_free(struct ttf_shadow *shadow);

/* M = least + (1 - least) s, least 0..1: the shadow of the config's least, or of another. */
TTF_MUST_USE int ttf_shadow_rate_map(const struct ttf_shadow *shadow, double least,
                                     struct ttf_rate_map *ret, struct ttf_err *err);

/*
 * One frame in place (height x width x 3 codes of the shadow's size): times s, then the object
 * over it; in linear light, clipped to the codes. pool: may be NULL; the same bits for any.
 */
void ttf_shadow_compose(const struct ttf_shadow *shadow, const struct ttf_encoding *encoding,
                        struct ttf_pool *pool, uint16_t *codes);

#endif
