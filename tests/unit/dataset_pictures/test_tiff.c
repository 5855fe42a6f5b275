/* SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <lcms2.h>
#include <tiffio.h>

#include "scratch.h"
#include "ttf/dataset/colour.h"
#include "ttf/dataset/tiff.h"

/* 2026-03-29T00:59:59.123456789Z, in a zone an hour and a half east. */
#define START_UTC_NS INT64_C(1774745999123456789)

static const struct ttf_tiff_times times = {
    .start_utc_ns = START_UTC_NS, .zone_offset_s = 5400, .exposure_ns = 10000000};

static void noise(struct ttf_pixbuf *buf, uint32_t w, uint32_t h, uint32_t samples,
                  enum ttf_sample format)
{
    uint32_t seed = w * 31 + h * 7 + samples;

    assert_int_equal(ttf_pixbuf_alloc(buf, w, h, samples, format), 0);
    for (uint32_t y = 0; y < h; y++) {
        for (uint32_t i = 0; i < w * samples; i++) {
            uint32_t r = scratch_random(&seed);

            if (format == TTF_SAMPLE_U8)
                ((uint8_t *)ttf_pixbuf_row(buf, y))[i] = (uint8_t)r;
            else if (format == TTF_SAMPLE_U16)
                ((uint16_t *)ttf_pixbuf_row(buf, y))[i] = (uint16_t)r;
            else
                ((float *)ttf_pixbuf_row(buf, y))[i] = (float)r / 1e6f - 1000.0f;
        }
    }
}

/* What a stream of halves is written as: the nearest half; beyond the largest infinity, below the smallest nothing. */
static void halves_in_a_file_are_the_nearest(void **state)
{
    static const float given[] = {0.0f,     -0.0f,    1.0f,   2049.0f,  2051.0f,   65504.0f,
                                  65519.0f, 65520.0f, -1e30f, INFINITY, -INFINITY, 1e-5f,
                                  6e-8f,    1e-9f,    -3e-8f, 1.0009f};
    static const float wanted[] = {0.0f,
                                   -0.0f,
                                   1.0f,
                                   2048.0f,
                                   2052.0f,
                                   65504.0f,
                                   65504.0f,
                                   INFINITY,
                                   -INFINITY,
                                   INFINITY,
                                   -INFINITY,
                                   168 / 16777216.0f,
                                   1 / 16777216.0f,
                                   0.0f,
                                   -1 / 16777216.0f,
                                   1.0009765625f};
    const uint32_t n = sizeof(given) / sizeof(*given);
    const struct ttf_tiff_spec spec = {.width = n + 1,
                                       .height = 1,
                                       .samples = 1,
                                       .format = TTF_SAMPLE_F16,
                                       .times = {.start_utc_ns = TTF_NS_UNKNOWN}};
    struct ttf_tiff_writer *writer = NULL;
    struct ttf_io *io = ttf_io_posix();
    struct ttf_pixbuf got = {0};
    int file = scratch_create(state, "half.tif");
    float row[sizeof(given) / sizeof(*given) + 1];

    memcpy(row, given, sizeof(given));
    row[n] = NAN;
    assert_int_equal(ttf_tiff_writer_open(io, file, &spec, &writer, NULL), 0);
    assert_int_equal(ttf_tiff_writer_rows(writer, row, sizeof(row), 1, NULL), 0);
    assert_int_equal(ttf_tiff_writer_close(writer, NULL), 0);
    assert_int_equal(io->ops->close(io, file), 0);
    assert_int_equal(ttf_tiff_read(io, scratch_path(state, "half.tif"), 0, &got, NULL), 0);
    assert_int_equal(got.format, TTF_SAMPLE_F32);
    for (uint32_t i = 0; i < n; i++)
        if (((float *)got.data)[i] != wanted[i])
            fail_msg("%u: %g became %g", i, (double)given[i], (double)((float *)got.data)[i]);
    assert_true(isnan(((float *)got.data)[n]));
    ttf_pixbuf_free(&got);
}

static void write_file(void **state, const char *name, const struct ttf_pixbuf *buf,
                       const struct ttf_tiff_spec *spec)
{
    struct ttf_io *io = ttf_io_posix();
    int file = scratch_create(state, name);
    struct ttf_err err = {0};

    if (ttf_tiff_write(io, file, buf, spec, &err) < 0)
        fail_msg("%s", err.what);
    assert_int_equal(io->ops->close(io, file), 0);
}

