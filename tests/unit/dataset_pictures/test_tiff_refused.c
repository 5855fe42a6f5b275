/* SPDX-License-Identifier: Apache-2.0 */
/* TIFF files, tag by tag, that this reader does not read: each is refused, and says what it is. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <errno.h>
#include <stdio.h>
#include <string.h>

#include "scratch.h"
#include "tagged.h"
#include "ttf/base/attr.h"
#include "ttf/dataset/dng.h"
#include "ttf/dataset/tiff.h"

#define PIXELS 400 /* where they lie in the file */
#define BYTES  1024

enum {
    TAG_WIDTH = 256,
    TAG_HEIGHT = 257,
    TAG_BITS = 258,
    TAG_COMPRESSION = 259,
    TAG_PHOTOMETRIC = 262,
    TAG_OFFSETS = 273,
    TAG_SAMPLES = 277,
    TAG_ROWS = 278,
    TAG_COUNTS = 279,
    TAG_PLANAR = 284,
    TAG_KIND = 339
};

/* Grey, 4 x 2, 8 bits. In the order of tags, as they must be. */
static const struct tag good[] = {
    {TAG_WIDTH, 4, 1, 4},       {TAG_HEIGHT, 4, 1, 2},      {TAG_BITS, 3, 1, 8},
    {TAG_COMPRESSION, 3, 1, 1}, {TAG_PHOTOMETRIC, 3, 1, 1}, {TAG_OFFSETS, 4, 1, PIXELS},
    {TAG_SAMPLES, 3, 1, 1},     {TAG_ROWS, 4, 1, 2},        {TAG_COUNTS, 4, 1, 8},
    {TAG_PLANAR, 3, 1, 1},      {TAG_KIND, 3, 1, 1}};

/* The good file with up to two of its tags changed. */
static const char *file_with(void **state, struct tag a, struct tag b)
{
    uint8_t bytes[BYTES] = {0};

    tagged_head(bytes, good, TTF_COUNT_OF(good), a, b);
    for (unsigned i = 0; i < 8; i++)
        bytes[PIXELS + i] = (uint8_t)(10 * i);
    scratch_write(state, "f.tif", bytes, sizeof(bytes));
    return scratch_path(state, "f.tif");
}

static void the_good_one_is_read(void **state)
{
    struct ttf_pixbuf got = {0};

    assert_int_equal(
        ttf_tiff_read(ttf_io_posix(), file_with(state, good[0], good[1]), 0, &got, NULL), 0);
    assert_true(got.width == 4 && got.height == 2 && got.samples == 1);
    assert_int_equal(((uint8_t *)got.data)[7], 70);
    ttf_pixbuf_free(&got);
}

/* As some programs say that they do not say what it is. */
static void a_sample_format_of_nothing_is_whole_numbers(void **state)
{
    struct ttf_pixbuf got = {0};

    assert_int_equal(ttf_tiff_read(ttf_io_posix(),
                                   file_with(state, (struct tag){TAG_KIND, 3, 1, 4}, good[0]), 0,
                                   &got, NULL),
                     0);
    assert_int_equal(((uint8_t *)got.data)[7], 70);
    ttf_pixbuf_free(&got);
}

