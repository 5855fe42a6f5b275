/* SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <errno.h>
#include <math.h>
#include <string.h>

#include "scratch.h"
#include "ttf/base/time.h"
#include "ttf/dataset/flicker.h"

#define W      64
#define H      400
#define BLACK  64
#define WHITE  1023
#define FRAMES 40

static uint16_t codes[W * H];

/* What the light does: of a frame i, of a row y of it. */
struct light {
    double level, frame, band, drift_per_min, noise;
};

static const struct ttf_frame_format format = {.width = W,
                                               .height = H,
                                               .stride = (size_t)W * 2,
                                               .packing = TTF_PACKING_RAW16,
                                               .cfa = TTF_CFA_RGGB,
                                               .bits = 10,
                                               .black_level = BLACK,
                                               .white_level = WHITE};

static int64_t start_of(unsigned i)
{
    return 1000 + (int64_t)i * TTF_NS_PER_S;
}

/* A subject that is twice as bright below, colours 1 : 2, every frame another phase of the ripple. */
static void expose(const struct light *light, unsigned i, uint32_t *seed)
{
    const double minutes = i / 60.0;
    const double all =
        (1 + (i % 2 ? light->frame : -light->frame)) * (1 + light->drift_per_min * minutes);

    for (unsigned y = 0; y < H; y++) {
        const double ripple = 1 + light->band * sin(6.2832 * (y / 160.0 + 0.37 * i));

        for (unsigned x = 0; x < W; x++) {
            const double colour = (x + y) % 2 ? 1 : 0.5;
            const double noise = light->noise * ((double)(scratch_random(seed) % 2001) / 1000 - 1);
            const double code =
                BLACK + light->level * colour * (1 + (double)y / H) * all * ripple * (1 + noise);

            codes[y * W + x] = (uint16_t)fmin(WHITE, fmax(0, code + 0.5));
        }
    }
}

static int measure(const struct light *light, unsigned n, struct ttf_flicker *ret,
                   struct ttf_err *err)
{
    struct ttf_frame frame = {.format = format,
                              .data = codes,
                              .bytes = sizeof(codes),
                              .settings = {7000000, 1000, 0, 0, 0}};
    struct ttf_flicker_frames frames;
    struct ttf_raw_sum sum;
    uint32_t seed = 5;
    int r;

    assert_int_equal(ttf_flicker_init(&frames, &format, FRAMES, err), 0);
    assert_int_equal(ttf_raw_sum_init(&sum, &format), 0);
    for (unsigned i = 0; i < n; i++) {
        expose(light, i, &seed);
        ttf_raw_sum_reset(&sum);
        assert_int_equal(ttf_raw_sum_add(&sum, &frame), 0);
        assert_int_equal(ttf_flicker_add(&frames, &sum, start_of(i)), 0);
    }
    r = ttf_flicker_measure(&frames, ret, err);
    ttf_raw_sum_free(&sum);
    ttf_flicker_free(&frames);
    return r;
}

static struct ttf_flicker measured(const struct light *light)
{
    struct ttf_flicker flicker = {0};
    struct ttf_err err = {0};

    if (measure(light, FRAMES, &flicker, &err) < 0)
        fail_msg("%s", err.what);
    return flicker;
}

static void a_steady_light_is_found_steady_through_its_noise(void **state)
{
    const struct ttf_flicker f = measured(&(struct light){.level = 300, .noise = 0.3});

    assert_int_equal(f.frames, FRAMES);
    assert_int_equal(f.settings.exposure_ns, 7000000);
    assert_float_equal(f.mean_level, 300 * 0.75 * 1.5 / (WHITE - BLACK), 0.005);
    assert_true(f.frame_rms < 0.002);
    assert_true(f.band_rms < 0.002); /* of noise alone it would be 0.008 */
    assert_true(f.band_peak > 0.01);
    assert_true(fabs(f.drift_per_min) < 0.005);
}

static void frames_of_different_brightness_are_told_from_bands_in_them(void **state)
{
    struct ttf_flicker f = measured(&(struct light){.level = 300, .frame = 0.03});

    assert_float_equal(f.frame_rms, 0.03, 0.001);
    assert_float_equal(f.frame_peak, 0.03, 0.004);
    assert_true(f.band_rms < 0.001);
    f = measured(&(struct light){.level = 300, .band = 0.05});
    assert_float_equal(f.band_rms, 0.05 / sqrt(2), 0.004);
    assert_true(f.frame_rms < 0.01); /* a whole number of ripples would leave none */
}

