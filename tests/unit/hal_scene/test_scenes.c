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

#include "ttf/hal/sim.h"

#define W    204u
#define H    153u
#define N    (W * H)
#define SPAN INT64_C(1000000000000)

/* Those that change. */
static const char *const living[] = {"grass", "copper", "paint", "banana", "snow"};

static struct ttf_scene scene_of(const char *name, uint64_t seed)
{
    struct ttf_scene s;

    assert_int_equal(ttf_scene_procedural(name, seed, SPAN, &s, NULL), 0);
    return s;
}

static void draw_size(const struct ttf_scene *s, double phase, uint32_t w, uint32_t h, float *rgb)
{
    assert_int_equal(s->ops->render(s->priv, (int64_t)(phase * SPAN), w, h, rgb, NULL), 0);
}

static void draw(const struct ttf_scene *s, double phase, float *rgb)
{
    draw_size(s, phase, W, H, rgb);
}

static float *picture(void)
{
    float *p = malloc(sizeof(*p) * 3 * N);

    assert_non_null(p);
    return p;
}

static double mean_difference(const float *p, const float *q)
{
    double sum = 0.0;

    for (unsigned i = 0; i < 3 * N; i++)
        sum += fabs((double)p[i] - q[i]);
    return sum / (3 * N);
}

static void scenes_are_listed_and_an_unknown_one_is_refused_with_the_list(void **state)
{
    struct ttf_scene s;
    struct ttf_err err = {0};
    unsigned n = 0;

    for (; ttf_scene_name(n); n++) {
        s = scene_of(ttf_scene_name(n), 1);
        s.ops->destroy(s.priv);
    }
    assert_int_equal(n, 8);
    assert_int_equal(ttf_scene_procedural("gras", 1, SPAN, &s, &err), -ENOENT);
    assert_non_null(strstr(err.what, "gras"));
    assert_non_null(strstr(err.hint, "grass, copper, paint"));
    assert_int_equal(ttf_scene_procedural("grass", 1, 0, &s, &err), -EINVAL);
}

static void a_picture_is_the_same_whatever_was_asked_before(void **state)
{
    static const double order[] = {0.7, 0.2, 1.0};
    float *p = picture(), *q = picture(), *small = picture();

    for (unsigned k = 0; k < 5; k++) {
        struct ttf_scene used = scene_of(living[k], 3);

        draw_size(&used, 0.9, 50, 60, small);
        for (unsigned i = 0; i < 3; i++) {
            struct ttf_scene fresh = scene_of(living[k], 3);

            draw(&used, order[i], p);
            draw_size(&used, order[i], 40 + i, 30, small);
            draw(&used, order[i], p);
            draw_size(&used, order[i], W, 20, small); /* as wide, not as high */
            draw_size(&fresh, order[i], W, 20, q);
            assert_memory_equal(small, q, sizeof(*p) * 3 * W * 20);
            draw(&used, order[i], p);
            draw(&fresh, order[i], q);
            fresh.ops->destroy(fresh.priv);
            assert_memory_equal(p, q, sizeof(*p) * 3 * N);
        }
        used.ops->destroy(used.priv);
    }
    free(p);
    free(q);
    free(small);
}

static void another_seed_is_another_sample(void **state)
{
    float *p = picture(), *q = picture();

    for (unsigned k = 0; k < 5; k++) {
        struct ttf_scene one = scene_of(living[k], 1), two = scene_of(living[k], 2);

        draw(&one, 0.6, p);
        draw(&two, 0.6, q);
        assert_true(mean_difference(p, q) > 0.02);
        one.ops->destroy(one.priv);
        two.ops->destroy(two.priv);
    }
    free(p);
    free(q);
}

static void reflectances_lie_between_nothing_and_everything(void **state)
{
    float *p = picture();

    for (unsigned k = 0; ttf_scene_name(k); k++) {
        struct ttf_scene s = scene_of(ttf_scene_name(k), 4);
        unsigned full = 0;

        for (int t = -1; t <= 3; t++) {
            draw(&s, 0.5 * t, p);
            for (unsigned i = 0; i < 3 * N; i++) {
                assert_true(p[i] >= 0.0f && p[i] <= 1.0f);
                full += p[i] >= 1.0f;
            }
        }
        assert_true(full < 5 * 3 * N / 1000); /* clipping is no look */
        s.ops->destroy(s.priv);
    }
    free(p);
}

static void before_its_beginning_and_after_its_end_a_sample_rests(void **state)
{
    float *p = picture(), *q = picture();

    for (unsigned k = 0; k < 5; k++) {
        struct ttf_scene s = scene_of(living[k], 4);

        draw(&s, 0.0, p);
        draw(&s, -2.0, q);
        assert_memory_equal(p, q, sizeof(*p) * 3 * N);
        draw(&s, 1.0, p);
        draw(&s, 3.0, q);
        assert_memory_equal(p, q, sizeof(*p) * 3 * N);
        s.ops->destroy(s.priv);
    }
    free(p);
    free(q);
}

