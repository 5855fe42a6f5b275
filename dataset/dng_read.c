/* SPDX-License-Identifier: Apache-2.0 */
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "dng_private.h"

#define LINEAR_RAW     34892
#define SUB_IMAGES_MAX 32

/* ---- which of the file's images is the mosaic ---- */

/* Pixels of the current directory if it is a full-resolution mosaic, else 0. */
static uint64_t mosaic_pixels(TIFF *tiff)
{
    uint32_t kind = 0, width = 0, height = 0;
    uint16_t photometric = 0, samples = 1;

    TIFFGetFieldDefaulted(tiff, TIFFTAG_SUBFILETYPE, &kind);
    TIFFGetField(tiff, TIFFTAG_PHOTOMETRIC, &photometric);
    TIFFGetFieldDefaulted(tiff, TIFFTAG_SAMPLESPERPIXEL, &samples);
    TIFFGetField(tiff, TIFFTAG_IMAGEWIDTH, &width);
    TIFFGetField(tiff, TIFFTAG_IMAGELENGTH, &height);
    if (kind != 0 || samples != 1 || width > 65535 || height > 65535 ||
        (photometric != PHOTOMETRIC_CFA && photometric != LINEAR_RAW))
        return 0;
    return (uint64_t)width * height;
}

/* Leaves the mosaic's directory current: the first one, or one below it. */
static int find_mosaic(struct tiff_client *client, struct ttf_err *err)
{
    TIFF *tiff = client->tiff;
    uint64_t best = mosaic_pixels(tiff), best_offset = 0, offsets[SUB_IMAGES_MAX];
    const uint64_t *listed = NULL;
    uint16_t n = 0;

    if (TIFFGetField(tiff, TIFFTAG_SUBIFD, &n, &listed) != 1 || !listed)
        n = 0;
    if (n > SUB_IMAGES_MAX)
        n = SUB_IMAGES_MAX;
    if (n > 0)
        memcpy(offsets, listed,
               n * sizeof(offsets[0])); /* what libtiff handed out goes with the directory */
    for (uint16_t i = 0; i < n; i++) {
        uint64_t pixels;

        if (TIFFSetSubDirectory(tiff, offsets[i]) != 1)
            continue;
        pixels = mosaic_pixels(tiff);
        if (pixels > best) {
            best = pixels;
            best_offset = offsets[i];
        }
    }
    if (best == 0)
        return ttf_err_set(err, -ENOTSUP, client->where,
                           "the file holds no raw mosaic that is read here");
    if (n > 0 &&
        (best_offset ? TIFFSetSubDirectory(tiff, best_offset) : TIFFSetDirectory(tiff, 0)) != 1)
        return tiff_client_fail(client, err, -TTF_EDAMAGED, "going to the mosaic");
    return 0;
}

/* ---- its tags ---- */

static int read_mosaic(TIFF *tiff, struct dng_image *image)
{
    static const uint8_t patterns[TTF_CFA_COUNT][4] = {
        {0}, {0, 1, 1, 2}, {1, 0, 2, 1}, {1, 2, 0, 1}, {2, 1, 1, 0}};
    const uint16_t *size = NULL;
    const uint8_t *pattern = NULL;
    uint16_t photometric = 0, n = 0;

    TIFFGetField(tiff, TIFFTAG_PHOTOMETRIC, &photometric);
    if (photometric != PHOTOMETRIC_CFA)
        return 0;
    if (TIFFGetField(tiff, TIFFTAG_CFAREPEATPATTERNDIM, &size) != 1 || !size || size[0] != 2 ||
        size[1] != 2 || TIFFGetField(tiff, TIFFTAG_CFAPATTERN, &n, &pattern) != 1 || !pattern ||
        n != 4)
        return -ENOTSUP;
    for (int i = TTF_CFA_RGGB; i < TTF_CFA_COUNT; i++) {
        if (memcmp(pattern, patterns[i], 4) == 0)
            image->cfa = (enum ttf_cfa)i;
    }
    return image->cfa == TTF_CFA_NONE ? -ENOTSUP : 0;
}

static void read_active_area(TIFF *tiff, struct dng_image *image)
{
    const uint32_t *area = NULL; /* top, left, bottom, right */

    image->right = image->width;
    image->bottom = image->height;
    if (TIFFGetField(tiff, TIFFTAG_ACTIVEAREA, &area) != 1 || !area)
        return;
    if (area[0] < area[2] && area[1] < area[3] && area[2] <= image->height &&
        area[3] <= image->width) {
        image->top = area[0];
        image->left = area[1];
        image->bottom = area[2];
        image->right = area[3];
    }
}

