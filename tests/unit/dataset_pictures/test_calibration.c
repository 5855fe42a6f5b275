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
#include <unistd.h>

#include "scratch.h"
#include "ttf/dataset/calibration.h"

#define W     160
#define H     96
#define BLACK 256
#define WHITE 4095

static uint16_t codes[W * H];

static const struct ttf_frame_format format = {.width = W,
                                               .height = H,
                                               .stride = (size_t)W * 2,
                                               .packing = TTF_PACKING_RAW16,
                                               .cfa = TTF_CFA_RGGB,
                                               .bits = 12,
                                               .black_level = BLACK,
                                               .white_level = WHITE};

static void add(struct ttf_raw_sum *sum)
{
    struct ttf_frame frame = {.format = format,
                              .data = codes,
                              .bytes = sizeof(codes),
                              .settings = {10000000, 1000, 1000, 1000, 0}};

    assert_int_equal(ttf_raw_sum_add(sum, &frame), 0);
}

/* n dark frames: an offset of 2.5 codes on the right half, noise of +-2 codes, five hot pixels. */
static const unsigned hot_at[] = {5, 777, 778, 5000, W *H - 1};

static void make_dark(struct ttf_raw_sum *sum, unsigned n, unsigned level)
{
    uint32_t seed = 3;

    assert_int_equal(ttf_raw_sum_init(sum, &format), 0);
    for (unsigned k = 0; k < n; k++) {
        for (unsigned i = 0; i < W * H; i++)
            codes[i] = (uint16_t)(BLACK + level + (i % W >= W / 2 ? 2 + k % 2 : 0) +
                                  scratch_random(&seed) % 5 - 2);
        for (unsigned i = 0; i < 5; i++)
            codes[hot_at[i]] = (uint16_t)(BLACK + 300 + 100 * i);
        add(sum);
    }
}

/* A target under vignetting, colours 1 : 2 : 1.5, the dark pattern below it. */
static double flat_signal(unsigned x, unsigned y)
{
    static const double colours[4] = {600, 1200, 1200, 900};
    double u = (double)x / W - 0.5, v = (double)y / H - 0.5;

    return colours[(y % 2) * 2 + x % 2] * (1.2 - u * u - v * v);
}

static void make_flat(struct ttf_raw_sum *sum, unsigned n, double scale)
{
    assert_int_equal(ttf_raw_sum_init(sum, &format), 0);
    for (unsigned i = 0; i < W * H; i++) {
        double code = BLACK + flat_signal(i % W, i / W) * scale + (i % W >= W / 2 ? 2.5 : 0);

        codes[i] = (uint16_t)(code > WHITE ? WHITE : code + 0.5);
    }
    for (unsigned k = 0; k < n; k++)
        add(sum);
}

static void dark_frames_give_offsets_and_hot_pixels(void **state)
{
    struct ttf_calibration calibration;
    struct ttf_raw_sum dark;
    struct ttf_err err = {0};
    double left = 0, right = 0;

    ttf_calibration_init(&calibration);
    make_dark(&dark, 16, 0);
    if (ttf_calibration_fit_dark(&calibration, &dark, &err) < 0)
        fail_msg("%s", err.what);
    assert_true(calibration.has_dark);
    assert_int_equal(calibration.dark_frames, 16);
    assert_int_equal(calibration.dark_settings.exposure_ns, 10000000);
    assert_int_equal(calibration.n_hot, 5);
    for (unsigned i = 0; i < 5; i++)
        assert_int_equal(calibration.hot[i].y * W + calibration.hot[i].x, hot_at[i]);
    for (unsigned i = W; i < 2 * W; i++) {
        if (i % W < W / 2)
            left += calibration.dark_offset_16[i] / 16.0 / (W / 2.0);
        else
            right += calibration.dark_offset_16[i] / 16.0 / (W / 2.0);
    }
    assert_float_equal(left, 0.0, 0.2);
    assert_float_equal(right, 2.5, 0.2);
    ttf_raw_sum_free(&dark);
    ttf_calibration_free(&calibration);
}

