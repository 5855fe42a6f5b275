/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Records whose every crc holds and that still cannot be true: a writer refuses them, a reader
 * does not pass them on, verify names them.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "lines.h"
#include "store_ios.h"
#include "store_test.h"
#include "ttf/dataset/hash.h"
#include "ttf/dataset/reader.h"
#include "ttf/dataset/sequence.h"
#include "ttf/dataset/verify.h"

/* Lines: 0 plan, 1 segment, 2..4 slots 0..2; closed, not sealed. */
static const char *three_slots(void **state)
{
    const char *path = in(*state, "d");
    struct ttf_writer *writer = small_create(quick_io(), path);
    int64_t i;

    for (i = 0; i < 3; i++)
        assert_int_equal(small_slot(writer, i), 0);
    ttf_writer_close(writer);
    return path;
}

/* Replaces what stands in that line (from 0) of records.jsonl, and gives the line its right crc. */
static void change_line(const char *path, int number, const char *from, const char *to)
{
    size_t n, room, used;
    char *text = file_text(in(path, "records.jsonl"), &n), *line = text, *end, *at, *changed;

    room = n + strlen(to) + 1;
    changed = malloc(room);
    assert_non_null(changed);
    for (; number > 0; number--)
        line = strchr(line, '\n') + 1;
    end = strchr(line, '\n');
    at = strstr(line, from);
    assert_true(at && at < end);
    used = (size_t)snprintf(changed, room, "%.*s%s%.*s", (int)(at - text), text, to,
                            (int)(end - at - (ptrdiff_t)strlen(from) - (ptrdiff_t)TTF_LINE_TAIL),
                            at + strlen(from));
    snprintf(changed + used, room - used, ",\"crc\":\"%08x\"}%s",
             ttf_crc32(0, changed + (line - text), used - (size_t)(line - text)), end);
    write_text(in(path, "records.jsonl"), changed, strlen(changed));
    free(changed);
    free(text);
}

static bool verify_says(const char *path, const char *says)
{
    struct ttf_verify_options options = {.deep = true};
    struct ttf_verify_report report;
    bool said = false;
    unsigned i;

    assert_int_equal(ttf_verify(quick_io(), path, &options, &report, NULL), 0);
    for (i = 0; i < report.n_findings; i++)
        said = said || (report.findings[i].severity == TTF_FINDING_DAMAGE &&
                        strstr(report.findings[i].text, says));
    said = said && report.damaged;
    ttf_verify_report_free(&report);
    return said;
}

static int opened_for_writing(const char *path)
{
    struct ttf_writer *writer;
    int r = ttf_writer_open(quick_io(), path, &writer, NULL);

    if (r == 0)
        ttf_writer_abandon(writer);
    return r;
}

static int opened_for_reading(const char *path)
{
    struct ttf_reader *reader;
    int r = ttf_reader_open(quick_io(), path, &reader, NULL);

    if (r == 0)
        ttf_reader_close(reader);
    return r;
}

static int opened_by_heads(const char *path)
{
    struct ttf_reader *reader;
    int r = ttf_reader_open_by_heads(quick_io(), path, &reader, NULL);

    if (r == 0)
        ttf_reader_close(reader);
    return r;
}

/* By their heads, or as a line of another hand. */
static void a_slot_that_another_program_wrote_is_read_like_ours(void **state)
{
    const char *path = three_slots(state);
    struct ttf_reader *reader = NULL;
    struct ttf_slot_record record;
    enum ttf_result result;
    int64_t index;

    change_line(path, 3, "\"index\":1,\"segment\":0", "\"segment\":0,\"index\":1");
    assert_int_equal(ttf_reader_open_by_heads(quick_io(), path, &reader, NULL), 0);
    assert_int_equal(ttf_reader_summary(reader)->slots, 3);
    assert_int_equal(ttf_reader_brief(reader, 1, &index, &result), 0);
    assert_int_equal(index, 1);
    assert_int_equal(result, TTF_RESULT_CAPTURED);
    assert_int_equal(ttf_reader_slot(reader, 1, &record, NULL), 0);
    assert_int_equal(record.index, 1);
    ttf_slot_record_free(&record);
    ttf_reader_close(reader);
}

