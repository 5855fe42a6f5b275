/* SPDX-License-Identifier: Apache-2.0 */
/* Each allocation of those who look at, repair and change a dataset fails once (README.md). */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "each_allocation.h"
#include "model_disk.h"
#include "ttf/dataset/json_parse.h"
#include "ttf/dataset/notes.h"
#include "ttf/dataset/reader.h"
#include "ttf/dataset/samples.h"
#include "ttf/dataset/sequence.h"
#include "ttf/dataset/verify.h"
#include "unit/dataset_store/rich_dataset.h"
#include "unit/dataset_store/store_test.h"

#define PLACE "/m/d"

static struct alloc_run run_of_all; /* set once, by main */

/* ---- who looks at a dataset: on the machine's own disk ---- */

static char folder[] = "/tmp/ttf-alloc-XXXXXX";
static struct ttf_io *posix;
static const char *looked_at;

static int read_all(struct ttf_reader *reader, struct ttf_err *err)
{
    struct ttf_slot_record record;
    struct ttf_segment segment;
    int r = 0;

    for (int64_t i = 0; r == 0 && i < ttf_reader_summary(reader)->slots; i++) {
        r = ttf_reader_slot(reader, i, &record, err);
        if (r == 0) {
            (void)ttf_reader_due_utc_ns(reader, &record);
            ttf_slot_record_free(&record);
        }
    }
    return r ? r : ttf_reader_segment(reader, 2, &segment);
}

static int work_read(struct ttf_err *err)
{
    struct ttf_reader *reader;
    int r = ttf_reader_open(posix, looked_at, &reader, err);

    if (r)
        return r;
    assert_int_equal(ttf_reader_summary(reader)->slots, RICH_SLOTS);
    r = read_all(reader, err);
    ttf_reader_close(reader);
    return r;
}

static int work_digest(struct ttf_err *err)
{
    struct ttf_reader *reader;
    char digest[65];
    int r = ttf_reader_open(posix, looked_at, &reader, err);

    if (r)
        return r;
    r = ttf_reader_digest(reader, digest, err);
    ttf_reader_close(reader);
    return r;
}

/* No memory is no damage. */
static int work_verify(struct ttf_err *err)
{
    struct ttf_verify_options options = {.deep = true};
    struct ttf_verify_report report;
    int r = ttf_verify(posix, looked_at, &options, &report, err);

    if (r)
        return r;
    assert_false(report.damaged);
    assert_true(report.files > 70);
    ttf_verify_report_free(&report);
    return 0;
}

static int work_sequence(struct ttf_err *err)
{
    const struct ttf_sequence_choice choice = {.stream = "top"};
    struct ttf_sequence *sequence = NULL;
    struct ttf_reader *reader;
    uint16_t rows[8 * 6 * 3];
    int r = ttf_reader_open(posix, looked_at, &reader, err);

    if (r)
        return r;
    r = ttf_sequence_of_dataset(reader, &choice, &sequence, err);
    if (r == 0) /* a note leaves three of them out */
        assert_int_equal(sequence->n, RICH_SLOTS - 2 - 3);
    for (uint32_t t = 0; r == 0 && t < sequence->n; t++)
        r = ttf_sequence_read_rows(sequence, t, 0, sequence->height, rows, err);
    ttf_sequence_destroy(sequence);
    ttf_reader_close(reader);
    return r;
}

static void looking_says_that_there_was_no_memory(void **state)
{
    static const struct alloc_piece pieces[] = {
        {.name = "reading", .work = work_read, .share_of_all = 397},
        {.name = "digest", .work = work_digest, .share_of_all = 397},
        {.name = "verifying", .work = work_verify, .share = 7, .share_of_all = 797},
        {.name = "a sequence", .work = work_sequence, .ours_only = true},
    };

    looked_at = in(folder, "sealed");
    for (unsigned i = 0; i < sizeof(pieces) / sizeof(pieces[0]); i++)
        each_allocation_fails(&pieces[i], run_of_all);
    looked_at = in(folder, "cut");
    each_allocation_fails(&pieces[0], run_of_all);
    each_allocation_fails(&pieces[2], run_of_all);
}

/* ---- who repairs and changes one: on a disk in memory ---- */