static void dark_frames_that_are_not_dark_are_refused_with_the_reason(void **state)
{
    struct ttf_calibration calibration;
    struct ttf_raw_sum dark;
    struct ttf_err err = {0};

    ttf_calibration_init(&calibration);
    make_dark(&dark, 2, 400);
    assert_int_equal(ttf_calibration_fit_dark(&calibration, &dark, &err), -EINVAL);
    assert_non_null(strstr(err.what, "not dark"));
    assert_non_null(strstr(err.what, "10.5 %"));
    assert_non_null(strstr(err.hint, "lamps"));
    assert_false(calibration.has_dark);
    ttf_raw_sum_reset(&dark);
    assert_int_equal(ttf_calibration_fit_dark(&calibration, &dark, &err), -EINVAL);
    assert_non_null(strstr(err.what, "no dark frames"));
    /* A leak of light in one corner. */
    for (unsigned i = 0; i < W * H; i++)
        codes[i] = (uint16_t)(BLACK + (i % W < 20 && i / W < 20 ? 90 : i % 3));
    add(&dark);
    assert_int_equal(ttf_calibration_fit_dark(&calibration, &dark, &err), -EINVAL);
    assert_non_null(strstr(err.what, "not dark everywhere"));
    ttf_raw_sum_free(&dark);
    ttf_calibration_free(&calibration);
}

static void fit_both(struct ttf_calibration *calibration)
{
    struct ttf_raw_sum dark, flat;
    struct ttf_err err = {0};

    ttf_calibration_init(calibration);
    snprintf(calibration->camera, sizeof(calibration->camera), "main");
    calibration->simulated = true;
    make_dark(&dark, 16, 0);
    make_flat(&flat, 4, 1.0);
    if (ttf_calibration_fit_dark(calibration, &dark, &err) < 0 ||
        ttf_calibration_fit_flat(calibration, &flat, 0.8, &err) < 0)
        fail_msg("%s", err.what);
    ttf_raw_sum_free(&dark);
    ttf_raw_sum_free(&flat);
}

/* What the gains are for: signal x gain is flat_level x reflectance, at every pixel and colour. */
static void a_flat_makes_all_pixels_alike(void **state)
{
    struct ttf_calibration calibration;

    fit_both(&calibration);
    for (unsigned i = 0; i < W * H; i++) {
        double signal =
            floor(flat_signal(i % W, i / W) + BLACK + (i % W >= W / 2 ? 2.5 : 0) + 0.5) - BLACK -
            calibration.dark_offset_16[i] / 16.0;
        double out = signal * calibration.flat_gain[i] / 16384.0;
        bool hot = false;

        for (unsigned k = 0; k < 5; k++)
            hot = hot || hot_at[k] == i;
        if (!hot && fabs(out / (calibration.flat_level * 0.8) - 1) > 1e-3)
            fail_msg("pixel %u: %g", i, out / (calibration.flat_level * 0.8));
    }
    assert_float_equal(calibration.flat_reflectance, 0.8, 0);
    ttf_calibration_free(&calibration);
}

static void dead_pixels_join_the_list(void **state)
{
    struct ttf_calibration calibration;
    struct ttf_raw_sum flat;

    ttf_calibration_init(&calibration);
    make_flat(&flat, 1, 1.0);
    flat.sum[1234] = BLACK;
    flat.sum[4321] = BLACK + 3;
    assert_int_equal(ttf_calibration_fit_flat(&calibration, &flat, 0.9, NULL), 0);
    assert_int_equal(calibration.n_hot, 2);
    assert_int_equal(calibration.hot[0].y * W + calibration.hot[0].x, 1234);
    ttf_raw_sum_free(&flat);
    ttf_calibration_free(&calibration);
}

