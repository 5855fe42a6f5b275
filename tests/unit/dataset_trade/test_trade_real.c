/* SPDX-License-Identifier: Apache-2.0 */
/* Real sequences that nobody here made: imported, exported, compared with their sources. */
#include "imported.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ttf/dataset/export.h"
#include "ttf/dataset/import.h"
#include "ttf/dataset/reader.h"
#include "ttf/dataset/sequence.h"

#define INPUTS_MAX 256

static int sync_nothing(struct ttf_io *io, int file, bool data_only)
{
    return 0;
}

static int sync_no_folder(struct ttf_io *io, const char *path)
{
    return 0;
}

/* The machine's files without waiting for its disk: hundreds of frames are looked at here, not power cuts. */
static struct ttf_io *quick_io(void)
{
    static struct ttf_io_ops ops;
    static struct ttf_io io = {.ops = &ops};

    ops = *ttf_io_posix()->ops;
    ops.sync = sync_nothing;
    ops.sync_dir = sync_no_folder;
    return &io;
}

struct inputs {
    char *path[INPUTS_MAX];
    size_t n;
};

struct listing {
    struct inputs *inputs;
    const char *folder, *ending;
};

static int take_input(void *ctx, const char *name, bool is_dir)
{
    const struct listing *listing = ctx;
    size_t n = strlen(name), m = strlen(listing->ending), room = strlen(listing->folder) + n + 2;
    char *path;

    if (n < m || strcmp(name + n - m, listing->ending) != 0 || listing->inputs->n == INPUTS_MAX)
        return 0;
    path = malloc(room);
    assert_non_null(path);
    snprintf(path, room, "%s/%s", listing->folder, name);
    listing->inputs->path[listing->inputs->n++] = path;
    return 0;
}

/* In the disk's order, which is none. */
static struct inputs list_inputs(const char *folder, const char *ending)
{
    struct inputs inputs = {.n = 0};
    struct listing listing = {&inputs, folder, ending};
    struct ttf_io *io = ttf_io_posix();

    assert_true(io->ops->list(io, folder, take_input, &listing) >= 0);
    assert_true(inputs.n > 0);
    return inputs;
}

static void free_inputs(struct inputs *inputs)
{
    for (size_t i = 0; i < inputs->n; i++)
        free(inputs->path[i]);
}

static struct ttf_sequence *open_sequence(const char *path, struct ttf_reader **ret_reader)
{
    struct ttf_sequence *sequence = NULL;
    struct ttf_err err = {0};

    if (ttf_reader_open(ttf_io_posix(), path, ret_reader, &err) ||
        ttf_sequence_of_dataset(*ret_reader, NULL, &sequence, &err))
        fail_msg("%s: %s", err.where, err.what);
    return sequence;
}

static void comes_back_to_the_bit(void **state, const char *which)
{
    const char *folder = real_data(which);
    struct ttf_import_config config = {.output = in_folder(state, "data"),
                                       .interval_ns = TTF_NS_PER_MIN};
    struct ttf_export_config out = {.kind = TTF_EXPORT_PNG, .output = in_folder(state, "out")};
    struct ttf_import_result result;
    struct ttf_sequence *sequence;
    struct ttf_reader *reader;
    struct inputs inputs;

    if (!folder)
        skip();
    inputs = list_inputs(folder, ".png");
    config.inputs = (const char *const *)inputs.path;
    config.n_inputs = inputs.n;
    result = import_ok(quick_io(), &config);
    assert_int_equal(result.frames, inputs.n);
    sequence = open_sequence(config.output, &reader);
    assert_int_equal(ttf_export(sequence, quick_io(), &out, NULL, NULL), 0);
    for (unsigned i = 0; i < inputs.n; i++) {
        char source[600];
        struct ttf_pixbuf a, b;

        snprintf(source, sizeof(source), "%s/%03u.png", folder, i);
        assert_int_equal(ttf_image_read(ttf_io_posix(), source, 0, &a, NULL, NULL), 0);
        assert_int_equal(ttf_image_read(ttf_io_posix(),
                                        in_folder(state, "out/frame.%u.png", 1001 + i), 0, &b, NULL,
                                        NULL),
                         0);
        assert_true(same_pixels(&a, &b));
        ttf_pixbuf_free(&a);
        ttf_pixbuf_free(&b);
    }
    ttf_sequence_destroy(sequence);
    ttf_reader_close(reader);
    free_inputs(&inputs);
}

static void copper_comes_back_to_the_bit(void **state)
{
    comes_back_to_the_bit(state, "timelapse/copper");
}

static void clay_comes_back_to_the_bit(void **state)
{
    comes_back_to_the_bit(state, "timelapse/clay");
}

