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
#include "prepare/nudges.h"
#include "ttf/synth/prepare.h"

#define W 120u
#define H 104u

/* A scene seen by a camera that was moved: where what belongs at p is found, p + shift. */
struct scene {
    const struct shift *shift; /* per frame; NULL: never moved */
    double drift_px;           /* and this much more to the right with each frame */
    double fade;               /* how much of the scene is another one after each frame */
    double flicker;
    double noise;
    uint32_t hand; /* a frame of something else; 0: none */
    uint32_t dim;  /* a frame with a sixth of the light; 0: none */
};

static double seen(const void *ctx, double x, double y, uint32_t t, int c)
{
    const struct scene *scene = ctx;
    double sx = x - (scene->shift ? scene->shift[t].x : 0.0) - scene->drift_px * t;
    double sy = y - (scene->shift ? scene->shift[t].y : 0.0);
    double other = fmod(scene->fade * t, 1.0), value;
    unsigned picture = (unsigned)(scene->fade * t);
    uint32_t at = (uint32_t)x + 1000u * (uint32_t)y;

    if (scene->hand > 0 && t == scene->hand)
        return 0.8 * ground(x, y, 99);
    value = (1.0 - other) * ground(sx, sy, picture);
    value += other > 0.0 ? other * ground(sx, sy, picture + 1) : 0.0;
    value *= 0.5 * (1.0 - 0.1 * c) * (1.0 + scene->flicker * (chance(t, 1, 1) - 0.5));
    value *= scene->dim > 0 && t == scene->dim ? 1.0 / 6.0 : 1.0;
    return value + scene->noise * (chance(at, t, (uint32_t)c) - 0.5);
}

static struct pictures make(const struct scene *scene, uint32_t n)
{
    return pictures_make(W, H, n, &captured, seen, scene);
}

static struct ttf_sequence *stabilised(struct ttf_sequence *input, double limit_px,
                                       struct ttf_stabilise_figures *ret)
{
    struct ttf_sequence *made = NULL;
    struct ttf_err err = {0};

    if (ttf_stabilise_create(input, limit_px, &made, ret, &err) < 0)
        fail_msg("%s", err.what);
    return made;
}

static const struct shift nudges[11] = {{-3.25, 2.4}, {-3.25, 2.4}, {-3.25, 2.4}, {0.0, 0.0},
                                        {0.0, 0.0},   {0.0, 0.0},   {0.0, 0.0},   {0.45, -0.3},
                                        {0.2, 3.7},   {0.2, 3.7},   {-1.5, -2.0}};

/* The largest error of the shifts found, in pixels. */
static double worst(struct ttf_sequence *input, const struct scene *scene, double limit_px)
{
    struct shift *found = calloc(input->n, sizeof(*found));
    double most = 0.0;
    uint32_t unlike = 9, middle = input->n / 2;
    struct ttf_err err = {0};

    assert_non_null(found);
    if (ttf_nudges_find(input, limit_px, found, &unlike, &err) < 0)
        fail_msg("%s", err.what);
    assert_int_equal(unlike, 0);
    for (uint32_t t = 0; t < input->n; t++) {
        double x = scene->drift_px * ((double)t - middle), y = 0.0;

        if (scene->shift) {
            x += scene->shift[t].x - scene->shift[middle].x;
            y = scene->shift[t].y - scene->shift[middle].y;
        }
        most = fmax(most, hypot(found[t].x - x, found[t].y - y));
    }
    free(found);
    return most;
}

static void nudges_are_found_to_a_twentieth_of_a_pixel(void **state)
{
    struct scene scene = {.shift = nudges};
    struct pictures input = make(&scene, 11);

    (void)state;
    assert_true(worst(input.sequence, &scene, 6.0) < 0.05);
    pictures_free(&input);
}

static void nudges_are_found_under_flicker_noise_and_change(void **state)
{
    struct scene scene = {.shift = nudges, .flicker = 0.3, .noise = 0.06, .fade = 0.04};
    struct pictures input = make(&scene, 11);

    (void)state;
    assert_true(worst(input.sequence, &scene, 6.0) < 0.1);
    pictures_free(&input);
}

static void exposure_does_not_matter(void **state)
{
    struct scene scene = {.shift = nudges, .dim = 5}; /* the reference */
    struct pictures input = make(&scene, 11);

    (void)state;
    assert_true(worst(input.sequence, &scene, 6.0) < 0.05);
    pictures_free(&input);
}

/* The first, the middle and the last frame have nothing in common: only those in between tell where they lie. */
static void frames_in_between_carry_over_what_becomes_another_picture(void **state)
{
    static const struct shift carried[21] = {
        [2] = {-3.25, 2.4}, {-3.25, 2.4}, {-3.25, 2.4}, [16] = {2.3, 1.6},
        {2.3, 1.6},         {2.3, 1.6},   {2.3, 1.6},   {1.3, 4.6}};
    struct scene scene = {.shift = carried, .fade = 0.1};
    struct pictures input = make(&scene, 21);

    (void)state;
    assert_true(worst(input.sequence, &scene, 6.0) < 0.2);
    pictures_free(&input);
}

