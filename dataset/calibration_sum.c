/* SPDX-License-Identifier: Apache-2.0 */
#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "calibration_private.h"
#include "ttf/base/checked.h"
#include "ttf/dataset/colour.h"

#define FRAMES_MAX 65535u

/* Bytes that a row of width pixels takes, 0 for an unknown packing. */
static size_t row_bytes(const struct ttf_frame_format *format)
{
    switch (format->packing) {
    case TTF_PACKING_RAW16:
    case TTF_PACKING_GREY16:
        return (size_t)format->width * 2;
    case TTF_PACKING_GREY8:
        return format->width;
    case TTF_PACKING_RGB8:
        return (size_t)format->width * 3;
    case TTF_PACKING_YUYV8:
        return ((size_t)format->width + 1) / 2 * 4;
    default:
        return 0;
    }
}

static bool is_raw(enum ttf_packing packing)
{
    return packing == TTF_PACKING_RAW16 || packing == TTF_PACKING_GREY16;
}

void ttf_raw_sum_levels(const struct ttf_frame_format *format, uint16_t *ret_black,
                        uint16_t *ret_white)
{
    bool raw = is_raw(format->packing);

    *ret_black = raw ? format->black_level : 0;
    *ret_white = raw ? format->white_level : 65535;
}

int calibration_samples(const struct ttf_frame_format *format)
{
    if (format->width == 0 || format->height == 0 || format->width > 65535 ||
        format->height > 65535 || (unsigned)format->cfa >= TTF_CFA_COUNT)
        return -EINVAL;
    if (row_bytes(format) == 0)
        return -ENOTSUP;
    if (is_raw(format->packing) &&
        (format->bits < 1 || format->bits > 16 || format->white_level <= format->black_level))
        return -EINVAL;
    return format->packing == TTF_PACKING_RGB8 || format->packing == TTF_PACKING_YUYV8 ? 3 : 1;
}

/* Samples per pixel, and of a frame into *ret; negative as init. */
static int samples_of(const struct ttf_frame_format *format, size_t *ret)
{
    int samples = calibration_samples(format);

    if (samples < 0)
        return samples;
    return ttf_mul_size((size_t)format->width * format->height, (size_t)samples, ret) ? samples
                                                                                      : -EINVAL;
}

int ttf_raw_sum_init(struct ttf_raw_sum *sum, const struct ttf_frame_format *format)
{
    size_t n;
    int samples = samples_of(format, &n);

    if (samples < 0)
        return samples;
    memset(sum, 0, sizeof(*sum));
    sum->sum = calloc(n, sizeof(*sum->sum));
    if (!sum->sum)
        return -ENOMEM;
    sum->room = n;
    sum->format = *format;
    sum->samples = (unsigned)samples;
    return 0;
}

int ttf_raw_sum_refit(struct ttf_raw_sum *sum, const struct ttf_frame_format *format)
{
    size_t n;
    int samples = samples_of(format, &n);

    if (samples < 0)
        return samples;
    if (n > sum->room)
        return -ENOSPC;
    sum->format = *format;
    sum->samples = (unsigned)samples;
    sum->n = 0;
    return 0;
}

void ttf_raw_sum_reset(struct ttf_raw_sum *sum)
{
    sum->n = 0;
}

void ttf_raw_sum_free(struct ttf_raw_sum *sum)
{
    if (!sum)
        return;
    free(sum->sum);
    memset(sum, 0, sizeof(*sum));
}

static bool same_kind(const struct ttf_frame_format *a, const struct ttf_frame_format *b)
{
    return a->width == b->width && a->height == b->height && a->packing == b->packing &&
           a->cfa == b->cfa && a->bits == b->bits && a->black_level == b->black_level &&
           a->white_level == b->white_level;
}

/* Two pixels of BT.601 limited range to R, G, B codes; coefficients in 1/65536. */
static void rgb_of_yuv(int y, int cb, int cr, uint8_t ret[3])
{
    int luma = 76309 * (y - 16); /* 255 / 219 */
    int rgb[3];

    cb -= 128;
    cr -= 128;
    rgb[0] = luma + 104597 * cr; /* 1.402 x 255 / 224 */
    rgb[1] = luma - 25675 * cb - 53279 * cr;
    rgb[2] = luma + 132201 * cb;
    for (int c = 0; c < 3; c++) {
        int code = rgb[c] <= 0 ? 0 : (rgb[c] + 32768) / 65536;

        ret[c] = (uint8_t)(code > 255 ? 255 : code);
    }
}

static void add_yuyv(uint32_t *sum, const uint8_t *row, uint32_t width, uint32_t keep)
{
    for (uint32_t x = 0; x < width; x++) {
        const uint8_t *pair = row + (size_t)(x / 2) * 4;
        uint8_t rgb[3];

        rgb_of_yuv(pair[x % 2 ? 2 : 0], pair[1], pair[3], rgb);
        for (int c = 0; c < 3; c++)
            sum[3 * x + c] = sum[3 * x + c] * keep + ttf_srgb8_to_linear16(rgb[c]);
    }
}

/* keep: 1 adds to what is there, 0 begins anew. */
static void add_row(uint32_t *sum, const void *row, const struct ttf_frame_format *format,
                    uint32_t keep)
{
    uint32_t n = format->packing == TTF_PACKING_RGB8 ? 3 * format->width : format->width;
    const uint16_t *words = row;
    const uint8_t *bytes = row;

    if (is_raw(format->packing)) {
        for (uint32_t i = 0; i < n; i++)
            sum[i] = sum[i] * keep + words[i];
    } else if (format->packing == TTF_PACKING_YUYV8) {
        add_yuyv(sum, bytes, format->width, keep);
    } else {
        for (uint32_t i = 0; i < n; i++)
            sum[i] = sum[i] * keep + ttf_srgb8_to_linear16(bytes[i]);
    }
}

int ttf_raw_sum_add(struct ttf_raw_sum *sum, const struct ttf_frame *frame)
{
    const struct ttf_frame_format *format = &frame->format;
    size_t row = row_bytes(format), need;

    if (!same_kind(format, &sum->format) || format->stride < row || !frame->data ||
        (is_raw(format->packing) && format->stride % 2 != 0))
        return -EINVAL;
    if (!ttf_mul_size(format->stride, format->height - 1, &need) ||
        !ttf_add_size(need, row, &need) || frame->bytes < need)
        return -EINVAL;
    if (sum->n >= FRAMES_MAX)
        return -EOVERFLOW;
    for (uint32_t y = 0; y < format->height; y++) {
        uint32_t *to = sum->sum + (size_t)y * format->width * sum->samples;

        add_row(to, (const char *)frame->data + (size_t)y * format->stride, format,
                sum->n > 0 ? 1 : 0);
    }
    if (sum->n == 0)
        sum->settings = frame->settings;
    sum->n++;
    return 0;
}
