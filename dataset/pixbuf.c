/* SPDX-License-Identifier: Apache-2.0 */
#include "ttf/dataset/pixbuf.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "ttf/base/checked.h"

#define SIDE_MAX (1u << 20) /* pixels: far beyond any sensor, small enough for int arithmetic */

static const struct {
    const char *name;
    size_t bytes;
} samples[TTF_SAMPLE_COUNT] = {
    [TTF_SAMPLE_U8] = {"u8", 1},
    [TTF_SAMPLE_U16] = {"u16", 2},
    [TTF_SAMPLE_F16] = {"f16", 2},
    [TTF_SAMPLE_F32] = {"f32", 4},
};

const char *ttf_sample_name(enum ttf_sample sample)
{
    return (unsigned)sample < TTF_SAMPLE_COUNT ? samples[sample].name : "?";
}

int ttf_sample_find(const char *name)
{
    for (int i = 0; name && i < TTF_SAMPLE_COUNT; i++) {
        if (strcmp(name, samples[i].name) == 0)
            return i;
    }
    return -ENOENT;
}

size_t ttf_sample_bytes(enum ttf_sample sample)
{
    return (unsigned)sample < TTF_SAMPLE_COUNT ? samples[sample].bytes : 0;
}

/* In memory a 16-bit float has no arithmetic: it is widened when read. */
static bool in_memory(enum ttf_sample format)
{
    return format == TTF_SAMPLE_U8 || format == TTF_SAMPLE_U16 || format == TTF_SAMPLE_F32;
}

int ttf_pixbuf_alloc(struct ttf_pixbuf *ret, uint32_t width, uint32_t height, uint32_t n_samples,
                     enum ttf_sample format)
{
    size_t stride, bytes;
    void *data;

    if (width == 0 || height == 0 || width > SIDE_MAX || height > SIDE_MAX)
        return -EINVAL;
    if (n_samples < 1 || n_samples > 4 || !in_memory(format))
        return -EINVAL;
    stride = (size_t)width * n_samples * ttf_sample_bytes(format);
    if (!ttf_mul_size(stride, height, &bytes))
        return -EINVAL;
    data = calloc(1, bytes);
    if (!data)
        return -ENOMEM;
    *ret = (struct ttf_pixbuf){.width = width,
                               .height = height,
                               .samples = n_samples,
                               .format = format,
                               .stride = stride,
                               .data = data,
                               .owned = true};
    return 0;
}

void ttf_pixbuf_free(struct ttf_pixbuf *buf)
{
    if (!buf)
        return;
    if (buf->owned)
        free(buf->data);
    memset(buf, 0, sizeof(*buf));
}

int ttf_pixbuf_view(const struct ttf_pixbuf *buf, uint32_t x, uint32_t y, uint32_t w, uint32_t h,
                    struct ttf_pixbuf *ret)
{
    struct ttf_pixbuf view = *buf;

    if (w == 0 || h == 0 || x >= buf->width || y >= buf->height || w > buf->width - x ||
        h > buf->height - y)
        return -EINVAL;
    view.data =
        (char *)ttf_pixbuf_row(buf, y) + (size_t)x * buf->samples * ttf_sample_bytes(buf->format);
    view.width = w;
    view.height = h;
    view.owned = false;
    *ret = view;
    return 0;
}

/* Written so that a NaN becomes 0. */
static unsigned to_code(float value, float max)
{
    float scaled = value * max + 0.5f;

    if (!(scaled > 0.0f))
        return 0;
    return scaled >= max ? (unsigned)max : (unsigned)scaled;
}

static void row_from_u8(const uint8_t *src, void *dst, enum ttf_sample format, size_t n)
{
    uint16_t *u16 = dst;
    float *f32 = dst;

    if (format == TTF_SAMPLE_U16) {
        for (size_t i = 0; i < n; i++)
            u16[i] = (uint16_t)(src[i] * 257u);
    } else {
        for (size_t i = 0; i < n; i++)
            f32[i] = (float)src[i] / 255.0f;
    }
}

static void row_from_u16(const uint16_t *src, void *dst, enum ttf_sample format, size_t n)
{
    uint8_t *u8 = dst;
    float *f32 = dst;

    if (format == TTF_SAMPLE_U8) {
        for (size_t i = 0; i < n; i++)
            u8[i] = (uint8_t)((src[i] + 128u) / 257u); /* nearest; x 257 comes back */
    } else {
        for (size_t i = 0; i < n; i++)
            f32[i] = (float)src[i] / 65535.0f;
    }
}

static void row_from_f32(const float *src, void *dst, enum ttf_sample format, size_t n)
{
    uint8_t *u8 = dst;
    uint16_t *u16 = dst;

    if (format == TTF_SAMPLE_U8) {
        for (size_t i = 0; i < n; i++)
            u8[i] = (uint8_t)to_code(src[i], 255.0f);
    } else {
        for (size_t i = 0; i < n; i++)
            u16[i] = (uint16_t)to_code(src[i], 65535.0f);
    }
}

int ttf_pixbuf_convert(const struct ttf_pixbuf *src, struct ttf_pixbuf *dst)
{
    size_t n = (size_t)src->width * src->samples;

    if (src->width != dst->width || src->height != dst->height || src->samples != dst->samples)
        return -EINVAL;
    if (!in_memory(src->format) || !in_memory(dst->format))
        return -EINVAL;
    for (uint32_t y = 0; y < src->height; y++) {
        const void *from = ttf_pixbuf_row(src, y);
        void *to = ttf_pixbuf_row(dst, y);

        if (src->format == dst->format)
            memcpy(to, from, n * ttf_sample_bytes(src->format));
        else if (src->format == TTF_SAMPLE_U8)
            row_from_u8(from, to, dst->format, n);
        else if (src->format == TTF_SAMPLE_U16)
            row_from_u16(from, to, dst->format, n);
        else
            row_from_f32(from, to, dst->format, n);
    }
    return 0;
}
