/* SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "pictures.h"
#include "ttf/synth/prepare.h"

#define W 96u
#define H 80u

/* Fine texture, of every colour its own, under a light that falls off from the middle and to the right. */
static double light(double x, double y)
{
    double u = (x - 40.0) / W, v = (y - 38.0) / H;

    return 1.35 * exp(-1.6 * (u * u + v * v));
}

static double texture(double x, double y, uint32_t t, int c)
{
    return 0.12 + 0.2 * chance((uint32_t)x, (uint32_t)y, t + 100u * (unsigned)c);
}

static double unevenly_lit(const void *ctx, double x, double y, uint32_t t, int c)
{
    (void)ctx;
    return texture(x, y, t, c) * light(x, y);
}

static double even(const void *ctx, double x, double y, uint32_t t, int c)
{
    (void)ctx;
    (void)x;
    (void)y;
    return 0.1 + 0.02 * t + 0.1 * c;
}

static struct ttf_gradient found(struct ttf_sequence *input, double sigma_px, uint32_t frame)
{
    struct ttf_gradient gradient = {0};
    struct ttf_err err = {0};

    if (ttf_gradient_find(input, sigma_px, frame, &gradient, &err) < 0)
        fail_msg("%s", err.what);
    return gradient;
}

static struct ttf_sequence *flattened(struct ttf_sequence *input,
                                      const struct ttf_gradient *gradient)
{
    struct ttf_sequence *flat = NULL;

    assert_int_equal(ttf_flatten_create(input, gradient, &flat, NULL), 0);
    return flat;
}

/* Brightest over darkest of the means of 16 x 16 pixels, but for those within `border` of the edge. */
static double unevenness(struct ttf_sequence *sequence, int c, uint32_t border)
{
    double least = 1e9, most = 0.0;

    for (uint32_t y = border; y < H - border; y += 16) {
        for (uint32_t x = border; x < W - border; x += 16) {
            double mean = mean_of(sequence, 7, x, y, 16, 16, c);

            least = fmin(least, mean);
            most = fmax(most, mean);
        }
    }
    return most / least;
}

static void an_unevenly_lit_texture_comes_out_flat(void **state)
{
    const struct ttf_encoding *encodings[] = {&imported, &captured};

    (void)state;
    for (int i = 0; i < 2; i++) {
        struct pictures input = pictures_make(W, H, 20, encodings[i], unevenly_lit, NULL);
        struct ttf_gradient gradient = found(input.sequence, 10.0, TTF_GRADIENT_MEAN);
        struct ttf_sequence *flat = flattened(input.sequence, &gradient);

        for (int c = 0; c < 3; c++) {
            assert_true(unevenness(input.sequence, c, 0) > 1.8);
            assert_true(unevenness(input.sequence, c, 16) > 1.25);
            /* at the edges, what is seen of a slope is seen from one side only */
            assert_true(unevenness(flat, c, 0) < 1.25);
            assert_true(unevenness(flat, c, 16) < 1.08);
            /* as bright as before, all in all */
            assert_true(
                fabs(mean_of(flat, 7, 0, 0, W, H, c) / mean_of(input.sequence, 7, 0, 0, W, H, c) -
                     1.0) < 0.03);
        }
        assert_true(flat->encoding.pedestal == encodings[i]->pedestal && flat->n == 20);
        assert_ptr_equal(flat->time_ns, input.sequence->time_ns);
        assert_reads_by_rows(flat);
        ttf_sequence_destroy(flat);
        ttf_gradient_free(&gradient);
        pictures_free(&input);
    }
}

