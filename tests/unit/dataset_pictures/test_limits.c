/* SPDX-License-Identifier: Apache-2.0 */
/* What no picture, frame or calibration can be is refused; what just can be is not. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "scratch.h"
#include "ttf/base/attr.h"
#include "ttf/dataset/calibration.h"
#include "ttf/dataset/develop.h"
#include "ttf/dataset/dng.h"
#include "ttf/dataset/image_file.h"
#include "ttf/dataset/sequence.h"
#include "ttf/dataset/tiff.h"

/* ---- pixels ---- */

static void pixels_of_no_size_or_kind_are_refused(void **state)
{
    struct ttf_pixbuf buf = {0}, view, other = {0};

    assert_int_equal(ttf_pixbuf_alloc(&buf, 0, 1, 1, TTF_SAMPLE_U8), -EINVAL);
    assert_int_equal(ttf_pixbuf_alloc(&buf, 1, 0, 1, TTF_SAMPLE_U8), -EINVAL);
    assert_int_equal(ttf_pixbuf_alloc(&buf, (1u << 20) + 1, 1, 1, TTF_SAMPLE_U8), -EINVAL);
    assert_int_equal(ttf_pixbuf_alloc(&buf, 1, (1u << 20) + 1, 1, TTF_SAMPLE_U8), -EINVAL);
    assert_int_equal(ttf_pixbuf_alloc(&buf, 1, 1, 0, TTF_SAMPLE_U8), -EINVAL);
    assert_int_equal(ttf_pixbuf_alloc(&buf, 1, 1, 5, TTF_SAMPLE_U8), -EINVAL);
    assert_int_equal(ttf_pixbuf_alloc(&buf, 1, 1, 1, TTF_SAMPLE_F16), -EINVAL);
    assert_int_equal(ttf_sample_find("f16"), TTF_SAMPLE_F16);
    assert_int_equal(ttf_sample_find("u32"), -ENOENT);
    assert_int_equal(ttf_sample_bytes(TTF_SAMPLE_COUNT), 0);
    assert_int_equal(ttf_pixbuf_alloc(&buf, 4, 3, 3, TTF_SAMPLE_U8), 0);
    assert_int_equal(ttf_pixbuf_view(&buf, 0, 0, 0, 1, &view), -EINVAL);
    assert_int_equal(ttf_pixbuf_view(&buf, 0, 0, 1, 0, &view), -EINVAL);
    assert_int_equal(ttf_pixbuf_view(&buf, 4, 0, 1, 1, &view), -EINVAL);
    assert_int_equal(ttf_pixbuf_view(&buf, 0, 3, 1, 1, &view), -EINVAL);
    assert_int_equal(ttf_pixbuf_view(&buf, 1, 0, 4, 1, &view), -EINVAL);
    assert_int_equal(ttf_pixbuf_view(&buf, 0, 1, 1, 3, &view), -EINVAL);
    assert_int_equal(ttf_pixbuf_view(&buf, 1, 1, 3, 2, &view), 0);
    assert_int_equal(ttf_pixbuf_alloc(&other, 4, 2, 3, TTF_SAMPLE_U8), 0);
    assert_int_equal(ttf_pixbuf_convert(&buf, &other), -EINVAL);
    ttf_pixbuf_free(&other);
    assert_int_equal(ttf_pixbuf_alloc(&other, 4, 3, 1, TTF_SAMPLE_U8), 0);
    assert_int_equal(ttf_pixbuf_convert(&buf, &other), -EINVAL);
    assert_int_equal(ttf_pixbuf_resample(&buf, &other), -EINVAL);
    other.format = TTF_SAMPLE_F16;
    other.samples = 3;
    assert_int_equal(ttf_pixbuf_convert(&buf, &other), -EINVAL);
    ttf_pixbuf_free(&other);
    ttf_pixbuf_free(&buf);
    ttf_pixbuf_free(NULL);
}

