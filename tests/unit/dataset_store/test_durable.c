/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What is seen is not what is on the disk: a writer that was killed, or told an
 * error, leaves names that were never synced. Found by tests/crash.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "store_ios.h"
#include "store_test.h"
#include "ttf/dataset/verify.h"

/* A dataset and a disk that writes down what it is told to do. */
struct watched {
    const char *path;
    char log[4096];
    struct cue cue;
    struct ttf_io *io;
};

static void watch(struct watched *w, void **state)
{
    memset(w, 0, sizeof(*w));
    w->path = in(*state, "d");
    ttf_writer_abandon(small_create(quick_io(), w->path));
    w->cue = (struct cue){.log = w->log, .log_room = sizeof(w->log)};
    w->io = ttf_io_faulty_create(quick_io(), cue_fault, &w->cue);
    assert_non_null(w->io);
}

/* Each was done, in this order, before `last` was. */
static void assert_order(const char *log, const char *const *wanted, const char *last)
{
    const char *at = log, *end = strstr(log, last);

    if (!end) {
        fail_msg("no %s in:\n%s", last, log);
        return;
    }
    for (; *wanted; wanted++) {
        const char *found = strstr(at, *wanted);

        at = found ? found : end;
        if (!found || found > end)
            fail_msg("no %s before %s, or out of order, in:\n%s", *wanted, last, log);
    }
}

static void folders_that_a_killed_writer_made_get_their_names_synced(void **state)
{
    static const char *const wanted[] = {"sync_dir d\n", "sync_dir frames\n", "sync_dir main\n",
                                         NULL};
    struct ttf_writer *writer;
    struct watched w;

    watch(&w, state);
    assert_int_equal(run("mkdir -p '%s/frames/main'", w.path), 0); /* and then it was killed */
    assert_int_equal(ttf_writer_open(w.io, w.path, &writer, NULL), 0);
    w.log[w.cue.log_used = 0] = '\0';
    assert_int_equal(small_slot(writer, 0), 0);
    assert_order(w.log, wanted, "append records.jsonl\n");
    w.log[w.cue.log_used = 0] = '\0';
    assert_int_equal(small_slot(writer, 1), 0); /* once is enough */
    assert_null(strstr(w.log, "sync_dir frames\n"));
    ttf_writer_abandon(writer);
    ttf_io_faulty_destroy(w.io);
}

static void a_line_that_a_killed_writer_left_is_synced_before_its_newline(void **state)
{
    static const char *const wanted[] = {"sync events.jsonl\n", "sync records.jsonl\n",
                                         "append records.jsonl\n", NULL};
    struct ttf_writer *writer;
    struct watched w;

    watch(&w, state);
    assert_int_equal(ttf_writer_open(quick_io(), w.path, &writer, NULL), 0);
    assert_int_equal(ttf_writer_event(writer, "door", 1, 1, "moved", NULL, NULL), 0);
    ttf_writer_abandon(writer);
    /* It died between writing a line and syncing it: the line is seen, and on no disk. */
    assert_int_equal(run("truncate -s -1 '%s/records.jsonl'", w.path), 0);
    assert_int_equal(run("truncate -s -1 '%s/events.jsonl'", w.path), 0);
    assert_int_equal(ttf_writer_open(w.io, w.path, &writer, NULL), 0);
    assert_order(w.log, wanted, "append events.jsonl\n");
    ttf_writer_abandon(writer);
    ttf_io_faulty_destroy(w.io);
}