static void assert_same(const struct ttf_pixbuf *a, const struct ttf_pixbuf *b)
{
    assert_int_equal(a->width, b->width);
    assert_int_equal(a->height, b->height);
    assert_int_equal(a->samples, b->samples);
    assert_int_equal(a->format, b->format);
    for (uint32_t y = 0; y < a->height; y++)
        assert_memory_equal(ttf_pixbuf_row(a, y), ttf_pixbuf_row(b, y),
                            (size_t)a->width * a->samples * ttf_sample_bytes(a->format));
}

static void every_geometry_comes_back_to_the_bit(void **state)
{
    static const uint32_t sizes[][2] = {{1, 1}, {7, 3}, {301, 457}, {1, 5000}, {70000, 2}};
    static const enum ttf_sample formats[] = {TTF_SAMPLE_U8, TTF_SAMPLE_U16, TTF_SAMPLE_F32};

    for (unsigned s = 0; s < TTF_COUNT_OF(sizes); s++) {
        for (unsigned f = 0; f < 3; f++) {
            for (uint32_t samples = 1; samples <= 4; samples++) {
                for (int deflate = 0; deflate < 2; deflate++) {
                    struct ttf_pixbuf buf, back;
                    struct ttf_tiff_spec spec = {.compression =
                                                     deflate ? TTF_TIFF_DEFLATE : TTF_TIFF_NONE,
                                                 .icc = TTF_ICC_LINEAR,
                                                 .times = {.start_utc_ns = TTF_NS_UNKNOWN}};
                    struct ttf_err err = {0};

                    noise(&buf, sizes[s][0], sizes[s][1], samples, formats[f]);
                    write_file(state, "a.tif", &buf, &spec);
                    if (ttf_tiff_read(ttf_io_posix(), scratch_path(state, "a.tif"), 0, &back,
                                      &err) < 0)
                        fail_msg("%s", err.what);
                    assert_same(&buf, &back);
                    ttf_pixbuf_free(&buf);
                    ttf_pixbuf_free(&back);
                }
            }
        }
    }
}

/* ---- the order of the file ---- */

/* Hands on to the disk, and looks where. */
struct watch {
    struct ttf_io io;
    int64_t at; /* where the next byte has to go */
    bool jumped, read;
};

static int64_t watch_pwrite(struct ttf_io *io, int file, const void *buf, size_t n, int64_t offset)
{
    struct watch *watch = (struct watch *)io;

    watch->jumped = watch->jumped || offset != watch->at;
    watch->at = offset + (int64_t)n;
    return ttf_io_posix()->ops->pwrite(ttf_io_posix(), file, buf, n, offset);
}

static int64_t watch_pread(struct ttf_io *io, int file, void *buf, size_t n, int64_t offset)
{
    ((struct watch *)io)->read = true;
    return ttf_io_posix()->ops->pread(ttf_io_posix(), file, buf, n, offset);
}

/* Whoever hashes what is written has to read nothing again. */
static void bytes_are_written_in_the_order_of_the_file(void **state)
{
    static const uint32_t sizes[][2] = {{1, 1}, {7, 3}, {301, 457}, {1, 5000}, {700, 500}};
    struct ttf_io_ops ops = *ttf_io_posix()->ops;

    ops.pwrite = watch_pwrite;
    ops.pread = watch_pread;
    for (unsigned s = 0; s < TTF_COUNT_OF(sizes); s++) {
        for (unsigned k = 0; k < 8; k++) {
            struct ttf_tiff_spec spec = {.icc = k & 1 ? TTF_ICC_LINEAR : TTF_ICC_NONE,
                                         .software = "ttfbox"};
            struct watch watch = {.io = {.ops = &ops}};
            struct ttf_pixbuf buf, back;
            int file = scratch_create(state, "order.tif");

            spec.times = k & 2 ? times : (struct ttf_tiff_times){.start_utc_ns = TTF_NS_UNKNOWN};
            noise(&buf, sizes[s][0], sizes[s][1], 3, k & 4 ? TTF_SAMPLE_U8 : TTF_SAMPLE_U16);
            assert_int_equal(ttf_tiff_write(&watch.io, file, &buf, &spec, NULL), 0);
            assert_false(watch.jumped || watch.read);
            assert_int_equal(ttf_io_posix()->ops->close(ttf_io_posix(), file), 0);
            assert_int_equal(
                ttf_tiff_read(ttf_io_posix(), scratch_path(state, "order.tif"), 0, &back, NULL), 0);
            assert_same(&buf, &back);
            ttf_pixbuf_free(&buf);
            ttf_pixbuf_free(&back);
        }
    }
}

