/* SPDX-License-Identifier: Apache-2.0 */
#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "calibration_private.h"
#include "ttf/base/checked.h"
#include "ttf/dataset/colour.h"

#define FRAMES_MAX 65535u

static bool is_raw(enum ttf_packing packing)
{
    return packing == TTF_PACKING_RAW16 || packing == TTF_PACKING_GREY16 ||
           packing == TTF_PACKING_RAW8 || packing == TTF_PACKING_RAW10P ||
           packing == TTF_PACKING_RAW12P;
}

static bool is_colour(enum ttf_packing packing)
{
    return packing == TTF_PACKING_RGB8 || packing == TTF_PACKING_YUYV8 ||
           packing == TTF_PACKING_NV12;
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
    if (ttf_row_bytes(format->packing, format->width) == 0)
        return -ENOTSUP;
    if (is_raw(format->packing) &&
        (format->bits < 1 || format->bits > 16 || format->white_level <= format->black_level))
        return -EINVAL;
    return is_colour(format->packing) ? 3 : 1;
}

int ttf_raw_sum_samples(const struct ttf_frame_format *format, size_t *ret)
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
    int samples = ttf_raw_sum_samples(format, &n);

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
    int samples = ttf_raw_sum_samples(format, &n);

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

static void put_yuv(uint32_t *sum, int y, int cb, int cr, uint32_t keep)
{
    uint8_t rgb[3];

    rgb_of_yuv(y, cb, cr, rgb);
    for (int c = 0; c < 3; c++)
        sum[c] = sum[c] * keep + ttf_srgb8_to_linear16(rgb[c]);
}

static void add_yuyv(uint32_t *sum, const uint8_t *row, uint32_t width, uint32_t keep)
{
    for (uint32_t x = 0; x < width; x++) {
        const uint8_t *pair = row + (size_t)(x / 2) * 4;

        put_yuv(sum + 3 * (size_t)x, pair[x % 2 ? 2 : 0], pair[1], pair[3], keep);
    }
}

/* colour: the row of pairs that this row of brightness shares with its neighbour. */
static void add_nv12(uint32_t *sum, const uint8_t *row, const uint8_t *colour, uint32_t width,
                     uint32_t keep)
{
    for (uint32_t x = 0; x < width; x++) {
        const uint8_t *pair = colour + (size_t)(x / 2) * 2;

        put_yuv(sum + 3 * (size_t)x, row[x], pair[0], pair[1], keep);
    }
}

/* `together` samples: their high bytes, then one byte with the low 8 / together bits of each, the first lowest. */
static void add_packed(uint32_t *sum, const uint8_t *row, uint32_t width, unsigned together,
                       uint32_t keep)
{
    unsigned low_bits = 8 / together;

    for (uint32_t x = 0; x < width; x++) {
        const uint8_t *group = row + (size_t)(x / together) * (together + 1);
        unsigned i = x % together;
        unsigned low = group[together] >> (i * low_bits) & ((1u << low_bits) - 1);

        sum[x] = sum[x] * keep + ((unsigned)group[i] << low_bits | low);
    }
}

static void add_words(uint32_t *sum, const uint16_t *row, uint32_t n, uint32_t keep)
{
    for (uint32_t i = 0; i < n; i++)
        sum[i] = sum[i] * keep + row[i];
}

static void add_bytes(uint32_t *sum, const uint8_t *row, uint32_t n, uint32_t keep)
{
    for (uint32_t i = 0; i < n; i++)
        sum[i] = sum[i] * keep + row[i];
}

/* Bytes that are sRGB-encoded. */
static void add_pictures(uint32_t *sum, const uint8_t *row, uint32_t n, uint32_t keep)
{
    for (uint32_t i = 0; i < n; i++)
        sum[i] = sum[i] * keep + ttf_srgb8_to_linear16(row[i]);
}

/* keep: 1 adds to what is there, 0 begins anew. */
static void add_row(uint32_t *sum, const struct ttf_frame *frame, uint32_t y, uint32_t keep)
{
    const struct ttf_frame_format *format = &frame->format;
    const uint8_t *data = frame->data, *row = data + (size_t)y * format->stride;
    uint32_t n = format->width;

    switch (format->packing) {
    case TTF_PACKING_RAW16:
    case TTF_PACKING_GREY16:
        add_words(sum, (const uint16_t *)(const void *)row, n, keep);
        break;
    case TTF_PACKING_RAW8:
        add_bytes(sum, row, n, keep);
        break;
    case TTF_PACKING_RAW10P:
        add_packed(sum, row, n, 4, keep);
        break;
    case TTF_PACKING_RAW12P:
        add_packed(sum, row, n, 2, keep);
        break;
    case TTF_PACKING_YUYV8:
        add_yuyv(sum, row, n, keep);
        break;
    case TTF_PACKING_NV12:
        add_nv12(sum, row, data + ((size_t)format->height + y / 2) * format->stride, n, keep);
        break;
    default:
        add_pictures(sum, row, format->packing == TTF_PACKING_RGB8 ? 3 * n : n, keep);
    }
}

static bool in_words(enum ttf_packing packing)
{
    return packing == TTF_PACKING_RAW16 || packing == TTF_PACKING_GREY16;
}

int ttf_raw_sum_add(struct ttf_raw_sum *sum, const struct ttf_frame *frame)
{
    const struct ttf_frame_format *format = &frame->format;
    size_t row = ttf_row_bytes(format->packing, format->width), need;

    if (!same_kind(format, &sum->format) || format->stride < row || !frame->data ||
        (in_words(format->packing) && format->stride % 2 != 0))
        return -EINVAL;
    if (!ttf_mul_size(format->stride, ttf_frame_rows(format) - 1, &need) ||
        !ttf_add_size(need, row, &need) || frame->bytes < need)
        return -EINVAL;
    if (sum->n >= FRAMES_MAX)
        return -EOVERFLOW;
    for (uint32_t y = 0; y < format->height; y++) {
        uint32_t *to = sum->sum + (size_t)y * format->width * sum->samples;

        add_row(to, frame, y, sum->n > 0 ? 1 : 0);
    }
    if (sum->n == 0)
        sum->settings = frame->settings;
    sum->n++;
    return 0;
}
