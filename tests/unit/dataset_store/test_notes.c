/* SPDX-License-Identifier: Apache-2.0 */
/* Notes: what was acknowledged stays, whoever else writes, and whatever failed before (DESIGN.md, "Notes and samples"). */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "meddled.h"
#include "store_ios.h"
#include "store_test.h"
#include "ttf/base/time.h"
#include "ttf/dataset/notes.h"

/* What another one does who adds a note, and to whom the lock is none. */
enum beside {
    NOBODY,
    ADDS,
    IS_CUT_OFF
};

/* A store that is meddled with (n.m), also by another process that adds. */
struct noted {
    struct meddled m;
    enum beside beside;
    bool cut; /* this process goes with the next bytes to write */
    int beside_code;
};

static int add(struct noted *n, const char *text);

/* Another process, which leaves its new file without what it was to hold. */
static void be_cut_off(struct noted *n)
{
    pid_t child = fork();
    int status;

    assert_true(child >= 0);
    if (child == 0) {
        n->cut = true;
        _exit(add(n, "cut off") == 0 ? 1 : 2);
    }
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_int_equal(status, 0);
}

static void before(void *ctx, const char *op)
{
    struct noted *n = ctx;
    enum beside beside = n->beside;

    if (n->cut && strcmp(op, "append") == 0)
        _exit(0);
    if (strcmp(op, "sync") != 0)
        return;
    n->beside = NOBODY;
    if (beside == ADDS)
        n->beside_code = add(n, "beside");
    else if (beside == IS_CUT_OFF)
        be_cut_off(n);
}

static void begin(struct noted *n, void **state)
{
    memset(n, 0, sizeof(*n));
    meddled_begin(&n->m, state, ".notes-new");
    n->m.before = before;
    n->m.ctx = n;
}

static int add(struct noted *n, const char *text)
{
    struct ttf_note note = {.utc_ns = TTF_NS_UNKNOWN};

    snprintf(note.text, sizeof(note.text), "%s", text);
    return ttf_note_append(n->m.io, n->m.path, &note, NULL);
}

static void expect(struct noted *n, const char *wanted)
{
    char *text = file_text(in(n->m.path, "notes.jsonl"), NULL);

    assert_string_equal(text, wanted);
    free(text);
    meddled_expect_no_new_file(&n->m);
    meddled_end(&n->m);
}

static void a_note_is_on_the_disk_before_it_takes_its_name(void **state)
{
    struct noted n;

    begin(&n, state);
    assert_int_equal(add(&n, "one"), 0);
    meddled_forget_log(&n.m);
    assert_int_equal(add(&n, "two"), 0);
    assert_string_equal(n.m.log, "open .notes-new\nappend .notes-new\nappend "
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
        n.m.cue.op = syncs[i];
        n.m.cue.error = EIO;
        n.m.cue.n = 0;
        n.m.cue.at = 1;
        assert_int_equal(add(&n, "two"), -EIO);
        n.m.cue.op = NULL;
        n.m.cue.at = 0;
        meddled_forget_log(&n.m);
        assert_int_equal(add(&n, "three"), 0);
        assert_non_null(strstr(n.m.log, "sync .notes-new\nrename notes.jsonl\nsync_dir d\n"));
        assert_null(strstr(n.m.log, "append notes.jsonl"));
        expect(&n, i ? "{\"text\":\"one\"}\n{\"text\":\"two\"}\n{\"text\":\"three\"}\n"
                     : "{\"text\":\"one\"}\n{\"text\":\"three\"}\n");
        assert_int_equal(run("rm -r '%s'", n.m.path), 0);
    }
}

static void a_note_that_fails_leaves_those_before_it(void **state)
{
    struct noted n;
    int r = -ENOSPC;

    begin(&n, state);
    assert_int_equal(add(&n, "one"), 0);
    n.m.cue.error = ENOSPC;
    for (n.m.cue.at = 1; r; n.m.cue.at++) {
        char *text;

        n.m.cue.n = 0;
        r = add(&n, "two");
        text = file_text(in(n.m.path, "notes.jsonl"), NULL);
        assert_int_equal(strncmp(text, "{\"text\":\"one\"}\n", 15), 0);
        free(text);
        assert_true(r == 0 || r == -ENOSPC);
    }
    assert_true(n.m.cue.at > 8);
    meddled_end(&n.m);
}

static void a_line_that_somebody_left_unfinished_is_ended_first(void **state)
{
    struct noted n;

    begin(&n, state);
    write_text(in(n.m.path, "notes.jsonl"), "{\"text\":\"to", 11);
    write_text(in(n.m.path, ".notes-new"), "{\"text\":\"cut", 12); /* of those that were cut off */
    write_text(in(n.m.path, ".notes-new-0123456789abcdef"), "{\"text\":\"cut", 12);
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
    file = io->ops->open(io, in(n.m.path, "dataset.json"), TTF_IO_READ);
    assert_true(file >= 0);
    assert_int_equal(io->ops->lock(io, file), 0);
    assert_int_equal(add(&n, "one"), -EAGAIN);
    assert_false(exists(in(n.m.path, "notes.jsonl")));
    io->ops->close(io, file);
    assert_int_equal(ttf_writer_open(io, n.m.path, &writer, NULL), 0); /* whose lock is another */
    assert_int_equal(add(&n, "one"), 0);
    ttf_writer_close(writer);
    expect(&n, "{\"text\":\"one\"}\n");
}

