/* SPDX-License-Identifier: Apache-2.0 */
/* What a TIFF file holds beside whole pixels, and what is told of it: damage that libtiff only warns of, copies, alpha, profiles. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <lcms2.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <tiffio.h>

#include "scratch.h"
#include "ttf/base/attr.h"
#include "ttf/dataset/import.h"
#include "ttf/dataset/tiff.h"

#define SIDE 64

/* One strip of grey noise in this compression; where its bytes lie. */
static void one_strip(void **state, uint16_t compression, uint64_t *ret_at, uint64_t *ret_bytes)
{
    unsigned bits = compression == COMPRESSION_CCITTFAX4 ? 1 : 8;
    uint8_t noise[SIDE * SIDE];
    uint32_t seed = 7;
    TIFF *tiff = TIFFOpen(scratch_path(state, "strip.tif"), "w");

    assert_non_null(tiff);
    for (unsigned i = 0; i < sizeof(noise); i++)
        noise[i] = (uint8_t)scratch_random(&seed);
    TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, SIDE);
    TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, SIDE);
    TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, bits);
    TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, 1);
    TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, SIDE);
    TIFFSetField(tiff, TIFFTAG_COMPRESSION, compression);
    TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISBLACK);
    assert_true(TIFFWriteEncodedStrip(tiff, 0, noise, SIDE * SIDE * bits / 8) > 0);
    TIFFClose(tiff);
    tiff = TIFFOpen(scratch_path(state, "strip.tif"), "r");
    assert_non_null(tiff);
    *ret_at = TIFFGetStrileOffset(tiff, 0);
    *ret_bytes = TIFFGetStrileByteCount(tiff, 0);
    TIFFClose(tiff);
}

static int read_strip(void **state, struct ttf_err *err)
{
    struct ttf_pixbuf got = {0};
    int code = ttf_tiff_read(ttf_io_posix(), scratch_path(state, "strip.tif"), 0, &got, err);

    ttf_pixbuf_free(&got);
    return code;
}

static void pixels_that_were_made_up_are_damage(void **state)
{
    static const uint16_t kinds[] = {COMPRESSION_CCITTFAX4, COMPRESSION_JPEG, COMPRESSION_LZW,
                                     COMPRESSION_ADOBE_DEFLATE};

    for (unsigned i = 0; i < TTF_COUNT_OF(kinds); i++) {
        struct ttf_err err = {0};
        uint64_t at, n;
        size_t bytes;
        uint8_t *file;

        one_strip(state, kinds[i], &at, &n);
        assert_int_equal(read_strip(state, NULL), 0);
        file = scratch_read(state, "strip.tif", &bytes);
        memset(file + at + n / 2, 0, n - n / 2);
        if (kinds[i] == COMPRESSION_JPEG) { /* it ends in the middle */
            file[at + n / 2] = 0xff;
            file[at + n / 2 + 1] = 0xd9;
        }
        scratch_write(state, "strip.tif", file, bytes);
        free(file);
        if (read_strip(state, &err) != -TTF_EDAMAGED)
            fail_msg("compression %u: %s", kinds[i], err.what);
        assert_string_equal(err.where, scratch_path(state, "strip.tif"));
    }
}

/* As of a JPEG file: zeros where a scan says which frequencies it holds. */
static void a_warning_of_no_pixel_is_no_damage(void **state)
{
    uint64_t at, n;
    size_t bytes;
    uint8_t *file;

    one_strip(state, COMPRESSION_JPEG, &at, &n);
    file = scratch_read(state, "strip.tif", &bytes);
    while (!(file[at] == 0xff && file[at + 1] == 0xda))
        assert_true(++at + 10 < bytes);
    assert_int_equal(file[at + 8], 63);
    file[at + 8] = 0;
    scratch_write(state, "strip.tif", file, bytes);
    free(file);
    assert_int_equal(read_strip(state, NULL), 0);
}

/* A picture of the size and kind of each page, 0: the end. */
struct page {
    uint32_t side, kind;
};

static void pages_are(void **state, const struct page *pages, const uint32_t *sides, unsigned n)
{
    TIFF *tiff = TIFFOpen(scratch_path(state, "pages.tif"), "w");
    struct ttf_tiff_reader *reader;
    uint8_t pixels[64] = {0};

    assert_non_null(tiff);
    for (; pages->side; pages++) {
        TIFFSetField(tiff, TIFFTAG_SUBFILETYPE, pages->kind);
        TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, pages->side);
        TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, pages->side);
        TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, 8);
        TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, pages->side);
        TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISBLACK);
        assert_true(TIFFWriteEncodedStrip(tiff, 0, pixels, pages->side * pages->side) > 0);
        assert_int_equal(TIFFWriteDirectory(tiff), 1);
    }
    TIFFClose(tiff);
    assert_int_equal(
        ttf_tiff_reader_open(ttf_io_posix(), scratch_path(state, "pages.tif"), &reader, NULL), 0);
    assert_int_equal(ttf_tiff_reader_info(reader)->pages, n);
    assert_int_equal(ttf_tiff_reader_info(reader)->width, sides[0]);
    for (unsigned i = n; i-- > 0;) {
        assert_int_equal(ttf_tiff_reader_page(reader, i, NULL), 0);
        assert_int_equal(ttf_tiff_reader_info(reader)->width, sides[i]);
    }
    ttf_tiff_reader_close(reader);
}

