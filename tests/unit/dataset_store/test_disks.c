/* SPDX-License-Identifier: Apache-2.0 */
/* Disks that give and take little at a time, fail at odd moments, or are full: what then lies there. */
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
#include <sys/sysmacros.h>
#include <unistd.h>

#include "store_ios.h"
#include "store_test.h"
#include "ttf/dataset/hash.h"
#include "ttf/dataset/reader.h"
#include "ttf/dataset/verify.h"

/* ---- three bytes at a time, and a signal before each ---- */

struct stingy {
    struct ttf_io io;
    struct ttf_io_ops ops;
    unsigned calls;
    int closes_to_fail;  /* -1: none; 0: the next one */
    int reads_to_fail;   /* -1: none; else every one from then on */
    int64_t failed_read; /* what those return */
    bool sparing;
};

static struct stingy *stingy(struct ttf_io *io)
{
    return (struct stingy *)io;
}

static size_t portion(struct stingy *s, size_t n)
{
    return s->sparing && n > 3 ? 3 : n;
}

static bool disturbed(struct stingy *s)
{
    return s->sparing && s->calls++ % 2 == 0;
}

static int64_t st_pread(struct ttf_io *io, int file, void *buf, size_t n, int64_t offset)
{
    struct stingy *s = stingy(io);

    if (s->reads_to_fail == 0)
        return s->failed_read;
    if (s->reads_to_fail > 0)
        s->reads_to_fail--;
    return disturbed(s) ? -EINTR : quick_io()->ops->pread(io, file, buf, portion(s, n), offset);
}

static int64_t st_pwrite(struct ttf_io *io, int file, const void *buf, size_t n, int64_t offset)
{
    struct stingy *s = stingy(io);

    return disturbed(s) ? -EINTR : quick_io()->ops->pwrite(io, file, buf, portion(s, n), offset);
}

static int64_t st_append(struct ttf_io *io, int file, const void *buf, size_t n)
{
    struct stingy *s = stingy(io);

    return disturbed(s) ? -EINTR : quick_io()->ops->append(io, file, buf, portion(s, n));
}

static int st_close(struct ttf_io *io, int file)
{
    struct stingy *s = stingy(io);
    int r = quick_io()->ops->close(io, file);

    if (s->closes_to_fail >= 0 && s->closes_to_fail-- == 0)
        return -EIO;
    return r;
}

static struct ttf_io *stingy_init(struct stingy *s)
{
    *s = (struct stingy){
        .ops = *quick_io()->ops, .closes_to_fail = -1, .reads_to_fail = -1, .failed_read = -EIO};
    s->io.ops = &s->ops;
    s->ops.pread = st_pread;
    s->ops.pwrite = st_pwrite;
    s->ops.append = st_append;
    s->ops.close = st_close;
    return &s->io;
}

static struct ttf_verify_report verified(struct ttf_io *io, const char *path)
{
    struct ttf_verify_options options = {.deep = true};
    struct ttf_verify_report report;
    struct ttf_err err = {0};

    if (ttf_verify(io, path, &options, &report, &err) != 0)
        fail_msg("%s: %s", err.where, err.what);
    return report;
}

static void assert_clean(struct ttf_io *io, const char *path)
{
    struct ttf_verify_report report = verified(io, path);

    if (report.n_findings > 0)
        fail_msg("%s: %s", report.findings[0].file, report.findings[0].text);
    ttf_verify_report_free(&report);
}

/* The last byte of a file. */
static char last_byte(const char *path)
{
    size_t n;
    char *text = file_text(path, &n), c = n > 0 ? text[n - 1] : '\0';

    free(text);
    return c;
}

/* Writes from the middle, then the beginning, cuts off the end and appends another. */
static int produce_restlessly(void *ctx, struct ttf_io *io, int file, struct ttf_err *err)
{
    int r = ttf_io_pwrite_all(io, file, "middle and an end", 17, 10);

    r = r ? r : ttf_io_pwrite_all(io, file, "beginning ", 10, 0);
    r = r ? r : io->ops->truncate(io, file, 17);
    return r ? r : ttf_io_append_all(io, file, "another end", 11);
}

/* Front to back, but for a piece that is cut off and left out: as long as if it had been written. */
static int produce_with_a_hole(void *ctx, struct ttf_io *io, int file, struct ttf_err *err)
{
    int r = ttf_io_append_all(io, file, "beginning ", 10);

    r = r ? r : io->ops->truncate(io, file, 5);
    return r ? r : ttf_io_pwrite_all(io, file, "and end", 7, 10);
}

