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

#include "made.h"
#include "ttf/synth/shadow.h"

enum {
    W = 160,
    H = 120
};

/* A made photograph: a disk of one colour on a ground lit unevenly, its soft shadow beside it. */
struct photo {
    double ground[3], object[3];
    double x, y, radius; /* of the disk, pixels; 0: none */
    double shadow_x, shadow_y, shadow_radius, depth;
    double noise; /* standard deviation, of full scale */
};

static const struct photo ball = {
    {0.30, 0.45, 0.65}, {0.7, 0.35, 0.1}, 70.0, 50.0, 22.0, 92.0, 66.0, 26.0, 0.6, 0.004};

static double light_at(double x, double y)
{
    return 0.8 + 0.2 * (x / W - 0.5) - 0.3 * (y / H - 0.5);
}

/* s: from 1 - depth within to 1 outside, over a third of the radius */
static double shadow_at(const struct photo *photo, double x, double y)
{
    double d = hypot(x - photo->shadow_x, y - photo->shadow_y) / photo->shadow_radius;
    double t = (1.15 - d) / 0.3;

    t = t < 0.0 ? 0.0 : t > 1.0 ? 1.0 : t;
    return 1.0 - photo->depth * t * t * (3.0 - 2.0 * t);
}

static bool in_disk(const struct photo *photo, double x, double y)
{
    return hypot(x - photo->x, y - photo->y) < photo->radius;
}

static double seen(const struct photo *photo, int c, double x, double y)
{
    if (in_disk(photo, x, y))
        return photo->object[c];
    return photo->ground[c] * light_at(x, y) * shadow_at(photo, x, y);
}

static double noise(uint32_t *random)
{
    double sum = 0.0;

    for (int i = 0; i < 3; i++) {
        *random = *random * 1664525u + 1013904223u;
        sum += (double)(*random >> 8) / 16777216.0 - 0.5;
    }
    return 2.0 * sum; /* of variance 1 */
}

static struct ttf_pixbuf photograph(const struct photo *photo)
{
    struct ttf_pixbuf buf = {0};
    uint32_t random = 11;

    assert_int_equal(ttf_pixbuf_alloc(&buf, W, H, 3, TTF_SAMPLE_U16), 0);
    for (int y = 0; y < H; y++) {
        uint16_t *row = ttf_pixbuf_row(&buf, (uint32_t)y);

        for (int i = 0; i < 3 * W; i++) {
            double sum = 0.0;

            for (int k = 0; k < 16; k++) { /* as a lens mixes at edges */
                int x4 = i / 3 * 4 + k % 4, y4 = y * 4 + k / 4;

                sum += seen(photo, i % 3, (x4 + 0.5) / 4, (y4 + 0.5) / 4) / 16;
            }
            sum += photo->noise * noise(&random);
            sum = sum < 0.0 ? 0.0 : sum > 1.0 ? 1.0 : sum;
            row[i] = (uint16_t)(sum * 65535.0 + 0.5);
        }
    }
    return buf;
}

static struct ttf_shadow found_in(const struct photo *photo, uint32_t width, uint32_t height)
{
    struct ttf_pixbuf buf = photograph(photo);
    struct ttf_shadow_config config;
    struct ttf_shadow shadow = {0};
    struct ttf_err err = {0};

    ttf_shadow_defaults(&config);
    if (ttf_shadow_find(&config, &buf, width, height, &shadow, &err) < 0)
        fail_msg("%s: %s", err.where, err.what);
    ttf_pixbuf_free(&buf);
    return shadow;
}

static void near(double got, double want, double by)
{
    if (!(fabs(got - want) <= by))
        fail_msg("%.9g is not within %g of %.9g", got, by, want);
}

/* Inside by more than `by` pixels it is the object, outside by more it is not; `scale` photo pixels to one. */
static void disk_within(const struct photo *photo, const struct ttf_shadow *shadow, double scale,
                        double by)
{
    for (uint32_t y = 0; y < shadow->height; y++) {
        for (uint32_t x = 0; x < shadow->width; x++) {
            double d = hypot((x + 0.5) * scale - photo->x, (y + 0.5) * scale - photo->y);
            double inside = (photo->radius - d) / scale;
            float alpha = shadow->alpha[(size_t)y * shadow->width + x];

            assert_true(alpha >= 0.0f && alpha <= 1.0f);
            if ((inside > by && alpha < 0.5f) || (inside < -by && alpha >= 0.5f))
                fail_msg("alpha %g at %u, %u, %g inside", (double)alpha, x, y, inside);
        }
    }
}