static void a_slot_in_the_wrong_place_is_damage_whoever_wrote_it(void **state)
{
    static const char *const wrong[][2] = {
        {"\"seq\":3", "\"seq\":4"},
        {"\"seq\":3", "\"seq\": 4"},
        {"\"index\":1", "\"index\":0"},
        {"\"index\":1", "\"index\":-1"},
        {"\"index\":1,\"segment\":0", "\"segment\":0,\"index\":0"},
        {"\"segment\":0", "\"segment\":1"},
        {"\"result\":\"captured\"", "\"result\":\"taken\""},
    };

    for (size_t i = 0; i < TTF_COUNT_OF(wrong); i++) {
        const char *path = three_slots(state);

        change_line(path, 3, wrong[i][0], wrong[i][1]);
        if (opened_for_reading(path) != -TTF_EDAMAGED || opened_by_heads(path) != -TTF_EDAMAGED)
            fail_msg("%s", wrong[i][1]);
        assert_int_equal(run("rm -r '%s'", path), 0);
    }
}

/* Whoever opens by the heads is told when it asks for the slot, everybody else at once. */
static void a_slot_that_is_no_json_behind_its_head_is_damage(void **state)
{
    const char *path = three_slots(state);
    struct ttf_slot_record record;
    struct ttf_reader *reader;
    struct ttf_err err = {0};

    change_line(path, 3, "\"images\":[", "\"images\":[[");
    assert_int_equal(ttf_reader_open_by_heads(quick_io(), path, &reader, NULL), 0);
    assert_int_equal(ttf_reader_slot(reader, 1, &record, &err), -TTF_EDAMAGED);
    assert_non_null(strstr(err.what, "not JSON"));
    assert_non_null(strstr(err.where, "records.jsonl:4"));
    assert_int_equal(ttf_reader_slot(reader, 2, &record, NULL), 0);
    ttf_slot_record_free(&record);
    ttf_reader_close(reader);
    assert_int_equal(opened_for_reading(path), -TTF_EDAMAGED);
    assert_true(verify_says(path, "not JSON"));
    assert_int_equal(opened_for_writing(path), -TTF_EDAMAGED);
}

/* Flags are words of whoever wrote them: what is none is passed over, and what finds no room. */
static void flags_are_read_as_far_as_they_are_words(void **state)
{
    const char *path = three_slots(state);
    char changed[700] = "\"stream\":\"main\",\"flags\":[\"\",7,\"late\",\"";
    struct ttf_reader *reader = NULL;
    struct ttf_slot_record record;

    memset(changed + strlen(changed), 'x', 500);
    snprintf(changed + strlen(changed), 40, "\",\"door-open\"]");
    change_line(path, 3, "\"stream\":\"main\"", changed);
    assert_int_equal(ttf_reader_open(quick_io(), path, &reader, NULL), 0);
    assert_int_equal(ttf_reader_slot(reader, 1, &record, NULL), 0);
    assert_string_equal(record.images[0].flags, "late,door-open");
    ttf_slot_record_free(&record);
    ttf_reader_close(reader);
}

/* Whoever shows a dataset that came from elsewhere must not be led to other files of the machine. */
static void a_sequence_never_leaves_its_dataset(void **state)
{
    static const char *const outside[] = {"../main/000000.tif", "/etc/passwd", "frames/../../x",
                                          ".."};

    for (unsigned i = 0; i < TTF_COUNT_OF(outside); i++) {
        const char *path = three_slots(state);
        struct ttf_sequence *sequence = NULL;
        struct ttf_reader *reader = NULL;
        struct ttf_err err = {0};

        change_line(path, 2, "frames/main/000000.tif", outside[i]);
        assert_int_equal(ttf_reader_open(quick_io(), path, &reader, NULL), 0);
        assert_int_equal(ttf_sequence_of_dataset(reader, NULL, &sequence, &err), -TTF_EDAMAGED);
        if (!strstr(err.what, "outside") && !strstr(err.what, "does not lie in the dataset"))
            fail_msg("%s: %s", outside[i], err.what);
        assert_null(sequence);
        ttf_reader_close(reader);
        assert_int_equal(run("rm -r '%s'", path), 0);
    }
}

