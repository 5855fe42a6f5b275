/* SPDX-License-Identifier: Apache-2.0 */
#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "half.h"
#include "tiff_client.h"
#include "ttf/base/checked.h"

#define STRIP_BYTES  ((size_t)1 << 18) /* about what one strip holds */
#define CLASSIC_MAX  ((size_t)0xf0000000u)
#define DEFLATE_WORK 6 /* zlib level: part of what makes the bits */

struct ttf_tiff_writer {
    struct tiff_client client;
    struct ttf_tiff_spec spec;
    bool big; /* beyond 4 GB only BigTIFF has offsets enough */
    uint8_t *profile;
    size_t profile_bytes;
    uint32_t height, strip_rows;
    size_t row_bytes;
    enum ttf_sample format;
    uint32_t rows;        /* taken so far */
    uint32_t in_strip;    /* of them in the strip being filled */
    uint32_t strip;       /* index of that strip */
    unsigned char *bytes; /* strip_rows x row_bytes */
};

static bool is_float(enum ttf_sample format)
{
    return format == TTF_SAMPLE_F32 || format == TTF_SAMPLE_F16;
}

static bool set_geometry(TIFF *tiff, const struct ttf_tiff_spec *spec, uint32_t strip_rows)
{
    static const uint16_t unspecified = EXTRASAMPLE_UNSPECIFIED;
    bool colour = spec->samples >= 3;
    uint16_t bits = (uint16_t)(8 * ttf_sample_bytes(spec->format));
    bool ok;

    ok = TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, spec->width) == 1;
    ok &= TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, spec->height) == 1;
    ok &= TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, bits) == 1;
    ok &= TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, spec->samples) == 1;
    ok &= TIFFSetField(tiff, TIFFTAG_SAMPLEFORMAT,
                       is_float(spec->format) ? SAMPLEFORMAT_IEEEFP : SAMPLEFORMAT_UINT) == 1;
    ok &= TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC,
                       colour ? PHOTOMETRIC_RGB : PHOTOMETRIC_MINISBLACK) == 1;
    ok &= TIFFSetField(tiff, TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG) == 1;
    ok &= TIFFSetField(tiff, TIFFTAG_ORIENTATION, ORIENTATION_TOPLEFT) == 1;
    ok &= TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, strip_rows) == 1;
    if (spec->samples == 2 || spec->samples == 4)
        ok &= TIFFSetField(tiff, TIFFTAG_EXTRASAMPLES, 1, &unspecified) == 1;
    return ok;
}

static bool set_compression(TIFF *tiff, const struct ttf_tiff_spec *spec)
{
    bool ok;

    if (spec->compression == TTF_TIFF_NONE)
        return TIFFSetField(tiff, TIFFTAG_COMPRESSION, COMPRESSION_NONE) == 1;
    ok = TIFFSetField(tiff, TIFFTAG_COMPRESSION, COMPRESSION_ADOBE_DEFLATE) == 1;
    ok &= TIFFSetField(tiff, TIFFTAG_ZIPQUALITY, DEFLATE_WORK) == 1;
    ok &=
        TIFFSetField(tiff, TIFFTAG_PREDICTOR,
                     is_float(spec->format) ? PREDICTOR_FLOATINGPOINT : PREDICTOR_HORIZONTAL) == 1;
    return ok;
}

static int set_tags(struct ttf_tiff_writer *writer, struct ttf_err *err)
{
    struct tiff_client *client = &writer->client;
    const struct ttf_tiff_spec *spec = &writer->spec;
    uint64_t exif = 0;
    int r = tiff_write_exif(client, &spec->times, 0, &exif, err);

    if (r < 0)
        return r;
    if (!set_geometry(client->tiff, spec, writer->strip_rows) ||
        !set_compression(client->tiff, spec) ||
        !tiff_set_text(client->tiff, TIFFTAG_SOFTWARE, spec->software) ||
        !tiff_set_text(client->tiff, TIFFTAG_IMAGEDESCRIPTION, spec->description) ||
        !tiff_set_date_time(client->tiff, &spec->times) ||
        (exif && TIFFSetField(client->tiff, TIFFTAG_EXIFIFD, exif) != 1))
        return tiff_client_fail(client, err, -EINVAL, "setting a TIFF file's tags");
    if (writer->profile && TIFFSetField(client->tiff, TIFFTAG_ICCPROFILE,
                                        (uint32_t)writer->profile_bytes, writer->profile) != 1)
        return tiff_client_fail(client, err, -ENOMEM, "setting the colour profile");
    return tiff_client_done(client, err, "setting a TIFF file's tags");
}

