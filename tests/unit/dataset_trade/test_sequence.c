/* SPDX-License-Identifier: Apache-2.0 */
#include "made_dataset.h"
#include "trade_test.h"

#include <errno.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ttf/dataset/reader.h"
#include "ttf/dataset/sequence.h"
#include "ttf/dataset/tiff.h"
#include "ttf/dataset/writer.h"

#define W MADE_W
#define H MADE_H

static struct ttf_sequence *open_stream(struct ttf_reader *reader, const char *stream)
{
    struct ttf_sequence *sequence = NULL;
    struct ttf_err err = {0};

    const struct ttf_sequence_choice choice = {.stream = stream};

    if (ttf_sequence_of_dataset(reader, &choice, &sequence, &err))
        fail_msg("%s: %s", err.where, err.what);
    return sequence;
}

static void of_a_bracket_the_reference_is_read_and_holes_are_left_out(void **state)
{
    const char *path = in_folder(state, "data");
    struct ttf_pixbuf a = make_picture(W, H, 3, TTF_SAMPLE_U16, 1),
                      b = make_picture(W, H, 3, TTF_SAMPLE_U16, 2),
                      c = make_picture(W, H, 3, TTF_SAMPLE_U16, 3);
    const struct shot bracket[] = {
        {"main", 0, 0.25, &a}, {"main", 1, 1.0, &b}, {"main", 2, 4.0, &c}};
    const struct shot lacking[] = {{"main", 0, 0.25, NULL}};
    struct ttf_manifest manifest;
    struct ttf_writer *writer;
    struct ttf_reader *reader;
    struct ttf_sequence *sequence;
    uint16_t rows[3 * W * 3];

    assert_int_equal(ttf_manifest_init(&manifest, NULL), 0);
    add_stream(&manifest, "main", 3, TTF_SAMPLE_U16);
    writer = create(path, &manifest);
    add_segment(writer, 0, 0, TTF_NS_UNKNOWN);
    add_slot(writer, 0, 0, TTF_NS_PER_H, bracket, 3);
    add_slot(writer, 1, 0, TTF_NS_PER_H + TTF_NS_PER_MIN, lacking, 1);
    add_slot(writer, 2, 0, TTF_NS_PER_H + 2 * TTF_NS_PER_MIN, bracket, 3);
    ttf_writer_close(writer);
    reader = open_reader(path);
    sequence = open_stream(reader, NULL);
    assert_int_equal(sequence->n, 2);
    assert_int_equal(sequence->index[1], 2);
    assert_true(sequence->time_ns[1] == 2 * TTF_NS_PER_MIN);
    assert_true(sequence->encoding.pedestal == TTF_PEDESTAL);
    assert_int_equal(ttf_sequence_read_rows(sequence, 1, 77, 3, rows, NULL), 0);
    assert_memory_equal(rows, ttf_pixbuf_row(&b, 77), sizeof(rows));
    assert_int_equal(ttf_sequence_read_rows(sequence, 2, 0, 1, rows, NULL), -EINVAL);
    assert_int_equal(ttf_sequence_read_rows(sequence, 0, H, 1, rows, NULL), -EINVAL);
    assert_int_equal(ttf_sequence_read_rows(sequence, 0, H + 1, 0, rows, NULL), -EINVAL);
    assert_int_equal(ttf_sequence_read_rows(sequence, 0, 0, H + 1, rows, NULL), -EINVAL);
    assert_int_equal(ttf_sequence_read_rows(sequence, 0, 1, UINT32_MAX, rows, NULL), -EINVAL);
    assert_int_equal(ttf_sequence_read_rows(sequence, 0, H, 0, rows, NULL), 0);
    ttf_sequence_destroy(sequence);
    ttf_reader_close(reader);
    ttf_pixbuf_free(&a);
    ttf_pixbuf_free(&b);
    ttf_pixbuf_free(&c);
}

