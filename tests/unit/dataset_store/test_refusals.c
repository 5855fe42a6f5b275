/* SPDX-License-Identifier: Apache-2.0 */
/* What no dataset may hold is refused before a byte of it is written, and says which field it is. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "io_hashing.h"
#include "store_test.h"
#include "ttf/dataset/hash.h"
#include "ttf/dataset/json_parse.h"
#include "ttf/dataset/json_writer.h"
#include "ttf/dataset/notes.h"
#include "ttf/dataset/reader.h"
#include "ttf/dataset/samples.h"

/* ---- records ---- */

static void whole_record(struct ttf_slot_record *record)
{
    struct ttf_image *image;

    ttf_slot_record_init(record);
    assert_int_equal(ttf_slot_record_images(record, 1), 0);
    image = &record->images[0];
    strcpy(image->stream, "main");
    image->n_averaged = 1;
    image->n_files = 1;
    strcpy(image->files[0].role, "developed");
    strcpy(image->files[0].path, "frames/main/000000.tif");
    memset(image->files[0].sha256, 'a', 64);
    assert_int_equal(ttf_image_shots(image, 1), 0);
}

static void no_stream(struct ttf_slot_record *r)
{
    r->images[0].stream[0] = '\0';
}

static void too_many_files(struct ttf_slot_record *r)
{
    r->images[0].n_files = TTF_IMAGE_FILES_MAX + 1;
}

static void no_role(struct ttf_slot_record *r)
{
    r->images[0].files[0].role[0] = '\0';
}

static void outside(struct ttf_slot_record *r)
{
    strcpy(r->images[0].files[0].path, "../x.tif");
}

static void negative_bytes(struct ttf_slot_record *r)
{
    r->images[0].files[0].bytes = -1;
}

static void no_hash(struct ttf_slot_record *r)
{
    r->images[0].files[0].sha256[63] = 'g';
}

static void too_many_lamps(struct ttf_slot_record *r)
{
    r->images[0].shots[0].n_lamps = TTF_SHOT_LAMPS_MAX + 1;
}

static void infinite_level(struct ttf_slot_record *r)
{
    r->images[0].mean_level = INFINITY;
}

static void infinite_reference(struct ttf_slot_record *r)
{
    r->images[0].reference_level = -INFINITY;
}

static void infinite_sharpness(struct ttf_slot_record *r)
{
    r->images[0].sharpness = INFINITY;
}

static void no_exposure(struct ttf_slot_record *r)
{
    r->images[0].relative_exposure = NAN;
}

static void neither_file_nor_reason(struct ttf_slot_record *r)
{
    r->images[0].n_files = 0;
}

static void captured_and_lacking(struct ttf_slot_record *r)
{
    strcpy(r->images[0].lacking, "no frame");
}

static void negative_index(struct ttf_slot_record *r)
{
    r->index = -1;
}

static void negative_segment(struct ttf_slot_record *r)
{
    r->segment = -1;
}

static void unknown_result(struct ttf_slot_record *r)
{
    r->result = TTF_RESULT_COUNT;
}

static void no_reason(struct ttf_slot_record *r)
{
    r->result = TTF_RESULT_MISSED;
}

static void too_many_sensors(struct ttf_slot_record *r)
{
    r->n_sensors = TTF_SLOT_SENSORS_MAX + 1;
}

static void last_index_of_all(struct ttf_slot_record *r)
{
    r->index = INT64_MAX;
}

static void segment_without_a_line(struct ttf_slot_record *r)
{
    r->segment = 1;
}

