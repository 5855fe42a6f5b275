/* SPDX-License-Identifier: Apache-2.0 */
/* test_choice.c: which images of a dataset are taken, what people said of them, and streams of floats. */
#include <errno.h>
#include <math.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "made_dataset.h"
#include "trade_test.h"
#include "ttf/dataset/export.h"
#include "ttf/dataset/notes.h"
#include "ttf/dataset/samples.h"
#include "ttf/dataset/sequence.h"
#include "ttf/dataset/verify.h"

#define W MADE_W
#define H MADE_H

/* Slots 0..n-1 a minute apart, each a bracket of three. */
static const char *bracketed(void **state, int64_t n)
{
    const char *path = in_folder(state, "data");
    struct ttf_pixbuf pictures[3];
    struct ttf_manifest manifest;
    struct ttf_writer *writer;

    assert_int_equal(ttf_manifest_init(&manifest, NULL), 0);
    add_stream(&manifest, "main", 3, TTF_SAMPLE_U16);
    writer = create(path, &manifest);
    add_segment(writer, 0, 0, TTF_NS_UNKNOWN);
    for (int64_t i = 0; i < n; i++) {
        for (unsigned b = 0; b < 3; b++)
            pictures[b] = make_picture(W, H, 3, TTF_SAMPLE_U16, (unsigned)i * 3 + b);
        add_slot(writer, i, 0, TTF_NS_PER_H + i * TTF_NS_PER_MIN,
                 (struct shot[]){{"main", 0, 0.25, &pictures[0]},
                                 {"main", 1, 1.0, &pictures[1]},
                                 {"main", 2, 4.0, &pictures[2]}},
                 3);
        for (unsigned b = 0; b < 3; b++)
            ttf_pixbuf_free(&pictures[b]);
    }
    ttf_writer_close(writer);
    return path;
}

/* Slots of one f32 grey picture each: value = slot + 0.5 x + 1000 y, one not a number. */
static const char *floats(void **state, int64_t n)
{
    const char *path = in_folder(state, "floats");
    struct ttf_manifest manifest;
    struct ttf_writer *writer;
    struct ttf_pixbuf age;

    assert_int_equal(ttf_manifest_init(&manifest, NULL), 0);
    add_stream(&manifest, "age", 1, TTF_SAMPLE_F32);
    writer = create(path, &manifest);
    add_segment(writer, 0, 0, TTF_NS_UNKNOWN);
    assert_int_equal(ttf_pixbuf_alloc(&age, W, H, 1, TTF_SAMPLE_F32), 0);
    for (int64_t i = 0; i < n; i++) {
        for (uint32_t y = 0; y < H; y++)
            for (uint32_t x = 0; x < W; x++)
                ((float *)ttf_pixbuf_row(&age, y))[x] =
                    (float)i + 0.5f * (float)x + 1000.0f * (float)y;
        ((float *)age.data)[3] = NAN;
        add_slot(writer, 2 * i, 0, TTF_NS_PER_H + 2 * i * TTF_NS_PER_MIN,
                 &(struct shot){"age", -1, 0, &age}, 1);
    }
    ttf_pixbuf_free(&age);
    ttf_writer_close(writer);
    return path;
}

static struct ttf_sequence *chosen(struct ttf_reader *reader, struct ttf_sequence_choice choice)
{
    struct ttf_sequence *sequence = NULL;
    struct ttf_err err = {0};

    if (ttf_sequence_of_dataset(reader, &choice, &sequence, &err))
        fail_msg("%s: %s", err.where, err.what);
    return sequence;
}