/* To any other kind and back: the codes that were. */
static void samples_go_to_every_other_kind_and_come_back(void **state)
{
    static const enum ttf_sample kinds[] = {TTF_SAMPLE_U8, TTF_SAMPLE_U16, TTF_SAMPLE_F32};
    struct ttf_pixbuf from = {0};

    assert_int_equal(ttf_pixbuf_alloc(&from, 16, 16, 1, TTF_SAMPLE_U8), 0);
    for (unsigned i = 0; i < 256; i++)
        ((uint8_t *)from.data)[i] = (uint8_t)i;
    for (unsigned a = 0; a < TTF_COUNT_OF(kinds); a++)
        for (unsigned b = 0; b < TTF_COUNT_OF(kinds); b++) {
            struct ttf_pixbuf first = {0}, second = {0}, back = {0};

            assert_int_equal(ttf_pixbuf_alloc(&first, 16, 16, 1, kinds[a]), 0);
            assert_int_equal(ttf_pixbuf_alloc(&second, 16, 16, 1, kinds[b]), 0);
            assert_int_equal(ttf_pixbuf_alloc(&back, 16, 16, 1, TTF_SAMPLE_U8), 0);
            assert_int_equal(ttf_pixbuf_convert(&from, &first), 0);
            assert_int_equal(ttf_pixbuf_convert(&first, &second), 0);
            assert_int_equal(ttf_pixbuf_convert(&second, &back), 0);
            assert_memory_equal(back.data, from.data, 256);
            /* Of the same size resampling changes nothing. */
            assert_int_equal(ttf_pixbuf_resample(&first, &first), 0);
            ttf_pixbuf_free(&first);
            ttf_pixbuf_free(&second);
            ttf_pixbuf_free(&back);
        }
    ttf_pixbuf_free(&from);
}

static void numbers_that_are_none_become_black_and_those_beyond_white(void **state)
{
    const float values[4] = {NAN, -1.0f, 2.0f, INFINITY};
    const struct ttf_pixbuf from = {.width = 4,
                                    .height = 1,
                                    .samples = 1,
                                    .format = TTF_SAMPLE_F32,
                                    .stride = sizeof(values),
                                    .data = (void *)values};
    uint8_t bytes[4];
    uint16_t codes[4];
    struct ttf_pixbuf to = from;

    to.format = TTF_SAMPLE_U8;
    to.stride = sizeof(bytes);
    to.data = bytes;
    assert_int_equal(ttf_pixbuf_convert(&from, &to), 0);
    assert_true(bytes[0] == 0 && bytes[1] == 0 && bytes[2] == 255 && bytes[3] == 255);
    to.format = TTF_SAMPLE_U16;
    to.stride = sizeof(codes);
    to.data = codes;
    assert_int_equal(ttf_pixbuf_convert(&from, &to), 0);
    assert_true(codes[0] == 0 && codes[1] == 0 && codes[2] == 65535 && codes[3] == 65535);
}

static void a_sequence_of_nothing_is_none(void **state)
{
    static const uint16_t frames[2 * 3 * 3] = {7};
    const struct ttf_encoding plain = {.scale = 65535}, none = {.scale = 0};
    struct ttf_sequence *s = NULL;
    uint16_t row[9];

    assert_int_equal(ttf_sequence_of_memory(NULL, 1, 1, 1, &plain, &s, NULL), -EINVAL);
    assert_int_equal(ttf_sequence_of_memory(frames, 1, 1, 1, NULL, &s, NULL), -EINVAL);
    assert_int_equal(ttf_sequence_of_memory(frames, 0, 1, 1, &plain, &s, NULL), -EINVAL);
    assert_int_equal(ttf_sequence_of_memory(frames, 1, 0, 1, &plain, &s, NULL), -EINVAL);
    assert_int_equal(ttf_sequence_of_memory(frames, 1, 1, 0, &plain, &s, NULL), -EINVAL);
    assert_int_equal(ttf_sequence_of_memory(frames, 1, 1, 1, &none, &s, NULL), -EINVAL);
    assert_int_equal(
        ttf_sequence_of_memory(frames, UINT32_MAX, UINT32_MAX, UINT32_MAX, &plain, &s, NULL),
        -EOVERFLOW);
    assert_int_equal(ttf_sequence_of_memory(frames, 3, 1, 2, &plain, &s, NULL), 0);
    assert_int_equal(ttf_sequence_read_rows(s, 2, 0, 1, row, NULL), -EINVAL);
    assert_int_equal(ttf_sequence_read_rows(s, 0, 2, 0, row, NULL), -EINVAL);
    assert_int_equal(ttf_sequence_read_rows(s, 0, 0, 2, row, NULL), -EINVAL);
    assert_int_equal(ttf_sequence_read_rows(s, 0, 0, 1, row, NULL), 0);
    assert_int_equal(row[0], 7);
    ttf_sequence_destroy(s);
    ttf_sequence_destroy(NULL);
}

