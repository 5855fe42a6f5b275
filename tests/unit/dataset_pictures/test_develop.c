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

#include "scratch.h"
#include "ttf/base/attr.h"
#include "ttf/dataset/develop.h"
#include "ttf/dataset/dng.h"
#include "ttf/dataset/hash.h"

#define W     97
#define H     71
#define BLACK 256
#define WHITE 4095

static const struct ttf_exposure settings = {10000000, 1000, 1000, 1000, 0};
static const struct ttf_encoding encoding = {TTF_PEDESTAL, TTF_SCALE};

static struct ttf_frame_format bayer(uint32_t width, uint32_t height, enum ttf_cfa cfa)
{
    return (struct ttf_frame_format){.width = width,
                                     .height = height,
                                     .stride = (size_t)width * 2,
                                     .packing = TTF_PACKING_RAW16,
                                     .cfa = cfa,
                                     .bits = 12,
                                     .black_level = BLACK,
                                     .white_level = WHITE};
}

/* A sum of n equal frames of these codes. */
static void sum_of(struct ttf_raw_sum *sum, const struct ttf_frame_format *format,
                   const void *codes, size_t bytes, unsigned n)
{
    struct ttf_frame frame = {
        .format = *format, .data = codes, .bytes = bytes, .settings = settings};

    assert_int_equal(ttf_raw_sum_init(sum, format), 0);
    for (unsigned i = 0; i < n; i++)
        assert_int_equal(ttf_raw_sum_add(sum, &frame), 0);
}

static void develop_all(const struct ttf_develop_config *config, const struct ttf_raw_sum *raw,
                        unsigned threads, struct ttf_pixbuf *ret,
                        struct ttf_image_figures *ret_figures)
{
    struct ttf_pool *pool = threads ? ttf_pool_create(threads) : NULL;
    struct ttf_develop *develop = NULL;
    struct ttf_err err = {0};

    if (ttf_develop_create(config, &develop, &err) < 0)
        fail_msg("%s", err.what);
    assert_int_equal(ttf_pixbuf_alloc(ret, ttf_develop_width(develop), ttf_develop_height(develop),
                                      3, TTF_SAMPLE_U16),
                     0);
    if (ttf_develop_run(develop, raw, pool, ret, ret_figures, &err) < 0)
        fail_msg("%s", err.what);
    ttf_develop_destroy(develop);
    ttf_pool_destroy(pool);
}

/* ---- the reference: one pixel at a time, in double, from the paper's figure ---- */

struct reference {
    const double *value; /* W x H corrected mosaic */
    uint32_t w, h;
    enum ttf_cfa cfa;
};

static int colour_at(enum ttf_cfa cfa, int x, int y)
{
    static const int patterns[TTF_CFA_COUNT][4] = {
        {0}, {0, 1, 1, 2}, {1, 0, 2, 1}, {1, 2, 0, 1}, {2, 1, 1, 0}};

    return patterns[cfa][(y & 1) * 2 + (x & 1)];
}

static double mosaic_at(const struct reference *ref, int x, int y)
{
    int w = (int)ref->w, h = (int)ref->h;

    x = x < 0 ? -x : x >= w ? 2 * (w - 1) - x : x;
    y = y < 0 ? -y : y >= h ? 2 * (h - 1) - y : y;
    return ref->value[y * w + x];
}

static double filtered(const struct reference *ref, int x, int y, const double kernel[5][5])
{
    double sum = 0.0;

    for (int j = 0; j < 5; j++) {
        for (int i = 0; i < 5; i++)
            sum += kernel[j][i] * mosaic_at(ref, x + i - 2, y + j - 2);
    }
    return sum / 8.0;
}

