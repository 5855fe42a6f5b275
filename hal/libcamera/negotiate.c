/* SPDX-License-Identifier: Apache-2.0 */
/* negotiate.c: asks for a format, and looks what was granted. */
#include <errno.h>
#include <string.h>

#include "device.h"
#include "ttf/base/checked.h"

static enum lc_colour colour_of(enum ttf_packing packing, enum lc_role role)
{
    if (role == LC_RAW)
        return LC_COLOUR_RAW;
    return packing == TTF_PACKING_YUYV8 || packing == TTF_PACKING_NV12 ? LC_COLOUR_BT601_LIMITED
                                                                       : LC_COLOUR_RGB_FULL;
}

/*
 * A mosaic's order is that of the sensor as it reads out, whatever was asked: one that is mounted upside down is turned by
 * libcamera. Words that are wider than asked hold the same samples; but a board that names a format may have given levels for it.
 */
static bool as_good(const struct lc_camera *camera, const struct lc_pixels *got)
{
    const struct lc_pixels *asked = camera->pixels;

    if (got == asked)
        return true;
    if (!got || got->role != LC_RAW || asked->role != LC_RAW || got->packing != asked->packing ||
        (got->cfa == TTF_CFA_NONE) != (asked->cfa == TTF_CFA_NONE))
        return false;
    return got->bits == asked->bits ||
           (!camera->config.pixel_format[0] && got->bits > asked->bits && got->modifier == 0);
}

static int refuse_pixels(const struct lc_camera *camera, const struct lc_granted *granted,
                         struct ttf_err *err)
{
    bool compressed = lc_pixels_compressed(granted->fourcc, granted->modifier);
    const struct lc_pixels *p = camera->pixels;
    char asked[6], got[6];

    (void)lc_pixels_text(p->fourcc, p->modifier, asked);
    (void)lc_pixels_text(granted->fourcc, granted->modifier, got);
    ttf_err_set(err, -EINVAL, camera->id.id, "instead of %s libcamera grants %s%s", asked, got,
                compressed ? ", which is compressed" : "");
    if (camera->config.pixel_format[0] && p->role == LC_RAW && compressed)
        ttf_err_hint(err,
                     "leave out 'format', so that words that are not compressed are asked for");
    else if (camera->config.pixel_format[0] && lc_pixels_of(granted->fourcc, granted->modifier))
        ttf_err_hint(err, "write 'format: %s', or leave it out; its levels are of its bits", got);
    else
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

/* The code of saturation: a word that is wider than the sensor's samples has them in its upper bits. */
static uint32_t white_of(struct lc_camera *camera, const struct lc_granted *granted)
{
    const struct lc_pixels *p = camera->pixels;
    unsigned bits = p->bits;

    if (camera->config.white_level)
        return camera->config.white_level;
    if (p->role == LC_RAW && p->bits == 16)
        bits = lc_sensor_bits(camera, granted);
    return ((1u << bits) - 1) << (p->bits - bits);
}

static int take(struct lc_camera *camera, const struct lc_granted *granted, struct ttf_err *err)
{
    const struct lc_pixels *p = camera->pixels;
    const struct ttf_libcamera_config *c = &camera->config;
    uint32_t white = white_of(camera, granted);
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

static int configure(struct lc_camera *camera, const struct lc_offer *offer, struct lc_granted *ret,
                     struct ttf_err *err)
{
    const struct lc_pixels *p = camera->pixels;
    struct lc_ask ask = {
        .role = p->role,
        .fourcc = p->fourcc,
        .modifier = p->modifier,
        .width = camera->mode.width ? camera->mode.width : camera->config.width,
        .height = camera->mode.height ? camera->mode.height : camera->config.height,
        .colour = colour_of(p->packing, p->role),
        .buffers = camera->config.buffers + LC_BUFFERS_SPARE,
    };
    int r;

    ask.width = ask.width ? ask.width : offer->width;
    ask.height = ask.height ? ask.height : offer->height;
    *ret = (struct lc_granted){0};
    r = lc_ops(camera)->configure(camera->handle, &ask, ret);
    return r < 0 ? ttf_err_set(err, r == -ENODEV ? r : -EINVAL, camera->id.id,
                               "the camera cannot be configured: %s", strerrordesc_np(-r))
                 : 0;
}

/* A Raspberry Pi 5 compresses where packed samples are asked for, and lists no others: it gives plain words to who asks for them. */
static bool ask_for_words(struct lc_camera *camera, const struct lc_granted *granted)
{
    const struct lc_pixels *plain = lc_pixels_unpacked(camera->pixels);

    if (camera->pixels->role != LC_RAW || camera->config.pixel_format[0] ||
        !lc_pixels_compressed(granted->fourcc, granted->modifier) || plain == camera->pixels ||
        (camera->mode.packing != TTF_PACKING_NONE && plain->packing != camera->mode.packing))
        return false;
    camera->pixels = plain;
    return true;
}

int lc_negotiate(struct lc_camera *camera, struct ttf_err *err)
{
    struct lc_offer offer = {0};
    struct lc_granted granted = {0};
    const struct lc_pixels *got;
    int r = lc_choose(camera, &offer, err);

    if (r == 0)
        r = configure(camera, &offer, &granted, err);
    if (r == 0 && ask_for_words(camera, &granted))
        r = configure(camera, &offer, &granted, err);
    if (r < 0)
        return r;
    got = lc_pixels_of(granted.fourcc, granted.modifier);
    if (!as_good(camera, got))
        return refuse_pixels(camera, &granted, err);
    camera->pixels = got;
    r = check_granted(camera, &granted, err);
    if (r == 0)
        r = take(camera, &granted, err);
    if (r == 0)
        r = get_buffers(camera, camera->config.buffers + LC_BUFFERS_SPARE, err);
    return r;
}