static void disk_is_found(const struct photo *photo, const struct ttf_shadow *shadow, double scale)
{
    disk_within(photo, shadow, scale, 1.0);
}

static void the_object_is_found_within_a_pixel(void **state)
{
    struct ttf_shadow shadow = found_in(&ball, 0, 0);

    (void)state;
    assert_true(shadow.width == W && shadow.height == H);
    disk_is_found(&ball, &shadow, 1.0);
    near(shadow.object_share * W * H, 3.14159 * 22 * 22, 40.0);
    assert_true(shadow.threshold > 0.02 && shadow.threshold < 0.3);
    assert_true(shadow.alpha[50 * W + 70] == 1.0f && shadow.alpha[0] == 0.0f);
    ttf_shadow_free(&shadow);
    assert_null(shadow.shade);
    ttf_shadow_free(NULL);
}

static void the_shade_is_the_shadow_s(void **state)
{
    struct ttf_shadow shadow = found_in(&ball, 0, 0);

    (void)state;
    for (int y = 0; y < H; y++) {
        for (int x = 0; x < W; x++) {
            double s = (double)shadow.shade[y * W + x];

            assert_true(s >= 0.0 && s <= 1.0);
            if (hypot(x + 0.5 - ball.x, y + 0.5 - ball.y) > ball.radius + 6.0)
                near(s, shadow_at(&ball, x + 0.5, y + 0.5), 0.05);
        }
    }
    near(shadow.shade[70 * W + 100], 0.4, 0.03);
    ttf_shadow_free(&shadow);
}

static void a_dark_object_does_not_darken_the_ground_beside_it(void **state)
{
    struct photo photo = ball;
    struct ttf_shadow shadow;

    (void)state;
    photo.object[0] = 0.08;
    photo.object[1] = 0.02;
    photo.object[2] = 0.01;
    photo.shadow_x = photo.x; /* all of it behind the object */
    photo.shadow_y = photo.y;
    photo.shadow_radius = 5.0;
    shadow = found_in(&photo, 0, 0);
    disk_is_found(&photo, &shadow, 1.0);
    for (int i = 0; i < W * H; i++)
        near(shadow.shade[i], 1.0, 0.05); /* under it, too */
    ttf_shadow_free(&shadow);
}

static void under_the_object_the_shade_goes_on_from_around_it(void **state)
{
    struct ttf_shadow shadow = found_in(&ball, 0, 0);
    const float *row = shadow.shade + 56 * W;

    (void)state;
    /* from the lit side on the left into the shadow on the right, without a jump */
    near(row[50], 1.0, 0.1);
    assert_true(row[90] < 0.55f && row[70] < row[52] && row[70] > row[88]);
    for (int x = 51; x < 90; x++)
        near(row[x], row[x - 1], 0.08);
    ttf_shadow_free(&shadow);
}

static void the_rates_are_as_asked(void **state)
{
    struct ttf_shadow shadow = found_in(&ball, 0, 0);
    struct ttf_rate_map map = {0};
    struct ttf_err err = {0};

    (void)state;
    made_refused(ttf_shadow_rate_map(&shadow, -0.1, &map, &err), -EINVAL, "least", &err, &map);
    made_refused(ttf_shadow_rate_map(&shadow, (double)NAN, &map, &err), -EINVAL, "least", &err,
                 &map);
    assert_int_equal(ttf_shadow_rate_map(&shadow, 0.2, &map, NULL), 0);
    assert_true(map.width == W && map.height == H);
    for (int i = 0; i < W * H; i++)
        near(map.m[i], 0.2 + 0.8 * (double)shadow.shade[i], 1e-6);
    near(map.m[70 * W + 100], 0.52, 0.03);
    ttf_rate_map_free(&map);
    ttf_shadow_free(&shadow);
}

static void another_size_shows_the_same(void **state)
{
    struct ttf_shadow small = found_in(&ball, W / 2, H / 2), large = found_in(&ball, 2 * W, 2 * H);

    (void)state;
    assert_true(small.width == W / 2 && small.height == H / 2);
    disk_is_found(&ball, &small, 2.0);
    disk_is_found(&ball, &large, 0.5);
    near(small.shade[35 * (W / 2) + 50], 0.4, 0.03);
    near(large.shade[140 * (2 * W) + 200], 0.4, 0.03);
    ttf_shadow_free(&small);
    ttf_shadow_free(&large);
}

