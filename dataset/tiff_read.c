/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Reads by bands: a strip, or a row of tiles, is decoded whole and kept, so that
 * rows asked for downwards decode each once. A strip all of which is asked for is
 * decoded where it is wanted, and not kept.
 */
#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "tiff_client.h"
#include "tiff_unpack.h"
#include "ttf/base/checked.h"

#define PAGES_MAX 65535u

struct ttf_tiff_reader {
    struct tiff_client client;
    struct ttf_tiff_info info;

    /* of the current page */
    struct tiff_layout layout;
    bool tiled, planar, palette;
    const uint16_t *tables[3];
    uint32_t tile_width;
    uint32_t band_rows;     /* rows of a strip or of a tile */
    size_t chunk_bytes;     /* of a strip or a tile, decoded */
    size_t chunk_row_bytes; /* of one row in it */
    unsigned char *chunk;   /* one of them; NULL: decoded into the band at once */
    unsigned char *band;    /* band_rows x band_stride, unpacked; NULL: none was held yet */
    size_t band_bytes, band_stride;
    uint32_t band_index; /* UINT32_MAX: none */

    uint32_t *folder; /* in which each page lies; NULL: in that of its number */
};

static int fail(const struct ttf_tiff_reader *reader, struct ttf_err *err, int code,
                const char *doing)
{
    return tiff_client_fail(&reader->client, err, code, doing);
}

static int unsupported(const struct ttf_tiff_reader *reader, struct ttf_err *err, const char *what,
                       unsigned value)
{
    const char *where = reader->client.where[0] ? reader->client.where : NULL;

    return ttf_err_set(err, -ENOTSUP, where, "TIFF images with %s %u are not read", what, value);
}

/* Samples of the pixel without the alpha ones, which come last. */
static unsigned kept_samples(TIFF *tiff, unsigned samples)
{
    uint16_t n = 0;
    const uint16_t *kinds = NULL;

    if (TIFFGetFieldDefaulted(tiff, TIFFTAG_EXTRASAMPLES, &n, &kinds) != 1 || !kinds)
        return samples;
    while (n > 0 && samples > 1 &&
           (kinds[n - 1] == EXTRASAMPLE_ASSOCALPHA || kinds[n - 1] == EXTRASAMPLE_UNASSALPHA)) {
        n--;
        samples--;
    }
    return samples;
}

static int read_layout(struct ttf_tiff_reader *reader, struct ttf_err *err)
{
    TIFF *tiff = reader->client.tiff;
    struct tiff_layout *layout = &reader->layout;
    uint16_t bits = 0, samples = 0, kind = SAMPLEFORMAT_UINT, planar = PLANARCONFIG_CONTIG;

    TIFFGetFieldDefaulted(tiff, TIFFTAG_BITSPERSAMPLE, &bits);
    TIFFGetFieldDefaulted(tiff, TIFFTAG_SAMPLESPERPIXEL, &samples);
    TIFFGetFieldDefaulted(tiff, TIFFTAG_SAMPLEFORMAT, &kind);
    TIFFGetFieldDefaulted(tiff, TIFFTAG_PLANARCONFIG, &planar);
    layout->is_float = kind == SAMPLEFORMAT_IEEEFP;
    if (kind != SAMPLEFORMAT_UINT && kind != SAMPLEFORMAT_VOID && !layout->is_float)
        return unsupported(reader, err, "sample format", kind);
    if (layout->is_float ? bits != 16 && bits != 32 : bits < 1 || (bits > 16 && bits != 32))
        return unsupported(reader, err, "bits per sample", bits);
    if (samples < 1 || samples > 64)
        return unsupported(reader, err, "samples per pixel", samples);
    reader->planar = planar == PLANARCONFIG_SEPARATE && samples > 1;
    layout->bits = bits;
    layout->kept = kept_samples(tiff, samples);
    reader->info.alpha_left_out = layout->kept < samples;
    layout->in_pixel = reader->planar ? 1 : samples;
    layout->spread = bits < 8;
    layout->format = tiff_format_of(bits, layout->is_float);
    if (layout->kept > 4)
        return unsupported(reader, err, "samples per pixel", samples);
    return 0;
}

/*
 * libtiff's faster way to inflate (libdeflate) takes a strip that holds more than is asked for as whole, also a damaged one, and leaves
 * what did not fit into its last piece unwritten (4.5). zlib writes every byte, and finds the damage.
 */