/* A text longer than what is held back: the file is whole all the same, and what is read back is the text. */
static void what_is_too_much_to_be_held_goes_as_it_comes(void **state)
{
    static char text[10000];
    struct ttf_tiff_spec spec = {.description = text, .times = times};
    struct ttf_io_ops ops = *ttf_io_posix()->ops;
    struct watch watch = {.io = {.ops = &ops}};
    struct ttf_pixbuf buf, back;
    char *got = NULL;
    TIFF *tiff;
    int file = scratch_create(state, "long.tif");

    ops.pwrite = watch_pwrite;
    memset(text, 'x', sizeof(text) - 1);
    noise(&buf, 301, 457, 3, TTF_SAMPLE_U16);
    assert_int_equal(ttf_tiff_write(&watch.io, file, &buf, &spec, NULL), 0);
    assert_true(watch.jumped);
    assert_int_equal(ttf_io_posix()->ops->close(ttf_io_posix(), file), 0);
    assert_int_equal(ttf_tiff_read(ttf_io_posix(), scratch_path(state, "long.tif"), 0, &back, NULL),
                     0);
    assert_same(&buf, &back);
    tiff = TIFFOpen(scratch_path(state, "long.tif"), "r");
    assert_non_null(tiff);
    assert_int_equal(TIFFGetField(tiff, TIFFTAG_IMAGEDESCRIPTION, &got), 1);
    assert_string_equal(got, text);
    TIFFClose(tiff);
    ttf_pixbuf_free(&buf);
    ttf_pixbuf_free(&back);
}

static void times_and_exposure_come_back(void **state)
{
    struct ttf_pixbuf buf;
    struct ttf_tiff_spec spec = {.icc = TTF_ICC_LINEAR, .times = times, .software = "ttfbox"};
    struct ttf_tiff_reader *reader = NULL;
    const struct ttf_tiff_info *info;
    struct ttf_io *io = ttf_io_posix();

    noise(&buf, 20, 10, 3, TTF_SAMPLE_U16);
    write_file(state, "t.tif", &buf, &spec);
    ttf_pixbuf_free(&buf);
    assert_int_equal(ttf_tiff_reader_open(io, scratch_path(state, "t.tif"), &reader, NULL), 0);
    info = ttf_tiff_reader_info(reader);
    assert_int_equal(info->times.start_utc_ns, START_UTC_NS);
    assert_int_equal(info->times.zone_offset_s, 5400);
    assert_true(info->zone_known);
    assert_int_equal(info->times.exposure_ns, 10000000);
    assert_int_equal(info->pages, 1);
    assert_true(info->has_icc);
    assert_false(info->display_encoded);
    ttf_tiff_reader_close(reader);
}

/* A clock that was never set, and one of another century. */
static void times_before_1970_come_back_too(void **state)
{
    static const int64_t starts[] = {-1, -1500 * TTF_NS_PER_MS, -70 * 366 * TTF_NS_PER_DAY, 0};

    for (unsigned i = 0; i < sizeof(starts) / sizeof(*starts); i++) {
        const struct ttf_tiff_spec spec = {
            .times = {.start_utc_ns = starts[i], .zone_offset_s = -3600}};
        struct ttf_tiff_reader *reader = NULL;
        struct ttf_pixbuf buf;

        noise(&buf, 3, 3, 1, TTF_SAMPLE_U8);
        write_file(state, "old.tif", &buf, &spec);
        assert_int_equal(
            ttf_tiff_reader_open(ttf_io_posix(), scratch_path(state, "old.tif"), &reader, NULL), 0);
        assert_int_equal(ttf_tiff_reader_info(reader)->times.start_utc_ns, starts[i]);
        assert_int_equal(ttf_tiff_reader_info(reader)->times.zone_offset_s, -3600);
        ttf_tiff_reader_close(reader);
        ttf_pixbuf_free(&buf);
        assert_int_equal(
            ttf_io_posix()->ops->unlink(ttf_io_posix(), scratch_path(state, "old.tif")), 0);
    }
}

static void the_same_picture_gives_the_same_bytes(void **state)
{
    struct ttf_pixbuf buf;
    struct ttf_tiff_spec spec = {.icc = TTF_ICC_LINEAR, .times = times};
    uint8_t *a, *b;
    size_t n_a, n_b;

    noise(&buf, 300, 200, 3, TTF_SAMPLE_U16);
    write_file(state, "a.tif", &buf, &spec);
    write_file(state, "b.tif", &buf, &spec);
    a = scratch_read(state, "a.tif", &n_a);
    b = scratch_read(state, "b.tif", &n_b);
    assert_int_equal(n_a, n_b);
    assert_memory_equal(a, b, n_a);
    assert_true(n_a < 300 * 200 * 6 + 4096); /* nothing is in it twice */
    free(a);
    free(b);
    ttf_pixbuf_free(&buf);
}

