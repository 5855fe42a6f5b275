/* SPDX-License-Identifier: Apache-2.0 */
/* Frames of real cameras, from ../shared/data or TTFBOX_TEST_DATA; skipped, saying so, where there are none. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "scratch.h"
#include "ttf/dataset/develop.h"
#include "ttf/dataset/dng.h"

static const struct ttf_encoding encoding = {TTF_PEDESTAL, TTF_SCALE};

/* The folder below the real data, or skips. */
static const char *data_folder(const char *name)
{
    static char path[1024];
    const char *root = scratch_real_data();
    DIR *dir;

    snprintf(path, sizeof(path), "%s/%s", root ? root : "../shared/data", name);
    dir = root ? opendir(path) : NULL;
    if (!root || !dir) {
        print_message("%s is not there (TTFBOX_TEST_DATA names its parent)\n", path);
        skip();
    }
    if (dir)
        closedir(dir);
    return path;
}

/* Adds the folder's frames whose names hold both texts; returns how many. */
static unsigned add_frames(const char *folder, const char *text, const char *also, int exposure_ms,
                           struct ttf_raw_sum *sum)
{
    DIR *dir = opendir(folder);
    const struct dirent *entry;
    unsigned n = 0;

    assert_non_null(dir);
    while ((entry = readdir(dir))) { /* NOLINT(concurrency-mt-unsafe): one thread */
        struct ttf_pixbuf bytes, words;
        struct ttf_frame frame = {0};
        char path[1400];

        if (!strstr(entry->d_name, text) || !strstr(entry->d_name, also) ||
            !strstr(entry->d_name, ".tif"))
            continue;
        snprintf(path, sizeof(path), "%s/%s", folder, entry->d_name);
        assert_int_equal(ttf_tiff_read(ttf_io_posix(), path, 0, &bytes, NULL), 0);
        assert_int_equal(bytes.format, TTF_SAMPLE_U8);
        assert_int_equal(ttf_pixbuf_alloc(&words, bytes.width, bytes.height, 1, TTF_SAMPLE_U16), 0);
        for (size_t i = 0; i < (size_t)bytes.width * bytes.height; i++)
            ((uint16_t *)words.data)[i] = ((uint8_t *)bytes.data)[i];
        /* Rows begin with green and blue: 550 nm is brightest at the first pixel, 700 nm below it. */
        frame.format = (struct ttf_frame_format){.width = words.width,
                                                 .height = words.height,
                                                 .stride = words.stride,
                                                 .packing = TTF_PACKING_RAW16,
                                                 .cfa = TTF_CFA_GBRG,
                                                 .bits = 8,
                                                 .white_level = 255};
        frame.data = words.data;
        frame.bytes = words.stride * words.height;
        frame.settings.exposure_ns = (int64_t)exposure_ms * 1000000;
        if (n == 0)
            assert_int_equal(ttf_raw_sum_init(sum, &frame.format), 0);
        assert_int_equal(ttf_raw_sum_add(sum, &frame), 0);
        n++;
        ttf_pixbuf_free(&bytes);
        ttf_pixbuf_free(&words);
    }
    closedir(dir);
    return n;
}

/* A calibration whose flat is even and of one 8-bit code more than full scale at 100 ms: exposure normalisation alone. */
static void even_calibration(struct ttf_calibration *calibration,
                             const struct ttf_frame_format *format)
{
    size_t n = (size_t)format->width * format->height;

    ttf_calibration_init(calibration);
    calibration->width = format->width;
    calibration->height = format->height;
    calibration->cfa = format->cfa;
    calibration->white_level = 255;
    calibration->has_flat = true;
    calibration->flat_gain = malloc(n * sizeof(uint16_t));
    assert_non_null(calibration->flat_gain);
    for (size_t i = 0; i < n; i++)
        calibration->flat_gain[i] = 16384;
    calibration->flat_settings.exposure_ns = 100000000;
    calibration->flat_reflectance = 1;
    calibration->flat_level = 256;
}

static void develop_at(const char *folder, const char *light, int exposure_ms,
                       struct ttf_raw_sum *raw, struct ttf_pixbuf *out)
{
    struct ttf_calibration calibration;
    struct ttf_develop_config config = {.calibration = &calibration, .encoding = encoding};
    struct ttf_develop *develop = NULL;
    char name[32];