static void assert_hash_is_of_the_file(const char *path, const struct ttf_file_ref *ref)
{
    char hex[65];
    int64_t bytes;

    assert_int_equal(ttf_sha256_file(quick_io(), in(path, "%s", ref->path), &bytes, hex, NULL), 0);
    assert_string_equal(ref->sha256, hex);
    assert_int_equal(ref->bytes, bytes);
}

static void a_disk_that_takes_three_bytes_at_a_time_gets_them_all(void **state)
{
    const char *path = in(*state, "d");
    struct ttf_writer *writer;
    struct ttf_file_ref ref;
    struct stingy s;
    struct ttf_io *io = stingy_init(&s);
    char *text;

    writer = small_create(io, path);
    s.sparing = true; /* from here: its reserve would take long */
    assert_int_equal(small_slot(writer, 0), 0);
    assert_int_equal(small_slot(writer, 1), 0);
    assert_int_equal(ttf_writer_event(writer, "door", 1, 2, "opened", NULL, NULL), 0);
    assert_int_equal(ttf_writer_seal(writer, "count", NULL, NULL), 0);
    ttf_writer_close(writer);
    assert_int_equal(small_check(io, path), 2);
    assert_clean(io, path);
    s.sparing = false;
    assert_int_equal(ttf_writer_open(io, path, &writer, NULL), 0);
    s.sparing = true;
    assert_int_equal(
        ttf_writer_file(writer, "raw", "main", 2, -1, "x", produce_restlessly, NULL, &ref, NULL),
        0);
    text = file_text(in(path, "%s", ref.path), NULL);
    assert_string_equal(text, "beginning middle another end");
    free(text);
    assert_hash_is_of_the_file(path, &ref);
    ttf_writer_close(writer);
}

static void a_file_that_was_cut_and_written_on_has_its_right_hash(void **state)
{
    const char *path = in(*state, "d");
    struct ttf_writer *writer = small_create(quick_io(), path);
    struct ttf_file_ref ref;

    assert_int_equal(
        ttf_writer_file(writer, "raw", "main", 0, -1, "x", produce_restlessly, NULL, &ref, NULL),
        0);
    assert_hash_is_of_the_file(path, &ref);
    assert_int_equal(
        ttf_writer_file(writer, "raw", "main", 1, -1, "x", produce_with_a_hole, NULL, &ref, NULL),
        0);
    assert_hash_is_of_the_file(path, &ref);
    ttf_writer_close(writer);
}

static void a_calibration_larger_than_one_piece_is_copied_whole(void **state)
{
    const char *path = in(*state, "d"), *cal = in(*state, "cal");
    struct ttf_writer *writer = small_create(quick_io(), path);

    assert_int_equal(mkdir(cal, 0777), 0);
    assert_int_equal(run("seq 100000 > '%s/flat.tif'", cal), 0); /* 575 KiB */
    assert_int_equal(ttf_writer_calibration(writer, "cal-1", cal, NULL), 0);
    ttf_writer_close(writer);
    assert_int_equal(run("cmp '%s/flat.tif' '%s/calibration/cal-1/flat.tif'", cal, path), 0);
    assert_clean(quick_io(), path);
}

/* ---- closing and reading fail ---- */

static void a_file_that_cannot_be_closed_does_not_count(void **state)
{
    const char *path = in(*state, "d"), *text = in(*state, "x");
    struct ttf_writer *writer;
    struct stingy s;
    struct ttf_io *io = stingy_init(&s);
    char *read;

    assert_int_equal(ttf_io_write_file(io, text, "old", 3, NULL), 0);
    s.closes_to_fail = 0;
    assert_int_equal(ttf_io_write_file(io, text, "new", 3, NULL), -EIO);
    read = file_text(text, NULL);
    assert_string_equal(read, "old");
    free(read);
    writer = small_create(io, path);
    s.closes_to_fail = 0;
    assert_int_equal(small_slot(writer, 0), 0);
    assert_true(exists(in(path, "frames/main/000000.r1.tif")));
    assert_int_equal(run("[ $(ls '%s/frames/main' | wc -l) -eq 1 ]", path), 0);
    ttf_writer_close(writer);
    assert_int_equal(small_check(quick_io(), path), 1);
}