static void a_slow_drift_is_followed(void **state)
{
    struct scene scene = {.drift_px = 0.08, .noise = 0.02};
    struct pictures input = make(&scene, 25);

    (void)state;
    assert_true(worst(input.sequence, &scene, 5.0) < 0.1);
    pictures_free(&input);
}

static void large_shifts_are_found_within_a_large_limit(void **state)
{
    static const struct shift far[3] = {{12.0, -12.5}, {0.0, 0.0}, {-12.5, 12.0}};
    struct scene scene = {.shift = far};
    struct pictures input = make(&scene, 3);

    (void)state;
    assert_true(worst(input.sequence, &scene, 18.0) < 0.1);
    pictures_free(&input);
}

/* Root mean square difference of two frames, `a` lying at x, y in `b`, in values. */
static double difference(struct ttf_sequence *a, struct ttf_sequence *b, uint32_t t, uint32_t x0,
                         uint32_t y0)
{
    uint16_t *one = frame_of(a, t), *other = frame_of(b, t);
    double sum = 0.0;

    for (size_t y = 0; y < a->height; y++) {
        for (size_t i = 0; i < (size_t)a->width * 3; i++) {
            double d = one[y * a->width * 3 + i] - other[((y + y0) * b->width + x0) * 3 + i];

            sum += d * d;
        }
    }
    free(one);
    free(other);
    return sqrt(sum / (a->width * a->height * 3.0)) / a->encoding.scale;
}

static void nudges_are_undone(void **state)
{
    struct scene scene = {.shift = nudges}, still = {0};
    struct pictures input = make(&scene, 11), without = make(&still, 11);
    struct ttf_stabilise_figures figures;
    struct ttf_sequence *made = stabilised(input.sequence, 6.0, &figures);

    (void)state;
    assert_int_equal(figures.moved, 7);
    assert_int_equal(figures.unlike, 0);
    assert_true(fabs(figures.largest_shift_px - 4.04) < 0.05);
    assert_int_equal(figures.crop_x, 4);
    assert_int_equal(figures.crop_y, 4);
    assert_true(made->width == W - 8 && made->height == H - 8 && made->n == 11);
    for (uint32_t t = 0; t < 11; t++) {
        if (t != 7)
            assert_true(difference(input.sequence, without.sequence, t, 0, 0) > 0.03 ||
                        (t >= 3 && t <= 6));
        assert_true(difference(made, without.sequence, t, 4, 4) < 0.006);
    }
    /* those that lie where they should are cropped, not filtered */
    for (uint32_t t = 3; t < 7; t++)
        assert_true(difference(made, input.sequence, t, 4, 4) == 0.0);
    assert_reads_by_rows(made);
    ttf_sequence_destroy(made);
    pictures_free(&input);
    pictures_free(&without);
}

static void shifts_of_whole_pixels_are_undone_bit_for_bit(void **state)
{
    static const struct shift whole[3] = {{2.0, 0.0}, {0.0, 0.0}, {0.0, 0.0}};
    struct scene scene = {.shift = whole}, still = {0};
    struct pictures input = make(&scene, 3), without = make(&still, 3);
    struct ttf_stabilise_figures figures;
    struct ttf_sequence *made = stabilised(input.sequence, 0.0, &figures);

    (void)state;
    assert_true(figures.crop_x <= 3 && figures.crop_y <= 1);
    assert_true(difference(made, without.sequence, 0, figures.crop_x, figures.crop_y) < 0.0006);
    ttf_sequence_destroy(made);
    pictures_free(&input);
    pictures_free(&without);
}

static void an_unmoved_sequence_comes_out_bit_for_bit(void **state)
{
    struct scene scene = {.fade = 0.02, .noise = 0.1, .flicker = 0.2};
    struct pictures input = make(&scene, 21);
    struct ttf_stabilise_figures figures;
    struct ttf_sequence *made = stabilised(input.sequence, 0.0, &figures);

    (void)state;
    assert_same_frames(made, input.sequence);
    assert_true(figures.moved == 0 && figures.crop_x == 0 && figures.crop_y == 0);
    assert_true(figures.largest_shift_px < 0.1);
    assert_ptr_equal(made->index, input.sequence->index);
    ttf_sequence_destroy(made);
    pictures_free(&input);
}

static void a_frame_of_something_else_is_counted_and_left_where_its_neighbour_is(void **state)
{
    static const struct shift once[9] = {[6] = {2.0, 1.0}, {2.0, 1.0}, {2.0, 1.0}};
    struct scene scene = {.shift = once, .hand = 7};
    struct pictures input = make(&scene, 9);
    struct shift found[9];
    uint32_t unlike = 0;

    (void)state;
    assert_int_equal(ttf_nudges_find(input.sequence, 5.0, found, &unlike, NULL), 0);
    assert_int_equal(unlike, 1);
    for (int t = 6; t < 9; t++)
        assert_true(hypot(found[t].x - 2.0, found[t].y - 1.0) < 0.05);
    pictures_free(&input);
}

static double plain(const void *ctx, double x, double y, uint32_t t, int c)
{
    (void)ctx;
    (void)x;
    (void)y;
    return 0.1 * (1 + c) + 0.01 * t;
}

