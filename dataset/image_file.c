/* SPDX-License-Identifier: Apache-2.0 */
#include "ttf/dataset/image_file.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "image_file_codecs.h"

#define FILE_MAX ((size_t)1 << 30) /* bytes of a PNG or JPEG, which are read whole */

int image_check_size(uint64_t width, uint64_t height, const char *path, struct ttf_err *err)
{
    if (width == 0 || height == 0)
        return ttf_err_set(err, -TTF_EDAMAGED, path, "the picture has no pixels");
    if (width > TTF_IMAGE_PIXELS_MAX / height)
        return ttf_err_set(err, -EFBIG, path, "a picture of %llu x %llu pixels is too large",
                           (unsigned long long)width, (unsigned long long)height);
    return 0;
}

int image_find_kind(struct ttf_io *io, const char *path, enum ttf_image_kind *ret,
                    struct ttf_err *err)
{
    static const char png[8] = {'\x89', 'P', 'N', 'G', '\r', '\n', '\x1a', '\n'};
    int file = io->ops->open(io, path, TTF_IO_READ);
    char head[8] = {0};
    int64_t n;

    if (file < 0)
        return ttf_err_set(err, file, path, "cannot be opened: %s", strerrordesc_np(-file));
    n = ttf_io_pread_all(io, file, head, sizeof(head), 0);
    io->ops->close(io, file);
    if (n < 0)
        return ttf_err_set(err, (int)n, path, "cannot be read: %s", strerrordesc_np(-(int)n));
    if (n == 8 && memcmp(head, png, 8) == 0)
        *ret = TTF_IMAGE_PNG;
    else if (n >= 3 && memcmp(head, "\xff\xd8\xff", 3) == 0)
        *ret = TTF_IMAGE_JPEG;
    else if (n == 8 && (memcmp(head, "II*\0", 4) == 0 || memcmp(head, "MM\0*", 4) == 0 ||
                        memcmp(head, "II+\0", 4) == 0 || memcmp(head, "MM\0+", 4) == 0))
        *ret = TTF_IMAGE_TIFF;
    else
        return ttf_err_set(err, -ENOTSUP, path,
                           n == 0 ? "the file is empty" : "this is no PNG, JPEG or TIFF picture");
    return 0;
}

static bool is_foreign(const struct ttf_tiff_reader *reader, const struct ttf_tiff_info *tiff)
{
    size_t n;
    const void *profile = ttf_tiff_reader_profile(reader, &n);
    bool grey = tiff->samples == 1;

    if (!profile)
        return false;
    return tiff->display_encoded ? !image_profile_is_srgb(profile, n, grey)
                                 : !image_profile_is_linear_srgb(profile, n, grey);
}

void image_info_of_tiff(const struct ttf_tiff_reader *reader, struct ttf_image_info *info)
{
    const struct ttf_tiff_info *tiff = ttf_tiff_reader_info(reader);

    info->kind = TTF_IMAGE_TIFF;
    info->width = tiff->width;
    info->height = tiff->height;
    info->samples = tiff->samples;
    info->format = tiff->format;
    info->bits = tiff->format == TTF_SAMPLE_U8 ? 8 : tiff->bits > 16 ? 16 : tiff->bits;
    info->pages = tiff->pages;
    info->transfer = tiff->display_encoded && tiff->format != TTF_SAMPLE_F32 ? TTF_TRANSFER_SRGB
                                                                             : TTF_TRANSFER_LINEAR;
    info->foreign_profile = is_foreign(reader, tiff);
    info->alpha_left_out = tiff->alpha_left_out;
    info->taken_utc_ns = tiff->times.start_utc_ns;
    info->zone_known = tiff->zone_known;
    info->zone_offset_s = tiff->zone_known ? tiff->times.zone_offset_s : 0;
    info->orientation = tiff->orientation >= 1 && tiff->orientation <= 8 ? tiff->orientation : 1;
}

static int read_tiff(struct ttf_io *io, const char *path, unsigned page, struct ttf_pixbuf *ret,
                     struct ttf_image_info *info, struct ttf_err *err)
{
    struct ttf_tiff_reader *reader;
    struct ttf_pixbuf pixels;
    const struct ttf_tiff_info *tiff;
    int code = ttf_tiff_reader_open(io, path, &reader, err);

    if (code)
        return code;
    tiff = ttf_tiff_reader_info(reader);
    if (page >= tiff->pages) {
        code = ttf_err_set(err, -EINVAL, path, "there is no page %u: the file has %u", page,
                           tiff->pages);
        goto out;
    }
    if (page > 0) {
        code = ttf_tiff_reader_page(reader, page, err);
        if (code)
            goto out;
    }
    image_info_of_tiff(reader, info);
    code = image_check_size(info->width, info->height, path, err);
    if (code || !ret)
        goto out;
    code = ttf_pixbuf_alloc(&pixels, info->width, info->height, info->samples, info->format);
    if (code) {
        code =
            ttf_err_set(err, code, path, "no memory for %u x %u pixels", info->width, info->height);
        goto out;
    }
    code = ttf_tiff_reader_rows(reader, 0, pixels.height, pixels.data, pixels.stride, err);
    if (code)
        ttf_pixbuf_free(&pixels);
    else
        *ret = pixels;
out:
    ttf_tiff_reader_close(reader);
    return code;
}

