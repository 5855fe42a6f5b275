/* SPDX-License-Identifier: Apache-2.0 */
/* negotiate.c: asks for a format and a rate, and looks what was granted. */
#include <errno.h>
#include <stdio.h>
#include <string.h>

#include "device.h"
#include "ttf/base/checked.h"
#include "ttf/base/time.h"

/* Where a driver tells no rate: longer than any that we know of, as waits are derived from it. */
#define PERIOD_UNKNOWN_NS (200 * TTF_NS_PER_MS)

#define FORMATS_MAX 256

static bool wanted(const struct v4l2_camera *camera, const struct ttf_camera_mode *mode,
                   const struct v4l2_pixels *pixels)
{
    if (camera->config.pixel_format[0] &&
        pixels->fourcc != v4l2_fourcc_of(camera->config.pixel_format))
        return false;
    return mode->packing == TTF_PACKING_NONE || pixels->packing == mode->packing;
}

/* Formats that are offered and cannot be used, for the message. */
struct refused {
    char text[120];
    size_t n;
    bool compressed;
};

static void note(struct refused *refused, uint32_t fourcc, uint32_t flags)
{
    char text[5];
    int n = snprintf(refused->text + refused->n, sizeof(refused->text) - refused->n, "%s%s",
                     refused->n ? ", " : "", v4l2_fourcc_text(fourcc, text));

    if (n > 0 && (size_t)n < sizeof(refused->text) - refused->n)
        refused->n += (size_t)n;
    else
        refused->text[refused->n] = '\0';
    refused->compressed |= v4l2_pixels_compressed(fourcc, flags);
}

static int no_format(const struct v4l2_camera *camera, const struct refused *refused,
                     struct ttf_err *err)
{
    const char *asked = camera->config.pixel_format;

    if (refused->n == 0)
        return ttf_err_set(err, -EINVAL, camera->id.device, "the camera offers no pixel format");
    if (asked[0] && v4l2_pixels_compressed(v4l2_fourcc_of(asked), 0))
        ttf_err_set(err, -EINVAL, camera->id.device,
                    "%s is compressed: what it threw away cannot be calibrated", asked);
    else if (asked[0] && !v4l2_pixels_of(v4l2_fourcc_of(asked)))
        ttf_err_set(err, -EINVAL, camera->id.device, "pixels of format '%s' are not known here",
                    asked);
    else
        ttf_err_set(err, -EINVAL, camera->id.device, "the camera does not give %s",
                    asked[0] ? asked : "the pixels that were asked for");
    ttf_err_hint(err, "it offers %s%s", refused->text,
                 refused->compressed ? "; compressed ones are refused" : "");
    return -EINVAL;
}

static int choose(struct v4l2_camera *camera, const struct ttf_camera_mode *mode,
                  const struct v4l2_pixels **ret, struct ttf_err *err)
{
    const struct v4l2_pixels *best = NULL;
    struct refused refused = {0};

    for (unsigned i = 0; i < FORMATS_MAX; i++) {
        struct v4l2_fmtdesc desc = {.index = i, .type = V4L2_BUF_TYPE_VIDEO_CAPTURE};
        const struct v4l2_pixels *pixels;
        int r = v4l2_ioctl(camera, VIDIOC_ENUM_FMT, &desc);

        if (r == -ENODEV)
            return ttf_err_set(err, r, camera->id.device, "the camera is gone");
        if (r < 0)
            break;
        pixels = v4l2_pixels_of(desc.pixelformat);
        if (pixels && v4l2_pixels_compressed(desc.pixelformat, desc.flags))
            pixels = NULL;
        if (!pixels || !wanted(camera, mode, pixels))
            note(&refused, desc.pixelformat, desc.flags);
        else if (!best || v4l2_pixels_rank(pixels->fourcc) < v4l2_pixels_rank(best->fourcc))
            best = pixels;
    }
    if (!best)
        return no_format(camera, &refused, err);
    *ret = best;
    return 0;
}

/* The largest the camera has in this format; nothing changes if it does not say. */
static void largest(struct v4l2_camera *camera, uint32_t fourcc, uint32_t *width, uint32_t *height)
{
    uint64_t area = 0;

    for (unsigned i = 0; i < FORMATS_MAX; i++) {
        struct v4l2_frmsizeenum size = {.index = i, .pixel_format = fourcc};

        if (v4l2_ioctl(camera, VIDIOC_ENUM_FRAMESIZES, &size) < 0)
            return;
        if (size.type != V4L2_FRMSIZE_TYPE_DISCRETE) {
            *width = size.stepwise.max_width;
            *height = size.stepwise.max_height;
            return;
        }
        if ((uint64_t)size.discrete.width * size.discrete.height > area) {
            area = (uint64_t)size.discrete.width * size.discrete.height;
            *width = size.discrete.width;
            *height = size.discrete.height;
        }
    }
}