/* ---- frames ---- */

static const struct ttf_frame_format mosaic = {.width = 8,
                                               .height = 6,
                                               .packing = TTF_PACKING_RAW16,
                                               .stride = 16,
                                               .cfa = TTF_CFA_RGGB,
                                               .bits = 12,
                                               .black_level = 64,
                                               .white_level = 4095};

static void frames_of_no_camera_are_not_added_up(void **state)
{
    struct ttf_frame_format format;
    struct ttf_raw_sum sum = {0};

    for (unsigned i = 0; i < 9; i++) {
        format = mosaic;
        switch (i) {
        case 0:
            format.width = 0;
            break;
        case 1:
            format.height = 0;
            break;
        case 2:
            format.width = 65536;
            break;
        case 3:
            format.height = 65536;
            break;
        case 4:
            format.cfa = TTF_CFA_COUNT;
            break;
        case 5:
            format.bits = 0;
            break;
        case 6:
            format.bits = 17;
            break;
        case 7:
            format.white_level = format.black_level;
            break;
        default:
            format.packing = TTF_PACKING_COUNT;
            break;
        }
        assert_int_equal(ttf_raw_sum_init(&sum, &format), i < 8 ? -EINVAL : -ENOTSUP);
    }
    assert_int_equal(ttf_raw_sum_init(&sum, &mosaic), 0);
    format = mosaic;
    format.width = 16;
    assert_int_equal(ttf_raw_sum_refit(&sum, &format), -ENOSPC);
    format.width = 4;
    assert_int_equal(ttf_raw_sum_refit(&sum, &format), 0);
    ttf_raw_sum_free(&sum);
}

static void refuse(const struct ttf_develop_config *config, const char *says)
{
    struct ttf_develop *develop = NULL;
    struct ttf_err err = {0};

    assert_int_equal(ttf_develop_create(config, &develop, &err), -EINVAL);
    if (!strstr(err.what, says))
        fail_msg("'%s' does not say '%s'", err.what, says);
    assert_null(develop);
}

static void developing_what_cannot_be_developed_is_refused(void **state)
{
    const struct ttf_develop_config good = {.format = mosaic,
                                            .encoding = {TTF_PEDESTAL, TTF_SCALE}};
    struct ttf_develop_config c = good;
    struct ttf_develop *develop = NULL;
    struct ttf_raw_sum sum = {0};
    struct ttf_pixbuf to = {0};
    struct ttf_err err = {0};
    const struct ttf_region outside[] = {
        {8, 0, 1, 1}, {0, 6, 1, 1}, {4, 0, 5, 1}, {0, 4, 1, 3}, {0, 0, 1, 0}};

    for (unsigned i = 0; i < TTF_COUNT_OF(outside); i++) {
        c.region = outside[i];
        refuse(&c, "does not lie in the frame");
    }
    c = good;
    c.encoding.scale = 0;
    refuse(&c, "no encoding");
    c.encoding.scale = 2e9;
    refuse(&c, "no encoding");
    c.encoding = (struct ttf_encoding){-1, 1000};
    refuse(&c, "no encoding");
    c.encoding = (struct ttf_encoding){65536, 1000};
    refuse(&c, "no encoding");
    c = good;
    c.format.width = 3;
    refuse(&c, "too small to develop");
    c = good;
    c.format.bits = 0;
    refuse(&c, "cannot be developed");
    assert_int_equal(ttf_develop_create(&good, &develop, NULL), 0);
    assert_int_equal(ttf_raw_sum_init(&sum, &mosaic), 0);
    assert_int_equal(ttf_pixbuf_alloc(&to, 8, 6, 3, TTF_SAMPLE_U16), 0);
    assert_int_equal(ttf_develop_run(develop, &sum, NULL, &to, NULL, &err), -EINVAL);
    assert_non_null(strstr(err.what, "there is no frame"));
    sum.n = 1;
    sum.format.white_level = 1000;
    assert_int_equal(ttf_develop_run(develop, &sum, NULL, &to, NULL, &err), -EINVAL);
    assert_non_null(strstr(err.what, "not of the format"));
    sum.format = mosaic;
    to.height = 5;
    assert_int_equal(ttf_develop_run(develop, &sum, NULL, &to, NULL, &err), -EINVAL);
    assert_non_null(strstr(err.what, "not of the developed size"));
    to.height = 6;
    assert_int_equal(ttf_develop_run(develop, &sum, NULL, &to, NULL, &err), 0);
    ttf_pixbuf_free(&to);
    ttf_raw_sum_free(&sum);
    ttf_develop_destroy(develop);
    ttf_develop_destroy(NULL);
}