static void a_record_that_cannot_be_is_refused_by_field(void **state)
{
    static const struct {
        void (*spoil)(struct ttf_slot_record *record);
        const char *says;
    } cases[] = {
        {no_stream, "stream is missing"},
        {too_many_files, "too many files"},
        {no_role, "needs a role"},
        {outside, "path inside the dataset"},
        {negative_bytes, "its bytes"},
        {no_hash, "sha256"},
        {too_many_lamps, "too many lamps"},
        {infinite_level, "infinite level"},
        {infinite_reference, "infinite level"},
        {infinite_sharpness, "infinite level"},
        {no_exposure, "infinite level"},
        {neither_file_nor_reason, "does not say why"},
        {captured_and_lacking, "partial, not captured"},
        {negative_index, "0 or more"},
        {negative_segment, "0 or more"},
        {unknown_result, "result is unknown"},
        {no_reason, "needs a reason"},
        {too_many_sensors, "too many sensors"},
        {last_index_of_all, "is the next one"},
        {segment_without_a_line, "has no line yet"},
    };
    struct ttf_writer *writer = small_create(ttf_io_posix(), in(*state, "d"));
    int64_t before = size_of(in(*state, "d/records.jsonl"));
    struct ttf_slot_record record;

    for (unsigned i = 0; i < TTF_COUNT_OF(cases); i++) {
        struct ttf_err err = {0};

        whole_record(&record);
        cases[i].spoil(&record);
        assert_int_equal(ttf_writer_commit(writer, &record, &err), -EINVAL);
        if (!strstr(err.what, cases[i].says))
            fail_msg("'%s' does not say '%s'", err.what, cases[i].says);
        ttf_slot_record_free(&record);
    }
    assert_int_equal(size_of(in(*state, "d/records.jsonl")), before);
    whole_record(&record);
    assert_int_equal(ttf_writer_commit(writer, &record, NULL), 0);
    ttf_slot_record_free(&record);
    ttf_writer_close(writer);
}

static void a_segment_that_cannot_be_is_refused_by_field(void **state)
{
    struct ttf_writer *writer = small_create(ttf_io_posix(), in(*state, "d"));
    const struct ttf_segment good = ttf_writer_state(writer)->last_segment;
    const struct {
        int64_t first_index, interval_ns, gap_ns;
        int segment, plan;
        bool corrects;
        const char *trust, *says;
    } cases[] = {
        {0, 1, 0, 1, 0, false, "gps", "trust must be"},
        {0, 1, 0, -1, 0, true, "rtc", "0 or more"},
        {-1, 1, 0, 1, 0, false, "rtc", "0 or more"},
        {0, -1, 0, 1, 0, false, "rtc", "0 or more"},
        {0, 1, -5, 1, 0, false, "rtc", "gap_ns must be"},
        {0, 1, 0, 2, 0, false, "rtc", "is the next new one"},
        {0, 1, 0, 1, 0, true, "rtc", "(a correction)"},
        {0, 1, 0, 0, 0, false, "rtc", "is the next new one"},
        {0, 1, 0, 1, 7, false, "rtc", "but there are 1 plans"},
    };

    for (unsigned i = 0; i < TTF_COUNT_OF(cases); i++) {
        struct ttf_segment s = good;
        struct ttf_err err = {0};

        s.first_index = cases[i].first_index;
        s.interval_ns = cases[i].interval_ns;
        s.gap_ns = cases[i].gap_ns;
        s.segment = cases[i].segment;
        s.plan = cases[i].plan;
        s.corrects = cases[i].corrects;
        snprintf(s.trust, sizeof(s.trust), "%s", cases[i].trust);
        assert_int_equal(ttf_writer_segment(writer, &s, &err), -EINVAL);
        if (!strstr(err.what, cases[i].says))
            fail_msg("case %u: '%s' does not say '%s'", i, err.what, cases[i].says);
    }
    assert_int_equal(ttf_writer_state(writer)->n_segments, 1);
    ttf_writer_close(writer);
}

static int produce_nothing(void *ctx, struct ttf_io *io, int file, struct ttf_err *err)
{
    return 0;
}

