/* SPDX-License-Identifier: Apache-2.0 */
#include "ttf/synth/shadow.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "control/fill.h"
#include "control/gaussian.h"
#include "control/picture.h"
#include "control/rates.h"
#include "control/shadow_parts.h"

#define SIDE_MIN   16   /* below it a border and an object cannot be told apart */
#define SOFTEN_MAX 64.0 /* pixels */

void ttf_shadow_defaults(struct ttf_shadow_config *config)
{
    *config = (struct ttf_shadow_config){.least = 0.2, .threshold = 0.0, .soften_px = 1.0};
}

static int least_check(double least, struct ttf_err *err)
{
    if (!(least >= 0.0 && least <= 1.0))
        return ttf_err_set(err, -EINVAL, "least", "%g is not within 0 and 1", least);
    return 0;
}

static int config_check(const struct ttf_shadow_config *config, struct ttf_err *err)
{
    int r = least_check(config->least, err);

    if (r < 0)
        return r;
    if (!(config->threshold >= 0.0 && config->threshold < 1.0))
        return ttf_err_set(err, -EINVAL, "threshold", "%g is not within 0 and 1",
                           config->threshold);
    if (!(config->soften_px >= 0.0 && config->soften_px <= SOFTEN_MAX))
        return ttf_err_set(err, -EINVAL, "soften", "%g pixels is not within 0 and %g",
                           config->soften_px, SOFTEN_MAX);
    return 0;
}

/* At the output's size, where all the rest happens. */
static int photo_load(const struct ttf_pixbuf *photo, uint32_t width, uint32_t height,
                      struct ttf_pixbuf *ret, struct ttf_err *err)
{
    int r;

    if (photo->samples != 3 || photo->format != TTF_SAMPLE_U16)
        return ttf_err_set(err, -EINVAL, "photograph",
                           "%u samples of %s per pixel, where 3 of u16 are needed", photo->samples,
                           ttf_sample_name(photo->format));
    r = ttf_control_size_check(width, height, err);
    if (r < 0)
        return r;
    if (width < SIDE_MIN || height < SIDE_MIN)
        return ttf_err_set(err, -EINVAL, "size", "%u x %u is smaller than %u x %u pixels", width,
                           height, SIDE_MIN, SIDE_MIN);
    return ttf_control_colour(photo, "photograph", width, height, ret, err);
}

static int shadow_alloc(struct ttf_shadow *shadow, uint32_t width, uint32_t height)
{
    size_t n = (size_t)width * height;

    *shadow = (struct ttf_shadow){.width = width, .height = height};
    shadow->shade = calloc(n, sizeof(*shadow->shade));
    shadow->alpha = calloc(n, sizeof(*shadow->alpha));
    shadow->object = calloc(n * 3, sizeof(*shadow->object));
    return shadow->shade && shadow->alpha && shadow->object ? 0 : -ENOMEM;
}

/* s = min(1, lum(I) / lum(B)), all over. */
static void shade_all(const struct ttf_pixbuf *photo, const struct ttf_ground *ground, float *ret)
{
    for (uint32_t y = 0; y < photo->height; y++) {
        const float *row = ttf_pixbuf_row(photo, y);

        for (uint32_t x = 0; x < photo->width; x++, row += 3) {
            float b[3], s;

            ttf_ground_at(ground, x, y, b);
            s = ttf_luminance(row[0], row[1], row[2]) / ttf_luminance(b[0], b[1], b[2]);
            ret[(size_t)y * photo->width + x] = s < 1.0f ? s : 1.0f;
        }
    }
}

/* Neither what the edge's softness shows of it, nor pixels that are partly object, know their shade. */
static int shade_fill(const struct ttf_mask *object, double soften_px, struct ttf_mask *scratch,
                      float *shade)
{
    size_t n = (size_t)object->width * object->height, known = 0;
    int r;

    memcpy(scratch->at, object->at, n);
    r = ttf_mask_grow(scratch, 2 + (int)ceil(2.0 * soften_px));
    if (r < 0)
        return r;
    for (size_t i = 0; i < n; i++) {
        scratch->at[i] = !scratch->at[i];
        known += scratch->at[i];
    }
    for (size_t i = 0; i < n && known == 0; i++) /* an object almost as large as the picture */
        scratch->at[i] = !object->at[i];
    return ttf_control_fill(shade, 1, scratch->at, object->width, object->height);
}

/*
 * The object's colour, continued outwards: pixels of the edge are partly ground, whose
 * colour would else be seen as a fringe on the texture.
 */
