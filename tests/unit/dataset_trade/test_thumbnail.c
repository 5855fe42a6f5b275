/* SPDX-License-Identifier: Apache-2.0 */
/* test_thumbnail.c: small pictures of large images. */
#include "trade_test.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "ttf/dataset/dng.h"
#include "ttf/dataset/thumbnail.h"
#include "ttf/dataset/tiff.h"

/* Left half dark, right half bright, as codes; a single full-scale pixel at (0, 0). */
static void write_tiff(const char *path, uint32_t width, uint32_t height, uint16_t dark,
                       uint16_t bright)
{
    const struct ttf_tiff_spec spec = {
        .width = width, .height = height, .samples = 3, .format = TTF_SAMPLE_U16};
    struct ttf_io *io = ttf_io_posix();
    struct ttf_tiff_writer *writer = NULL;
    uint16_t *row = calloc(width, 6);
    int file = io->ops->open(io, path, TTF_IO_CREATE_NEW);

    if (!row || file < 0 || ttf_tiff_writer_open(io, file, &spec, &writer, NULL) < 0) {
        free(row);
        fail_msg("no TIFF at %s", path);
        return;
    }
    for (uint32_t y = 0; y < height; y++) {
        for (uint32_t x = 0; x < width * 3; x++)
            row[x] = x / 3 < width / 2 ? dark : bright;
        assert_int_equal(ttf_tiff_writer_rows(writer, row, (size_t)width * 6, 1, NULL), 0);
    }
    assert_int_equal(ttf_tiff_writer_close(writer, NULL), 0);
    (void)io->ops->close(io, file);
    free(row);
}

/* The same, of grey pixels in another format: `row` is one row of the file, as it is given to the writer. */
static void write_grey(const char *path, enum ttf_sample format, const void *row, uint32_t width,
                       uint32_t height)
{
    const struct ttf_tiff_spec spec = {
        .width = width, .height = height, .samples = 1, .format = format};
    struct ttf_io *io = ttf_io_posix();
    struct ttf_tiff_writer *writer = NULL;
    int file = io->ops->open(io, path, TTF_IO_CREATE_NEW);
    size_t bytes = format == TTF_SAMPLE_U8 ? 1 : sizeof(float);

    assert_true(file >= 0);
    assert_int_equal(ttf_tiff_writer_open(io, file, &spec, &writer, NULL), 0);
    for (uint32_t y = 0; y < height; y++)
        assert_int_equal(ttf_tiff_writer_rows(writer, row, width * bytes, 1, NULL), 0);
    assert_int_equal(ttf_tiff_writer_close(writer, NULL), 0);
    (void)io->ops->close(io, file);
}

static struct ttf_pixbuf decoded(void **state, const void *jpeg, size_t n)
{
    const char *path = in_folder(state, "small.jpg");
    struct ttf_pixbuf pixels = {0};

    write_bytes(path, jpeg, n);
    if (ttf_image_read(ttf_io_posix(), path, 0, &pixels, NULL, NULL) < 0)
        fail_msg("no JPEG");
    return pixels;
}

static void a_large_image_becomes_a_small_picture_in_linear_light(void **state)
{
    const struct ttf_stream stream = {.encoding = {TTF_PEDESTAL, TTF_SCALE}};
    const struct ttf_thumbnail_size size = {.side = 100, .quality = 95};
    const char *path = in_folder(state, "large.tif");
    struct ttf_pixbuf small;
    const uint8_t *row;
    size_t n = 0;
    void *jpeg = NULL;

    write_tiff(path, 401, 203, TTF_PEDESTAL, TTF_PEDESTAL + TTF_SCALE);
    assert_int_equal(ttf_thumbnail_of_file(ttf_io_posix(), path, &stream, &size, &jpeg, &n, NULL),
                     0);
    small = decoded(state, jpeg, n);
    free(jpeg);
    assert_int_equal(small.width, 81);
    assert_int_equal(small.height, 41);
    row = ttf_pixbuf_row(&small, 20);
    assert_in_range(row[3 * 10], 0, 6);
    assert_in_range(row[3 * 70], 249, 255);
    /* x = 200 begins the bright half: column 40 holds 200..204, all bright; a grey edge would be 188 of linear 0.5 */
    assert_in_range(row[3 * 40], 240, 255);
    ttf_pixbuf_free(&small);
}