static bool is_yuv(enum ttf_packing packing)
{
    return packing == TTF_PACKING_YUYV8 || packing == TTF_PACKING_NV12;
}

static int ask(struct v4l2_camera *camera, const struct ttf_camera_mode *mode,
               struct v4l2_pix_format *pix, struct ttf_err *err)
{
    struct v4l2_format format = {.type = V4L2_BUF_TYPE_VIDEO_CAPTURE};
    uint32_t width = mode->width ? mode->width : camera->config.width;
    uint32_t height = mode->height ? mode->height : camera->config.height;
    int r = v4l2_ioctl(camera, VIDIOC_G_FMT, &format);

    if (r < 0)
        return ttf_err_set(err, r, camera->id.device, "the camera tells no format: %s",
                           strerrordesc_np(-r));
    if (width == 0 || height == 0)
        largest(camera, camera->pixels->fourcc, &format.fmt.pix.width, &format.fmt.pix.height);
    if (width > 0)
        format.fmt.pix.width = width;
    if (height > 0)
        format.fmt.pix.height = height;
    format.fmt.pix.pixelformat = camera->pixels->fourcc;
    format.fmt.pix.field = V4L2_FIELD_NONE;
    format.fmt.pix.bytesperline = 0;
    format.fmt.pix.sizeimage = 0;
    format.fmt.pix.priv = V4L2_PIX_FMT_PRIV_MAGIC;
    format.fmt.pix.flags = V4L2_PIX_FMT_FLAG_SET_CSC;
    format.fmt.pix.ycbcr_enc = is_yuv(camera->pixels->packing) ? V4L2_YCBCR_ENC_601 : 0;
    /* Asked for in so many words: a driver may remember what another program asked for. */
    format.fmt.pix.quantization = is_yuv(camera->pixels->packing) ? V4L2_QUANTIZATION_LIM_RANGE
                                                                  : V4L2_QUANTIZATION_FULL_RANGE;
    r = v4l2_ioctl(camera, VIDIOC_S_FMT, &format);
    if (r == -EBUSY)
        return ttf_err_set(err, r, camera->id.device, "another program uses the camera");
    if (r < 0)
        return ttf_err_set(err, r, camera->id.device, "the camera grants no format: %s",
                           strerrordesc_np(-r));
    *pix = format.fmt.pix;
    return 0;
}

/* Developing knows one kind of YUV and one of RGB. */
static int check_encoding(const struct v4l2_camera *camera, const struct v4l2_pix_format *pix,
                          struct ttf_err *err)
{
    bool yuv = is_yuv(camera->pixels->packing);
    uint32_t enc = pix->ycbcr_enc, quantization = pix->quantization;

    if (enc == V4L2_YCBCR_ENC_DEFAULT)
        enc = V4L2_MAP_YCBCR_ENC_DEFAULT(pix->colorspace);
    if (quantization == V4L2_QUANTIZATION_DEFAULT)
        quantization = V4L2_MAP_QUANTIZATION_DEFAULT(!yuv, pix->colorspace, enc);
    if (yuv && enc != V4L2_YCBCR_ENC_601 && enc != V4L2_YCBCR_ENC_XV601) {
        ttf_err_set(err, -ENOTSUP, camera->id.device,
                    "its colours are coded by another rule than BT.601 (%u)", enc);
        ttf_err_hint(err, "ask for RGB3 or a raw pixel format, if it has one");
        return -ENOTSUP;
    }
    if (yuv && quantization != V4L2_QUANTIZATION_LIM_RANGE) {
        ttf_err_set(err, -ENOTSUP, camera->id.device, "its YUV codes have full range");
        ttf_err_hint(err, "ask for RGB3 or a raw pixel format, if it has one");
        return -ENOTSUP;
    }
    if (camera->pixels->packing == TTF_PACKING_RGB8 && quantization != V4L2_QUANTIZATION_FULL_RANGE)
        return ttf_err_set(err, -ENOTSUP, camera->id.device,
                           "its RGB codes have limited range (16 to 235)");
    return 0;
}

static int check_granted(struct v4l2_camera *camera, const struct v4l2_pix_format *pix,
                         struct ttf_err *err)
{
    const char *where = camera->id.device;
    char got[5], asked[5];
    size_t row = ttf_row_bytes(camera->pixels->packing, pix->width);