static void names_that_are_none_are_refused(void **state)
{
    struct ttf_io *io = ttf_io_posix();
    struct ttf_writer *writer = small_create(io, in(*state, "d")), *other = NULL;
    struct ttf_manifest manifest;
    struct ttf_file_ref file;

    assert_int_equal(ttf_writer_calibration(writer, "../x", *state, NULL), -EINVAL);
    assert_int_equal(ttf_writer_calibration(writer, "", *state, NULL), -EINVAL);
    assert_int_equal(ttf_writer_plan(writer, NULL, NULL, NULL), -EINVAL);
    assert_int_equal(ttf_writer_file(writer, "developed", "../main", 0, -1, "tif", produce_nothing,
                                     NULL, &file, NULL),
                     -EINVAL);
    assert_int_equal(ttf_writer_file(writer, "deve loped", "main", 0, -1, "tif", produce_nothing,
                                     NULL, &file, NULL),
                     -EINVAL);
    assert_int_equal(ttf_writer_file(writer, "a-role-of-more-letters-than-a-record-has-room-for",
                                     "main", 0, -1, "tif", produce_nothing, NULL, &file, NULL),
                     -EINVAL);
    assert_int_equal(ttf_writer_file(writer, "developed", "main", -1, -1, "tif", produce_nothing,
                                     NULL, &file, NULL),
                     -EINVAL);
    assert_int_equal(ttf_writer_file(writer, "developed", "main", 0, -1, "t/if", produce_nothing,
                                     NULL, &file, NULL),
                     -EINVAL);
    ttf_writer_close(writer);
    small_manifest(&manifest);
    assert_int_equal(
        ttf_writer_create(io, in(*state, "a b"), &manifest, NULL, "{}\n", &other, NULL), -EINVAL);
    assert_null(other);
    assert_false(exists(in(*state, "a b")));
    /* Nor is a file a folder for one. */
    write_text(in(*state, "file"), "x", 1);
    assert_int_equal(
        ttf_writer_create(io, in(*state, "file"), &manifest, NULL, "{}\n", &other, NULL), -EEXIST);
    assert_int_equal(size_of(in(*state, "file")), 1);
}

/* As a shell completes it. */
static void a_path_that_ends_in_slashes_is_that_folder(void **state)
{
    struct ttf_io *io = ttf_io_posix();
    struct ttf_writer *writer = small_create(io, in(*state, "d//"));

    assert_int_equal(small_slot(writer, 0), 0);
    ttf_writer_close(writer);
    assert_true(exists(in(*state, "d/records.jsonl")));
    assert_int_equal(small_check(io, in(*state, "d")), 1);
    assert_int_equal(ttf_writer_open(io, in(*state, "d/"), &writer, NULL), 0);
    ttf_writer_close(writer);
}

/* A folder that a person looked into, or put things into, is still that calibration; one without files is none. */
static void of_a_calibration_s_folder_its_files_are_copied(void **state)
{
    struct ttf_io *io = ttf_io_posix();
    struct ttf_writer *writer = small_create(io, in(*state, "d"));
    struct ttf_err err = {0};

    assert_int_equal(run("mkdir -p '%s/cal/folder' '%s/bare/folder' '%s/odd'", (char *)*state,
                         (char *)*state, (char *)*state),
                     0);
    write_text(in(*state, "cal/calibration.json"), "{}", 2);
    write_text(in(*state, "cal/.hidden"), "x", 1);
    write_text(in(*state, "cal/left.tmp"), "x", 1);
    write_text(in(*state, "bare/.hidden"), "x", 1);
    write_text(in(*state, "odd/a b"), "x", 1);
    assert_int_equal(ttf_writer_calibration(writer, "bare", in(*state, "bare"), &err), -ENOENT);
    assert_non_null(strstr(err.what, "is no calibration that can be copied"));
    ttf_writer_close(writer);
    writer = NULL;
    assert_int_equal(ttf_writer_open(io, in(*state, "d"), &writer, NULL), 0);
    assert_int_equal(ttf_writer_calibration(writer, "odd", in(*state, "odd"), &err), -EILSEQ);
    ttf_writer_close(writer);
    writer = NULL;
    assert_int_equal(ttf_writer_open(io, in(*state, "d"), &writer, NULL), 0);
    assert_int_equal(ttf_writer_calibration(writer, "cal", in(*state, "cal"), &err), 0);
    ttf_writer_close(writer);
    assert_true(exists(in(*state, "d/calibration/cal/calibration.json")));
    assert_false(exists(in(*state, "d/calibration/cal/.hidden")));
    assert_false(exists(in(*state, "d/calibration/cal/left.tmp")));
    assert_false(exists(in(*state, "d/calibration/cal/folder")));
}

/* ---- what is read ---- */