    snprintf(name, sizeof(name), "_%dms_", exposure_ms);
    assert_int_equal(add_frames(folder, light, name, exposure_ms, raw), 1);
    even_calibration(&calibration, &raw->format);
    config.format = raw->format;
    assert_int_equal(ttf_develop_create(&config, &develop, NULL), 0);
    assert_int_equal(
        ttf_pixbuf_alloc(out, config.format.width, config.format.height, 3, TTF_SAMPLE_U16), 0);
    assert_int_equal(ttf_develop_run(develop, raw, NULL, out, NULL, NULL), 0);
    ttf_develop_destroy(develop);
    ttf_calibration_free(&calibration);
}

static int compare_doubles(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;

    return x < y ? -1 : x > y;
}

/* Value at exposure k of green pixel i; half a code was cut off at 8 bits. */
static double green_value(const struct ttf_pixbuf *out, size_t i, int exposure_ms)
{
    return (((uint16_t *)out->data)[3 * i + 1] - TTF_PEDESTAL) / (double)TTF_SCALE +
           0.5 / 256 * 100 / exposure_ms;
}

/*
 * Green pixels that are neither dark nor near saturation in two exposures develop
 * to the same value: the median of their ratios is 1, within what this camera
 * allows (8 bits, and light that spills over from saturated neighbours: up to 5 %
 * on a step of 4 in exposure, in the files themselves).
 */
static void real_exposures_develop_to_the_same_value(void **state)
{
    static const int exposures_ms[] = {25, 50, 100, 250, 500, 2000, 3916};
    static const char *const lights[] = {"500nm", "550nm", "650nm"};
    const char *folder = data_folder("camera/colorchecker-bayer");
    unsigned pairs = 0;

    for (unsigned e = 0; e + 1 < TTF_COUNT_OF(exposures_ms); e++) {
        for (unsigned l = 0; l < TTF_COUNT_OF(lights); l++) {
            struct ttf_raw_sum raw[2];
            struct ttf_pixbuf out[2];
            static double ratios[408 * 344];
            unsigned n = 0;

            for (unsigned k = 0; k < 2; k++)
                develop_at(folder, lights[l], exposures_ms[e + k], &raw[k], &out[k]);
            for (uint32_t i = 0; i < raw[0].format.width * raw[0].format.height; i++) {
                uint32_t x = i % raw[0].format.width, y = i / raw[0].format.width;

                if ((x + y) % 2 == 0 && raw[0].sum[i] >= 15 && raw[1].sum[i] >= 40 &&
                    raw[1].sum[i] <= 235)
                    ratios[n++] = green_value(&out[1], i, exposures_ms[e + 1]) /
                                  green_value(&out[0], i, exposures_ms[e]);
            }
            for (unsigned k = 0; k < 2; k++) {
                ttf_pixbuf_free(&out[k]);
                ttf_raw_sum_free(&raw[k]);
            }
            if (n < 1000) /* too dark a picture at the shorter one */
                continue;
            pairs++;
            qsort(ratios, n, sizeof(ratios[0]), compare_doubles);
            print_message("%s, %4d to %4d ms: %5u pixels, ratio of values %.3f\n", lights[l],
                          exposures_ms[e], exposures_ms[e + 1], n, ratios[n / 2]);
            assert_float_equal(ratios[n / 2], 1.0, 0.06);
        }
    }
    assert_true(pairs >= 12);
}

static unsigned bright_pixels(const struct ttf_raw_sum *raw,
                              const struct ttf_calibration *calibration)
{
    struct ttf_develop_config config = {
        .format = raw->format, .calibration = calibration, .encoding = encoding};
    struct ttf_develop *develop = NULL;
    struct ttf_pixbuf out;
    unsigned n = 0;

    assert_int_equal(ttf_develop_create(&config, &develop, NULL), 0);
    assert_int_equal(
        ttf_pixbuf_alloc(&out, raw->format.width, raw->format.height, 3, TTF_SAMPLE_U16), 0);
    assert_int_equal(ttf_develop_run(develop, raw, NULL, &out, NULL, NULL), 0);
    for (size_t i = 0; i < (size_t)out.width * out.height * 3; i++)
        n += ((uint16_t *)out.data)[i] > TTF_PEDESTAL + 4 * TTF_SCALE / 255;
    ttf_develop_destroy(develop);
    ttf_pixbuf_free(&out);
    return n;
}