static void records_that_contradict_each_other_are_damage(void **state)
{
    static const struct {
        int line;
        const char *from, *to, *says;
        int writer, reader;
    } cases[] = {
        {4, "\"index\":2", "\"index\":1", "index does not rise", -TTF_EDAMAGED, -TTF_EDAMAGED},
        {4, "\"segment\":0", "\"segment\":1", "no line before it", -TTF_EDAMAGED, -TTF_EDAMAGED},
        {1, "\"segment\":0", "\"segment\":1", "leaves others out", -TTF_EDAMAGED, -TTF_EDAMAGED},
        {1, "\"plan\":0", "\"plan\":3", "its plan has no line", -TTF_EDAMAGED, -TTF_EDAMAGED},
        {0, "\"plan\":0", "\"plan\":1", "plan 1 comes where plan 0 is due", -TTF_EDAMAGED,
         -TTF_EDAMAGED},
        {0, "\"plan\":0", "\"plum\":0", "plan is missing", -TTF_EDAMAGED, -TTF_EDAMAGED},
        {0, "\"files\"", "\"fires\"", "files is missing", -TTF_EDAMAGED, 0},
        {0, "\"type\":\"plan\"", "\"type\":\"calibration\"", "id is missing", -TTF_EDAMAGED,
         -TTF_EDAMAGED},
        {4, "\"n_averaged\":1",
         "\"n_averaged\":1,\"bracket\":{\"index\":0,\"relative_exposure\":0}",
         "relative_exposure must be more than 0", 0, 0},
        {4, "\"seq\":4", "\"seq\":3", "lost or doubled", -TTF_EDAMAGED, -TTF_EDAMAGED},
        {4, "\"seq\":4", "\"seq\":5", "lost or doubled", -TTF_EDAMAGED, -TTF_EDAMAGED},
        {4, "\"index\":2", "\"index\":2,\"index\":2", "not JSON", -TTF_EDAMAGED, -TTF_EDAMAGED},
        {4, "\"type\":\"slot\"", "\"typo\":\"slot\"", "no type", -TTF_EDAMAGED, -TTF_EDAMAGED},
        {4, "frames/main/000002.tif", "../main/000002.tif", "does not lie in the dataset",
         -TTF_EDAMAGED, 0},
        {4, "\"sha256\":\"0b02eb1c", "\"sha256\":\"0B02EB1C", "64 hex digits", -TTF_EDAMAGED, 0},
        {1, "\"dataset_sha256\":\"", "\"dataset_sha256\":\"5c\",\"x\":\"",
         "dataset_sha256 must be 64 hex digits", -TTF_EDAMAGED, -TTF_EDAMAGED},
        {4, "\"files\":", "\"fires\":", "no files and does not say why", -TTF_EDAMAGED, 0},
        {4, "\"n_averaged\":1", "\"n_averaged\":1,\"calibration\":\"cal-1\"",
         "names calibration cal-1", 0, 0},
        {4, "\"result\":\"captured\"", "\"result\":\"dreamt\"", "dreamt", -TTF_EDAMAGED,
         -TTF_EDAMAGED},
    };
    size_t i;

    for (i = 0; i < TTF_COUNT_OF(cases); i++) {
        const char *path = three_slots(state);

        change_line(path, cases[i].line, cases[i].from, cases[i].to);
        if (!verify_says(path, cases[i].says))
            fail_msg("%s: verify does not say that it %s", cases[i].to, cases[i].says);
        if (opened_for_reading(path) != cases[i].reader)
            fail_msg("%s: read: %d", cases[i].to, opened_for_reading(path));
        if (opened_for_writing(path) != cases[i].writer)
            fail_msg("%s: opened: %d", cases[i].to, opened_for_writing(path));
        assert_int_equal(run("rm -r '%s'", path), 0);
    }
}

/* Not even where no slot is of it. */
static void a_segment_that_leaves_another_out_is_refused(void **state)
{
    const char *path = in(*state, "d");

    ttf_writer_close(small_create(quick_io(), path));
    change_line(path, 1, "\"segment\":0", "\"segment\":1");
    assert_int_equal(opened_for_writing(path), -TTF_EDAMAGED);
    assert_int_equal(opened_for_reading(path), -TTF_EDAMAGED);
    assert_true(verify_says(path, "leaves others out"));
}