static void a_bracket_of_ones_choice_is_read(void **state)
{
    struct ttf_reader *reader = open_reader(bracketed(state, 2));
    struct ttf_sequence *sequence;
    struct ttf_err err = {0};
    uint16_t row[W * 3];

    for (int b = 0; b < 3; b++) {
        struct ttf_pixbuf want = make_picture(W, H, 3, TTF_SAMPLE_U16, 3 + (unsigned)b);

        sequence = chosen(reader, (struct ttf_sequence_choice){.one_bracket = true, .bracket = b});
        assert_int_equal(sequence->n, 2);
        assert_int_equal(ttf_sequence_read_rows(sequence, 1, 40, 1, row, NULL), 0);
        assert_memory_equal(row, ttf_pixbuf_row(&want, 40), sizeof(row));
        ttf_sequence_destroy(sequence);
        ttf_pixbuf_free(&want);
    }
    assert_int_equal(ttf_sequence_of_dataset(
                         reader, &(struct ttf_sequence_choice){.one_bracket = true, .bracket = 3},
                         &sequence, &err),
                     -ENODATA);
    assert_non_null(strstr(err.what, "bracket 3"));
    ttf_reader_close(reader);
}

/* Grey, of floats, and of bytes, beside 16-bit colours. */
static void what_lies_beside_an_image_is_read_by_its_role(void **state)
{
    const char *path = in_folder(state, "data");
    struct ttf_pixbuf picture = make_picture(W, H, 3, TTF_SAMPLE_U16, 1), sigma, mask;
    struct ttf_manifest manifest;
    struct ttf_sequence *sequence;
    struct ttf_reader *reader;
    struct ttf_writer *writer;
    struct ttf_err err = {0};
    uint16_t row[W * 3];
    float values[W * 3];

    assert_int_equal(ttf_manifest_init(&manifest, NULL), 0);
    add_stream(&manifest, "main", 3, TTF_SAMPLE_U16);
    writer = create(path, &manifest);
    add_segment(writer, 0, 0, TTF_NS_UNKNOWN);
    assert_int_equal(ttf_pixbuf_alloc(&sigma, W, H, 1, TTF_SAMPLE_F32), 0);
    assert_int_equal(ttf_pixbuf_alloc(&mask, W, H, 1, TTF_SAMPLE_U8), 0);
    for (uint32_t y = 0; y < H; y++)
        for (uint32_t x = 0; x < W; x++) {
            ((float *)ttf_pixbuf_row(&sigma, y))[x] = 0.25f * (float)x;
            ((uint8_t *)ttf_pixbuf_row(&mask, y))[x] = x < 5 ? 255 : 0;
        }
    for (int64_t i = 0; i < 3; i++) /* the second has nothing beside it */
        add_slot_beside(writer, i, TTF_NS_PER_H + i * TTF_NS_PER_MIN, &picture,
                        i == 1 ? NULL : &sigma, i == 1 ? NULL : &mask);
    ttf_writer_close(writer);
    reader = open_reader(path);

    sequence = chosen(reader, (struct ttf_sequence_choice){.role = "uncertainty"});
    assert_int_equal(sequence->n, 2);
    assert_int_equal(sequence->index[1], 2);
    assert_int_equal(ttf_sequence_read_values(sequence, 1, 7, 1, values, NULL), 0);
    for (uint32_t x = 0; x < W; x++)
        assert_true(values[x * 3] == 0.25f * (float)x && values[x * 3 + 2] == values[x * 3]);
    ttf_sequence_destroy(sequence);

    sequence = chosen(reader, (struct ttf_sequence_choice){.role = "mask"});
    assert_int_equal(sequence->n, 2);
    assert_true(sequence->encoding.pedestal == 0 && sequence->encoding.scale == 65535);
    assert_int_equal(ttf_sequence_read_rows(sequence, 0, 7, 1, row, NULL), 0);
    for (uint32_t x = 0; x < W; x++)
        assert_int_equal(row[x * 3 + 1], x < 5 ? 65535 : 0);
    ttf_sequence_destroy(sequence);

    sequence = chosen(reader, (struct ttf_sequence_choice){.role = "developed"});
    assert_int_equal(sequence->n, 3);
    ttf_sequence_destroy(sequence);
    assert_int_equal(ttf_sequence_of_dataset(reader, &(struct ttf_sequence_choice){.role = "raw"},
                                             &sequence, &err),
                     -EINVAL);
    ttf_reader_close(reader);
    ttf_pixbuf_free(&picture);
    ttf_pixbuf_free(&sigma);
    ttf_pixbuf_free(&mask);
}

