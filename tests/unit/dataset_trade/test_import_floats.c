/* SPDX-License-Identifier: Apache-2.0 */
/* Pictures of floats: kept as light, in a range that holds them. */
#include "imported.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "ttf/dataset/tiff.h"

#define W 24
#define H 17

static void a_float_stack_keeps_its_values(void **state)
{
    const char *const inputs[] = {in_folder(state, "f.tif")};
    struct ttf_import_config config = {.inputs = inputs,
                                       .n_inputs = 1,
                                       .output = in_folder(state, "data"),
                                       .interval_ns = TTF_NS_PER_S};
    struct ttf_pixbuf pixels = make_picture(W, H, 1, TTF_SAMPLE_F32, 9);
    struct ttf_tiff_spec spec = {.times = {.start_utc_ns = TTF_NS_UNKNOWN}};
    struct ttf_io *io = ttf_io_posix();
    struct ttf_import_result result;
    struct opened opened;
    double lo = INFINITY, hi = -INFINITY;
    uint16_t *frame;
    int file;

    ((float *)pixels.data)[5] = NAN;
    file = io->ops->open(io, inputs[0], TTF_IO_CREATE_NEW);
    assert_int_equal(ttf_tiff_write(io, file, &pixels, &spec, NULL), 0);
    io->ops->close(io, file);
    for (size_t i = 0; i < (size_t)W * H; i++) {
        float value = ((float *)pixels.data)[i];

        if (isfinite(value)) {
            lo = fmin(lo, (double)value);
            hi = fmax(hi, (double)value);
        }
    }
    result = import_ok(ttf_io_posix(), &config);
    assert_int_equal(result.samples, 1);
    opened = open_dataset(config.output);
    frame = read_frame(opened.sequence, 0);
    for (size_t i = 0; i < (size_t)W * H; i++) {
        const struct ttf_encoding *encoding = &opened.sequence->encoding;
        double value = (frame[3 * i] - encoding->pedestal) / encoding->scale;

        if (i != 5)
            assert_true(fabs(value - (double)((float *)pixels.data)[i]) <=
                        (hi - lo) / 65535.0 * 0.51);
    }
    free(frame);
    close_dataset(&opened);
    ttf_pixbuf_free(&pixels);
}

/* A grey picture of floats with a profile; even: of this value everywhere (0: -2 to 2). */
static void write_floats(const char *path, float even, enum ttf_icc icc)
{
    struct ttf_pixbuf pixels = make_picture(W, H, 1, TTF_SAMPLE_F32, 9);
    struct ttf_tiff_spec spec = {.times = {.start_utc_ns = TTF_NS_UNKNOWN}, .icc = icc};
    struct ttf_io *io = ttf_io_posix();
    int file;

    for (size_t i = 0; i < (size_t)W * H; i++)
        ((float *)pixels.data)[i] = even != 0 ? even : (float)(i % 5) - 2;
    (void)io->ops->unlink(io, path);
    file = io->ops->open(io, path, TTF_IO_CREATE_NEW);
    assert_int_equal(ttf_tiff_write(io, file, &pixels, &spec, NULL), 0);
    io->ops->close(io, file);
    ttf_pixbuf_free(&pixels);
}

/* The scale of what such a picture is kept with. */
static struct ttf_encoding encoding_of_floats(void **state, float even,
                                              struct ttf_image_range range, const char *output)
{
    const char *const inputs[] = {in_folder(state, "range.tif")};
    struct ttf_import_config config = {.inputs = inputs,
                                       .n_inputs = 1,
                                       .output = in_folder(state, "%s", output),
                                       .range = range,
                                       .interval_ns = TTF_NS_PER_S};
    struct ttf_encoding encoding;
    struct opened opened;

    write_floats(inputs[0], even, TTF_ICC_NONE);
    import_ok(ttf_io_posix(), &config);
    opened = open_dataset(config.output);
    encoding = opened.sequence->encoding;
    close_dataset(&opened);
    return encoding;
}

static void floats_are_kept_in_the_range_asked_for_or_their_own(void **state)
{
    struct ttf_encoding e = encoding_of_floats(state, 0, (struct ttf_image_range){0}, "own");

    assert_float_equal(e.scale, 65535.0 / 4, 1e-6);
    assert_float_equal(e.pedestal, 65535.0 / 2, 1e-6);
    e = encoding_of_floats(state, 0, (struct ttf_image_range){-4, 4}, "asked");
    assert_float_equal(e.scale, 65535.0 / 8, 1e-6);
    assert_float_equal(e.pedestal, 65535.0 / 2, 1e-6);
    /* One value has no range: from it to 1 above. */
    e = encoding_of_floats(state, 3, (struct ttf_image_range){0}, "even/");
    assert_float_equal(e.scale, 65535, 1e-6);
    assert_float_equal(e.pedestal, -3 * 65535.0, 1e-6);
    /* ... or as far above as numbers of its size are told apart. */
    e = encoding_of_floats(state, 1e20f, (struct ttf_image_range){0}, "large");
    assert_float_equal((0.0 - e.pedestal) / e.scale / (double)1e20f, 1, 1e-6);
}

/* Floats are light, whatever a profile says of codes; and numbers beyond 1 are no codes of a curve. */
static void floats_are_linear_by_themselves(void **state)
{
    const char *const inputs[] = {in_folder(state, "curved.tif")};
    struct ttf_import_config config = {.inputs = inputs,
                                       .n_inputs = 1,
                                       .output = in_folder(state, "curved"),
                                       .range = {-2, 2},
                                       .interval_ns = TTF_NS_PER_S};
    struct ttf_import_result result;
    struct ttf_err err = {0};
    struct opened opened;
    uint16_t row[W * 3];

    write_floats(inputs[0], 0, TTF_ICC_SRGB);
    import_ok(ttf_io_posix(), &config);
    opened = open_dataset(config.output);
    assert_int_equal(ttf_sequence_read_rows(opened.sequence, 0, 0, 1, row, NULL), 0);
    for (unsigned i = 0; i < 5; i++)
        assert_int_equal(row[3 * i], (i * 65535 + 2) / 4);
    close_dataset(&opened);
    config.output = in_folder(state, "asked-curve");
    config.range = (struct ttf_image_range){0};
    config.transfer = TTF_TRANSFER_SRGB;
    assert_int_equal(ttf_import(ttf_io_posix(), &config, &result, &err), -EINVAL);
    assert_non_null(strstr(err.what, "no sRGB codes"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
#define IN_FOLDER(f) cmocka_unit_test_setup_teardown(f, folder_setup, folder_teardown)
        IN_FOLDER(a_float_stack_keeps_its_values),
        IN_FOLDER(floats_are_kept_in_the_range_asked_for_or_their_own),
        IN_FOLDER(floats_are_linear_by_themselves),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