static bool inflate_by_zlib(TIFF *tiff)
{
    return !TIFFFindField(tiff, TIFFTAG_DEFLATE_SUBCODEC, TIFF_ANY) ||
           TIFFSetField(tiff, TIFFTAG_DEFLATE_SUBCODEC, DEFLATE_SUBCODEC_ZLIB) == 1;
}

static int read_photometric(struct ttf_tiff_reader *reader, struct ttf_err *err)
{
    TIFF *tiff = reader->client.tiff;
    uint16_t photometric = PHOTOMETRIC_MINISBLACK, compression = COMPRESSION_NONE;
    uint16_t *r, *g, *b;

    TIFFGetField(tiff, TIFFTAG_PHOTOMETRIC, &photometric);
    TIFFGetFieldDefaulted(tiff, TIFFTAG_COMPRESSION, &compression);
    if (!TIFFIsCODECConfigured(compression) || !inflate_by_zlib(tiff))
        return unsupported(reader, err, "compression", compression);
    switch (photometric) {
    case PHOTOMETRIC_MINISWHITE:
        reader->layout.inverted = true;
        return 0;
    case PHOTOMETRIC_MINISBLACK:
    case PHOTOMETRIC_RGB:
    case PHOTOMETRIC_CFA:
        return 0;
    case PHOTOMETRIC_YCBCR:
        if (compression != COMPRESSION_JPEG || reader->planar)
            return unsupported(reader, err, "YCbCr and compression", compression);
        if (TIFFSetField(tiff, TIFFTAG_JPEGCOLORMODE, JPEGCOLORMODE_RGB) != 1)
            return fail(reader, err, -TTF_EDAMAGED, "reading a JPEG image");
        return 0;
    case PHOTOMETRIC_PALETTE:
        if (reader->layout.bits > 8 || reader->layout.is_float || reader->planar ||
            TIFFGetField(tiff, TIFFTAG_COLORMAP, &r, &g, &b) != 1)
            return unsupported(reader, err, "a palette and bits", reader->layout.bits);
        reader->palette = true;
        reader->tables[0] = r;
        reader->tables[1] = g;
        reader->tables[2] = b;
        return 0;
    default:
        return unsupported(reader, err, "photometric interpretation", photometric);
    }
}

/* Strips that lie as rows are handed out: most files, all of ours. */
static bool is_band_itself(const struct ttf_tiff_reader *reader)
{
    return !reader->tiled && !reader->planar && !reader->palette &&
           tiff_unpack_copies(&reader->layout, reader->info.samples) &&
           reader->chunk_row_bytes == reader->band_stride &&
           reader->chunk_bytes == reader->band_stride * reader->band_rows;
}

/* Strips or tiles: their sizes as libtiff will hand them out, checked against what we make of them. */
static int read_chunks(struct ttf_tiff_reader *reader, struct ttf_err *err)
{
    TIFF *tiff = reader->client.tiff;
    uint32_t rows = 0;
    uint64_t chunk, row, width = reader->info.width;
    size_t band;

    reader->tiled = TIFFIsTiled(tiff) != 0;
    if (reader->tiled) {
        uint32_t tile_width = 0;

        TIFFGetField(tiff, TIFFTAG_TILEWIDTH, &tile_width);
        TIFFGetField(tiff, TIFFTAG_TILELENGTH, &rows);
        reader->tile_width = tile_width;
        width = tile_width;
        chunk = TIFFTileSize64(tiff);
        row = TIFFTileRowSize64(tiff);
    } else {
        TIFFGetFieldDefaulted(tiff, TIFFTAG_ROWSPERSTRIP, &rows);
        if (rows > reader->info.height)
            rows = reader->info.height;
        chunk = TIFFStripSize64(tiff);
        row = TIFFScanlineSize64(tiff);
    }
    if (rows == 0 || width == 0 || width > 1u << 20 || rows > 1u << 20)
        return fail(reader, err, -TTF_EDAMAGED, "reading a TIFF file's strips");
    if (row < (width * reader->layout.in_pixel * reader->layout.bits + 7) / 8 || chunk < row * rows)
        return fail(reader, err, -TTF_EDAMAGED, "reading a TIFF file's strips");
    reader->band_rows = rows;
    reader->chunk_bytes = (size_t)chunk;
    reader->chunk_row_bytes = (size_t)row;
    reader->band_stride =
        (size_t)reader->info.width * reader->info.samples * ttf_sample_bytes(reader->info.format);
    if (chunk > TIFF_ALLOC_MAX || !ttf_mul_size(reader->band_stride, rows, &band) ||
        band > TIFF_ALLOC_MAX)
        return ttf_err_set(err, -EFBIG, reader->client.where,
                           "a strip of %llu bytes is too large to read", (unsigned long long)chunk);
    if (!is_band_itself(reader)) {
        reader->chunk = malloc(reader->chunk_bytes);
        if (!reader->chunk)
            return ttf_err_set(err, -ENOMEM, reader->client.where, "no memory for a strip");
    }
    reader->band_bytes = band;
    return 0;
}