static void no_uncertainty_is_no_developed_image(void **state)
{
    struct ttf_reader *reader = open_reader(bracketed(state, 2));
    struct ttf_sequence *sequence;
    struct ttf_err err = {0};

    assert_int_equal(ttf_sequence_of_dataset(reader,
                                             &(struct ttf_sequence_choice){.role = "uncertainty"},
                                             &sequence, &err),
                     -ENODATA);
    assert_non_null(strstr(err.what, "no uncertainty image"));
    ttf_reader_close(reader);
}

static void note(const char *path, const char *tag, int64_t first, int64_t last)
{
    struct ttf_note note = {.utc_ns = TTF_NS_UNKNOWN, .n_tags = 1};

    snprintf(note.tags[0], sizeof(note.tags[0]), "%s", tag);
    if (first >= 0) {
        note.n_slots = 1;
        note.slots[0][0] = first;
        note.slots[0][1] = last;
    }
    assert_int_equal(ttf_note_append(ttf_io_posix(), path, &note, NULL), 0);
}

static void what_a_note_excludes_is_left_out_unless_asked_for(void **state)
{
    const char *path = bracketed(state, 6);
    struct ttf_reader *reader = open_reader(path);
    struct ttf_sequence *sequence;
    struct ttf_err err = {0};

    note(path, "reference", 0, 5);
    note(path, "exclude", 1, 2);
    note(path, "exclude", 4, 4);
    sequence = chosen(reader, (struct ttf_sequence_choice){0});
    assert_int_equal(sequence->n, 3);
    assert_int_equal(sequence->index[1], 3);
    assert_true(sequence->time_ns[1] == 3 * TTF_NS_PER_MIN);
    assert_int_equal(sequence->n_excluded, 3);
    assert_int_equal(sequence->excluded[2], 4);
    ttf_sequence_destroy(sequence);
    sequence = chosen(reader, (struct ttf_sequence_choice){.with_excluded = true});
    assert_int_equal(sequence->n, 6);
    assert_int_equal(sequence->n_excluded, 0);
    ttf_sequence_destroy(sequence);
    note(path, "exclude", -1, -1); /* of the whole */
    assert_int_equal(ttf_sequence_of_dataset(reader, NULL, &sequence, &err), -ENODATA);
    assert_non_null(strstr(err.what, "exclude all 6"));
    ttf_reader_close(reader);
}

/* Reads of threads that are not the test's own. */
static pthread_t own_thread;
static atomic_uint of_others;

static int64_t count_others(struct ttf_io *io, int file, void *buf, size_t n, int64_t offset)
{
    if (!pthread_equal(pthread_self(), own_thread))
        atomic_fetch_add(&of_others, 1);
    return ttf_io_posix()->ops->pread(io, file, buf, n, offset);
}

/* A process of limited address space says 1: malloc keeps some for each thread that there was. */
static void records_are_parsed_by_as_many_threads_as_is_said(void **state)
{
    const char *path = floats(state, 200);
    struct ttf_io_ops ops = *ttf_io_posix()->ops;
    struct ttf_io io = {.ops = &ops};
    struct ttf_reader *reader;

    own_thread = pthread_self();
    ops.pread = count_others;
    assert_int_equal(ttf_reader_open(&io, path, &reader, NULL), 0);
    for (unsigned threads = 1; threads <= 4; threads++) {
        struct ttf_sequence *sequence =
            chosen(reader, (struct ttf_sequence_choice){.threads = threads});

        if (threads == 1)
            assert_int_equal(atomic_load(&of_others), 0);
        assert_int_equal(sequence->n, 200);
        for (uint32_t t = 0; t < 200; t++)
            assert_int_equal(sequence->index[t], 2 * t);
        ttf_sequence_destroy(sequence);
    }
    ttf_reader_close(reader);
}

