/* SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <errno.h>
#include <math.h>

#include "made.h"
#include "ttf/synth/rate_map.h"

static struct ttf_rate_map lit(const struct ttf_light *light, uint32_t width, uint32_t height)
{
    struct ttf_rate_map map = {0};
    struct ttf_err err = {0};

    if (ttf_rate_map_of_light(light, width, height, &map, &err) < 0)
        fail_msg("%s: %s", err.where, err.what);
    return map;
}

static void near(double got, double want, double by)
{
    if (!(fabs(got - want) <= by))
        fail_msg("%.9g is not within %g of %.9g", got, by, want);
}

static void under_the_light_the_rate_is_one_and_falls_off_as_eq_9_has_it(void **state)
{
    struct ttf_light light = {.x = 0.5, .y = 0.5, .z = 0.4, .gain = 1.0};
    struct ttf_rate_map map = lit(&light, 51, 51);

    (void)state;
    assert_true(made_at(&map, 25, 25) == 1.0f);
    for (uint32_t y = 0; y < 51; y += 5) {
        for (uint32_t x = 0; x < 51; x++) {
            double dx = (x - 25.0) / 51, dy = (y - 25.0) / 51;
            double r2 = (dx * dx + dy * dy + 0.16) / 0.16, cosine = 1.0 / sqrt(r2);

            near(made_at(&map, x, y), pow(cosine / r2, 2.0), 1e-6);
        }
    }
    ttf_rate_map_free(&map);
}

static void lengths_are_in_widths_and_y_runs_down(void **state)
{
    struct ttf_light light = {.x = 0.75, .y = 0.25, .z = 0.1, .offset = 0.5, .gain = 2.0};
    struct ttf_rate_map map = lit(&light, 40, 60);

    (void)state;
    for (uint32_t y = 0; y < 60; y++)
        for (uint32_t x = 0; x < 40; x++)
            assert_true(made_at(&map, x, y) <=
                        made_at(&map, 29, 9) + 1e-6f); /* 30 and 10 touch it */
    assert_true(made_at(&map, 30, 10) > 2.3f && made_at(&map, 30, 10) <= 2.5f);
    near(made_at(&map, 0, 59), 0.5, 1e-3);
    ttf_rate_map_free(&map);
}

static void a_light_beside_the_picture_still_gives_at_most_one(void **state)
{
    struct ttf_light light = {.x = -1.0, .y = 0.5, .z = 0.5, .gain = 1.0};
    struct ttf_rate_map map = lit(&light, 20, 20);
    float least, most;

    (void)state;
    ttf_rate_map_range(&map, &least, &most);
    assert_true(most <= 1.0f && most > 0.1f); /* cos q is about 0.44 there */
    assert_true(made_at(&map, 0, 10) > made_at(&map, 19, 10));
    ttf_rate_map_free(&map);
}

static void a_normal_turned_away_gets_nothing_and_one_towards_the_light_all(void **state)
{
    struct ttf_light light = {.x = 0.5, .y = 1000.5, .z = 1000.0, .gain = 1.0};
    struct ttf_pixbuf away = made_plain(9, 9, 0.5, 1.0, 0.5);                /* up the picture */
    struct ttf_pixbuf towards = made_plain(9, 9, 0.5, 0.1464466, 0.8535534); /* down, 45 degrees */
    struct ttf_pixbuf flat = made_plain(9, 9, 0.5, 0.5, 1.0);
    struct ttf_rate_map map;

    (void)state;
    light.normals = &away;
    map = lit(&light, 9, 9);
    assert_true(made_at(&map, 4, 4) == 0.0f);
    ttf_rate_map_free(&map);
    light.normals = &towards;
    map = lit(&light, 9, 9);
    near(made_at(&map, 4, 4), 1.0, 3e-3);
    ttf_rate_map_free(&map);
    light.normals = &flat;
    map = lit(&light, 9, 9);
    near(made_at(&map, 4, 4), 0.5, 3e-3); /* cos 45 degrees, squared */
    ttf_rate_map_free(&map);
    ttf_pixbuf_free(&away);
    ttf_pixbuf_free(&towards);
    ttf_pixbuf_free(&flat);
}

static void flat_normals_are_the_plane_and_their_length_does_not_matter(void **state)
{
    struct ttf_light light = {.x = 0.3, .y = 0.4, .z = 0.4, .gain = 1.0};
    struct ttf_pixbuf flat = made_plain(30, 20, 0.5, 0.5, 0.9);
    struct ttf_pixbuf none = made_plain(30, 20, 128 / 255.0, 128 / 255.0, 128 / 255.0);
    struct ttf_rate_map plane = lit(&light, 30, 20), map;

    (void)state;
    light.normals = &flat;
    map = lit(&light, 30, 20);
    for (uint32_t i = 0; i < 600; i++)
        near(map.m[i], plane.m[i], 1e-6);
    ttf_rate_map_free(&map);
    light.normals = &none; /* mid-grey: a normal of no length */
    map = lit(&light, 30, 20);
    for (uint32_t i = 0; i < 600; i++)
        near(map.m[i], plane.m[i], 1e-6);
    ttf_rate_map_free(&map);
    ttf_rate_map_free(&plane);
    ttf_pixbuf_free(&flat);
    ttf_pixbuf_free(&none);
}