static void what_is_small_stays_as_large_as_it_is(void **state)
{
    const struct ttf_stream stream = {.encoding = {0, 65535}};
    const struct ttf_thumbnail_size size = {.side = 100};
    const char *path = in_folder(state, "tiny.tif");
    struct ttf_pixbuf small;
    size_t n = 0;
    void *jpeg = NULL;

    write_tiff(path, 40, 20, 10000, 10000);
    assert_int_equal(ttf_thumbnail_of_file(ttf_io_posix(), path, &stream, &size, &jpeg, &n, NULL),
                     0);
    small = decoded(state, jpeg, n);
    free(jpeg);
    assert_int_equal(small.width, 40);
    assert_int_equal(small.height, 20);
    assert_in_range(*(const uint8_t *)ttf_pixbuf_row(&small, 5), 108, 112); /* sRGB of 0.153 */
    ttf_pixbuf_free(&small);
}

/* Black, a linear half, white, beyond white and below black, whatever their codes are. */
static void bytes_and_floats_mean_what_their_stream_says(void **state)
{
    static const uint8_t bytes[5] = {10, 110, 210, 255, 0};
    static const float floats[5] = {-1, 0, 1, 7, NAN};
    static const uint8_t wanted[5] = {0, 188, 255, 255, 0}; /* sRGB of 0.5: 188 */
    const struct ttf_thumbnail_size size = {.quality = 100};
    const struct ttf_stream of_bytes = {.encoding = {10, 200}}, of_floats = {.encoding = {-1, 2}};
    uint8_t byte_row[5 * 16];
    float float_row[5 * 16];

    for (unsigned i = 0; i < 5 * 16; i++) { /* patches of a JPEG's own size */
        byte_row[i] = bytes[i / 16];
        float_row[i] = floats[i / 16];
    }
    write_grey(in_folder(state, "bytes.tif"), TTF_SAMPLE_U8, byte_row, 5 * 16, 16);
    write_grey(in_folder(state, "floats.tif"), TTF_SAMPLE_F32, float_row, 5 * 16, 16);
    for (unsigned i = 0; i < 2; i++) {
        struct ttf_pixbuf small;
        void *jpeg = NULL;
        size_t n = 0;

        assert_int_equal(ttf_thumbnail_of_file(ttf_io_posix(),
                                               in_folder(state, i ? "floats.tif" : "bytes.tif"),
                                               i ? &of_floats : &of_bytes, &size, &jpeg, &n, NULL),
                         0);
        small = decoded(state, jpeg, n);
        free(jpeg);
        for (unsigned k = 0; k < 5; k++) {
            const uint8_t *at =
                (const uint8_t *)ttf_pixbuf_row(&small, 8) + (size_t)(k * 16 + 8) * small.samples;

            assert_in_range(at[0], wanted[k] < 1 ? 0 : wanted[k] - 1, wanted[k] + 1);
        }
        ttf_pixbuf_free(&small);
    }
}

static void a_stream_without_a_scale_is_not_shown(void **state)
{
    static const struct ttf_stream none;
    const struct ttf_thumbnail_size size = {0};
    struct ttf_err err = {0};
    void *jpeg = NULL;
    size_t n = 0;

    write_tiff(in_folder(state, "none.tif"), 8, 8, 0, 1);
    assert_int_equal(ttf_thumbnail_of_file(ttf_io_posix(), in_folder(state, "none.tif"), &none,
                                           &size, &jpeg, &n, &err),
                     -ENOTSUP);
    assert_non_null(strstr(err.what, "no scale"));
    assert_null(jpeg);
}