static void grey_and_eight_bit_streams_read_as_sixteen_bit_rgb(void **state)
{
    const char *path = in_folder(state, "data");
    struct ttf_pixbuf grey = make_picture(W, H, 1, TTF_SAMPLE_U16, 1),
                      small = make_picture(W, H, 3, TTF_SAMPLE_U8, 2),
                      mask = make_picture(W, H, 1, TTF_SAMPLE_U8, 3);
    const struct shot shots[] = {
        {"grey", -1, 0, &grey}, {"small", -1, 0, &small}, {"mask", -1, 0, &mask}};
    struct ttf_sequence *sequence;
    struct ttf_manifest manifest;
    struct ttf_writer *writer;
    struct ttf_reader *reader;
    const struct ttf_sequence_choice age = {.stream = "age"}, none = {.stream = "none"};
    struct ttf_err err = {0};
    uint16_t row[W * 3];

    assert_int_equal(ttf_manifest_init(&manifest, NULL), 0);
    add_stream(&manifest, "grey", 1, TTF_SAMPLE_U16);
    add_stream(&manifest, "small", 3, TTF_SAMPLE_U8);
    add_stream(&manifest, "mask", 1, TTF_SAMPLE_U8);
    add_stream(&manifest, "age", 1, TTF_SAMPLE_F32);
    writer = create(path, &manifest);
    add_segment(writer, 0, 0, TTF_NS_UNKNOWN);
    add_slot(writer, 0, 0, TTF_NS_PER_H, shots, 3);
    ttf_writer_close(writer);
    reader = open_reader(path);
    sequence = open_stream(reader, NULL);
    assert_int_equal(ttf_sequence_read_rows(sequence, 0, 9, 1, row, NULL), 0);
    for (uint32_t i = 0; i < W * 3; i++)
        assert_int_equal(row[i], ((uint16_t *)ttf_pixbuf_row(&grey, 9))[i / 3]);
    ttf_sequence_destroy(sequence);
    sequence = open_stream(reader, "small");
    assert_true(sequence->encoding.scale == 65535.0);
    assert_int_equal(ttf_sequence_read_rows(sequence, 0, 9, 1, row, NULL), 0);
    for (uint32_t i = 0; i < W * 3; i++)
        assert_int_equal(row[i], ((uint8_t *)ttf_pixbuf_row(&small, 9))[i] * 257);
    ttf_sequence_destroy(sequence);
    sequence = open_stream(reader, "mask");
    assert_int_equal(ttf_sequence_read_rows(sequence, 0, 9, 1, row, NULL), 0);
    for (uint32_t i = 0; i < W * 3; i++)
        assert_int_equal(row[i], ((uint8_t *)ttf_pixbuf_row(&mask, 9))[i / 3] * 257);
    ttf_sequence_destroy(sequence);
    assert_int_equal(ttf_sequence_of_dataset(reader, &age, &sequence, &err), -ENODATA);
    assert_int_equal(ttf_sequence_of_dataset(reader, &none, &sequence, &err), -ENODATA);
    ttf_reader_close(reader);
    ttf_pixbuf_free(&grey);
    ttf_pixbuf_free(&small);
    ttf_pixbuf_free(&mask);
}