static void the_gradient_put_on_again_gives_the_original_back(void **state)
{
    struct pictures input = pictures_make(W, H, 2, &captured, unevenly_lit, NULL);
    struct ttf_gradient gradient = found(input.sequence, 16.0, 0);
    struct ttf_sequence *flat = flattened(input.sequence, &gradient);
    struct ttf_pool *pool = ttf_pool_create(3);
    uint16_t *again = frame_of(flat, 1), *alone = frame_of(flat, 1);
    const uint16_t *original = input.codes + (size_t)W * H * 3;

    (void)state;
    assert_non_null(pool);
    assert_true(memcmp(again, original, (size_t)W * H * 6) != 0);
    ttf_gradient_apply(&gradient, &captured, pool, again);
    ttf_gradient_apply(&gradient, &captured, NULL, alone);
    for (size_t i = 0; i < (size_t)W * H * 3; i++)
        assert_in_range(again[i], original[i] - 1, original[i] + 1);
    assert_memory_equal(again, alone, (size_t)W * H * 6);
    free(again);
    free(alone);
    ttf_pool_destroy(pool);
    ttf_sequence_destroy(flat);
    ttf_gradient_free(&gradient);
    pictures_free(&input);
}

static void an_evenly_lit_sequence_comes_out_bit_for_bit(void **state)
{
    struct pictures input = pictures_make(W, H, 3, &captured, even, NULL);
    struct ttf_gradient gradient = found(input.sequence, 24.0, TTF_GRADIENT_MEAN);
    struct ttf_sequence *flat = flattened(input.sequence, &gradient);
    float least, most;

    (void)state;
    ttf_gradient_range(&gradient, &least, &most);
    assert_true(least > 0.99999f && most < 1.00001f);
    assert_same_frames(flat, input.sequence);
    ttf_sequence_destroy(flat);
    ttf_gradient_free(&gradient);
    pictures_free(&input);
}

/* The definition, pixel by pixel: weights of a Gaussian, those inside made to add up to 1. */
static double gaussian_at(const uint16_t *codes, uint32_t width, uint32_t height, double sigma,
                          int px, int py, size_t c)
{
    double sum = 0.0, weights = 0.0;
    int reach = (int)ceil(3.0 * sigma);

    for (int y = py - reach; y <= py + reach; y++) {
        for (int x = px - reach; x <= px + reach; x++) {
            double dx = x - px, dy = y - py;
            double weight = exp(-(dx * dx + dy * dy) / (2.0 * sigma * sigma));

            if (x < 0 || y < 0 || x >= (int)width || y >= (int)height)
                continue;
            sum += weight * codes[((size_t)y * width + (size_t)x) * 3 + c];
            weights += weight;
        }
    }
    return sum / weights;
}

static void matches_the_definition(uint32_t width, uint32_t height, double sigma)
{
    struct pictures input = pictures_make(width, height, 1, &imported, unevenly_lit, NULL);
    struct ttf_gradient gradient = found(input.sequence, sigma, 0);

    for (size_t c = 0; c < 3; c++) {
        double mean = 0.0;

        for (int i = 0; i < (int)(width * height); i++)
            mean +=
                gaussian_at(input.codes, width, height, sigma, i % (int)width, i / (int)width, c) /
                (width * height);
        for (int i = 0; i < (int)(width * height); i += 7) {
            double want =
                gaussian_at(input.codes, width, height, sigma, i % (int)width, i / (int)width, c) /
                mean;

            assert_true(fabs((double)gradient.g[3 * (size_t)i + c] - want) < 1e-5);
        }
    }
    ttf_gradient_free(&gradient);
    pictures_free(&input);
}

static void the_gradient_is_a_gaussian_with_its_weights_inside(void **state)
{
    (void)state;
    matches_the_definition(21, 17, 1.5);
    matches_the_definition(17, 23, 4.0);
    matches_the_definition(16, 9, 30.0); /* wider than the picture */
    matches_the_definition(1, 12, 2.0);
    matches_the_definition(12, 1, 0.2);
}

static double one_red_frame(const void *ctx, double x, double y, uint32_t t, int c)
{
    uint32_t n = *(const uint32_t *)ctx;

    (void)y;
    return t == n - 1 && c == 0 ? 0.1 + 0.6 * x / W : 0.4;
}

