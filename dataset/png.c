/* SPDX-License-Identifier: Apache-2.0 */
/* png.c: PNG in and out, by libspng. */
#include <errno.h>
#include <spng.h>
#include <string.h>

#include "image_file_codecs.h"
#include "ttf/dataset/hash.h"

#define CHUNK_MAX ((size_t)16 << 20) /* bytes of one ancillary chunk, and of all of them */

/* zlib's and lcms2's failed allocations are anything else to libspng, or nothing; but malloc leaves ENOMEM. */
static int png_code(int error)
{
    if (errno == ENOMEM)
        return -ENOMEM;
    switch (error) {
    case SPNG_EMEM:
        return -ENOMEM;
    case SPNG_EWIDTH:
    case SPNG_EHEIGHT:
    case SPNG_EUSER_WIDTH:
    case SPNG_EUSER_HEIGHT:
        return -EFBIG;
    default:
        return -TTF_EDAMAGED;
    }
}

static int png_fail(struct ttf_err *err, int error, const char *path)
{
    return ttf_err_set(err, png_code(error), path, "this PNG cannot be read: %s",
                       spng_strerror(error));
}

/* The layout that keeps what is stored: 16 bits stay 16 bits, palettes and 1 to 4 bits become 8. */
static int layout_of(spng_ctx *ctx, const struct spng_ihdr *header, int *ret_flags,
                     struct ttf_image_info *info)
{
    struct spng_trns transparency;

    *ret_flags = 0;
    info->format = header->bit_depth == 16 ? TTF_SAMPLE_U16 : TTF_SAMPLE_U8;
    info->bits = header->bit_depth == 16 ? 16 : 8;
    switch (header->color_type) {
    case SPNG_COLOR_TYPE_GRAYSCALE:
        info->samples = 1;
        return header->bit_depth < 8 ? SPNG_FMT_G8 : SPNG_FMT_PNG;
    case SPNG_COLOR_TYPE_GRAYSCALE_ALPHA:
        info->samples = 2;
        return SPNG_FMT_PNG;
    case SPNG_COLOR_TYPE_TRUECOLOR_ALPHA:
        info->samples = 4;
        return SPNG_FMT_PNG;
    case SPNG_COLOR_TYPE_INDEXED:
        if (spng_get_trns(ctx, &transparency) == 0) {
            info->samples = 4;
            *ret_flags = SPNG_DECODE_TRNS;
            return SPNG_FMT_RGBA8;
        }
        info->samples = 3;
        return SPNG_FMT_RGB8;
    default:
        info->samples = 3;
        return SPNG_FMT_PNG;
    }
}

static uint32_t read_be32(const uint8_t *p)
{
    return (uint32_t)p[0] << 24 | (uint32_t)p[1] << 16 | (uint32_t)p[2] << 8 | p[3];
}

/*
 * An EXIF block may lie behind the pixels as well, where the library finds it only once they are decoded; a file is
 * asked when it was taken without that. What is broken there spoils no pixel, and is left alone.
 */
static void find_exif(const uint8_t *data, size_t n, struct ttf_image_info *info)
{
    size_t at = 8;

    while (n - at >= 12) {
        size_t bytes = read_be32(data + at);

        if (bytes > n - at - 12)
            return;
        if (memcmp(data + at + 4, "eXIf", 4) == 0 &&
            ttf_crc32(0, data + at + 4, bytes + 4) == read_be32(data + at + 8 + bytes))
            exif_read(data + at + 8, bytes, info);
        at += 12 + bytes;
    }
}

static void read_colour(spng_ctx *ctx, struct ttf_image_info *info)
{
    struct spng_iccp profile;
    uint32_t gamma = 0;
    uint8_t intent;

    info->transfer = TTF_TRANSFER_SRGB;
    if (spng_get_iccp(ctx, &profile) == 0)
        info->foreign_profile =
            !image_profile_is_srgb(profile.profile, profile.profile_len, info->samples <= 2);
    if (spng_get_srgb(ctx, &intent) != 0 && spng_get_gama_int(ctx, &gamma) == 0 && gamma == 100000)
        info->transfer = TTF_TRANSFER_LINEAR;
}

static int decode_rows(spng_ctx *ctx, int format, int flags, struct ttf_pixbuf *pixels)
{
    size_t bytes;
    int error = spng_decoded_image_size(ctx, format, &bytes);

    if (error)
        return error;
    /* The pixbuf is tightly packed: rows follow one another as in the decoder. */
    if (bytes != pixels->stride * pixels->height)
        return SPNG_EBUFSIZ;
    return spng_decode_image(ctx, pixels->data, bytes, format, flags);
}

static int decode(spng_ctx *ctx, const uint8_t *data, size_t n, const char *path,
                  struct ttf_pixbuf *ret, struct ttf_image_info *info, struct ttf_err *err)
{
    struct ttf_pixbuf pixels = {0};
    struct spng_ihdr header;
    int error, format, flags, code;