static void an_object_and_shadow_that_reach_the_border_leave_the_ground_alone(void **state)
{
    struct photo photo = ball;
    struct ttf_shadow shadow;

    (void)state;
    photo.x = 140.0;
    photo.y = 90.0;
    photo.radius = 32.0; /* cut by the right and the lower border */
    photo.shadow_x = 100.0;
    photo.shadow_y = 105.0;
    photo.shadow_radius = 30.0;
    shadow = found_in(&photo, 0, 0);
    disk_is_found(&photo, &shadow, 1.0);
    near(shadow.shade[5 * W + 5], 1.0, 0.05);
    near(shadow.shade[40 * W + 150], 1.0, 0.05);
    near(shadow.shade[110 * W + 90], 0.4, 0.04);
    ttf_shadow_free(&shadow);
}

static void a_whole_side_may_be_the_object_s(void **state)
{
    struct photo photo = ball;
    struct ttf_shadow shadow;

    (void)state;
    photo.x = 340.0;
    photo.y = 60.0;
    photo.radius = 200.0;
    shadow = found_in(&photo, 0, 0);
    disk_is_found(&photo, &shadow, 1.0);
    near(shadow.shade[5 * W + 5], 1.0, 0.05);
    near(shadow.shade[115 * W + 130], 1.0, 0.05);
    near(shadow.shade[70 * W + 100], 0.4, 0.04);
    ttf_shadow_free(&shadow);
}

static void noise_does_not_fray_the_outline(void **state)
{
    struct photo photo = ball;
    struct ttf_shadow shadow;

    (void)state;
    photo.noise = 0.08;
    shadow = found_in(&photo, 0, 0);
    disk_within(&photo, &shadow, 1.0, 1.5);
    near(shadow.object_share * W * H, 3.14159 * 22 * 22, 60.0);
    ttf_shadow_free(&shadow);
}

static void dark_parts_and_highlights_belong_to_the_object(void **state)
{
    struct ttf_pixbuf buf = photograph(&ball);
    struct ttf_shadow_config config;
    struct ttf_shadow shadow;

    (void)state;
    for (int y = 44; y < 54; y++) { /* black, and of the ground's colour */
        uint16_t *row = ttf_pixbuf_row(&buf, (uint32_t)y);

        for (int x = 60; x < 70; x++) {
            for (int c = 0; c < 3; c++) {
                row[3 * x + c] = 300;
                row[3 * (x + 10) + c] = (uint16_t)(65535 * ball.ground[c]);
            }
        }
    }
    for (int y = 49; y < 52; y++) /* a black line that reaches the outline */
        memset((uint16_t *)ttf_pixbuf_row(&buf, (uint32_t)y) + (size_t)3 * 49, 0, 60);
    ttf_shadow_defaults(&config);
    assert_int_equal(ttf_shadow_find(&config, &buf, 0, 0, &shadow, NULL), 0);
    disk_is_found(&ball, &shadow, 1.0);
    near(shadow.object[3 * (48 * W + 65)], 300 / 65535.0, 1e-6);
    ttf_shadow_free(&shadow);
    ttf_pixbuf_free(&buf);
}

static const struct ttf_encoding captured = {TTF_PEDESTAL, TTF_SCALE};

static uint16_t *plain_frame(const struct ttf_shadow *shadow, double value)
{
    size_t n = (size_t)shadow->width * shadow->height * 3;
    uint16_t *codes = malloc(n * sizeof(*codes));

    assert_non_null(codes);
    for (size_t i = 0; i < n; i++)
        codes[i] = (uint16_t)(captured.pedestal + captured.scale * value + 0.5);
    return codes;
}

static double value_of(uint16_t code)
{
    return ((double)code - captured.pedestal) / captured.scale;
}

static void the_object_lies_over_a_shaded_texture(void **state)
{
    struct ttf_shadow shadow = found_in(&ball, 0, 0);
    uint16_t *codes = plain_frame(&shadow, 0.5);

    (void)state;
    ttf_shadow_compose(&shadow, &captured, NULL, codes);
    for (int y = 0; y < H; y++) {
        for (int x = 0; x < W; x++) {
            double inside = ball.radius - hypot(x + 0.5 - ball.x, y + 0.5 - ball.y);

            for (int c = 0; c < 3; c++) {
                double got = value_of(codes[3 * (y * W + x) + c]);

                if (inside > 5.0)
                    near(got, ball.object[c], 0.02);
                else if (inside < -6.0)
                    near(got, 0.5 * shadow_at(&ball, x + 0.5, y + 0.5), 0.025);
            }
        }
    }
    near(value_of(codes[3 * (70 * W + 100)]), 0.2, 0.015);
    free(codes);
    ttf_shadow_free(&shadow);
}

