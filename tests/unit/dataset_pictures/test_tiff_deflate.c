/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Deflated strips that hold more than is asked for, or are damaged: every byte of what is read comes from the file,
 * or the read fails. What lay in the caller's memory shows nowhere.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <tiffio.h>

#include "scratch.h"
#include "ttf/dataset/io.h"
#include "ttf/dataset/tiff.h"

enum {
    W = 100,
    H = 72,
    STRIP = 32,
    WRITTEN = 96,
    ROW = W * 3
};

static uint8_t rows[2][H * ROW];

/* Even surfaces end in a long match, noise in a stored block. */
static uint8_t code_at(bool noise, unsigned y, unsigned i)
{
    return noise ? (uint8_t)((y * 131071u + i * 8191u) * 2654435761u >> 13) : 200;
}

/* ImageLength, in place: the last strip holds all rows of a strip then, as some programs write it. */
static void shorten(const char *path, long folder)
{
    FILE *f = fopen(path, "r+b");
    uint8_t n[2], entry[12];

    assert_non_null(f);
    assert_int_equal(fseek(f, folder, SEEK_SET), 0);
    assert_int_equal(fread(n, 1, 2, f), 2);
    for (unsigned i = 0; i < n[0]; i++) {
        assert_int_equal(fread(entry, 1, 12, f), 12);
        if (entry[0] == (TIFFTAG_IMAGELENGTH & 0xff) && entry[1] == TIFFTAG_IMAGELENGTH >> 8) {
            entry[8] = H;
            assert_int_equal(fseek(f, -12, SEEK_CUR), 0);
            assert_int_equal(fwrite(entry, 1, 12, f), 12);
            assert_int_equal(fseek(f, 0, SEEK_CUR), 0);
        }
    }
    assert_int_equal(fclose(f), 0);
}

static void write_long(const char *path, bool noise)
{
    TIFF *tiff = TIFFOpen(path, "wl");
    long folder;

    assert_non_null(tiff);
    TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, W);
    TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, WRITTEN);
    TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, 8);
    TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, 3);
    TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_RGB);
    TIFFSetField(tiff, TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG);
    TIFFSetField(tiff, TIFFTAG_COMPRESSION, COMPRESSION_ADOBE_DEFLATE);
    TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, STRIP);
    for (unsigned y = 0; y < WRITTEN; y++) {
        uint8_t row[ROW];

        for (unsigned i = 0; i < ROW; i++)
            row[i] = code_at(noise, y, i);
        assert_int_equal(TIFFWriteScanline(tiff, row, y, 0), 1);
    }
    TIFFClose(tiff);
    tiff = TIFFOpen(path, "r");
    assert_non_null(tiff);
    folder = (long)TIFFCurrentDirOffset(tiff);
    TIFFClose(tiff);
    shorten(path, folder);
}

/* All rows into memory that holds `fill`; the first error. */
static int read_all(const char *path, int fill, uint8_t *to)
{
    struct ttf_tiff_reader *reader = NULL;
    int r = ttf_tiff_reader_open(ttf_io_posix(), path, &reader, NULL);
    const struct ttf_tiff_info *info = r == 0 ? ttf_tiff_reader_info(reader) : NULL;

    memset(to, fill, H * ROW);
    if (info && info->height == H && info->width == W && info->samples == 3 &&
        info->format == TTF_SAMPLE_U8)
        r = ttf_tiff_reader_rows(reader, 0, H, to, ROW, NULL);
    else if (r == 0)
        memset(to, 0, H * ROW); /* a flipped bit made it another picture */
    ttf_tiff_reader_close(reader);
    return r;
}

static void a_last_strip_that_holds_more_rows_is_read_to_the_last_one(void **state)
{
    for (int noise = 0; noise < 2; noise++) {
        const char *path = scratch_path(state, "long.tif");

        write_long(path, noise);
        for (int k = 0; k < 2; k++) {
            assert_int_equal(read_all(path, k ? 0xff : 0, rows[k]), 0);
            for (unsigned at = 0; at < H * ROW; at++) {
                if (rows[k][at] != code_at(noise, at / ROW, at % ROW))
                    fail_msg("%s: row %u, byte %u", noise ? "noise" : "even", at / ROW, at % ROW);
            }
        }
    }
}

static void damage_shows_nothing_of_the_callers_memory(void **state)
{
    static uint8_t text[64 << 10];
    unsigned read = 0, failed = 0;

    for (int noise = 0; noise < 2; noise++) {
        const char *path = scratch_path(state, "long.tif"), *bad = scratch_path(state, "bad.tif");
        FILE *f;
        size_t n;

        write_long(path, noise);
        f = fopen(path, "rb");
        n = f ? fread(text, 1, sizeof(text), f) : 0;
        assert_true(n > 0 && n < sizeof(text));
        assert_int_equal(fclose(f), 0);
        for (size_t bit = 3; bit < n * 8; bit += n * 8 / 600 + 1) {
            int r[2];

            text[bit / 8] ^= (uint8_t)(1 << bit % 8);
            f = fopen(bad, "wb");
            assert_true(f && fwrite(text, 1, n, f) == n && fclose(f) == 0);
            text[bit / 8] ^= (uint8_t)(1 << bit % 8);
            for (int i = 0; i < 2; i++)
                r[i] = read_all(bad, i ? 0xff : 0, rows[i]);
            assert_int_equal(r[0], r[1]);
            if (r[0] == 0 && memcmp(rows[0], rows[1], sizeof(rows[0])) != 0)
                fail_msg("%s, bit %zu: some bytes were not read", noise ? "noise" : "even", bit);
            read += r[0] == 0;
            failed += r[0] < 0;
        }
    }
    assert_true(read > 0 && failed > 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(a_last_strip_that_holds_more_rows_is_read_to_the_last_one,
                                        scratch_make, scratch_remove),
        cmocka_unit_test_setup_teardown(damage_shows_nothing_of_the_callers_memory, scratch_make,
                                        scratch_remove),
    };

    return cmocka_run_group_tests_name("tiff_deflate", tests, NULL, NULL);
}
