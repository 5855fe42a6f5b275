/* SPDX-License-Identifier: Apache-2.0 */
/* Every file operation of a pull fails on the side that pulls, once or for good, in every way (README.md). */
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

#include "faults.h"
#include "small_run.h"
#include "ttf/dataset/verify.h"
#include "ttf/hal/clock.h"
#include "ttf/http/listen.h"
#include "ttf/http/server.h"
#include "ttf/pull/pull.h"
#include "unit/http/scratch.h"

#define LOG_ROOM 2000
#define SHARE    23 /* of what may fail, each so-manieth does; of some kinds each QUICK-th */
#define QUICK    4

static bool everything; /* set once, by main */

/* A box whose dataset "d" is what the small run made, and the same on a disk in memory to compare with. */
struct box {
    struct model_disk disk;
    struct ttf_clock *clock;
    struct ttf_http_server *server;
};

static void lay_out(struct model_disk *disk)
{
    for (int i = 0; i < disk->n_names; i++) {
        const struct model_name *name = &disk->names[i];
        char path[220];

        if (name->seen < 0 || disk->inodes[name->seen].is_dir ||
            strncmp(name->path, SMALL_PATH "/", strlen(SMALL_PATH) + 1) != 0)
            continue;
        (void)snprintf(path, sizeof path, "data/d/%s", name->path + strlen(SMALL_PATH) + 1);
        scratch_file(path, disk->inodes[name->seen].seen, disk->inodes[name->seen].seen_bytes);
    }
}

static void box_begin(struct box *box)
{
    struct ttf_http_config config = {.folder = "data", .io = ttf_io_posix()};
    struct ttf_http_socket socket = {.fd = -1};
    struct small_run run;

    small_disk_init(&box->disk);
    run = (struct small_run){.io = &box->disk.io};
    small_run(&run);
    assert_true(run.sealed);
    lay_out(&box->disk);
    config.clock = box->clock = ttf_clock_real_create();
    assert_true(box->clock != NULL);
    assert_int_equal(ttf_http_server_create(&config, &box->server, NULL), 0);
    assert_int_equal(ttf_http_listen("unix:http", false, &socket, NULL), 0);
    assert_int_equal(ttf_http_server_listen(box->server, socket.fd, true, NULL), 0);
}

static void box_end(struct box *box)
{
    ttf_http_server_destroy(box->server);
    ttf_clock_destroy(box->clock);
    model_disk_free(&box->disk);
    (void)unlink("http");
}

static int pull(struct box *box, struct model_disk *disk, struct ttf_pull_result *ret,
                struct ttf_err *err)
{
    const struct ttf_pull_config config = {
        .io = &disk->io, .clock = box->clock, .box = "unix:http", .dest = "/m"};

    return ttf_pull(&config, ret, err);
}

/* The operations of a pull on which nothing fails. */
static long clean_pull(struct box *box, struct model_call *log)
{
    struct ttf_pull_result result;
    struct model_disk disk;
    struct ttf_err err = {0};
    long n;

    model_disk_init(&disk);
    model_disk_fail(&disk, (struct model_fault){0});
    disk.log = log;
    disk.log_room = LOG_ROOM;
    if (pull(box, &disk, &result, &err) < 0)
        fail_msg("%s: %s", err.where, err.what);
    n = disk.n;
    disk.log = NULL;
    assert_int_equal(result.sealed, 1);
    model_disk_free(&disk);
    assert_true(n > 60 && n < LOG_ROOM);
    return n;
}

/* ---- what must hold ---- */

#define WRONG(...) return (void)snprintf(ret, SMALL_TEXT, __VA_ARGS__), false