static void a_calibration_of_nothing_has_no_name(void **state)
{
    char longest[4100];
    struct ttf_calibration c;
    struct ttf_raw_sum sum = {0};
    struct ttf_frame_format rgb = {
        .width = 4, .height = 4, .stride = 12, .packing = TTF_PACKING_RGB8};

    memset(longest, 'a', sizeof(longest));
    longest[sizeof(longest) - 1] = '\0';
    ttf_calibration_init(&c);
    assert_int_equal(ttf_calibration_name(&c, NULL), -EINVAL);
    assert_int_equal(ttf_raw_sum_init(&sum, &mosaic), 0);
    assert_int_equal(ttf_calibration_fit_dark(&c, &sum, NULL), -EINVAL);
    sum.n = 1;
    for (unsigned i = 0; i < 48; i++)
        sum.sum[i] = 3000;
    assert_int_equal(ttf_calibration_fit_dark(&c, &sum, NULL), -EINVAL); /* not dark */
    assert_int_equal(ttf_calibration_fit_flat(&c, &sum, 0.0, NULL), -EINVAL);
    assert_int_equal(ttf_calibration_fit_flat(&c, &sum, 1.5, NULL), -EINVAL);
    for (unsigned i = 0; i < 48; i++)
        sum.sum[i] = 4095;
    assert_int_equal(ttf_calibration_fit_flat(&c, &sum, 0.9, NULL), -EINVAL); /* saturated */
    for (unsigned i = 0; i < 48; i++)
        sum.sum[i] = 66;
    assert_int_equal(ttf_calibration_fit_flat(&c, &sum, 0.9, NULL), -EINVAL); /* too dark */
    assert_false(c.has_dark || c.has_flat);
    ttf_raw_sum_free(&sum);
    assert_int_equal(ttf_raw_sum_init(&sum, &rgb), 0);
    sum.n = 1;
    assert_int_equal(ttf_calibration_fit_dark(&c, &sum, NULL), -ENOTSUP);
    assert_int_equal(ttf_calibration_save(&c, ttf_io_posix(), longest, NULL), -ENAMETOOLONG);
    assert_int_equal(ttf_calibration_load(ttf_io_posix(), longest, &c, NULL), -ENAMETOOLONG);
    ttf_raw_sum_free(&sum);
    ttf_calibration_free(&c);
}

/* ---- files ---- */