static void assert_flat_refused(double scale, double reflectance, const char *reason)
{
    struct ttf_calibration calibration;
    struct ttf_raw_sum flat;
    struct ttf_err err = {0};

    ttf_calibration_init(&calibration);
    make_flat(&flat, 1, scale);
    assert_int_equal(ttf_calibration_fit_flat(&calibration, &flat, reflectance, &err), -EINVAL);
    if (!strstr(err.what, reason))
        fail_msg("'%s' does not say '%s'", err.what, reason);
    assert_false(calibration.has_flat);
    assert_int_equal(calibration.width, 0);
    ttf_raw_sum_free(&flat);
    ttf_calibration_free(&calibration);
}

static void useless_flats_are_refused_with_the_reason(void **state)
{
    struct ttf_calibration calibration;
    struct ttf_raw_sum flat;
    struct ttf_err err = {0};

    assert_flat_refused(4.0, 0.9, "saturated");
    assert_flat_refused(0.05, 0.9, "too dark");
    assert_flat_refused(1.0, 1.5, "reflectance");
    assert_flat_refused(1.0, NAN, "reflectance");
    ttf_calibration_init(&calibration);
    make_flat(&flat, 1, 1.0);
    for (unsigned i = 0; i < W * H; i++)
        flat.sum[i] = i % W < 64 ? BLACK + 100 : BLACK + 1500;
    assert_int_equal(ttf_calibration_fit_flat(&calibration, &flat, 0.9, &err), -EINVAL);
    assert_non_null(strstr(err.what, "uneven"));
    ttf_raw_sum_free(&flat);
    fit_both(&calibration);
    make_flat(&flat, 1, 1.0);
    flat.format.black_level = 64;
    assert_int_equal(ttf_calibration_fit_flat(&calibration, &flat, 0.9, &err), -EINVAL);
    assert_non_null(strstr(err.what, "another camera mode"));
    ttf_raw_sum_free(&flat);
    ttf_calibration_free(&calibration);
}

/* The dead pixels that a flat finds stay known, and its gains are of the dark that was there. */
static void a_dark_comes_before_the_flat_or_not_at_all(void **state)
{
    struct ttf_calibration calibration;
    struct ttf_raw_sum dark, flat;
    struct ttf_err err = {0};

    ttf_calibration_init(&calibration);
    make_flat(&flat, 1, 1.0);
    flat.sum[1234] = BLACK;
    assert_int_equal(ttf_calibration_fit_flat(&calibration, &flat, 0.9, NULL), 0);
    make_dark(&dark, 16, 0);
    assert_int_equal(ttf_calibration_fit_dark(&calibration, &dark, &err), -EINVAL);
    assert_non_null(strstr(err.hint, "the dark first"));
    assert_false(calibration.has_dark);
    assert_int_equal(calibration.n_hot, 1);
    ttf_raw_sum_free(&dark);
    ttf_raw_sum_free(&flat);
    ttf_calibration_free(&calibration);
}

/* A flat of one code everywhere, of a camera of 8 bits. */
static int fit_even_flat(uint16_t code)
{
    struct ttf_frame_format narrow = format;
    struct ttf_frame frame = {
        .data = codes, .bytes = sizeof(codes), .settings = {10000000, 1000, 1000, 1000, 0}};
    struct ttf_calibration calibration;
    struct ttf_raw_sum flat;
    int r;

    narrow.bits = 8;
    narrow.black_level = 16;
    narrow.white_level = 255;
    frame.format = narrow;
    for (unsigned i = 0; i < W * H; i++)
        codes[i] = code;
    assert_int_equal(ttf_raw_sum_init(&flat, &narrow), 0);
    assert_int_equal(ttf_raw_sum_add(&flat, &frame), 0);
    ttf_calibration_init(&calibration);
    r = ttf_calibration_fit_flat(&calibration, &flat, 0.9, NULL);
    ttf_raw_sum_free(&flat);
    ttf_calibration_free(&calibration);
    return r;
}