static void records_that_cannot_be_read_are_not_taken_for_none(void **state)
{
    const char *path = in(*state, "d");
    struct ttf_writer *writer = small_create(quick_io(), path);
    struct ttf_reader *reader;
    struct stingy s;
    struct ttf_io *io = stingy_init(&s);
    int at;

    assert_int_equal(small_slot(writer, 0), 0);
    ttf_writer_close(writer);
    for (at = 0; at < 12; at++) { /* dataset.json, the sums, the records, the events, ... */
        s.reads_to_fail = at;
        if (ttf_writer_open(io, path, &writer, NULL) == 0) {
            assert_int_equal(ttf_writer_state(writer)->next_index, 1);
            ttf_writer_abandon(writer);
        }
        s.reads_to_fail = at;
        if (ttf_reader_open(io, path, &reader, NULL) == 0) {
            assert_int_equal(ttf_reader_summary(reader)->slots, 1);
            ttf_reader_close(reader);
        }
    }
    s.reads_to_fail = 0;
    assert_int_equal(ttf_writer_open(io, path, &writer, NULL), -EIO);
    assert_int_equal(small_check(quick_io(), path), 1);
    assert_clean(quick_io(), path);
}

/* Neither where reading fails, nor where it gives less than was written. */
static void records_that_cannot_be_read_back_are_not_replaced(void **state)
{
    static const int64_t failures[] = {-EIO, 0};
    char path[300];
    size_t i;

    for (i = 0; i < TTF_COUNT_OF(failures); i++) {
        struct stingy s;
        struct cue cue = {.error = EIO, .op = "sync", .in = "records.jsonl"};
        struct ttf_io *io = ttf_io_faulty_create(stingy_init(&s), cue_fault, &cue);
        struct ttf_writer *writer;

        snprintf(path, sizeof(path), "%s/d%zu", (char *)*state, i);
        writer = small_create(io, path);
        assert_int_equal(small_slot(writer, 0), 0);
        cue.at = cue.n + 1;
        s.reads_to_fail = 0;
        s.failed_read = failures[i];
        assert_int_equal(small_slot(writer, 1), -EIO);
        s.reads_to_fail = -1;
        assert_int_equal(small_slot(writer, 1), -EIO); /* for good: what lies there is not known */
        ttf_writer_abandon(writer);
        ttf_io_faulty_destroy(io);
        assert_int_equal(small_check(quick_io(), path), 1);
        assert_int_equal(ttf_writer_open(quick_io(), path, &writer, NULL), 0);
        assert_int_equal(ttf_writer_state(writer)->next_index, 1);
        ttf_writer_close(writer);
    }
}

/* ---- the records' own failures ---- */

static void a_record_that_was_not_acknowledged_is_not_there(void **state)
{
    const char *path = in(*state, "d");
    struct cue cue = {.error = EIO, .op = "sync", .in = "records.jsonl"};
    struct ttf_io *io = ttf_io_faulty_create(quick_io(), cue_fault, &cue);
    struct ttf_writer *writer = small_create(io, path);

    assert_int_equal(small_slot(writer, 0), 0);
    cue.at = cue.n + 1;
    cue.for_ever = true; /* the new file's too */
    assert_int_equal(small_slot(writer, 1), -EIO);
    cue.at = 0;
    assert_int_equal(small_check(quick_io(), path), 1);
    assert_int_equal(small_slot(writer, 1), -EIO); /* refused, though the disk would take it */
    ttf_writer_close(writer);
    ttf_io_faulty_destroy(io);
    assert_int_equal(small_check(quick_io(), path), 1);
    assert_false(exists(in(path, "records.jsonl.tmp")));
}

static void after_writing_anew_records_go_to_the_new_file(void **state)
{
    const char *path = in(*state, "d");
    struct cue cue = {.error = EIO, .op = "sync", .in = "records.jsonl"};
    struct ttf_io *io = ttf_io_faulty_create(quick_io(), cue_fault, &cue);
    struct ttf_writer *writer = small_create(io, path);

    cue.at = cue.n + 1;
    assert_int_equal(small_slot(writer, 0), 0);
    assert_int_equal(small_slot(writer, 1), 0);
    ttf_writer_close(writer);
    ttf_io_faulty_destroy(io);
    assert_int_equal(small_check(quick_io(), path), 2);
    assert_clean(quick_io(), path);
}