static void only_the_wrong_line_is_blamed(void **state)
{
    struct ttf_verify_options options = {.deep = true};
    struct ttf_verify_report report;
    const char *path = three_slots(state);

    assert_int_equal(run("sed -i '4s/index/indox/' '%s/records.jsonl'", path), 0);
    assert_int_equal(ttf_verify(quick_io(), path, &options, &report, NULL), 0);
    assert_int_equal(report.n_findings, 1); /* nor its file for being without a record */
    assert_string_equal(report.findings[0].file, "records.jsonl:4");
    ttf_verify_report_free(&report);
}

static void an_end_that_counts_wrong_is_damage(void **state)
{
    const char *path = three_slots(state);
    struct ttf_writer *writer;

    assert_int_equal(ttf_writer_open(quick_io(), path, &writer, NULL), 0);
    assert_int_equal(ttf_writer_seal(writer, "count", NULL, NULL), 0);
    ttf_writer_close(writer);
    change_line(path, 5, "\"slots\":3", "\"slots\":4");
    assert_true(verify_says(path, "counts 4 slots"));
}

/* A folder that is there by now vouches for nothing: the image was developed with something else, or with nothing. */
static void a_calibration_without_a_line_is_damage_though_its_folder_is_there(void **state)
{
    const char *path = three_slots(state);

    assert_int_equal(run("mkdir -p '%s/calibration/cal-1'", path), 0);
    change_line(path, 4, "\"n_averaged\":1", "\"n_averaged\":1,\"calibration\":\"cal-1\"");
    assert_true(verify_says(path, "names calibration cal-1, which no line before it brought"));
}

/* Behind a line that is damaged the next is judged by what may have stood there. */
static void one_damaged_plan_does_not_accuse_the_next(void **state)
{
    struct ttf_verify_options options = {.deep = true};
    struct ttf_verify_report report;
    const char *path = in(*state, "d");
    struct ttf_writer *writer = small_create(quick_io(), path);

    assert_int_equal(ttf_writer_plan(writer, "interval: 20s\n", "{}\n", NULL), 1);
    ttf_writer_close(writer);
    assert_int_equal(run("sed -i '1s/plans/plums/' '%s/records.jsonl'", path), 0);
    assert_int_equal(ttf_verify(quick_io(), path, &options, &report, NULL), 0);
    for (unsigned i = 0; i < report.n_findings; i++)
        if (strstr(report.findings[i].text, "is due"))
            fail_msg("%s: %s", report.findings[i].file, report.findings[i].text);
    ttf_verify_report_free(&report);
}

static void a_seal_that_is_not_in_order_is_damage(void **state)
{
    const char *path = three_slots(state);
    struct ttf_writer *writer;

    assert_int_equal(ttf_writer_open(quick_io(), path, &writer, NULL), 0);
    assert_int_equal(ttf_writer_seal(writer, "count", NULL, NULL), 0);
    ttf_writer_close(writer);
    assert_int_equal(
        run("tac '%s/SHA256SUMS' > '%s/x' && mv '%s/x' '%s/SHA256SUMS'", path, path, path, path),
        0);
    assert_int_equal(sha256sum_check(path), 0);
    assert_true(verify_says(path, "lists by the bytes of the paths"));
}

/* A path that was changed upward is missing, and the next, which comes before it, is as it was. */
static void one_changed_path_of_a_seal_accuses_no_other(void **state)
{
    /* dataset.json is the first, then events.jsonl */
    static const char *const change[] = {"1s/  d/  z/", "2s/  e/  a/"};
    static const char *const accused[] = {"zataset.json", "avents.jsonl"};

    for (unsigned i = 0; i < 2; i++) {
        struct ttf_verify_options options = {.deep = true};
        struct ttf_verify_report report;
        const char *path = three_slots(state);
        struct ttf_writer *writer;
        bool missing = false;
        unsigned order = 0;

        assert_int_equal(ttf_writer_open(quick_io(), path, &writer, NULL), 0);
        assert_int_equal(ttf_writer_seal(writer, "count", NULL, NULL), 0);
        ttf_writer_close(writer);
        assert_int_equal(run("sed -i '%s' '%s/SHA256SUMS'", change[i], path), 0);
        assert_int_equal(ttf_verify(quick_io(), path, &options, &report, NULL), 0);
        for (unsigned k = 0; k < report.n_findings; k++) {
            const struct ttf_verify_finding *f = &report.findings[k];

            order += strstr(f->text, "lists by the bytes") != NULL;
            missing = missing || strcmp(f->file, accused[i]) == 0;
        }
        assert_true(missing);
        assert_int_equal(order, i); /* the second one comes before the first itself */
        ttf_verify_report_free(&report);
        assert_int_equal(run("rm -r '%s'", path), 0);
    }
}