static void full_scale_is_98_percent_of_few_codes_too(void **state)
{
    assert_int_equal(fit_even_flat(16 + 230), 0);       /* 96 % of 239 */
    assert_int_equal(fit_even_flat(16 + 236), -EINVAL); /* 99 % */
}

static void frames_that_do_not_fit_are_refused(void **state)
{
    struct ttf_raw_sum sum;
    struct ttf_frame frame = {.format = format, .data = codes, .bytes = sizeof(codes)};
    struct ttf_frame_format other = format;

    assert_int_equal(ttf_raw_sum_init(&sum, &format), 0);
    frame.bytes--;
    assert_int_equal(ttf_raw_sum_add(&sum, &frame), -EINVAL);
    frame.bytes++;
    frame.format.width--;
    assert_int_equal(ttf_raw_sum_add(&sum, &frame), -EINVAL);
    frame.format.width++;
    frame.format.stride = SIZE_MAX - 1;
    assert_int_equal(ttf_raw_sum_add(&sum, &frame), -EINVAL);
    for (unsigned i = 0; i < 9; i++) { /* each alone would make the mean of it a lie */
        frame.format = format;
        frame.data = i == 0 ? NULL : codes;
        frame.format.stride += i == 1; /* words at odd addresses */
        frame.format.height -= i == 2;
        frame.format.packing = i == 3 ? TTF_PACKING_GREY8 : format.packing;
        frame.format.cfa = i == 4 ? TTF_CFA_BGGR : format.cfa;
        frame.format.bits -= i == 5;
        frame.format.black_level += i == 6;
        frame.format.white_level -= i == 7;
        if (ttf_raw_sum_add(&sum, &frame) != (i == 8 ? 0 : -EINVAL))
            fail_msg("change %u", i);
    }
    assert_int_equal(sum.n, 1);
    ttf_raw_sum_free(&sum);
    other.packing = TTF_PACKING_NONE;
    assert_int_equal(ttf_raw_sum_init(&sum, &other), -ENOTSUP);
    other = format;
    other.width = 0;
    assert_int_equal(ttf_raw_sum_init(&sum, &other), -EINVAL);
}

/* ---- its folder ---- */

static void save(void **state, const struct ttf_calibration *calibration)
{
    struct ttf_err err = {0};

    if (ttf_calibration_save(calibration, ttf_io_posix(), scratch_path(state, "cal"), &err) < 0)
        fail_msg("%s", err.what);
}

static void a_calibration_comes_back_from_its_folder(void **state)
{
    struct ttf_calibration calibration, back;
    struct ttf_err err = {0};
    char id[64];

    fit_both(&calibration);
    calibration.dark_temp_mdegc = -1500;
    calibration.colour_matrix[1] = -0.1234567890123;
    assert_int_equal(ttf_calibration_name(&calibration, NULL), 0);
    save(state, &calibration);
    save(state, &calibration); /* again, over it */
    if (ttf_calibration_load(ttf_io_posix(), scratch_path(state, "cal"), &back, &err) < 0)
        fail_msg("%s: %s", err.where, err.what);
    assert_string_equal(back.id, calibration.id);
    assert_string_equal(back.camera, "main");
    assert_true(back.simulated);
    assert_int_equal(back.width, W);
    assert_int_equal(back.cfa, TTF_CFA_RGGB);
    assert_int_equal(back.dark_temp_mdegc, -1500);
    assert_int_equal(back.dark_frames, 16);
    assert_int_equal(back.flat_frames, 4);
    assert_memory_equal(back.dark_offset_16, calibration.dark_offset_16, sizeof(int32_t) * W * H);
    assert_memory_equal(back.flat_gain, calibration.flat_gain, sizeof(uint16_t) * W * H);
    assert_int_equal(back.n_hot, calibration.n_hot);
    assert_memory_equal(back.hot, calibration.hot, sizeof(*back.hot) * back.n_hot);
    assert_memory_equal(back.colour_matrix, calibration.colour_matrix, sizeof(back.colour_matrix));
    assert_true(back.flat_level == calibration.flat_level);
    snprintf(id, sizeof(id), "%s", back.id);
    back.flat_gain[7]++;
    assert_int_equal(ttf_calibration_name(&back, NULL), 0);
    assert_string_not_equal(id, back.id);
    ttf_calibration_free(&calibration);
    ttf_calibration_free(&back);
}