/* Half of a line finds room, and what there is cannot be cut off again. */
static int full_and_stuck(void *ctx, const char *op, const char *path)
{
    bool *full = ctx;

    if (!*full || !strstr(path, "records.jsonl"))
        return 0;
    return strcmp(op, "append") == 0 ? ENOSPC : strcmp(op, "truncate") == 0 ? EIO : 0;
}

static void a_piece_of_a_line_that_cannot_be_cut_off_stops_the_writer(void **state)
{
    const char *path = in(*state, "d");
    bool full = false;
    struct ttf_io *io = ttf_io_faulty_create(quick_io(), full_and_stuck, &full);
    struct ttf_writer *writer = small_create(io, path);

    assert_int_equal(small_slot(writer, 0), 0);
    full = true;
    assert_int_equal(small_slot(writer, 1), -ENOSPC);
    full = false;
    assert_int_equal(small_slot(writer, 1), -ENOSPC); /* what lies at the end is not known */
    ttf_writer_close(writer);
    ttf_io_faulty_destroy(io);
    assert_int_equal(small_check(quick_io(), path), 1);
}

static void a_newline_that_found_no_room_is_written_when_closing(void **state)
{
    static const char *const logs[] = {"records.jsonl", "events.jsonl"};
    char path[300];
    size_t i;

    for (i = 0; i < 2 * TTF_COUNT_OF(logs); i++) {
        struct cue cue = {.error = ENOSPC, .op = "append", .in = logs[i % 2]};
        struct ttf_io *io = ttf_io_faulty_create(quick_io(), cue_fault, &cue);
        struct ttf_writer *writer;
        const char *log;

        snprintf(path, sizeof(path), "%s/d%zu", (char *)*state, i);
        log = in(path, "%s", logs[i % 2]);
        writer = small_create(io, path);
        cue.at = cue.n + 2;
        if (i % 2 == 0)
            assert_int_equal(small_slot(writer, 0), 0);
        else
            assert_int_equal(ttf_writer_event(writer, "door", 1, 2, "", NULL, NULL), 0);
        assert_int_not_equal(last_byte(log), '\n');
        if (i < 2) {
            ttf_writer_close(writer);
        } else { /* or, cut off, when it is opened again */
            ttf_writer_abandon(writer);
            assert_int_equal(ttf_writer_open(quick_io(), path, &writer, NULL), 0);
            assert_int_equal(last_byte(log), '\n');
            ttf_writer_abandon(writer);
        }
        ttf_io_faulty_destroy(io);
        assert_int_equal(last_byte(log), '\n');
    }
}

static void a_log_that_cannot_be_synced_is_not_sealed(void **state)
{
    const char *path = in(*state, "d");
    struct cue cue = {.error = EIO, .op = "sync", .in = "events.jsonl", .for_ever = true};
    struct ttf_io *io = ttf_io_faulty_create(quick_io(), cue_fault, &cue);
    struct ttf_writer *writer = small_create(io, path);

    assert_int_equal(small_slot(writer, 0), 0);
    cue.at = cue.n + 1;
    assert_int_equal(ttf_writer_seal(writer, "count", NULL, NULL), -EIO);
    assert_false(ttf_writer_state(writer)->sealed);
    ttf_writer_close(writer);
    ttf_io_faulty_destroy(io);
    assert_int_equal(run("grep -q records.jsonl '%s/SHA256SUMS'", path), 1);
}

/* The next syncs of events.jsonl fail, `*ctx` of them, whatever name it has; the one after them would work. */
static int next_syncs(void *ctx, const char *op, const char *path)
{
    int *left = ctx;

    if (strcmp(op, "sync") != 0 || !strstr(path, "events.jsonl") || *left == 0)
        return 0;
    (*left)--;
    return EIO;
}

static void a_log_whose_sync_failed_is_not_sealed_by_another_that_works(void **state)
{
    const char *path = in(*state, "d");
    int left = 0;
    struct ttf_io *io = ttf_io_faulty_create(quick_io(), next_syncs, &left);
    struct ttf_writer *writer = small_create(io, path);

    assert_int_equal(small_slot(writer, 0), 0);
    left = 2; /* of the log, and of the new file that it is written as */
    assert_int_equal(ttf_writer_seal(writer, "count", NULL, NULL), -EIO);
    assert_int_equal(left, 0);
    ttf_writer_close(writer);
    ttf_io_faulty_destroy(io);
    assert_int_equal(run("grep -q records.jsonl '%s/SHA256SUMS'", path), 1);
}

