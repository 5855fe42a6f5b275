/* SPDX-License-Identifier: Apache-2.0 */
/* The mosaic's codes: strips or tiles, packed bits through libtiff, lossless JPEG through our own decoder. */
#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "dng_private.h"
#include "lossless_jpeg.h"
#include "tiff_unpack.h"
#include "ttf/base/checked.h"

struct chunks {
    struct tiff_client *client;
    const struct dng_image *image;
    uint8_t *packed; /* as decoded by libtiff, or as it lies in the file */
    size_t packed_room;
    uint16_t *codes; /* chunk_width x chunk_height */
    size_t n_codes;
    size_t row_bytes; /* of packed rows */
};

static int read_packed(struct chunks *chunks, uint32_t index, uint32_t rows, struct ttf_err *err)
{
    const struct dng_image *image = chunks->image;
    struct tiff_layout layout = {
        .bits = image->bits, .in_pixel = 1, .kept = 1, .format = TTF_SAMPLE_U16};
    TIFF *tiff = chunks->client->tiff;
    tmsize_t got;

    if (image->tiled)
        got = TIFFReadEncodedTile(tiff, index, chunks->packed, (tmsize_t)chunks->packed_room);
    else
        got = TIFFReadEncodedStrip(tiff, index, chunks->packed, (tmsize_t)chunks->packed_room);
    if (got < (tmsize_t)(rows * chunks->row_bytes))
        return tiff_client_fail(chunks->client, err, -TTF_EDAMAGED, "decoding a mosaic");
    for (uint32_t y = 0; y < rows; y++)
        tiff_unpack_row(&layout, chunks->packed + y * chunks->row_bytes, image->chunk_width,
                        chunks->codes + (size_t)y * image->chunk_width, 1);
    return 0;
}

static int read_jpeg(struct chunks *chunks, uint32_t index, uint32_t rows, struct ttf_err *err)
{
    const struct dng_image *image = chunks->image;
    const struct tiff_client *client = chunks->client;
    struct lossless_jpeg_info info = {0};
    uint64_t bytes = TIFFGetStrileByteCount(client->tiff, index);
    size_t need = (size_t)rows * image->chunk_width;
    tmsize_t got;
    int r;

    if (bytes < 8 || bytes > (uint64_t)client->size)
        return tiff_client_fail(client, err, -TTF_EDAMAGED, "reading a mosaic's strip");
    if (bytes > chunks->packed_room) {
        uint8_t *more = realloc(chunks->packed, (size_t)bytes);

        if (!more)
            return ttf_err_set(err, -ENOMEM, client->where, "no memory for a strip");
        chunks->packed = more;
        chunks->packed_room = (size_t)bytes;
    }
    if (image->tiled)
        got = TIFFReadRawTile(client->tiff, index, chunks->packed, (tmsize_t)bytes);
    else
        got = TIFFReadRawStrip(client->tiff, index, chunks->packed, (tmsize_t)bytes);
    if (got != (tmsize_t)bytes)
        return tiff_client_fail(client, err, -TTF_EDAMAGED, "reading a mosaic's strip");
    r = lossless_jpeg_decode(chunks->packed, (size_t)bytes, chunks->codes, chunks->n_codes, &info);
    if (r == -ENOTSUP)
        return ttf_err_set(err, r, client->where, "this kind of JPEG in a DNG file is not read");
    if (r < 0 || (size_t)info.width * info.height * info.components < need)
        return ttf_err_set(err, -TTF_EDAMAGED, client->where, "a mosaic's lossless JPEG is broken");
    return 0;
}

/* Of a chunk at x0, y0 what lies in the active area, linearized. */
static void place(const struct chunks *chunks, uint32_t x0, uint32_t y0, uint32_t rows,
                  uint32_t *ret)
{
    const struct dng_image *image = chunks->image;
    size_t stride = image->right - image->left;

    for (uint32_t y = 0; y < rows; y++) {
        const uint16_t *row = chunks->codes + (size_t)y * image->chunk_width;

        if (y0 + y < image->top || y0 + y >= image->bottom)
            continue;
        for (uint32_t x = 0; x < image->chunk_width; x++) {
            uint32_t code = row[x];

            if (x0 + x < image->left || x0 + x >= image->right)
                continue;
            if (image->table)
                code = image->table[code < image->table_n ? code : image->table_n - 1];
            ret[(size_t)(y0 + y - image->top) * stride + (x0 + x - image->left)] = code;
        }
    }
}

static int prepare(struct chunks *chunks, struct ttf_err *err)
{
    const struct dng_image *image = chunks->image;
    TIFF *tiff = chunks->client->tiff;
    uint64_t size = image->tiled ? TIFFTileSize64(tiff) : TIFFStripSize64(tiff);
    uint64_t row = image->tiled ? TIFFTileRowSize64(tiff) : TIFFScanlineSize64(tiff);

    if (!ttf_mul_size(image->chunk_width, image->chunk_height, &chunks->n_codes) ||
        chunks->n_codes > TIFF_ALLOC_MAX / 2 || size > TIFF_ALLOC_MAX || size == 0 ||
        row < ((uint64_t)image->chunk_width * image->bits + 7) / 8 ||
        size < row * image->chunk_height) {
        (void)tiff_client_fail(chunks->client, err, -TTF_EDAMAGED, "reading a mosaic's sizes");
        return -TTF_EDAMAGED;
    }
    chunks->row_bytes = (size_t)row;
    chunks->packed_room = image->compression == COMPRESSION_JPEG ? 4096 : (size_t)size;
    chunks->packed = calloc(1, chunks->packed_room);
    chunks->codes = calloc(chunks->n_codes, sizeof(*chunks->codes));
    if (!chunks->packed || !chunks->codes)
        goto err_memory;
    return 0;

err_memory:
    ttf_err_set(err, -ENOMEM, chunks->client->where, "no memory for a strip");
    return -ENOMEM;
}

int dng_read_codes(struct tiff_client *client, const struct dng_image *image, uint32_t *ret,
                   struct ttf_err *err)
{
    struct chunks chunks = {.client = client, .image = image};
    uint32_t index = 0;
    int r = prepare(&chunks, err);

    for (uint32_t y = 0; r == 0 && y < image->height; y += image->chunk_height) {
        uint32_t rows = image->height - y;

        if (rows > image->chunk_height)
            rows = image->chunk_height;
        for (uint32_t x = 0; r == 0 && x < image->width; x += image->chunk_width, index++) {
            if (image->compression == COMPRESSION_JPEG)
                r = read_jpeg(&chunks, index, rows, err);
            else
                r = read_packed(&chunks, index, rows, err);
            if (r == 0)
                place(&chunks, x, y, rows, ret);
        }
    }
    free(chunks.packed);
    free(chunks.codes);
    return r;
}