static double reference_at(const struct reference *ref, int x, int y, int colour)
{
    static const double green_at_other[5][5] = {
        {0, 0, -1, 0, 0}, {0, 0, 2, 0, 0}, {-1, 2, 4, 2, -1}, {0, 0, 2, 0, 0}, {0, 0, -1, 0, 0}};
    static const double along_row[5][5] = {{0, 0, 0.5, 0, 0},
                                           {0, -1, 0, -1, 0},
                                           {-1, 4, 5, 4, -1},
                                           {0, -1, 0, -1, 0},
                                           {0, 0, 0.5, 0, 0}};
    static const double along_column[5][5] = {{0, 0, -1, 0, 0},
                                              {0, -1, 4, -1, 0},
                                              {0.5, 0, 5, 0, 0.5},
                                              {0, -1, 4, -1, 0},
                                              {0, 0, -1, 0, 0}};
    static const double diagonal[5][5] = {{0, 0, -1.5, 0, 0},
                                          {0, 2, 0, 2, 0},
                                          {-1.5, 0, 6, 0, -1.5},
                                          {0, 2, 0, 2, 0},
                                          {0, 0, -1.5, 0, 0}};
    int here = colour_at(ref->cfa, x, y);

    if (here == colour)
        return mosaic_at(ref, x, y);
    if (colour == 1)
        return filtered(ref, x, y, green_at_other);
    if (here != 1)
        return filtered(ref, x, y, diagonal);
    return filtered(ref, x, y, colour_at(ref->cfa, x + 1, y) == colour ? along_row : along_column);
}

static int code_of(double value)
{
    double code = floor(value * TTF_SCALE + TTF_PEDESTAL + 0.5);

    return code < 0 ? 0 : code > 65535 ? 65535 : (int)code;
}

static void assert_near(int a, int b, int tolerance, int x, int y, int c)
{
    if (abs(a - b) > tolerance)
        fail_msg("at %d, %d, %d: %d is not %d", x, y, c, a, b);
}

/* All minimum, all maximum, noise, and a region at every parity. */
static void every_mosaic_and_parity_agrees_with_the_reference(void **state)
{
    static uint16_t codes[W * H];
    static double corrected[W * H];
    uint32_t seed = 7;

    for (int fill = 0; fill < 3; fill++) {
        for (int cfa = TTF_CFA_RGGB; cfa <= TTF_CFA_BGGR; cfa++) {
            struct ttf_frame_format format = bayer(W, H, (enum ttf_cfa)cfa);
            struct reference ref = {corrected, W, H, (enum ttf_cfa)cfa};
            struct ttf_raw_sum raw;

            for (int i = 0; i < W * H; i++) {
                codes[i] = fill == 0 ? 0 : fill == 1 ? 4095 : scratch_random(&seed) % 4096;
                corrected[i] = ((double)codes[i] - BLACK) / (WHITE - BLACK);
            }
            sum_of(&raw, &format, codes, sizeof(codes), 3);
            for (uint32_t shift = 0; shift < 4; shift++) {
                struct ttf_develop_config config = {
                    .format = format,
                    .encoding = encoding,
                    .region = {shift, shift / 2, W - 2 * shift, H - 5 * (shift / 2)}};
                struct ttf_pixbuf out;

                develop_all(&config, &raw, 0, &out, NULL);
                for (uint32_t y = 0; y < out.height; y++) {
                    const uint16_t *row = ttf_pixbuf_row(&out, y);

                    for (uint32_t x = 0; x < out.width; x++) {
                        for (int c = 0; c < 3; c++)
                            assert_near(row[3 * x + c],
                                        code_of(reference_at(&ref, (int)(x + shift),
                                                             (int)(y + shift / 2), c)),
                                        1, (int)x, (int)y, c);
                    }
                }
                ttf_pixbuf_free(&out);
            }
            ttf_raw_sum_free(&raw);
        }
    }
}

/* ---- what a capture relies on ---- */

/* A scene: even colour with a soft slope; linear in exposure. */
static double scene(unsigned x, unsigned y, int colour)
{
    static const double colours[3] = {0.3, 0.5, 0.2};

    return colours[colour] * (0.6 + 0.4 * x / W + 0.2 * y / H);
}

/* Response and vignetting of a camera, times exposure: codes above black. */
static double response(unsigned x, unsigned y, int colour)
{
    static const double colours[3] = {1500, 2800, 2000};
    double u = (double)x / W - 0.5, v = (double)y / H - 0.5;

    return colours[colour] * (1.0 - u * u - v * v);
}

