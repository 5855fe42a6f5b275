/* SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include <tiffio.h>

#include "jpeg_encoder.h"
#include "lossless_jpeg.h"
#include "scratch.h"
#include "ttf/base/attr.h"
#include "ttf/dataset/dng.h"

#define W    61
#define H    37
#define ROOM (W * H * 4)

static uint16_t samples[ROOM], decoded[ROOM];
static uint8_t bytes[ROOM * 5 + 1024];

/* Smooth with jumps and both extremes, so that all categories occur. */
static void fill(unsigned bits, size_t n)
{
    uint32_t seed = bits;
    unsigned max = (1u << bits) - 1;

    for (size_t i = 0; i < n; i++) {
        uint32_t r = scratch_random(&seed);

        samples[i] =
            (uint16_t)(r % 16 == 0 ? (r >> 8) % 2 * max : ((i * 37) + (r >> 4) % 50) & max);
    }
}

static void every_predictor_width_and_component_count_comes_back(void **state)
{
    for (unsigned components = 1; components <= 4; components++) {
        for (unsigned bits = 2; bits <= 16; bits++) {
            for (unsigned predictor = 1; predictor <= 7; predictor++) {
                for (unsigned restart = 0; restart <= 5; restart += 5) {
                    struct jpeg_encoding e = {W, H, components, bits, predictor, restart};
                    struct lossless_jpeg_info info;
                    size_t n = (size_t)W * H * components, encoded;

                    fill(bits, n);
                    encoded = jpeg_encode(&e, samples, bytes);
                    assert_int_equal(lossless_jpeg_decode(bytes, encoded, decoded, n, &info), 0);
                    assert_int_equal(info.width, W);
                    assert_int_equal(info.height, H);
                    assert_int_equal(info.components, components);
                    assert_memory_equal(samples, decoded, n * 2);
                }
            }
        }
    }
}

static void cut_files_are_damage_and_never_more_is_written(void **state)
{
    struct jpeg_encoding e = {W, H, 2, 12, 1, 0};
    struct lossless_jpeg_info info;
    size_t encoded;

    fill(12, (size_t)W * H * 2);
    encoded = jpeg_encode(&e, samples, bytes);
    assert_int_equal(lossless_jpeg_decode(bytes, encoded, decoded, (size_t)W * H * 2 - 1, &info),
                     -ENOSPC);
    for (size_t n = 0; n + 3 < encoded; n += n < 200 ? 1 : 97) {
        uint8_t *copy = malloc(n + 1); /* so that a sanitizer sees each step beyond */

        assert_non_null(copy);
        memcpy(copy, bytes, n);
        assert_int_equal(lossless_jpeg_decode(copy, n, decoded, ROOM, &info), -TTF_EDAMAGED);
        free(copy);
    }
}

static void broken_files_do_not_crash(void **state)
{
    struct jpeg_encoding e = {W, H, 2, 14, 6, 4};
    uint8_t *copy;
    size_t encoded;
    uint32_t seed = 77;

    fill(14, (size_t)W * H * 2);
    encoded = jpeg_encode(&e, samples, bytes);
    copy = malloc(encoded);
    assert_non_null(copy);
    for (int i = 0; i < 4000; i++) {
        struct lossless_jpeg_info info;
        int r;

        memcpy(copy, bytes, encoded);
        for (int k = 0; k <= i % 4; k++)
            copy[scratch_random(&seed) % (i % 2 ? 120 : encoded)] = (uint8_t)scratch_random(&seed);
        r = lossless_jpeg_decode(copy, encoded, decoded, ROOM, &info);
        assert_true(r == 0 || r == -TTF_EDAMAGED || r == -ENOTSUP || r == -ENOSPC);
    }
    free(copy);
}

#define SOI "\xff\xd8"
#define TABLE \
    "\xff\xc4\0\x14\0\1\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0" /* one code, "0": no difference */
#define FRAME   "\xff\xc3\0\x0b\x8\0\2\0\x8\1\1\x11\0"   /* 8 bits, 8 x 2, one component */
#define SCAN    "\xff\xda\0\x8\1\1\0\1\0\0"
#define NOTHING "\0\0\0\0\0\0"