static void files_that_cannot_be_are_not_begun(void **state)
{
    struct ttf_io *io = ttf_io_posix();
    const struct ttf_tiff_spec good = {.width = 4, .height = 2, .samples = 1};
    struct ttf_tiff_spec spec;
    struct ttf_tiff_writer *writer = NULL;
    struct ttf_pixbuf buf = {0};
    struct ttf_raw_sum sum = {0};
    const struct ttf_dng_info info = {.model = "A"};
    uint8_t rows[12] = {0};
    int file = scratch_create(state, "f");

    for (unsigned i = 0; i < 7; i++) {
        spec = good;
        switch (i) {
        case 0:
            spec.width = 0;
            break;
        case 1:
            spec.height = 0;
            break;
        case 2:
            spec.width = (1u << 20) + 1;
            break;
        case 3:
            spec.height = (1u << 20) + 1;
            break;
        case 4:
            spec.samples = 0;
            break;
        case 5:
            spec.samples = 5;
            break;
        default:
            spec.format = TTF_SAMPLE_COUNT;
            break;
        }
        assert_int_equal(ttf_tiff_writer_create(&spec, &writer, NULL), -EINVAL);
    }
    assert_int_equal(ttf_tiff_writer_open(io, file, &good, &writer, NULL), 0);
    assert_int_equal(ttf_tiff_writer_rows(writer, rows, 4, 3, NULL), -EINVAL);
    assert_int_equal(ttf_tiff_writer_rows(writer, rows, 4, 1, NULL), 0);
    assert_int_equal(ttf_tiff_writer_rows(writer, rows, 4, 2, NULL), -EINVAL);
    assert_int_equal(ttf_tiff_writer_close(writer, NULL), -EINVAL); /* a row is lacking */
    ttf_tiff_writer_abandon(NULL);
    assert_int_equal(ttf_pixbuf_alloc(&buf, 4, 4, 3, TTF_SAMPLE_F32), 0);
    assert_int_equal(ttf_png_write(io, file, &buf, TTF_TRANSFER_SRGB, 6, NULL, NULL), -EINVAL);
    assert_int_equal(ttf_jpeg_write(io, file, &buf, 90, NULL), -EINVAL);
    buf.format = TTF_SAMPLE_U8;
    assert_int_equal(ttf_png_write(io, file, &buf, TTF_TRANSFER_SRGB, 10, NULL, NULL), -EINVAL);
    assert_int_equal(ttf_png_write(io, file, &buf, TTF_TRANSFER_SRGB, -1, NULL, NULL), -EINVAL);
    assert_int_equal(ttf_jpeg_write(io, file, &buf, 0, NULL), -EINVAL);
    assert_int_equal(ttf_jpeg_write(io, file, &buf, 101, NULL), -EINVAL);
    buf.samples = 2;
    assert_int_equal(ttf_jpeg_write(io, file, &buf, 90, NULL), -EINVAL);
    buf.samples = 5;
    assert_int_equal(ttf_png_write(io, file, &buf, TTF_TRANSFER_SRGB, 6, NULL, NULL), -EINVAL);
    buf.samples = 3;
    buf.width = 70000;
    assert_int_equal(ttf_jpeg_write(io, file, &buf, 90, NULL), -EFBIG);
    ttf_pixbuf_free(&buf);
    assert_int_equal(ttf_raw_sum_init(&sum, &mosaic), 0);
    assert_int_equal(ttf_dng_write(&sum, &info, io, file, NULL), -EINVAL);
    sum.n = 1;
    sum.samples = 3;
    assert_int_equal(ttf_dng_write(&sum, &info, io, file, NULL), -ENOTSUP);
    ttf_raw_sum_free(&sum);
    assert_int_equal(io->ops->close(io, file), 0);
}

/* More than one piece of the encoder's: what comes back is as large, and about the same. */
static void a_large_jpeg_goes_out_in_pieces(void **state)
{
    struct ttf_pixbuf buf = {0}, back = {0};
    struct ttf_image_info info;
    uint32_t seed = 1;
    int file = scratch_create(state, "noise.jpg");

    assert_int_equal(ttf_pixbuf_alloc(&buf, 512, 512, 3, TTF_SAMPLE_U8), 0);
    for (unsigned i = 0; i < 512 * 512 * 3; i++)
        ((uint8_t *)buf.data)[i] = (uint8_t)(scratch_random(&seed) % 256);
    assert_int_equal(ttf_jpeg_write(ttf_io_posix(), file, &buf, 95, NULL), 0);
    assert_int_equal(ttf_io_posix()->ops->close(ttf_io_posix(), file), 0);
    assert_int_equal(
        ttf_image_read(ttf_io_posix(), scratch_path(state, "noise.jpg"), 0, &back, &info, NULL), 0);
    assert_int_equal(back.width, 512);
    assert_int_equal(info.kind, TTF_IMAGE_JPEG);
    assert_true(abs(((uint8_t *)back.data)[0] - ((uint8_t *)buf.data)[0]) < 64);
    assert_int_equal(
        ttf_image_read(ttf_io_posix(), scratch_path(state, "noise.jpg"), 1, &back, &info, NULL),
        -EINVAL);
    ttf_pixbuf_free(&buf);
    ttf_pixbuf_free(&back);
}