static void the_picture_it_is_found_on_can_be_chosen(void **state)
{
    uint32_t n = 40;
    struct pictures input = pictures_make(W, 20, n, &imported, one_red_frame, &n);
    struct ttf_gradient gradient = found(input.sequence, 8.0, 3);
    float least, most, red_least, red_most;

    (void)state;
    ttf_gradient_range(&gradient, &least, &most);
    assert_true(most - least < 1e-4f);
    ttf_gradient_free(&gradient);

    gradient = found(input.sequence, 8.0, n - 1);
    ttf_gradient_range(&gradient, &red_least, &red_most);
    assert_true(red_least < 0.5f && red_most > 1.5f);
    for (size_t i = 0; i < (size_t)W * 20; i++) /* each channel has its own */
        assert_true(fabsf(gradient.g[3 * i + 1] - 1.0f) < 1e-4f);
    ttf_gradient_free(&gradient);

    /* the mean of 16 frames of 40, the last among them */
    gradient = found(input.sequence, 8.0, TTF_GRADIENT_MEAN);
    ttf_gradient_range(&gradient, &least, &most);
    assert_true(most - 1.0f > (red_most - 1.0f) / 18.0f && most - 1.0f < (red_most - 1.0f) / 14.0f);
    ttf_gradient_free(&gradient);
    pictures_free(&input);
}

static double half_black(const void *ctx, double x, double y, uint32_t t, int c)
{
    (void)ctx;
    (void)y;
    (void)t;
    return c == 2 ? 0.0 : x < 48 ? 0.001 : 0.9;
}

static void darkness_is_not_blown_up(void **state)
{
    struct pictures input = pictures_make(W, 8, 1, &imported, half_black, NULL);
    struct ttf_gradient gradient = found(input.sequence, 4.0, 0);
    struct ttf_sequence *flat = flattened(input.sequence, &gradient);
    uint16_t *codes = frame_of(flat, 0);
    float least, most;

    (void)state;
    ttf_gradient_range(&gradient, &least, &most);
    assert_true(least == TTF_GRADIENT_LEAST && most < 2.1f);
    assert_int_equal(codes[0], 66 * 20); /* no more than the 20-fold */
    assert_int_equal(codes[2], 0);
    assert_true(gradient.g[2] == 1.0f && gradient.g[3 * W - 1] == 1.0f);
    free(codes);
    ttf_sequence_destroy(flat);
    ttf_gradient_free(&gradient);
    pictures_free(&input);
}

static double ramp(const void *ctx, double x, double y, uint32_t t, int c)
{
    (void)ctx;
    (void)t;
    (void)c;
    return 0.2 + 0.5 * x / W + 0.2 * y / H;
}

static void a_resampled_gradient_has_the_same_slopes(void **state)
{
    struct pictures input = pictures_make(W, H, 1, &imported, ramp, NULL);
    struct ttf_gradient gradient = found(input.sequence, 6.0, 0), same, large, dot;

    (void)state;
    assert_int_equal(ttf_gradient_resample(&gradient, W, H, &same, NULL), 0);
    assert_memory_equal(same.g, gradient.g, (size_t)W * H * 3 * sizeof(float));
    assert_int_equal(ttf_gradient_resample(&gradient, 3 * W, 2 * H, &large, NULL), 0);
    for (size_t y = 0; y < H; y += 3) {
        for (size_t x = 0; x < W;
             x += 3) /* every third pixel lies on an old one, across; between two, down */
            assert_true(fabsf(large.g[((2 * y + 1) * 3 * W + 3 * x + 1) * 3] -
                              gradient.g[(y * W + x) * 3]) < 0.003f);
    }
    assert_true(large.g[0] == gradient.g[0]);
    assert_int_equal(ttf_gradient_resample(&gradient, 1, 1, &dot, NULL), 0);
    assert_true(fabsf(dot.g[0] - 1.0f) < 0.01f);
    ttf_gradient_free(&large);
    assert_int_equal(ttf_gradient_resample(&dot, 5, 4, &large, NULL), 0); /* and from one pixel */
    assert_true(large.g[59] == dot.g[2]);
    ttf_gradient_free(&dot);
    ttf_gradient_free(&same);
    ttf_gradient_free(&large);
    ttf_gradient_free(&gradient);
    pictures_free(&input);
}