/* A file of 16 equal samples, segment by segment, and what is wrong with each of its neighbours. */
static void each_segment_that_cannot_be_is_refused(void **state)
{
#define FILE_OF(...) __VA_ARGS__, sizeof(__VA_ARGS__) - 1
    static const struct {
        const char *data;
        size_t n;
        int code;
    } cases[] = {
        {FILE_OF(SOI TABLE FRAME SCAN NOTHING), 0},
        {FILE_OF(SOI "\xff\xe0\0\4ab" TABLE FRAME SCAN NOTHING), 0}, /* somebody's own segment */
        {FILE_OF(SOI "\xff\xc8\0\2" TABLE FRAME SCAN NOTHING), 0},   /* reserved */
        {FILE_OF(SOI "\xff\xdd\0\2" TABLE FRAME SCAN NOTHING), 0},   /* no interval in it */
        {FILE_OF(SOI "\xff\xdd\0\4\0\0" TABLE FRAME SCAN NOTHING), 0},
        {FILE_OF("\xff\xd9" TABLE FRAME SCAN NOTHING), -TTF_EDAMAGED},
        {FILE_OF(SOI "\xfe\xc4\0\2" TABLE FRAME SCAN NOTHING), -TTF_EDAMAGED},
        {FILE_OF(SOI "\xff\xe0\0\1" TABLE FRAME SCAN NOTHING), -TTF_EDAMAGED},
        {FILE_OF(SOI "\xff\xe0\xff\xff" TABLE FRAME SCAN NOTHING), -TTF_EDAMAGED},
        /* tables: a piece of one, an unknown one, three codes of one bit, a category beyond 16, too many */
        {FILE_OF(SOI "\xff\xc4\0\5abc" FRAME SCAN NOTHING), -TTF_EDAMAGED},
        {FILE_OF(SOI "\xff\xc4\0\x14\4\1\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0" FRAME SCAN NOTHING),
         -TTF_EDAMAGED},
        {FILE_OF(SOI "\xff\xc4\0\x16\0\3\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\1\2" FRAME SCAN NOTHING),
         -TTF_EDAMAGED},
        {FILE_OF(SOI "\xff\xc4\0\x14\0\1\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\x11" FRAME SCAN NOTHING),
         -TTF_EDAMAGED},
        {FILE_OF(SOI "\xff\xc4\0\x13\0\0\0\0\0\0\x12\0\0\0\0\0\0\0\0\0\0" FRAME SCAN NOTHING),
         -TTF_EDAMAGED},
        /* frames: two, too short, bits, components, sides, subsampled */
        {FILE_OF(SOI TABLE FRAME FRAME SCAN NOTHING), -TTF_EDAMAGED},
        {FILE_OF(SOI TABLE "\xff\xc3\0\5\x8\0\2" SCAN NOTHING), -TTF_EDAMAGED},
        {FILE_OF(SOI TABLE "\xff\xc3\0\x0b\1\0\2\0\x8\1\1\x11\0" SCAN NOTHING), -TTF_EDAMAGED},
        {FILE_OF(SOI TABLE "\xff\xc3\0\x0b\x11\0\2\0\x8\1\1\x11\0" SCAN NOTHING), -TTF_EDAMAGED},
        {FILE_OF(SOI TABLE "\xff\xc3\0\x0b\x8\0\2\0\x8\0\1\x11\0" SCAN NOTHING), -TTF_EDAMAGED},
        {FILE_OF(SOI TABLE "\xff\xc3\0\x0b\x8\0\2\0\x8\5\1\x11\0" SCAN NOTHING), -TTF_EDAMAGED},
        {FILE_OF(SOI TABLE "\xff\xc3\0\x0b\x8\0\2\0\x8\2\1\x11\0" SCAN NOTHING), -TTF_EDAMAGED},
        {FILE_OF(SOI TABLE "\xff\xc3\0\x0b\x8\0\0\0\x8\1\1\x11\0" SCAN NOTHING), -ENOTSUP},
        {FILE_OF(SOI TABLE "\xff\xc3\0\x0b\x8\0\2\0\0\1\1\x11\0" SCAN NOTHING), -ENOTSUP},
        {FILE_OF(SOI TABLE "\xff\xc3\0\x0b\x8\0\2\0\x8\1\1\x21\0" SCAN NOTHING), -ENOTSUP},
        {FILE_OF(SOI TABLE "\xff\xcb\0\2" FRAME SCAN NOTHING), -ENOTSUP}, /* arithmetic */
        /* scans: before the frame, empty, of fewer components, too short, of others, without a table */
        {FILE_OF(SOI TABLE SCAN NOTHING), -TTF_EDAMAGED},
        {FILE_OF(SOI TABLE FRAME "\xff\xda\0\2" NOTHING), -TTF_EDAMAGED},
        {FILE_OF(SOI TABLE FRAME "\xff\xda\0\x8\2\1\0\1\0\0" NOTHING), -ENOTSUP},
        {FILE_OF(SOI TABLE FRAME "\xff\xda\0\5\1\1\0" NOTHING), -TTF_EDAMAGED},
        {FILE_OF(SOI TABLE FRAME "\xff\xda\0\x8\1\2\0\1\0\0" NOTHING), -TTF_EDAMAGED},
        {FILE_OF(SOI TABLE FRAME "\xff\xda\0\x8\1\1\x40\1\0\0" NOTHING), -TTF_EDAMAGED},
        {FILE_OF(SOI FRAME SCAN NOTHING), -TTF_EDAMAGED},
        /* predictors 0 and 8, a shift of all the bits */
        {FILE_OF(SOI TABLE FRAME "\xff\xda\0\x8\1\1\0\0\0\0" NOTHING), -TTF_EDAMAGED},
        {FILE_OF(SOI TABLE FRAME "\xff\xda\0\x8\1\1\0\x8\0\0" NOTHING), -TTF_EDAMAGED},
        {FILE_OF(SOI TABLE FRAME "\xff\xda\0\x8\1\1\0\1\0\x8" NOTHING), -TTF_EDAMAGED},
        /* restarts: amid a row, none where one is due, another marker there */
        {FILE_OF(SOI TABLE FRAME "\xff\xdd\0\4\0\3" SCAN NOTHING), -ENOTSUP},
        {FILE_OF(SOI TABLE FRAME "\xff\xdd\0\4\0\x8" SCAN "\0\xff\xd0\0"), 0},
        {FILE_OF(SOI TABLE FRAME "\xff\xdd\0\4\0\x8" SCAN "\0\0"), -TTF_EDAMAGED},
        {FILE_OF(SOI TABLE FRAME "\xff\xdd\0\4\0\x8" SCAN "\0\xff\xd9\0"), -TTF_EDAMAGED},
        /* bits that are no code */
        {FILE_OF(SOI TABLE FRAME SCAN "\xff\0\xff\0\xff\0"), -TTF_EDAMAGED},
    };

    for (unsigned i = 0; i < TTF_COUNT_OF(cases); i++) {
        struct lossless_jpeg_info info = {0};
        int r =
            lossless_jpeg_decode((const uint8_t *)cases[i].data, cases[i].n, decoded, ROOM, &info);

        if (r != cases[i].code)
            fail_msg("case %u: %d, not %d", i, r, cases[i].code);
        for (unsigned k = 0; r == 0 && k < 16; k++)
            assert_int_equal(decoded[k], 128); /* where prediction begins */
    }
}

