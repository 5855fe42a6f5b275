/* SPDX-License-Identifier: Apache-2.0 */
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
#include <sys/stat.h>

#include "store_test.h"
#include "ttf/dataset/hash.h"
#include "ttf/dataset/reader.h"

static void what_is_written_is_read_back(void **state)
{
    struct ttf_io *io = ttf_io_posix();
    const char *path = in(*state, "grass-1");
    struct ttf_writer *writer = small_create(io, path);
    const struct ttf_reader_summary *sum;
    struct ttf_reader *reader;
    struct ttf_err err = {0};
    char digest[65], again[65];
    int64_t i;

    assert_non_null(writer);
    for (i = 0; i < 5; i++)
        assert_int_equal(small_slot(writer, i), 0);
    assert_int_equal(sha256sum_check(path), 0);
    assert_int_equal(ttf_writer_state(writer)->next_index, 5);
    assert_int_equal(ttf_writer_seal(writer, "count", digest, &err), 0);
    ttf_writer_close(writer);
    assert_int_equal(sha256sum_check(path), 0);
    assert_int_equal(small_check(io, path), 5);

    assert_int_equal(ttf_reader_open(io, path, &reader, &err), 0);
    sum = ttf_reader_summary(reader);
    assert_true(sum->sealed && sum->ended && !sum->unterminated);
    assert_int_equal(sum->slots, 5);
    assert_int_equal(sum->counts[TTF_RESULT_CAPTURED], 5);
    assert_int_equal(sum->n_plans, 1);
    assert_int_equal(ttf_reader_digest(reader, again, &err), 0);
    assert_string_equal(digest, again);
    ttf_reader_close(reader);
}

static void a_record_in_a_folder_that_was_removed_is_not_acknowledged(void **state)
{
    struct ttf_io *io = ttf_io_posix();
    char away[256];
    const char *path = in(*state, "grass-1");
    struct ttf_writer *writer = small_create(io, path);

    assert_int_equal(small_slot(writer, 0), 0);
    (void)snprintf(away, sizeof away, "%s.away", path);
    assert_int_equal(rename(path, away),
                     0); /* as a disk that was unmounted while files of it are open */
    assert_int_equal(small_slot(writer, 1), -EIO);
    assert_int_equal(ttf_writer_event(writer, "door", 1, 2, "opened", NULL, NULL), -EIO);
    ttf_writer_close(writer);
    (void)rename(path, in(*state, "left")); /* what was made there since */
    assert_int_equal(rename(away, path), 0);
    assert_int_equal(ttf_writer_open(io, path, &writer, NULL), 0);
    assert_int_equal(ttf_writer_state(writer)->next_index, 1);
    ttf_writer_close(writer);
    assert_int_equal(small_check(io, path), 1);
}

/* With a key twice the line could be read in two ways: its readers call that damage. */
static void an_event_whose_detail_its_readers_would_refuse_is_refused(void **state)
{
    static const char *const wrong[] = {"{\"a\":1,\"a\":2}", "[1]", "{\"a\":", "7", ""};
    struct ttf_io *io = ttf_io_posix();
    const char *path = in(*state, "grass-1");
    struct ttf_writer *writer = small_create(io, path);

    for (unsigned i = 0; i < TTF_COUNT_OF(wrong); i++)
        assert_int_equal(ttf_writer_event(writer, "door", 1, 2, "opened", wrong[i], NULL), -EINVAL);
    assert_int_equal(ttf_writer_event(writer, "door", 1, 2, "opened", "{\"a\":\n1}", NULL), 0);
    ttf_writer_close(writer);
    assert_int_equal(ttf_writer_open(io, path, &writer, NULL), 0);
    ttf_writer_close(writer);
    assert_int_equal(small_check(io, path), 0);
}

/* Completes its first bytes last, as TIFF writers do. */
static int produce_backwards(void *ctx, struct ttf_io *io, int file, struct ttf_err *err)
{
    int r = ttf_io_pwrite_all(io, file, "rest", 4, 4);

    return r ? r : ttf_io_pwrite_all(io, file, "head", 4, 0);
}

static void a_file_written_back_and_forth_has_its_right_hash(void **state)
{
    const char *path = in(*state, "d");
    struct ttf_writer *writer = small_create(ttf_io_posix(), path);
    struct ttf_file_ref ref;
    char hex[65];

    assert_int_equal(ttf_writer_file(writer, "mask", "main", 1000000, 2, "tif", produce_backwards,
                                     NULL, &ref, NULL),
                     0);
    assert_string_equal(ref.path, "frames/main/1000000.b2.mask.tif");
    assert_int_equal(ref.bytes, 8);
    assert_int_equal(ttf_sha256_file(ttf_io_posix(), in(path, "%s", ref.path), NULL, hex, NULL), 0);
    assert_string_equal(ref.sha256, hex);
    ttf_writer_close(writer);
}