static void an_export_fills_excluded_slots_and_names_them(void **state)
{
    const char *path = bracketed(state, 4);
    struct ttf_reader *reader = open_reader(path);
    struct ttf_export_config config = {.kind = TTF_EXPORT_NPY, .output = in_folder(state, "a.npy")};
    struct ttf_export_result result;
    struct ttf_sequence *sequence;
    uint8_t *sidecar;
    size_t n;

    note(path, "exclude", 2, 2);
    sequence = chosen(reader, (struct ttf_sequence_choice){0});
    assert_int_equal(ttf_export(sequence, ttf_io_posix(), &config, &result, NULL), 0);
    assert_int_equal(result.frames, 4);
    assert_int_equal(result.invented, 1);
    sidecar = slurp(in_folder(state, "a.npy.json"), &n);
    assert_non_null(memmem(sidecar, n, "\"excluded_slots\": [\n    2\n  ]", 29));
    free(sidecar);
    ttf_sequence_destroy(sequence);
    ttf_reader_close(reader);
}

static void floats_are_spread_over_sixteen_bits_and_read_back_as_values(void **state)
{
    struct ttf_reader *reader = open_reader(floats(state, 3));
    struct ttf_sequence *sequence = chosen(reader, (struct ttf_sequence_choice){0});
    const double greatest = 2 + 0.5 * (W - 1) + 1000.0 * (H - 1);
    uint16_t row[W * 3];
    float values[W * 3];

    assert_int_equal(ttf_sequence_read_rows(sequence, 0, 0, 1, row, NULL), 0);
    assert_int_equal(row[0], 0);
    assert_int_equal(row[3 * 3], 0); /* no number */
    assert_int_equal(ttf_sequence_read_rows(sequence, 2, H - 1, 1, row, NULL), 0);
    assert_int_equal(row[W * 3 - 1], 65535);
    for (uint32_t i = 0; i < W * 3; i++) {
        double value = (row[i] - sequence->encoding.pedestal) / sequence->encoding.scale;

        assert_true(fabs(value - (2 + 0.5 * floor(i / 3.0) + 1000.0 * (H - 1))) <=
                    greatest / 65535);
    }
    assert_int_equal(ttf_sequence_read_values(sequence, 2, 7, 1, values, NULL), 0);
    for (uint32_t i = 0; i < W * 3; i++)
        assert_true(values[i] == 2 + 0.5f * floorf((float)i / 3) + 7000.0f);
    assert_int_equal(ttf_sequence_read_values(sequence, 3, 7, 1, values, NULL), -EINVAL);
    ttf_sequence_destroy(sequence);
    ttf_reader_close(reader);
}

static void a_stream_that_never_changes_has_a_range_too(void **state)
{
    const char *path = in_folder(state, "flat");
    struct ttf_manifest manifest;
    struct ttf_sequence *sequence;
    struct ttf_writer *writer;
    struct ttf_reader *reader;
    struct ttf_pixbuf flat;
    uint16_t row[W * 3];

    assert_int_equal(ttf_manifest_init(&manifest, NULL), 0);
    add_stream(&manifest, "age", 3, TTF_SAMPLE_F16);
    writer = create(path, &manifest);
    add_segment(writer, 0, 0, TTF_NS_UNKNOWN);
    assert_int_equal(ttf_pixbuf_alloc(&flat, W, H, 3, TTF_SAMPLE_F32), 0);
    for (size_t i = 0; i < (size_t)W * H * 3; i++)
        ((float *)flat.data)[i] = -7.5f;
    add_slot(writer, 0, 0, TTF_NS_PER_H, &(struct shot){"age", -1, 0, &flat}, 1);
    ttf_writer_close(writer);
    reader = open_reader(path);
    /* The file is f32 where its stream says f16: values are what counts. */
    sequence = chosen(reader, (struct ttf_sequence_choice){0});
    assert_int_equal(ttf_sequence_read_rows(sequence, 0, 9, 1, row, NULL), 0);
    for (uint32_t i = 0; i < W * 3; i++)
        assert_true((row[i] - sequence->encoding.pedestal) / sequence->encoding.scale == -7.5);
    ttf_sequence_destroy(sequence);
    ttf_reader_close(reader);
    ttf_pixbuf_free(&flat);
}