static void ice_lies_a_minute_apart_by_camera_time_and_by_name(void **state)
{
    const char *folder = real_data("timelapse/ice");
    struct ttf_import_config config = {.output = in_folder(state, "exif"),
                                       .order = TTF_IMPORT_EXIF_TIME};
    struct ttf_import_result result;
    struct ttf_segment segment;
    struct ttf_sequence *sequence;
    struct ttf_reader *reader;
    struct inputs inputs;

    if (!folder)
        skip();
    inputs = list_inputs(folder, ".jpg");
    config.inputs = (const char *const *)inputs.path;
    config.n_inputs = inputs.n;
    result = import_ok(quick_io(), &config);
    assert_int_equal(result.frames, 70);
    assert_true(result.interval_ns == TTF_NS_PER_MIN);
    assert_false(result.foreign_profile); /* they carry one, of sRGB */
    sequence = open_sequence(config.output, &reader);
    assert_int_equal(ttf_reader_segment(reader, 0, &segment), 0);
    assert_true(segment.origin_utc_ns == INT64_C(1115223229) * TTF_NS_PER_S);
    ttf_sequence_destroy(sequence);
    ttf_reader_close(reader);
    config.order = TTF_IMPORT_NAME_TIME;
    config.interval_ns = TTF_NS_PER_MIN;
    config.output = in_folder(state, "name");
    result = import_ok(quick_io(), &config);
    assert_int_equal(result.frames, 70);
    free_inputs(&inputs);
}

static void banana_lies_on_a_grid_of_days_with_missed_ones(void **state)
{
    const char *folder = real_data("timelapse/banana");
    struct ttf_import_config config = {.output = in_folder(state, "data"),
                                       .order = TTF_IMPORT_NAME_TIME,
                                       .region = {600, 400, 200, 100},
                                       .interval_ns = TTF_NS_PER_DAY};
    struct ttf_import_result result;
    struct inputs inputs;

    if (!folder)
        skip();
    inputs = list_inputs(folder, ".png");
    config.inputs = (const char *const *)inputs.path;
    config.n_inputs = inputs.n;
    result = import_ok(quick_io(), &config);
    assert_int_equal(result.frames, 20);
    assert_int_equal(result.missed, 1); /* nobody photographed it on 31 May */
    assert_true(result.alpha_dropped);
    free_inputs(&inputs);
}

static void golgi_is_a_stack_of_floats(void **state)
{
    const char *path =
        real_data("timelapse/golgi/xyt_calibrated_16bit__golgi_bfa_sum_projection.tif");
    struct ttf_import_config config = {.inputs = &path,
                                       .n_inputs = 1,
                                       .output = in_folder(state, "data"),
                                       .interval_ns = TTF_NS_PER_S};
    struct ttf_export_config out = {.kind = TTF_EXPORT_SHEET,
                                    .output = in_folder(state, "sheet.png")};
    struct ttf_import_result result;
    struct ttf_sequence *sequence;
    struct ttf_reader *reader;
    struct ttf_pixbuf page;
    uint16_t *frame;

    if (!path)
        skip();
    result = import_ok(quick_io(), &config);
    assert_int_equal(result.frames, 30);
    assert_int_equal(result.width, 147);
    assert_int_equal(result.samples, 1);
    sequence = open_sequence(config.output, &reader);
    assert_int_equal(ttf_image_read(ttf_io_posix(), path, 17, &page, NULL, NULL), 0);
    frame = malloc((size_t)147 * 137 * 6);
    assert_int_equal(ttf_sequence_read_rows(sequence, 17, 0, 137, frame, NULL), 0);
    for (size_t i = 0; i < (size_t)147 * 137; i++) {
        double value = (frame[3 * i] - sequence->encoding.pedestal) / sequence->encoding.scale;

        assert_true(fabs(value - (double)((float *)page.data)[i]) <=
                    0.51 / sequence->encoding.scale);
    }
    free(frame);
    ttf_pixbuf_free(&page);
    assert_int_equal(ttf_export(sequence, quick_io(), &out, NULL, NULL), 0);
    ttf_sequence_destroy(sequence);
    ttf_reader_close(reader);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
#define IN_FOLDER(f) cmocka_unit_test_setup_teardown(f, folder_setup, folder_teardown)
        IN_FOLDER(copper_comes_back_to_the_bit),
        IN_FOLDER(clay_comes_back_to_the_bit),
        IN_FOLDER(ice_lies_a_minute_apart_by_camera_time_and_by_name),
        IN_FOLDER(banana_lies_on_a_grid_of_days_with_missed_ones),
        IN_FOLDER(golgi_is_a_stack_of_floats),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