static void read_levels(TIFF *tiff, struct dng_image *image)
{
    const uint16_t *size = NULL;
    const float *black = NULL;
    const uint32_t *white = NULL;
    uint16_t n = 0;

    image->black_rows = image->black_columns = 1;
    if (TIFFGetField(tiff, TIFFTAG_BLACKLEVELREPEATDIM, &size) == 1 && size && size[0] >= 1 &&
        size[0] <= 8 && size[1] >= 1 && size[1] <= 8) {
        image->black_rows = size[0];
        image->black_columns = size[1];
    }
    if (TIFFGetField(tiff, TIFFTAG_BLACKLEVEL, &n, &black) == 1 && black &&
        n == image->black_rows * image->black_columns) {
        for (uint16_t i = 0; i < n; i++)
            image->black[i] = black[i] >= 0.0f && black[i] <= 65535.0f ? black[i] : 0.0f;
    }
    image->white = (1u << image->bits) - 1;
    if (TIFFGetField(tiff, TIFFTAG_WHITELEVEL, &n, &white) == 1 && white && n >= 1 &&
        white[0] >= 1 && white[0] <= 65535)
        image->white = white[0];
}

static int read_image(struct tiff_client *client, struct dng_image *image, struct ttf_err *err)
{
    TIFF *tiff = client->tiff;
    uint16_t bits = 0, n = 0, format = SAMPLEFORMAT_UINT;

    memset(image, 0, sizeof(*image));
    TIFFGetField(tiff, TIFFTAG_IMAGEWIDTH, &image->width);
    TIFFGetField(tiff, TIFFTAG_IMAGELENGTH, &image->height);
    TIFFGetFieldDefaulted(tiff, TIFFTAG_BITSPERSAMPLE, &bits);
    TIFFGetFieldDefaulted(tiff, TIFFTAG_SAMPLEFORMAT, &format);
    TIFFGetFieldDefaulted(tiff, TIFFTAG_COMPRESSION, &image->compression);
    image->bits = bits;
    if (bits < 8 || bits > 16 || format != SAMPLEFORMAT_UINT ||
        (image->compression != COMPRESSION_NONE && image->compression != COMPRESSION_JPEG))
        return ttf_err_set(err, -ENOTSUP, client->where,
                           "a mosaic of %u bits with compression %u is not read", bits,
                           image->compression);
    if (read_mosaic(tiff, image) < 0)
        return ttf_err_set(err, -ENOTSUP, client->where, "only Bayer mosaics are read");
    image->tiled = TIFFIsTiled(tiff) != 0;
    if (image->tiled) {
        TIFFGetField(tiff, TIFFTAG_TILEWIDTH, &image->chunk_width);
        TIFFGetField(tiff, TIFFTAG_TILELENGTH, &image->chunk_height);
    } else {
        image->chunk_width = image->width;
        TIFFGetFieldDefaulted(tiff, TIFFTAG_ROWSPERSTRIP, &image->chunk_height);
        if (image->chunk_height > image->height)
            image->chunk_height = image->height;
    }
    /* A header alone must not make us reserve memory: even lossless JPEG spends a bit per pixel. */
    if (image->chunk_width == 0 || image->chunk_height == 0 || image->chunk_width > 65535 ||
        image->chunk_height > 65535 ||
        (uint64_t)image->width * image->height / 8 > (uint64_t)client->size)
        return tiff_client_fail(client, err, -TTF_EDAMAGED, "reading a mosaic's sizes");
    read_active_area(tiff, image);
    read_levels(tiff, image);
    if (TIFFGetField(tiff, TIFFTAG_LINEARIZATIONTABLE, &n, &image->table) == 1 && image->table &&
        n > 0)
        image->table_n = n;
    else
        image->table = NULL;
    return 0;
}

/* ---- what is known of the file as a whole, in its first directory ---- */

static void copy_text(TIFF *tiff, uint32_t tag, char *ret, size_t size)
{
    const char *text = NULL;

    if (TIFFGetField(tiff, tag, &text) == 1 && text && text[0])
        snprintf(ret, size, "%s", text);
}

static void read_colour(TIFF *tiff, struct ttf_dng_info *info)
{
    const float *values = NULL;
    uint16_t n = 0;

    if (TIFFGetField(tiff, TIFFTAG_ASSHOTNEUTRAL, &n, &values) == 1 && values && n == 3) {
        for (int i = 0; i < 3; i++)
            info->neutral[i] = isfinite(values[i]) ? (double)values[i] : 0.0;
    }
    /* Of two, the second is the one for daylight. */
    if ((TIFFGetField(tiff, TIFFTAG_COLORMATRIX2, &n, &values) == 1 ||
         TIFFGetField(tiff, TIFFTAG_COLORMATRIX1, &n, &values) == 1) &&
        values && n == 9) {
        for (int i = 0; i < 9; i++)
            info->colour_matrix[i] = isfinite(values[i]) ? (double)values[i] : 0.0;
    }
}

