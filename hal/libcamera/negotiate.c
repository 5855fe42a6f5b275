/* SPDX-License-Identifier: Apache-2.0 */
/* negotiate.c: asks for a format, and looks what was granted. */
#include <errno.h>
#include <stdio.h>
#include <string.h>

#include "device.h"
#include "ttf/base/checked.h"

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

static int choose(struct lc_camera *camera, struct lc_offer *ret, struct ttf_err *err)
{
    enum ttf_libcamera_stream stream = camera->config.stream;
    struct refused refused = {0};
    const struct lc_pixels *best = NULL;

    if (stream != TTF_LIBCAMERA_PROCESSED)
        best = best_of(camera, LC_RAW, ret, &refused);
    if (!best && stream != TTF_LIBCAMERA_RAW)
        best = best_of(camera, LC_PROCESSED, ret, &refused);
    if (!best)
        return no_format(camera, &refused, err);
    camera->pixels = best;
    return 0;
}

static enum lc_colour colour_of(enum ttf_packing packing, enum lc_role role)
{
    if (role == LC_RAW)
        return LC_COLOUR_RAW;
    return packing == TTF_PACKING_YUYV8 || packing == TTF_PACKING_NV12 ? LC_COLOUR_BT601_LIMITED
                                                                       : LC_COLOUR_RGB_FULL;
}

static int check_pixels(const struct lc_camera *camera, const struct lc_granted *granted,
                        struct ttf_err *err)
{
    const struct lc_pixels *p = camera->pixels;
    char asked[6], got[6];

    if (granted->fourcc == p->fourcc && granted->modifier == p->modifier)
        return 0;
    (void)lc_pixels_text(p->fourcc, p->modifier, asked);
    (void)lc_pixels_text(granted->fourcc, granted->modifier, got);
    ttf_err_set(err, -EINVAL, camera->id.id, "instead of %s libcamera grants %s%s", asked, got,
                lc_pixels_compressed(granted->fourcc, granted->modifier) ? ", which is compressed"
                                                                         : "");
    ttf_err_hint(err, "name another format, or another size");
    return -EINVAL;
}

/* Developing knows one kind of YUV and one of RGB. What libcamera does not tell is taken as it was asked. */
static int check_colour(const struct lc_camera *camera, const struct lc_granted *granted,
                        struct ttf_err *err)
{
    enum lc_colour right = colour_of(camera->pixels->packing, camera->pixels->role);

    if (right == LC_COLOUR_RAW || granted->colour == LC_COLOUR_UNKNOWN ||
        granted->colour == right || camera->pixels->packing == TTF_PACKING_GREY8)
        return 0;
    ttf_err_set(err, -ENOTSUP, camera->id.id, "its colours are coded as %s, and not as %s",
                granted->colour_text,
                right == LC_COLOUR_RGB_FULL ? "RGB of full range" : "BT.601 of limited range");
    ttf_err_hint(err, "ask for a raw stream, if it has one, or for BG24");
    return -ENOTSUP;
}

static int check_granted(const struct lc_camera *camera, const struct lc_granted *granted,
                         struct ttf_err *err)
{
    size_t row = ttf_row_bytes(camera->pixels->packing, granted->width);
    int r = check_pixels(camera, granted, err);

    if (r < 0)
        return r;
    if (granted->width == 0 || granted->height == 0 || granted->width > 65535 ||
        granted->height > 65535)
        return ttf_err_set(err, -EINVAL, camera->id.id, "libcamera grants frames of %u x %u",
                           granted->width, granted->height);
    if (granted->stride < row)
        return ttf_err_set(err, -EINVAL, camera->id.id,
                           "rows have %u bytes, and %u pixels take %zu", granted->stride,
                           granted->width, row);
    return check_colour(camera, granted, err);
}

static int take(struct lc_camera *camera, const struct lc_granted *granted, struct ttf_err *err)
{
    const struct lc_pixels *p = camera->pixels;
    const struct ttf_libcamera_config *c = &camera->config;
    uint32_t white = c->white_level ? c->white_level : (1u << p->bits) - 1;
    struct ttf_frame_format format = {
        .width = granted->width,
        .height = granted->height,
        .stride = granted->stride,
        .packing = p->packing,
        .cfa = p->cfa,
        .bits = p->bits,
        .black_level = c->black_level,
        .white_level = (uint16_t)white,
    };

    if (white >> p->bits != 0 || c->black_level >= white)
        return ttf_err_set(err, -EINVAL, camera->id.id,
                           "levels of %u to %u do not fit samples of %u bits", c->black_level,
                           white, p->bits);
    if (!ttf_mul_size(format.stride, ttf_frame_rows(&format), &camera->frame_bytes) ||
        granted->bytes < camera->frame_bytes)
        return ttf_err_set(err, -EINVAL, camera->id.id,
                           "buffers have %zu bytes, fewer than %u rows of %u", granted->bytes,
                           granted->height, granted->stride);
    camera->base.format = format;
    return 0;
}

static int get_buffers(struct lc_camera *camera, unsigned want, struct ttf_err *err)
{
    struct lc_stream *s = &camera->stream;
    unsigned granted = 0;
    int r = lc_ops(camera)->allocate(camera->handle, want, &granted);

    if (r < 0)
        return ttf_err_set(err, r, camera->id.id, "libcamera gives no buffers: %s",
                           strerrordesc_np(-r));
    if (granted <= camera->config.buffers)
        return ttf_err_set(err, -ENOMEM, camera->id.id,
                           "libcamera gives %u buffers, and %u are needed", granted,
                           camera->config.buffers + 1);
    s->n = granted < LC_BUFFERS_MAX ? granted : LC_BUFFERS_MAX;
    for (unsigned i = 0; i < s->n && r == 0; i++) {
        memset(&s->slot[i], 0, sizeof(s->slot[i]));
        r = lc_ops(camera)->buffer(camera->handle, i, &s->slot[i].at, &s->slot[i].length);
        if (r == 0 && s->slot[i].length < camera->frame_bytes)
            r = -EIO;
    }
    return r < 0 ? ttf_err_set(err, r, camera->id.id, "a buffer cannot be had: %s",
                               strerrordesc_np(-r))
                 : 0;
}

int lc_negotiate(struct lc_camera *camera, struct ttf_err *err)
{
    struct lc_offer offer = {0};
    struct lc_granted granted = {0};
    struct lc_ask ask;
    int r = choose(camera, &offer, err);

    if (r < 0)
        return r;
    ask = (struct lc_ask){
        .role = camera->pixels->role,
        .fourcc = camera->pixels->fourcc,
        .modifier = camera->pixels->modifier,
        .width = camera->mode.width ? camera->mode.width : camera->config.width,
        .height = camera->mode.height ? camera->mode.height : camera->config.height,
        .colour = colour_of(camera->pixels->packing, camera->pixels->role),
        .buffers = camera->config.buffers + LC_BUFFERS_SPARE,
    };
    ask.width = ask.width ? ask.width : offer.width;
    ask.height = ask.height ? ask.height : offer.height;
    r = lc_ops(camera)->configure(camera->handle, &ask, &granted);
    if (r < 0)
        return ttf_err_set(err, r == -ENODEV ? r : -EINVAL, camera->id.id,
                           "the camera cannot be configured: %s", strerrordesc_np(-r));
    r = check_granted(camera, &granted, err);
    if (r == 0)
        r = take(camera, &granted, err);
    if (r == 0)
        r = get_buffers(camera, ask.buffers, err);
    return r;
}