static void arrays_and_tiffs_of_floats_hold_the_values(void **state)
{
    struct ttf_reader *reader = open_reader(floats(state, 2));
    struct ttf_sequence *sequence = chosen(reader, (struct ttf_sequence_choice){0});
    struct ttf_export_config config = {
        .kind = TTF_EXPORT_NPY, .output = in_folder(state, "a.npy"), .gaps = TTF_GAPS_INTERPOLATE};
    struct ttf_pixbuf read = {0};
    size_t n, header, frame = (size_t)W * H * 3;
    const float *values;
    uint8_t *data;

    assert_int_equal(ttf_export(sequence, ttf_io_posix(), &config, NULL, NULL), 0);
    data = slurp(in_folder(state, "a.npy"), &n);
    header = 10 + ((size_t)data[8] | (size_t)data[9] << 8);
    assert_non_null(memmem(data, header, "'<f4'", 5));
    assert_int_equal(n - header, 3 * frame * sizeof(float));
    values = (const float *)(const void *)(data + header);
    assert_true(values[frame - 1] == 0.5f * (W - 1) + 1000.0f * (H - 1));
    assert_true(values[2 * frame - 1] == 0.5f + values[frame - 1]); /* between slots 0 and 2 */
    assert_true(values[3 * frame - 1] == 1.0f + values[frame - 1]);
    free(data);
    config.kind = TTF_EXPORT_TIFF;
    config.output = in_folder(state, "tiffs");
    assert_int_equal(ttf_export(sequence, ttf_io_posix(), &config, NULL, NULL), 0);
    assert_int_equal(ttf_image_read(ttf_io_posix(), in_folder(state, "tiffs/frame.1003.tif"), 0,
                                    &read, NULL, NULL),
                     0);
    assert_int_equal(read.format, TTF_SAMPLE_F32);
    assert_true(((float *)ttf_pixbuf_row(&read, 2))[0] == 2001.0f);
    ttf_pixbuf_free(&read);
    ttf_sequence_destroy(sequence);
    ttf_reader_close(reader);
}

/* A normal's number goes below 0: black is the least, white the greatest, though both are near a picture's. */
static void floats_are_shown_from_the_least_to_the_greatest(void **state)
{
    const char *path = in_folder(state, "normals");
    struct ttf_export_config config = {.kind = TTF_EXPORT_PNG, .output = in_folder(state, "shown")};
    struct ttf_sequence *sequence;
    struct ttf_manifest manifest;
    struct ttf_writer *writer;
    struct ttf_reader *reader;
    struct ttf_pixbuf normal, shown = {0};

    assert_int_equal(ttf_manifest_init(&manifest, NULL), 0);
    add_stream(&manifest, "normal", 1, TTF_SAMPLE_F32);
    writer = create(path, &manifest);
    add_segment(writer, 0, 0, TTF_NS_UNKNOWN);
    assert_int_equal(ttf_pixbuf_alloc(&normal, W, H, 1, TTF_SAMPLE_F32), 0);
    for (size_t i = 0; i < (size_t)W * H; i++)
        ((float *)normal.data)[i] = (float)(i % 3) * 2 - 2;
    add_slot(writer, 0, 0, TTF_NS_PER_H, &(struct shot){"normal", -1, 0, &normal}, 1);
    ttf_writer_close(writer);
    reader = open_reader(path);
    sequence = chosen(reader, (struct ttf_sequence_choice){0});
    assert_int_equal(ttf_export(sequence, ttf_io_posix(), &config, NULL, NULL), 0);
    assert_int_equal(ttf_image_read(ttf_io_posix(), in_folder(state, "shown/frame.1001.png"), 0,
                                    &shown, NULL, NULL),
                     0);
    for (unsigned i = 0; i < 3; i++) {
        static const unsigned wanted[] = {0, 188, 255}; /* of light: none, half, all */

        assert_int_equal(shown.format == TTF_SAMPLE_U8
                             ? ((uint8_t *)shown.data)[3 * i]
                             : (((uint16_t *)shown.data)[3 * i] + 128) / 257,
                         wanted[i]);
    }
    ttf_pixbuf_free(&shown);
    ttf_pixbuf_free(&normal);
    ttf_sequence_destroy(sequence);
    ttf_reader_close(reader);
}

struct seen {
    unsigned notes, wrong;
    int64_t wrong_line;
    struct ttf_note last;
};