static int complaints;

static void on_complaint(const char *module, const char *fmt, va_list args) TTF_PRINTF(2, 0);
static void on_complaint(const char *module, const char *fmt, va_list args)
{
    complaints++;
    (void)vfprintf(stderr, fmt, args);
}

static void other_readers_do_not_complain_and_see_the_tags(void **state)
{
    struct ttf_pixbuf buf;
    struct ttf_tiff_spec spec = {.icc = TTF_ICC_LINEAR, .times = times, .description = "grass"};
    const char *text = NULL;
    TIFF *tiff;

    noise(&buf, 30, 20, 3, TTF_SAMPLE_U16);
    write_file(state, "a.tif", &buf, &spec);
    ttf_pixbuf_free(&buf);
    complaints = 0;
    TIFFSetWarningHandler(on_complaint);
    TIFFSetErrorHandler(on_complaint);
    tiff = TIFFOpen(scratch_path(state, "a.tif"), "r");
    assert_non_null(tiff);
    assert_int_equal(TIFFGetField(tiff, TIFFTAG_DATETIME, &text), 1);
    assert_string_equal(text, "2026:03:29 02:29:59");
    assert_int_equal(TIFFGetField(tiff, TIFFTAG_IMAGEDESCRIPTION, &text), 1);
    assert_string_equal(text, "grass");
    TIFFClose(tiff);
    assert_int_equal(complaints, 0);
}

/* The oracle is lcms2's own transform to sRGB against our tables. */
static void the_profile_says_linear_light_of_srgb_primaries(void **state)
{
    uint8_t *bytes = NULL;
    size_t n = 0;
    cmsHPROFILE linear, srgb = cmsCreate_sRGBProfile();
    cmsHTRANSFORM transform;

    assert_int_equal(ttf_icc_create(TTF_ICC_LINEAR, 3, &bytes, &n, NULL), 0);
    assert_int_equal(ttf_icc_is_linear(bytes, n), 1);
    linear = cmsOpenProfileFromMem(bytes, (cmsUInt32Number)n);
    assert_non_null(linear);
    transform = cmsCreateTransform(linear, TYPE_RGB_16, srgb, TYPE_RGB_8, INTENT_PERCEPTUAL, 0);
    for (unsigned code = 0; code < 256; code++) {
        uint16_t in[3];
        uint8_t out[3];

        for (int c = 0; c < 3; c++)
            in[c] = ttf_srgb8_to_linear16((uint8_t)(code + 60 * c));
        cmsDoTransform(transform, in, out, 1);
        for (int c = 0; c < 3; c++)
            assert_in_range(out[c] + 1 - (uint8_t)(code + 60 * c), 0, 2);
    }
    cmsDeleteTransform(transform);
    cmsCloseProfile(linear);
    cmsCloseProfile(srgb);
    free(bytes);
    assert_int_equal(ttf_icc_create(TTF_ICC_SRGB, 1, &bytes, &n, NULL), 0);
    assert_int_equal(ttf_icc_is_linear(bytes, n), 0);
    free(bytes);
    assert_true(ttf_icc_is_linear("not a profile at all", 20) < 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(every_geometry_comes_back_to_the_bit, scratch_make,
                                        scratch_remove),
        cmocka_unit_test_setup_teardown(bytes_are_written_in_the_order_of_the_file, scratch_make,
                                        scratch_remove),
        cmocka_unit_test_setup_teardown(what_is_too_much_to_be_held_goes_as_it_comes, scratch_make,
                                        scratch_remove),
        cmocka_unit_test_setup_teardown(times_and_exposure_come_back, scratch_make, scratch_remove),
        cmocka_unit_test_setup_teardown(the_same_picture_gives_the_same_bytes, scratch_make,
                                        scratch_remove),
        cmocka_unit_test_setup_teardown(other_readers_do_not_complain_and_see_the_tags,
                                        scratch_make, scratch_remove),
        cmocka_unit_test_setup_teardown(times_before_1970_come_back_too, scratch_make,
                                        scratch_remove),
        cmocka_unit_test_setup_teardown(halves_in_a_file_are_the_nearest, scratch_make,
                                        scratch_remove),
        cmocka_unit_test(the_profile_says_linear_light_of_srgb_primaries),
    };

    return cmocka_run_group_tests_name("tiff", tests, NULL, NULL);
}
