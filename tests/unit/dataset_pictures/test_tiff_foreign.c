/* SPDX-License-Identifier: Apache-2.0 */
/* TIFF files as other programs write them, made here with libtiff itself; and broken ones. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <tiffio.h>

#include "scratch.h"
#include "ttf/dataset/dng.h"
#include "ttf/dataset/image_file.h"
#include "ttf/dataset/tiff.h"

#define W 75
#define H 50

struct foreign {
    const char *name, *mode;
    unsigned bits, samples, kind, compression, photometric, planar, tile, strip_rows, extra;
};

static const struct foreign all[] = {
    {"tiles-lzw", "w", 16, 3, 1, COMPRESSION_LZW, PHOTOMETRIC_RGB, 1, 32, 0, 0},
    {"big-endian", "wb", 16, 3, 1, COMPRESSION_NONE, PHOTOMETRIC_RGB, 1, 0, 7, 0},
    {"bigtiff", "w8", 16, 1, 1, COMPRESSION_NONE, PHOTOMETRIC_MINISBLACK, 1, 0, 50, 0},
    {"planes", "w", 8, 3, 1, COMPRESSION_ADOBE_DEFLATE, PHOTOMETRIC_RGB, 2, 0, 9, 0},
    {"plane-tiles", "w", 16, 3, 1, COMPRESSION_NONE, PHOTOMETRIC_RGB, 2, 16, 0, 0},
    {"alpha", "w", 8, 4, 1, COMPRESSION_PACKBITS, PHOTOMETRIC_RGB, 1, 0, 20,
     EXTRASAMPLE_UNASSALPHA},
    {"grey-alpha", "w", 16, 2, 1, COMPRESSION_LZW, PHOTOMETRIC_MINISBLACK, 1, 0, 20,
     EXTRASAMPLE_ASSOCALPHA},
    {"white-is-zero", "w", 8, 1, 1, COMPRESSION_NONE, PHOTOMETRIC_MINISWHITE, 1, 0, 50, 0},
    {"bilevel", "w", 1, 1, 1, COMPRESSION_CCITTFAX4, PHOTOMETRIC_MINISBLACK, 1, 0, 50, 0},
    {"four-bits", "w", 4, 1, 1, COMPRESSION_NONE, PHOTOMETRIC_MINISBLACK, 1, 0, 50, 0},
    {"twelve-bits", "w", 12, 1, 1, COMPRESSION_NONE, PHOTOMETRIC_MINISBLACK, 1, 0, 11, 0},
    {"fourteen-bits", "wb", 14, 3, 1, COMPRESSION_NONE, PHOTOMETRIC_RGB, 1, 0, 11, 0},
    {"thirty-two-bits", "w", 32, 1, 1, COMPRESSION_LZW, PHOTOMETRIC_MINISBLACK, 1, 0, 50, 0},
    {"float", "wb", 32, 3, 3, COMPRESSION_LZW, PHOTOMETRIC_RGB, 1, 0, 50, 0},
    {"half", "w", 16, 1, 3, COMPRESSION_NONE, PHOTOMETRIC_MINISBLACK, 1, 0, 50, 0},
    {"palette", "w", 8, 1, 1, COMPRESSION_LZW, PHOTOMETRIC_PALETTE, 1, 0, 50, 0},
};

/* The code that sample c of pixel x, y has in the file. */
static uint32_t code_at(const struct foreign *f, unsigned x, unsigned y, unsigned c)
{
    uint32_t mix = x * 2654435761u + y * 40503u + c * 977u;

    mix ^= mix >> 15;
    return f->bits == 32 ? mix : mix & ((1u << f->bits) - 1);
}

static float float_of(unsigned x, unsigned y, unsigned c)
{
    return (float)(int)(x + 10 * y + c) * 0.25f - 8.0f; /* exact as half as well */
}

static uint16_t half_of(float value)
{
    uint32_t bits, exponent;

    memcpy(&bits, &value, sizeof(bits));
    exponent = bits >> 23 & 255;
    if (exponent == 0)
        return (uint16_t)(bits >> 16 & 0x8000);
    return (uint16_t)((bits >> 16 & 0x8000) | (exponent - 112) << 10 | (bits >> 13 & 1023));
}