static void a_drift_is_no_flicker(void **state)
{
    const struct ttf_flicker f = measured(&(struct light){.level = 300, .drift_per_min = -0.06});

    assert_float_equal(f.drift_per_min, -0.06, 0.003);
    assert_true(f.frame_rms < 0.001);
}

static void assert_refused(const struct light *light, unsigned n, const char *what)
{
    struct ttf_flicker flicker = {.frames = 77};
    struct ttf_err err = {0};

    assert_int_equal(measure(light, n, &flicker, &err), -EINVAL);
    if (!strstr(err.what, what))
        fail_msg("'%s' does not say '%s'", err.what, what);
    assert_int_equal(flicker.frames, 77);
}

static void what_tells_nothing_is_refused_with_the_reason(void **state)
{
    assert_refused(&(struct light){.level = 900}, FRAMES, "saturated");
    assert_refused(&(struct light){.level = 1}, FRAMES, "too dark");
    assert_refused(&(struct light){.level = 300}, TTF_FLICKER_FRAMES_LEAST - 1, "too few");
}

static void more_frames_than_there_is_room_for_or_of_another_size_are_refused(void **state)
{
    struct ttf_frame_format other = format;
    struct ttf_flicker_frames frames;
    struct ttf_raw_sum sum;
    struct ttf_err err = {0};
    struct ttf_frame frame = {.format = format, .data = codes, .bytes = sizeof(codes)};

    assert_int_equal(ttf_flicker_init(&frames, &format, TTF_FLICKER_FRAMES_LEAST - 1, &err),
                     -EINVAL);
    assert_int_equal(ttf_flicker_init(&frames, &format, TTF_FLICKER_FRAMES_LEAST, &err), 0);
    assert_int_equal(ttf_raw_sum_init(&sum, &format), 0);
    assert_int_equal(ttf_flicker_add(&frames, &sum, 0), -EINVAL); /* no frame in it */
    assert_int_equal(ttf_raw_sum_add(&sum, &frame), 0);
    for (int i = 0; i < TTF_FLICKER_FRAMES_LEAST; i++)
        assert_int_equal(ttf_flicker_add(&frames, &sum, i), 0);
    assert_int_equal(ttf_flicker_add(&frames, &sum, 99), -ENOSPC);
    ttf_flicker_free(&frames);
    other.height = H / 2;
    assert_int_equal(ttf_flicker_init(&frames, &other, TTF_FLICKER_FRAMES_LEAST, &err), 0);
    assert_int_equal(ttf_flicker_add(&frames, &sum, 0), -EINVAL);
    ttf_flicker_free(&frames);
    other = format;
    other.width = W / 2;
    assert_int_equal(ttf_flicker_init(&frames, &other, TTF_FLICKER_FRAMES_LEAST, &err), 0);
    assert_int_equal(ttf_flicker_add(&frames, &sum, 0), -EINVAL);
    ttf_flicker_free(&frames);
    other = format;
    other.packing = TTF_PACKING_RAW8;
    assert_int_equal(ttf_flicker_init(&frames, &other, TTF_FLICKER_FRAMES_LEAST, &err), 0);
    assert_int_equal(ttf_flicker_add(&frames, &sum, 0), -EINVAL);
    ttf_flicker_free(&frames);
    other.height = 3;
    assert_int_equal(ttf_flicker_init(&frames, &other, TTF_FLICKER_FRAMES_LEAST, &err), -EINVAL);
    assert_non_null(strstr(err.what, "frames of 3 rows are too small"));
    ttf_raw_sum_free(&sum);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_steady_light_is_found_steady_through_its_noise),
        cmocka_unit_test(frames_of_different_brightness_are_told_from_bands_in_them),
        cmocka_unit_test(a_drift_is_no_flicker),
        cmocka_unit_test(what_tells_nothing_is_refused_with_the_reason),
        cmocka_unit_test(more_frames_than_there_is_room_for_or_of_another_size_are_refused),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
