/* SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "noise.h"
#include "plain_box.h"

#define W  256u
#define H  192u
#define N  (W * H)
#define S1 INT64_C(1000000000)

static uint16_t a[N], b[N];

static void noisy_config(struct ttf_sim_config *ret)
{
    plain_config(W, H, ret);
    ret->noise = true;
    ret->black_level = 1000;
    ret->full_well_e = 64535.0; /* one code an electron */
}

static void mean_and_variance(const uint16_t *p, double *ret_mean, double *ret_variance)
{
    double sum = 0.0, squares = 0.0;

    for (unsigned i = 0; i < N; i++)
        sum += p[i];
    *ret_mean = sum / N;
    for (unsigned i = 0; i < N; i++)
        squares += (p[i] - *ret_mean) * (p[i] - *ret_mean);
    *ret_variance = squares / N;
}

/* Variance of the noise that differs between two frames, so that of one of them. */
static double noise_variance(const uint16_t *p, const uint16_t *q)
{
    double sum = 0.0, squares = 0.0;

    for (unsigned i = 0; i < N; i++) {
        const double d = (double)p[i] - q[i];

        sum += d;
        squares += d * d;
    }
    return 0.5 * (squares / N - sum / N * (sum / N));
}

static void a_frame_in_the_dark_shows_black_level_and_read_noise(void **state)
{
    struct ttf_sim_config config;
    struct plain_scene s;
    double mean, variance;

    noisy_config(&config);
    config.read_noise_e = 6.0;
    plain_scene_init(&s, plain_white);
    plain_expose(&config, &s, 0.0f, a);
    mean_and_variance(a, &mean, &variance);
    assert_float_equal(mean, 1000.0, 0.15);
    assert_float_equal(variance, 36.0 + 1.0 / 12.0, 0.9);
}

static void variance_rises_with_the_mean_as_photons_demand(void **state)
{
    /* Photon transfer at 4 electrons a code: the slope is the conversion gain in codes an electron. */
    struct ttf_sim_config config;
    struct plain_scene s;
    struct sim_image_model *model;
    double sx = 0, sy = 0, sxx = 0, sxy = 0, slope;
    const int n = 10;

    noisy_config(&config);
    config.full_well_e = 4.0 * 64535.0;
    config.read_noise_e = 8.0;
    config.prnu = 0.02;
    config.sensitivity_e = 200000.0;
    plain_scene_init(&s, plain_white);
    model = plain_model(&config, &s);
    for (int i = 0; i < n; i++) {
        const float light = 0.05f + 0.1f * (float)i;
        double mean, variance, v;

        plain_shoot(model, H, light, S1, 1000, 25.0, 2 * (uint64_t)i, a);
        plain_shoot(model, H, light, S1, 1000, 25.0, 2 * (uint64_t)i + 1, b);
        mean_and_variance(a, &mean, &variance);
        v = noise_variance(a, b);
        sx += mean;
        sy += v;
        sxx += mean * mean;
        sxy += mean * v;
    }
    sim_image_model_destroy(model);
    slope = (n * sxy - sx * sy) / (n * sxx - sx * sx);
    assert_float_equal(slope, 0.25, 0.02 * 0.25);
}

static void few_photons_are_counted_as_poisson_says(void **state)
{
    static const double means[] = {0.02, 0.5, 3.0, 9.0, 11.9, 12.1, 30.0, 300.0};
    const unsigned draws = 400000;
    struct noise_normal normal;

    noise_normal_init(&normal);
    for (unsigned k = 0; k < 8; k++) {
        const uint64_t stream = noise_stream(3, 99, k);
        const double m = means[k];
        double sum = 0.0, squares = 0.0, cubes = 0.0, mean, variance;

        for (unsigned i = 0; i < draws; i++) {
            const double x =
                noise_poisson(&normal, (float)m, (uint32_t)(noise_draw(stream, i) >> 32)) - m;

            sum += x;
            squares += x * x;
            cubes += x * x * x;
        }
        mean = sum / draws;
        variance = squares / draws - mean * mean;
        assert_float_equal(mean, 0.0, 5.0 * sqrt(m / draws));
        assert_float_equal(variance / m, 1.0, 0.015 + 5.0 / sqrt(m * draws));
        /* The third central moment of a Poisson number is its mean too. */
        assert_float_equal(cubes / draws / m, 1.0,
                           0.1 + 40.0 * sqrt(m / draws) + 8.0 / sqrt(m * draws));
    }
}