static void a_seal_that_failed_is_removed_before_anything_else_is_written(void **state)
{
    static const char *const wanted[] = {"rename SHA256SUMS\n", "append records.jsonl\n", NULL};
    struct ttf_verify_options options = {.deep = true};
    struct ttf_verify_report report;
    struct ttf_writer *writer;
    struct watched w;

    watch(&w, state);
    assert_int_equal(ttf_writer_open(w.io, w.path, &writer, NULL), 0);
    assert_int_equal(small_slot(writer, 0), 0);
    w.cue.op = "sync_dir";
    w.cue.error = EIO;
    w.cue.n = 0;
    w.cue.at = 2; /* the stream's folder is the first, that of SHA256SUMS the second */
    assert_int_equal(ttf_writer_seal(writer, "count", NULL, NULL), -EIO);
    assert_int_equal(run("grep -q records.jsonl '%s/SHA256SUMS'", w.path), 0); /* it is seen */
    w.cue.op = NULL;
    w.cue.at = 0;
    w.log[w.cue.log_used = 0] = '\0';
    assert_int_equal(small_slot(writer, 1), 0);
    assert_order(w.log, wanted, "append SHA256SUMS\n");
    ttf_writer_abandon(writer);
    assert_int_equal(ttf_verify(quick_io(), w.path, &options, &report, NULL), 0);
    assert_false(report.damaged);
    ttf_verify_report_free(&report);
    ttf_io_faulty_destroy(w.io);
}

static void a_folder_whose_sync_failed_is_synced_by_the_next_slot(void **state)
{
    static const char *const wanted[] = {"sync_dir d\n", "sync_dir frames\n", NULL};
    struct ttf_writer *writer;
    struct watched w;

    watch(&w, state);
    assert_int_equal(ttf_writer_open(w.io, w.path, &writer, NULL), 0);
    w.cue.op = "sync_dir";
    w.cue.n = 0;
    w.cue.at = 1;
    w.cue.error = EIO;
    assert_int_equal(small_slot(writer, 0), -EIO);
    w.cue.op = NULL;
    w.cue.at = 0;
    w.log[w.cue.log_used = 0] = '\0';
    assert_int_equal(small_slot(writer, 0), 0);
    assert_order(w.log, wanted, "append records.jsonl\n");
    ttf_writer_abandon(writer);
    ttf_io_faulty_destroy(w.io);
}

static void a_dataset_that_is_opened_stays_where_it_was_seen(void **state)
{
    struct ttf_writer *writer;
    struct watched w;
    char parent[100];

    watch(&w, state);
    snprintf(parent, sizeof(parent), "sync_dir %s\n", strrchr((char *)*state, '/') + 1);
    assert_int_equal(ttf_writer_open(w.io, w.path, &writer, NULL), 0);
    assert_order(w.log, (const char *const[]){parent, NULL}, "sync_dir d\n");
    ttf_writer_abandon(writer);
    /* Its folder was made by a creation that was killed. */
    assert_int_equal(run("rm -r '%s' && mkdir '%s'", w.path, w.path), 0);
    w.log[w.cue.log_used = 0] = '\0';
    writer = small_create(w.io, w.path);
    assert_non_null(writer);
    assert_order(w.log, (const char *const[]){parent, NULL}, "rename dataset.json\n");
    ttf_writer_abandon(writer);
    ttf_io_faulty_destroy(w.io);
}

static void a_seal_vouches_only_for_what_is_on_the_disk(void **state)
{
    static const char *const wanted[] = {"sync calibration.json\n", "sync_dir calibration\n",
                                         "sync_dir c1\n", NULL};
    struct ttf_writer *writer;
    struct watched w;

    watch(&w, state);
    /* Left by a copy that stopped at the second file: renamed, its folder not yet synced. */
    assert_int_equal(
        run("mkdir -p '%s/calibration/c1' && echo {} >'%s/calibration/c1/calibration.json'", w.path,
            w.path),
        0);
    assert_int_equal(ttf_writer_open(w.io, w.path, &writer, NULL), 0);
    w.log[w.cue.log_used = 0] = '\0';
    assert_int_equal(ttf_writer_seal(writer, "count", NULL, NULL), 0);
    assert_order(w.log, wanted, "rename SHA256SUMS\n");
    ttf_writer_close(writer);
    ttf_io_faulty_destroy(w.io);
}

static void what_the_repair_removes_stays_removed(void **state)
{
    static const char *const wanted[] = {"unlink 000000.tif.tmp\n", "sync_dir main\n",
                                         "unlink 000000.tif\n", "sync_dir main\n", NULL};
    struct ttf_writer *writer;
    struct watched w;

    watch(&w, state);
    assert_int_equal(run("mkdir -p '%s/frames/main' && cd '%s/frames/main' && "
                         "echo a >000000.tif && echo b >000000.tif.tmp",
                         w.path, w.path),
                     0);
    assert_int_equal(ttf_writer_open(w.io, w.path, &writer, NULL), 0);
    assert_order(w.log, wanted, "append events.jsonl\n"); /* which says that it was removed */
    ttf_writer_abandon(writer);
    ttf_io_faulty_destroy(w.io);
}