static void each_tag_that_is_not_read_is_told(void **state)
{
    static const struct {
        struct tag a, b;
        int code;
        const char *says;
    } cases[] = {
        {{TAG_WIDTH, 4, 1, TAG_ABSENT}, {TAG_WIDTH, 4, 1, TAG_ABSENT}, -TTF_EDAMAGED, ""},
        {{TAG_HEIGHT, 4, 1, 0}, {TAG_HEIGHT, 4, 1, 0}, -TTF_EDAMAGED, ""},
        {{TAG_WIDTH, 4, 1, (1u << 20) + 1}, {TAG_ROWS, 4, 1, 2}, -ENOTSUP, "a side of"},
        {{TAG_HEIGHT, 4, 1, (1u << 20) + 1}, {TAG_ROWS, 4, 1, 2}, -ENOTSUP, "a side of"},
        {{TAG_KIND, 3, 1, 2}, {TAG_KIND, 3, 1, 2}, -ENOTSUP, "sample format"},
        {{TAG_KIND, 3, 1, 6}, {TAG_KIND, 3, 1, 6}, -ENOTSUP, "sample format"},
        {{TAG_KIND, 3, 1, 3}, {TAG_BITS, 3, 1, 8}, -ENOTSUP, "bits per sample"},
        {{TAG_KIND, 3, 1, 3}, {TAG_BITS, 3, 1, 64}, -ENOTSUP, "bits per sample"},
        {{TAG_BITS, 3, 1, 17}, {TAG_BITS, 3, 1, 17}, -ENOTSUP, "bits per sample"},
        {{TAG_BITS, 3, 1, 64}, {TAG_BITS, 3, 1, 64}, -ENOTSUP, "bits per sample"},
        {{TAG_SAMPLES, 3, 1, 65}, {TAG_SAMPLES, 3, 1, 65}, -ENOTSUP, "samples per pixel"},
        {{TAG_SAMPLES, 3, 1, 5}, {TAG_SAMPLES, 3, 1, 5}, -ENOTSUP, "samples per pixel"},
        {{TAG_COMPRESSION, 3, 1, 60000}, {TAG_PLANAR, 3, 1, 1}, -ENOTSUP, "compression"},
        {{TAG_PHOTOMETRIC, 3, 1, 6}, {TAG_SAMPLES, 3, 1, 3}, -ENOTSUP, "YCbCr"},
        {{TAG_PHOTOMETRIC, 3, 1, 8}, {TAG_SAMPLES, 3, 1, 3}, -ENOTSUP, "photometric"},
        {{TAG_PHOTOMETRIC, 3, 1, 6}, {TAG_COMPRESSION, 3, 1, 7}, -TTF_EDAMAGED, ""},
        {{TAG_SAMPLES, 3, 1, 0}, {TAG_PLANAR, 3, 1, 1}, -TTF_EDAMAGED, ""},
        {{TAG_BITS, 3, 1, 0}, {TAG_PLANAR, 3, 1, 1}, -TTF_EDAMAGED, ""},
        {{TAG_ROWS, 4, 1, 0}, {TAG_PLANAR, 3, 1, 1}, -TTF_EDAMAGED, ""},
        {{TAG_OFFSETS, 4, 1, 100000}, {TAG_PLANAR, 3, 1, 1}, -TTF_EDAMAGED, ""},
        {{TAG_OFFSETS, 4, 1, TAG_ABSENT}, {TAG_PLANAR, 3, 1, 1}, -TTF_EDAMAGED, ""},
    };

    for (unsigned i = 0; i < TTF_COUNT_OF(cases); i++) {
        struct ttf_pixbuf got = {0};
        struct ttf_err err = {0};
        int r =
            ttf_tiff_read(ttf_io_posix(), file_with(state, cases[i].a, cases[i].b), 0, &got, &err);

        if (r != cases[i].code || !strstr(err.what, cases[i].says))
            fail_msg("case %u: %d: %s", i, r, err.what);
        assert_true(err.what[0] != '\0');
        assert_null(got.data);
    }
}

static void pages_and_rows_that_are_not_there_are_refused(void **state)
{
    struct ttf_tiff_reader *reader = NULL;
    struct ttf_pixbuf got = {0};
    struct ttf_err err = {0};
    uint8_t rows[8];

    assert_int_equal(
        ttf_tiff_reader_open(ttf_io_posix(), file_with(state, good[0], good[1]), &reader, NULL), 0);
    assert_int_equal(ttf_tiff_reader_page(reader, 1, NULL), -EINVAL);
    assert_int_equal(ttf_tiff_reader_rows(reader, 0, 3, rows, 4, NULL), -EINVAL);
    assert_int_equal(ttf_tiff_reader_rows(reader, 3, 0, rows, 4, NULL), -EINVAL);
    assert_int_equal(ttf_tiff_reader_rows(reader, 1, 1, rows, 4, NULL), 0);
    assert_int_equal(rows[0], 40);
    ttf_tiff_reader_close(reader);
    ttf_tiff_reader_close(NULL);
    assert_int_equal(
        ttf_tiff_read(ttf_io_posix(), file_with(state, good[0], good[1]), 1, &got, &err), -EINVAL);
    assert_non_null(strstr(err.what, "page"));
    assert_null(got.data);
}

static void what_is_no_raw_frame_is_not_read_as_one(void **state)
{
    struct ttf_raw_sum sum;
    struct ttf_err err = {0};

    assert_true(ttf_dng_read(ttf_io_posix(), file_with(state, good[0], good[1]), &sum, NULL, &err) <
                0);
    assert_true(err.what[0] != '\0');
    assert_true(ttf_dng_read(ttf_io_posix(), scratch_path(state, "none"), &sum, NULL, NULL) ==
                -ENOENT);
    scratch_write(state, "text", "no picture", 10);
    assert_true(ttf_dng_read(ttf_io_posix(), scratch_path(state, "text"), &sum, NULL, NULL) < 0);
}

#define T(test) cmocka_unit_test_setup_teardown(test, scratch_make, scratch_remove)

int main(void)
{
    const struct CMUnitTest tests[] = {
        T(the_good_one_is_read),
        T(a_sample_format_of_nothing_is_whole_numbers),
        T(each_tag_that_is_not_read_is_told),
        T(pages_and_rows_that_are_not_there_are_refused),
        T(what_is_no_raw_frame_is_not_read_as_one),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