static void time_goes_on_over_boots_by_utc_or_else_by_the_grid(void **state)
{
    const char *path = in_folder(state, "data");
    struct ttf_pixbuf a = make_picture(W, H, 3, TTF_SAMPLE_U16, 1);
    const struct shot shot = {"main", -1, 0, &a};
    struct ttf_manifest manifest;
    struct ttf_writer *writer;
    struct ttf_reader *reader;
    struct ttf_sequence *sequence;

    assert_int_equal(ttf_manifest_init(&manifest, NULL), 0);
    add_stream(&manifest, "main", 3, TTF_SAMPLE_U16);
    writer = create(path, &manifest);
    add_segment(writer, 0, 0, 1000 * TTF_NS_PER_H);
    add_slot(writer, 0, 0, TTF_NS_PER_H, &shot, 1);
    add_slot(writer, 1, 0, TTF_NS_PER_H + TTF_NS_PER_MIN, &shot, 1);
    add_segment(writer, 1, 2, 1005 * TTF_NS_PER_H);
    add_slot(writer, 2, 1, 2 * TTF_NS_PER_H, &shot, 1);
    add_slot(writer, 3, 1, 2 * TTF_NS_PER_H + TTF_NS_PER_MIN, &shot, 1);
    add_segment(writer, 2, 4, TTF_NS_UNKNOWN);
    add_slot(writer, 4, 2, 3 * TTF_NS_PER_H, &shot, 1);
    ttf_writer_close(writer);
    reader = open_reader(path);
    sequence = open_stream(reader, NULL);
    assert_int_equal(sequence->n, 5);
    assert_true(sequence->time_ns[1] == TTF_NS_PER_MIN);
    assert_true(sequence->time_ns[2] == 5 * TTF_NS_PER_H);
    assert_true(sequence->time_ns[3] == 5 * TTF_NS_PER_H + TTF_NS_PER_MIN);
    assert_true(sequence->time_ns[4] == 5 * TTF_NS_PER_H + 2 * TTF_NS_PER_MIN);
    ttf_sequence_destroy(sequence);
    ttf_reader_close(reader);
    ttf_pixbuf_free(&a);
}

/* As no box writes them, and somebody else's program may: the frames are there all the same, and their times are no accident. */
static void times_beyond_all_that_can_be_said_are_as_if_the_grid_had_gone_on(void **state)
{
    const char *path = in_folder(state, "data");
    struct ttf_pixbuf a = make_picture(W, H, 3, TTF_SAMPLE_U16, 1);
    const struct shot shot = {"main", -1, 0, &a};
    struct ttf_manifest manifest;
    struct ttf_writer *writer;
    struct ttf_reader *reader;
    struct ttf_sequence *sequence;

    assert_int_equal(ttf_manifest_init(&manifest, NULL), 0);
    add_stream(&manifest, "main", 3, TTF_SAMPLE_U16);
    writer = create(path, &manifest);
    add_segment(writer, 0, 0, INT64_MIN + 2 * TTF_NS_PER_H);
    add_slot(writer, 0, 0, TTF_NS_PER_H, &shot, 1);
    add_segment(writer, 1, 1, INT64_MAX - 2 * TTF_NS_PER_H);
    add_slot(writer, 1, 1, 0, &shot, 1);
    add_slot(writer, 2, 1, INT64_MAX - TTF_NS_PER_H, &shot, 1);
    add_segment(writer, 2, 3, TTF_NS_UNKNOWN);
    add_slot(writer, 3, 2, 0, &shot, 1);
    add_segment(writer, 3, 4, TTF_NS_UNKNOWN);
    for (int64_t i = 4; i < 6; i++)
        add_slot(writer, i, 3, INT64_MAX, &shot, 1);
    ttf_writer_close(writer);
    reader = open_reader(path);
    sequence = open_stream(reader, NULL);
    assert_int_equal(sequence->n, 6);
    assert_true(sequence->time_ns[1] == TTF_NS_PER_MIN);
    assert_true(sequence->time_ns[2] == INT64_MAX - TTF_NS_PER_H + TTF_NS_PER_MIN);
    assert_true(sequence->time_ns[3] == sequence->time_ns[2] + TTF_NS_PER_MIN);
    assert_true(sequence->time_ns[5] == sequence->time_ns[4]);
    ttf_sequence_destroy(sequence);
    ttf_reader_close(reader);

    path = in_folder(state, "backwards");
    writer = create(path, &manifest);
    add_segment(writer, 0, 0, TTF_NS_UNKNOWN);
    add_slot(writer, 0, 0, 2, &shot, 1);
    add_slot(writer, 1, 0, INT64_MIN + 1, &shot, 1);
    ttf_writer_close(writer);
    reader = open_reader(path);
    sequence = open_stream(reader, NULL);
    assert_true(sequence->time_ns[1] == TTF_NS_PER_MIN);
    ttf_sequence_destroy(sequence);
    ttf_reader_close(reader);
    ttf_pixbuf_free(&a);
}