/* Rises to the right by 0.6 and downwards by 0.3 of the way, with height_scale 2 */
static double slope(double x, double y)
{
    return 0.3 * x + 0.15 * y;
}

static void heights_of_a_tilted_plane_are_its_normal_map(void **state)
{
    /* so far away that raising the surface means nothing */
    struct ttf_light light = {.x = -4000.0, .y = -2500.0, .z = 9000.0, .gain = 1.0};
    struct ttf_pixbuf heights = made_grey(32, 24, slope), normals;
    double l = sqrt(0.36 + 0.09 + 1.0);
    struct ttf_rate_map a, b;

    (void)state;
    normals = made_plain(32, 24, 0.5 - 0.3 / l, 0.5 + 0.15 / l, 0.5 + 0.5 / l);
    light.normals = &normals;
    a = lit(&light, 32, 24);
    light.normals = NULL;
    light.heights = &heights;
    light.height_scale = 2.0;
    b = lit(&light, 32, 24);
    assert_true(made_at(&a, 0, 0) > 0.9f); /* it looks at the light; flat: 0.78 */
    for (uint32_t i = 0; i < 32 * 24; i++)
        near(b.m[i], a.m[i], 1e-3);
    ttf_rate_map_free(&a);
    ttf_rate_map_free(&b);
    ttf_pixbuf_free(&heights);
    ttf_pixbuf_free(&normals);
}

static double block(double x, double y)
{
    (void)y;
    return x < 0.5 ? 0.0 : 1.0;
}

static void heights_raise_the_surface_towards_the_light(void **state)
{
    struct ttf_light light = {.x = 0.5, .y = 0.5, .z = 1.0, .gain = 1.0, .height_scale = 0.5};
    struct ttf_pixbuf heights = made_grey(40, 40, block);
    struct ttf_rate_map map;

    (void)state;
    light.heights = &heights;
    map = lit(&light, 40, 40);
    near(made_at(&map, 21, 19), 1.0, 0.02);
    near(made_at(&map, 18, 19), 1.0 / 16.0, 0.005); /* twice as far: (1 / 2^2)^2 */
    ttf_rate_map_free(&map);
    ttf_pixbuf_free(&heights);
}

static void light_refused(struct ttf_light light, const char *where)
{
    struct ttf_rate_map map = {0};
    struct ttf_err err = {0};

    made_refused(ttf_rate_map_of_light(&light, 16, 16, &map, &err), -EINVAL, where, &err, &map);
}

static void impossible_lights_are_refused(void **state)
{
    struct ttf_light good = {.x = 0.5, .y = 0.5, .z = 0.4, .gain = 1.0}, bad;
    struct ttf_pixbuf heights = made_grey(16, 16, slope);
    struct ttf_pixbuf normals = made_plain(16, 16, 0.5, 0.5, 1.0);
    struct ttf_rate_map map = {0};
    struct ttf_err err = {0};

    (void)state;
#define REFUSED(field, value, where) \
    do {                             \
        bad = good;                  \
        bad.field = (value);         \
        light_refused(bad, where);   \
    } while (0)
    REFUSED(z, 0.0, "light");
    REFUSED(z, -1.0, "light");
    REFUSED(x, (double)NAN, "light");
    REFUSED(gain, (double)NAN, "gain");
    REFUSED(height_scale, (double)INFINITY, "height_scale");
    REFUSED(normals, &heights, "normals"); /* grey */
    made_refused(ttf_rate_map_of_light(&good, 0, 16, &map, &err), -EINVAL, "size", &err, &map);
    good.normals = &normals;
    REFUSED(heights, &heights, "light");
    ((float *)ttf_pixbuf_row(&normals, 3))[7] = NAN;
    light_refused(good, "normals");
    good.normals = NULL;
    good.heights = &heights;
    good.height_scale = 1.0;
    good.x = good.y = 8.5 / 16;
    REFUSED(z, (double)(float)slope(8.5 / 16, 8.5 / 16), "light"); /* in the surface */
    ((float *)ttf_pixbuf_row(&heights, 3))[7] = NAN;
    light_refused(good, "heights");
#undef REFUSED
    ttf_pixbuf_free(&heights);
    ttf_pixbuf_free(&normals);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(under_the_light_the_rate_is_one_and_falls_off_as_eq_9_has_it),
        cmocka_unit_test(lengths_are_in_widths_and_y_runs_down),
        cmocka_unit_test(a_light_beside_the_picture_still_gives_at_most_one),
        cmocka_unit_test(a_normal_turned_away_gets_nothing_and_one_towards_the_light_all),
        cmocka_unit_test(flat_normals_are_the_plane_and_their_length_does_not_matter),
        cmocka_unit_test(heights_of_a_tilted_plane_are_its_normal_map),
        cmocka_unit_test(heights_raise_the_surface_towards_the_light),
        cmocka_unit_test(impossible_lights_are_refused),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