static void see_note(void *ctx, const struct ttf_note *note)
{
    struct seen *seen = ctx;

    seen->notes++;
    seen->last = *note;
}

static void see_wrong(void *ctx, int64_t line, const char *what)
{
    struct seen *seen = ctx;

    seen->wrong++;
    seen->wrong_line = line;
    assert_true(what[0] != '\0');
}

static void notes_are_read_and_what_no_one_understands_is_told(void **state)
{
    static const char text[] =
        "{\"text\":\"mould\",\"slots\":[[3,5],[9,9]],\"tags\":[\"mine\",\"exclude\"],"
        "\"author\":\"K\",\"utc_ns\":12,\"mood\":\"fine\"}\n"
        "{\"slots\":[3]}\n"
        "{\"text\":\"torn";
    const char *path = bracketed(state, 1);
    struct seen seen = {0};
    const struct ttf_note_visitor visitor = {see_note, see_wrong, &seen};
    struct ttf_verify_report report;
    bool told = false;

    write_bytes(in_folder(state, "data/notes.jsonl"), text, sizeof(text) - 1);
    assert_int_equal(ttf_notes_read(ttf_io_posix(), path, &visitor, NULL), 0);
    assert_int_equal(seen.notes, 1);
    assert_string_equal(seen.last.text, "mould");
    assert_string_equal(seen.last.author, "K");
    assert_true(seen.last.utc_ns == 12);
    assert_true(ttf_note_has_tag(&seen.last, "exclude"));
    assert_true(ttf_note_is_of(&seen.last, 9) && ttf_note_is_of(&seen.last, 4));
    assert_false(ttf_note_is_of(&seen.last, 6));
    assert_int_equal(seen.wrong, 1);
    assert_int_equal(seen.wrong_line, 2);
    assert_int_equal(
        ttf_verify(ttf_io_posix(), path, &(struct ttf_verify_options){0}, &report, NULL), 0);
    for (unsigned i = 0; i < report.n_findings; i++) {
        assert_int_not_equal(report.findings[i].severity, TTF_FINDING_DAMAGE);
        told = told || strcmp(report.findings[i].file, "notes.jsonl:2") == 0;
    }
    assert_true(told);
    ttf_verify_report_free(&report);
}

/* Each alone in its file: a good note, and a line that nobody can use. */
static void a_note_that_says_nothing_sure_is_told_and_excludes_nothing(void **state)
{
    static const char *const bad[] = {"7",
                                      "[]",
                                      "{\"slots\":[[1,2,3]],\"tags\":[\"exclude\"]}",
                                      "{\"slots\":[[1,\"2\"]]}",
                                      "{\"slots\":[[1.5,2]]}",
                                      "{\"slots\":[3]}",
                                      "{\"slots\":[[5,3]],\"tags\":[\"exclude\"]}",
                                      "{\"slots\":[[-1,3]],\"tags\":[\"exclude\"]}",
                                      "{\"slots\":7}",
                                      "{\"tags\":[7]}",
                                      "{\"tags\":\"exclude\"}"};
    const char *path = bracketed(state, 1);

    for (unsigned i = 0; i < sizeof(bad) / sizeof(*bad); i++) {
        struct seen seen = {0};
        const struct ttf_note_visitor visitor = {see_note, see_wrong, &seen};
        char text[256];

        snprintf(text, sizeof(text), "%s\n{\"text\":\"good\"}\n", bad[i]);
        write_bytes(in_folder(state, "data/notes.jsonl"), text, strlen(text));
        assert_int_equal(ttf_notes_read(ttf_io_posix(), path, &visitor, NULL), 0);
        if (seen.wrong != 1 || seen.wrong_line != 1 || seen.notes != 1)
            fail_msg("%s: %u wrong, %u notes", bad[i], seen.wrong, seen.notes);
        assert_string_equal(seen.last.text, "good");
    }
}