static void shoot(struct ttf_raw_sum *sum, double exposure, double reflectance, unsigned n)
{
    static uint16_t codes[W * H];
    struct ttf_frame_format format = bayer(W, H, TTF_CFA_GRBG);
    struct ttf_frame frame = {
        .format = format, .data = codes, .bytes = sizeof(codes), .settings = settings};
    uint32_t seed = 1;

    frame.settings.exposure_ns = (int64_t)(1e7 * exposure);
    assert_int_equal(ttf_raw_sum_init(sum, &format), 0);
    for (unsigned k = 0; k < n; k++) {
        for (unsigned i = 0; i < W * H; i++) {
            unsigned x = i % W, y = i / W;
            int c = colour_at(TTF_CFA_GRBG, (int)x, (int)y);
            double value = reflectance > 0 ? reflectance : scene(x, y, c);
            /* dithered, so that averages know more than 12 bits */
            double dither = (scratch_random(&seed) % 1000) / 1000.0;

            codes[i] = (uint16_t)(BLACK + 3 + response(x, y, c) * value * exposure + dither);
        }
        assert_int_equal(ttf_raw_sum_add(sum, &frame), 0);
    }
}

static void calibrate(struct ttf_calibration *calibration)
{
    struct ttf_raw_sum dark, flat;
    struct ttf_err err = {0};

    ttf_calibration_init(calibration);
    shoot(&dark, 1e-9, 1e-9, 32);
    shoot(&flat, 1.0, 0.9, 32);
    if (ttf_calibration_fit_dark(calibration, &dark, &err) < 0 ||
        ttf_calibration_fit_flat(calibration, &flat, 0.9, &err) < 0)
        fail_msg("%s", err.what);
    ttf_raw_sum_free(&dark);
    ttf_raw_sum_free(&flat);
}

static void a_calibrated_frame_is_the_scene_whatever_the_exposure(void **state)
{
    static const double exposures[] = {0.25, 0.5, 1.0, 1.6};
    struct ttf_calibration calibration;

    calibrate(&calibration);
    for (unsigned e = 0; e < TTF_COUNT_OF(exposures); e++) {
        struct ttf_develop_config config = {
            .format = bayer(W, H, TTF_CFA_GRBG), .calibration = &calibration, .encoding = encoding};
        struct ttf_image_figures figures;
        struct ttf_raw_sum raw;
        struct ttf_pixbuf out;
        double error = 0;

        shoot(&raw, exposures[e], 0, 16);
        develop_all(&config, &raw, 2, &out, &figures);
        for (unsigned y = 0; y < H; y++) {
            for (unsigned x = 0; x < W; x++) {
                for (int c = 0; c < 3; c++) {
                    double code = ((uint16_t *)ttf_pixbuf_row(&out, y))[3 * x + (unsigned)c];

                    error +=
                        fabs((code - TTF_PEDESTAL) / TTF_SCALE - scene(x, y, c)) / (3.0 * W * H);
                }
            }
        }
        if (error > 1e-3)
            fail_msg("at exposure %g the mean error is %g", exposures[e], error);
        assert_float_equal(figures.mean_level, (0.3 + 0.5 + 0.2) / 3 * 0.9, 3e-3);
        assert_float_equal(figures.saturated, 0.0, 0.0);
        ttf_pixbuf_free(&out);
        ttf_raw_sum_free(&raw);
    }
    ttf_calibration_free(&calibration);
}