static void no_ground_fringes_the_object(void **state)
{
    struct photo photo = ball;
    struct ttf_shadow shadow;
    uint16_t *codes;

    (void)state;
    photo.ground[0] = photo.ground[1] = 0.1;
    photo.ground[2] = 1.0;
    photo.depth = 0.0;
    shadow = found_in(&photo, 0, 0);
    codes = plain_frame(&shadow, 0.2); /* no more blue anywhere than texture or object have */
    ttf_shadow_compose(&shadow, &captured, NULL, codes);
    for (int i = 0; i < W * H; i++)
        assert_true(value_of(codes[3 * i + 2]) < 0.22);
    free(codes);
    ttf_shadow_free(&shadow);
}

static void light_that_nothing_shades_keeps_its_codes_for_any_number_of_threads(void **state)
{
    struct ttf_shadow shadow = found_in(&ball, 0, 0);
    struct ttf_pool *pool = ttf_pool_create(3);
    uint16_t *a = plain_frame(&shadow, 0.7), *b = plain_frame(&shadow, 0.7);

    (void)state;
    assert_non_null(pool);
    for (int i = 0; i < W * 10; i++) {
        shadow.shade[i] = 1.0f;
        for (int c = 0; c < 3; c++)
            a[3 * i + c] = b[3 * i + c] = (uint16_t)(i * 37 + c); /* below the pedestal, too */
    }
    ttf_shadow_compose(&shadow, &captured, NULL, a);
    ttf_shadow_compose(&shadow, &captured, pool, b);
    for (int i = 0; i < W * 10 * 3; i++)
        assert_int_equal(a[i], (uint16_t)(i / 3 * 37 + i % 3));
    assert_memory_equal(a, b, W * H * 6);
    free(a);
    free(b);
    ttf_pool_destroy(pool);
    ttf_shadow_free(&shadow);
}

static void photo_refused(const struct photo *photo, const char *words)
{
    struct ttf_pixbuf buf = photograph(photo);
    struct ttf_shadow_config config;
    struct ttf_shadow shadow = {0};
    struct ttf_err err = {0};

    ttf_shadow_defaults(&config);
    assert_int_equal(ttf_shadow_find(&config, &buf, 0, 0, &shadow, &err), -EINVAL);
    assert_string_equal(err.where, "photograph");
    if (!strstr(err.what, words))
        fail_msg("\"%s\" says nothing of \"%s\"", err.what, words);
    assert_true(err.hint[0] != '\0');
    assert_null(shadow.shade);
    ttf_pixbuf_free(&buf);
}

static void a_photograph_that_shows_no_object_is_refused(void **state)
{
    struct photo photo = ball;

    (void)state;
    photo.radius = 0.0; /* only a shadow, by something outside */
    photo_refused(&photo, "no object");
    photo.depth = 0.0;
    photo_refused(&photo, "no object");
    photo.noise = 0.0;
    photo_refused(&photo, "no object");
    photo.noise = 0.05;
    photo_refused(&photo, "no object");
    photo.noise = 0.15;
    photo_refused(&photo, "the ground's own");
    photo = ball;
    for (int c = 0; c < 3; c++) /* as bright or dark as it may be, of the same colour */
        photo.object[c] = 0.5 * photo.ground[c];
    photo_refused(&photo, "no object");
}

static void grounds_that_cannot_serve_are_refused(void **state)
{
    struct photo photo = ball;
    struct ttf_pixbuf buf;
    struct ttf_shadow_config config;
    struct ttf_shadow shadow = {0};
    struct ttf_err err = {0};

    (void)state;
    for (int c = 0; c < 3; c++)
        photo.ground[c] = 0.01;
    photo_refused(&photo, "too dark");
    buf = photograph(&ball); /* stripes all across in both directions */
    for (int y = 0; y < H; y++)
        for (int x = 0; x < W; x++)
            if (abs(x - 80) < 8 || abs(y - 60) < 8)
                memcpy((uint16_t *)ttf_pixbuf_row(&buf, (uint32_t)y) + 3 * x,
                       (uint16_t[3]){45000, 20000, 6000}, 6);
    ttf_shadow_defaults(&config);
    assert_int_equal(ttf_shadow_find(&config, &buf, 0, 0, &shadow, &err), -EINVAL);
    assert_non_null(strstr(err.what, "all four borders"));
    assert_true(err.hint[0] != '\0');
    ttf_pixbuf_free(&buf);
}

