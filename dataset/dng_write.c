/* SPDX-License-Identifier: Apache-2.0 */
#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "dng_private.h"

#define STRIP_BYTES ((size_t)1 << 18)

#define LINEAR_RAW     34892 /* PhotometricInterpretation of a sensor without a mosaic */
#define ILLUMINANT_D65 21

/* XYZ to linear sRGB (IEC 61966-2-1), the inverse of its primaries under D65. */
static const double xyz_to_srgb[9] = {3.2406255, -1.5372080, -0.4986286, -0.9689307, 1.8757561,
                                      0.0415175, 0.0557101,  -0.2040211, 1.0569959};

void dng_describe(const struct ttf_raw_sum *raw, bool simulated, char ret[DNG_DESCRIPTION_SIZE])
{
    const struct ttf_exposure *s = &raw->settings;

    snprintf(ret, DNG_DESCRIPTION_SIZE,
             "%sttfbox frame: exposure %" PRId64 " ns, gain %" PRIu32
             "/1000, white balance %" PRIu32 "/1000 %" PRIu32 "/1000, lens %" PRIu32
             " mdpt, mean of %u",
             simulated ? DNG_SIMULATED " " : "", s->exposure_ns, s->gain_milli, s->wb_r_milli,
             s->wb_b_milli, s->lens_mdpt, raw->n);
}

bool dng_parse_description(const char *text, struct ttf_exposure *ret)
{
    const char *at = strstr(text, "ttfbox frame: ");
    struct ttf_exposure s = {0};
    int n = 0;

    /* NOLINTBEGIN(cert-err34-c): each number is bounded by its width */
    if (at)
        n = sscanf(at,
                   "ttfbox frame: exposure %18" SCNd64 " ns, gain %9" SCNu32
                   "/1000, white balance %9" SCNu32 "/1000 %9" SCNu32 "/1000, lens %9" SCNu32,
                   &s.exposure_ns, &s.gain_milli, &s.wb_r_milli, &s.wb_b_milli, &s.lens_mdpt);
    /* NOLINTEND(cert-err34-c) */
    if (n != 5)
        return false;
    if (s.exposure_ns < 0)
        return false;
    *ret = s;
    return true;
}

/* Places that codes move up: 0 for a single frame, else as many as full scale leaves. */
static unsigned shift_of(const struct ttf_raw_sum *raw, uint16_t white)
{
    unsigned shift = 0;

    while (raw->n > 1 && (uint32_t)white << (shift + 1) <= 65535)
        shift++;
    return shift;
}

static bool set_mosaic(TIFF *tiff, enum ttf_cfa cfa)
{
    static const uint8_t patterns[TTF_CFA_COUNT][4] = {
        {0}, {0, 1, 1, 2}, {1, 0, 2, 1}, {1, 2, 0, 1}, {2, 1, 1, 0}};
    static const uint8_t planes[3] = {0, 1, 2};
    static const uint16_t size[2] = {2, 2};
    bool ok;

    if (cfa == TTF_CFA_NONE)
        return TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, LINEAR_RAW) == 1;
    ok = TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_CFA) == 1;
    ok &= TIFFSetField(tiff, TIFFTAG_CFAREPEATPATTERNDIM, size) == 1;
    ok &= TIFFSetField(tiff, TIFFTAG_CFAPATTERN, 4, patterns[cfa]) == 1;
    ok &= TIFFSetField(tiff, TIFFTAG_CFAPLANECOLOR, 3, planes) == 1;
    ok &= TIFFSetField(tiff, TIFFTAG_CFALAYOUT, 1) == 1;
    return ok;
}

static bool set_geometry(TIFF *tiff, const struct ttf_raw_sum *raw, uint32_t strip_rows)
{
    bool ok = TIFFSetField(tiff, TIFFTAG_SUBFILETYPE, 0) == 1;

    ok &= TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, raw->format.width) == 1;
    ok &= TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, raw->format.height) == 1;
    ok &= TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, 16) == 1;
    ok &= TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, 1) == 1;
    ok &= TIFFSetField(tiff, TIFFTAG_SAMPLEFORMAT, SAMPLEFORMAT_UINT) == 1;
    ok &= TIFFSetField(tiff, TIFFTAG_COMPRESSION, COMPRESSION_NONE) == 1;
    ok &= TIFFSetField(tiff, TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG) == 1;
    ok &= TIFFSetField(tiff, TIFFTAG_ORIENTATION, ORIENTATION_TOPLEFT) == 1;
    ok &= TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, strip_rows) == 1;
    ok &= set_mosaic(tiff, raw->format.cfa);
    return ok;
}