static void put(uint8_t *row, const struct foreign *f, size_t i, uint32_t code, float value)
{
    if (f->kind == 3 && f->bits == 32) {
        memcpy(row + 4 * i, &value, 4);
    } else if (f->kind == 3 || f->bits == 16) {
        uint16_t word = f->kind == 3 ? half_of(value) : (uint16_t)code;

        memcpy(row + 2 * i, &word, 2);
    } else if (f->bits == 32) {
        memcpy(row + 4 * i, &code, 4);
    } else {
        for (unsigned b = 0; b < f->bits; b++) {
            size_t at = i * f->bits + b;

            if (code >> (f->bits - 1 - b) & 1)
                row[at / 8] |= (uint8_t)(128 >> at % 8);
        }
    }
}

/* One plane (all samples if contiguous) of rows y.. and columns x.. as the file packs them. */
static void pack(const struct foreign *f, unsigned x0, unsigned y0, unsigned w, unsigned h,
                 unsigned plane, uint8_t *ret, size_t row_bytes)
{
    unsigned k = f->planar == 2 ? 1 : f->samples;

    memset(ret, 0, row_bytes * h);
    for (unsigned y = 0; y < h; y++) {
        for (unsigned x = 0; x < w; x++) {
            for (unsigned c = 0; c < k; c++)
                put(ret + y * row_bytes, f, x * k + c, code_at(f, x0 + x, y0 + y, plane + c),
                    float_of(x0 + x, y0 + y, plane + c));
        }
    }
}

static void set_tags(TIFF *tiff, const struct foreign *f)
{
    TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, W);
    TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, H);
    TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, f->bits);
    TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, f->samples);
    TIFFSetField(tiff, TIFFTAG_SAMPLEFORMAT, f->kind);
    TIFFSetField(tiff, TIFFTAG_COMPRESSION, f->compression);
    TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, f->photometric);
    TIFFSetField(tiff, TIFFTAG_PLANARCONFIG, f->planar);
    TIFFSetField(tiff, TIFFTAG_ORIENTATION, ORIENTATION_RIGHTTOP);
    if (f->extra) {
        uint16_t extra = (uint16_t)f->extra;

        TIFFSetField(tiff, TIFFTAG_EXTRASAMPLES, 1, &extra);
    }
    if (f->photometric == PHOTOMETRIC_PALETTE) {
        uint16_t map[3][256];

        for (unsigned i = 0; i < 256; i++) {
            map[0][i] = (uint16_t)(i * 257);
            map[1][i] = (uint16_t)((255 - i) * 257);
            map[2][i] = (uint16_t)((i ^ 85) * 257);
        }
        TIFFSetField(tiff, TIFFTAG_COLORMAP, map[0], map[1], map[2]);
    }
    if (f->tile) {
        TIFFSetField(tiff, TIFFTAG_TILEWIDTH, f->tile);
        TIFFSetField(tiff, TIFFTAG_TILELENGTH, f->tile);
    } else {
        TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, f->strip_rows);
    }
}

static void write_page(TIFF *tiff, const struct foreign *f)
{
    unsigned planes = f->planar == 2 ? f->samples : 1;
    uint8_t *buf = calloc(1, 1 << 20);

    assert_non_null(buf);
    set_tags(tiff, f);
    for (unsigned plane = 0; plane < planes; plane++) {
        if (f->tile) {
            for (unsigned y = 0; y < H; y += f->tile) {
                for (unsigned x = 0; x < W; x += f->tile) {
                    pack(f, x, y, f->tile, f->tile, plane, buf, (size_t)TIFFTileRowSize(tiff));
                    assert_true(TIFFWriteTile(tiff, buf, x, y, 0, (uint16_t)plane) > 0);
                }
            }
            continue;
        }
        for (unsigned y = 0; y < H; y++) {
            pack(f, 0, y, W, 1, plane, buf, (size_t)TIFFScanlineSize(tiff));
            assert_int_equal(TIFFWriteScanline(tiff, buf, y, (uint16_t)plane), 1);
        }
    }
    free(buf);
}

static void write_foreign(void **state, const struct foreign *f, unsigned pages)
{
    TIFF *tiff = TIFFOpen(scratch_path(state, f->name), f->mode);

    assert_non_null(tiff);
    for (unsigned i = 0; i < pages; i++) {
        write_page(tiff, f);
        assert_int_equal(TIFFWriteDirectory(tiff), 1);
    }
    TIFFClose(tiff);
}

