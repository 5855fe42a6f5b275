/* SPDX-License-Identifier: Apache-2.0 */
/* Raw files as other programs write them, tag by tag: what is read of them, and what is refused. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <stdio.h>
#include <string.h>

#include "scratch.h"
#include "tagged.h"
#include "ttf/base/attr.h"
#include "ttf/dataset/dng.h"

#define PIXELS 600 /* where they lie in the file */
#define TABLE  800 /* where values lie that are longer than four bytes */
#define BYTES  1024

/* A mosaic of 4 x 2, 16 bits, codes 100, 200, ... */
static const struct tag good[] = {
    {254, 4, 1, 0},
    {256, 4, 1, 4},
    {257, 4, 1, 2},
    {258, 3, 1, 16},
    {259, 3, 1, 1},
    {262, 3, 1, 32803},
    {273, 4, 1, PIXELS},
    {277, 3, 1, 1},
    {278, 4, 1, 2},
    {279, 4, 1, 16},
    {330, 4, 1, TAG_ABSENT},
    {339, 3, 1, 1},
    {33421, 3, 2, 0x00020002},
    {33422, 1, 4, 0x02010100},
    {50706, 1, 4, 0x0401},
    {50712, 3, 2, TAG_ABSENT},
    {50713, 3, 2, TAG_ABSENT},
    {50714, 3, 1, 64},
    {50717, 4, 1, 4095},
    {50728, 5, 3, TAG_ABSENT},
    {50829, 4, 4, TAG_ABSENT},
};

/* The good file with up to two of its tags changed; words lie at TABLE. */
static const char *file_with(void **state, struct tag a, struct tag b, const uint32_t words[4])
{
    uint8_t bytes[BYTES] = {0};

    tagged_head(bytes, good, TTF_COUNT_OF(good), a, b);
    for (unsigned i = 0; i < 8; i++)
        tagged_put(bytes + PIXELS + 2 * i, 100 * (i + 1), 2);
    for (unsigned i = 0; words && i < 4; i++)
        tagged_put(bytes + TABLE + 4 * i, words[i], 4);
    scratch_write(state, "f.dng", bytes, sizeof(bytes));
    return scratch_path(state, "f.dng");
}

static struct ttf_raw_sum read_ok(const char *path)
{
    struct ttf_raw_sum sum = {0};
    struct ttf_err err = {0};

    if (ttf_dng_read(ttf_io_posix(), path, &sum, NULL, &err) != 0)
        fail_msg("%s", err.what);
    return sum;
}

static void a_mosaic_is_read_with_its_levels(void **state)
{
    struct ttf_raw_sum sum = read_ok(file_with(state, good[0], good[0], NULL));

    assert_true(sum.format.width == 4 && sum.format.height == 2);
    assert_int_equal(sum.format.cfa, TTF_CFA_RGGB);
    assert_true(sum.format.black_level == 64 && sum.format.white_level == 4095);
    assert_int_equal(sum.format.bits, 12);
    assert_true(sum.sum[0] == 100 && sum.sum[7] == 800);
    ttf_raw_sum_free(&sum);
}

static void levels_that_cannot_be_are_those_of_the_bits(void **state)
{
    struct ttf_raw_sum sum = read_ok(file_with(state, (struct tag){50717, 4, 1, 70000},
                                               (struct tag){50714, 3, 2, 0x00400040},
                                               NULL)); /* two, where one belongs */

    assert_true(sum.format.black_level == 0 && sum.format.white_level == 65535);
    ttf_raw_sum_free(&sum);
    sum = read_ok(file_with(state, (struct tag){50717, 4, 1, 0}, good[0], NULL));
    assert_int_equal(sum.format.white_level, 65535);
    ttf_raw_sum_free(&sum);
}

/* Two columns of their own black: codes move so that one holds for all, and none falls below 0. */
static void a_pattern_of_blacks_becomes_one(void **state)
{
    struct ttf_raw_sum sum = read_ok(file_with(state, (struct tag){50713, 3, 2, 0x00020001},
                                               (struct tag){50714, 3, 2, 0x00c80000}, NULL));

    assert_int_equal(sum.format.black_level, 100); /* of 0 and 200 */
    assert_true(sum.sum[0] == 200 && sum.sum[1] == 100 && sum.sum[2] == 400);
    ttf_raw_sum_free(&sum);
}

static void the_active_area_is_cut_out_if_it_lies_inside(void **state)
{
    static const uint32_t inside[4] = {0, 1, 2, 3}, outside[4] = {0, 0, 3, 4},
                          none[4] = {1, 1, 1, 1},
                          strange[][4] = {{0, 3, 2, 3}, {0, 0, 2, 5}, {2, 0, 1, 4}, {0, 4, 2, 1}};
    const struct tag area = {50829, 4, 4, TABLE};
    struct ttf_raw_sum sum = read_ok(file_with(state, area, area, inside));

    assert_true(sum.format.width == 2 && sum.format.height == 2);
    assert_int_equal(sum.sum[0], 200);
    ttf_raw_sum_free(&sum);
    sum = read_ok(file_with(state, area, area, outside));
    assert_int_equal(sum.format.width, 4);
    ttf_raw_sum_free(&sum);
    sum = read_ok(file_with(state, area, area, none));
    assert_int_equal(sum.format.width, 4);
    ttf_raw_sum_free(&sum);
    for (unsigned i = 0; i < TTF_COUNT_OF(strange); i++) {
        sum = read_ok(file_with(state, area, area, strange[i]));
        assert_true(sum.format.width == 4 && sum.format.height == 2);
        ttf_raw_sum_free(&sum);
    }
}