/* Levels and colour. */
static bool set_calibration(TIFF *tiff, const struct ttf_raw_sum *raw,
                            const struct ttf_dng_info *info, uint16_t black, uint16_t white)
{
    unsigned shift = shift_of(raw, white);
    float black_level = (float)((uint32_t)black << shift), matrix[9], neutral[3];
    uint32_t white_level = (uint32_t)white << shift;
    bool has_matrix = false, ok;

    for (int i = 0; i < 9; i++)
        has_matrix = has_matrix || info->colour_matrix[i] != 0.0;
    for (int i = 0; i < 9; i++)
        matrix[i] = (float)(has_matrix ? info->colour_matrix[i] : xyz_to_srgb[i]);
    for (int i = 0; i < 3; i++)
        neutral[i] = info->neutral[i] > 0.0 ? (float)info->neutral[i] : 1.0f;
    ok = TIFFSetField(tiff, TIFFTAG_BLACKLEVEL, 1, &black_level) == 1;
    ok &= TIFFSetField(tiff, TIFFTAG_WHITELEVEL, 1, &white_level) == 1;
    if (raw->format.cfa == TTF_CFA_NONE) /* of one colour: nothing to say */
        return ok;
    ok &= TIFFSetField(tiff, TIFFTAG_COLORMATRIX1, 9, matrix) == 1;
    ok &= TIFFSetField(tiff, TIFFTAG_CALIBRATIONILLUMINANT1, ILLUMINANT_D65) == 1;
    ok &= TIFFSetField(tiff, TIFFTAG_ASSHOTNEUTRAL, 3, neutral) == 1;
    return ok;
}

static bool set_names(TIFF *tiff, const struct ttf_raw_sum *raw, const struct ttf_dng_info *info)
{
    static const uint8_t version[4] = {1, 4, 0, 0}, oldest_reader[4] = {1, 1, 0, 0};
    char model[sizeof(info->model) + 16], description[DNG_DESCRIPTION_SIZE];
    /* The simulated camera's own name says it already. */
    bool say = info->simulated && !strstr(info->model, DNG_SIMULATED), ok;

    snprintf(model, sizeof(model), "%s%s", info->model[0] ? info->model : "camera",
             say ? " " DNG_SIMULATED : "");
    dng_describe(raw, info->simulated, description);
    ok = TIFFSetField(tiff, TIFFTAG_DNGVERSION, version) == 1;
    ok &= TIFFSetField(tiff, TIFFTAG_DNGBACKWARDVERSION, oldest_reader) == 1;
    ok &= tiff_set_text(tiff, TIFFTAG_MAKE, "ttfbox");
    ok &= tiff_set_text(tiff, TIFFTAG_MODEL, model);
    ok &= tiff_set_text(tiff, TIFFTAG_UNIQUECAMERAMODEL, model);
    ok &= tiff_set_text(tiff, TIFFTAG_CAMERASERIALNUMBER, info->serial);
    ok &= tiff_set_text(tiff, TIFFTAG_SOFTWARE, info->software);
    ok &= tiff_set_text(tiff, TIFFTAG_IMAGEDESCRIPTION, description);
    ok &= tiff_set_date_time(tiff, &info->times);
    return ok;
}