/* What our reader must hand out for that sample. */
static double expected(const struct foreign *f, unsigned x, unsigned y, unsigned c)
{
    uint32_t code = code_at(f, x, y, c);

    if (f->kind == 3)
        return (double)float_of(x, y, c);
    if (f->photometric == PHOTOMETRIC_PALETTE)
        code = code_at(f, x, y, 0);
    if (f->photometric == PHOTOMETRIC_PALETTE)
        return c == 0 ? code : c == 1 ? 255 - code : code ^ 85;
    if (f->photometric == PHOTOMETRIC_MINISWHITE)
        return 255 - code;
    if (f->bits < 8)
        return (double)(unsigned)(code * 255 / ((1u << f->bits) - 1));
    return f->bits == 32 ? code >> 16 : code;
}

static double sample(const struct ttf_pixbuf *buf, unsigned x, unsigned y, unsigned c)
{
    const void *row = ttf_pixbuf_row(buf, y);
    size_t i = (size_t)x * buf->samples + c;

    if (buf->format == TTF_SAMPLE_U8)
        return ((const uint8_t *)row)[i];
    if (buf->format == TTF_SAMPLE_U16)
        return ((const uint16_t *)row)[i];
    return (double)((const float *)row)[i];
}

static void assert_page(const struct foreign *f, const struct ttf_pixbuf *buf)
{
    unsigned samples = f->photometric == PHOTOMETRIC_PALETTE ? 3
                       : f->extra                            ? f->samples - 1
                                                             : f->samples;

    assert_int_equal(buf->samples, samples);
    for (unsigned y = 0; y < buf->height; y++) {
        for (unsigned x = 0; x < W; x++) {
            for (unsigned c = 0; c < samples; c++) {
                if (sample(buf, x, y, c) != expected(f, x, y, c))
                    fail_msg("%s at %u, %u, %u: %g is not %g", f->name, x, y, c,
                             sample(buf, x, y, c), expected(f, x, y, c));
            }
        }
    }
}

static void every_common_layout_is_read(void **state)
{
    for (unsigned i = 0; i < TTF_COUNT_OF(all); i++) {
        struct ttf_err err = {0};
        struct ttf_pixbuf buf;

        write_foreign(state, &all[i], 1);
        if (ttf_tiff_read(ttf_io_posix(), scratch_path(state, all[i].name), 0, &buf, &err) < 0)
            fail_msg("%s: %s", all[i].name, err.what);
        assert_int_equal(buf.width, W);
        assert_int_equal(buf.height, H);
        assert_page(&all[i], &buf);
        ttf_pixbuf_free(&buf);
    }
}

static void pages_and_rows_are_read_in_any_order(void **state)
{
    struct ttf_tiff_reader *reader = NULL;
    const struct ttf_tiff_info *info;
    struct ttf_err err = {0};
    struct ttf_pixbuf buf;
    uint16_t row[W * 3];

    write_foreign(state, &all[0], 5);
    assert_int_equal(
        ttf_tiff_reader_open(ttf_io_posix(), scratch_path(state, all[0].name), &reader, NULL), 0);
    info = ttf_tiff_reader_info(reader);
    assert_int_equal(info->pages, 5);
    assert_int_equal(info->orientation, 6);
    assert_false(info->display_encoded);
    assert_int_equal(info->times.start_utc_ns, TTF_NS_UNKNOWN);
    for (unsigned page = 5; page-- > 0;) {
        assert_int_equal(ttf_tiff_reader_page(reader, page, NULL), 0);
        for (unsigned i = 0; i < H; i++) {
            unsigned y = i * 31 % H;

            assert_int_equal(ttf_tiff_reader_rows(reader, y, 1, row, 0, NULL), 0);
            for (unsigned x = 0; x < W * 3; x++)
                assert_int_equal(row[x], code_at(&all[0], x / 3, y, x % 3));
        }
    }
    assert_int_equal(ttf_tiff_reader_rows(reader, H, 1, row, 0, NULL), -EINVAL);
    assert_int_equal(ttf_tiff_reader_rows(reader, 1, UINT32_MAX, row, 0, NULL), -EINVAL);
    assert_int_equal(ttf_tiff_reader_page(reader, 5, NULL), -EINVAL);
    ttf_tiff_reader_close(reader);
    assert_int_equal(ttf_tiff_read(ttf_io_posix(), scratch_path(state, all[0].name), 4, &buf, NULL),
                     0);
    assert_page(&all[0], &buf);
    ttf_pixbuf_free(&buf);
    assert_int_equal(
        ttf_image_read(ttf_io_posix(), scratch_path(state, all[0].name), 3, &buf, NULL, &err), 0);
    assert_true(buf.width == H && buf.height == W); /* turned upright */
    ttf_pixbuf_free(&buf);
    assert_int_equal(
        ttf_image_read(ttf_io_posix(), scratch_path(state, all[0].name), 5, &buf, NULL, &err),
        -EINVAL);
    assert_non_null(strstr(err.what, "there is no page 5: the file has 5"));
}