/* Of one row and of the whole image; false if the geometry cannot be. */
static bool sizes_of(const struct ttf_tiff_spec *spec, size_t *ret_row, size_t *ret_all)
{
    if (spec->width == 0 || spec->height == 0 || spec->width > 1u << 20 ||
        spec->height > 1u << 20 || spec->samples < 1 || spec->samples > 4)
        return false;
    if ((unsigned)spec->format >= TTF_SAMPLE_COUNT)
        return false;
    *ret_row = (size_t)spec->width * spec->samples * ttf_sample_bytes(spec->format);
    return ttf_mul_size(*ret_row, spec->height, ret_all);
}

int ttf_tiff_writer_create(const struct ttf_tiff_spec *spec, struct ttf_tiff_writer **ret,
                           struct ttf_err *err)
{
    struct ttf_tiff_writer *writer;
    size_t row_bytes, bytes;
    int r;

    if (!sizes_of(spec, &row_bytes, &bytes)) {
        ttf_err_set(err, -EINVAL, NULL, "no TIFF image can be %u x %u x %u %s", spec->width,
                    spec->height, spec->samples, ttf_sample_name(spec->format));
        return -EINVAL;
    }
    writer = calloc(1, sizeof(*writer));
    if (!writer) {
        ttf_err_set(err, -ENOMEM, NULL, "no memory for a TIFF writer");
        return -ENOMEM;
    }
    writer->spec = *spec;
    writer->big = bytes > CLASSIC_MAX;
    writer->height = spec->height;
    writer->row_bytes = row_bytes;
    writer->format = spec->format;
    writer->strip_rows = row_bytes < STRIP_BYTES ? (uint32_t)(STRIP_BYTES / row_bytes) : 1;
    if (writer->strip_rows > spec->height)
        writer->strip_rows = spec->height;
    writer->bytes = malloc(writer->strip_rows * row_bytes);
    if (!writer->bytes) {
        r = -ENOMEM;
        ttf_err_set(err, r, NULL, "no memory for a strip of %zu bytes",
                    writer->strip_rows * row_bytes);
        goto err_free;
    }
    r = ttf_icc_create(spec->icc, spec->samples, &writer->profile, &writer->profile_bytes, err);
    if (r < 0)
        goto err_free;
    *ret = writer;
    return 0;

err_free:
    ttf_tiff_writer_abandon(writer);
    return r;
}

int ttf_tiff_writer_begin(struct ttf_tiff_writer *writer, const struct ttf_tiff_times *times,
                          struct ttf_io *io, int file, struct ttf_err *err)
{
    int r;

    writer->spec.times = *times;
    writer->rows = writer->in_strip = writer->strip = 0;
    r = tiff_client_attach(&writer->client, io, file, writer->big ? "w8l" : "wl", err);
    if (r == 0)
        r = set_tags(writer, err);
    if (r == 0 && writer->spec.compression == TTF_TIFF_NONE)
        r = tiff_client_pixels(&writer->client, (int64_t)(writer->row_bytes * writer->height), err);
    if (r < 0)
        ttf_tiff_writer_drop(writer);
    return r;
}

int ttf_tiff_writer_open(struct ttf_io *io, int file, const struct ttf_tiff_spec *spec,
                         struct ttf_tiff_writer **ret, struct ttf_err *err)
{
    struct ttf_tiff_writer *writer = NULL;
    int r = ttf_tiff_writer_create(spec, &writer, err);

    if (r < 0)
        return r;
    r = ttf_tiff_writer_begin(writer, &spec->times, io, file, err);
    if (r < 0) {
        ttf_tiff_writer_abandon(writer);
        return r;
    }
    *ret = writer;
    return 0;
}