/* Fails without a word of its own. */
static int produce_no_room(void *ctx, struct ttf_io *io, int file, struct ttf_err *err)
{
    (void)ctx, (void)io, (void)file, (void)err;
    return -ENOSPC;
}

static void the_error_told_is_the_one_that_is_returned(void **state)
{
    struct ttf_writer *writer = small_create(ttf_io_posix(), in(*state, "d"));
    struct ttf_file_ref ref;
    struct ttf_err err = {0};

    (void)ttf_err_set(&err, -EIO, "elsewhere", "what a call before met");
    assert_int_equal(
        ttf_writer_file(writer, "mask", "main", 0, -1, "tif", produce_no_room, NULL, &ref, &err),
        -ENOSPC);
    assert_int_equal(err.code, -ENOSPC);
    assert_non_null(strstr(err.what, "No space left"));
    ttf_writer_close(writer);
}

static void a_name_that_is_no_name_is_refused(void **state)
{
    struct ttf_manifest manifest;
    struct ttf_writer *writer;
    struct ttf_err err = {0};

    small_manifest(&manifest);
    assert_int_equal(ttf_writer_create(ttf_io_posix(), in(*state, "gr√ss"), &manifest, NULL, NULL,
                                       &writer, &err),
                     -EINVAL);
    assert_int_equal(
        ttf_writer_create(ttf_io_posix(), in(*state, "a b"), &manifest, NULL, NULL, &writer, &err),
        -EINVAL);
}

static void an_existing_dataset_is_not_written_over(void **state)
{
    const char *path = in(*state, "d");
    struct ttf_writer *writer = small_create(ttf_io_posix(), path), *second;
    struct ttf_manifest manifest;
    struct ttf_err err = {0};

    assert_non_null(writer);
    small_manifest(&manifest);
    assert_int_equal(ttf_writer_create(ttf_io_posix(), path, &manifest, NULL, NULL, &second, &err),
                     -EEXIST);
    ttf_writer_close(writer);
    assert_int_equal(mkdir(in(*state, "full"), 0777), 0);
    write_text(in(*state, "full/thesis.txt"), "x", 1);
    assert_int_equal(
        ttf_writer_create(ttf_io_posix(), in(*state, "full"), &manifest, NULL, NULL, &second, &err),
        -EEXIST);
}

static void two_writers_at_once_are_kept_apart(void **state)
{
    const char *path = in(*state, "d");
    struct ttf_writer *writer = small_create(ttf_io_posix(), path), *second;
    struct ttf_err err = {0};

    assert_int_equal(ttf_writer_open(ttf_io_posix(), path, &second, &err), -EBUSY);
    ttf_writer_close(writer);
    assert_int_equal(ttf_writer_open(ttf_io_posix(), path, &second, &err), 0);
    ttf_writer_close(second);
    assert_int_equal(ttf_writer_open(ttf_io_posix(), in(*state, "none"), &second, &err), -ENOENT);
}

static void going_on_after_the_seal_removes_it_first(void **state)
{
    struct ttf_io *io = ttf_io_posix();
    const char *path = in(*state, "d");
    struct ttf_writer *writer = small_create(io, path);
    struct ttf_reader *reader;
    struct ttf_segment segment;
    struct ttf_err err = {0};
    char first[65], second[65], sums[65], unchanged[65];

    assert_int_equal(small_slot(writer, 0), 0);
    assert_int_equal(ttf_writer_seal(writer, "count", first, &err), 0);
    ttf_writer_close(writer);
    assert_int_equal(ttf_sha256_file(io, in(path, "SHA256SUMS"), NULL, sums, NULL), 0);
    assert_int_equal(ttf_writer_open(io, path, &writer, &err), 0);
    assert_true(ttf_writer_state(writer)->sealed);
    assert_int_equal(ttf_writer_state(writer)->next_index, 1);
    ttf_writer_close(writer); /* opened and closed: still sealed */
    assert_int_equal(ttf_sha256_file(io, in(path, "SHA256SUMS"), NULL, unchanged, NULL), 0);
    assert_string_equal(sums, unchanged);

    assert_int_equal(ttf_writer_open(io, path, &writer, &err), 0);
    segment = ttf_writer_state(writer)->last_segment;
    segment.segment = 1;
    segment.first_index = 1;
    assert_int_equal(ttf_writer_segment(writer, &segment, &err), 0);
    assert_int_equal(ttf_reader_open(io, path, &reader, &err), 0);
    assert_false(ttf_reader_summary(reader)->sealed || ttf_reader_summary(reader)->ended);
    ttf_reader_close(reader);
    assert_int_equal(small_slot(writer, 1), 0);
    assert_int_equal(sha256sum_check(path), 0);
    assert_int_equal(ttf_writer_seal(writer, "until", second, &err), 0);
    ttf_writer_close(writer);
    assert_string_not_equal(first, second);
    assert_int_equal(sha256sum_check(path), 0);
    assert_int_equal(small_check(io, path), 2);
}

