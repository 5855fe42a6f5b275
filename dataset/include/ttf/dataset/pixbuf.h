/* SPDX-License-Identifier: Apache-2.0 */
/* pixbuf.h: a rectangle of pixels in memory. */
#ifndef TTF_DATASET_PIXBUF_H
#define TTF_DATASET_PIXBUF_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "ttf/base/attr.h"

enum ttf_sample {
    TTF_SAMPLE_U8 = 0,
    TTF_SAMPLE_U16,
    TTF_SAMPLE_F16, /* stored only; in memory it is F32 */
    TTF_SAMPLE_F32,
    TTF_SAMPLE_COUNT
};

/* "u8", "u16", "f16", "f32"; and bytes of one sample in a file. */
const char *ttf_sample_name(enum ttf_sample sample);
int ttf_sample_find(const char *name); /* -ENOENT */
size_t ttf_sample_bytes(enum ttf_sample sample);

/* Interleaved samples, machine byte order. A view does not own its data. */
struct ttf_pixbuf {
    uint32_t width, height; /* pixels */
    uint32_t samples;       /* per pixel, 1..4 */
    enum ttf_sample format;
    size_t stride; /* bytes from row to row */
    void *data;
    bool owned;
};

/* Zeroed pixels, rows tightly packed. -EINVAL for a zero or absurd size (a side beyond 2^20) or F16, -ENOMEM. */
TTF_MUST_USE int ttf_pixbuf_alloc(struct ttf_pixbuf *ret, uint32_t width, uint32_t height,
                                  uint32_t samples, enum ttf_sample format);

/* Frees what is owned and zeroes *buf. NULL and a zeroed struct are fine. */
void ttf_pixbuf_free(struct ttf_pixbuf *buf);

/* A view into buf; -EINVAL if the rectangle does not lie inside. Lives as long as buf's data. */
TTF_MUST_USE int ttf_pixbuf_view(const struct ttf_pixbuf *buf, uint32_t x, uint32_t y, uint32_t w,
                                 uint32_t h, struct ttf_pixbuf *ret);

static inline void *ttf_pixbuf_row(const struct ttf_pixbuf *buf, uint32_t y)
{
    return (char *)buf->data + (size_t)y * buf->stride;
}

/*
 * Converts samples between formats of equal size and samples count: integers map
 * to 0..1 floats and back (rounded to nearest, clipped), u8 <-> u16 by x 257.
 */
TTF_MUST_USE int ttf_pixbuf_convert(const struct ttf_pixbuf *src, struct ttf_pixbuf *dst);

/*
 * Resamples src into dst (same samples and format, any sizes): averages over the
 * area when shrinking, interpolates linearly when enlarging. In the samples'
 * own space: convert to linear light first where that matters.
 */
TTF_MUST_USE int ttf_pixbuf_resample(const struct ttf_pixbuf *src, struct ttf_pixbuf *dst);

#endif