static double striped(const void *ctx, double x, double y, uint32_t t, int c)
{
    double noise = *(const double *)ctx;

    (void)c;
    return 0.3 + 0.2 * sin((x - (t == 0 ? 1.5 : 0.0)) * 0.3) +
           noise * chance((uint32_t)x, (uint32_t)y, t);
}

static void pictures_without_anything_to_hold_on_to_are_not_moved(void **state)
{
    struct pictures nothing = pictures_make(W, H, 5, &captured, plain, NULL);
    struct ttf_stabilise_figures figures;
    struct ttf_sequence *made = stabilised(nothing.sequence, 0.0, &figures);

    (void)state;
    assert_same_frames(made, nothing.sequence);
    assert_true(figures.largest_shift_px == 0.0);
    ttf_sequence_destroy(made);
    pictures_free(&nothing);
}

static void stripes_are_moved_across_and_not_along(void **state)
{
    static const double noise[] = {0.0, 0.01};

    (void)state;
    for (int i = 0; i < 2; i++) {
        struct pictures stripes = pictures_make(W, H, 5, &captured, striped, &noise[i]);
        struct ttf_stabilise_figures figures;
        struct ttf_sequence *made = stabilised(stripes.sequence, 26.0, &figures);

        assert_true(fabs(figures.largest_shift_px - 1.5) < 0.1);
        assert_int_equal(figures.crop_x, 2);
        assert_true(figures.crop_y <= 1);
        ttf_sequence_destroy(made);
        pictures_free(&stripes);
    }
}

static void one_frame_is_its_own_reference(void **state)
{
    struct scene scene = {0};
    struct pictures input = make(&scene, 1);
    struct ttf_sequence *made = stabilised(input.sequence, 0.0, NULL);

    (void)state;
    assert_same_frames(made, input.sequence);
    ttf_sequence_destroy(made);
    pictures_free(&input);
}

static void refused(struct ttf_sequence *input, double limit_px, int code, const char *where,
                    const char *what)
{
    struct ttf_stabilise_figures figures = {.moved = 7};
    struct ttf_sequence *made = NULL;
    struct ttf_err err = {0};

    assert_int_equal(ttf_stabilise_create(input, limit_px, &made, &figures, &err), code);
    assert_string_equal(err.where, where);
    assert_non_null(strstr(err.what, what));
    assert_true(!made && figures.moved == 7);
    assert_true(code != -ERANGE || err.hint[0] != '\0');
}

static void a_shift_beyond_the_limit_names_its_frame(void **state)
{
    struct scene scene = {.shift = nudges};
    static const struct shift leap[3] = {{0.0, 0.0}, {0.0, 0.0}, {14.0, 0.0}};
    struct scene leaping = {.shift = leap};
    struct pictures input = make(&scene, 11), far = make(&leaping, 3);

    (void)state;
    refused(input.sequence, 3.0, -ERANGE, "stabilise", "frame 8");
    refused(far.sequence, 3.0, -ERANGE, "stabilise", "frame 2 lies 14.0");
    pictures_free(&input);
    pictures_free(&far);
}

static void what_makes_no_sense_is_refused_by_name(void **state)
{
    struct scene scene = {0};
    struct pictures input = make(&scene, 2);
    struct pictures small = pictures_make(40, 15, 2, &captured, plain, NULL);
    struct ttf_sequence broken = unreadable_from(5, 6);

    (void)state;
    refused(input.sequence, -1.0, -EINVAL, "limit", "limit");
    refused(input.sequence, NAN, -EINVAL, "limit", "limit");
    refused(input.sequence, 26.5, -EINVAL, "limit", "26 pixels");
    refused(small.sequence, 0.0, -EINVAL, "stabilise", "40 x 15");
    refused(&broken, 0.0, -EIO, "frame", "cannot be read");
    pictures_free(&input);
    pictures_free(&small);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(nudges_are_found_to_a_twentieth_of_a_pixel),
        cmocka_unit_test(nudges_are_found_under_flicker_noise_and_change),
        cmocka_unit_test(exposure_does_not_matter),
        cmocka_unit_test(frames_in_between_carry_over_what_becomes_another_picture),
        cmocka_unit_test(a_slow_drift_is_followed),
        cmocka_unit_test(large_shifts_are_found_within_a_large_limit),
        cmocka_unit_test(nudges_are_undone),
        cmocka_unit_test(shifts_of_whole_pixels_are_undone_bit_for_bit),
        cmocka_unit_test(an_unmoved_sequence_comes_out_bit_for_bit),
        cmocka_unit_test(a_frame_of_something_else_is_counted_and_left_where_its_neighbour_is),
        cmocka_unit_test(pictures_without_anything_to_hold_on_to_are_not_moved),
        cmocka_unit_test(stripes_are_moved_across_and_not_along),
        cmocka_unit_test(one_frame_is_its_own_reference),
        cmocka_unit_test(a_shift_beyond_the_limit_names_its_frame),
        cmocka_unit_test(what_makes_no_sense_is_refused_by_name),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
