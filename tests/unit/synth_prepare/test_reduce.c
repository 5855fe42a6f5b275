/* SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "pictures.h"
#include "ttf/base/time.h"
#include "ttf/synth/prepare.h"

static double any(const void *ctx, double x, double y, uint32_t t, int c)
{
    (void)ctx;
    return chance((uint32_t)x + 4096u * (uint32_t)y, t, (uint32_t)c);
}

static struct ttf_sequence *reduced(struct ttf_sequence *input, uint32_t shrink, uint32_t step)
{
    struct ttf_sequence *made = NULL;
    struct ttf_err err = {0};

    if (ttf_reduce_create(input, shrink, step, &made, &err) < 0)
        fail_msg("%s", err.what);
    return made;
}

static void each_pixel_is_the_mean_of_those_it_stands_for(void **state)
{
    struct pictures input = pictures_make(23, 17, 7, &captured, any, NULL);
    struct ttf_sequence *made = reduced(input.sequence, 3, 2);

    (void)state;
    assert_true(made->width == 7 && made->height == 5 && made->n == 4);
    for (uint32_t t = 0; t < made->n; t++) {
        uint16_t *codes = frame_of(made, t);

        for (size_t i = 0; i < (size_t)7 * 5 * 3; i++) {
            size_t x = i / 3 % 7 * 3, y = i / 21 * 3, sum = 0;

            for (size_t k = 0; k < 9; k++)
                sum += input.codes[(((size_t)t * 2 * 17 + y + k / 3) * 23 + x + k % 3) * 3 + i % 3];
            assert_int_equal(codes[i], (sum + 4) / 9);
        }
        free(codes);
    }
    assert_reads_by_rows(made);
    ttf_sequence_destroy(made);
    pictures_free(&input);
}

static double white(const void *ctx, double x, double y, uint32_t t, int c)
{
    (void)ctx;
    (void)x;
    (void)y;
    (void)t;
    (void)c;
    return 1.0;
}

static void many_bright_pixels_still_add_up(void **state)
{
    struct pictures input = pictures_make(300, 300, 1, &imported, white, NULL);
    struct ttf_sequence *made = reduced(input.sequence, 300, 1);
    uint16_t *codes = frame_of(made, 0);

    (void)state;
    assert_true(made->width == 1 && made->height == 1);
    assert_true(codes[0] == 65535 && codes[2] == 65535);
    free(codes);
    ttf_sequence_destroy(made);
    pictures_free(&input);
}

static void frames_keep_their_index_and_time(void **state)
{
    struct pictures input = pictures_make(4, 4, 11, &imported, any, NULL);
    struct ttf_sequence *made = reduced(input.sequence, 1, 5), *again;

    (void)state;
    assert_int_equal(made->n, 3);
    for (uint32_t t = 0; t < 3; t++) {
        uint16_t *codes = frame_of(made, t);

        assert_int_equal(made->index[t], 5 * t);
        assert_true(made->time_ns[t] == 5 * t * TTF_NS_PER_S);
        assert_memory_equal(codes, input.codes + (size_t)t * 5 * 48, 96);
        free(codes);
    }
    again = reduced(made, 2, 2); /* a preview of a preview */
    assert_true(again->n == 2 && again->index[1] == 10 && again->width == 2);
    ttf_sequence_destroy(again);
    ttf_sequence_destroy(made);
    pictures_free(&input);
}

static void nothing_less_is_the_same(void **state)
{
    struct pictures input = pictures_make(9, 8, 3, &captured, any, NULL);
    struct ttf_sequence *made = reduced(input.sequence, 1, 1);

    (void)state;
    assert_same_frames(made, input.sequence);
    ttf_sequence_destroy(made);
    made = reduced(input.sequence, 1, UINT32_MAX); /* the first frame remains */
    assert_true(made->n == 1 && made->time_ns[0] == 0);
    ttf_sequence_destroy(made);
    pictures_free(&input);
}

static void refused(struct ttf_sequence *input, uint32_t shrink, uint32_t step, const char *where)
{
    struct ttf_sequence *made = NULL;
    struct ttf_err err = {0};

    assert_int_equal(ttf_reduce_create(input, shrink, step, &made, &err), -EINVAL);
    assert_string_equal(err.where, where);
    assert_true(!made && err.what[0] != '\0');
}

static void what_makes_no_sense_is_refused_by_name(void **state)
{
    struct pictures input = pictures_make(9, 8, 3, &captured, any, NULL);
    struct ttf_sequence broken = unreadable_from(2, 3), *made;
    uint16_t *codes = malloc((size_t)40 * 36 * 6);
    struct ttf_err err = {0};

    (void)state;
    assert_non_null(codes);
    refused(input.sequence, 0, 1, "shrink");
    refused(input.sequence, 1, 0, "step");
    refused(input.sequence, 9, 1, "shrink");
    made = reduced(&broken, 2, 2);
    assert_int_equal(ttf_sequence_read_rows(made, 0, 0, 18, codes, &err), 0);
    assert_int_equal(ttf_sequence_read_rows(made, 1, 0, 18, codes, &err), -EIO);
    free(codes);
    ttf_sequence_destroy(made);
    pictures_free(&input);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(each_pixel_is_the_mean_of_those_it_stands_for),
        cmocka_unit_test(many_bright_pixels_still_add_up),
        cmocka_unit_test(frames_keep_their_index_and_time),
        cmocka_unit_test(nothing_less_is_the_same),
        cmocka_unit_test(what_makes_no_sense_is_refused_by_name),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