static void who_asks_for_what_is_not_there_is_told(void **state)
{
    struct ttf_io *io = ttf_io_posix();
    struct ttf_writer *writer = small_create(io, in(*state, "d"));
    struct ttf_slot_record record;
    struct ttf_segment segment;
    struct ttf_reader *reader = NULL;
    char digest[65];

    assert_int_equal(small_slot(writer, 0), 0);
    ttf_writer_close(writer);
    assert_int_equal(ttf_reader_open(io, in(*state, "none"), &reader, NULL), -ENOENT);
    assert_int_equal(ttf_reader_open(io, in(*state, "d"), &reader, NULL), 0);
    assert_int_equal(ttf_reader_slot(reader, -1, &record, NULL), -ENOENT);
    assert_int_equal(ttf_reader_slot(reader, 1, &record, NULL), -ENOENT);
    assert_int_equal(ttf_reader_segment(reader, 1, &segment), -ENOENT);
    assert_int_equal(ttf_reader_segment(reader, -1, &segment), -ENOENT);
    assert_true(ttf_reader_find(reader, 1) == -ENOENT);
    assert_int_equal(ttf_reader_digest(reader, digest, NULL), -ENODATA);
    ttf_slot_record_init(&record);
    record.segment = 1;
    assert_true(ttf_reader_due_utc_ns(reader, &record) == TTF_NS_UNKNOWN);
    record.segment = 0;
    record.due_ns = INT64_MIN; /* no time is so long ago */
    assert_true(ttf_reader_due_utc_ns(reader, &record) == TTF_NS_UNKNOWN);
    ttf_reader_close(reader);
}

static void a_line_that_changes_under_its_reader_is_damage(void **state)
{
    struct ttf_io *io = ttf_io_posix();
    const char *path = in(*state, "d/records.jsonl");
    struct ttf_writer *writer = small_create(io, in(*state, "d"));
    struct ttf_slot_record record;
    struct ttf_reader *reader = NULL;
    struct ttf_err err = {0};
    size_t n;
    char *text, *at;

    assert_int_equal(small_slot(writer, 0), 0);
    ttf_writer_close(writer);
    assert_int_equal(ttf_reader_open(io, in(*state, "d"), &reader, NULL), 0);
    text = file_text(path, &n);
    at = text ? strstr(text, "captured") : NULL;
    assert_non_null(at);
    assert_int_equal(run("printf C | dd of='%s' bs=1 seek=%d conv=notrunc", path, (int)(at - text)),
                     0);
    assert_int_equal(ttf_reader_slot(reader, 0, &record, &err), -TTF_EDAMAGED);
    assert_non_null(strstr(err.what, "changed since it was opened"));
    assert_int_equal(run("truncate -s 10 '%s'", path), 0);
    assert_int_equal(ttf_reader_slot(reader, 0, &record, NULL), -TTF_EDAMAGED);
    free(text);
    ttf_reader_close(reader);
}

/* ---- notes ---- */

static void a_note_that_says_nothing_or_too_much_is_refused(void **state)
{
    struct ttf_io *io = ttf_io_posix();
    struct ttf_note good = {.utc_ns = 1, .text = "a fly", .n_tags = 1, .tags = {"exclude"}}, note;

    note = (struct ttf_note){.utc_ns = 1};
    assert_int_equal(ttf_note_append(io, *state, &note, NULL), -EINVAL);
    note = good;
    note.n_slots = TTF_NOTE_SLOTS_MAX + 1;
    assert_int_equal(ttf_note_append(io, *state, &note, NULL), -EINVAL);
    note = good;
    note.n_tags = TTF_NOTE_TAGS_MAX + 1;
    assert_int_equal(ttf_note_append(io, *state, &note, NULL), -EINVAL);
    note = good;
    note.n_slots = 1;
    note.slots[0][0] = 5;
    note.slots[0][1] = 4;
    assert_int_equal(ttf_note_append(io, *state, &note, NULL), -EINVAL);
    note.slots[0][0] = -1;
    assert_int_equal(ttf_note_append(io, *state, &note, NULL), -EINVAL);
    note = good;
    strcpy(note.tags[0], "two words");
    assert_int_equal(ttf_note_append(io, *state, &note, NULL), -EINVAL);
    note.tags[0][0] = '\0';
    assert_int_equal(ttf_note_append(io, *state, &note, NULL), -EINVAL);
    assert_false(exists(in(*state, "notes.jsonl")));
}

/* ---- JSON ---- */

