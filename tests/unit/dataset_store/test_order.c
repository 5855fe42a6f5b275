/* SPDX-License-Identifier: Apache-2.0 */
/*
 * In which order things reach the disk (DESIGN.md): what is relied upon is synced first. The
 * machine's file system hides a sync that is lacking; the list of operations does not.
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
#include <sys/stat.h>

#include "store_ios.h"
#include "store_test.h"
#include "ttf/dataset/reader.h"

/* A disk that lists what is done to it. */
struct watched {
    struct cue cue;
    struct ttf_io *io;
    char path[300], log[16384];
};

static int watched_setup(void **state)
{
    struct watched *w = calloc(1, sizeof(*w));
    void *folder = NULL;

    if (!w || folder_setup(&folder) != 0) {
        free(w);
        return -1;
    }
    snprintf(w->path, sizeof(w->path), "%s", (char *)folder);
    free(folder);
    w->cue.log = w->log;
    w->cue.log_room = sizeof(w->log);
    w->io = ttf_io_faulty_create(quick_io(), cue_fault, &w->cue);
    *state = w;
    return w->io ? 0 : -1;
}

static int watched_teardown(void **state)
{
    struct watched *w = *state;
    void *folder = strdup(w->path);

    ttf_io_faulty_destroy(w->io);
    free(w);
    return folder_teardown(&folder);
}

/* From here on. */
static void watch(struct watched *w)
{
    w->cue.log_used = 0;
    w->log[0] = '\0';
}

#define WHOLE(name, folder)                                                                        \
    "unlink " name ".tmp\nopen " name ".tmp\nappend " name ".tmp\nsync " name ".tmp\nrename " name \
    "\nsync_dir " folder "\n"

#define LINE(name) "append " name "\nsync " name "\nappend " name "\n"

static void assert_ends(const char *log, const char *end)
{
    size_t n = strlen(log), m = strlen(end);

    assert_string_equal(n > m ? log + n - m : log, end);
}

static void assert_begins(const char *log, const char *begin)
{
    if (strncmp(log, begin, strlen(begin)) != 0)
        assert_string_equal(log, begin); /* shows both */
}

static void dataset_json_comes_last_when_creating(void **state)
{
    struct watched *w = *state;
    const char *path = in(w->path, "new/d");
    struct ttf_manifest manifest;
    struct ttf_writer *writer;

    small_manifest(&manifest);
    assert_int_equal(
        ttf_writer_create(w->io, path, &manifest, "interval: 10s\n", NULL, &writer, NULL), 0);
    assert_non_null(strstr(w->log, "mkdir new\nsync_dir ttf-store-"));
    assert_non_null(strstr(w->log, "mkdir d\nsync_dir new\n"));
    assert_ends(w->log,
                "mkdir plans\nsync_dir d\n" WHOLE("0.yaml", "plans") WHOLE(
                    "records.jsonl",
                    "d") "unlink events.jsonl.tmp\nopen events.jsonl.tmp\nsync events.jsonl.tmp\n"
                         "rename events.jsonl\nsync_dir d\n"
                         "open .events-reserve\nappend .events-reserve\nappend .events-reserve\n"
                         "append .events-reserve\nappend .events-reserve\nsync .events-reserve\n"
                         "open records.jsonl\nopen events.jsonl\n" WHOLE("dataset.json", "d"));
    ttf_writer_close(writer);
}

/* They may have been made a moment ago, by a shell that syncs nothing. */
static void folders_above_a_new_dataset_that_are_there_are_synced_too(void **state)
{
    struct watched *w = *state;
    const char *of, *lines;
    struct ttf_writer *writer;

    assert_int_equal(mkdir(in(w->path, "of"), 0755), 0);
    assert_int_equal(mkdir(in(w->path, "of/series"), 0755), 0);
    watch(w);
    writer = small_create(w->io, in(w->path, "of/series/d"));
    assert_non_null(strstr(w->log, "sync_dir series\n"));
    assert_non_null(strstr(w->log, "sync_dir ttf-store-"));
    of = strstr(w->log, "sync_dir of\n");
    lines = strstr(w->log, "open records.jsonl.tmp\n");
    assert_true(of && lines && of < lines);
    ttf_writer_close(writer);
}

struct not_ours {
    const char *path;
    int error;
};

static int refuse_to_sync(void *ctx, const char *op, const char *path)
{
    const struct not_ours *n = ctx;

    return strcmp(op, "sync_dir") == 0 && strcmp(path, n->path) == 0 ? n->error : 0;
}