/* Whole strips go straight to where they are asked for, parts and other strides by way of the reader's own. */
static void rows_are_the_same_however_many_are_asked_for(void **state)
{
    enum {
        PAD = 3
    };
    static uint16_t rows[H * (W + PAD) * 3];

    for (unsigned i = 0; i < TTF_COUNT_OF(all); i++) {
        const struct foreign *f = &all[i];
        struct ttf_tiff_reader *reader = NULL;
        struct ttf_pixbuf whole = {0};
        const char *path = scratch_path(state, f->name);
        size_t row;

        write_foreign(state, f, 1);
        assert_int_equal(ttf_tiff_read(ttf_io_posix(), path, 0, &whole, NULL), 0);
        row = (size_t)W * whole.samples * ttf_sample_bytes(whole.format);
        assert_int_equal(ttf_tiff_reader_open(ttf_io_posix(), path, &reader, NULL), 0);
        for (unsigned k = 0; row <= (size_t)W * 6 && k < H * H * 2; k++) {
            uint32_t y0 = k * 7 % H, n = k / H % H + 1;
            size_t stride = row + (k % 2 ? PAD : 0);

            n = n < H - y0 ? n : H - y0;
            memset(rows, 0xa5, sizeof(rows));
            assert_int_equal(ttf_tiff_reader_rows(reader, y0, n, rows, stride, NULL), 0);
            for (uint32_t y = 0; y < n; y++) {
                if (memcmp((char *)rows + y * stride,
                           (char *)whole.data + (size_t)(y0 + y) * whole.stride, row) != 0)
                    fail_msg("%s: row %u of %u from %u on", f->name, y, n, y0);
            }
            assert_int_equal(((unsigned char *)rows)[(n - 1) * stride + row], 0xa5);
        }
        ttf_tiff_reader_close(reader);
        ttf_pixbuf_free(&whole);
    }
}

static void a_jpeg_inside_comes_out_as_rgb(void **state)
{
    TIFF *tiff = TIFFOpen(scratch_path(state, "j.tif"), "w");
    struct ttf_err err = {0};
    struct ttf_pixbuf buf;
    uint8_t row[64 * 3];

    assert_non_null(tiff);
    TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, 64);
    TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, 64);
    TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, 8);
    TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, 3);
    TIFFSetField(tiff, TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG);
    TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_YCBCR);
    TIFFSetField(tiff, TIFFTAG_COMPRESSION, COMPRESSION_JPEG);
    TIFFSetField(tiff, TIFFTAG_JPEGCOLORMODE, JPEGCOLORMODE_RGB);
    TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, 16);
    for (unsigned y = 0; y < 64; y++) {
        for (unsigned x = 0; x < 64; x++) {
            row[3 * x] = 200;
            row[3 * x + 1] = 60;
            row[3 * x + 2] = 20;
        }
        assert_int_equal(TIFFWriteScanline(tiff, row, y, 0), 1);
    }
    TIFFClose(tiff);
    if (ttf_tiff_read(ttf_io_posix(), scratch_path(state, "j.tif"), 0, &buf, &err) < 0)
        fail_msg("%s", err.what);
    for (unsigned i = 0; i < 64 * 64; i++) {
        assert_in_range(((uint8_t *)buf.data)[3 * i], 197, 203);
        assert_in_range(((uint8_t *)buf.data)[3 * i + 1], 57, 63);
        assert_in_range(((uint8_t *)buf.data)[3 * i + 2], 17, 23);
    }
    ttf_pixbuf_free(&buf);
}