static void light_of_pictures_that_cannot_be_mapped_is_refused(void **state)
{
    struct ttf_image_info info = {.format = TTF_SAMPLE_F32, .bits = 32, .samples = 1};
    const struct ttf_image_range none = {1.0, 1.0}, half = {0.0, 0.5};
    struct ttf_pixbuf from = {0}, to = {0};

    assert_int_equal(ttf_pixbuf_alloc(&from, 2, 1, 1, TTF_SAMPLE_F32), 0);
    ((float *)from.data)[0] = 0.25f;
    ((float *)from.data)[1] = NAN;
    assert_int_equal(ttf_image_linear(&from, &info, TTF_TRANSFER_LINEAR, &none, 1, &to), -EINVAL);
    assert_int_equal(ttf_image_linear(&from, &info, TTF_TRANSFER_LINEAR, &half, 2, &to), -EINVAL);
    assert_int_equal(ttf_image_linear(&from, &info, TTF_TRANSFER_LINEAR, &half, 1, &to), 0);
    assert_int_equal(((uint16_t *)to.data)[0], 32768);
    assert_int_equal(((uint16_t *)to.data)[1], 0);
    ttf_pixbuf_free(&to);
    /* Half of the sRGB scale is a fifth of the light. */
    assert_int_equal(ttf_image_linear(&from, &info, TTF_TRANSFER_SRGB, &half, 1, &to), 0);
    assert_in_range(((uint16_t *)to.data)[0], 14000, 14050);
    ttf_pixbuf_free(&to);
    info.format = TTF_SAMPLE_U16;
    assert_int_equal(ttf_image_linear(&from, &info, TTF_TRANSFER_SRGB, NULL, 1, &to), -EINVAL);
    from.format = TTF_SAMPLE_U16;
    info.bits = 17;
    assert_int_equal(ttf_image_linear(&from, &info, TTF_TRANSFER_SRGB, NULL, 1, &to), -EINVAL);
    ttf_pixbuf_free(&from);
}

static void count_tile(void *ctx, unsigned tile, unsigned worker)
{
    unsigned *done = ctx;

    __atomic_add_fetch(&done[tile], 1, __ATOMIC_RELAXED);
}

/* Whoever asks for a million gets what is sensible, and each tile is done once. */
static void more_threads_than_a_pool_has_are_as_many_as_it_has(void **state)
{
    struct ttf_pool *pool = ttf_pool_create(1000000);
    unsigned done[1000] = {0};

    assert_non_null(pool);
    assert_in_range(ttf_pool_threads(pool), 1, 256);
    ttf_pool_run(pool, 1000, count_tile, done);
    for (unsigned i = 0; i < 1000; i++)
        assert_int_equal(done[i], 1);
    ttf_pool_destroy(pool);
}

#define T(test) cmocka_unit_test_setup_teardown(test, scratch_make, scratch_remove)

int main(void)
{
    const struct CMUnitTest tests[] = {
        T(pixels_of_no_size_or_kind_are_refused),
        T(more_threads_than_a_pool_has_are_as_many_as_it_has),
        T(samples_go_to_every_other_kind_and_come_back),
        T(numbers_that_are_none_become_black_and_those_beyond_white),
        T(a_sequence_of_nothing_is_none),
        T(frames_of_no_camera_are_not_added_up),
        T(developing_what_cannot_be_developed_is_refused),
        T(a_calibration_of_nothing_has_no_name),
        T(files_that_cannot_be_are_not_begun),
        T(a_large_jpeg_goes_out_in_pieces),
        T(light_of_pictures_that_cannot_be_mapped_is_refused),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