static void a_threshold_may_be_given(void **state)
{
    struct ttf_pixbuf buf = photograph(&ball);
    struct ttf_shadow_config config;
    struct ttf_shadow shadow = {0};
    struct ttf_err err = {0};

    (void)state;
    ttf_shadow_defaults(&config);
    config.threshold = 0.15;
    assert_int_equal(ttf_shadow_find(&config, &buf, 0, 0, &shadow, NULL), 0);
    assert_true(shadow.threshold == 0.15);
    disk_is_found(&ball, &shadow, 1.0);
    ttf_shadow_free(&shadow);
    config.threshold = 0.9;
    assert_int_equal(ttf_shadow_find(&config, &buf, 0, 0, &shadow, &err), -EINVAL);
    assert_non_null(strstr(err.what, "no object"));
    ttf_pixbuf_free(&buf);
}

static void the_edge_is_as_soft_as_asked(void **state)
{
    struct ttf_pixbuf buf = photograph(&ball);
    struct ttf_shadow_config config;
    struct ttf_shadow shadow = {0};

    (void)state;
    ttf_shadow_defaults(&config);
    assert_true(config.least == 0.2 && config.threshold == 0.0 && config.soften_px == 1.0);
    config.soften_px = 0.0;
    assert_int_equal(ttf_shadow_find(&config, &buf, 0, 0, &shadow, NULL), 0);
    for (int i = 0; i < W * H; i++)
        assert_true(shadow.alpha[i] == 0.0f || shadow.alpha[i] == 1.0f);
    ttf_shadow_free(&shadow);
    config.soften_px = 4.0;
    assert_int_equal(ttf_shadow_find(&config, &buf, 0, 0, &shadow, NULL), 0);
    near(shadow.alpha[50 * W + 70 - 22 - 4], 0.16, 0.06); /* one sigma outside an edge */
    near(shadow.alpha[50 * W + 70 - 22 + 3], 0.82, 0.06);
    ttf_shadow_free(&shadow);
    ttf_pixbuf_free(&buf);
}

static void impossible_settings_are_refused_by_name(void **state)
{
    struct ttf_pixbuf buf = photograph(&ball), grey = {0};
    struct ttf_shadow_config good, bad;
    struct ttf_shadow shadow = {0};
    struct ttf_err err = {0};

    (void)state;
    ttf_shadow_defaults(&good);
#define REFUSED(field, value, name)                                                  \
    do {                                                                             \
        bad = good;                                                                  \
        bad.field = (value);                                                         \
        assert_int_equal(ttf_shadow_find(&bad, &buf, 0, 0, &shadow, &err), -EINVAL); \
        assert_string_equal(err.where, name);                                        \
    } while (0)
    REFUSED(least, 1.5, "least");
    REFUSED(least, (double)NAN, "least");
    REFUSED(threshold, 1.0, "threshold");
    REFUSED(threshold, (double)NAN, "threshold");
    REFUSED(soften_px, -1.0, "soften");
    REFUSED(soften_px, 100.0, "soften");
#undef REFUSED
    assert_int_equal(ttf_shadow_find(&good, &buf, 8, 0, &shadow, &err), -EINVAL);
    assert_string_equal(err.where, "size");
    assert_int_equal(ttf_pixbuf_alloc(&grey, W, H, 1, TTF_SAMPLE_U16), 0);
    assert_int_equal(ttf_shadow_find(&good, &grey, 0, 0, &shadow, &err), -EINVAL);
    assert_string_equal(err.where, "photograph");
    assert_null(shadow.shade);
    ttf_pixbuf_free(&grey);
    ttf_pixbuf_free(&buf);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_object_is_found_within_a_pixel),
        cmocka_unit_test(the_shade_is_the_shadow_s),
        cmocka_unit_test(a_dark_object_does_not_darken_the_ground_beside_it),
        cmocka_unit_test(under_the_object_the_shade_goes_on_from_around_it),
        cmocka_unit_test(the_rates_are_as_asked),
        cmocka_unit_test(another_size_shows_the_same),
        cmocka_unit_test(an_object_and_shadow_that_reach_the_border_leave_the_ground_alone),
        cmocka_unit_test(a_whole_side_may_be_the_object_s),
        cmocka_unit_test(noise_does_not_fray_the_outline),
        cmocka_unit_test(dark_parts_and_highlights_belong_to_the_object),
        cmocka_unit_test(the_object_lies_over_a_shaded_texture),
        cmocka_unit_test(no_ground_fringes_the_object),
        cmocka_unit_test(light_that_nothing_shades_keeps_its_codes_for_any_number_of_threads),
        cmocka_unit_test(a_photograph_that_shows_no_object_is_refused),
        cmocka_unit_test(grounds_that_cannot_serve_are_refused),
        cmocka_unit_test(a_threshold_may_be_given),
        cmocka_unit_test(the_edge_is_as_soft_as_asked),
        cmocka_unit_test(impossible_settings_are_refused_by_name),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