/* ---- nothing in a file is trusted ---- */

static void read_whatever(const char *path)
{
    struct ttf_tiff_reader *reader = NULL;
    struct ttf_err err = {0};
    struct ttf_raw_sum raw;

    if (ttf_tiff_reader_open(ttf_io_posix(), path, &reader, &err) == 0) {
        const struct ttf_tiff_info *info = ttf_tiff_reader_info(reader);
        unsigned pages = info->pages;

        for (unsigned p = 0; p < pages && p < 3; p++) {
            size_t stride = (size_t)info->width * info->samples * ttf_sample_bytes(info->format);
            void *row = malloc(stride); /* not a byte more than promised */

            assert_non_null(row);
            for (uint32_t y = 0; y < info->height && y < 60; y++) {
                if (ttf_tiff_reader_rows(reader, y, 1, row, stride, &err) < 0)
                    break;
            }
            free(row);
            if (p + 1 < pages && ttf_tiff_reader_page(reader, p + 1, &err) < 0)
                break;
        }
        ttf_tiff_reader_close(reader);
    } else {
        assert_true(err.code < 0 && err.what[0]);
    }
    if (ttf_dng_read(ttf_io_posix(), path, &raw, NULL, &err) == 0)
        ttf_raw_sum_free(&raw);
}

static void break_it(void **state, const uint8_t *bytes, size_t n, unsigned rounds, uint32_t seed)
{
    uint8_t *copy = malloc(n);

    assert_non_null(copy);
    for (unsigned i = 0; i < rounds; i++) {
        size_t length = i % 3 == 0 ? scratch_random(&seed) % n : n;

        memcpy(copy, bytes, n);
        for (unsigned k = 0; i % 3 != 0 && k <= i % 5; k++) {
            /* Tags stand at the end or the beginning: mostly there. */
            uint32_t where = scratch_random(&seed) % 600;
            size_t at = i % 2 ? where % n : n - 1 - where % n;

            copy[i % 7 == 0 ? scratch_random(&seed) % n : at] ^=
                (uint8_t)(1u << scratch_random(&seed) % 8);
        }
        scratch_write(state, "broken", copy, length);
        read_whatever(scratch_path(state, "broken"));
    }
    free(copy);
}

static void broken_files_do_not_crash(void **state)
{
    for (unsigned i = 0; i < TTF_COUNT_OF(all); i++) {
        uint8_t *bytes;
        size_t n;

        write_foreign(state, &all[i], 2);
        bytes = scratch_read(state, all[i].name, &n);
        break_it(state, bytes, n, 150, i);
        free(bytes);
    }
}

static void broken_dng_files_do_not_crash(void **state)
{
    struct ttf_frame_format format = {.width = 60,
                                      .height = 40,
                                      .stride = 120,
                                      .packing = TTF_PACKING_RAW16,
                                      .cfa = TTF_CFA_GRBG,
                                      .bits = 12,
                                      .black_level = 64,
                                      .white_level = 4095};
    struct ttf_dng_info info = {.model = "m", .times = {0, 3600, 1000}};
    struct ttf_io *io = ttf_io_posix();
    struct ttf_raw_sum raw;
    uint8_t *bytes;
    size_t n;
    int file = scratch_create(state, "a.dng");

    assert_int_equal(ttf_raw_sum_init(&raw, &format), 0);
    raw.n = 1;
    assert_int_equal(ttf_dng_write(&raw, &info, io, file, NULL), 0);
    assert_int_equal(io->ops->close(io, file), 0);
    bytes = scratch_read(state, "a.dng", &n);
    break_it(state, bytes, n, 1500, 4);
    free(bytes);
    ttf_raw_sum_free(&raw);
}