static void read_profile(struct ttf_tiff_reader *reader)
{
    size_t n;
    const void *icc = ttf_tiff_reader_profile(reader, &n);
    int linear = icc ? ttf_icc_is_linear(icc, n) : -1;

    reader->info.has_icc = icc != NULL;
    if (linear >= 0)
        reader->info.display_encoded = linear == 0;
    else
        reader->info.display_encoded = reader->info.format == TTF_SAMPLE_U8;
}

static unsigned read_orientation(TIFF *tiff)
{
    uint16_t orientation = 0;

    TIFFGetFieldDefaulted(tiff, TIFFTAG_ORIENTATION, &orientation);
    return orientation >= 1 && orientation <= 8 ? orientation : 1;
}

static int open_page(struct ttf_tiff_reader *reader, struct ttf_err *err)
{
    TIFF *tiff = reader->client.tiff;
    struct ttf_tiff_info *info = &reader->info;
    unsigned pages = info->pages;
    int r;

    memset(info, 0, sizeof(*info));
    memset(&reader->layout, 0, sizeof(reader->layout));
    reader->palette = false;
    reader->band_index = UINT32_MAX;
    free(reader->chunk);
    free(reader->band);
    reader->chunk = reader->band = NULL;
    info->pages = pages;
    /* First: it goes to another folder of the file and back, which frees what was read of this one. */
    tiff_read_times(tiff, &info->times, &info->zone_known);
    TIFFGetField(tiff, TIFFTAG_IMAGEWIDTH, &info->width);
    TIFFGetField(tiff, TIFFTAG_IMAGELENGTH, &info->height);
    if (info->width == 0 || info->height == 0)
        return fail(reader, err, -TTF_EDAMAGED, "reading a TIFF file's tags");
    if (info->width > 1u << 20 || info->height > 1u << 20)
        return unsupported(reader, err, "a side of",
                           info->width > info->height ? info->width : info->height);
    r = read_layout(reader, err);
    if (r == 0)
        r = read_photometric(reader, err);
    if (r < 0)
        return r;
    info->samples = reader->palette ? 3 : reader->layout.kept;
    info->bits = reader->palette ? 8 : reader->layout.bits;
    info->format = reader->palette ? TTF_SAMPLE_U8 : reader->layout.format;
    info->orientation = read_orientation(tiff);
    r = read_chunks(reader, err);
    if (r < 0)
        return r;
    read_profile(reader);
    return tiff_client_done(&reader->client, err, "reading a TIFF file's tags");
}

/* A page is a picture of its own: no smaller copy of another, as pyramids have, and no mask. */
static bool is_page(TIFF *tiff)
{
    uint32_t kind = 0;

    TIFFGetFieldDefaulted(tiff, TIFFTAG_SUBFILETYPE, &kind);
    return (kind & (FILETYPE_REDUCEDIMAGE | FILETYPE_MASK)) == 0;
}

/* Folders that cannot be read are pages, so that whoever asks for them is told. */
static int find_pages(struct ttf_tiff_reader *reader, struct ttf_err *err)
{
    TIFF *tiff = reader->client.tiff;
    unsigned n = TIFFNumberOfDirectories(tiff), pages = 0;
    bool readable = true;

    if (n == 0)
        return fail(reader, err, -TTF_EDAMAGED, "reading a TIFF file");
    reader->info.pages = n;
    if (n == 1)
        return tiff_client_done(&reader->client, err, "reading a TIFF file");
    reader->folder = calloc(n, sizeof(*reader->folder));
    if (!reader->folder)
        return ttf_err_set(err, -ENOMEM, reader->client.where, "no memory for %u pages", n);
    for (unsigned i = 0; i < n; i++) {
        readable = readable && (i == 0 ? TIFFSetDirectory(tiff, 0) : TIFFReadDirectory(tiff)) == 1;
        if (!readable || is_page(tiff))
            reader->folder[pages++] = i;
    }
    if (pages == 0) { /* no other has more pixels */
        free(reader->folder);
        reader->folder = NULL;
    } else {
        reader->info.pages = pages;
    }
    return tiff_client_done(&reader->client, err, "reading a TIFF file");
}