static void refused(struct ttf_sequence *input, double sigma_px, uint32_t frame, int code,
                    const char *where)
{
    struct ttf_gradient gradient = {.width = 7};
    struct ttf_err err = {0};

    assert_int_equal(ttf_gradient_find(input, sigma_px, frame, &gradient, &err), code);
    assert_string_equal(err.where, where);
    assert_int_equal(gradient.width, 7);
}

static void what_makes_no_sense_is_refused_by_name(void **state)
{
    struct pictures input = pictures_make(20, 20, 2, &imported, even, NULL);
    struct pictures other = pictures_make(20, 21, 2, &imported, even, NULL);
    struct ttf_gradient gradient = found(input.sequence, 3.0, 0), none = {.width = 7};
    struct ttf_sequence broken = unreadable_from(1, 3), *flat = NULL;
    struct ttf_err err = {0};

    (void)state;
    refused(input.sequence, 0.0, 0, -EINVAL, "sigma");
    refused(input.sequence, -2.0, 0, -EINVAL, "sigma");
    refused(input.sequence, NAN, 0, -EINVAL, "sigma");
    refused(input.sequence, INFINITY, 0, -EINVAL, "sigma");
    refused(input.sequence, 3.0, 2, -EINVAL, "frame");
    refused(&broken, 3.0, 2, -EIO, "frame");
    refused(&broken, 3.0, TTF_GRADIENT_MEAN, -EIO, "frame");
    assert_int_equal(ttf_flatten_create(other.sequence, &gradient, &flat, &err), -EINVAL);
    assert_non_null(strstr(err.what, "20 x 21"));
    assert_true(err.hint[0] != '\0' && !flat);
    assert_int_equal(ttf_gradient_resample(&gradient, 0, 4, &none, &err), -EINVAL);
    assert_int_equal(none.width, 7);
    ttf_gradient_free(&gradient);
    ttf_gradient_free(&gradient);
    ttf_gradient_free(NULL);
    pictures_free(&input);
    pictures_free(&other);
}

static void an_unreadable_frame_is_reported_when_it_is_read(void **state)
{
    struct ttf_sequence broken = unreadable_from(1, 3), *flat;
    struct ttf_gradient gradient = found(&broken, 3.0, 0);
    uint16_t *codes = malloc((size_t)40 * 36 * 6);
    struct ttf_err err = {0};

    (void)state;
    assert_non_null(codes);
    flat = flattened(&broken, &gradient);
    assert_int_equal(ttf_sequence_read_rows(flat, 0, 0, 36, codes, &err), 0);
    assert_int_equal(ttf_sequence_read_rows(flat, 1, 0, 36, codes, &err), -EIO);
    free(codes);
    ttf_sequence_destroy(flat);
    ttf_gradient_free(&gradient);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(an_unevenly_lit_texture_comes_out_flat),
        cmocka_unit_test(the_gradient_put_on_again_gives_the_original_back),
        cmocka_unit_test(an_evenly_lit_sequence_comes_out_bit_for_bit),
        cmocka_unit_test(the_gradient_is_a_gaussian_with_its_weights_inside),
        cmocka_unit_test(the_picture_it_is_found_on_can_be_chosen),
        cmocka_unit_test(darkness_is_not_blown_up),
        cmocka_unit_test(a_resampled_gradient_has_the_same_slopes),
        cmocka_unit_test(what_makes_no_sense_is_refused_by_name),
        cmocka_unit_test(an_unreadable_frame_is_reported_when_it_is_read),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