static void a_rehearsal_is_not_sealed(void **state)
{
    const char *path = three_slots(state);
    struct ttf_writer *writer;

    assert_int_equal(
        run("sed -i 's/\"simulated\"/\"rehearsal\": true, \"simulated\"/' '%s/dataset.json'; "
            "sed -i 's/\"dataset_sha256\"/\"dataset_sha\"/' '%s/records.jsonl'",
            path, path),
        0);
    change_line(path, 1, "dataset_sha\"", "dataset_sha_\"");
    assert_int_equal(ttf_writer_open(quick_io(), path, &writer, NULL), 0);
    assert_int_equal(ttf_writer_seal(writer, "count", NULL, NULL), -EINVAL);
    ttf_writer_close(writer);
    /* Somebody else's writer did. */
    assert_int_equal(run("cd '%s' && find * -type f ! -name SHA256SUMS | LC_ALL=C sort | xargs "
                         "sha256sum > x && mv x SHA256SUMS",
                         path),
                     0);
    assert_true(verify_says(path, "is not to be sealed"));
}

static void a_seal_without_an_end_is_damage(void **state)
{
    const char *path = three_slots(state);
    struct ttf_writer *writer;

    assert_int_equal(ttf_writer_open(quick_io(), path, &writer, NULL), 0);
    assert_int_equal(ttf_writer_seal(writer, "count", NULL, NULL), 0);
    ttf_writer_close(writer);
    change_line(path, 5, "\"type\":\"end\"", "\"type\":\"and\"");
    assert_true(verify_says(path, "does not close with an \"end\" line"));
}

/* The seal gives what the record says, not what lies there by then. */
static void the_seal_does_not_bless_a_frame_that_changed_before_it(void **state)
{
    const char *path = three_slots(state);
    struct ttf_writer *writer;
    char changed[64];

    small_bytes(7, changed);
    write_text(in(path, "frames/main/000001.tif"), changed, sizeof(changed));
    assert_int_equal(ttf_writer_open(quick_io(), path, &writer, NULL), 0);
    assert_int_equal(ttf_writer_seal(writer, "count", NULL, NULL), 0);
    ttf_writer_close(writer);
    assert_int_not_equal(sha256sum_check(path), 0);
    assert_true(verify_says(path, "its sha256 is not"));
}

/* Sealed by somebody who wrote no end: it gets one, but not under that seal. */
static void an_end_is_not_added_under_a_seal(void **state)
{
    const char *path = three_slots(state);
    struct cue cue = {.error = EIO, .op = "rename", .in = "SHA256SUMS", .at = 1, .for_ever = true};
    struct ttf_io *io = ttf_io_faulty_create(quick_io(), cue_fault, &cue);
    struct ttf_writer *writer;
    int64_t bytes;

    assert_int_equal(ttf_writer_open(quick_io(), path, &writer, NULL), 0);
    assert_int_equal(ttf_writer_seal(writer, "count", NULL, NULL), 0);
    ttf_writer_close(writer);
    change_line(path, 5, "\"type\":\"end\"", "\"type\":\"and\"");
    bytes = size_of(in(path, "records.jsonl"));
    assert_int_equal(ttf_writer_open(io, path, &writer, NULL), 0);
    assert_int_equal(ttf_writer_seal(writer, "count", NULL, NULL), -EIO);
    assert_int_equal(size_of(in(path, "records.jsonl")), bytes);
    ttf_writer_abandon(writer);
    ttf_io_faulty_destroy(io);
}