/* Whatever of the dataset is here is whole. */
static bool is_whole(struct model_disk *disk, char ret[SMALL_TEXT])
{
    const struct ttf_verify_options options = {.deep = true};
    struct ttf_verify_report report;
    bool damaged;
    int r;

    if (!model_disk_has(disk, SMALL_PATH "/dataset.json") ||
        !model_disk_has(disk, SMALL_PATH "/records.jsonl"))
        return true;
    r = ttf_verify(&disk->io, SMALL_PATH, &options, &report, NULL);
    if (r < 0)
        WRONG("verify: %d", r);
    damaged = report.damaged;
    if (damaged && report.n_findings > 0)
        (void)snprintf(ret, SMALL_TEXT, "%s: %s", report.findings[0].file, report.findings[0].text);
    ttf_verify_report_free(&report);
    return !damaged;
}

static int inode_of(const struct model_disk *disk, const char *path)
{
    for (int i = 0; i < disk->n_names; i++)
        if (disk->names[i].seen >= 0 && strcmp(disk->names[i].path, path) == 0)
            return disk->names[i].seen;
    return -1;
}

static bool is_same(const struct box *box, const struct model_disk *disk, char ret[SMALL_TEXT])
{
    for (int i = 0; i < box->disk.n_names; i++) {
        const struct model_name *name = &box->disk.names[i];
        const struct model_inode *a, *b;
        int there;

        if (name->seen < 0 || box->disk.inodes[name->seen].is_dir ||
            strncmp(name->path, SMALL_PATH "/", strlen(SMALL_PATH) + 1) != 0)
            continue;
        there = inode_of(disk, name->path);
        if (there < 0)
            WRONG("%s is not here", name->path);
        a = &box->disk.inodes[name->seen];
        b = &disk->inodes[there];
        if (a->seen_bytes != b->seen_bytes ||
            (a->seen_bytes > 0 && memcmp(a->seen, b->seen, a->seen_bytes) != 0))
            WRONG("%s is another", name->path);
    }
    return true;
}

/* Run again on a sound disk, it brings the rest. */
static bool goes_on(struct box *box, struct model_disk *disk, char ret[SMALL_TEXT])
{
    struct ttf_pull_result result;
    struct ttf_err err = {0};
    int r;

    model_disk_fail(disk, (struct model_fault){0});
    if (!is_whole(disk, ret))
        return false;
    r = pull(box, disk, &result, &err);
    if (r < 0)
        WRONG("pulled again: %s: %s (%d)", err.where, err.what, r);
    if (result.sealed != 1 || result.damaged != 0)
        WRONG("pulled again, it is not sealed");
    return is_same(box, disk, ret);
}

struct figures {
    long injections, recovered, told, wrong;
};

static void wrong(struct figures *figures, const char *what, const char *text)
{
    if (figures->wrong++ < 20)
        print_error("%s: %s\n", what, text);
}

static void one(struct box *box, const struct fault_kind *kind, long at,
                const struct model_call *call, struct figures *figures)
{
    char what[300], dark_what[340], text[SMALL_TEXT] = "";
    struct model_fault fault = kind->fault;
    struct model_disk disk, dark;
    struct ttf_pull_result result;
    struct ttf_err err = {0};
    int r;

    fault_text(kind, at, call, what);
    model_disk_init(&disk);
    fault.at = at;
    model_disk_fail(&disk, fault);
    r = pull(box, &disk, &result, &err);
    figures->injections++;
    figures->recovered += r == 0;
    figures->told += r < 0;
    if (r < 0 && (err.code != r || err.what[0] == '\0'))
        wrong(figures, what, "it is not said why");
    if (result.damaged != 0 || r == -TTF_EDAMAGED)
        wrong(figures, what, "the box is blamed");
    if (model_disk_open_handles(&disk) != 0)
        wrong(figures, what, "a handle was left open");
    model_disk_copy(&dark, &disk);
    model_disk_lose_power(&dark);
    if (!goes_on(box, &disk, text))
        wrong(figures, what, text);
    (void)snprintf(dark_what, sizeof dark_what, "%s, then a power cut", what);
    if (!goes_on(box, &dark, text))
        wrong(figures, dark_what, text);
    model_disk_free(&dark);
    model_disk_free(&disk);
}