static void plans_calibrations_and_events_are_kept(void **state)
{
    struct ttf_io *io = ttf_io_posix();
    const char *path = in(*state, "d"), *cal = in(*state, "cal");
    struct ttf_writer *writer = small_create(io, path);
    struct ttf_reader *reader;
    struct ttf_err err = {0};
    char *text;

    assert_int_equal(mkdir(cal, 0777), 0);
    write_text(in(cal, "calibration.json"), "{}\n", 3);
    write_text(in(cal, "dark.tif"), "dark", 4);
    assert_int_equal(ttf_writer_calibration(writer, "cal-1", cal, &err), 0);
    assert_int_equal(ttf_writer_calibration(writer, "cal-1", cal, &err), 0);
    assert_int_equal(ttf_writer_plan(writer, "interval: 20s\n", NULL, &err), 1);
    assert_int_equal(ttf_writer_event(writer, "door", 7, TTF_NS_UNKNOWN, "opened\nwide",
                                      "{\"angle\":\n90}", &err),
                     0);
    assert_int_equal(ttf_writer_event(writer, "door", 7, 8, "x", "[1]", &err), -EINVAL);
    ttf_writer_close(writer);
    assert_int_equal(ttf_writer_open(io, path, &writer, &err), 0);
    assert_int_equal(ttf_writer_calibration(writer, "cal-1", cal, &err), 0);
    ttf_writer_close(writer);

    assert_int_equal(ttf_reader_open(io, path, &reader, &err), 0);
    assert_int_equal(ttf_reader_summary(reader)->n_calibrations, 1);
    assert_int_equal(ttf_reader_summary(reader)->n_plans, 2);
    ttf_reader_close(reader);
    assert_int_equal(size_of(in(path, "calibration/cal-1/dark.tif")), 4);
    text = file_text(in(path, "plans/1.yaml"), NULL);
    assert_string_equal(text, "interval: 20s\n");
    free(text);
    text = file_text(in(path, "events.jsonl"), NULL);
    assert_non_null(strstr(text, "{\"type\":\"event\",\"seq\":0,\"kind\":\"door\",\"at_ns\":7,"
                                 "\"text\":\"opened\\nwide\",\"detail\":{\"angle\": 90},\"crc\":"));
    free(text);
}

static void slots_that_do_not_say_what_they_lack_are_refused(void **state)
{
    struct ttf_writer *writer = small_create(ttf_io_posix(), in(*state, "d"));
    struct ttf_slot_record record;
    struct ttf_err err = {0};

    ttf_slot_record_init(&record);
    record.result = TTF_RESULT_MISSED;
    assert_int_equal(ttf_writer_commit(writer, &record, &err), -EINVAL); /* no reason */
    strcpy(record.reason, "storage too slow");
    record.segment = 1;
    assert_int_equal(ttf_writer_commit(writer, &record, &err), -EINVAL); /* no such segment */
    record.segment = 0;
    assert_int_equal(ttf_writer_commit(writer, &record, &err), 0);
    assert_int_equal(ttf_writer_commit(writer, &record, &err), -EINVAL); /* index again */
    record.index = 7;
    record.result = TTF_RESULT_PARTIAL;
    assert_int_equal(ttf_slot_record_images(&record, 1), 0);
    strcpy(record.images[0].stream, "main");
    assert_int_equal(ttf_writer_commit(writer, &record, &err), -EINVAL);
    assert_non_null(strstr(err.what, "lacking"));
    strcpy(record.images[0].lacking, "missing");
    record.result = TTF_RESULT_CAPTURED;
    assert_int_equal(ttf_writer_commit(writer, &record, &err), -EINVAL);
    record.result = TTF_RESULT_PARTIAL;
    assert_int_equal(ttf_writer_commit(writer, &record, &err), 0);
    assert_int_equal(ttf_writer_state(writer)->next_index, 8);
    ttf_slot_record_free(&record);
    ttf_writer_close(writer);
}

int main(void)
{
#define T(f) cmocka_unit_test_setup_teardown(f, folder_setup, folder_teardown)
    const struct CMUnitTest tests[] = {
        T(what_is_written_is_read_back),
        T(a_file_written_back_and_forth_has_its_right_hash),
        T(the_error_told_is_the_one_that_is_returned),
        T(a_name_that_is_no_name_is_refused),
        T(an_existing_dataset_is_not_written_over),
        T(two_writers_at_once_are_kept_apart),
        T(going_on_after_the_seal_removes_it_first),
        T(a_record_in_a_folder_that_was_removed_is_not_acknowledged),
        T(an_event_whose_detail_its_readers_would_refuse_is_refused),
        T(plans_calibrations_and_events_are_kept),
        T(slots_that_do_not_say_what_they_lack_are_refused),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