static int object_colour(const struct ttf_pixbuf *photo, const struct ttf_mask *object,
                         struct ttf_mask *scratch, float *ret)
{
    size_t n = (size_t)object->width * object->height, core = 0;
    int r;

    for (uint32_t y = 0; y < photo->height; y++)
        memcpy(ret + (size_t)y * photo->width * 3, ttf_pixbuf_row(photo, y),
               (size_t)photo->width * 3 * sizeof(*ret));
    memcpy(scratch->at, object->at, n);
    r = ttf_mask_grow(scratch, -1);
    if (r < 0)
        return r;
    for (size_t i = 0; i < n; i++)
        core += scratch->at[i];
    if (core == 0) /* thin everywhere */
        memcpy(scratch->at, object->at, n);
    return ttf_control_fill(ret, 3, scratch->at, object->width, object->height);
}

static int alpha_of(const struct ttf_mask *object, double soften_px, float *ret)
{
    size_t n = (size_t)object->width * object->height;
    double *plane = malloc(n * sizeof(*plane));
    int r;

    if (!plane)
        return -ENOMEM;
    for (size_t i = 0; i < n; i++)
        plane[i] = object->at[i];
    r = ttf_control_gaussian(plane, object->width, object->height, soften_px, TTF_BORDER_HOLD);
    for (size_t i = 0; i < n; i++)
        ret[i] = plane[i] < 1.0 - 1e-9 ? (float)plane[i]
                                       : 1.0f; /* sums of weights are 1 but for rounding */
    free(plane);
    return r;
}

/* What is known of the picture, into a shadow that is allocated. */
static int separate(const struct ttf_shadow_config *config, const struct ttf_pixbuf *photo,
                    struct ttf_mask *object, struct ttf_mask *scratch, struct ttf_shadow *shadow,
                    struct ttf_err *err)
{
    struct ttf_ground ground;
    size_t pixels = 0;
    int r = ttf_ground_fit(photo, &ground, err);

    if (r == 0)
        r = ttf_object_find(photo, &ground, config->threshold, object, &shadow->threshold, &pixels,
                            err);
    if (r < 0)
        return r;
    shadow->object_share = (double)pixels / ((double)photo->width * (double)photo->height);
    shade_all(photo, &ground, shadow->shade);
    r = shade_fill(object, config->soften_px, scratch, shadow->shade);
    if (r == 0)
        r = object_colour(photo, object, scratch, shadow->object);
    if (r == 0)
        r = alpha_of(object, config->soften_px, shadow->alpha);
    return r < 0 ? ttf_err_set(err, r, "photograph", "no memory to take it apart") : 0;
}

int ttf_shadow_find(const struct ttf_shadow_config *config, const struct ttf_pixbuf *photo,
                    uint32_t width, uint32_t height, struct ttf_shadow *ret, struct ttf_err *err)
{
    uint32_t w = width ? width : photo->width, h = height ? height : photo->height;
    struct ttf_mask object = {w, h, NULL}, scratch = {w, h, NULL};
    struct ttf_shadow shadow = {0};
    struct ttf_pixbuf sized = {0};
    int r = config_check(config, err);

    if (r == 0)
        r = photo_load(photo, w, h, &sized, err);
    if (r < 0)
        return r;
    object.at = calloc((size_t)w * h, 1);
    scratch.at = calloc((size_t)w * h, 1);
    r = shadow_alloc(&shadow, w, h);
    if (r < 0 || !object.at || !scratch.at)
        r = ttf_err_set(err, -ENOMEM, "photograph", "no memory for %u x %u pixels", w, h);
    else
        r = separate(config, &sized, &object, &scratch, &shadow, err);
    free(object.at);
    free(scratch.at);
    ttf_pixbuf_free(&sized);
    if (r < 0) {
        ttf_shadow_free(&shadow);
        return r;
    }
    *ret = shadow;
    return 0;
}

void ttf_shadow_free(struct ttf_shadow *shadow)
{
    if (!shadow)
        return;
    free(shadow->shade);
    free(shadow->alpha);
    free(shadow->object);
    memset(shadow, 0, sizeof(*shadow));
}

int ttf_shadow_rate_map(const struct ttf_shadow *shadow, double least, struct ttf_rate_map *ret,
                        struct ttf_err *err)
{
    struct ttf_rate_map map = {0};
    size_t n = (size_t)shadow->width * shadow->height;
    int r = least_check(least, err);

    if (r == 0)
        r = ttf_rates_alloc(shadow->width, shadow->height, &map, err);
    if (r != 0)
        return r;
    for (size_t i = 0; i < n; i++)
        map.m[i] = (float)(least + (1.0 - least) * (double)shadow->shade[i]);
    *ret = map;
    return 0;
}