static struct model_disk sealed, cut, disk;

static void begin_sealed(void)
{
    model_disk_copy(&disk, &sealed);
}

static void begin_cut(void)
{
    model_disk_copy(&disk, &cut);
}

/* Whatever came of it, nothing is lost. */
static void end_whole(int r)
{
    struct ttf_verify_options options = {.deep = true};
    struct ttf_verify_report report;

    assert_int_equal(model_disk_open_handles(&disk), 0);
    assert_int_equal(ttf_verify(&disk.io, PLACE, &options, &report, NULL), 0);
    assert_false(report.damaged);
    assert_int_equal(report.slots, RICH_SLOTS);
    ttf_verify_report_free(&report);
    model_disk_free(&disk);
}

static int work_open(struct ttf_err *err)
{
    struct ttf_writer *writer;
    int r = ttf_writer_open(&disk.io, PLACE, &writer, err);

    if (r == 0)
        ttf_writer_close(writer);
    return r;
}

static int work_open_anew(struct ttf_err *err)
{
    struct ttf_writer *writer;
    bool doubt = true;
    int r = ttf_writer_open_anew(&disk.io, PLACE, NULL, &doubt, &writer, err);

    if (r == 0)
        ttf_writer_close(writer);
    return r;
}

/* One thing more, which takes the seal away. */
static int add(int (*what)(struct ttf_writer *writer, struct ttf_err *err), struct ttf_err *err)
{
    struct ttf_writer *writer;
    int r = ttf_writer_open(&disk.io, PLACE, &writer, err);

    if (r)
        return r;
    r = what(writer, err);
    ttf_writer_close(writer);
    return r;
}

static int an_event(struct ttf_writer *writer, struct ttf_err *err)
{
    return ttf_writer_event(writer, "door", 1, 2, "opened", "{\"a\": {\"b\": [1, 2.5]}}", err);
}

static int a_seal(struct ttf_writer *writer, struct ttf_err *err)
{
    return ttf_writer_seal(writer, "stopped", NULL, err);
}

static int work_event(struct ttf_err *err)
{
    return add(an_event, err);
}

static int work_seal(struct ttf_err *err)
{
    return add(a_seal, err);
}

static int work_note(struct ttf_err *err)
{
    static const struct ttf_note note = {
        .utc_ns = 1, .text = "a fly", .n_tags = 1, .tags = {"exclude"}};

    return ttf_note_append(&disk.io, PLACE, &note, err);
}

/* The second of two that are asked for, so that what is there is read. */
static int work_sample(struct ttf_err *err)
{
    static const struct ttf_sample_rect dot = {.width = 1, .height = 1};
    static const struct ttf_sample_change changes[] = {
        {.id = "one", .title = "grass", .region = &dot}, {.id = "two", .region = &dot}};

    for (unsigned i = 0; i < 2; i++) {
        int r = ttf_samples_change(&disk.io, PLACE, &changes[i], 1, err);

        if (r)
            return r;
    }
    return 0;
}

static void what_could_not_be_done_without_memory_leaves_all_as_it_was(void **state)
{
    /* What closing cannot do, the next opening does. */
    static const struct alloc_piece pieces[] = {
        {.name = "opening after a cut",
         .begin = begin_cut,
         .work = work_open,
         .end = end_whole,
         .may_do_without = true,
         .share = 7,
         .share_of_all = 797},
        {.name = "opening anew, in doubt",
         .begin = begin_cut,
         .work = work_open_anew,
         .end = end_whole,
         .may_do_without = true,
         .share = 7,
         .share_of_all = 797},
        {.name = "opening what is sealed",
         .begin = begin_sealed,
         .work = work_open,
         .end = end_whole,
         .may_do_without = true,
         .share = 7,
         .share_of_all = 797},
        {.name = "an event, of a sealed one",
         .begin = begin_sealed,
         .work = work_event,
         .end = end_whole,
         .may_do_without = true,
         .share = 7,
         .share_of_all = 797},
        {.name = "sealing after a cut",
         .begin = begin_cut,
         .work = work_seal,
         .end = end_whole,
         .may_do_without = true,
         .share = 7,
         .share_of_all = 797},
        {.name = "a note", .begin = begin_sealed, .work = work_note, .end = end_whole},
        {.name = "samples", .begin = begin_sealed, .work = work_sample, .end = end_whole},
    };

    for (unsigned i = 0; i < sizeof(pieces) / sizeof(pieces[0]); i++)
        each_allocation_fails(&pieces[i], run_of_all);
}