static void what_a_tool_writes_meanwhile_is_not_lost(void **state)
{
    static const char *const meddling[] = {
        "printf 'B\\n' >> notes.jsonl",
        "printf 'A\\nB\\n' > .saved && mv .saved notes.jsonl", /* an editor's way */
        "printf 'B\\n' > .saved && mv .saved notes.jsonl",     /* and as long as before */
        "printf 'B\\n' > .saved && touch -r notes.jsonl .saved && mv .saved notes.jsonl",
        "printf 'B\\n' > notes.jsonl && touch -d 2001-01-01 notes.jsonl",
        "rm notes.jsonl",
    };
    static const char *const left[] = {"A\nB\n", "A\nB\n", "B\n", "B\n", "B\n", ""};

    for (unsigned i = 0; i < sizeof meddling / sizeof *meddling; i++) {
        char wanted[64];
        struct noted n;

        begin(&n, state);
        write_text(in(n.m.path, "notes.jsonl"), "A\n", 2);
        n.m.meddles = meddling[i];
        assert_int_equal(add(&n, "two"), -EAGAIN);
        assert_int_equal(add(&n, "two"), 0);
        snprintf(wanted, sizeof(wanted), "%s{\"text\":\"two\"}\n", left[i]);
        expect(&n, wanted);
        assert_int_equal(run("rm -r '%s'", n.m.path), 0);
    }
}

static void notes_that_a_tool_began_meanwhile_are_not_lost(void **state)
{
    struct noted n;

    begin(&n, state);
    n.m.meddles = "printf 'B\\n' > notes.jsonl";
    assert_int_equal(add(&n, "one"), -EAGAIN);
    assert_int_equal(add(&n, "one"), 0);
    expect(&n, "B\n{\"text\":\"one\"}\n");
}

static int no_lock(struct ttf_io *io, int file)
{
    (void)io;
    (void)file;
    return -EBADF; /* as NFS says of a handle that only reads */
}

static void where_nobody_can_lock_no_acknowledged_note_is_lost(void **state)
{
    for (unsigned i = 0; i < 2; i++) {
        struct ttf_io_ops ops;
        struct noted n;

        begin(&n, state);
        ops = *n.m.io->ops;
        ops.lock = no_lock;
        n.m.io->ops = &ops;
        if (i)
            assert_int_equal(add(&n, "one"), 0);
        n.beside = ADDS;
        assert_int_equal(add(&n, "two"), -EAGAIN); /* the other was faster */
        assert_int_equal(n.beside_code, 0);
        assert_int_equal(add(&n, "two"), 0);
        expect(&n, i ? "{\"text\":\"one\"}\n{\"text\":\"beside\"}\n{\"text\":\"two\"}\n"
                     : "{\"text\":\"beside\"}\n{\"text\":\"two\"}\n");
        assert_int_equal(run("rm -r '%s'", n.m.path), 0);
    }
}

/* Nor is what takes the place of the notes another one's half. */
static void where_nobody_can_lock_what_is_renamed_is_one_s_own(void **state)
{
    struct ttf_io_ops ops;
    struct noted n;

    begin(&n, state);
    ops = *n.m.io->ops;
    ops.lock = no_lock;
    n.m.io->ops = &ops;
    assert_int_equal(add(&n, "one"), 0);
    n.beside = IS_CUT_OFF;
    assert_int_equal(add(&n, "two"), -EAGAIN); /* its own was taken for a leftover */
    assert_int_equal(add(&n, "two"), 0);
    expect(&n, "{\"text\":\"one\"}\n{\"text\":\"two\"}\n");
}

static void a_person_s_notes_keep_their_mode_and_group(void **state)
{
    static const int modes[] = {0644, 0600, 0664, 0666};

    for (unsigned i = 0; i < sizeof modes / sizeof *modes; i++) {
        struct noted n;

        begin(&n, state);
        write_text(in(n.m.path, "notes.jsonl"), "A\n", 2);
        assert_int_equal(run("chmod %o '%s/notes.jsonl'", modes[i], n.m.path), 0);
        if (geteuid() == 0) /* who else has a group to give? */
            assert_int_equal(run("chown 12345:12346 '%s/notes.jsonl'", n.m.path), 0);
        assert_int_equal(add(&n, "one"), 0);
        assert_int_equal(run("test $(stat -c %%a '%s/notes.jsonl') = %o", n.m.path, modes[i]), 0);
        if (geteuid() == 0)
            assert_int_equal(
                run("test $(stat -c %%u:%%g '%s/notes.jsonl') = 12345:12346", n.m.path), 0);
        expect(&n, "A\n{\"text\":\"one\"}\n");
        assert_int_equal(run("rm -r '%s'", n.m.path), 0);
    }
}

static void a_link_is_not_replaced(void **state)
{
    static const char *const ends[] = {"elsewhere", "nowhere"};
    struct noted n;

    begin(&n, state);
    write_text(in(n.m.path, "elsewhere"), "A\n", 2);
    for (unsigned i = 0; i < 2; i++) {
        assert_int_equal(run("ln -sfn %s '%s/notes.jsonl'", ends[i], n.m.path), 0);
        assert_int_equal(add(&n, "one"), -ELOOP);
        assert_int_equal(run("test -L '%s/notes.jsonl'", n.m.path), 0);
    }
    assert_int_equal(run("mv '%s/elsewhere' '%s/notes.jsonl'", n.m.path, n.m.path), 0);
    expect(&n, "A\n");
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
        T(what_a_tool_writes_meanwhile_is_not_lost),
        T(notes_that_a_tool_began_meanwhile_are_not_lost),
        T(where_nobody_can_lock_no_acknowledged_note_is_lost),
        T(where_nobody_can_lock_what_is_renamed_is_one_s_own),
        T(a_person_s_notes_keep_their_mode_and_group),
        T(a_link_is_not_replaced),
    };

    return cmocka_run_group_tests_name("notes", tests, NULL, NULL);
}