static void json_that_cannot_be_is_not_written(void **state)
{
    struct ttf_json json;
    const char *text;
    size_t n;

    ttf_json_init(&json, false);
    for (unsigned i = 0; i < 20; i++)
        ttf_json_array(&json);
    assert_true(ttf_json_finish(&json, &text, &n) < 0);
    ttf_json_again(&json, false);
    ttf_json_double(&json, NAN);
    assert_true(ttf_json_finish(&json, &text, &n) < 0);
    ttf_json_again(&json, false);
    ttf_json_double(&json, INFINITY);
    assert_true(ttf_json_finish(&json, &text, &n) < 0);
    ttf_json_again(&json, false);
    ttf_json_array(&json);
    ttf_json_null(&json);
    ttf_json_string(&json, NULL);
    ttf_json_bool(&json, true);
    ttf_json_double(&json, 0.1);
    ttf_json_string(&json, "a\"\\\b\f\n\r\t\x01\x7f\xff\xc3\xa4");
    ttf_json_array_end(&json);
    assert_int_equal(ttf_json_finish(&json, &text, &n), 0);
    assert_int_equal(n, strlen(text));
    assert_true(strncmp(text, "[null,null,true,0.1,\"a\\\"\\\\", 25) == 0);
    assert_non_null(strstr(text, "\xc3\xa4\"]"));
    ttf_json_free(&json);
}

/* A title that a person's editor wrote in another encoding must not make a dataset unreadable. */
static void text_that_is_no_utf8_becomes_text_that_is(void **state)
{
    static const char *const good[] = {"a",
                                       "\xc2\x80",
                                       "\xdf\xbf",
                                       "\xe0\xa0\x80",
                                       "\xed\x9f\xbf",
                                       "\xee\x80\x80",
                                       "\xf0\x90\x80\x80",
                                       "\xf4\x8f\xbf\xbf",
                                       "\xf1\x80\x80\x80"};
    static const char *const bad[] = {"\x80",         "\xc1\xbf",         "\xc2",
                                      "\xc2q",        "\xe0\x9f\xbf",     "\xe1\x80",
                                      "\xed\xa0\x80", "\xf0\x8f\xbf\xbf", "\xf4\x90\x80\x80",
                                      "\xf5\x80",     "\xe1\x80\xc0",     "\xf1\x80\x80\x7f"};
    struct ttf_json json;
    const char *text;
    size_t n;

    ttf_json_init(&json, false);
    for (unsigned i = 0; i < TTF_COUNT_OF(good) + TTF_COUNT_OF(bad); i++) {
        bool whole = i < TTF_COUNT_OF(good);
        const char *value = whole ? good[i] : bad[i - TTF_COUNT_OF(good)];
        json_t *back;

        ttf_json_again(&json, false);
        ttf_json_array(&json);
        ttf_json_string(&json, value);
        ttf_json_array_end(&json);
        assert_int_equal(ttf_json_finish(&json, &text, &n), 0);
        back = json_loadb(text, n, 0, NULL); /* refuses what is no UTF-8 */
        if (!back)
            fail_msg("text %u: %s", i, text);
        if (whole != (strcmp(json_string_value(json_array_get(back, 0)), value) == 0))
            fail_msg("text %u came back as %s", i, text);
        json_decref(back);
    }
    ttf_json_free(&json);
}

static void json_that_could_be_read_in_two_ways_is_none(void **state)
{
    json_error_t where;
    json_t *json = NULL;

    assert_int_equal(ttf_json_parse("{\"a\":1,\"a\":1}", 13, &json, NULL), -EINVAL);
    assert_int_equal(ttf_json_parse("[1,\n2", 5, &json, &where), -EINVAL);
    assert_int_equal(where.line, 2);
    assert_null(json);
    assert_int_equal(ttf_json_parse("[1,2]xx", 5, &json, NULL), 0);
    assert_int_equal(json_array_size(json), 2);
    json_decref(json);
}

/* ---- regions ---- */