static void chart_and_white_target_never_change(void **state)
{
    float *p = picture(), *q = picture();
    struct ttf_scene chart = scene_of("chart", 1), white = scene_of("white", 1);

    draw(&chart, 0.0, p);
    draw(&chart, 0.8, q);
    assert_memory_equal(p, q, sizeof(*p) * 3 * N);
    /* The last patch of each row is in its place: a grey of 3.1 % at the lower right. */
    assert_float_equal(p[3 * ((H - 18) * W + W - 16) + 1], 0.031f, 1e-6);
    draw(&white, 0.5, p);
    for (unsigned i = 0; i < 3 * N; i++)
        assert_true(p[i] == 0.9f);
    chart.ops->destroy(chart.priv);
    white.ops->destroy(white.priv);
    free(p);
    free(q);
}

#define TIMES 9

/*
 * How much of the variance over time the best blend of the first and last picture explains,
 * a weight chosen for each time: 1 for a cross-fade.
 */
static double blend_explains(float *const frame[TIMES])
{
    const float *first = frame[0], *last = frame[TIMES - 1];
    double span = 0.0, left = 0.0, total = 0.0;

    for (unsigned i = 0; i < 3 * N; i++)
        span += ((double)last[i] - first[i]) * (last[i] - first[i]);
    for (unsigned t = 1; t + 1 < TIMES; t++) {
        double along = 0.0, whole = 0.0;

        for (unsigned i = 0; i < 3 * N; i++) {
            along += ((double)frame[t][i] - first[i]) * (last[i] - first[i]);
            whole += ((double)frame[t][i] - first[i]) * (frame[t][i] - first[i]);
        }
        left += whole - along * along / span;
    }
    for (unsigned i = 0; i < 3 * N; i++) {
        double sum = 0.0, squares = 0.0;

        for (unsigned t = 0; t < TIMES; t++) {
            sum += frame[t][i];
            squares += (double)frame[t][i] * frame[t][i];
        }
        total += squares - sum * sum / TIMES;
    }
    return 1.0 - left / total;
}

static void samples_change_by_what_appears_and_not_by_a_fade(void **state)
{
    float *frame[TIMES];

    for (unsigned t = 0; t < TIMES; t++)
        frame[t] = picture();
    for (unsigned k = 0; k < 5; k++) {
        struct ttf_scene s = scene_of(living[k], 6);

        for (unsigned t = 0; t < TIMES; t++)
            draw(&s, (double)t / (TIMES - 1), frame[t]);
        s.ops->destroy(s.priv);
        print_message("%s: the best fade explains %.2f\n", living[k], blend_explains(frame));
        assert_true(blend_explains(frame) < 0.8);
    }
    /* The measure itself: a fade between the same ends is recognised. */
    for (unsigned t = 1; t + 1 < TIMES; t++) {
        const float u = (float)t / (TIMES - 1);

        for (unsigned i = 0; i < 3 * N; i++)
            frame[t][i] = frame[0][i] + u * u * (frame[TIMES - 1][i] - frame[0][i]);
    }
    assert_true(blend_explains(frame) > 0.999);
    for (unsigned t = 0; t < TIMES; t++)
        free(frame[t]);
}

static void pictures_follow_one_another_without_jumps(void **state)
{
    float *p = picture(), *q = picture(), *r = picture();

    for (unsigned k = 0; k < 5; k++) {
        struct ttf_scene s = scene_of(living[k], 8);
        double whole, step = 0.0, half = 0.0;

        draw(&s, 0.0, p);
        draw(&s, 1.0, q);
        whole = mean_difference(p, q);
        for (int t = 0; t < 5; t++) {
            const double phase = 0.1 + 0.2 * t;

            draw(&s, phase, p);
            draw(&s, phase + 0.001, q);
            draw(&s, phase + 0.0005, r);
            step += mean_difference(p, q) / 5.0;
            half += mean_difference(p, r) / 5.0;
        }
        s.ops->destroy(s.priv);
        /* A thousandth of the time does not move more than a few thousandths, and always something. */
        assert_true(step > 0.0 && step < 0.02 * whole);
        /* Change is in proportion to time: no flicker that differs from picture to picture. */
        assert_float_equal(half / step, 0.5, 0.12);
    }
    free(p);
    free(q);
    free(r);
}

/* Marks what has appeared: the sample's new matter, told by its colour. */
typedef int (*appeared_fn)(const float *rgb);

static int is_leaf(const float *c)
{
    return c[1] > 1.25f * c[0] && c[1] > 0.05f;
}

static int is_verdigris(const float *c)
{
    return c[1] > 1.5f * c[0];
}

static int is_wood(const float *c)
{
    return c[1] > 0.33f * c[0];
}

static int is_brown(const float *c)
{
    return c[0] < 0.33f && c[0] > 1.3f * c[1];
}

static int is_snow(const float *c)
{
    return c[1] > 0.4f;
}