/* Of a log that was written anew when the dataset was sealed once more, and the power went. */
static void what_sealing_again_left_goes_with_the_seal(void **state)
{
    static const char *const wanted[] = {"unlink records.jsonl.tmp\n", "unlink events.jsonl.tmp\n",
                                         "sync_dir d\n", NULL};
    struct ttf_writer *writer;
    struct watched w;

    watch(&w, state);
    assert_int_equal(ttf_writer_open(w.io, w.path, &writer, NULL), 0);
    assert_int_equal(ttf_writer_seal(writer, "count", NULL, NULL), 0);
    ttf_writer_close(writer);
    assert_int_equal(
        run("echo a >'%s/records.jsonl.tmp' && echo b >'%s/events.jsonl.tmp'", w.path, w.path), 0);
    w.log[w.cue.log_used = 0] = '\0';
    assert_int_equal(ttf_writer_open(w.io, w.path, &writer, NULL), 0);
    assert_null(strstr(w.log, "unlink")); /* only looked at */
    assert_int_equal(small_slot(writer, 0), 0);
    assert_order(w.log, wanted, "rename 000000.tif\n");
    ttf_writer_close(writer);
    ttf_io_faulty_destroy(w.io);
}

static void a_log_whose_sync_fails_on_closing_is_written_as_a_new_file(void **state)
{
    static const char *const wanted[] = {"sync records.jsonl.tmp\n", "rename records.jsonl\n",
                                         NULL};
    struct ttf_writer *writer;
    struct watched w;

    watch(&w, state);
    assert_int_equal(ttf_writer_open(w.io, w.path, &writer, NULL), 0);
    assert_int_equal(small_slot(writer, 0), 0);
    w.log[w.cue.log_used = 0] = '\0';
    w.cue.n = 0;
    w.cue.at = 1; /* what was dirty is lost, and seen all the same */
    w.cue.error = EIO;
    ttf_writer_close(writer);
    assert_order(w.log, wanted, "sync_dir d\n");
    ttf_io_faulty_destroy(w.io);
    assert_int_equal(small_check(quick_io(), w.path), 1);
}

static int gone(struct ttf_io *io, const char *path, struct ttf_io_stat *ret)
{
    if (strstr(path, ".tif"))
        return -EIO;
    return ttf_io_posix()->ops->stat(ttf_io_posix(), path, ret);
}

static void a_disk_that_answers_nothing_ends_the_search_for_a_name(void **state)
{
    struct ttf_io_ops ops = *quick_io()->ops;
    struct ttf_io io = {.ops = &ops};
    struct ttf_writer *writer = small_create(&io, in(*state, "d"));

    ops.stat = gone; /* the card was pulled */
    (void)alarm(20);
    assert_int_equal(small_slot(writer, 0), -EIO);
    (void)alarm(0);
    ttf_writer_abandon(writer);
}

int main(void)
{
#define T(f) cmocka_unit_test_setup_teardown(f, folder_setup, folder_teardown)
    const struct CMUnitTest tests[] = {
        T(folders_that_a_killed_writer_made_get_their_names_synced),
        T(a_line_that_a_killed_writer_left_is_synced_before_its_newline),
        T(a_seal_that_failed_is_removed_before_anything_else_is_written),
        T(a_folder_whose_sync_failed_is_synced_by_the_next_slot),
        T(a_dataset_that_is_opened_stays_where_it_was_seen),
        T(a_seal_vouches_only_for_what_is_on_the_disk),
        T(what_the_repair_removes_stays_removed),
        T(what_sealing_again_left_goes_with_the_seal),
        T(a_log_whose_sync_fails_on_closing_is_written_as_a_new_file),
        T(a_disk_that_answers_nothing_ends_the_search_for_a_name),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