static int set_tags(struct tiff_client *client, const struct ttf_raw_sum *raw,
                    const struct ttf_dng_info *info, uint32_t strip_rows, struct ttf_err *err)
{
    struct ttf_tiff_times times = info->times;
    uint16_t black, white;
    uint64_t exif = 0;
    bool ok;
    int r;

    if (times.exposure_ns == 0)
        times.exposure_ns = raw->settings.exposure_ns;
    r = tiff_write_exif(client, &times, raw->settings.gain_milli / 10, &exif, err);
    if (r < 0)
        return r;
    ttf_raw_sum_levels(&raw->format, &black, &white);
    ok = set_geometry(client->tiff, raw, strip_rows);
    ok &= set_calibration(client->tiff, raw, info, black, white);
    ok &= set_names(client->tiff, raw, info);
    if (exif)
        ok &= TIFFSetField(client->tiff, TIFFTAG_EXIFIFD, exif) == 1;
    if (!ok)
        return tiff_client_fail(client, err, -EINVAL, "setting a DNG file's tags");
    return 0;
}

static int write_strips(struct tiff_client *client, const struct ttf_raw_sum *raw,
                        uint32_t strip_rows, uint16_t *codes, struct ttf_err *err)
{
    size_t width = raw->format.width;
    uint16_t black, white;
    unsigned shift;
    int r = 0;

    ttf_raw_sum_levels(&raw->format, &black, &white);
    shift = shift_of(raw, white);
    for (uint32_t y0 = 0; r == 0 && y0 < raw->format.height; y0 += strip_rows) {
        uint32_t rows = raw->format.height - y0 < strip_rows ? raw->format.height - y0 : strip_rows;
        const uint32_t *sum = raw->sum + y0 * width;
        tmsize_t n = (tmsize_t)(rows * width * 2);

        for (size_t i = 0; i < rows * width; i++) {
            uint64_t code = (((uint64_t)sum[i] << shift) + raw->n / 2) / raw->n;

            codes[i] = (uint16_t)(code > 65535 ? 65535 : code);
        }
        if (TIFFWriteEncodedStrip(client->tiff, y0 / strip_rows, codes, n) != n)
            r = tiff_client_fail(client, err, -EIO, "writing a DNG strip");
    }
    return r;
}

/* Of a file of that format; a row at least, whatever its width. */
static uint32_t strip_rows_of(const struct ttf_frame_format *format)
{
    size_t rows = format->width ? STRIP_BYTES / ((size_t)format->width * 2) : 1;

    if (rows > format->height)
        rows = format->height;
    return rows > 0 ? (uint32_t)rows : 1;
}

size_t ttf_dng_scratch_bytes(const struct ttf_frame_format *format)
{
    return ((size_t)format->width + 1) * strip_rows_of(format) * sizeof(uint16_t);
}

int ttf_dng_write(const struct ttf_raw_sum *raw, const struct ttf_dng_info *info, struct ttf_io *io,
                  int file, struct ttf_err *err)
{
    void *scratch = malloc(ttf_dng_scratch_bytes(&raw->format));
    int r = scratch ? ttf_dng_write_in(raw, info, scratch, io, file, err)
                    : ttf_err_set(err, -ENOMEM, NULL, "no memory for a strip");

    free(scratch);
    return r;
}

int ttf_dng_write_in(const struct ttf_raw_sum *raw, const struct ttf_dng_info *info, void *scratch,
                     struct ttf_io *io, int file, struct ttf_err *err)
{
    uint32_t strip_rows = strip_rows_of(&raw->format);
    struct tiff_client client;
    int r;

    if (raw->n == 0)
        return ttf_err_set(err, -EINVAL, NULL, "there is no frame to write");
    if (raw->samples != 1)
        return ttf_err_set(err, -ENOTSUP, NULL,
                           "finished RGB pictures are not written as DNG: keep them developed");
    r = tiff_client_attach(&client, io, file, "wl", err);
    if (r < 0)
        return r;
    r = set_tags(&client, raw, info, strip_rows, err);
    if (r == 0)
        r = tiff_client_pixels(&client, (int64_t)raw->format.width * raw->format.height * 2, err);
    if (r == 0)
        r = write_strips(&client, raw, strip_rows, scratch, err);
    if (r == 0 && !TIFFFlush(client.tiff))
        r = tiff_client_fail(&client, err, -EIO, "completing a DNG file");
    if (r < 0) {
        tiff_client_drop(&client);
        return r;
    }
    if (tiff_client_close(&client) < 0)
        return tiff_client_fail(&client, err, -EIO, "completing a DNG file");
    return tiff_client_done(&client, err, "completing a DNG file");
}
