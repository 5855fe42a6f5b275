/* SPDX-License-Identifier: Apache-2.0 */
/* Opening to go on, and creating again: what is put right, what is left alone, what is refused. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "store_ios.h"
#include "store_test.h"
#include "ttf/dataset/reader.h"
#include "ttf/dataset/verify.h"

/* n slots, closed, not sealed. */
static const char *slots(void **state, int64_t n)
{
    const char *path = in(*state, "d");
    struct ttf_writer *writer = small_create(quick_io(), path);
    int64_t i;

    for (i = 0; i < n; i++)
        assert_int_equal(small_slot(writer, i), 0);
    ttf_writer_close(writer);
    return path;
}

/* Opens and closes again: how much was repaired. */
static unsigned repaired(const char *path)
{
    struct ttf_writer *writer;
    struct ttf_err err = {0};
    unsigned n;

    if (ttf_writer_open(quick_io(), path, &writer, &err) != 0)
        fail_msg("%s: %s", err.where, err.what);
    n = ttf_writer_state(writer)->repaired;
    ttf_writer_close(writer);
    return n;
}

static bool events_say(const char *path, const char *text)
{
    char *events = file_text(in(path, "events.jsonl"), NULL);
    bool said = strstr(events, text) != NULL;

    free(events);
    return said;
}

static unsigned findings(const char *path, enum ttf_severity severity)
{
    struct ttf_verify_options options = {.deep = true};
    struct ttf_verify_report report;
    unsigned n;

    assert_int_equal(ttf_verify(quick_io(), path, &options, &report, NULL), 0);
    n = (unsigned)report.n_of[severity];
    ttf_verify_report_free(&report);
    return n;
}

/* ---- what is put right ---- */

static void a_fragment_of_the_events_is_kept_as_an_event(void **state)
{
    const char *path = slots(state, 1);

    assert_int_equal(run("printf 'torn' >> '%s/events.jsonl'", path), 0);
    assert_int_equal(repaired(path), 1);
    assert_true(events_say(path, "\"file\":\"events.jsonl\",\"bytes\":4,\"hex\":\"746f726e\""));
    assert_int_equal(findings(path, TTF_FINDING_LEFTOVER), 0);
    assert_int_equal(repaired(path), 0); /* once is enough */
}

static void what_was_repaired_is_said_in_an_event(void **state)
{
    const char *path = slots(state, 1);

    write_text(in(path, "frames/main/000001.tif"), "x", 1);
    write_text(in(path, "raw.tmp"), "x", 1);
    assert_int_equal(findings(path, TTF_FINDING_LEFTOVER), 2);
    assert_int_equal(unlink(in(path, "SHA256SUMS")), 0);
    assert_int_equal(repaired(path), 3);
    assert_true(events_say(path, "1 temporary files removed; 1 files without a record removed; "
                                 "SHA256SUMS brought up to date"));
    assert_int_equal(sha256sum_check(path), 0);
    assert_int_equal(findings(path, TTF_FINDING_LEFTOVER), 0);
}

static void sums_cut_off_within_a_line_are_no_damage(void **state)
{
    char path[300]; /* the buffers of in() come round */
    int64_t n, whole;

    snprintf(path, sizeof(path), "%s", slots(state, 2));
    whole = size_of(in(path, "SHA256SUMS"));
    for (n = whole - 1; n >= 0; n--) {
        assert_int_equal(truncate(in(path, "SHA256SUMS"), n), 0);
        assert_int_equal(findings(path, TTF_FINDING_DAMAGE), 0);
        if (n % 8 != 0 && n != whole - 1)
            continue;
        assert_int_equal(repaired(path), 1);
        assert_int_equal(run("[ $(wc -l < '%s/SHA256SUMS') -eq 2 ]", path), 0);
    }
}

/* Whatever another path in it is taken for: it does not go unseen. */
static void sums_with_a_changed_path_do_not_pass(void **state)
{
    const char *path = slots(state, 2);
    struct ttf_writer *writer;
    int r;

    assert_int_equal(run("sed -i 's/000001/000007/' '%s/SHA256SUMS'", path), 0);
    r = ttf_writer_open(quick_io(), path, &writer, NULL);
    if (r == 0) {
        assert_int_equal(ttf_writer_state(writer)->repaired, 1);
        ttf_writer_close(writer);
        assert_int_equal(sha256sum_check(path), 0);
    } else {
        assert_int_equal(r, -TTF_EDAMAGED);
    }
}

static void rubbish_in_the_sums_is_not_taken_for_lost_records(void **state)
{
    const char *path = slots(state, 2);

    assert_int_equal(run("printf '%%064d  frames/main/000009.tif\\n' 0 | tr 0 g | "
                         "sed s/ggggg9/000009/ >> '%s/SHA256SUMS'",
                         path),
                     0);
    assert_int_equal(run("grep -q 'gggg  frames/main/000009.tif' '%s/SHA256SUMS'", path), 0);
    assert_int_equal(repaired(path), 1);
    assert_int_equal(sha256sum_check(path), 0);
}