static int write_strip(struct ttf_tiff_writer *writer, struct ttf_err *err)
{
    tmsize_t n = (tmsize_t)(writer->in_strip * writer->row_bytes);

    errno = 0;
    if (TIFFWriteEncodedStrip(writer->client.tiff, writer->strip, writer->bytes, n) != n)
        return tiff_client_fail(&writer->client, err, -EIO, "writing a TIFF strip");
    writer->strip++;
    writer->in_strip = 0;
    return 0;
}

/* Rows come as they lie in memory: halves are floats there. */
static void take_row(struct ttf_tiff_writer *writer, const void *row)
{
    unsigned char *to = writer->bytes + writer->in_strip * writer->row_bytes;
    const float *values = row;
    uint16_t half;

    if (writer->format != TTF_SAMPLE_F16) {
        memcpy(to, row, writer->row_bytes);
        return;
    }
    for (size_t i = 0; i < writer->row_bytes / sizeof(half); i++) {
        half = ttf_half_of_float(values[i]);
        memcpy(to + i * sizeof(half), &half, sizeof(half));
    }
}

int ttf_tiff_writer_rows(struct ttf_tiff_writer *writer, const void *rows, size_t stride,
                         uint32_t n, struct ttf_err *err)
{
    if (n > writer->height - writer->rows)
        return ttf_err_set(err, -EINVAL, NULL, "more rows than the image's height of %u",
                           writer->height);
    for (uint32_t y = 0; y < n; y++) {
        int r = 0;

        take_row(writer, (const char *)rows + (size_t)y * stride);
        writer->in_strip++;
        writer->rows++;
        if (writer->in_strip == writer->strip_rows || writer->rows == writer->height)
            r = write_strip(writer, err);
        if (r < 0)
            return r;
    }
    return 0;
}

int ttf_tiff_writer_end(struct ttf_tiff_writer *writer, struct ttf_err *err)
{
    int r = 0;

    errno = 0;
    if (writer->rows != writer->height)
        r = ttf_err_set(err, -EINVAL, NULL, "an image of %u rows was given %u", writer->height,
                        writer->rows);
    else if (!TIFFFlush(writer->client.tiff))
        r = tiff_client_fail(&writer->client, err, -EIO, "completing a TIFF file");
    if (r == 0 && tiff_client_close(&writer->client) < 0)
        r = tiff_client_fail(&writer->client, err, -EIO, "completing a TIFF file");
    if (r == 0)
        r = tiff_client_done(&writer->client, err, "completing a TIFF file");
    ttf_tiff_writer_drop(writer);
    return r;
}

int ttf_tiff_writer_close(struct ttf_tiff_writer *writer, struct ttf_err *err)
{
    int r = ttf_tiff_writer_end(writer, err);

    ttf_tiff_writer_abandon(writer);
    return r;
}

void ttf_tiff_writer_drop(struct ttf_tiff_writer *writer)
{
    tiff_client_drop(&writer->client);
}

void ttf_tiff_writer_abandon(struct ttf_tiff_writer *writer)
{
    if (!writer)
        return;
    tiff_client_drop(&writer->client);
    free(writer->profile);
    free(writer->bytes);
    free(writer);
}

int ttf_tiff_write(struct ttf_io *io, int file, const struct ttf_pixbuf *pixels,
                   const struct ttf_tiff_spec *spec, struct ttf_err *err)
{
    struct ttf_tiff_spec own = *spec;
    struct ttf_tiff_writer *writer = NULL;
    int r;

    own.width = pixels->width;
    own.height = pixels->height;
    own.samples = pixels->samples;
    own.format = pixels->format;
    r = ttf_tiff_writer_open(io, file, &own, &writer, err);
    if (r < 0)
        return r;
    r = ttf_tiff_writer_rows(writer, pixels->data, pixels->stride, pixels->height, err);
    if (r < 0) {
        ttf_tiff_writer_abandon(writer);
        return r;
    }
    return ttf_tiff_writer_close(writer, err);
}