static void normal_numbers_have_the_tails_they_should(void **state)
{
    const unsigned draws = 2000000;
    const uint64_t stream = noise_stream(5, 98, 0);
    struct noise_normal normal;
    double squares = 0.0;
    unsigned beyond2 = 0, beyond4 = 0;

    noise_normal_init(&normal);
    for (unsigned i = 0; i < draws; i++) {
        const float z = noise_normal(&normal, (uint32_t)noise_draw(stream, i));

        squares += (double)z * z;
        beyond2 += fabsf(z) > 2.0f;
        beyond4 += fabsf(z) > 4.0f;
    }
    assert_float_equal(squares / draws, 1.0, 0.006);
    assert_float_equal(beyond2 / (0.0455003 * draws), 1.0, 0.02);
    assert_in_range(beyond4, 80, 180); /* 127 expected */
}

static void the_pixels_response_differs_by_prnu(void **state)
{
    struct ttf_sim_config config;
    struct plain_scene s;
    struct sim_image_model *model;
    double *sum = calloc(N, sizeof(*sum)), mean = 0.0, squares = 0.0;
    const int frames = 24;

    assert_non_null(sum);
    noisy_config(&config);
    config.prnu = 0.01;
    config.sensitivity_e = 50000.0;
    plain_scene_init(&s, plain_white);
    model = plain_model(&config, &s);
    for (int k = 0; k < frames; k++) {
        plain_shoot(model, H, 1.0f, S1, 1000, 25.0, (uint64_t)k, a);
        for (unsigned i = 0; i < N; i++)
            sum[i] += (a[i] - 1000.0) / frames;
    }
    sim_image_model_destroy(model);
    for (unsigned i = 0; i < N; i++)
        mean += sum[i] / N;
    for (unsigned i = 0; i < N; i++)
        squares += (sum[i] - mean) * (sum[i] - mean) / N;
    /* What is left of the shot noise is taken off. */
    assert_float_equal(sqrt(squares - mean / frames) / mean, 0.01, 0.0003);
    free(sum);
}

static void hot_pixels_are_as_many_as_asked_and_stay_in_place(void **state)
{
    struct ttf_sim_config config;
    struct plain_scene s;
    struct sim_image_model *model;
    unsigned hot_a = 0, both = 0;

    noisy_config(&config);
    config.read_noise_e = 3.0;
    config.hot_fraction = 0.01;
    config.hot_e_per_s = 2000.0;
    plain_scene_init(&s, plain_white);
    model = plain_model(&config, &s);
    plain_shoot(model, H, 0.0f, S1, 1000, 25.0, 1, a);
    plain_shoot(model, H, 0.0f, S1, 1000, 25.0, 2, b);
    sim_image_model_destroy(model);
    for (unsigned i = 0; i < N; i++) {
        hot_a += a[i] > 1060;
        both += a[i] > 1060 && b[i] > 1060;
    }
    assert_float_equal(hot_a / (0.01 * N), 1.0, 0.15);
    assert_in_range(hot_a - both, 0, 2);
}

static void dark_current_doubles_as_often_as_the_sensor_warms(void **state)
{
    struct ttf_sim_config config;
    struct plain_scene s;
    struct sim_image_model *model;
    double at25, at31, at37, longer, variance;

    noisy_config(&config);
    config.dark_e_per_s = 150.0;
    config.dark_doubling_degc = 6.0;
    plain_scene_init(&s, plain_white);
    model = plain_model(&config, &s);
    plain_shoot(model, H, 0.0f, S1, 1000, 25.0, 1, a);
    mean_and_variance(a, &at25, &variance);
    plain_shoot(model, H, 0.0f, S1, 1000, 31.0, 2, a);
    mean_and_variance(a, &at31, &variance);
    plain_shoot(model, H, 0.0f, S1, 1000, 37.0, 3, a);
    mean_and_variance(a, &at37, &variance);
    plain_shoot(model, H, 0.0f, 5 * S1, 1000, 25.0, 4, a);
    mean_and_variance(a, &longer, &variance);
    sim_image_model_destroy(model);
    assert_float_equal(at25 - 1000.0, 150.0, 0.6);
    assert_float_equal(at31 - 1000.0, 300.0, 0.8);
    assert_float_equal(at37 - 1000.0, 600.0, 1.2);
    assert_float_equal(longer - 1000.0, 750.0, 1.4);
}