static const char *fails; /* the operation that does */

static int fail_there(void *ctx, const char *op, const char *path)
{
    (void)ctx;
    (void)path;
    return strcmp(op, fails) == 0 ? -ENOSPC : 0;
}

static void a_save_that_is_refused_leaves_no_half_picture(void **state)
{
    static const char *const OPS[] = {"append", "pwrite", "sync", "rename"};
    struct ttf_io *io = ttf_io_faulty_create(ttf_io_posix(), fail_there, NULL);
    struct ttf_calibration calibration;
    struct ttf_io_stat st;

    fit_both(&calibration);
    assert_int_equal(ttf_calibration_name(&calibration, NULL), 0);
    assert_non_null(io);
    for (unsigned i = 0; i < sizeof(OPS) / sizeof(*OPS); i++) {
        fails = OPS[i];
        if (ttf_calibration_save(&calibration, io, scratch_path(state, "cal"), NULL) == 0)
            print_message("%s is not used\n", fails);
        assert_int_equal(io->ops->stat(io, scratch_path(state, "cal/.dark.tif.tmp"), &st), -ENOENT);
    }
    ttf_io_faulty_destroy(io);
    ttf_calibration_free(&calibration);
}

static long operation, failing;

static int fail_at(void *ctx, const char *op, const char *path)
{
    (void)ctx;
    (void)op;
    (void)path;
    return ++operation == failing ? ENOSPC : 0;
}

/* Whichever of its operations finds no room. */
static void a_first_save_that_is_refused_leaves_nothing(void **state)
{
    struct ttf_io *io = ttf_io_faulty_create(ttf_io_posix(), fail_at, NULL);
    struct ttf_calibration calibration;
    struct ttf_io_stat st;
    int r = -ENOSPC;

    fit_both(&calibration);
    assert_int_equal(ttf_calibration_name(&calibration, NULL), 0);
    assert_non_null(io);
    for (failing = 1; r < 0; failing++) {
        operation = 0;
        r = ttf_calibration_save(&calibration, io, scratch_path(state, "cal"), NULL);
        if (io->ops->stat(io, scratch_path(state, "cal/calibration.json"), &st) == 0) {
            assert_true(failing > 10); /* it was there, and whole, before what failed */
            break;
        }
        assert_true(r < 0);
        if (failing > 3) /* the folder was made */
            assert_int_equal(io->ops->stat(io, scratch_path(state, "cal"), &st), -ENOENT);
    }
    ttf_io_faulty_destroy(io);
    ttf_calibration_free(&calibration);
}

static void a_changed_picture_is_damage(void **state)
{
    struct ttf_calibration calibration, back;
    struct ttf_err err = {0};
    uint8_t *bytes;
    size_t n;

    fit_both(&calibration);
    assert_int_equal(ttf_calibration_name(&calibration, NULL), 0);
    save(state, &calibration);
    bytes = scratch_read(state, "cal/flat.tif", &n);
    bytes[n / 2] ^= 1;
    scratch_write(state, "cal/flat.tif", bytes, n);
    assert_int_equal(ttf_calibration_load(ttf_io_posix(), scratch_path(state, "cal"), &back, &err),
                     -TTF_EDAMAGED);
    free(bytes);
    ttf_calibration_free(&calibration);
    assert_int_equal(ttf_calibration_load(ttf_io_posix(), scratch_path(state, "no"), &back, &err),
                     -ENOENT);
}