static void without_a_flat_full_scale_is_one(void **state)
{
    static uint16_t codes[W * H];
    struct ttf_frame_format format = bayer(W, H, TTF_CFA_RGGB);
    struct ttf_develop_config config = {.format = format, .encoding = encoding};
    struct ttf_image_figures figures;
    struct ttf_raw_sum raw;
    struct ttf_pixbuf out;
    const int bright = W * H / 4;
    double share;

    for (int i = 0; i < W * H; i++)
        codes[i] = i < bright ? WHITE : BLACK;
    sum_of(&raw, &format, codes, sizeof(codes), 1);
    develop_all(&config, &raw, 0, &out, &figures);
    share = bright / (double)(W * H);
    assert_int_equal(((uint16_t *)out.data)[0], TTF_PEDESTAL + TTF_SCALE);
    assert_int_equal(((uint16_t *)ttf_pixbuf_row(&out, H - 1))[5], TTF_PEDESTAL);
    assert_float_equal(figures.saturated, share, 1e-7);
    assert_float_equal(figures.mean_level, 0.25, 0.01);
    ttf_pixbuf_free(&out);
    ttf_raw_sum_free(&raw);
}

static void hot_pixels_leave_no_trace(void **state)
{
    struct ttf_hot_pixel hot[] = {{0, 0},   {50, 30}, {52, 30}, {51, 31},
                                  {50, 32}, {96, 63}, {40, 64}, {96, 70}};
    struct ttf_calibration calibration;
    struct ttf_develop_config config = {
        .format = bayer(W, H, TTF_CFA_GRBG), .calibration = &calibration, .encoding = encoding};
    struct ttf_pixbuf clean, mended;
    struct ttf_raw_sum raw;

    calibrate(&calibration);
    shoot(&raw, 1.0, 0.5, 8);
    develop_all(&config, &raw, 0, &clean, NULL);
    for (unsigned i = 0; i < TTF_COUNT_OF(hot); i++)
        raw.sum[hot[i].y * W + hot[i].x] = WHITE * 8;
    free(calibration.hot);
    calibration.hot = hot;
    calibration.n_hot = TTF_COUNT_OF(hot);
    develop_all(&config, &raw, 0, &mended, NULL);
    for (unsigned i = 0; i < W * H * 3; i++)
        assert_near(((uint16_t *)mended.data)[i], ((uint16_t *)clean.data)[i], TTF_SCALE / 200,
                    (int)(i / 3 % W), (int)(i / 3 / W), (int)(i % 3));
    calibration.hot = NULL;
    calibration.n_hot = 0;
    ttf_calibration_free(&calibration);
    ttf_pixbuf_free(&clean);
    ttf_pixbuf_free(&mended);
    ttf_raw_sum_free(&raw);
}

/* Threads, regions, TIFF by strips: all the same bits. On 300 rows, so that there are several chunks. */
static void the_same_bits_come_however_it_is_cut(void **state)
{
    enum {
        BW = 180,
        BH = 300
    };
    static uint16_t codes[BW * BH];
    struct ttf_hot_pixel hot[400];
    struct ttf_frame_format format = bayer(BW, BH, TTF_CFA_BGGR);
    struct ttf_calibration calibration;
    struct ttf_develop_config config = {
        .format = format, .calibration = &calibration, .encoding = encoding};
    struct ttf_image_figures figures, others;
    struct ttf_pixbuf whole, part, view, file_back;
    struct ttf_tiff_times times = {.start_utc_ns = 0, .exposure_ns = 5};
    struct ttf_io *io = ttf_io_posix();
    struct ttf_develop *develop = NULL;
    struct ttf_raw_sum raw;
    uint32_t seed = 5;
    int file;

    for (int i = 0; i < BW * BH; i++)
        codes[i] = (uint16_t)(scratch_random(&seed) % 4096);
    for (unsigned i = 0; i < 400; i++) /* dense: their neighbours are hot as well */
        hot[i] = (struct ttf_hot_pixel){(uint16_t)(2 * (i % 8) + 20 + i % 3 / 2),
                                        (uint16_t)(20 + i / 8)};
    ttf_calibration_init(&calibration);
    calibration.hot = hot;
    calibration.n_hot = 400;
    calibration.colour_matrix[1] = -0.3;
    calibration.colour_matrix[8] = 1.3;
    sum_of(&raw, &format, codes, sizeof(codes), 1);
    develop_all(&config, &raw, 0, &whole, &figures);
    for (unsigned threads = 1; threads <= 4; threads++) {
        develop_all(&config, &raw, threads, &part, &others);
        assert_memory_equal(whole.data, part.data, sizeof(uint16_t) * 3 * BW * BH);
        assert_memory_equal(&figures, &others, sizeof(figures));
        ttf_pixbuf_free(&part);
    }
    assert_int_equal(ttf_develop_create(&config, &develop, NULL), 0);
    file = scratch_create(state, "d.tif");
    assert_int_equal(ttf_develop_tiff(develop, &raw, NULL, &times, io, file, &others, NULL), 0);
    assert_int_equal(io->ops->close(io, file), 0);
    ttf_develop_destroy(develop);
    assert_memory_equal(&figures, &others, sizeof(figures));
    assert_int_equal(ttf_tiff_read(io, scratch_path(state, "d.tif"), 0, &file_back, NULL), 0);
    assert_memory_equal(whole.data, file_back.data, sizeof(uint16_t) * 3 * BW * BH);
    for (uint32_t shift = 1; shift < 40; shift += 7) {
        config.region = (struct ttf_region){shift, shift + 3, BW - 2 * shift, BH - 3 * shift - 3};
        develop_all(&config, &raw, 0, &part, NULL);
        assert_int_equal(
            ttf_pixbuf_view(&whole, shift, shift + 3, BW - 2 * shift, BH - 3 * shift - 3, &view),
            0);
        for (uint32_t y = 0; y < part.height; y++)
            assert_memory_equal(ttf_pixbuf_row(&part, y), ttf_pixbuf_row(&view, y), part.width * 6);
        ttf_pixbuf_free(&part);
    }
    ttf_pixbuf_free(&whole);
    ttf_pixbuf_free(&file_back);
    ttf_raw_sum_free(&raw);
}