static void what_was_added_behind_the_seal_is_damage(void **state)
{
    const char *path = three_slots(state);
    struct ttf_writer *writer;

    assert_int_equal(ttf_writer_open(quick_io(), path, &writer, NULL), 0);
    assert_int_equal(ttf_writer_seal(writer, "count", NULL, NULL), 0);
    ttf_writer_close(writer);
    assert_int_equal(run("printf '{\"type\":\"ev' >> '%s/events.jsonl'", path), 0);
    assert_true(verify_says(path, "ends in 11 bytes"));
    assert_int_equal(opened_for_writing(path), -TTF_EDAMAGED);
}

static void a_seal_cut_off_at_its_last_byte_is_damage(void **state)
{
    const char *path = three_slots(state);
    struct ttf_writer *writer;

    assert_int_equal(ttf_writer_open(quick_io(), path, &writer, NULL), 0);
    assert_int_equal(ttf_writer_seal(writer, "count", NULL, NULL), 0);
    ttf_writer_close(writer);
    assert_int_equal(truncate(in(path, "SHA256SUMS"), size_of(in(path, "SHA256SUMS")) - 1), 0);
    assert_true(verify_says(path, "no line that sha256sum checks"));
}

static void a_file_that_cannot_be_read_is_damage_and_why_is_said(void **state)
{
    const char *path = three_slots(state);

    assert_int_equal(unlink(in(path, "frames/main/000001.tif")), 0);
    assert_int_equal(symlink("000001.tif", in(path, "frames/main/000001.tif")), 0);
    assert_true(verify_says(path, "cannot be read: Too many levels"));
}

static void a_manifest_that_cannot_be_true_is_damage_before_the_seal_too(void **state)
{
    const char *path = three_slots(state);

    assert_int_equal(run("sed -i 's/\"width\": 4/\"width\": 0/' '%s/dataset.json'", path), 0);
    assert_true(verify_says(path, "streams[0].width"));
}

static void missing_records_are_damage_and_none_are_made(void **state)
{
    const char *path = three_slots(state);

    assert_int_equal(unlink(in(path, "records.jsonl")), 0);
    assert_true(verify_says(path, "is missing"));
    assert_int_equal(opened_for_reading(path), -TTF_EDAMAGED);
    assert_int_equal(opened_for_writing(path), -TTF_EDAMAGED);
    assert_false(exists(in(path, "records.jsonl")));
    assert_true(exists(in(path, "frames/main/000002.tif")));
}

static void rot_in_the_events_is_refused_too(void **state)
{
    const char *path = three_slots(state);

    assert_int_equal(run("printf '{}\\n' >> '%s/events.jsonl'", path), 0);
    assert_true(verify_says(path, "crc does not hold"));
    assert_int_equal(opened_for_writing(path), -TTF_EDAMAGED);
}

static void a_line_without_end_is_damage(void **state)
{
    const char *path = three_slots(state);

    assert_int_equal(run("head -c 20000000 /dev/zero | tr '\\0' x >> '%s/events.jsonl'", path), 0);
    assert_true(verify_says(path, "longer than any line"));
    assert_int_equal(opened_for_writing(path), -TTF_EDAMAGED);
}

static void a_record_that_changes_while_it_is_read_is_not_passed_on(void **state)
{
    const char *path = three_slots(state);
    struct ttf_slot_record record;
    struct ttf_reader *reader;

    assert_int_equal(ttf_reader_open(quick_io(), path, &reader, NULL), 0);
    /* In place: the reader has the file open. */
    assert_int_equal(run("printf 7 | dd of='%s/records.jsonl' bs=1 conv=notrunc seek="
                         "$(($(grep -ob '\"index\":1' '%s/records.jsonl' | cut -d: -f1) + 8))",
                         path, path),
                     0);
    assert_int_equal(ttf_reader_slot(reader, 0, &record, NULL), 0);
    ttf_slot_record_free(&record);
    assert_int_equal(ttf_reader_slot(reader, 1, &record, NULL), -TTF_EDAMAGED);
    ttf_reader_close(reader);
}