#define BEGIN                                                                              \
    "{\"format\":{\"name\":\"ttf-calibration\",\"major\":1},\"id\":\"a\",\"camera\":\"\"," \
    "\"width\":4,\"height\":4,\"cfa\":\"RGGB\",\"black_level\":0,\"white_level\":9,"
#define SETTINGS                                                                         \
    "\"frames\":1,\"exposure_ns\":1,\"gain_milli\":1,\"wb_r_milli\":1,\"wb_b_milli\":1," \
    "\"lens_mdpt\":0"

static void wrong_json_is_refused_by_field(void **state)
{
    static const struct {
        const char *text, *reason;
    } cases[] = {
        {"", "no JSON"},
        {"[]", "no object"},
        {"{\"format\":{\"name\":\"x\"}}", "format"},
        {"{\"format\":{\"name\":\"ttf-calibration\",\"major\":2}}", "major"},
        {"{\"format\":{\"name\":\"ttf-calibration\",\"major\":1},\"id\":7}", "id"},
        {"{\"format\":{\"name\":\"ttf-calibration\",\"major\":1},\"id\":\"a\",\"camera\":\"\","
         "\"width\":-1}",
         "width"},
        {"{\"format\":{\"name\":\"ttf-calibration\",\"major\":1},\"id\":\"a\",\"camera\":\"\","
         "\"width\":4,\"height\":4,\"black_level\":0,\"white_level\":9,\"hot\":[1,4]}",
         "hot"},
        {BEGIN "\"hot\":[1,2,3]}", "'hot' holds no pairs"},
        {BEGIN "\"hot\":[-1,2]}", "'hot' holds a pixel outside"},
        {BEGIN "\"hot\":[1,4]}", "'hot' holds a pixel outside"},
        {BEGIN "\"hot\":[1,\"x\"]}", "'hot' holds no pairs"},
        {BEGIN "\"hot\":[4,1]}", "'hot' holds a pixel outside"},
        {BEGIN "\"hot\":[1,-2]}", "'hot' holds a pixel outside"},
        {BEGIN "\"hot\":[1,2.5]}", "'hot' holds no pairs"},
        {BEGIN "\"hot\":[0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0]}",
         "'hot' holds no pairs"}, /* 17 pixels of 16 */
        {BEGIN "\"dark\":{\"frames\":65536}}", "'frames' is out of range"},
        {BEGIN "\"flat\":{" SETTINGS ",\"reflectance\":-0.5,\"level\":1}}",
         "'reflectance' is out of range"},
        {BEGIN "\"colour_matrix\":[1,2]}", "has not nine numbers"},
        {BEGIN "\"colour_matrix\":[1,0,0,0,\"x\",0,0,0,1]}",
         "'colour_matrix' is missing or no number"},
        {BEGIN "\"colour_matrix\":[1,0,0,0,1e9,0,0,0,1]}", "'colour_matrix' is out of range"},
        {BEGIN "\"dark\":{\"frames\":0}}", "'frames' is out of range"},
        {BEGIN "\"dark\":{\"frames\":\"x\"}}", "'frames' is missing or no whole number"},
        {BEGIN "\"flat\":{" SETTINGS ",\"reflectance\":1.5,\"level\":1}}",
         "'reflectance' is out of range"},
        {BEGIN "\"flat\":{" SETTINGS ",\"reflectance\":0.9}}", "'level' is missing or no number"},
        {BEGIN "\"cfa\":\"RGGB\"}", "no JSON"}, /* a key twice */
        {"{\"format\":{\"name\":\"ttf-calibration\",\"major\":1},\"id\":\"a\",\"camera\":\"\","
         "\"width\":4,\"height\":4,\"cfa\":\"RGBG\",\"black_level\":0,\"white_level\":9}",
         "'cfa' is no mosaic"},
        {"{\"format\":{\"name\":\"ttf-calibration\",\"major\":1},\"id\":\"a\",\"camera\":\"\","
         "\"width\":4,\"height\":4,\"cfa\":\"RGGB\",\"black_level\":9,\"white_level\":9,"
         "\"dark\":{" SETTINGS "}}",
         "levels cannot be"},
    };
    struct ttf_calibration back;

    for (unsigned i = 0; i < TTF_COUNT_OF(cases); i++) {
        struct ttf_err err = {0};

        scratch_write(state, "calibration.json", cases[i].text, strlen(cases[i].text));
        assert_true(ttf_calibration_load(ttf_io_posix(), *state, &back, &err) < 0);
        if (!strstr(err.what, cases[i].reason))
            fail_msg("case %u: '%s' does not say '%s'", i, err.what, cases[i].reason);
    }
}