static int go_to_page(struct ttf_tiff_reader *reader, unsigned page, struct ttf_err *err)
{
    uint32_t folder = reader->folder ? reader->folder[page] : page;

    errno = 0;
    if (TIFFSetDirectory(reader->client.tiff, (tdir_t)folder) != 1)
        return fail(reader, err, -TTF_EDAMAGED, "going to a page of a TIFF file");
    return open_page(reader, err);
}

int ttf_tiff_reader_open(struct ttf_io *io, const char *path, struct ttf_tiff_reader **ret,
                         struct ttf_err *err)
{
    struct ttf_tiff_reader *reader = calloc(1, sizeof(*reader));
    int r;

    if (!reader) {
        ttf_err_set(err, -ENOMEM, path, "no memory for a TIFF reader");
        return -ENOMEM;
    }
    r = tiff_client_open(&reader->client, io, path, err);
    if (r < 0) {
        free(reader);
        return r;
    }
    r = find_pages(reader, err);
    if (r == 0)
        r = go_to_page(reader, 0, err);
    if (r < 0) {
        ttf_tiff_reader_close(reader);
        return r;
    }
    *ret = reader;
    return 0;
}

int ttf_tiff_reader_page(struct ttf_tiff_reader *reader, unsigned page, struct ttf_err *err)
{
    if (page >= reader->info.pages || page >= PAGES_MAX)
        return ttf_err_set(err, -EINVAL, reader->client.where, "there is no page %u of %u", page,
                           reader->info.pages);
    return go_to_page(reader, page, err);
}

const void *ttf_tiff_reader_profile(const struct ttf_tiff_reader *reader, size_t *ret_bytes)
{
    uint32_t n = 0;
    void *icc = NULL;

    if (TIFFGetField(reader->client.tiff, TIFFTAG_ICCPROFILE, &n, &icc) != 1 || n == 0)
        icc = NULL;
    *ret_bytes = icc ? n : 0;
    return icc;
}

const struct ttf_tiff_info *ttf_tiff_reader_info(const struct ttf_tiff_reader *reader)
{
    return &reader->info;
}

/* A decoded chunk of n pixels in each of `rows` rows goes to column x, plane c of the band. */
static void unpack_chunk(struct ttf_tiff_reader *reader, uint32_t x, uint32_t n, uint32_t rows,
                         unsigned plane)
{
    size_t sample = ttf_sample_bytes(reader->info.format);
    size_t at = ((size_t)x * reader->info.samples + plane) * sample;
    struct tiff_layout layout = reader->layout;

    if (reader->planar)
        layout.kept = 1;
    for (uint32_t y = 0; y < rows; y++) {
        const uint8_t *src = reader->chunk + y * reader->chunk_row_bytes;
        unsigned char *dst = reader->band + y * reader->band_stride + at;

        if (reader->palette)
            tiff_unpack_palette(&layout, src, n, reader->tables, dst);
        else
            tiff_unpack_row(&layout, src, n, dst, reader->info.samples);
    }
}

/* Strips that lie as rows are handed out go to `band`, others through the chunk to the reader's own. */
static int decode_strip(struct ttf_tiff_reader *reader, uint32_t index, unsigned plane,
                        uint32_t rows, unsigned char *band, struct ttf_err *err)
{
    TIFF *tiff = reader->client.tiff;
    uint32_t strip = TIFFComputeStrip(tiff, index * reader->band_rows, (uint16_t)plane);
    tmsize_t need = (tmsize_t)(rows * reader->chunk_row_bytes);
    tmsize_t room = reader->chunk ? (tmsize_t)reader->chunk_bytes : need;

    if (TIFFReadEncodedStrip(tiff, strip, reader->chunk ? reader->chunk : band, room) < need)
        return fail(reader, err, -TTF_EDAMAGED, "decoding a strip");
    if (reader->chunk)
        unpack_chunk(reader, 0, reader->info.width, rows, plane);
    return 0;
}

static int decode_tiles(struct ttf_tiff_reader *reader, uint32_t index, unsigned plane,
                        uint32_t rows, struct ttf_err *err)
{
    TIFF *tiff = reader->client.tiff;

    for (uint32_t x = 0; x < reader->info.width; x += reader->tile_width) {
        uint32_t tile = TIFFComputeTile(tiff, x, index * reader->band_rows, 0, (uint16_t)plane);
        uint32_t n = reader->info.width - x;
        tmsize_t got =
            TIFFReadEncodedTile(tiff, tile, reader->chunk, (tmsize_t)reader->chunk_bytes);

        if (got < (tmsize_t)(rows * reader->chunk_row_bytes))
            return fail(reader, err, -TTF_EDAMAGED, "decoding a tile");
        unpack_chunk(reader, x, n < reader->tile_width ? n : reader->tile_width, rows, plane);
    }
    return 0;
}