/* ---- JSON ---- */

#define LONG_TEXT 700

/* Long texts with all that has to be copied piece by piece; numbers, and containers that grow. */
static int work_json(struct ttf_err *err)
{
    static const char piece[] = "a\\n\\u00e9\\\"\\\\", back[] = "a\n\xc3\xa9\"\\";
    char text[4 * LONG_TEXT], expected[LONG_TEXT * 2] = "";
    size_t n = (size_t)snprintf(text, sizeof(text), "{\"list\":[null,null,null,1.25,");
    size_t m = 0;
    json_t *json = NULL;
    int r;

    for (unsigned i = 0; i < 24; i++)
        n += (size_t)snprintf(text + n, sizeof(text) - n, "{\"n\":%u},", 1000000000u + i);
    n += (size_t)snprintf(text + n, sizeof(text) - n, "1],\"text\":\"");
    for (unsigned i = 0; i < LONG_TEXT / sizeof(piece); i++) {
        n += (size_t)snprintf(text + n, sizeof(text) - n, "%s", piece);
        m += (size_t)snprintf(expected + m, sizeof(expected) - m, "%s", back);
    }
    n += (size_t)snprintf(text + n, sizeof(text) - n, "\"}");
    r = ttf_json_parse(text, n, &json, NULL);
    if (r < 0)
        return ttf_err_set(err, r, "json", "cannot be parsed");
    assert_string_equal(json_string_value(json_object_get(json, "text")), expected);
    assert_int_equal(json_array_size(json_object_get(json, "list")), 29);
    json_decref(json);
    return 0;
}

static void a_text_that_finds_no_memory_harms_nothing(void **state)
{
    static const struct alloc_piece piece = {.name = "JSON with long texts", .work = work_json};

    (void)state;
    each_allocation_fails(&piece, run_of_all);
}

/* ---- */

/* A piece of a line behind each log, and files of a slot under way; its list lacks the last lines. */
static void cut_more(struct model_disk *to)
{
    static const char piece[] = "{\"type\":\"slot\",\"seq\":99,\"ind";
    struct ttf_io *io = &to->io;
    int file = io->ops->open(io, PLACE "/records.jsonl", TTF_IO_APPEND);

    assert_true(file >= 0);
    assert_int_equal(ttf_io_append_all(io, file, piece, sizeof(piece) - 1), 0);
    assert_int_equal(io->ops->close(io, file), 0);
    file = io->ops->open(io, PLACE "/events.jsonl", TTF_IO_APPEND);
    assert_true(file >= 0);
    assert_int_equal(ttf_io_append_all(io, file, piece, sizeof(piece) - 1), 0);
    assert_int_equal(io->ops->close(io, file), 0);
    assert_int_equal(io->ops->unlink(io, PLACE "/SHA256SUMS"), 0);
}

static int make(void **state)
{
    char path[100];

    posix = ttf_io_posix();
    if (!mkdtemp(folder))
        return -1;
    snprintf(path, sizeof(path), "%s/sealed", folder);
    rich_build(posix, path, RICH_SEALED);
    model_disk_init(&sealed);
    model_disk_take(&sealed, path, PLACE);
    snprintf(path, sizeof(path), "%s/cut", folder);
    rich_build(posix, path, RICH_CUT);
    model_disk_init(&cut);
    model_disk_take(&cut, path, PLACE);
    cut_more(&cut);
    return 0;
}

static int clear(void **state)
{
    model_disk_free(&cut);
    model_disk_free(&sealed);
    return run("rm -rf '%s'", folder);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(looking_says_that_there_was_no_memory),
        cmocka_unit_test(what_could_not_be_done_without_memory_leaves_all_as_it_was),
        cmocka_unit_test(a_text_that_finds_no_memory_harms_nothing),
    };

    run_of_all = alloc_run_of(argc, argv);
    return cmocka_run_group_tests(tests, make, clear);
}