/* Nothing in a folder is trusted: cut and altered ones give an error, or a calibration that can be freed. */
static void broken_folders_do_not_crash(void **state)
{
    static const char *const names[] = {"cal/calibration.json", "cal/dark.tif", "cal/flat.tif"};
    struct ttf_calibration calibration;
    uint32_t seed = 11;

    fit_both(&calibration);
    snprintf(calibration.id, sizeof(calibration.id), "mine"); /* no checksum in the way */
    save(state, &calibration);
    ttf_calibration_free(&calibration);
    for (unsigned f = 0; f < 3; f++) {
        size_t n;
        uint8_t *bytes = scratch_read(state, names[f], &n), *copy = malloc(n);

        assert_non_null(copy);
        for (unsigned i = 0; i < 150; i++) {
            struct ttf_calibration back;
            struct ttf_err err = {0};

            memcpy(copy, bytes, n);
            for (unsigned k = 0; k < 3; k++)
                copy[scratch_random(&seed) % (n < 900 ? n : 900)] = (uint8_t)scratch_random(&seed);
            scratch_write(state, names[f], copy, i % 3 == 0 ? scratch_random(&seed) % n : n);
            if (ttf_calibration_load(ttf_io_posix(), scratch_path(state, "cal"), &back, &err) == 0)
                ttf_calibration_free(&back);
            else
                assert_true(err.code < 0 && err.what[0]);
        }
        scratch_write(state, names[f], bytes, n);
        free(bytes);
        free(copy);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(dark_frames_give_offsets_and_hot_pixels),
        cmocka_unit_test(dark_frames_that_are_not_dark_are_refused_with_the_reason),
        cmocka_unit_test(a_flat_makes_all_pixels_alike),
        cmocka_unit_test(dead_pixels_join_the_list),
        cmocka_unit_test(useless_flats_are_refused_with_the_reason),
        cmocka_unit_test(a_dark_comes_before_the_flat_or_not_at_all),
        cmocka_unit_test(full_scale_is_98_percent_of_few_codes_too),
        cmocka_unit_test(frames_that_do_not_fit_are_refused),
        cmocka_unit_test_setup_teardown(a_calibration_comes_back_from_its_folder, scratch_make,
                                        scratch_remove),
        cmocka_unit_test_setup_teardown(a_first_save_that_is_refused_leaves_nothing, scratch_make,
                                        scratch_remove),
        cmocka_unit_test_setup_teardown(a_save_that_is_refused_leaves_no_half_picture, scratch_make,
                                        scratch_remove),
        cmocka_unit_test_setup_teardown(a_changed_picture_is_damage, scratch_make, scratch_remove),
        cmocka_unit_test_setup_teardown(broken_folders_do_not_crash, scratch_make, scratch_remove),
        cmocka_unit_test_setup_teardown(wrong_json_is_refused_by_field, scratch_make,
                                        scratch_remove),
    };

    return cmocka_run_group_tests_name("calibration", tests, NULL, NULL);
}