static uint32_t rows_of_band(const struct ttf_tiff_reader *reader, uint32_t index)
{
    uint32_t rows = reader->info.height - index * reader->band_rows;

    return rows < reader->band_rows ? rows : reader->band_rows;
}

static int decode_band(struct ttf_tiff_reader *reader, uint32_t index, unsigned char *band,
                       struct ttf_err *err)
{
    uint32_t rows = rows_of_band(reader, index);
    unsigned planes = reader->planar ? reader->layout.kept : 1;
    int r = 0;

    tiff_decode_begin(&reader->client);
    for (unsigned plane = 0; plane < planes && r == 0; plane++)
        r = reader->tiled ? decode_tiles(reader, index, plane, rows, err)
                          : decode_strip(reader, index, plane, rows, band, err);
    if (r < 0) {
        reader->client.decoding = false;
        return r;
    }
    return tiff_decode_end(&reader->client, err, "decoding an image");
}

/* Into the reader's own band, of which rows may be asked for again. */
static int hold_band(struct ttf_tiff_reader *reader, uint32_t index, struct ttf_err *err)
{
    int r;

    if (!reader->band)
        reader->band = malloc(reader->band_bytes);
    if (!reader->band)
        return ttf_err_set(err, -ENOMEM, reader->client.where, "no memory for a strip");
    reader->band_index = UINT32_MAX;
    r = decode_band(reader, index, reader->band, err);
    if (r == 0)
        reader->band_index = index;
    return r;
}

/* Is all of the band at row y asked for, and in the form that it is decoded in? Then it need not be held and copied. */
static bool goes_straight(const struct ttf_tiff_reader *reader, uint32_t y, uint32_t n,
                          size_t stride)
{
    uint32_t index = y / reader->band_rows;

    return !reader->chunk && stride == reader->band_stride && y % reader->band_rows == 0 &&
           n >= rows_of_band(reader, index) && index != reader->band_index;
}

int ttf_tiff_reader_rows(struct ttf_tiff_reader *reader, uint32_t y0, uint32_t n, void *dst,
                         size_t stride, struct ttf_err *err)
{
    if (y0 > reader->info.height || n > reader->info.height - y0)
        return ttf_err_set(err, -EINVAL, reader->client.where, "rows %u and on are outside", y0);
    for (uint32_t y = 0, done; y < n; y += done) {
        uint32_t index = (y0 + y) / reader->band_rows;
        unsigned char *to = (unsigned char *)dst + (size_t)y * stride;
        int r = 0;

        if (goes_straight(reader, y0 + y, n - y, stride)) {
            done = rows_of_band(reader, index);
            r = decode_band(reader, index, to, err);
        } else {
            done = 1;
            if (index != reader->band_index)
                r = hold_band(reader, index, err);
            if (r == 0)
                memcpy(to,
                       reader->band + (size_t)((y0 + y) % reader->band_rows) * reader->band_stride,
                       reader->band_stride);
        }
        if (r < 0)
            return r;
    }
    return 0;
}

void ttf_tiff_reader_close(struct ttf_tiff_reader *reader)
{
    if (!reader)
        return;
    tiff_client_drop(&reader->client);
    free(reader->chunk);
    free(reader->band);
    free(reader->folder);
    free(reader);
}

int ttf_tiff_read(struct ttf_io *io, const char *path, unsigned page, struct ttf_pixbuf *ret,
                  struct ttf_err *err)
{
    struct ttf_tiff_reader *reader = NULL;
    struct ttf_pixbuf buf = {0};
    const struct ttf_tiff_info *info;
    int r = ttf_tiff_reader_open(io, path, &reader, err);

    if (r < 0)
        return r;
    if (page > 0)
        r = ttf_tiff_reader_page(reader, page, err);
    if (r < 0)
        goto out;
    info = ttf_tiff_reader_info(reader);
    r = ttf_pixbuf_alloc(&buf, info->width, info->height, info->samples, info->format);
    if (r < 0) {
        ttf_err_set(err, r, path, "no memory for an image of %u x %u", info->width, info->height);
        goto out;
    }
    r = ttf_tiff_reader_rows(reader, 0, info->height, buf.data, buf.stride, err);
    if (r == 0) {
        *ret = buf;
        buf.owned = false;
    }
out:
    ttf_pixbuf_free(&buf);
    ttf_tiff_reader_close(reader);
    return r;
}