/* What one dark frame teaches holds for the next: its hot pixels are gone there. */
static void real_dark_frames_take_hot_pixels_away(void **state)
{
    const char *folder = data_folder("camera/colorchecker-bayer");
    struct ttf_calibration calibration;
    struct ttf_raw_sum teacher, other;
    struct ttf_err err = {0};
    unsigned before, after;

    assert_int_equal(add_frames(folder, "d2_dark_3916ms", "-0003", 3916, &teacher), 1);
    assert_int_equal(add_frames(folder, "d2_dark_3916ms", "-0004", 3916, &other), 1);
    ttf_calibration_init(&calibration);
    if (ttf_calibration_fit_dark(&calibration, &teacher, &err) < 0)
        fail_msg("%s", err.what);
    before = bright_pixels(&other, NULL);
    after = bright_pixels(&other, &calibration);
    print_message("%u hot pixels; samples brighter than 4 codes: %u before, %u after\n",
                  calibration.n_hot, before, after);
    assert_true(calibration.n_hot > 0 && before > 0);
    assert_true(2 * after < before);
    ttf_calibration_free(&calibration);
    ttf_raw_sum_free(&teacher);
    ttf_raw_sum_free(&other);
}

static void a_picture_is_no_dark_frame(void **state)
{
    const char *folder = data_folder("camera/colorchecker-bayer");
    struct ttf_calibration calibration;
    struct ttf_raw_sum picture;
    struct ttf_err err = {0};

    ttf_calibration_init(&calibration);
    assert_int_equal(add_frames(folder, "550nm", "_500ms_", 500, &picture), 1);
    assert_true(ttf_calibration_fit_dark(&calibration, &picture, &err) < 0);
    assert_non_null(strstr(err.what, "not dark"));
    assert_true(ttf_calibration_fit_flat(&calibration, &picture, 0.9, &err) < 0);
    assert_non_null(strstr(err.what, "saturated"));
    ttf_raw_sum_free(&picture);
}

/* A 14-bit packed DNG of a real camera; the oracle is LibRaw's own unpacking. */
static void a_real_dng_is_read_as_libraw_reads_it(void **state)
{
    const char *folder = data_folder("camera/colorchart-dng");
    char path[1200], command[2600];
    struct ttf_dng_info info;
    struct ttf_raw_sum raw;
    struct ttf_pixbuf seen;
    struct ttf_err err = {0};

    snprintf(path, sizeof(path), "%s/colorchart.dng", folder);
    if (ttf_dng_read(ttf_io_posix(), path, &raw, &info, &err) < 0)
        fail_msg("%s", err.what);
    assert_int_equal(raw.format.width, 1734); /* the active area of 1888 x 1182 */
    assert_int_equal(raw.format.height, 1156);
    assert_int_equal(raw.format.cfa, TTF_CFA_RGGB);
    assert_int_equal(raw.format.bits, 14);
    assert_int_equal(raw.format.black_level, 2056);
    assert_int_equal(raw.format.white_level, 15000);
    assert_string_equal(info.model, "Canon EOS Kiss X4");
    assert_float_equal(info.neutral[1], 2.477, 1e-3);
    assert_false(info.simulated);
    snprintf(command, sizeof(command),
             "cp '%s' '%s/c.dng' && cd '%s' && unprocessed_raw -T c.dng >/dev/null 2>&1", path,
             (const char *)*state, (const char *)*state);
    if (system(command) != 0) { /* NOLINT(cert-env33-c, concurrency-mt-unsafe) */
        print_message("unprocessed_raw (libraw-bin) is not installed\n");
        ttf_raw_sum_free(&raw);
        skip();
    }
    assert_int_equal(
        ttf_tiff_read(ttf_io_posix(), scratch_path(state, "c.dng.tiff"), 0, &seen, NULL), 0);
    assert_int_equal(seen.width, 1888);
    for (uint32_t y = 0; y < 1156; y++) {
        const uint16_t *row = (const uint16_t *)ttf_pixbuf_row(&seen, y + 26) + 152;

        for (uint32_t x = 0; x < 1734; x++)
            assert_int_equal(raw.sum[y * 1734 + x], row[x]);
    }
    ttf_pixbuf_free(&seen);
    ttf_raw_sum_free(&raw);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(real_exposures_develop_to_the_same_value),
        cmocka_unit_test(real_dark_frames_take_hot_pixels_away),
        cmocka_unit_test(a_picture_is_no_dark_frame),
        cmocka_unit_test_setup_teardown(a_real_dng_is_read_as_libraw_reads_it, scratch_make,
                                        scratch_remove),
    };

    return cmocka_run_group_tests_name("real_frames", tests, NULL, NULL);
}