/* A few bytes that claim 65,535 x 65,535 pixels must not cost memory or time. */
static void a_boasting_header_is_refused(void **state)
{
    TIFF *tiff = TIFFOpen(scratch_path(state, "huge.tif"), "w");
    struct ttf_tiff_reader *reader = NULL;
    struct ttf_raw_sum raw;
    uint8_t few[64] = {0};

    assert_non_null(tiff);
    TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, 65535);
    TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, 65535);
    TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, 16);
    TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, 1);
    TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, 34892);
    TIFFSetField(tiff, TIFFTAG_COMPRESSION, COMPRESSION_ADOBE_DEFLATE);
    TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, 65535);
    assert_true(TIFFWriteRawStrip(tiff, 0, few, sizeof(few)) > 0);
    TIFFClose(tiff);
    assert_true(
        ttf_tiff_reader_open(ttf_io_posix(), scratch_path(state, "huge.tif"), &reader, NULL) < 0);
    assert_true(ttf_dng_read(ttf_io_posix(), scratch_path(state, "huge.tif"), &raw, NULL, NULL) <
                0);
}

static void what_is_no_tiff_is_told_so(void **state)
{
    struct ttf_tiff_reader *reader = NULL;
    struct ttf_err err = {0};

    scratch_write(state, "x.tif", "This is a text, not a picture.", 30);
    assert_int_equal(
        ttf_tiff_reader_open(ttf_io_posix(), scratch_path(state, "x.tif"), &reader, &err),
        -TTF_EDAMAGED);
    assert_non_null(strstr(err.where, "x.tif"));
    assert_non_null(strstr(err.what, "TIFF"));
    assert_int_equal(
        ttf_tiff_reader_open(ttf_io_posix(), scratch_path(state, "none.tif"), &reader, &err),
        -ENOENT);
}

/* ---- a disk that fails ---- */

static int fail_after(void *ctx, const char *op, const char *path)
{
    int *left = ctx;

    return strcmp(op, "pwrite") == 0 && (*left)-- <= 0 ? -ENOSPC : 0;
}

static void a_full_disk_is_reported_at_whatever_write(void **state)
{
    struct ttf_pixbuf buf;
    struct ttf_tiff_spec spec = {.icc = TTF_ICC_LINEAR, .times = {0, 0, 1000}};
    int successes = 0;

    assert_int_equal(ttf_pixbuf_alloc(&buf, 400, 400, 3, TTF_SAMPLE_U16), 0);
    for (int allowed = 0; allowed < 200 && successes == 0; allowed++) {
        int left = allowed, file, r;
        struct ttf_io *io = ttf_io_faulty_create(ttf_io_posix(), fail_after, &left);
        struct ttf_err err = {0};

        assert_non_null(io);
        (void)io->ops->unlink(io, scratch_path(state, "f.tif"));
        file = io->ops->open(io, scratch_path(state, "f.tif"), TTF_IO_CREATE_NEW);
        assert_true(file >= 0);
        r = ttf_tiff_write(io, file, &buf, &spec, &err);
        if (r == 0)
            successes++;
        else if (r != -ENOSPC)
            fail_msg("after %d writes: %d %s", allowed, r, err.what);
        assert_int_equal(io->ops->close(io, file), 0);
        ttf_io_faulty_destroy(io);
    }
    assert_int_equal(successes, 1);
    ttf_pixbuf_free(&buf);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(every_common_layout_is_read, scratch_make, scratch_remove),
        cmocka_unit_test_setup_teardown(pages_and_rows_are_read_in_any_order, scratch_make,
                                        scratch_remove),
        cmocka_unit_test_setup_teardown(rows_are_the_same_however_many_are_asked_for, scratch_make,
                                        scratch_remove),
        cmocka_unit_test_setup_teardown(a_jpeg_inside_comes_out_as_rgb, scratch_make,
                                        scratch_remove),
        cmocka_unit_test_setup_teardown(broken_files_do_not_crash, scratch_make, scratch_remove),
        cmocka_unit_test_setup_teardown(broken_dng_files_do_not_crash, scratch_make,
                                        scratch_remove),
        cmocka_unit_test_setup_teardown(a_boasting_header_is_refused, scratch_make, scratch_remove),
        cmocka_unit_test_setup_teardown(what_is_no_tiff_is_told_so, scratch_make, scratch_remove),
        cmocka_unit_test_setup_teardown(a_full_disk_is_reported_at_whatever_write, scratch_make,
                                        scratch_remove),
    };

    return cmocka_run_group_tests_name("tiff_foreign", tests, NULL, NULL);
}
