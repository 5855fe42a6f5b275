/* SPDX-License-Identifier: Apache-2.0 */
/* Notes: what was acknowledged stays, whoever else writes, and whatever failed before (DESIGN.md, "Notes"). */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "store_ios.h"
#include "store_test.h"
#include "ttf/base/time.h"
#include "ttf/dataset/notes.h"

/* A dataset, and a disk that lists what is done to it and fails on cue. */
struct noted {
    const char *path;
    char log[4096];
    struct cue cue;
    struct ttf_io *io;
    bool meddles; /* somebody's tool appends a line just before the new file is synced */
};

static int fault(void *ctx, const char *op, const char *path)
{
    struct noted *n = ctx;

    if (n->meddles && strcmp(op, "sync") == 0) {
        n->meddles = false;
        assert_int_equal(run("echo '{\"text\":\"by hand\"}' >> '%s/notes.jsonl'", n->path), 0);
    }
    return cue_fault(&n->cue, op, path);
}

static void begin(struct noted *n, void **state)
{
    memset(n, 0, sizeof(*n));
    n->path = in(*state, "d");
    ttf_writer_close(small_create(quick_io(), n->path));
    n->cue = (struct cue){.log = n->log, .log_room = sizeof(n->log)};
    n->io = ttf_io_faulty_create(quick_io(), fault, n);
    assert_non_null(n->io);
}

static int add(struct noted *n, const char *text)
{
    struct ttf_note note = {.utc_ns = TTF_NS_UNKNOWN};

    snprintf(note.text, sizeof(note.text), "%s", text);
    return ttf_note_append(n->io, n->path, &note, NULL);
}

static void expect(struct noted *n, const char *wanted)
{
    char *text = file_text(in(n->path, "notes.jsonl"), NULL);

    assert_string_equal(text, wanted);
    free(text);
    assert_false(exists(in(n->path, ".notes-new")));
    ttf_io_faulty_destroy(n->io);
}

static void a_note_is_on_the_disk_before_it_takes_its_name(void **state)
{
    struct noted n;

    begin(&n, state);
    assert_int_equal(add(&n, "one"), 0);
    n.log[n.cue.log_used = 0] = '\0';
    assert_int_equal(add(&n, "two"), 0);
    assert_string_equal(n.log, "unlink .notes-new\nopen .notes-new\nappend .notes-new\nappend "
                               ".notes-new\nappend .notes-new\nsync .notes-new\nrename "
                               "notes.jsonl\nsync_dir d\n");
    expect(&n, "{\"text\":\"one\"}\n{\"text\":\"two\"}\n");
}

/* Not behind bytes, nor under a name, of which nobody knows whether they are on the disk. */
static void a_note_after_one_whose_sync_failed_stands_on_nothing_of_it(void **state)
{
    static const char *const syncs[] = {"sync", "sync_dir"};

    for (unsigned i = 0; i < 2; i++) {
        struct noted n;

        begin(&n, state);
        assert_int_equal(add(&n, "one"), 0);
        n.cue.op = syncs[i];
        n.cue.error = EIO;
        n.cue.n = 0;
        n.cue.at = 1;
        assert_int_equal(add(&n, "two"), -EIO);
        n.cue.op = NULL;
        n.cue.at = 0;
        n.log[n.cue.log_used = 0] = '\0';
        assert_int_equal(add(&n, "three"), 0);
        assert_non_null(strstr(n.log, "sync .notes-new\nrename notes.jsonl\nsync_dir d\n"));
        assert_null(strstr(n.log, "append notes.jsonl"));
        expect(&n, i ? "{\"text\":\"one\"}\n{\"text\":\"two\"}\n{\"text\":\"three\"}\n"
                     : "{\"text\":\"one\"}\n{\"text\":\"three\"}\n");
        assert_int_equal(run("rm -r '%s'", n.path), 0);
    }
}

static void a_note_that_fails_leaves_those_before_it(void **state)
{
    struct noted n;
    int r = -ENOSPC;

    begin(&n, state);
    assert_int_equal(add(&n, "one"), 0);
    n.cue.error = ENOSPC;
    for (n.cue.at = 1; r; n.cue.at++) {
        char *text;

        n.cue.n = 0;
        r = add(&n, "two");
        text = file_text(in(n.path, "notes.jsonl"), NULL);
        assert_int_equal(strncmp(text, "{\"text\":\"one\"}\n", 15), 0);
        free(text);
        assert_true(r == 0 || r == -ENOSPC);
    }
    assert_true(n.cue.at > 8);
    ttf_io_faulty_destroy(n.io);
}

static void a_line_that_somebody_left_unfinished_is_ended_first(void **state)
{
    struct noted n;

    begin(&n, state);
    write_text(in(n.path, "notes.jsonl"), "{\"text\":\"to", 11);
    write_text(in(n.path, ".notes-new"), "{\"text\":\"cut", 12); /* of one that was cut off */
    assert_int_equal(add(&n, "two"), 0);
    expect(&n, "{\"text\":\"to\n{\"text\":\"two\"}\n");
}

static void only_one_adds_a_note_at_a_time(void **state)
{
    struct ttf_io *io = quick_io();
    struct ttf_writer *writer;
    struct noted n;
    int file;

    begin(&n, state);
    file = io->ops->open(io, in(n.path, "dataset.json"), TTF_IO_READ);
    assert_true(file >= 0);
    assert_int_equal(io->ops->lock(io, file), 0);
    assert_int_equal(add(&n, "one"), -EAGAIN);
    assert_false(exists(in(n.path, "notes.jsonl")));
    io->ops->close(io, file);
    assert_int_equal(ttf_writer_open(io, n.path, &writer, NULL), 0); /* whose lock is another */
    assert_int_equal(add(&n, "one"), 0);
    ttf_writer_close(writer);
    expect(&n, "{\"text\":\"one\"}\n");
}

static void what_a_tool_appends_meanwhile_is_not_lost(void **state)
{
    struct noted n;

    begin(&n, state);
    assert_int_equal(add(&n, "one"), 0);
    n.meddles = true;
    assert_int_equal(add(&n, "two"), -EAGAIN);
    assert_int_equal(add(&n, "two"), 0);
    expect(&n, "{\"text\":\"one\"}\n{\"text\":\"by hand\"}\n{\"text\":\"two\"}\n");
}

#define T(test) cmocka_unit_test_setup_teardown(test, folder_setup, folder_teardown)

int main(void)
{
    const struct CMUnitTest tests[] = {
        T(a_note_is_on_the_disk_before_it_takes_its_name),
        T(a_note_after_one_whose_sync_failed_stands_on_nothing_of_it),
        T(a_note_that_fails_leaves_those_before_it),
        T(a_line_that_somebody_left_unfinished_is_ended_first),
        T(only_one_adds_a_note_at_a_time),
        T(what_a_tool_appends_meanwhile_is_not_lost),
    };

    return cmocka_run_group_tests_name("notes", tests, NULL, NULL);
}