static void finished_pictures_are_taken_as_srgb(void **state)
{
    static const uint8_t rgb[2 * 4 * 3] = {0,   1,   2,  255, 254, 253, 128, 64, 32, 10, 20, 30,
                                           200, 100, 50, 90,  80,  70,  3,   2,  1,  9,  99, 199};
    static const uint8_t grey[8] = {0, 1, 2, 50, 100, 150, 200, 255};
    static const uint8_t yuyv[8] = {16, 128, 235, 128,
                                    81, 90,  81,  240}; /* black, white, red, red */
    static const struct ttf_encoding imported = {0, 65535};
    struct ttf_frame_format format = {
        .width = 4, .height = 2, .stride = 12, .packing = TTF_PACKING_RGB8, .bits = 8};
    struct ttf_develop_config config = {.format = format, .encoding = imported};
    struct ttf_raw_sum raw;
    struct ttf_pixbuf out;

    sum_of(&raw, &format, rgb, sizeof(rgb), 5);
    develop_all(&config, &raw, 0, &out, NULL);
    for (unsigned i = 0; i < 24; i++) {
        assert_int_equal(((uint16_t *)out.data)[i], ttf_srgb8_to_linear16(rgb[i]));
        assert_int_equal(ttf_linear16_to_srgb8(((uint16_t *)out.data)[i]), rgb[i]);
    }
    ttf_pixbuf_free(&out);
    ttf_raw_sum_free(&raw);
    format.packing = TTF_PACKING_GREY8;
    format.stride = 4;
    config.format = format;
    sum_of(&raw, &format, grey, sizeof(grey), 1);
    develop_all(&config, &raw, 0, &out, NULL);
    for (unsigned i = 0; i < 24; i++)
        assert_int_equal(((uint16_t *)out.data)[i], ttf_srgb8_to_linear16(grey[i / 3]));
    ttf_pixbuf_free(&out);
    ttf_raw_sum_free(&raw);
    format.packing = TTF_PACKING_YUYV8;
    format.height = 1;
    format.stride = 8;
    config.format = format;
    sum_of(&raw, &format, yuyv, sizeof(yuyv), 1);
    develop_all(&config, &raw, 0, &out, NULL);
    for (unsigned c = 0; c < 3; c++) {
        assert_int_equal(((uint16_t *)out.data)[c], 0);
        assert_int_equal(((uint16_t *)out.data)[3 + c], 65535);
    }
    /* 75 % red of BT.601's colour bars has Y 65, 81 is full red: 254, 0, 0. */
    assert_in_range(ttf_linear16_to_srgb8(((uint16_t *)out.data)[6]), 253, 255);
    assert_in_range(ttf_linear16_to_srgb8(((uint16_t *)out.data)[7]), 0, 1);
    assert_in_range(ttf_linear16_to_srgb8(((uint16_t *)out.data)[8]), 0, 1);
    ttf_pixbuf_free(&out);
    ttf_raw_sum_free(&raw);
}

