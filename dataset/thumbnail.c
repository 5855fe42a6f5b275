/* SPDX-License-Identifier: Apache-2.0 */
/* thumbnail.c: see thumbnail.h. */
#include "ttf/dataset/thumbnail.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "ttf/dataset/colour.h"
#include "ttf/dataset/dng.h"
#include "ttf/dataset/image_file.h"
#include "ttf/dataset/tiff.h"

#define QUALITY 80

/* Where rows come from, downwards: width x 3 codes that mean what `encoding` says. */
struct source {
    uint32_t width, height;
    struct ttf_encoding encoding;
    int (*row)(struct source *source, uint32_t y, uint16_t *rgb, struct ttf_err *err);
};

struct shrunk {
    uint32_t factor; /* pixels that become one, each way */
    uint64_t *sum;   /* of the rows of one small row */
    struct ttf_pixbuf small;
    uint8_t table[65536];
};

static void add_row(struct shrunk *s, const struct source *source, const uint16_t *rgb)
{
    for (uint32_t x = 0; x < source->width; x++) {
        uint64_t *sum = s->sum + (size_t)(x / s->factor) * 3;

        for (int c = 0; c < 3; c++)
            sum[c] += rgb[(size_t)x * 3 + (size_t)c];
    }
}

static void end_row(struct shrunk *s, const struct source *source, uint32_t y, uint32_t rows)
{
    uint8_t *row = ttf_pixbuf_row(&s->small, y);

    for (uint32_t x = 0; x < s->small.width; x++) {
        uint32_t left = source->width - x * s->factor;
        uint64_t n = (uint64_t)rows * (left < s->factor ? left : s->factor);

        if (n == 0)
            continue; /* never: a row has come, and the picture ends with the source */
        for (size_t c = 0; c < 3; c++)
            row[(size_t)x * 3 + c] = s->table[(s->sum[(size_t)x * 3 + c] + n / 2) / n];
    }
    memset(s->sum, 0, (size_t)s->small.width * 3 * sizeof *s->sum);
}

static int shrink(struct shrunk *s, struct source *source, uint16_t *rgb, struct ttf_err *err)
{
    uint32_t rows = 0;

    for (uint32_t y = 0; y < source->height; y++) {
        int r = source->row(source, y, rgb, err);

        if (r < 0)
            return r;
        add_row(s, source, rgb);
        rows++;
        if (rows == s->factor || y + 1 == source->height) {
            end_row(s, source, y / s->factor, rows);
            rows = 0;
        }
    }
    return 0;
}

static int make(struct source *source, const struct ttf_thumbnail_size *size, void **ret,
                size_t *ret_bytes, struct ttf_err *err)
{
    uint32_t longer = source->width > source->height ? source->width : source->height;
    struct shrunk *s = calloc(1, sizeof *s);
    uint16_t *rgb = malloc((size_t)source->width * 3 * sizeof *rgb);
    int r = -ENOMEM;

    if (s && rgb) {
        s->factor = size->side && longer > size->side ? (longer - 1) / size->side + 1 : 1;
        r = ttf_pixbuf_alloc(&s->small, (source->width - 1) / s->factor + 1,
                             (source->height - 1) / s->factor + 1, 3, TTF_SAMPLE_U8);
    }
    if (r == 0) {
        s->sum = calloc((size_t)s->small.width * 3, sizeof *s->sum);
        r = s->sum ? 0 : -ENOMEM;
    }
    if (r < 0) {
        ttf_err_set(err, r, NULL, "no memory for a small picture");
    } else {
        ttf_display8_table(&source->encoding, s->table);
        r = shrink(s, source, rgb, err);
        if (r == 0)
            r = ttf_jpeg_encode(&s->small, size->quality ? size->quality : QUALITY, ret, ret_bytes,
                                err);
    }
    if (s) {
        free(s->sum);
        ttf_pixbuf_free(&s->small);
    }
    free(s);
    free(rgb);
    return r;
}

/* ---- of a TIFF ---- */

struct tiff_source {
    struct source base; /* first */
    struct ttf_tiff_reader *tiff;
    const struct ttf_tiff_info *info;
    struct ttf_encoding encoding; /* of the file's samples */
    void *samples;                /* of a row */
};

static uint16_t as_code(const struct tiff_source *t, size_t i)
{
    double value;

    switch (t->info->format) {
    case TTF_SAMPLE_U8:
        return (uint16_t)(((const uint8_t *)t->samples)[i] * 257u);
    case TTF_SAMPLE_U16:
        return ((const uint16_t *)t->samples)[i];
    default:
        value = (((const float *)t->samples)[i] - t->encoding.pedestal) / t->encoding.scale;
        return !(value > 0) ? 0 : value >= 1 ? 65535 : (uint16_t)lround(value * 65535);
    }
}

static int tiff_row(struct source *source, uint32_t y, uint16_t *rgb, struct ttf_err *err)
{
    struct tiff_source *t = (struct tiff_source *)source;
    size_t samples = t->info->samples;
    int r = ttf_tiff_reader_rows(t->tiff, y, 1, t->samples, 0, err);

    for (size_t x = 0; x < source->width && r == 0; x++)
        for (size_t c = 0; c < 3; c++)
            rgb[x * 3 + c] = as_code(t, x * samples + (samples >= 3 ? c : 0));
    return r;
}