static void lossy_jpeg_is_told_apart(void **state)
{
    static const uint8_t baseline[] = {0xff, 0xd8, 0xff, 0xc0, 0, 11, 8, 0, 8, 0, 8, 1, 1, 0x11, 0};
    struct lossless_jpeg_info info;

    assert_int_equal(lossless_jpeg_decode(baseline, sizeof(baseline), decoded, ROOM, &info),
                     -ENOTSUP);
}

/* A DNG as converters write them: tiles of lossless JPEG, two components wide, in a folder below a thumbnail. */
static void a_tiled_dng_of_another_program_is_read(void **state)
{
    enum {
        TILE = 64,
        IMAGE_W = 150,
        IMAGE_H = 100
    };
    static const uint16_t size[2] = {2, 2};
    static const uint8_t pattern[4] = {1, 2, 0, 1}; /* GBRG */
    static const float black[4] = {100, 104, 96, 100};
    static const uint32_t white = 4000, area[4] = {2, 4, 98, 148};
    static uint16_t image[192 * 128];
    uint64_t sub[1] = {0};
    struct ttf_raw_sum raw;
    struct ttf_dng_info info;
    uint8_t thumbnail[12] = {0};
    TIFF *tiff = TIFFOpen(scratch_path(state, "t.dng"), "w");

    assert_non_null(tiff);
    for (unsigned i = 0; i < 192 * 128; i++)
        image[i] = (uint16_t)(100 + (i * 7) % 3001);
    TIFFSetField(tiff, TIFFTAG_SUBFILETYPE, 1);
    TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, 2);
    TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, 2);
    TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, 8);
    TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, 3);
    TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_RGB);
    TIFFSetField(tiff, TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG);
    TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, 2);
    TIFFSetField(tiff, TIFFTAG_MODEL, "Other");
    TIFFSetField(tiff, TIFFTAG_SUBIFD, 1, sub);
    assert_true(TIFFWriteEncodedStrip(tiff, 0, thumbnail, 12) == 12);
    assert_int_equal(TIFFWriteDirectory(tiff), 1);

    TIFFSetField(tiff, TIFFTAG_SUBFILETYPE, 0);
    TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, IMAGE_W);
    TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, IMAGE_H);
    TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, 16);
    TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, 1);
    TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_CFA);
    TIFFSetField(tiff, TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG);
    TIFFSetField(tiff, TIFFTAG_COMPRESSION, COMPRESSION_JPEG);
    TIFFSetField(tiff, TIFFTAG_TILEWIDTH, TILE);
    TIFFSetField(tiff, TIFFTAG_TILELENGTH, TILE);
    TIFFSetField(tiff, TIFFTAG_CFAREPEATPATTERNDIM, size);
    TIFFSetField(tiff, TIFFTAG_CFAPATTERN, 4, pattern);
    TIFFSetField(tiff, TIFFTAG_BLACKLEVELREPEATDIM, size);
    TIFFSetField(tiff, TIFFTAG_BLACKLEVEL, 4, black);
    TIFFSetField(tiff, TIFFTAG_WHITELEVEL, 1, &white);
    TIFFSetField(tiff, TIFFTAG_ACTIVEAREA, area);
    for (uint32_t ty = 0, tile = 0; ty < 2; ty++) {
        for (uint32_t tx = 0; tx < 3; tx++, tile++) {
            struct jpeg_encoding e = {TILE / 2, TILE, 2, 12, 1 + tile % 7, 0};
            size_t n;

            for (size_t y = 0; y < TILE; y++)
                memcpy(samples + y * TILE, image + (ty * TILE + y) * 192 + tx * TILE, TILE * 2);
            n = jpeg_encode(&e, samples, bytes);
            assert_true(TIFFWriteRawTile(tiff, tile, bytes, (tmsize_t)n) == (tmsize_t)n);
        }
    }
    TIFFClose(tiff);

    assert_int_equal(ttf_dng_read(ttf_io_posix(), scratch_path(state, "t.dng"), &raw, &info, NULL),
                     0);
    assert_string_equal(info.model, "Other");
    assert_int_equal(raw.format.width, 144);
    assert_int_equal(raw.format.height, 96);
    assert_int_equal(raw.format.cfa, TTF_CFA_GBRG);
    assert_int_equal(raw.format.black_level, 100);
    assert_int_equal(raw.format.white_level, 4000);
    for (unsigned y = 0; y < 96; y++) {
        for (unsigned x = 0; x < 144; x++) {
            int own = (int)black[(y % 2) * 2 + x % 2];

            assert_int_equal(raw.sum[y * 144 + x], image[(y + 2) * 192 + x + 4] + 100 - own);
        }
    }
    ttf_raw_sum_free(&raw);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_predictor_width_and_component_count_comes_back),
        cmocka_unit_test(cut_files_are_damage_and_never_more_is_written),
        cmocka_unit_test(broken_files_do_not_crash),
        cmocka_unit_test(each_segment_that_cannot_be_is_refused),
        cmocka_unit_test(lossy_jpeg_is_told_apart),
        cmocka_unit_test_setup_teardown(a_tiled_dng_of_another_program_is_read, scratch_make,
                                        scratch_remove),
    };

    return cmocka_run_group_tests_name("lossless_jpeg", tests, NULL, NULL);
}