static void smaller_copies_and_masks_are_no_pages(void **state)
{
    pages_are(state, (struct page[]){{8, 0}, {4, 1}, {2, 1}, {0}}, (uint32_t[]){8}, 1);
    pages_are(state, (struct page[]){{8, 0}, {4, 1}, {7, 0}, {7, 4}, {6, 2}, {0}},
              (uint32_t[]){8, 7, 6}, 3);
    pages_are(state, (struct page[]){{2, 1}, {8, 0}, {0}}, (uint32_t[]){8}, 1);
    pages_are(state, (struct page[]){{8, 1}, {4, 1}, {0}}, (uint32_t[]){8, 4}, 2);
}

enum profile {
    NONE,
    SRGB,
    LINEAR,
    WIDE,
    WIDE_LINEAR,
};

/* The bytes of a profile, to be freed. */
static void *make_profile(enum profile kind, size_t *ret_bytes)
{
    const cmsCIExyY white = {0.3127, 0.3290, 1};
    const cmsCIExyYTRIPLE adobe = {{0.64, 0.33, 1}, {0.21, 0.71, 1}, {0.15, 0.06, 1}};
    cmsToneCurve *curve, *curves[3];
    cmsUInt32Number n = 0;
    cmsHPROFILE profile;
    uint8_t *bytes;

    if (kind == SRGB || kind == LINEAR) {
        assert_int_equal(ttf_icc_create(kind == SRGB ? TTF_ICC_SRGB : TTF_ICC_LINEAR, 3, &bytes,
                                        ret_bytes, NULL),
                         0);
        return bytes;
    }
    curve = cmsBuildGamma(NULL, kind == WIDE ? 2.19921875 : 1);
    curves[0] = curves[1] = curves[2] = curve;
    profile = cmsCreateRGBProfile(&white, &adobe, curves);
    assert_true(cmsSaveProfileToMem(profile, NULL, &n));
    bytes = malloc(n);
    assert_true(bytes && cmsSaveProfileToMem(profile, bytes, &n));
    cmsCloseProfile(profile);
    cmsFreeToneCurve(curve);
    *ret_bytes = n;
    return bytes;
}

/* 2 x 2 of RGB, and alpha or what is not said to be. */
static const char *with_profile(void **state, enum profile kind, unsigned samples, bool deep)
{
    const char *path = scratch_path(state, "profile.tif");
    TIFF *tiff = TIFFOpen(path, "w");
    uint16_t pixels[2 * 2 * 4] = {0};
    uint16_t alpha = EXTRASAMPLE_UNASSALPHA;
    size_t n = 0;
    void *profile = kind == NONE ? NULL : make_profile(kind, &n);

    assert_non_null(tiff);
    TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, 2);
    TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, 2);
    TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, deep ? 16 : 8);
    TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, samples);
    TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, 2);
    TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_RGB);
    TIFFSetField(tiff, TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG);
    if (samples == 4)
        TIFFSetField(tiff, TIFFTAG_EXTRASAMPLES, 1, &alpha);
    if (profile)
        TIFFSetField(tiff, TIFFTAG_ICCPROFILE, (uint32_t)n, profile);
    assert_true(TIFFWriteEncodedStrip(tiff, 0, pixels, 4 * samples * (deep ? 2 : 1)) > 0);
    TIFFClose(tiff);
    free(profile);
    return path;
}

static void alpha_and_profiles_that_do_not_come_along_are_told(void **state)
{
    static const struct {
        enum profile profile;
        unsigned samples;
        bool deep, foreign;
    } files[] = {{NONE, 3, false, false}, {NONE, 4, true, false},   {SRGB, 3, false, false},
                 {SRGB, 4, true, false},  {LINEAR, 3, true, false}, {LINEAR, 4, false, false},
                 {WIDE, 3, false, true},  {WIDE, 4, true, true},    {WIDE_LINEAR, 3, true, true}};

    for (unsigned i = 0; i < TTF_COUNT_OF(files); i++) {
        const char *const inputs[] = {
            with_profile(state, files[i].profile, files[i].samples, files[i].deep)};
        char output[200], name[20];
        struct ttf_import_config config = {
            .inputs = inputs, .n_inputs = 1, .output = output, .interval_ns = TTF_NS_PER_S};
        struct ttf_import_result result;
        struct ttf_err err = {0};

        snprintf(name, sizeof(name), "data%u", i);
        snprintf(output, sizeof(output), "%s", scratch_path(state, name));
        if (ttf_import(ttf_io_posix(), &config, &result, &err) < 0)
            fail_msg("%u: %s", i, err.what);
        if (result.alpha_dropped != (files[i].samples == 4) ||
            result.foreign_profile != files[i].foreign)
            fail_msg("%u: alpha %d, profile %d", i, result.alpha_dropped, result.foreign_profile);
    }
}

#define T(test) cmocka_unit_test_setup_teardown(test, scratch_make, scratch_remove)

int main(void)
{
    const struct CMUnitTest tests[] = {
        T(pixels_that_were_made_up_are_damage),
        T(a_warning_of_no_pixel_is_no_damage),
        T(smaller_copies_and_masks_are_no_pages),
        T(alpha_and_profiles_that_do_not_come_along_are_told),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