    (void)v4l2_fourcc_text(camera->pixels->fourcc, asked);
    (void)v4l2_fourcc_text(pix->pixelformat, got);
    if (pix->pixelformat != camera->pixels->fourcc) {
        ttf_err_set(err, -EINVAL, where, "instead of %s the driver grants %s%s", asked, got,
                    v4l2_pixels_compressed(pix->pixelformat, 0) ? ", which is compressed" : "");
        ttf_err_hint(err, "name another pixel_format: `v4l2-ctl --list-formats-ext`");
        return -EINVAL;
    }
    if (pix->width == 0 || pix->height == 0 || pix->width > 65535 || pix->height > 65535)
        return ttf_err_set(err, -EINVAL, where, "the driver grants frames of %u x %u", pix->width,
                           pix->height);
    if (pix->field != V4L2_FIELD_NONE && pix->field != V4L2_FIELD_ANY)
        return ttf_err_set(err, -EINVAL, where, "the driver grants half pictures (interlaced)");
    if (pix->bytesperline < row)
        return ttf_err_set(err, -EINVAL, where,
                           "the driver's rows have %u bytes, and %u pixels of %s take %zu",
                           pix->bytesperline, pix->width, got, row);
    return check_encoding(camera, pix, err);
}

static int take(struct v4l2_camera *camera, const struct v4l2_pix_format *pix, struct ttf_err *err)
{
    const struct v4l2_pixels *p = camera->pixels;
    const struct ttf_v4l2_config *c = &camera->config;
    uint32_t white = c->white_level ? c->white_level : (1u << p->bits) - 1;
    struct ttf_frame_format format = {
        .width = pix->width,
        .height = pix->height,
        .stride = pix->bytesperline,
        .packing = p->packing,
        .cfa = p->cfa,
        .bits = p->bits,
        .black_level = c->black_level,
        .white_level = (uint16_t)white,
    };

    /* Grey bytes of a sensor that says so are no picture for the eye. */
    if (p->packing == TTF_PACKING_GREY8 &&
        (pix->xfer_func == V4L2_XFER_FUNC_NONE || pix->colorspace == V4L2_COLORSPACE_RAW))
        format.packing = TTF_PACKING_RAW8;
    if (white >> p->bits != 0 || c->black_level >= white)
        return ttf_err_set(err, -EINVAL, camera->id.device,
                           "levels of %u to %u do not fit samples of %u bits", c->black_level,
                           white, p->bits);
    if (!ttf_mul_size(format.stride, ttf_frame_rows(&format), &camera->frame_bytes) ||
        pix->sizeimage < camera->frame_bytes)
        return ttf_err_set(err, -EINVAL, camera->id.device,
                           "the driver's frames have %u bytes, fewer than %u rows of %u",
                           pix->sizeimage, pix->height, pix->bytesperline);
    camera->base.format = format;
    return 0;
}

/* What the driver makes of the wanted rate; without a wish, what it is. */
static void settle_rate(struct v4l2_camera *camera)
{
    struct v4l2_streamparm parm = {.type = V4L2_BUF_TYPE_VIDEO_CAPTURE};
    struct v4l2_fract *per = &parm.parm.capture.timeperframe;
    int64_t wish = camera->config.frame_period_ns;
    int r = v4l2_ioctl(camera, VIDIOC_G_PARM, &parm);

    camera->rate_settable = r == 0 && parm.parm.capture.capability & V4L2_CAP_TIMEPERFRAME;
    if (r == 0 && wish > 0) {
        per->numerator = (uint32_t)(wish / TTF_NS_PER_US);
        per->denominator = 1000000;
        r = v4l2_ioctl(camera, VIDIOC_S_PARM, &parm);
    }
    if (r == 0 && per->numerator > 0 && per->denominator > 0)
        camera->period_ns = (int64_t)((double)per->numerator * 1e9 / per->denominator + 0.5);
    else
        camera->period_ns = wish > 0 ? wish : PERIOD_UNKNOWN_NS;
    if (camera->period_ns < TTF_NS_PER_US)
        camera->period_ns = TTF_NS_PER_US;
}

int v4l2_negotiate(struct v4l2_camera *camera, const struct ttf_camera_mode *mode,
                   struct ttf_err *err)
{
    struct v4l2_pix_format pix = {0};
    int r = choose(camera, mode, &camera->pixels, err);

    if (r == 0)
        r = ask(camera, mode, &pix, err);
    if (r == 0)
        r = check_granted(camera, &pix, err);
    if (r == 0)
        r = take(camera, &pix, err);
    if (r == 0)
        settle_rate(camera);
    return r;
}