static void a_dataset_below_a_folder_that_is_not_ours_to_sync_is_written_all_the_same(void **state)
{
    static const int errors[] = {EACCES, EPERM, EROFS};
    struct watched *w = *state;

    for (unsigned i = 0; i < sizeof(errors) / sizeof(errors[0]); i++) {
        struct not_ours n = {.path = w->path, .error = errors[i]};
        struct ttf_io *io = ttf_io_faulty_create(quick_io(), refuse_to_sync, &n);
        struct ttf_writer *writer;
        char name[8];

        assert_non_null(io);
        snprintf(name, sizeof(name), "d%u", i);
        assert_int_equal(mkdir(in(w->path, "%s", name), 0755), 0); /* by who may */
        ttf_writer_close(small_create(io, in(w->path, "%s", name)));
        assert_int_equal(ttf_writer_open(io, in(w->path, "%s", name), &writer, NULL), 0);
        ttf_writer_close(writer);
        /* An error of the disk is another matter. */
        n.error = EIO;
        assert_int_equal(ttf_writer_open(io, in(w->path, "%s", name), &writer, NULL), -EIO);
        ttf_io_faulty_destroy(io);
    }
}

static void the_first_image_brings_its_folders_to_the_disk(void **state)
{
    struct watched *w = *state;
    struct ttf_writer *writer = small_create(w->io, in(w->path, "d"));

    watch(w);
    assert_int_equal(small_slot(writer, 0), 0);
    assert_begins(w->log, "mkdir frames\nsync_dir d\nmkdir main\nsync_dir frames\n"
                          "unlink 000000.tif.tmp\nopen 000000.tif.tmp\n");
    ttf_writer_close(writer);
}

static void lines_are_synced_before_their_newline(void **state)
{
    struct watched *w = *state;
    struct ttf_writer *writer = small_create(w->io, in(w->path, "d"));
    struct ttf_segment segment = ttf_writer_state(writer)->last_segment;

    watch(w);
    assert_int_equal(ttf_writer_event(writer, "door", 1, 2, "opened", NULL, NULL), 0);
    assert_string_equal(w->log, LINE("events.jsonl"));
    watch(w);
    segment.segment = 1;
    assert_int_equal(ttf_writer_segment(writer, &segment, NULL), 0);
    assert_string_equal(w->log, LINE("records.jsonl"));
    ttf_writer_close(writer);
}

static void files_of_plans_and_calibrations_come_before_their_line(void **state)
{
    struct watched *w = *state;
    struct ttf_writer *writer = small_create(w->io, in(w->path, "d"));
    const char *cal = in(w->path, "cal");

    assert_int_equal(mkdir(cal, 0777), 0);
    write_text(in(cal, "calibration.json"), "{}\n", 3);
    write_text(in(cal, "dark.tif"), "dark", 4);
    watch(w);
    assert_int_equal(ttf_writer_plan(writer, "interval: 20s\n", "{}\n", NULL), 1);
    assert_string_equal(w->log, "sync_dir d\n" WHOLE("1.yaml", "plans") WHOLE("1.json", "plans")
                                    LINE("records.jsonl"));
    watch(w);
    assert_int_equal(ttf_writer_calibration(writer, "cal-1", cal, NULL), 0);
    assert_string_equal(
        w->log, "mkdir calibration\nsync_dir d\nmkdir cal-1\nsync_dir calibration\n"
                "unlink dark.tif.tmp\nopen dark.tif.tmp\n"
                "append dark.tif.tmp\nsync dark.tif.tmp\nrename dark.tif\n"
                /* last: a folder without it holds no calibration */
                "unlink calibration.json.tmp\nopen calibration.json.tmp\n"
                "append calibration.json.tmp\nsync calibration.json.tmp\nrename calibration.json\n"
                "sync_dir cal-1\n" LINE("records.jsonl"));
    ttf_writer_close(writer);
}

static void both_logs_are_synced_before_the_seal(void **state)
{
    struct watched *w = *state;
    struct ttf_writer *writer = small_create(w->io, in(w->path, "d"));

    assert_int_equal(small_slot(writer, 0), 0);
    watch(w);
    assert_int_equal(ttf_writer_seal(writer, "count", NULL, NULL), 0);
    assert_string_equal(
        w->log,
        LINE("records.jsonl") "sync records.jsonl\nsync events.jsonl\n"
                              /* whatever no record names, so that it is what the seal says */
                              "sync events.jsonl\nsync records.jsonl\n"
                              "sync_dir main\n" WHOLE("SHA256SUMS", "d") "unlink .events-reserve\n"
                                                                         "sync_dir d\n");
    watch(w);
    ttf_writer_close(writer); /* sealed: nothing more */
    assert_string_equal(w->log, "");
}