static void read_info(TIFF *tiff, struct ttf_dng_info *info, struct ttf_exposure *settings)
{
    char description[DNG_DESCRIPTION_SIZE] = "";
    bool zone_known;
    char *mark;

    memset(info, 0, sizeof(*info));
    tiff_read_times(tiff, &info->times, &zone_known);
    copy_text(tiff, TIFFTAG_MODEL, info->model, sizeof(info->model));
    copy_text(tiff, TIFFTAG_UNIQUECAMERAMODEL, info->model, sizeof(info->model));
    copy_text(tiff, TIFFTAG_CAMERASERIALNUMBER, info->serial, sizeof(info->serial));
    copy_text(tiff, TIFFTAG_SOFTWARE, info->software, sizeof(info->software));
    copy_text(tiff, TIFFTAG_IMAGEDESCRIPTION, description, sizeof(description));
    read_colour(tiff, info);
    info->simulated = strncmp(description, DNG_SIMULATED, strlen(DNG_SIMULATED)) == 0;
    mark = strstr(info->model, " " DNG_SIMULATED);
    if (info->simulated && mark)
        *mark = '\0';
    *settings = (struct ttf_exposure){.exposure_ns = info->times.exposure_ns};
    if (dng_parse_description(description, settings) && settings->exposure_ns > 0)
        info->times.exposure_ns = settings->exposure_ns; /* exact, the tag is not */
}

/* ---- all together ---- */

/* Mean of the black pattern, rounded; codes are then moved so that it holds for all positions. */
static uint16_t mean_black(const struct dng_image *image)
{
    unsigned n = image->black_rows * image->black_columns;
    double sum = 0.0;

    for (unsigned i = 0; i < n; i++)
        sum += (double)image->black[i];
    return (uint16_t)(sum / n + 0.5);
}

static void level_black(const struct dng_image *image, uint16_t black, uint32_t *codes)
{
    uint32_t width = image->right - image->left, height = image->bottom - image->top;

    for (uint32_t y = 0; y < height; y++) {
        for (uint32_t x = 0; x < width; x++) {
            float own = image->black[(y % image->black_rows) * image->black_columns +
                                     x % image->black_columns];
            int32_t shift = (int32_t)black - (int32_t)(own + 0.5f);
            int32_t code = (int32_t)codes[(size_t)y * width + x] + shift;

            if (shift != 0)
                codes[(size_t)y * width + x] = code > 0 ? (uint32_t)code : 0;
        }
    }
}

static int make_sum(const struct dng_image *image, struct ttf_raw_sum *ret, const char *path,
                    struct ttf_err *err)
{
    struct ttf_frame_format format = {.width = image->right - image->left,
                                      .height = image->bottom - image->top,
                                      .packing = TTF_PACKING_RAW16,
                                      .cfa = image->cfa,
                                      .bits = 16,
                                      .black_level = mean_black(image),
                                      .white_level = (uint16_t)image->white};
    int r;

    format.stride = (size_t)format.width * 2;
    while (format.bits > 1 && image->white < 1u << (format.bits - 1))
        format.bits--;
    if (format.white_level <= format.black_level) {
        ttf_err_set(err, -TTF_EDAMAGED, path, "white level %u is not above black level %u",
                    format.white_level, format.black_level);
        return -TTF_EDAMAGED;
    }
    r = ttf_raw_sum_init(ret, &format);
    if (r < 0)
        ttf_err_set(err, r, path, "no memory for a mosaic of %u x %u", format.width, format.height);
    return r;
}

int ttf_dng_read(struct ttf_io *io, const char *path, struct ttf_raw_sum *ret,
                 struct ttf_dng_info *ret_info, struct ttf_err *err)
{
    struct tiff_client client;
    struct ttf_raw_sum sum = {0};
    struct ttf_exposure settings;
    struct ttf_dng_info info;
    struct dng_image image;
    int r = tiff_client_open(&client, io, path, err);

    if (r < 0)
        return r;
    read_info(client.tiff, &info, &settings);
    r = find_mosaic(&client, err);
    if (r == 0)
        r = read_image(&client, &image, err);
    if (r == 0)
        r = make_sum(&image, &sum, path, err);
    if (r == 0)
        r = dng_read_codes(&client, &image, sum.sum, err);
    if (r == 0)
        r = tiff_client_done(&client, err, "reading a DNG file");
    if (r == 0) {
        level_black(&image, sum.format.black_level, sum.sum);
        sum.n = 1;
        sum.settings = settings;
        *ret = sum;
        if (ret_info)
            *ret_info = info;
    } else {
        ttf_raw_sum_free(&sum);
    }
    tiff_client_drop(&client);
    return r;
}