static int of_tiff(struct ttf_io *io, const char *path, const struct ttf_stream *stream,
                   const struct ttf_thumbnail_size *size, void **ret, size_t *ret_bytes,
                   struct ttf_err *err)
{
    struct tiff_source t = {.base = {.row = tiff_row}, .encoding = stream->encoding};
    int r = ttf_tiff_reader_open(io, path, &t.tiff, err);

    if (r < 0)
        return r;
    t.info = ttf_tiff_reader_info(t.tiff);
    t.base.width = t.info->width;
    t.base.height = t.info->height;
    if (t.info->format == TTF_SAMPLE_U8)
        t.base.encoding = (struct ttf_encoding){stream->encoding.pedestal * 257.0,
                                                stream->encoding.scale * 257.0};
    else if (t.info->format == TTF_SAMPLE_U16)
        t.base.encoding = stream->encoding;
    else
        t.base.encoding = (struct ttf_encoding){0, 65535}; /* as_code has seen to it */
    t.samples = malloc((size_t)t.info->width * t.info->samples * sizeof(float));
    if (!t.samples)
        r = ttf_err_set(err, -ENOMEM, path, "no memory for a row");
    else if (!(stream->encoding.scale > 0))
        r = ttf_err_set(err, -ENOTSUP, path, "its stream has no scale");
    else
        r = make(&t.base, size, ret, ret_bytes, err);
    free(t.samples);
    ttf_tiff_reader_close(t.tiff);
    return r;
}

/* ---- of a DNG ---- */

/* A pixel for each two by two of the mosaic; of a camera without one, for each two by two all the same. */
struct dng_source {
    struct source base; /* first */
    struct ttf_raw_sum raw;
    double gain[3]; /* a mosaic's code above black to 65535 = full scale, white balanced */
    uint16_t black;
};

/* Colour (0 red, 1 green, 2 blue) of a place in the mosaic. */
static unsigned colour_at(enum ttf_cfa cfa, unsigned x, unsigned y)
{
    static const unsigned char COLOURS[TTF_CFA_COUNT][4] = {
        [TTF_CFA_NONE] = {1, 1, 1, 1}, [TTF_CFA_RGGB] = {0, 1, 1, 2}, [TTF_CFA_GRBG] = {1, 0, 2, 1},
        [TTF_CFA_GBRG] = {1, 2, 0, 1}, [TTF_CFA_BGGR] = {2, 1, 1, 0},
    };

    return COLOURS[cfa][(y & 1) * 2 + (x & 1)];
}

static int dng_row(struct source *source, uint32_t y, uint16_t *rgb, struct ttf_err *err)
{
    const struct dng_source *d = (const struct dng_source *)source;
    const struct ttf_frame_format *format = &d->raw.format;

    (void)err;
    for (size_t x = 0; x < source->width; x++) {
        double sum[3] = {0}, n[3] = {0};

        for (unsigned k = 0; k < 4; k++) {
            size_t at = ((size_t)y * 2 + k / 2) * format->width + x * 2 + k % 2;
            unsigned c = colour_at(format->cfa, k % 2, k / 2);

            sum[c] += (double)d->raw.sum[at] / d->raw.n - d->black;
            n[c]++;
        }
        for (unsigned c = 0; c < 3; c++) {
            unsigned from = n[c] > 0 ? c : 1;
            double code = sum[from] / n[from] * d->gain[c];

            rgb[x * 3 + c] = code <= 0 ? 0 : code >= 65535 ? 65535 : (uint16_t)code;
        }
    }
    return 0;
}

static int of_dng(struct ttf_io *io, const char *path, const struct ttf_thumbnail_size *size,
                  void **ret, size_t *ret_bytes, struct ttf_err *err)
{
    struct dng_source d = {.base = {.encoding = {0, 65535}, .row = dng_row}};
    struct ttf_dng_info info;
    uint16_t white;
    int r = ttf_dng_read(io, path, &d.raw, &info, err);

    if (r < 0)
        return r;
    d.base.width = d.raw.format.width / 2;
    d.base.height = d.raw.format.height / 2;
    ttf_raw_sum_levels(&d.raw.format, &d.black, &white);
    for (int c = 0; c < 3; c++) {
        double neutral = info.neutral[c] > 0 ? info.neutral[c] : 1;

        if (d.raw.format.cfa == TTF_CFA_NONE)
            neutral = 1;
        d.gain[c] = 65535.0 / (white - d.black) / neutral;
    }
    if (d.base.width == 0 || d.base.height == 0 || d.raw.samples != 1 || d.raw.n == 0 ||
        d.raw.format.cfa >= TTF_CFA_COUNT)
        r = ttf_err_set(err, -ENOTSUP, path, "has no pixels that can be shown small");
    else
        r = make(&d.base, size, ret, ret_bytes, err);
    ttf_raw_sum_free(&d.raw);
    return r;
}

int ttf_thumbnail_of_file(struct ttf_io *io, const char *path, const struct ttf_stream *stream,
                          const struct ttf_thumbnail_size *size, void **ret, size_t *ret_bytes,
                          struct ttf_err *err)
{
    size_t n = strlen(path);

    if (n > 4 && strcmp(path + n - 4, ".dng") == 0)
        return of_dng(io, path, size, ret, ret_bytes, err);
    return of_tiff(io, path, stream, size, ret, ret_bytes, err);
}