/* The last line reached the disk in part: its length and its end, not what lies between. */
static void a_last_line_with_a_hole_is_set_aside(void **state)
{
    const char *path = slots(state, 3);
    struct ttf_reader *reader;
    struct ttf_writer *writer;
    char *text, *hole;
    size_t n;

    assert_int_equal(run("sed -i '$d' '%s/SHA256SUMS'", path),
                     0); /* is written behind the record */
    text = file_text(in(path, "records.jsonl"), &n);
    hole = strstr(text, "\"index\":2");
    hole[8] = '7'; /* JSON as before: only the crc tells */
    write_text(in(path, "records.jsonl"), text, n - 1);
    free(text);
    assert_int_equal(findings(path, TTF_FINDING_DAMAGE), 0);
    assert_int_equal(ttf_reader_open(quick_io(), path, &reader, NULL), 0);
    assert_int_equal(ttf_reader_summary(reader)->slots, 2);
    ttf_reader_close(reader);
    assert_int_equal(ttf_writer_open(quick_io(), path, &writer, NULL), 0);
    assert_int_equal(ttf_writer_state(writer)->next_index, 2);
    assert_int_equal(small_slot(writer, 2), 0);
    ttf_writer_close(writer);
    assert_int_equal(small_check(quick_io(), path), 3);
    assert_int_equal(findings(path, TTF_FINDING_LEFTOVER), 0);
}

/* ---- what is left alone ---- */

static void a_file_that_a_record_names_is_never_removed(void **state)
{
    const char *path = slots(state, 1);
    struct ttf_slot_record record;
    struct ttf_writer *writer;

    /* Somebody names files by another counting: that of slot 1 has the name of slot 5. */
    write_text(in(path, "frames/main/000005.tif"), "five", 4);
    assert_int_equal(ttf_writer_open(quick_io(), path, &writer, NULL), 0);
    ttf_slot_record_init(&record);
    assert_int_equal(ttf_slot_record_images(&record, 1), 0);
    record.index = 1;
    strcpy(record.images[0].stream, "main");
    record.images[0].n_files = 1;
    strcpy(record.images[0].files[0].role, "developed");
    strcpy(record.images[0].files[0].path, "frames/main/000005.tif");
    record.images[0].files[0].bytes = 4;
    memset(record.images[0].files[0].sha256, '0', 64);
    write_text(in(path, "frames/main/000005.tif"), "five", 4);
    assert_int_equal(ttf_writer_commit(writer, &record, NULL), 0);
    ttf_slot_record_free(&record);
    ttf_writer_close(writer);
    assert_int_equal(repaired(path), 0);
    assert_int_equal(size_of(in(path, "frames/main/000005.tif")), 4);
}

static void a_file_of_a_slot_that_has_its_record_is_left_alone_and_named(void **state)
{
    const char *path = slots(state, 2);

    write_text(in(path, "frames/main/000001.r1.tif"), "x", 1);
    assert_int_equal(findings(path, TTF_FINDING_NOTE), 1);
    assert_int_equal(findings(path, TTF_FINDING_LEFTOVER), 0);
    assert_int_equal(repaired(path), 0);
    assert_int_equal(size_of(in(path, "frames/main/000001.r1.tif")), 1);
    assert_int_equal(findings(path, TTF_FINDING_NOTE), 1);
}

static void a_sealed_dataset_is_only_looked_at(void **state)
{
    const char *path = slots(state, 1);
    struct ttf_writer *writer;

    assert_int_equal(ttf_writer_open(quick_io(), path, &writer, NULL), 0);
    assert_int_equal(ttf_writer_seal(writer, "count", NULL, NULL), 0);
    ttf_writer_close(writer);
    write_text(in(path, "mine.tmp"), "x", 1);
    assert_int_equal(repaired(path), 0);
    assert_true(exists(in(path, "mine.tmp")));
    assert_false(exists(in(path, ".events-reserve")));
    assert_int_equal(sha256sum_check(path), 0);
    assert_int_equal(run("grep -q records.jsonl '%s/SHA256SUMS'", path), 0);
}

/* ---- the end is known after opening, too ---- */

static void sealing_after_opening_adds_no_second_end(void **state)
{
    const char *path = slots(state, 1);
    struct cue cue = {.error = EIO, .op = "rename", .in = "SHA256SUMS", .at = 1, .for_ever = true};
    struct ttf_io *io = ttf_io_faulty_create(quick_io(), cue_fault, &cue);
    struct ttf_writer *writer;

    assert_int_equal(ttf_writer_open(io, path, &writer, NULL), 0);
    assert_int_equal(ttf_writer_seal(writer, "count", NULL, NULL), -EIO); /* ended, not sealed */
    ttf_writer_abandon(writer);
    ttf_io_faulty_destroy(io);
    assert_int_equal(ttf_writer_open(quick_io(), path, &writer, NULL), 0);
    assert_int_equal(ttf_writer_seal(writer, "count", NULL, NULL), 0);
    ttf_writer_close(writer);
    assert_int_equal(run("[ $(grep -c '\"type\":\"end\"' '%s/records.jsonl') -eq 1 ]", path), 0);
    assert_int_equal(findings(path, TTF_FINDING_DAMAGE), 0);
}