static void streams_that_are_no_pictures_are_refused_by_name(void **state)
{
    static const struct {
        const char *id, *says;
        int code;
    } cases[] = {
        {"pair", "stream 'pair' has 2 samples a pixel", -ENOTSUP},
        {"none", "there is no stream 'none'", -ENODATA},
        {"empty", "", -ENODATA},
    };
    const char *path = in_folder(state, "data");
    struct ttf_manifest manifest;
    struct ttf_writer *writer;
    struct ttf_reader *reader;

    assert_int_equal(ttf_manifest_init(&manifest, NULL), 0);
    add_stream(&manifest, "pair", 2, TTF_SAMPLE_U16);
    add_stream(&manifest, "empty", 3, TTF_SAMPLE_U16);
    writer = create(path, &manifest);
    add_segment(writer, 0, 0, TTF_NS_UNKNOWN);
    ttf_writer_close(writer);
    reader = open_reader(path);
    for (unsigned i = 0; i < sizeof(cases) / sizeof(*cases); i++) {
        const struct ttf_sequence_choice choice = {.stream = cases[i].id};
        struct ttf_sequence *sequence = NULL;
        struct ttf_err err = {0};

        assert_int_equal(ttf_sequence_of_dataset(reader, &choice, &sequence, &err), cases[i].code);
        if (!strstr(err.what, cases[i].says))
            fail_msg("'%s' does not say '%s'", err.what, cases[i].says);
        assert_null(sequence);
    }
    ttf_reader_close(reader);
}

struct reading {
    struct ttf_sequence *sequence;
    const struct ttf_pixbuf *frames;
    unsigned seed;
    unsigned wrong;
};

static void *read_at_random(void *ctx)
{
    struct reading *reading = ctx;
    uint32_t x = reading->seed;
    uint16_t rows[4 * W * 3];

    for (unsigned i = 0; i < 400; i++) {
        uint32_t t, y;

        x = x * 1664525u + 1013904223u;
        t = (x >> 8) % (i % 2 ? reading->sequence->n : 2); /* two of them wanted by all */
        y = (x >> 16) % (H - 4);
        if (ttf_sequence_read_rows(reading->sequence, t, y, 4, rows, NULL) ||
            memcmp(rows, ttf_pixbuf_row(&reading->frames[t], y), sizeof(rows)) != 0)
            reading->wrong++;
    }
    return NULL;
}

static void many_threads_read_one_sequence_with_bounded_open_files(void **state)
{
    enum {
        FRAMES = 24,
        THREADS = 4
    };
    const char *path = in_folder(state, "data");
    struct ttf_pixbuf frames[FRAMES];
    struct reading reading[THREADS];
    pthread_t thread[THREADS];
    struct ttf_manifest manifest;
    struct ttf_writer *writer;
    struct ttf_reader *reader;
    struct ttf_sequence *sequence;
    int files;

    assert_int_equal(ttf_manifest_init(&manifest, NULL), 0);
    add_stream(&manifest, "main", 3, TTF_SAMPLE_U16);
    writer = create(path, &manifest);
    add_segment(writer, 0, 0, TTF_NS_UNKNOWN);
    for (unsigned t = 0; t < FRAMES; t++) {
        const struct shot shot = {"main", -1, 0, &frames[t]};

        frames[t] = make_picture(W, H, 3, TTF_SAMPLE_U16, t);
        add_slot(writer, t, 0, TTF_NS_PER_H + t * TTF_NS_PER_MIN, &shot, 1);
    }
    ttf_writer_close(writer);
    reader = open_reader(path);
    files = count_entries("/proc/self/fd");
    sequence = open_stream(reader, NULL);
    for (unsigned i = 0; i < THREADS; i++) {
        reading[i] = (struct reading){sequence, frames, i + 1, 0};
        assert_int_equal(pthread_create(&thread[i], NULL, read_at_random, &reading[i]), 0);
    }
    for (unsigned i = 0; i < THREADS; i++) {
        pthread_join(thread[i], NULL);
        assert_int_equal(reading[i].wrong, 0);
    }
    assert_true(count_entries("/proc/self/fd") <= files + 16);
    ttf_sequence_destroy(sequence);
    assert_int_equal(count_entries("/proc/self/fd"), files);
    ttf_reader_close(reader);
    for (unsigned t = 0; t < FRAMES; t++)
        ttf_pixbuf_free(&frames[t]);
}