/* The quick ones, and those that few operations can meet. */
static bool is_of_all(const struct fault_kind *kind)
{
    return kind->quick || kind->transfers_only || kind->interruptible_only;
}

static void each_operation_fails(void **state)
{
    static struct model_call log[LOG_ROOM];
    static struct box box;
    long n, all_wrong = 0;

    (void)state;
    box_begin(&box);
    n = clean_pull(&box, log);
    for (unsigned i = 0; i < n_fault_kinds; i++) {
        struct figures figures = {0};

        for (long at = 1; at <= n; at++)
            if (fault_fits(&fault_kinds[i], &log[at - 1]) &&
                (everything || (at + i) % (is_of_all(&fault_kinds[i]) ? QUICK : SHARE) == 0))
                one(&box, &fault_kinds[i], at, &log[at - 1], &figures);
        print_message("%-28s %5ld injected: %ld recovered, %ld told\n", fault_kinds[i].name,
                      figures.injections, figures.recovered, figures.told);
        all_wrong += figures.wrong;
    }
    box_end(&box);
    assert_int_equal(all_wrong, 0);
}

/* Each size of the disk, from nothing to all that the dataset takes. */
static void a_full_disk_takes_what_fits_and_goes_on_when_there_is_room(void **state)
{
    static struct box box;
    struct figures figures = {0};

    (void)state;
    box_begin(&box);
    for (int64_t room = 1; room < model_disk_used(&box.disk); room += everything ? 13 : 397) {
        char what[64], text[SMALL_TEXT] = "";
        struct ttf_pull_result result;
        struct model_disk disk;
        struct ttf_err err = {0};
        int r;

        (void)snprintf(what, sizeof what, "a disk of %lld bytes", (long long)room);
        model_disk_init(&disk);
        disk.capacity_bytes = room;
        r = pull(&box, &disk, &result, &err);
        if (r != -ENOSPC || err.code != r)
            wrong(&figures, what, r == 0 ? "all is said to be here" : err.what);
        disk.capacity_bytes = 0;
        if (!goes_on(&box, &disk, text))
            wrong(&figures, what, text);
        figures.injections++;
        model_disk_free(&disk);
    }
    box_end(&box);
    assert_true(figures.injections > 5);
    assert_int_equal(figures.wrong, 0);
}

static void what_another_program_is_writing_is_left_alone(void **state)
{
    static struct box box;
    struct ttf_pull_result result;
    struct model_disk disk;
    struct ttf_err err = {0};
    int file;

    (void)state;
    box_begin(&box);
    model_disk_init(&disk);
    assert_int_equal(pull(&box, &disk, &result, &err), 0);
    file = disk.io.ops->open(&disk.io, SMALL_PATH, TTF_IO_READ);
    assert_true(file >= 0);
    assert_int_equal(disk.io.ops->lock(&disk.io, file), 0);
    assert_int_equal(pull(&box, &disk, &result, &err), -EBUSY);
    assert_int_equal(disk.io.ops->close(&disk.io, file), 0);
    assert_int_equal(pull(&box, &disk, &result, &err), 0);
    model_disk_free(&disk);
    box_end(&box);
}

/* "all": every operation fails in every way; else a share of it, in some seconds. */
int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(each_operation_fails, scratch_make, scratch_remove),
        cmocka_unit_test_setup_teardown(a_full_disk_takes_what_fits_and_goes_on_when_there_is_room,
                                        scratch_make, scratch_remove),
        cmocka_unit_test_setup_teardown(what_another_program_is_writing_is_left_alone, scratch_make,
                                        scratch_remove),
    };

    everything = argc > 1 && strcmp(argv[1], "all") == 0;
    return cmocka_run_group_tests(tests, NULL, NULL);
}