static void what_is_closed_in_order_is_on_the_disk(void **state)
{
    struct watched *w = *state;
    struct ttf_writer *writer = small_create(w->io, in(w->path, "d"));

    assert_int_equal(small_slot(writer, 0), 0);
    watch(w);
    ttf_writer_close(writer);
    assert_string_equal(w->log,
                        "sync records.jsonl\nsync events.jsonl\nsync SHA256SUMS\nsync_dir d\n");
}

/* ---- the seal goes first ---- */

static int add_segment(struct ttf_writer *writer, const char *cal)
{
    struct ttf_segment segment = ttf_writer_state(writer)->last_segment;

    segment.segment = 1;
    return ttf_writer_segment(writer, &segment, NULL);
}

static int add_plan(struct ttf_writer *writer, const char *cal)
{
    return ttf_writer_plan(writer, "interval: 20s\n", NULL, NULL) > 0 ? 0 : -1;
}

static int add_calibration(struct ttf_writer *writer, const char *cal)
{
    return ttf_writer_calibration(writer, "cal-1", cal, NULL);
}

static int add_event(struct ttf_writer *writer, const char *cal)
{
    return ttf_writer_event(writer, "door", 1, 2, "opened", NULL, NULL);
}

static int add_slot_with_file(struct ttf_writer *writer, const char *cal)
{
    return small_slot(writer, 1);
}

static int add_slot_without_files(struct ttf_writer *writer, const char *cal)
{
    struct ttf_slot_record record;

    ttf_slot_record_init(&record);
    record.index = 1;
    record.result = TTF_RESULT_MISSED;
    strcpy(record.reason, "storage too slow");
    return ttf_writer_commit(writer, &record, NULL);
}

static int (*const additions[])(struct ttf_writer *, const char *) = {
    add_segment, add_plan, add_calibration, add_event, add_slot_with_file, add_slot_without_files,
};

/* Whatever is written first to a sealed dataset, opened anew or not. */
static void the_seal_is_gone_from_the_disk_before_anything_else_changes(void **state)
{
    struct watched *w = *state;
    const char *cal = in(w->path, "cal");
    struct ttf_writer *writer;
    char path[320];
    size_t i;

    assert_int_equal(mkdir(cal, 0777), 0);
    write_text(in(cal, "calibration.json"), "{}\n", 3);
    for (i = 0; i < 2 * TTF_COUNT_OF(additions); i++) {
        snprintf(path, sizeof(path), "%s/d%zu", w->path, i);
        writer = small_create(w->io, path);
        assert_int_equal(small_slot(writer, 0), 0);
        assert_int_equal(ttf_writer_seal(writer, "count", NULL, NULL), 0);
        if (i % 2) {
            ttf_writer_close(writer);
            watch(w);
            assert_int_equal(ttf_writer_open(w->io, path, &writer, NULL), 0);
            assert_string_equal(w->log, "open records.jsonl\nopen events.jsonl\n");
        }
        watch(w);
        assert_int_equal(additions[i / 2](writer, cal), 0);
        assert_begins(w->log, "unlink SHA256SUMS.tmp\nopen SHA256SUMS.tmp\n"
                              "append SHA256SUMS.tmp\nsync SHA256SUMS.tmp\n"
                              "rename SHA256SUMS\nsync_dir d");
        assert_false(ttf_writer_state(writer)->sealed);
        ttf_writer_close(writer);
    }
}

static void the_seal_of_a_dataset_without_images_is_removed_first(void **state)
{
    struct watched *w = *state;
    struct ttf_writer *writer = small_create(w->io, in(w->path, "d"));

    assert_int_equal(ttf_writer_seal(writer, "stopped", NULL, NULL), 0);
    watch(w);
    assert_int_equal(small_slot(writer, 0), 0);
    assert_begins(w->log, "unlink SHA256SUMS.tmp\nopen SHA256SUMS.tmp\nunlink SHA256SUMS\n"
                          "sync_dir d\n");
    ttf_writer_close(writer);
}

static void a_seal_that_cannot_be_removed_stops_what_wanted_to_write(void **state)
{
    struct watched *w = *state;
    const char *path = in(w->path, "d");
    struct ttf_writer *writer = small_create(w->io, path);
    struct ttf_reader *reader;
    size_t i;

    assert_int_equal(small_slot(writer, 0), 0);
    assert_int_equal(ttf_writer_seal(writer, "count", NULL, NULL), 0);
    w->cue.op = "rename";
    w->cue.in = "SHA256SUMS";
    w->cue.for_ever = true;
    w->cue.error = EIO;
    w->cue.at = 1;
    w->cue.n = 0;
    for (i = 0; i < TTF_COUNT_OF(additions); i++)
        if (additions[i] != add_calibration)
            assert_int_not_equal(additions[i](writer, NULL), 0);
    ttf_writer_close(writer);
    assert_int_equal(sha256sum_check(path), 0);
    assert_int_equal(ttf_reader_open(quick_io(), path, &reader, NULL), 0);
    assert_true(ttf_reader_summary(reader)->sealed && ttf_reader_summary(reader)->ended);
    ttf_reader_close(reader);
}