static void an_image_of_another_size_than_its_stream_is_damage(void **state)
{
    const char *path = in_folder(state, "data");
    struct ttf_pixbuf odd = make_picture(W + 1, H, 3, TTF_SAMPLE_U16, 1);
    const struct shot shot = {"main", -1, 0, &odd};
    struct ttf_manifest manifest;
    struct ttf_writer *writer;
    struct ttf_reader *reader;
    struct ttf_sequence *sequence;
    uint16_t row[(W + 1) * 3];
    struct ttf_err err = {0};

    assert_int_equal(ttf_manifest_init(&manifest, NULL), 0);
    add_stream(&manifest, "main", 3, TTF_SAMPLE_U16);
    writer = create(path, &manifest);
    add_segment(writer, 0, 0, TTF_NS_UNKNOWN);
    add_slot(writer, 0, 0, TTF_NS_PER_H, &shot, 1);
    ttf_writer_close(writer);
    reader = open_reader(path);
    sequence = open_stream(reader, NULL);
    assert_int_equal(ttf_sequence_read_rows(sequence, 0, 0, 1, row, &err), -TTF_EDAMAGED);
    assert_non_null(strstr(err.where, "000000.tif"));
    ttf_sequence_destroy(sequence);
    ttf_reader_close(reader);
    ttf_pixbuf_free(&odd);
}

static void a_picture_file_is_a_sequence_of_one_frame(void **state)
{
    const char *path = in_folder(state, "a.png");
    struct ttf_pixbuf want = make_picture(W, H, 3, TTF_SAMPLE_U8, 5);
    struct ttf_sequence *sequence;
    uint16_t row[W * 3];

    save_png(path, &want);
    assert_int_equal(ttf_sequence_of_image(ttf_io_posix(), path, &sequence, NULL), 0);
    assert_int_equal(sequence->n, 1);
    assert_int_equal(ttf_sequence_read_rows(sequence, 0, 7, 1, row, NULL), 0);
    for (uint32_t i = 0; i < W * 3; i++)
        assert_int_equal(row[i], ttf_srgb8_to_linear16(((uint8_t *)ttf_pixbuf_row(&want, 7))[i]));
    ttf_sequence_destroy(sequence);
    ttf_pixbuf_free(&want);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
#define IN_FOLDER(f) cmocka_unit_test_setup_teardown(f, folder_setup, folder_teardown)
        IN_FOLDER(of_a_bracket_the_reference_is_read_and_holes_are_left_out),
        IN_FOLDER(grey_and_eight_bit_streams_read_as_sixteen_bit_rgb),
        IN_FOLDER(time_goes_on_over_boots_by_utc_or_else_by_the_grid),
        IN_FOLDER(streams_that_are_no_pictures_are_refused_by_name),
        IN_FOLDER(times_beyond_all_that_can_be_said_are_as_if_the_grid_had_gone_on),
        IN_FOLDER(many_threads_read_one_sequence_with_bounded_open_files),
        IN_FOLDER(an_image_of_another_size_than_its_stream_is_damage),
        IN_FOLDER(a_picture_file_is_a_sequence_of_one_frame),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