    spng_set_chunk_limits(ctx, CHUNK_MAX, CHUNK_MAX);
    error = spng_set_png_buffer(ctx, data, n);
    if (!error)
        error = spng_get_ihdr(ctx, &header);
    if (error)
        return png_fail(err, error, path);
    code = image_check_size(header.width, header.height, path, err);
    if (code)
        return code;
    /* Reads the chunks before the pixels, so that what follows knows them. */
    error = spng_decode_chunks(ctx);
    if (error)
        return png_fail(err, error, path);
    format = layout_of(ctx, &header, &flags, info);
    info->width = header.width;
    info->height = header.height;
    read_colour(ctx, info);
    find_exif(data, n, info);
    if (!ret)
        return 0;
    code = ttf_pixbuf_alloc(&pixels, header.width, header.height, info->samples, info->format);
    if (code)
        return ttf_err_set(err, code, path, "no memory for %u x %u pixels", header.width,
                           header.height);
    error = decode_rows(ctx, format, flags, &pixels);
    if (error) {
        ttf_pixbuf_free(&pixels);
        return png_fail(err, error, path);
    }
    *ret = pixels;
    return 0;
}

int png_decode(const uint8_t *data, size_t n, const char *path, struct ttf_pixbuf *ret,
               struct ttf_image_info *info, struct ttf_err *err)
{
    spng_ctx *ctx = spng_ctx_new(0);
    struct ttf_pixbuf pixels = {0};
    int code;

    if (!ctx)
        return ttf_err_set(err, -ENOMEM, path, "no memory to read a PNG");
    errno = 0;
    code = decode(ctx, data, n, path, ret ? &pixels : NULL, info, err);
    if (code == 0 && errno == ENOMEM) {
        ttf_pixbuf_free(&pixels);
        code = png_fail(err, SPNG_EMEM, path);
    }
    spng_ctx_free(ctx);
    if (code == 0 && ret)
        *ret = pixels;
    return code;
}

struct png_target {
    struct ttf_io *io;
    int file;
    int64_t offset;
    int error;
};

static int write_piece(spng_ctx *ctx, void *user, void *data, size_t n)
{
    struct png_target *target = user;

    target->error = ttf_io_pwrite_all(target->io, target->file, data, n, target->offset);
    if (target->error)
        return SPNG_IO_ERROR;
    target->offset += (int64_t)n;
    return 0;
}

static int encode(spng_ctx *ctx, struct png_target *target, const struct ttf_pixbuf *pixels,
                  enum ttf_transfer transfer, int level, const char *comment)
{
    static const uint8_t colour_type[5] = {
        0, SPNG_COLOR_TYPE_GRAYSCALE, SPNG_COLOR_TYPE_GRAYSCALE_ALPHA, SPNG_COLOR_TYPE_TRUECOLOR,
        SPNG_COLOR_TYPE_TRUECOLOR_ALPHA};
    struct spng_ihdr header = {.width = pixels->width,
                               .height = pixels->height,
                               .bit_depth = pixels->format == TTF_SAMPLE_U16 ? 16 : 8,
                               .color_type = colour_type[pixels->samples]};
    size_t row = (size_t)pixels->width * pixels->samples * ttf_sample_bytes(pixels->format);
    int error = spng_set_png_stream(ctx, write_piece, target);

    if (!error)
        error = spng_set_option(ctx, SPNG_IMG_COMPRESSION_LEVEL, level);
    if (!error)
        error = spng_set_ihdr(ctx, &header);
    if (!error)
        error = transfer == TTF_TRANSFER_LINEAR ? spng_set_gama_int(ctx, 100000)
                                                : spng_set_srgb(ctx, 0);
    if (!error && comment) {
        /* The library only reads both texts. */
        struct spng_text text = {.text = (char *)comment,
                                 .length = strlen(comment),
                                 .type = SPNG_TEXT,
                                 .keyword = "Comment"};

        error = spng_set_text(ctx, &text, 1);
    }
    if (!error)
        error = spng_encode_image(ctx, NULL, 0, SPNG_FMT_PNG,
                                  SPNG_ENCODE_PROGRESSIVE | SPNG_ENCODE_FINALIZE);
    for (uint32_t y = 0; !error && y < pixels->height; y++)
        error = spng_encode_row(ctx, ttf_pixbuf_row(pixels, y), row);
    return error == SPNG_EOI ? 0 : error;
}

int ttf_png_write(struct ttf_io *io, int file, const struct ttf_pixbuf *pixels,
                  enum ttf_transfer transfer, int level, const char *comment, struct ttf_err *err)
{
    struct png_target target = {.io = io, .file = file};
    spng_ctx *ctx;
    int error;

    if (pixels->samples < 1 || pixels->samples > 4 || level < 0 || level > 9 ||
        (pixels->format != TTF_SAMPLE_U8 && pixels->format != TTF_SAMPLE_U16))
        return ttf_err_set(err, -EINVAL, NULL, "a PNG holds 8 or 16-bit samples, 1 to 4 of them");
    ctx = spng_ctx_new(SPNG_CTX_ENCODER);
    if (!ctx)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory to write a PNG");
    errno = 0;
    error = encode(ctx, &target, pixels, transfer, level, comment);
    spng_ctx_free(ctx);
    if (target.error)
        return ttf_err_set(err, target.error, NULL, "writing a PNG failed: %s",
                           strerrordesc_np(-target.error));
    if (error)
        return ttf_err_set(err, error == SPNG_EMEM || errno == ENOMEM ? -ENOMEM : -EINVAL, NULL,
                           "writing a PNG failed: %s", spng_strerror(error));
    return 0;
}