/* ---- repairs ---- */

static void a_fragment_is_kept_as_an_event_before_it_is_cut_off(void **state)
{
    struct watched *w = *state;
    const char *path = in(w->path, "d");
    struct ttf_writer *writer = small_create(w->io, path);

    assert_int_equal(small_slot(writer, 0), 0);
    ttf_writer_close(writer);
    assert_int_equal(run("printf '{\"type\":\"sl' >> '%s/records.jsonl'", path), 0);
    watch(w);
    assert_int_equal(ttf_writer_open(w->io, path, &writer, NULL), 0);
    assert_begins(w->log, "open records.jsonl\nopen events.jsonl\nsync_dir ttf-store-");
    assert_non_null(strstr(
        w->log,
        "\nsync_dir d\n" LINE("events.jsonl") "truncate records.jsonl\nsync records.jsonl\n"));
    ttf_writer_close(writer);
}

/* Fails the first sync of records.jsonl, and lists everything. */
static int first_sync_fails(void *ctx, const char *op, const char *path)
{
    struct cue *cue = ctx;
    const char *name = strrchr(path, '/');

    (void)cue_fault(ctx, op, path);
    if (strcmp(op, "sync") != 0 || strcmp(name, "/records.jsonl") != 0 || cue->at == 0)
        return 0;
    cue->at = 0;
    return EIO;
}

static void order_of_writing_anew(void **state)
{
    struct watched *w = *state;
    struct ttf_io *io = ttf_io_faulty_create(quick_io(), first_sync_fails, &w->cue);
    const char *path = in(w->path, "d");
    struct ttf_writer *writer = small_create(io, path);

    watch(w);
    w->cue.at = -1; /* from here on */
    assert_int_equal(add_slot_without_files(writer, NULL), 0);
    assert_string_equal(w->log, "append records.jsonl\nsync records.jsonl\n"
                                "unlink records.jsonl.tmp\nopen records.jsonl.tmp\n"
                                "append records.jsonl.tmp\nappend records.jsonl.tmp\n"
                                "sync records.jsonl.tmp\nrename records.jsonl\nsync_dir d\n"
                                "append records.jsonl.tmp\n"); /* the handle it was opened by */
    ttf_writer_close(writer);
    ttf_io_faulty_destroy(io);
}

static void order_of_an_event_on_a_full_disk(void **state)
{
    struct watched *w = *state;
    struct ttf_writer *writer = small_create(w->io, in(w->path, "d"));

    watch(w);
    w->cue.n = 0;
    w->cue.at = 1;
    w->cue.error = ENOSPC;
    assert_int_equal(ttf_writer_event(writer, "disk", 1, 2, "full", NULL, NULL), 0);
    assert_string_equal(w->log, "append events.jsonl\ntruncate events.jsonl\n"
                                "open .events-reserve\ntruncate .events-reserve\n"
                                "sync .events-reserve\n" LINE("events.jsonl"));
    ttf_writer_close(writer);
}

int main(void)
{
#define T(f) cmocka_unit_test_setup_teardown(f, watched_setup, watched_teardown)
    const struct CMUnitTest tests[] = {
        T(dataset_json_comes_last_when_creating),
        T(folders_above_a_new_dataset_that_are_there_are_synced_too),
        T(a_dataset_below_a_folder_that_is_not_ours_to_sync_is_written_all_the_same),
        T(the_first_image_brings_its_folders_to_the_disk),
        T(lines_are_synced_before_their_newline),
        T(files_of_plans_and_calibrations_come_before_their_line),
        T(both_logs_are_synced_before_the_seal),
        T(what_is_closed_in_order_is_on_the_disk),
        T(the_seal_is_gone_from_the_disk_before_anything_else_changes),
        T(the_seal_of_a_dataset_without_images_is_removed_first),
        T(a_seal_that_cannot_be_removed_stops_what_wanted_to_write),
        T(a_fragment_is_kept_as_an_event_before_it_is_cut_off),
        T(order_of_writing_anew),
        T(order_of_an_event_on_a_full_disk),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