static void a_note_of_more_than_a_note_holds_is_told(void **state)
{
    const char *path = bracketed(state, 1);

    for (unsigned tags = 0; tags <= 1; tags++) {
        struct seen seen = {0};
        const struct ttf_note_visitor visitor = {see_note, see_wrong, &seen};
        unsigned n = tags ? TTF_NOTE_TAGS_MAX : TTF_NOTE_SLOTS_MAX;
        const char *one = tags ? "\"mine\"" : "[1,2]";
        size_t size = 64 + (size_t)(n + 1) * (strlen(one) + 1);
        char *text = malloc(size);
        size_t used;

        if (!text)
            fail_msg("no memory");
        used = (size_t)snprintf(text, size, "{\"%s\":[%s", tags ? "tags" : "slots", one);
        for (unsigned i = 0; i < n; i++) /* one more than fits */
            used += (size_t)snprintf(text + used, size - used, ",%s", one);
        (void)snprintf(text + used, size - used, "]}\n");
        write_bytes(in_folder(state, "data/notes.jsonl"), text, strlen(text));
        free(text);
        assert_int_equal(ttf_notes_read(ttf_io_posix(), path, &visitor, NULL), 0);
        assert_true(seen.wrong == 1 && seen.notes == 0);
    }
}

static void samples_are_read_or_refused_by_what_is_wrong(void **state)
{
    static const char good[] =
        "{\"samples\":[{\"id\":\"a\",\"title\":\"Lolium\",\"region\":{\"x\":1,"
        "\"y\":2,\"width\":3,\"height\":4},\"treatment\":\"dry\"}]}";
    static const char *const bad[] = {"{}", "{\"samples\":[{\"id\":\"a\"}]}", "[",
                                      "{\"samples\":[{\"id\":\"a\",\"region\":{\"x\":1,\"y\":2,"
                                      "\"width\":0,\"height\":4}}]}"};
    const char *path = bracketed(state, 1);
    struct ttf_sample_region *regions;
    struct ttf_err err = {0};
    unsigned n;

    assert_int_equal(ttf_samples_read(ttf_io_posix(), path, &regions, &n, NULL), 0);
    assert_int_equal(n, 0);
    write_bytes(in_folder(state, "data/samples.json"), good, sizeof(good) - 1);
    assert_int_equal(ttf_samples_read(ttf_io_posix(), path, &regions, &n, NULL), 0);
    assert_int_equal(n, 1);
    assert_string_equal(regions[0].title, "Lolium");
    assert_string_equal(regions[0].treatment, "dry");
    assert_int_equal(regions[0].region.height, 4);
    free(regions);
    for (unsigned i = 0; i < sizeof(bad) / sizeof(*bad); i++) {
        write_bytes(in_folder(state, "data/samples.json"), bad[i], strlen(bad[i]));
        assert_int_equal(ttf_samples_read(ttf_io_posix(), path, &regions, &n, &err), -EINVAL);
        assert_null(regions);
    }
    assert_non_null(strstr(err.what, "samples[0].region.width"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
#define IN_FOLDER(f) cmocka_unit_test_setup_teardown(f, folder_setup, folder_teardown)
        IN_FOLDER(a_bracket_of_ones_choice_is_read),
        IN_FOLDER(what_lies_beside_an_image_is_read_by_its_role),
        IN_FOLDER(no_uncertainty_is_no_developed_image),
        IN_FOLDER(what_a_note_excludes_is_left_out_unless_asked_for),
        IN_FOLDER(records_are_parsed_by_as_many_threads_as_is_said),
        IN_FOLDER(an_export_fills_excluded_slots_and_names_them),
        IN_FOLDER(floats_are_spread_over_sixteen_bits_and_read_back_as_values),
        IN_FOLDER(a_stream_that_never_changes_has_a_range_too),
        IN_FOLDER(floats_are_shown_from_the_least_to_the_greatest),
        IN_FOLDER(arrays_and_tiffs_of_floats_hold_the_values),
        IN_FOLDER(notes_are_read_and_what_no_one_understands_is_told),
        IN_FOLDER(a_note_that_says_nothing_sure_is_told_and_excludes_nothing),
        IN_FOLDER(a_note_of_more_than_a_note_holds_is_told),
        IN_FOLDER(samples_are_read_or_refused_by_what_is_wrong),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