static void too_much_light_saturates_at_the_highest_code(void **state)
{
    struct ttf_sim_config config;
    struct plain_scene s;

    noisy_config(&config);
    config.bits = 12;
    config.black_level = 256;
    config.full_well_e = 15000.0;
    config.read_noise_e = 3.0;
    config.prnu = 0.01;
    config.sensitivity_e = 20000.0;
    plain_scene_init(&s, plain_white);
    plain_expose(&config, &s, 1.0f, a);
    for (unsigned i = 0; i < N; i++)
        assert_int_equal(a[i], 4095);
    plain_expose(&config, &s, 0.5f, a);
    for (unsigned i = 0; i < N; i++)
        assert_true(a[i] < 4095 && a[i] > 256);
}

static void gain_multiplies_signal_and_not_black(void **state)
{
    struct ttf_sim_config config;
    struct plain_scene s;
    struct sim_image_model *model;

    plain_config(W, H, &config);
    config.black_level = 500;
    config.full_well_e = 65035.0;
    plain_scene_init(&s, plain_white);
    model = plain_model(&config, &s);
    plain_shoot(model, H, 1.0f, S1, 1000, 25.0, 1, a);
    plain_shoot(model, H, 1.0f, S1, 4000, 25.0, 1, b);
    sim_image_model_destroy(model);
    assert_int_equal(a[77], 1500);
    assert_int_equal(b[77], 4500);
}

static void the_same_key_gives_the_same_bits_in_any_order(void **state)
{
    struct ttf_sim_config config;
    struct plain_scene s;
    struct sim_image_model *model;
    double cross = 0.0, mean, variance;

    noisy_config(&config);
    config.sensitivity_e = 10000.0;
    config.read_noise_e = 3.0;
    plain_scene_init(&s, plain_white);
    model = plain_model(&config, &s);
    plain_shoot(model, H, 1.0f, S1, 1000, 25.0, 11, a);
    plain_shoot(model, H, 0.3f, S1, 1000, 25.0, 12, b);
    plain_shoot(model, H, 1.0f, S1, 1000, 25.0, 11, b);
    assert_memory_equal(a, b, sizeof(a));
    plain_shoot(model, H, 1.0f, S1, 1000, 25.0, 12, b);
    sim_image_model_destroy(model);
    /* Another key: noise that has nothing to do with the first; nor have neighbours with each other. */
    mean_and_variance(a, &mean, &variance);
    for (unsigned i = 0; i < N; i++)
        cross += (a[i] - mean) * (b[i] - mean) / variance;
    assert_float_equal(cross / N, 0.0, 5.0 / sqrt(N));
    cross = 0.0;
    for (unsigned i = 0; i + 1 < N; i++)
        cross += (a[i] - mean) * (a[i + 1] - mean) / variance;
    assert_float_equal(cross / N, 0.0, 5.0 / sqrt(N));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_frame_in_the_dark_shows_black_level_and_read_noise),
        cmocka_unit_test(variance_rises_with_the_mean_as_photons_demand),
        cmocka_unit_test(few_photons_are_counted_as_poisson_says),
        cmocka_unit_test(normal_numbers_have_the_tails_they_should),
        cmocka_unit_test(the_pixels_response_differs_by_prnu),
        cmocka_unit_test(hot_pixels_are_as_many_as_asked_and_stay_in_place),
        cmocka_unit_test(dark_current_doubles_as_often_as_the_sensor_warms),
        cmocka_unit_test(too_much_light_saturates_at_the_highest_code),
        cmocka_unit_test(gain_multiplies_signal_and_not_black),
        cmocka_unit_test(the_same_key_gives_the_same_bits_in_any_order),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
