/* SPDX-License-Identifier: Apache-2.0 */
#include "control/picture.h"

#include <errno.h>
#include <math.h>
#include <stdbool.h>
#include <string.h>

#include "ttf/dataset/colour.h"

#define SIDE_MAX 32768u

int ttf_control_size_check(uint32_t width, uint32_t height, struct ttf_err *err)
{
    if (width < 1 || width > SIDE_MAX || height < 1 || height > SIDE_MAX)
        return ttf_err_set(err, -EINVAL, "size", "%u x %u is not within 1 x 1 and %u x %u pixels",
                           width, height, SIDE_MAX, SIDE_MAX);
    return 0;
}

static int widen(const struct ttf_pixbuf *picture, const char *name, struct ttf_pixbuf *ret,
                 struct ttf_err *err)
{
    int r;

    if (!picture->data || picture->width == 0 || picture->height == 0)
        return ttf_err_set(err, -EINVAL, name, "the picture has no pixels");
    r = ttf_pixbuf_alloc(ret, picture->width, picture->height, picture->samples, TTF_SAMPLE_F32);
    if (r == 0)
        r = ttf_pixbuf_convert(picture, ret);
    if (r < 0)
        return ttf_err_set(err, r, name, "%s samples, %u per pixel, cannot be used here",
                           ttf_sample_name(picture->format), picture->samples);
    return 0;
}

static int finite_check(const struct ttf_pixbuf *picture, const char *name, struct ttf_err *err)
{
    size_t n = (size_t)picture->width * picture->samples;

    for (uint32_t y = 0; y < picture->height; y++) {
        const float *row = ttf_pixbuf_row(picture, y);

        for (size_t i = 0; i < n; i++) {
            if (isfinite(row[i]))
                continue;
            ttf_err_set(err, -EINVAL, name, "pixel (%u, %u) is not a finite number",
                        (unsigned)(i / picture->samples), y);
            ttf_err_hint(err, "replace NaN and infinity in the picture by numbers");
            return -EINVAL;
        }
    }
    return 0;
}

static float grey_of(const float *pixel, uint32_t samples)
{
    return samples >= 3 ? ttf_luminance(pixel[0], pixel[1], pixel[2]) : pixel[0];
}

/* Leaves `keep` samples of each pixel: 1 is its grey. */
static void narrow(const struct ttf_pixbuf *from, struct ttf_pixbuf *to)
{
    for (uint32_t y = 0; y < from->height; y++) {
        const float *src = ttf_pixbuf_row(from, y);
        float *dst = ttf_pixbuf_row(to, y);

        for (uint32_t x = 0; x < from->width; x++, src += from->samples, dst += to->samples) {
            if (to->samples == 1)
                dst[0] = grey_of(src, from->samples);
            else
                memcpy(dst, src, to->samples * sizeof(*dst));
        }
    }
}

static int prepared(const struct ttf_pixbuf *picture, const char *name, uint32_t samples,
                    uint32_t width, uint32_t height, struct ttf_pixbuf *ret, struct ttf_err *err)
{
    struct ttf_pixbuf wide = {0}, narrowed = {0}, sized = {0};
    int r = widen(picture, name, &wide, err);

    if (r == 0)
        r = finite_check(&wide, name, err);
    if (r < 0)
        goto out;
    r = ttf_pixbuf_alloc(&narrowed, wide.width, wide.height, samples, TTF_SAMPLE_F32);
    if (r == 0)
        r = ttf_pixbuf_alloc(&sized, width, height, samples, TTF_SAMPLE_F32);
    if (r == 0) {
        narrow(&wide, &narrowed);
        r = ttf_pixbuf_resample(&narrowed, &sized);
    }
    if (r < 0) {
        ttf_err_set(err, r, name, "no room for the picture at %u x %u", width, height);
        goto out;
    }
    *ret = sized;
    sized = (struct ttf_pixbuf){0};
out:
    ttf_pixbuf_free(&wide);
    ttf_pixbuf_free(&narrowed);
    ttf_pixbuf_free(&sized);
    return r;
}

int ttf_control_grey(const struct ttf_pixbuf *picture, const char *name, uint32_t width,
                     uint32_t height, struct ttf_pixbuf *ret, struct ttf_err *err)
{
    return prepared(picture, name, 1, width, height, ret, err);
}

int ttf_control_colour(const struct ttf_pixbuf *picture, const char *name, uint32_t width,
                       uint32_t height, struct ttf_pixbuf *ret, struct ttf_err *err)
{
    if (picture->samples < 3)
        return ttf_err_set(err, -EINVAL, name, "a picture of three channels is needed, this has %u",
                           picture->samples);
    return prepared(picture, name, 3, width, height, ret, err);
}