static void more_regions_than_anybody_marks_are_refused(void **state)
{
    static const char region[] = "{\"id\":\"a\",\"region\":[0,0,1,1]},";
    struct ttf_writer *writer = small_create(ttf_io_posix(), in(*state, "d"));
    struct ttf_sample_region *regions = NULL;
    struct ttf_err err = {0};
    static const char begin[] = "{\"samples\":[";
    const size_t bytes = sizeof(region) - 1, all = sizeof(begin) - 1 + 4097 * bytes;
    char *text = calloc(1, all + 2);
    unsigned n = 0;

    assert_non_null(text);
    ttf_writer_close(writer);
    memcpy(text, begin, sizeof(begin) - 1);
    for (size_t at = sizeof(begin) - 1; at < all; at += bytes)
        memcpy(text + at, region, bytes);
    text[all - 1] = ']'; /* for the last comma */
    text[all] = '}';
    write_text(in(*state, "d/samples.json"), text, strlen(text));
    free(text);
    assert_int_equal(ttf_samples_read(ttf_io_posix(), in(*state, "d"), &regions, &n, &err),
                     -EINVAL);
    assert_non_null(strstr(err.what, "samples has more than 4096"));
    assert_null(regions);
}

/* ---- the table that fails ---- */

static int refuse_sync_all(void *ctx, const char *op, const char *path)
{
    (void)ctx;
    (void)path;
    return strcmp(op, "sync_all") == 0 ? -EIO : 0;
}

/* Whatever was left open in it is closed with it; the sync of a whole disk fails like anything else. */
static void a_disk_made_to_fail_closes_what_was_left_open(void **state)
{
    struct ttf_io *io = ttf_io_faulty_create(ttf_io_posix(), refuse_sync_all, NULL);
    struct ttf_io *plain = ttf_io_faulty_create(ttf_io_posix(), NULL, NULL);
    int first, second, r;

    assert_true(io && plain);
    first = io->ops->open(io, in(*state, "a"), TTF_IO_CREATE_NEW);
    second = io->ops->open(io, in(*state, "b"), TTF_IO_CREATE_NEW);
    assert_true(first >= 0 && second >= 0);
    assert_int_equal(ttf_io_sync_all(io, first), -EIO);
    ttf_io_faulty_destroy(io);
    assert_int_equal(fcntl(first, F_GETFD), -1);
    assert_int_equal(fcntl(second, F_GETFD), -1);
    first = plain->ops->open(plain, in(*state, "a"), TTF_IO_READ);
    r = ttf_io_sync_all(plain, first);
    assert_true(r == 0 || r == -EOPNOTSUPP); /* as the disk below can */
    ttf_io_faulty_destroy(plain);
    ttf_io_faulty_destroy(NULL);
}

/* ---- the table that hashes ---- */

/* Whoever writes through it may do with it what he may do with the one below. */
static void what_is_done_while_hashing_is_done(void **state)
{
    struct ttf_io *below = ttf_io_posix();
    struct ttf_io_hashing hashing;
    struct ttf_io *io = &hashing.io;
    struct ttf_io_space space;
    struct ttf_io_stat st;
    char text[8] = "", hex[65], whole[65];
    static char piece[TTF_SHA256_PIECE];
    int64_t bytes;
    int file;

    file = below->ops->open(below, in(*state, "f"), TTF_IO_CREATE_NEW);
    assert_true(file >= 0);
    ttf_io_hashing_init(&hashing, below, file);
    assert_int_equal(ttf_io_append_all(io, file, "abcd", 4), 0);
    assert_int_equal(ttf_io_pwrite_all(io, file, "e", 1, 4), 0);
    assert_int_equal(ttf_io_hashing_result(&hashing, piece, &bytes, hex), 0);
    assert_int_equal(bytes, 5);
    assert_int_equal(ttf_sha256_file(below, in(*state, "f"), NULL, whole, NULL), 0);
    assert_string_equal(hex, whole);
    /* Cut: what was hashed is not what is there. */
    assert_int_equal(io->ops->truncate(io, file, 2), 0);
    assert_int_equal(ttf_io_hashing_result(&hashing, piece, &bytes, hex), 0);
    assert_int_equal(bytes, 2);
    assert_string_not_equal(hex, whole);
    assert_int_equal(ttf_io_pread_all(io, file, text, 7, 0), 2);
    assert_string_equal(text, "ab");
    assert_int_equal(io->ops->size(io, file, &bytes), 0);
    assert_int_equal(io->ops->sync(io, file, true), 0);
    assert_int_equal(io->ops->lock(io, file), 0);
    assert_int_equal(io->ops->close(io, file), 0);
    assert_int_equal(io->ops->rename(io, in(*state, "f"), in(*state, "g")), 0);
    assert_true(io->ops->open(io, in(*state, "f"), TTF_IO_READ) == -ENOENT);
    assert_int_equal(io->ops->stat(io, in(*state, "g"), &st), 0);
    assert_int_equal(st.bytes, 2);
    assert_int_equal(io->ops->unlink(io, in(*state, "g")), 0);
    assert_false(exists(in(*state, "g")));
    assert_int_equal(io->ops->mkdir(io, in(*state, "h")), 0);
    assert_int_equal(io->ops->sync_dir(io, in(*state, "h")), 0);
    assert_int_equal(io->ops->space(io, *state, &space), 0);
    assert_true(space.free_bytes > 0);
}