static void what_has_appeared_grows_and_stays(void **state)
{
    static const appeared_fn appeared[] = {is_leaf, is_verdigris, is_wood, is_brown, is_snow};
    /* Blades bend and hide one another; the others do not move at all. */
    static const double lost_at_most[] = {0.12, 0.005, 0.005, 0.005, 0.02};
    static const double end_at_least[] = {0.6, 0.2, 0.1, 0.15, 0.9};
    float *now = picture();
    unsigned char *was = malloc(N);

    assert_non_null(was);
    for (unsigned k = 0; k < 5; k++) {
        struct ttf_scene s = scene_of(living[k], 5);
        unsigned before = 0;

        memset(was, 0, N);
        for (int t = 0; t <= 20; t++) {
            unsigned count = 0, lost = 0;

            draw(&s, t / 20.0, now);
            for (unsigned i = 0; i < N; i++) {
                const int is = appeared[k](now + 3 * i);

                lost += was[i] && !is;
                count += is != 0;
                was[i] = (unsigned char)is;
            }
            if (t == 0)
                assert_true(count < 0.01 * N);
            assert_true(count + 0.004 * N >= before);
            assert_true(lost <= lost_at_most[k] * before + 4);
            before = count;
        }
        print_message("%s: %.2f of the sample at the end\n", living[k], (double)before / N);
        assert_true(before > end_at_least[k] * N);
        s.ops->destroy(s.priv);
    }
    free(now);
    free(was);
}

static double edge_energy(const float *p)
{
    double sum = 0.0;

    for (unsigned y = 0; y < H; y++) {
        for (unsigned x = 1; x < W; x++)
            sum += fabs((double)p[3 * (y * W + x) + 1] - p[3 * (y * W + x - 1) + 1]);
    }
    return sum / N;
}

static void structure_rises_from_a_plain_beginning(void **state)
{
    float *p = picture();

    /* Snow begins on rough slate and ends smooth; its structure is greatest between. */
    for (unsigned k = 0; k < 5; k++) {
        const double peak = strcmp(living[k], "snow") == 0 ? 0.5 : 1.0;
        struct ttf_scene s = scene_of(living[k], 9);
        double begin;

        draw(&s, 0.0, p);
        begin = edge_energy(p);
        draw(&s, peak, p);
        print_message("%s: edges %.4f -> %.4f\n", living[k], begin, edge_energy(p));
        assert_true(edge_energy(p) > 1.5 * begin);
        s.ops->destroy(s.priv);
    }
    free(p);
}

static void a_larger_picture_shows_the_same_sample(void **state)
{
    float *p = picture(), *big = malloc(sizeof(*big) * 3 * N * 16);

    assert_non_null(big);
    for (unsigned k = 0; k < 5; k++) {
        struct ttf_scene s = scene_of(living[k], 2);
        double cross = 0.0, pp = 0.0, qq = 0.0, mp = 0.0, mq = 0.0;

        draw(&s, 0.6, p);
        draw_size(&s, 0.6, 4 * W, 4 * H, big);
        s.ops->destroy(s.priv);
        for (unsigned pass = 0; pass < 2; pass++) {
            for (unsigned y = 0; y < H; y++) {
                for (unsigned x = 0; x < W; x++) {
                    double q = 0.0;
                    const double v = p[3 * (y * W + x) + 1];

                    for (unsigned j = 0; j < 16; j++)
                        q += big[3 * ((4 * y + j / 4) * 4 * W + 4 * x + j % 4) + 1] / 16.0;
                    if (pass == 0) {
                        mp += v / N;
                        mq += q / N;
                    } else {
                        cross += (v - mp) * (q - mq);
                        pp += (v - mp) * (v - mp);
                        qq += (q - mq) * (q - mq);
                    }
                }
            }
        }
        print_message("%s: correlation over sizes %.3f\n", living[k], cross / sqrt(pp * qq));
        /* Flakes here are smaller than the small picture's pixels: they agree least. */
        assert_true(cross / sqrt(pp * qq) > 0.8);
        assert_float_equal(mp, mq, 0.02);
    }
    free(p);
    free(big);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(scenes_are_listed_and_an_unknown_one_is_refused_with_the_list),
        cmocka_unit_test(a_picture_is_the_same_whatever_was_asked_before),
        cmocka_unit_test(another_seed_is_another_sample),
        cmocka_unit_test(reflectances_lie_between_nothing_and_everything),
        cmocka_unit_test(before_its_beginning_and_after_its_end_a_sample_rests),
        cmocka_unit_test(chart_and_white_target_never_change),
        cmocka_unit_test(samples_change_by_what_appears_and_not_by_a_fade),
        cmocka_unit_test(pictures_follow_one_another_without_jumps),
        cmocka_unit_test(what_has_appeared_grows_and_stays),
        cmocka_unit_test(structure_rises_from_a_plain_beginning),
        cmocka_unit_test(a_larger_picture_shows_the_same_sample),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