static void a_sharper_picture_has_more_sharpness(void **state)
{
    static uint16_t codes[W * H];
    struct ttf_frame_format format = bayer(W, H, TTF_CFA_NONE);
    struct ttf_develop_config config = {.format = format, .encoding = encoding};
    double before = 1e9;

    for (int blur = 1; blur <= 8; blur *= 2) {
        struct ttf_image_figures figures;
        struct ttf_raw_sum raw;
        struct ttf_pixbuf out;

        for (int i = 0; i < W * H; i++)
            codes[i] = (uint16_t)(1500 + 800 * sin((double)(i % W) / blur));
        sum_of(&raw, &format, codes, sizeof(codes), 1);
        develop_all(&config, &raw, 0, &out, &figures);
        assert_true(figures.sharpness > 0 && figures.sharpness < before / 1.5);
        before = figures.sharpness;
        ttf_pixbuf_free(&out);
        ttf_raw_sum_free(&raw);
    }
}

static void wrong_configurations_are_refused(void **state)
{
    struct ttf_calibration calibration;
    struct ttf_develop *develop = NULL;
    struct ttf_err err = {0};
    struct ttf_develop_config config = {
        .format = bayer(W, H, TTF_CFA_GRBG), .encoding = encoding, .region = {90, 0, 8, 8}};

    assert_int_equal(ttf_develop_create(&config, &develop, &err), -EINVAL);
    assert_string_equal(err.where, "region");
    config.region = (struct ttf_region){0};
    calibrate(&calibration);
    config.calibration = &calibration;
    config.format.width = W - 1;
    assert_int_equal(ttf_develop_create(&config, &develop, &err), -EINVAL);
    assert_non_null(strstr(err.what, "97 x 71"));
    config.format = bayer(W, H, TTF_CFA_GRBG);
    config.format.black_level = 64;
    assert_int_equal(ttf_develop_create(&config, &develop, &err), -EINVAL);
    assert_non_null(strstr(err.what, "levels"));
    config.format.packing = TTF_PACKING_COUNT;
    assert_int_equal(ttf_develop_create(&config, &develop, &err), -ENOTSUP);
    ttf_calibration_free(&calibration);
}

static void regions_encodings_and_mosaics_that_cannot_be_are_refused(void **state)
{
    static const struct ttf_region outside[] = {
        {0, 0, 8, 0},          {W, 0, 1, 1},         {0, H, 1, 1}, {0, 0, W + 1, 1},
        {0, 0, 1, H + 1},      {1, 0, W, H},         {0, 1, W, H}, {UINT32_MAX, 0, 2, 2},
        {0, UINT32_MAX, 2, 2}, {2, 2, UINT32_MAX, 2}};
    static const struct ttf_encoding none[] = {{0, 0},        {0, -1},      {0, 2e9},  {0, NAN},
                                               {-1, 60000.0}, {65536, 1.0}, {NAN, 1.0}};
    struct ttf_develop *develop = NULL;
    struct ttf_err err = {0};

    for (unsigned i = 0; i < TTF_COUNT_OF(outside); i++) {
        struct ttf_develop_config config = {
            .format = bayer(W, H, TTF_CFA_GRBG), .encoding = encoding, .region = outside[i]};

        if (ttf_develop_create(&config, &develop, &err) != -EINVAL)
            fail_msg("region %u", i);
        assert_string_equal(err.where, "region");
    }
    for (unsigned i = 0; i < TTF_COUNT_OF(none); i++) {
        struct ttf_develop_config config = {.format = bayer(W, H, TTF_CFA_GRBG),
                                            .encoding = none[i]};

        if (ttf_develop_create(&config, &develop, &err) != -EINVAL)
            fail_msg("encoding %u", i);
        assert_string_equal(err.where, "encoding");
    }
    for (uint32_t side = 3; side <= 4; side++) {
        struct ttf_develop_config wide = {.format = bayer(8, side, TTF_CFA_RGGB),
                                          .encoding = encoding};
        struct ttf_develop_config high = {.format = bayer(side, 8, TTF_CFA_RGGB),
                                          .encoding = encoding};

        assert_int_equal(ttf_develop_create(&wide, &develop, &err), side < 4 ? -EINVAL : 0);
        if (side == 4)
            ttf_develop_destroy(develop);
        assert_int_equal(ttf_develop_create(&high, &develop, &err), side < 4 ? -EINVAL : 0);
        if (side == 4)
            ttf_develop_destroy(develop);
    }
    assert_null(strstr(err.what, "region"));
}