/* ---- the machine's own table ---- */

static int count_entry(void *ctx, const char *name, bool is_dir)
{
    return 0;
}

static void a_file_that_is_not_open_or_not_there_is_told_as_such(void **state)
{
    struct ttf_io *io = ttf_io_posix();
    const char *none = in(*state, "none/at/all");
    struct ttf_io_space space;
    struct ttf_io_stat st;
    int64_t bytes;
    char c = 0;

    assert_true(io->ops->pread(io, -1, &c, 1, 0) == -EBADF);
    assert_true(io->ops->pwrite(io, -1, &c, 1, 0) == -EBADF);
    assert_true(io->ops->append(io, -1, &c, 1) == -EBADF);
    assert_int_equal(io->ops->size(io, -1, &bytes), -EBADF);
    assert_int_equal(io->ops->truncate(io, -1, 0), -EBADF);
    assert_int_equal(io->ops->sync(io, -1, false), -EBADF);
    assert_int_equal(io->ops->sync(io, -1, true), -EBADF);
    assert_int_equal(io->ops->close(io, -1), -EBADF);
    assert_int_equal(io->ops->lock(io, -1), -EBADF);
    assert_int_equal(io->ops->open(io, none, TTF_IO_READ), -ENOENT);
    assert_int_equal(io->ops->open(io, none, TTF_IO_CREATE_NEW), -ENOENT);
    assert_int_equal(io->ops->open(io, none, TTF_IO_APPEND), -ENOENT);
    assert_int_equal(io->ops->open(io, none, (enum ttf_io_mode)9), -EINVAL);
    assert_int_equal(io->ops->rename(io, none, in(*state, "x")), -ENOENT);
    assert_int_equal(io->ops->unlink(io, none), -ENOENT);
    assert_int_equal(io->ops->mkdir(io, none), -ENOENT);
    assert_int_equal(io->ops->mkdir(io, *state), -EEXIST);
    assert_int_equal(io->ops->sync_dir(io, none), -ENOENT);
    assert_int_equal(io->ops->stat(io, none, &st), -ENOENT);
    assert_int_equal(io->ops->list(io, none, count_entry, NULL), -ENOENT);
    assert_int_equal(io->ops->space(io, none, &space), -ENOENT);
}

#define T(test) cmocka_unit_test_setup_teardown(test, folder_setup, folder_teardown)

int main(void)
{
    const struct CMUnitTest tests[] = {
        T(a_record_that_cannot_be_is_refused_by_field),
        T(a_segment_that_cannot_be_is_refused_by_field),
        T(names_that_are_none_are_refused),
        T(a_path_that_ends_in_slashes_is_that_folder),
        T(of_a_calibration_s_folder_its_files_are_copied),
        T(who_asks_for_what_is_not_there_is_told),
        T(a_line_that_changes_under_its_reader_is_damage),
        T(a_note_that_says_nothing_or_too_much_is_refused),
        T(json_that_cannot_be_is_not_written),
        T(json_that_could_be_read_in_two_ways_is_none),
        T(text_that_is_no_utf8_becomes_text_that_is),
        T(more_regions_than_anybody_marks_are_refused),
        T(a_disk_made_to_fail_closes_what_was_left_open),
        T(what_is_done_while_hashing_is_done),
        T(a_file_that_is_not_open_or_not_there_is_told_as_such),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