static void a_seal_that_cannot_be_written_is_told(void **state)
{
    const char *path = in(*state, "d");
    struct cue cue = {.error = EIO, .op = "rename", .in = "SHA256SUMS", .at = 1};
    struct ttf_io *io = ttf_io_faulty_create(quick_io(), cue_fault, &cue);
    struct ttf_writer *writer = small_create(io, path);

    assert_int_equal(small_slot(writer, 0), 0);
    assert_int_equal(ttf_writer_seal(writer, "count", NULL, NULL), -EIO);
    assert_false(ttf_writer_state(writer)->sealed);
    assert_int_equal(ttf_writer_seal(writer, "count", NULL, NULL), 0); /* another try */
    ttf_writer_close(writer);
    ttf_io_faulty_destroy(io);
    assert_int_equal(run("[ $(grep -c '\"type\":\"end\"' '%s/records.jsonl') -eq 1 ]", path), 0);
    assert_clean(quick_io(), path);
}

/* ---- the list of sums ---- */

static void sums_that_fell_behind_are_brought_up_when_closing(void **state)
{
    const char *path = in(*state, "d");
    struct cue cue = {.error = EIO, .op = "append", .in = "SHA256SUMS", .at = 2};
    struct ttf_io *io = ttf_io_faulty_create(quick_io(), cue_fault, &cue);
    struct ttf_writer *writer = small_create(io, path);
    int64_t i;

    for (i = 0; i < 3; i++)
        assert_int_equal(small_slot(writer, i), 0);
    ttf_writer_close(writer);
    ttf_io_faulty_destroy(io);
    assert_int_equal(run("[ $(wc -l < '%s/SHA256SUMS') -eq 3 ]", path), 0);
    assert_clean(quick_io(), path);
}

static void slots_after_a_seal_are_listed_anew(void **state)
{
    const char *path = in(*state, "d");
    struct ttf_writer *writer = small_create(quick_io(), path);

    assert_int_equal(small_slot(writer, 0), 0);
    assert_int_equal(ttf_writer_seal(writer, "count", NULL, NULL), 0);
    assert_int_equal(small_slot(writer, 1), 0); /* the same writer goes on */
    assert_int_equal(small_slot(writer, 2), 0);
    assert_int_equal(run("[ $(wc -l < '%s/SHA256SUMS') -eq 3 ]", path), 0);
    ttf_writer_abandon(writer);
    assert_clean(quick_io(), path);
}

/* ---- no room ---- */

static void an_image_that_found_no_room_leaves_nothing(void **state)
{
    const char *path = in(*state, "d");
    struct cue cue = {.error = ENOSPC, .op = "append", .in = "000001.tif"};
    struct ttf_io *io = ttf_io_faulty_create(quick_io(), cue_fault, &cue);
    struct ttf_writer *writer = small_create(io, path);

    assert_int_equal(small_slot(writer, 0), 0);
    cue.at = cue.n + 2; /* half of it has found room */
    assert_int_equal(small_slot(writer, 1), -ENOSPC);
    assert_int_equal(cue.n, 2); /* at once: another name would not help */
    assert_int_equal(run("[ $(ls '%s/frames/main' | wc -l) -eq 1 ]", path), 0);
    ttf_writer_close(writer);
    ttf_io_faulty_destroy(io);
}

static void the_second_attempt_leaves_nothing_of_the_first(void **state)
{
    static const char *const ops[] = {"append", "sync", "rename", "sync_dir"};
    char path[300];
    size_t i;

    for (i = 0; i < TTF_COUNT_OF(ops); i++) {
        struct cue cue = {.error = EIO, .op = ops[i], .in = "frames/main"};
        struct ttf_io *io = ttf_io_faulty_create(quick_io(), cue_fault, &cue);
        struct ttf_writer *writer;

        snprintf(path, sizeof(path), "%s/d%zu", (char *)*state, i);
        writer = small_create(io, path);
        assert_int_equal(small_slot(writer, 0), 0);
        cue.at = cue.n + 1;
        assert_int_equal(small_slot(writer, 1), 0);
        assert_true(exists(in(path, "frames/main/000001.r1.tif")));
        assert_int_equal(run("[ $(ls '%s/frames/main' | wc -l) -eq 2 ]", path), 0);
        ttf_writer_close(writer);
        ttf_io_faulty_destroy(io);
    }
}

