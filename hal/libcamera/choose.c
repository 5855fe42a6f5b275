/* SPDX-License-Identifier: Apache-2.0 */
/* choose.c: which pixel format is asked for, and what samples of the sensor's are in the one that is granted. */
#include <errno.h>
#include <stdio.h>
#include <string.h>

#include "device.h"

#define OFFERS_MAX 512

/* Formats that are offered and cannot be used, for the message. */
struct refused {
    char text[160];
    size_t n;
    bool compressed;
};

static void note(struct refused *refused, const struct lc_offer *offer)
{
    char text[6];
    int n;

    refused->compressed |= lc_pixels_compressed(offer->fourcc, offer->modifier);
    (void)lc_pixels_text(offer->fourcc, offer->modifier, text);
    if (strstr(refused->text, text))
        return;
    n = snprintf(refused->text + refused->n, sizeof(refused->text) - refused->n, "%s%s",
                 refused->n ? ", " : "", text);
    if (n > 0 && (size_t)n < sizeof(refused->text) - refused->n)
        refused->n += (size_t)n;
    else
        refused->text[refused->n] = '\0';
}

static bool wanted(const struct lc_camera *camera, const struct lc_pixels *pixels)
{
    if (camera->config.pixel_format[0] && !lc_pixels_named(pixels, camera->config.pixel_format))
        return false;
    return camera->mode.packing == TTF_PACKING_NONE || pixels->packing == camera->mode.packing;
}

static int no_format(const struct lc_camera *camera, const struct refused *refused,
                     struct ttf_err *err)
{
    static const char *const streams[] = {"", "raw ", "processed "};
    const char *asked = camera->config.pixel_format;

    if (refused->n == 0)
        return ttf_err_set(err, -EINVAL, camera->id.id, "the camera offers no %spixel format",
                           streams[camera->config.stream]);
    ttf_err_set(err, -EINVAL, camera->id.id, "the camera gives no %s%s",
                streams[camera->config.stream],
                asked[0] ? asked : "pixels that are known here or asked for");
    ttf_err_hint(err, "it offers %s%s", refused->text,
                 refused->compressed ? "; compressed ones are refused: what they threw away cannot "
                                       "be calibrated"
                                     : "");
    return -EINVAL;
}

/* The i-th raw format that is listed; *ret_pixels NULL: none that is known. */
static bool next_raw(struct lc_camera *camera, unsigned i, struct lc_offer *ret,
                     const struct lc_pixels **ret_pixels)
{
    if (i >= OFFERS_MAX || lc_ops(camera)->offer(camera->handle, LC_RAW, i, ret) <= 0)
        return false;
    *ret_pixels = lc_pixels_of(ret->fourcc, ret->modifier);
    if (*ret_pixels && (*ret_pixels)->role != LC_RAW)
        *ret_pixels = NULL;
    return true;
}

/* The best of one role's formats that is wanted; NULL: none. */
static const struct lc_pixels *best_of(struct lc_camera *camera, enum lc_role role,
                                       struct lc_offer *ret, struct refused *refused)
{
    const struct lc_pixels *best = NULL;
    struct lc_offer offer;

    for (unsigned i = 0; i < OFFERS_MAX; i++) {
        const struct lc_pixels *p;

        if (lc_ops(camera)->offer(camera->handle, role, i, &offer) <= 0)
            break;
        p = lc_pixels_of(offer.fourcc, offer.modifier);
        /* Cameras without a raw stream offer processed pixels in its place. */
        if (!p || p->role != role || !wanted(camera, p))
            note(refused, &offer);
        else if (!best || lc_pixels_rank(p->fourcc, p->modifier) <
                              lc_pixels_rank(best->fourcc, best->modifier)) {
            best = p;
            *ret = offer;
        }
    }
    return best;
}

/*
 * Pipelines may grant more than they list: those of Raspberry Pis list packed raw formats alone, of the order in which the sensor
 * is built. So one that a board names is asked for if the camera has a raw stream at all.
 */
static const struct lc_pixels *unlisted(struct lc_camera *camera, struct lc_offer *ret)
{
    const struct lc_pixels *named = lc_pixels_of_name(camera->config.pixel_format);
    const struct lc_pixels *deepest = NULL, *p;
    struct lc_offer offer;

    if (!named || named->role != LC_RAW || !wanted(camera, named))
        return NULL;
    for (unsigned i = 0; next_raw(camera, i, &offer, &p); i++)
        if (p && (!deepest || p->bits > deepest->bits)) {
            deepest = p;
            *ret = offer;
        }
    return deepest ? named : NULL;
}

int lc_choose(struct lc_camera *camera, struct lc_offer *ret, struct ttf_err *err)
{
    enum ttf_libcamera_stream stream = camera->config.stream;
    struct refused refused = {0};
    const struct lc_pixels *best = NULL;

    if (stream != TTF_LIBCAMERA_PROCESSED)
        best = best_of(camera, LC_RAW, ret, &refused);
    if (!best && stream != TTF_LIBCAMERA_RAW)
        best = best_of(camera, LC_PROCESSED, ret, &refused);
    if (!best && stream != TTF_LIBCAMERA_PROCESSED)
        best = unlisted(camera, ret);
    if (!best)
        return no_format(camera, &refused, err);
    camera->pixels = best;
    return 0;
}

/*
 * Libcamera does not tell which of the sensor's modes fills its words. Of a size that is the largest of a listed depth it is
 * that depth; of another the least there is, so that saturation is rather seen too early than never.
 */
unsigned lc_sensor_bits(struct lc_camera *camera, const struct lc_granted *granted)
{
    unsigned least = camera->pixels->bits, deepest = 0;
    const struct lc_pixels *p;
    struct lc_offer offer;

    for (unsigned i = 0; next_raw(camera, i, &offer, &p); i++) {
        if (!p)
            continue;
        if (p->bits < least)
            least = p->bits;
        if (offer.width == granted->width && offer.height == granted->height && p->bits > deepest)
            deepest = p->bits;
    }
    return deepest ? deepest : least;
}