/* What a camera sends after its mode was changed behind one's back must not be developed as if nothing were. */
static void frames_of_another_format_are_refused(void **state)
{
    const struct ttf_frame_format format = bayer(W, H, TTF_CFA_GRBG);
    const struct ttf_develop_config config = {.format = format, .encoding = encoding};
    static const uint16_t codes[W * H];
    struct ttf_develop *develop = NULL;
    struct ttf_pixbuf out = {0};
    struct ttf_err err = {0};
    struct ttf_raw_sum sum;

    assert_int_equal(ttf_develop_create(&config, &develop, &err), 0);
    assert_int_equal(ttf_pixbuf_alloc(&out, W, H, 3, TTF_SAMPLE_U16), 0);
    sum_of(&sum, &format, codes, sizeof(codes), 1);
    for (unsigned i = 0; i < 9; i++) {
        struct ttf_raw_sum other = sum;

        other.format.width -= i == 0;
        other.format.height -= i == 1;
        other.format.cfa = i == 2 ? TTF_CFA_RGGB : format.cfa;
        other.format.packing = i == 3 ? TTF_PACKING_RAW10P : format.packing;
        other.format.black_level += i == 4;
        other.format.white_level -= i == 5;
        other.samples = i == 6 ? 3 : other.samples;
        other.n = i == 7 ? 0 : 1;
        if (ttf_develop_run(develop, &other, NULL, &out, NULL, &err) != (i == 8 ? 0 : -EINVAL))
            fail_msg("change %u", i);
    }
    ttf_raw_sum_free(&sum);
    ttf_pixbuf_free(&out);
    ttf_develop_destroy(develop);
}

/* A frame that needs every step, and the checksum that every compiler and machine must come to. */
static void the_bits_are_those_of_every_machine(void **state)
{
    static const struct ttf_hot_pixel hot[] = {{3, 3}, {5, 3}, {40, 20}};
    struct ttf_calibration calibration;
    struct ttf_develop_config config = {
        .format = bayer(W, H, TTF_CFA_GRBG), .calibration = &calibration, .encoding = encoding};
    struct ttf_pixbuf out;
    struct ttf_raw_sum raw;
    uint32_t seed = 2024;

    ttf_calibration_init(&calibration);
    calibration.width = W;
    calibration.height = H;
    calibration.cfa = TTF_CFA_GRBG;
    calibration.black_level = BLACK;
    calibration.white_level = WHITE;
    calibration.has_dark = calibration.has_flat = true;
    calibration.dark_offset_16 = calloc(W * H, sizeof(int32_t));
    calibration.flat_gain = calloc(W * H, sizeof(uint16_t));
    calibration.hot = calloc(3, sizeof(hot[0]));
    assert_true(calibration.dark_offset_16 && calibration.flat_gain && calibration.hot);
    memcpy(calibration.hot, hot, sizeof(hot));
    calibration.n_hot = 3;
    calibration.flat_settings = settings;
    calibration.flat_level = 2345.678;
    for (int i = 0; i < 9; i++)
        calibration.colour_matrix[i] = (i % 4 == 0 ? 1.3 : -0.15) + i * 0.01;
    assert_int_equal(ttf_raw_sum_init(&raw, &config.format), 0);
    raw.n = 3;
    raw.settings = settings;
    raw.settings.exposure_ns = 7654321;
    for (unsigned i = 0; i < W * H; i++) {
        raw.sum[i] = scratch_random(&seed) % (3 * 4096);
        calibration.dark_offset_16[i] = (int32_t)(scratch_random(&seed) % 100) - 50;
        calibration.flat_gain[i] = (uint16_t)(8192 + scratch_random(&seed) % 40000);
    }
    develop_all(&config, &raw, 2, &out, NULL);
    for (unsigned i = 0; i < W * H * 3; i++) { /* little-endian, as in a file */
        uint16_t code = ((uint16_t *)out.data)[i];
        uint8_t *bytes = (uint8_t *)out.data + 2 * (size_t)i;

        bytes[0] = (uint8_t)code;
        bytes[1] = (uint8_t)(code >> 8);
    }
    assert_int_equal(ttf_crc32(0, out.data, (size_t)W * H * 6), 0x90f13623);
    ttf_calibration_free(&calibration);
    ttf_pixbuf_free(&out);
    ttf_raw_sum_free(&raw);
}