static void the_reserve_is_there_whenever_something_may_be_written(void **state)
{
    const char *path = in(*state, "d"), *reserve = in(path, ".events-reserve");
    struct ttf_writer *writer = small_create(quick_io(), path);
    struct ttf_segment segment = ttf_writer_state(writer)->last_segment;

    assert_int_equal(size_of(reserve), 256 * 1024);
    /* Noise: no file system can store it in less. */
    assert_int_equal(run("[ $(gzip -c '%s' | wc -c) -gt 260000 ]", reserve), 0);
    assert_int_equal(ttf_writer_seal(writer, "stopped", NULL, NULL), 0);
    assert_false(exists(reserve));
    segment.segment = 1;
    assert_int_equal(ttf_writer_segment(writer, &segment, NULL), 0);
    assert_int_equal(size_of(reserve), 256 * 1024);
    ttf_writer_close(writer);
    assert_int_equal(truncate(reserve, 100000), 0);
    assert_int_equal(ttf_writer_open(quick_io(), path, &writer, NULL), 0);
    assert_int_equal(size_of(reserve), 256 * 1024);
    ttf_writer_close(writer);
}

/* As the kernel lays it out: devices by their numbers, counts by their names. */
static void errors_that_a_file_system_counts_are_read_by_its_device(void **state)
{
    const char *sys = *state;

    assert_int_equal(
        run("cd '%s' && mkdir -p dev/block fs/ext4/sda1 fs/ext4/mmcblk0p2 fs/ext4/sdb1 &&"
            " ln -s ../../devices/usb/block/sda/sda1 dev/block/8:1 &&"
            " ln -s ../../devices/mmc/block/mmcblk0/mmcblk0p2 dev/block/179:2 &&"
            " ln -s ../../devices/usb/block/sdb/sdb1 dev/block/8:17 &&"
            " ln -s ../../devices/usb/block/sdc/sdc1 dev/block/8:33 &&"
            " echo 0 >fs/ext4/sda1/errors_count && echo 7 >fs/ext4/mmcblk0p2/errors_count"
            " && echo what >fs/ext4/sdb1/errors_count",
            sys),
        0);
    assert_int_equal(ttf_io_fs_errors(sys, makedev(8, 1)), 0);
    assert_int_equal(ttf_io_fs_errors(sys, makedev(179, 2)), 7);
    assert_int_equal(ttf_io_fs_errors(sys, makedev(8, 17)), 0); /* not a number */
    assert_int_equal(ttf_io_fs_errors(sys, makedev(8, 33)), 0); /* not ext4 */
    assert_int_equal(ttf_io_fs_errors(sys, makedev(0, 44)), 0); /* no device */
}

int main(void)
{
#define T(f) cmocka_unit_test_setup_teardown(f, folder_setup, folder_teardown)
    const struct CMUnitTest tests[] = {
        T(a_disk_that_takes_three_bytes_at_a_time_gets_them_all),
        T(a_file_that_was_cut_and_written_on_has_its_right_hash),
        T(a_calibration_larger_than_one_piece_is_copied_whole),
        T(a_file_that_cannot_be_closed_does_not_count),
        T(records_that_cannot_be_read_are_not_taken_for_none),
        T(records_that_cannot_be_read_back_are_not_replaced),
        T(a_record_that_was_not_acknowledged_is_not_there),
        T(after_writing_anew_records_go_to_the_new_file),
        T(a_piece_of_a_line_that_cannot_be_cut_off_stops_the_writer),
        T(a_newline_that_found_no_room_is_written_when_closing),
        T(a_log_that_cannot_be_synced_is_not_sealed),
        T(a_log_whose_sync_failed_is_not_sealed_by_another_that_works),
        T(a_seal_that_cannot_be_written_is_told),
        T(sums_that_fell_behind_are_brought_up_when_closing),
        T(slots_after_a_seal_are_listed_anew),
        T(an_image_that_found_no_room_leaves_nothing),
        T(the_second_attempt_leaves_nothing_of_the_first),
        T(the_reserve_is_there_whenever_something_may_be_written),
        T(errors_that_a_file_system_counts_are_read_by_its_device),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