static int read_any(struct ttf_io *io, const char *path, unsigned page, struct ttf_pixbuf *ret,
                    struct ttf_image_info *info, struct ttf_err *err)
{
    struct ttf_err slurp_err = {0};
    char *data;
    size_t n;
    int code;

    *info = (struct ttf_image_info){.pages = 1, .orientation = 1, .taken_utc_ns = TTF_NS_UNKNOWN};
    code = image_find_kind(io, path, &info->kind, err);
    if (code)
        return code;
    if (info->kind == TTF_IMAGE_TIFF)
        return read_tiff(io, path, page, ret, info, err);
    if (page > 0)
        return ttf_err_set(err, -EINVAL, path, "there is no page %u: the file has 1", page);
    code = ttf_io_slurp(io, path, FILE_MAX, &data, &n, &slurp_err);
    if (code) {
        if (err)
            *err = slurp_err;
        return code;
    }
    if (info->kind == TTF_IMAGE_PNG)
        code = png_decode((const uint8_t *)data, n, path, ret, info, err);
    else
        code = jpeg_decode((const uint8_t *)data, n, path, ret, info, err);
    free(data);
    return code;
}

int ttf_image_read(struct ttf_io *io, const char *path, unsigned page, struct ttf_pixbuf *ret,
                   struct ttf_image_info *ret_info, struct ttf_err *err)
{
    struct ttf_image_info info = {0};
    struct ttf_pixbuf pixels = {0};
    int code = read_any(io, path, page, &pixels, &info, err);

    if (code)
        return code;
    code = image_upright(&pixels, info.orientation);
    if (code) {
        ttf_pixbuf_free(&pixels);
        return ttf_err_set(err, code, path, "no memory to turn the picture upright");
    }
    info.width = pixels.width;
    info.height = pixels.height;
    *ret = pixels;
    if (ret_info)
        *ret_info = info;
    return 0;
}

int ttf_image_probe(struct ttf_io *io, const char *path, struct ttf_image_info *ret,
                    struct ttf_err *err)
{
    struct ttf_image_info info = {0};
    int code = read_any(io, path, 0, NULL, &info, err);

    if (code)
        return code;
    if (info.orientation >= 5) {
        uint32_t width = info.width;

        info.width = info.height;
        info.height = width;
    }
    *ret = info;
    return 0;
}

int ttf_image_read_linear(struct ttf_io *io, const char *path, struct ttf_pixbuf *ret,
                          struct ttf_image_info *ret_info, struct ttf_err *err)
{
    struct ttf_image_info info = {0};
    struct ttf_pixbuf pixels = {0};
    int code = ttf_image_read(io, path, 0, &pixels, &info, err);

    if (code)
        return code;
    code = ttf_image_linear(&pixels, &info, TTF_TRANSFER_AUTO, NULL, 3, ret);
    ttf_pixbuf_free(&pixels);
    if (code)
        return ttf_err_set(err, code, path, "no memory for %u x %u pixels", info.width,
                           info.height);
    if (ret_info)
        *ret_info = info;
    return 0;
}

/* Where pixel (x, y) of the upright picture lies in the stored one (EXIF 2.32, 4.6.4, tag Orientation). */
static void stored_place(unsigned orientation, uint32_t width, uint32_t height, uint32_t x,
                         uint32_t y, uint32_t *ret_x, uint32_t *ret_y)
{
    bool swapped = orientation >= 5;
    uint32_t sx = swapped ? y : x, sy = swapped ? x : y;
    bool flip_x = orientation == 2 || orientation == 3 || orientation == 7 || orientation == 8;
    bool flip_y = orientation == 3 || orientation == 4 || orientation == 6 || orientation == 7;

    *ret_x = flip_x ? width - 1 - sx : sx;
    *ret_y = flip_y ? height - 1 - sy : sy;
}

int image_upright(struct ttf_pixbuf *pixels, unsigned orientation)
{
    bool swapped = orientation >= 5;
    size_t bytes = pixels->samples * ttf_sample_bytes(pixels->format);
    struct ttf_pixbuf turned;
    int code;

    if (orientation <= 1 || orientation > 8)
        return 0;
    code =
        ttf_pixbuf_alloc(&turned, swapped ? pixels->height : pixels->width,
                         swapped ? pixels->width : pixels->height, pixels->samples, pixels->format);
    if (code)
        return code;
    for (uint32_t y = 0; y < turned.height; y++) {
        char *dst = ttf_pixbuf_row(&turned, y);

        for (uint32_t x = 0; x < turned.width; x++, dst += bytes) {
            uint32_t sx, sy;

            stored_place(orientation, pixels->width, pixels->height, x, y, &sx, &sy);
            memcpy(dst, (char *)ttf_pixbuf_row(pixels, sy) + sx * bytes, bytes);
        }
    }
    ttf_pixbuf_free(pixels);
    *pixels = turned;
    return 0;
}