static void a_raw_file_is_shown_with_its_white_balance(void **state)
{
    const struct ttf_frame_format format = {.width = 64,
                                            .height = 32,
                                            .stride = 128,
                                            .packing = TTF_PACKING_RAW16,
                                            .cfa = TTF_CFA_RGGB,
                                            .bits = 12,
                                            .black_level = 100,
                                            .white_level = 4095};
    const struct ttf_dng_info info = {.neutral = {0.5, 1, 0.25}};
    const struct ttf_thumbnail_size size = {.side = 16, .quality = 95};
    static const struct ttf_stream none;
    const char *path = in_folder(state, "raw.dng");
    struct ttf_io *io = ttf_io_posix();
    uint16_t pixels[32][64];
    struct ttf_frame frame = {
        .format = format, .data = pixels, .bytes = sizeof pixels, .settings = {.exposure_ns = 1}};
    struct ttf_raw_sum raw = {0};
    struct ttf_pixbuf small;
    const uint8_t *row;
    void *jpeg = NULL;
    size_t n = 0;
    int file;

    for (unsigned y = 0; y < 32;
         y++) /* a grey of 0.4 under a light that this sensor sees as green */
        for (unsigned x = 0; x < 64; x++)
            pixels[y][x] = (uint16_t)(100 + (y % 2 == 0 ? (x % 2 == 0 ? 799 : 1598)
                                                        : (x % 2 == 0 ? 1598 : 400)));
    assert_int_equal(ttf_raw_sum_init(&raw, &format), 0);
    assert_int_equal(ttf_raw_sum_add(&raw, &frame), 0);
    file = io->ops->open(io, path, TTF_IO_CREATE_NEW);
    assert_true(file >= 0);
    assert_int_equal(ttf_dng_write(&raw, &info, io, file, NULL), 0);
    (void)io->ops->close(io, file);
    ttf_raw_sum_free(&raw);
    assert_int_equal(ttf_thumbnail_of_file(io, path, &none, &size, &jpeg, &n, NULL), 0);
    small = decoded(state, jpeg, n);
    free(jpeg);
    assert_int_equal(small.width, 16);
    assert_int_equal(small.height, 8);
    row = ttf_pixbuf_row(&small, 4);
    for (int c = 0; c < 3; c++)
        assert_in_range(row[3 * 8 + c], 166, 172); /* sRGB of 0.4 */
    ttf_pixbuf_free(&small);
}

static void what_is_no_picture_is_refused(void **state)
{
    const struct ttf_stream stream = {.encoding = {0, 65535}};
    const struct ttf_thumbnail_size size = {.side = 16};
    const char *path = in_folder(state, "no.tif");
    void *jpeg = NULL;
    size_t n = 0;

    write_bytes(path, "II*", 3);
    assert_true(ttf_thumbnail_of_file(ttf_io_posix(), path, &stream, &size, &jpeg, &n, NULL) < 0);
    assert_true(ttf_thumbnail_of_file(ttf_io_posix(), in_folder(state, "none.dng"), &stream, &size,
                                      &jpeg, &n, NULL) < 0);
    assert_null(jpeg);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(a_large_image_becomes_a_small_picture_in_linear_light,
                                        folder_setup, folder_teardown),
        cmocka_unit_test_setup_teardown(what_is_small_stays_as_large_as_it_is, folder_setup,
                                        folder_teardown),
        cmocka_unit_test_setup_teardown(bytes_and_floats_mean_what_their_stream_says, folder_setup,
                                        folder_teardown),
        cmocka_unit_test_setup_teardown(a_stream_without_a_scale_is_not_shown, folder_setup,
                                        folder_teardown),
        cmocka_unit_test_setup_teardown(a_raw_file_is_shown_with_its_white_balance, folder_setup,
                                        folder_teardown),
        cmocka_unit_test_setup_teardown(what_is_no_picture_is_refused, folder_setup,
                                        folder_teardown),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