/* Black levels in a grid that cannot be, or of values that cannot be: 0, and never a code below 0. */
static void blacks_that_cannot_be_are_none(void **state)
{
    static const uint32_t grids[] = {0x00010000, 0x00000001, 0x00010009, 0x00090001};
    static const uint32_t too_dark[4] = {70000, 1, 0, 0};
    struct ttf_raw_sum sum;

    for (unsigned i = 0; i < TTF_COUNT_OF(grids); i++) {
        sum = read_ok(file_with(state, (struct tag){50713, 3, 2, grids[i]}, good[0], NULL));
        assert_int_equal(sum.format.black_level, 64); /* the one level there is */
        ttf_raw_sum_free(&sum);
    }
    sum = read_ok(file_with(state, (struct tag){50714, 5, 1, TABLE}, good[0], too_dark));
    assert_int_equal(sum.format.black_level, 0);
    assert_int_equal(sum.sum[0], 100);
    ttf_raw_sum_free(&sum);
}

/* Smaller pictures that are listed and are none, or more of them than anybody lists: the mosaic is read all the same. */
static void sub_images_that_cannot_be_read_are_passed_over(void **state)
{
    static const uint32_t words[4] = {BYTES - 2, 3, PIXELS, 5};
    static const struct tag lists[] = {
        {330, 4, 1, BYTES - 2}, {330, 4, 4, TABLE}, {330, 4, 40, TABLE}};

    for (unsigned i = 0; i < TTF_COUNT_OF(lists); i++) {
        struct ttf_raw_sum sum = read_ok(file_with(state, lists[i], good[0], words));

        assert_true(sum.format.width == 4 && sum.sum[7] == 800);
        ttf_raw_sum_free(&sum);
    }
}

/* As floats: 1/2, not a number, and without end. */
static void a_white_that_is_no_number_is_not_known(void **state)
{
    static const uint32_t words[4] = {0x3f000000, 0x7fc00000, 0x7f800000, 0};
    struct ttf_raw_sum sum = {0};
    struct ttf_dng_info info;
    struct ttf_err err = {0};

    if (ttf_dng_read(ttf_io_posix(),
                     file_with(state, (struct tag){50728, 11, 3, TABLE}, good[0], words), &sum,
                     &info, &err) != 0)
        fail_msg("%s", err.what);
    assert_true(info.neutral[0] == 0.5 && info.neutral[1] == 0 && info.neutral[2] == 0);
    ttf_raw_sum_free(&sum);
}

/* Codes beyond the table are its last. */
static void a_table_makes_codes_linear(void **state)
{
    struct ttf_raw_sum sum =
        read_ok(file_with(state, (struct tag){50712, 3, 2, 0x01f40100}, good[0], NULL));

    assert_int_equal(sum.sum[0], 500);
    assert_int_equal(sum.sum[7], 500);
    ttf_raw_sum_free(&sum);
}

static void mosaics_that_are_not_read_say_so(void **state)
{
    static const struct tag wrong[] = {
        {254, 4, 1, 1},     /* a small one only */
        {262, 3, 1, 2},     /* finished pictures */
        {277, 3, 1, 3},     /* of three samples */
        {256, 4, 1, 65536}, /* too wide */
        {257, 4, 1, 65536}, /* too high */
        {258, 3, 1, 4},     /* bits */
        {258, 3, 1, 32},
        {339, 3, 1, 3},            /* floats */
        {259, 3, 1, 8},            /* deflated */
        {33421, 3, 2, 0x00060006}, /* a pattern of 6 x 6 */
        {33421, 3, 2, 0x00020004}, /* of 4 x 2 */
        {33421, 3, 2, 0x00040002}, /* of 2 x 4 */
        {33421, 3, 2, TAG_ABSENT},
        {33422, 1, 4, 0x02010101}, /* of two reds */
        {33422, 1, 3, 0x00010100}, /* of three */
        {33422, 1, 4, TAG_ABSENT},
        {50717, 4, 1, 64},   /* white is not above black */
        {273, 4, 1, 100000}, /* the pixels are not there */
        {256, 4, 1, 60000},  /* more pixels than there are bits */
    };

    for (unsigned i = 0; i < TTF_COUNT_OF(wrong); i++) {
        struct ttf_raw_sum sum = {0};
        struct ttf_err err = {0};
        int r = ttf_dng_read(ttf_io_posix(), file_with(state, wrong[i], wrong[i], NULL), &sum, NULL,
                             &err);

        if (r >= 0 || err.what[0] == '\0')
            fail_msg("case %u: %d: %s", i, r, err.what);
        assert_null(sum.sum);
    }
}

#define T(test) cmocka_unit_test_setup_teardown(test, scratch_make, scratch_remove)

int main(void)
{
    const struct CMUnitTest tests[] = {
        T(a_mosaic_is_read_with_its_levels),
        T(levels_that_cannot_be_are_those_of_the_bits),
        T(a_pattern_of_blacks_becomes_one),
        T(the_active_area_is_cut_out_if_it_lies_inside),
        T(blacks_that_cannot_be_are_none),
        T(a_table_makes_codes_linear),
        T(mosaics_that_are_not_read_say_so),
        T(sub_images_that_cannot_be_read_are_passed_over),
        T(a_white_that_is_no_number_is_not_known),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