/* A raw file that is developed later gives what was developed at once; of an average to half a 16-bit code. */
static void a_dng_develops_to_the_same_picture(void **state)
{
    for (unsigned n = 1; n <= 8; n += 7) {
        struct ttf_dng_info info = {.times = {.start_utc_ns = TTF_NS_UNKNOWN}};
        struct ttf_io *io = ttf_io_posix();
        struct ttf_calibration calibration;
        struct ttf_develop_config config = {
            .format = bayer(W, H, TTF_CFA_GRBG), .calibration = &calibration, .encoding = encoding};
        struct ttf_raw_sum raw, back;
        struct ttf_pixbuf direct, later;
        int file = scratch_create(state, "a.dng");

        calibrate(&calibration);
        shoot(&raw, 0.7, 0, n);
        assert_int_equal(ttf_dng_write(&raw, &info, io, file, NULL), 0);
        assert_int_equal(io->ops->close(io, file), 0);
        assert_int_equal(ttf_dng_read(io, scratch_path(state, "a.dng"), &back, NULL, NULL), 0);
        develop_all(&config, &raw, 0, &direct, NULL);
        config.format = back.format;
        develop_all(&config, &back, 0, &later, NULL);
        for (unsigned i = 0; i < W * H * 3; i++)
            assert_near(((uint16_t *)direct.data)[i], ((uint16_t *)later.data)[i], n == 1 ? 0 : 4,
                        (int)(i / 3 % W), (int)(i / 3 / W), (int)(i % 3));
        ttf_calibration_free(&calibration);
        ttf_pixbuf_free(&direct);
        ttf_pixbuf_free(&later);
        ttf_raw_sum_free(&raw);
        ttf_raw_sum_free(&back);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_mosaic_and_parity_agrees_with_the_reference),
        cmocka_unit_test(a_calibrated_frame_is_the_scene_whatever_the_exposure),
        cmocka_unit_test(without_a_flat_full_scale_is_one),
        cmocka_unit_test(hot_pixels_leave_no_trace),
        cmocka_unit_test_setup_teardown(the_same_bits_come_however_it_is_cut, scratch_make,
                                        scratch_remove),
        cmocka_unit_test(finished_pictures_are_taken_as_srgb),
        cmocka_unit_test(a_sharper_picture_has_more_sharpness),
        cmocka_unit_test(wrong_configurations_are_refused),
        cmocka_unit_test(regions_encodings_and_mosaics_that_cannot_be_are_refused),
        cmocka_unit_test(frames_of_another_format_are_refused),
        cmocka_unit_test(the_bits_are_those_of_every_machine),
        cmocka_unit_test_setup_teardown(a_dng_develops_to_the_same_picture, scratch_make,
                                        scratch_remove),
    };

    return cmocka_run_group_tests_name("develop", tests, NULL, NULL);
}