static void a_fragment_is_told_by_the_reader(void **state)
{
    const char *path = three_slots(state);
    struct ttf_reader *reader;

    assert_int_equal(run("printf '{\"type\":\"sl' >> '%s/records.jsonl'", path), 0);
    assert_int_equal(ttf_reader_open(quick_io(), path, &reader, NULL), 0);
    assert_true(ttf_reader_summary(reader)->unterminated);
    assert_int_equal(ttf_reader_summary(reader)->slots, 3);
    ttf_reader_close(reader);
}

static void sums_that_say_something_else_are_made_anew_from_the_records(void **state)
{
    const char *path = three_slots(state);
    struct ttf_writer *writer;

    /* Another sha256, a line twice, a last line cut off: none of it lists what no record names. */
    static const char *const edits[] = {"s/^./g/;s/^g/0/;2s/^.../fff/", "2p", "$s/tif$/ti/"};
    size_t i;

    for (i = 0; i < TTF_COUNT_OF(edits); i++) {
        assert_int_equal(run("sed -i '%s' '%s/SHA256SUMS'", edits[i], path), 0);
        if (i == 2)
            assert_int_equal(truncate(in(path, "SHA256SUMS"), size_of(in(path, "SHA256SUMS")) - 1),
                             0);
        assert_int_not_equal(run("cd '%s' && sha256sum --strict -c SHA256SUMS && "
                                 "[ $(wc -l < SHA256SUMS) -eq 3 ]",
                                 path),
                             0);
        assert_int_equal(ttf_writer_open(quick_io(), path, &writer, NULL), 0);
        assert_int_equal(ttf_writer_state(writer)->repaired, 1);
        ttf_writer_close(writer);
        assert_int_equal(sha256sum_check(path), 0);
        assert_int_equal(run("[ $(wc -l < '%s/SHA256SUMS') -eq 3 ]", path), 0);
    }
}

static void damage_is_named_among_a_thousand_notes(void **state)
{
    const char *path = three_slots(state);
    struct ttf_writer *writer;

    assert_int_equal(ttf_writer_open(quick_io(), path, &writer, NULL), 0);
    assert_int_equal(ttf_writer_seal(writer, "count", NULL, NULL), 0);
    ttf_writer_close(writer);
    assert_int_equal(run("cd '%s' && seq -f a%%g.txt 1100 | xargs touch", path), 0);
    write_text(in(path, "frames/main/000009.tif"), "added", 5);
    assert_true(verify_says(path, "not covered by the seal"));
}

int main(void)
{
#define T(f) cmocka_unit_test_setup_teardown(f, folder_setup, folder_teardown)
    const struct CMUnitTest tests[] = {
        T(records_that_contradict_each_other_are_damage),
        T(a_segment_that_leaves_another_out_is_refused),
        T(only_the_wrong_line_is_blamed),
        T(an_end_that_counts_wrong_is_damage),
        T(a_calibration_without_a_line_is_damage_though_its_folder_is_there),
        T(one_damaged_plan_does_not_accuse_the_next),
        T(a_seal_that_is_not_in_order_is_damage),
        T(one_changed_path_of_a_seal_accuses_no_other),
        T(a_rehearsal_is_not_sealed),
        T(a_seal_without_an_end_is_damage),
        T(the_seal_does_not_bless_a_frame_that_changed_before_it),
        T(an_end_is_not_added_under_a_seal),
        T(what_was_added_behind_the_seal_is_damage),
        T(a_seal_cut_off_at_its_last_byte_is_damage),
        T(a_file_that_cannot_be_read_is_damage_and_why_is_said),
        T(a_manifest_that_cannot_be_true_is_damage_before_the_seal_too),
        T(missing_records_are_damage_and_none_are_made),
        T(rot_in_the_events_is_refused_too),
        T(a_line_without_end_is_damage),
        T(a_record_that_changes_while_it_is_read_is_not_passed_on),
        T(a_slot_that_another_program_wrote_is_read_like_ours),
        T(a_slot_in_the_wrong_place_is_damage_whoever_wrote_it),
        T(a_slot_that_is_no_json_behind_its_head_is_damage),
        T(flags_are_read_as_far_as_they_are_words),
        T(a_sequence_never_leaves_its_dataset),
        T(a_fragment_is_told_by_the_reader),
        T(sums_that_say_something_else_are_made_anew_from_the_records),
        T(damage_is_named_among_a_thousand_notes),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