/* ---- what is refused ---- */

static int created(const char *path)
{
    struct ttf_manifest manifest;
    struct ttf_writer *writer;
    int r;

    small_manifest(&manifest);
    r = ttf_writer_create(quick_io(), path, &manifest, NULL, NULL, &writer, NULL);
    if (r == 0)
        ttf_writer_close(writer);
    return r;
}

static void a_folder_that_lost_its_manifest_is_not_created_over(void **state)
{
    const char *path = slots(state, 1);

    assert_int_equal(unlink(in(path, "dataset.json")), 0);
    assert_int_equal(created(path), -EEXIST); /* frames/ is nothing that creating leaves */
    assert_int_equal(run("rm -r '%s/frames' '%s/SHA256SUMS'", path, path), 0);
    assert_int_equal(created(path), -EEXIST); /* its records hold more than plans */
    assert_int_equal(run("sed -i '1s/plan/plum/;2,$d' '%s/records.jsonl'", path), 0);
    assert_int_equal(created(path), -EEXIST); /* or are damaged */
    assert_int_equal(size_of(in(path, "dataset.json")), -1);
    assert_int_equal(unlink(in(path, "records.jsonl")), 0);
    assert_int_equal(created(path), 0); /* what is left now may be of a creation cut off */
}

static void a_writer_is_refused_while_the_creator_writes(void **state)
{
    const char *path = in(*state, "d");
    struct ttf_writer *writer = small_create(quick_io(), path), *second;

    assert_int_equal(run("printf 'torn' >> '%s/records.jsonl'", path), 0);
    assert_int_equal(ttf_writer_open(quick_io(), path, &second, NULL), -EBUSY);
    assert_int_equal(run("tail -c 4 '%s/records.jsonl' | grep -q torn", path), 0); /* untouched */
    ttf_writer_abandon(writer);
    assert_int_equal(ttf_writer_open(quick_io(), path, &writer, NULL), 0);
    assert_int_equal(ttf_writer_open(quick_io(), path, &second, NULL), -EBUSY);
    ttf_writer_close(writer);
}

static void segments_and_slots_come_in_order(void **state)
{
    const char *path = slots(state, 1);
    struct ttf_slot_record record;
    struct ttf_segment segment;
    struct ttf_writer *writer;

    assert_int_equal(ttf_writer_open(quick_io(), path, &writer, NULL), 0);
    segment = ttf_writer_state(writer)->last_segment;
    assert_int_equal(ttf_writer_segment(writer, &segment, NULL), -EINVAL); /* no correction */
    segment.corrects = true;
    segment.plan = 7;
    assert_int_equal(ttf_writer_segment(writer, &segment, NULL), -EINVAL); /* of no plan */
    segment.plan = 0;
    assert_int_equal(ttf_writer_segment(writer, &segment, NULL), 0);
    segment.segment = 1;
    assert_int_equal(ttf_writer_segment(writer, &segment, NULL), -EINVAL); /* corrects nothing */
    segment.segment = 2;
    segment.corrects = false;
    assert_int_equal(ttf_writer_segment(writer, &segment, NULL), -EINVAL); /* leaves 1 out */
    ttf_slot_record_init(&record);
    record.result = TTF_RESULT_MISSED;
    strcpy(record.reason, "storage too slow");
    assert_int_equal(ttf_writer_commit(writer, &record, NULL), -EINVAL); /* is there already */
    record.index = 1;
    assert_int_equal(ttf_slot_record_images(&record, 1), 0);
    strcpy(record.images[0].stream, "main");
    record.images[0].n_files = 1;
    strcpy(record.images[0].files[0].role, "developed");
    strcpy(record.images[0].files[0].path, "frames/main/000001.tif");
    assert_int_equal(ttf_writer_commit(writer, &record, NULL), -EINVAL); /* without its sha256 */
    ttf_slot_record_free(&record);
    ttf_writer_close(writer);
    assert_int_equal(findings(path, TTF_FINDING_DAMAGE), 0);
}

int main(void)
{
#define T(f) cmocka_unit_test_setup_teardown(f, folder_setup, folder_teardown)
    const struct CMUnitTest tests[] = {
        T(a_fragment_of_the_events_is_kept_as_an_event),
        T(what_was_repaired_is_said_in_an_event),
        T(sums_cut_off_within_a_line_are_no_damage),
        T(sums_with_a_changed_path_do_not_pass),
        T(rubbish_in_the_sums_is_not_taken_for_lost_records),
        T(a_last_line_with_a_hole_is_set_aside),
        T(a_file_that_a_record_names_is_never_removed),
        T(a_file_of_a_slot_that_has_its_record_is_left_alone_and_named),
        T(a_sealed_dataset_is_only_looked_at),
        T(sealing_after_opening_adds_no_second_end),
        T(a_folder_that_lost_its_manifest_is_not_created_over),
        T(a_writer_is_refused_while_the_creator_writes),
        T(segments_and_slots_come_in_order),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
