/* SPDX-License-Identifier: Apache-2.0 */
/* Crashes and failing disks: what was acknowledged stays, and the dataset goes on. */
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

#include "store_ios.h"
#include "store_test.h"
#include "ttf/dataset/hash.h"
#include "ttf/dataset/reader.h"
#include "ttf/dataset/verify.h"

#define SLOTS 3

static void assert_whole(const char *path, bool leftovers_allowed)
{
    struct ttf_verify_options options = {.deep = true};
    struct ttf_verify_report report;
    struct ttf_err err = {0};

    if (ttf_verify(ttf_io_posix(), path, &options, &report, &err) != 0)
        fail_msg("%s: %s", err.where, err.what);
    if (report.damaged || (!leftovers_allowed && report.n_of[TTF_FINDING_LEFTOVER] > 0))
        fail_msg("%s: %s", report.findings[0].file, report.findings[0].text);
    ttf_verify_report_free(&report);
}

/* Opens with a sound disk, goes on to the end, and looks at everything. */
static void finish(const char *path, int64_t acknowledged, bool sha256sum)
{
    struct ttf_io *io = quick_io();
    struct ttf_writer *writer;
    struct ttf_segment s = {0};
    struct ttf_err err = {0};
    int r;

    r = ttf_writer_open(io, path, &writer, &err);
    if (r == -ENOENT && acknowledged == 0) { /* it had not come to be */
        writer = small_create(io, path);
        assert_non_null(writer);
    } else if (r != 0) {
        fail_msg("%s: %s", err.where, err.what);
    }
    assert_true(ttf_writer_state(writer)->next_index >= acknowledged);
    if (ttf_writer_state(writer)->n_segments == 0) {
        strcpy(s.trust, "none");
        s.origin_utc_ns = s.uncertainty_ns = TTF_NS_UNKNOWN;
        s.interval_ns = TTF_NS_PER_S;
        assert_int_equal(ttf_writer_segment(writer, &s, &err), 0);
    }
    while (ttf_writer_state(writer)->next_index < SLOTS + 1)
        assert_int_equal(small_slot(writer, ttf_writer_state(writer)->next_index), 0);
    if (sha256sum)
        assert_int_equal(sha256sum_check(path), 0);
    assert_int_equal(ttf_writer_seal(writer, "count", NULL, &err), 0);
    ttf_writer_close(writer);
    assert_int_equal(small_check(io, path), SLOTS + 1);
    assert_whole(path, false);
    if (sha256sum)
        assert_int_equal(sha256sum_check(path), 0);
}

/* Whether the calibration has its line, on a disk that does nothing from that operation on. */
static bool copied(const char *path, const char *cal, long at)
{
    struct cue cue = {.error = EIO, .for_ever = true};
    struct ttf_io *io = ttf_io_faulty_create(quick_io(), cue_fault, &cue);
    struct ttf_writer *writer;
    bool done;

    assert_non_null(io);
    assert_int_equal(ttf_writer_open(io, path, &writer, NULL), 0);
    cue.at = cue.n + at;
    done = ttf_writer_calibration(writer, "cal-1", cal, NULL) == 0;
    ttf_writer_abandon(writer);
    ttf_io_faulty_destroy(io);
    return done;
}

/* The run is gone on with, with another calibration: nothing of the half one is left, or it is whole. */
static void go_on_with_another(const char *path, const char *other)
{
    char cal_1[300];
    struct ttf_writer *writer;
    bool whole;

    snprintf(cal_1, sizeof(cal_1), "%s", in(path, "calibration/cal-1"));
    assert_int_equal(ttf_writer_open(quick_io(), path, &writer, NULL), 0);
    whole = exists(in(cal_1, "calibration.json"));
    assert_true(exists(in(cal_1, "dark.tif")) == whole);
    assert_true(exists(in(cal_1, "flat.tif")) == whole);
    assert_int_equal(ttf_writer_calibration(writer, "cal-2", other, NULL), 0);
    assert_int_equal(small_slot(writer, 0), 0);
    ttf_writer_close(writer);
    assert_whole(path, whole);
}

static void a_calibration_is_copied_whole_or_not_at_all(void **state)
{
    char cal[300], other[300], path[300]; /* the buffers of in() come round */
    bool done = false;
    long at;

    snprintf(cal, sizeof(cal), "%s", in(*state, "cal"));
    snprintf(other, sizeof(other), "%s", in(*state, "other"));
    snprintf(path, sizeof(path), "%s", in(*state, "d"));
    assert_int_equal(run("mkdir '%s' '%s' && cd '%s' && echo {} | tee calibration.json dark.tif "
                         ">flat.tif && cp * '%s'",
                         cal, other, cal, other),
                     0);
    for (at = 1; !done; at++) {
        ttf_writer_close(small_create(quick_io(), path));
        done = copied(path, cal, at);
        go_on_with_another(path, other);
        assert_int_equal(run("rm -r '%s'", path), 0);
    }
    assert_true(at > 20); /* each of its operations was cut off */
}

/* A run on a disk that may fail: how many slots it was told are safe. */
static int64_t run_on(struct ttf_io *io, const char *path, bool seal, bool power_cut)
{
    struct ttf_writer *writer = small_create(io, path);
    int64_t done = 0;

    if (!writer)
        return 0;
    while (done < SLOTS && small_slot(writer, done) == 0)
        done++;
    if (done == SLOTS && ttf_writer_event(writer, "door", 1, 2, "opened", NULL, NULL) == 0 && seal)
        (void)!ttf_writer_seal(writer, "count", NULL, NULL);
    if (power_cut)
        ttf_writer_abandon(writer);
    else
        ttf_writer_close(writer);
    return done;
}

/* Fails operation 1, 2, 3, ... until a run needs no more of them. */
static void fail_each_operation(void **state, int error, bool for_ever)
{
    struct cue cue;
    struct ttf_io *io;
    int64_t done;
    char path[300];
    long at;

    for (at = 1;; at++) {
        snprintf(path, sizeof(path), "%s/d%ld", (char *)*state, at);
        memset(&cue, 0, sizeof(cue));
        cue.at = at;
        cue.error = error;
        cue.for_ever = for_ever;
        io = ttf_io_faulty_create(quick_io(), cue_fault, &cue);
        done = run_on(io, path, true, for_ever);
        ttf_io_faulty_destroy(io);
        if (exists(path) && exists(in(path, "dataset.json")))
            assert_whole(path, true);    /* before any repair */
        finish(path, done, at % 8 == 0); /* a process each: not every time */
        if (cue.n < at)
            break;
    }
    assert_true(at > 60);
}

static void the_disk_may_be_gone_from_any_operation_on(void **state)
{
    fail_each_operation(state, EIO, true);
}

static void any_one_operation_may_fail(void **state)
{
    fail_each_operation(state, EIO, false);
}

static void the_disk_may_be_full_at_any_operation(void **state)
{
    fail_each_operation(state, ENOSPC, false);
}

static void a_failed_sync_is_answered_with_a_new_name(void **state)
{
    const char *path = in(*state, "d");
    struct cue cue = {.at = 2, .error = EIO, .op = "sync", .in = "frames"};
    struct ttf_io *io = ttf_io_faulty_create(quick_io(), cue_fault, &cue);
    struct ttf_writer *writer = small_create(io, path);

    assert_int_equal(small_slot(writer, 0), 0);
    assert_int_equal(small_slot(writer, 1), 0);
    ttf_writer_close(writer);
    ttf_io_faulty_destroy(io);
    assert_true(exists(in(path, "frames/main/000000.tif")));
    assert_true(exists(in(path, "frames/main/000001.r1.tif")));
    assert_false(exists(in(path, "frames/main/000001.tif")));
    assert_int_equal(small_check(quick_io(), path), 2);
    assert_whole(path, false);
}

static void after_two_failed_syncs_the_error_is_told(void **state)
{
    const char *path = in(*state, "d");
    struct cue cue = {.at = 2, .error = EIO, .op = "sync", .in = "frames", .for_ever = true};
    struct ttf_io *io = ttf_io_faulty_create(quick_io(), cue_fault, &cue);
    struct ttf_writer *writer = small_create(io, path);

    assert_int_equal(small_slot(writer, 0), 0);
    assert_int_equal(small_slot(writer, 1), -EIO);
    assert_int_equal(cue.n, 3); /* not tried a third time */
    ttf_writer_close(writer);
    ttf_io_faulty_destroy(io);
    assert_int_equal(small_check(quick_io(), path), 1);
}

static void a_record_whose_sync_fails_is_written_as_a_new_file(void **state)
{
    const char *path = in(*state, "d");
    struct cue cue = {.at = 3, .error = EIO, .op = "sync", .in = "records.jsonl"};
    struct ttf_io *io = ttf_io_faulty_create(quick_io(), cue_fault, &cue);
    struct ttf_writer *writer = small_create(io, path);

    assert_int_equal(small_slot(writer, 0), 0);
    assert_int_equal(small_slot(writer, 1), 0);
    ttf_writer_close(writer);
    assert_true(cue.n > 3);
    ttf_io_faulty_destroy(io);
    assert_int_equal(small_check(quick_io(), path), 2);
    assert_whole(path, false);
}

static void a_newline_that_found_no_room_comes_before_the_next_line(void **state)
{
    const char *path = in(*state, "d");
    struct cue cue = {.error = ENOSPC, .op = "append", .in = "records.jsonl", .for_ever = true};
    struct ttf_io *io = ttf_io_faulty_create(quick_io(), cue_fault, &cue);
    struct ttf_writer *writer = small_create(io, path);

    cue.at = cue.n + 2;
    assert_int_equal(small_slot(writer, 0), 0);
    assert_int_equal(small_check(quick_io(), path), 1); /* readers count it */
    assert_int_equal(small_slot(writer, 1), -ENOSPC);
    cue.at = 0;
    assert_int_equal(small_slot(writer, 1), 0);
    ttf_writer_close(writer);
    ttf_io_faulty_destroy(io);
    assert_int_equal(small_check(quick_io(), path), 2);
    assert_int_equal(run("grep -c . '%s/records.jsonl' | grep -qx 4", path), 0);
}

static void order_of_a_commit(void **state)
{
    char log[4096] = "";
    struct cue cue = {.log = log, .log_room = sizeof(log)};
    struct ttf_io *io = ttf_io_faulty_create(quick_io(), cue_fault, &cue);
    struct ttf_writer *writer = small_create(io, in(*state, "d"));

    assert_int_equal(small_slot(writer, 0), 0);
    cue.log_used = 0;
    assert_int_equal(small_slot(writer, 1), 0);
    assert_string_equal(log, "unlink 000001.tif.tmp\n"
                             "open 000001.tif.tmp\n"
                             "append 000001.tif.tmp\n"
                             "append 000001.tif.tmp\n"
                             "sync 000001.tif.tmp\n"
                             "rename 000001.tif\n"
                             "sync_dir main\n"
                             "append records.jsonl\n"
                             "sync records.jsonl\n"
                             "append records.jsonl\n" /* the newline: DESIGN.md, "A line" */
                             "append SHA256SUMS\n");
    ttf_writer_close(writer);
    ttf_io_faulty_destroy(io);
}

/* A dataset of SLOTS slots as it lies on the disk, to be put back again and again. */
struct kept {
    char path[300];
    char *records, *events;
    size_t records_n, events_n;
};

static void keep(struct kept *k, void **state)
{
    snprintf(k->path, sizeof(k->path), "%s/d", (char *)*state);
    assert_int_equal(run_on(quick_io(), k->path, false, false), SLOTS);
    k->records = file_text(in(k->path, "records.jsonl"), &k->records_n);
    k->events = file_text(in(k->path, "events.jsonl"), &k->events_n);
}

static void put_back(const struct kept *k, size_t records_n)
{
    char bytes[64], path[400];
    int64_t i;

    write_text(in(k->path, "records.jsonl"), k->records, records_n);
    write_text(in(k->path, "events.jsonl"), k->events, k->events_n);
    (void)unlink(in(k->path, "SHA256SUMS"));
    for (i = 0; i < SLOTS; i++) {
        snprintf(path, sizeof(path), "%s/frames/main/%06d.tif", k->path, (int)i);
        small_bytes(i, bytes);
        if (!exists(path))
            write_text(path, bytes, 64);
    }
    snprintf(path, sizeof(path), "%s/frames/main/%06d.tif", k->path, SLOTS);
    (void)unlink(path);
}

/* Whole lines of type slot in the first n bytes; without newline too. */
static int64_t slots_within(const struct kept *k, size_t n)
{
    const char *at = k->records, *end;
    int64_t slots = 0;

    while ((end = memchr(at, '\n', (size_t)(k->records + k->records_n - at))) != NULL &&
           (size_t)(end - k->records) <= n) {
        slots += strncmp(at, "{\"type\":\"slot\"", 14) == 0;
        at = end + 1;
    }
    return slots;
}

static void records_may_be_cut_off_at_every_byte(void **state)
{
    struct ttf_writer *writer;
    struct ttf_err err = {0};
    struct kept k;
    int64_t slots;
    size_t n;

    keep(&k, state);
    for (n = 0; n <= k.records_n; n++) {
        put_back(&k, n);
        slots = slots_within(&k, n);
        if (n % 16 == 0)
            assert_whole(k.path, true);
        assert_int_equal(small_check(quick_io(), k.path), slots);
        if (ttf_writer_open(quick_io(), k.path, &writer, &err) != 0)
            fail_msg("at %zu: %s: %s", n, err.where, err.what);
        assert_int_equal(ttf_writer_state(writer)->next_index, slots);
        if (ttf_writer_state(writer)->n_segments > 0)
            assert_int_equal(small_slot(writer, slots), 0);
        else
            slots--;
        ttf_writer_close(writer);
        assert_int_equal(small_check(quick_io(), k.path), slots + 1);
        if (n % 16 == 0 && slots >= SLOTS - 1)
            assert_whole(k.path, false);
    }
    free(k.records);
    free(k.events);
}

static void events_may_be_cut_off_at_every_byte(void **state)
{
    struct ttf_writer *writer;
    struct ttf_err err = {0};
    struct kept k;
    size_t n, whole;

    keep(&k, state);
    whole = k.events_n;
    for (n = 0; n <= whole; n++) {
        k.events_n = n;
        put_back(&k, k.records_n);
        if (ttf_writer_open(quick_io(), k.path, &writer, &err) != 0)
            fail_msg("at %zu: %s: %s", n, err.where, err.what);
        assert_int_equal(ttf_writer_event(writer, "resume", 1, 2, "", NULL, &err), 0);
        ttf_writer_close(writer);
        assert_whole(k.path, false);
    }
    free(k.records);
    free(k.events);
}

static void what_was_cut_off_is_set_aside_as_an_event(void **state)
{
    struct ttf_writer *writer;
    struct kept k;
    char *text;

    keep(&k, state);
    put_back(&k, k.records_n);
    assert_int_equal(run("printf '{\"type\":\"sl' >> '%s/records.jsonl'", k.path), 0);
    assert_int_equal(ttf_writer_open(quick_io(), k.path, &writer, NULL), 0);
    assert_true(ttf_writer_state(writer)->repaired >= 1);
    ttf_writer_close(writer);
    text = file_text(in(k.path, "events.jsonl"), NULL);
    assert_non_null(strstr(text, "\"kind\":\"repair\""));
    assert_non_null(strstr(text, "\"hex\":\"7b2274797065223a22736c\""));
    free(text);
    free(k.records);
    free(k.events);
}

static void a_lost_newline_between_two_lines_spares_the_first(void **state)
{
    struct ttf_writer *writer;
    struct kept k;
    size_t n;

    keep(&k, state);
    put_back(&k, k.records_n);
    /* The newline of slot 1 never reached the disk; slot 2's line did in part. */
    n = (size_t)(strstr(k.records, "\"index\":2") - k.records) + 40;
    while (k.records[n] != '\n' && n > 0)
        n--;
    k.records[n] = '\0';
    write_text(in(k.path, "records.jsonl"), k.records, n + 60);
    assert_int_equal(small_check(quick_io(), k.path), 2);
    assert_int_equal(ttf_writer_open(quick_io(), k.path, &writer, NULL), 0);
    assert_int_equal(ttf_writer_state(writer)->next_index, 2);
    ttf_writer_close(writer);
    free(k.records);
    free(k.events);
    finish(k.path, 2, true);
}

static void files_of_one_uncommitted_slot_are_reclaimed_of_several_left_alone(void **state)
{
    struct ttf_writer *writer;
    struct kept k;

    keep(&k, state);
    write_text(in(k.path, "frames/main/000003.tif"), "x", 1);
    write_text(in(k.path, "frames/main/000003.r1.tif.tmp"), "x", 1);
    assert_int_equal(ttf_writer_open(quick_io(), k.path, &writer, NULL), 0);
    ttf_writer_close(writer);
    assert_false(exists(in(k.path, "frames/main/000003.tif")));
    assert_false(exists(in(k.path, "frames/main/000003.r1.tif.tmp")));
    write_text(in(k.path, "frames/main/000003.tif"), "x", 1);
    write_text(in(k.path, "frames/main/000004.tif"), "y", 1);
    assert_int_equal(ttf_writer_open(quick_io(), k.path, &writer, NULL), 0);
    assert_int_equal(small_slot(writer, 3), 0); /* under another name */
    ttf_writer_close(writer);
    assert_int_equal(size_of(in(k.path, "frames/main/000003.tif")), 1);
    assert_int_equal(size_of(in(k.path, "frames/main/000004.tif")), 1);
    assert_int_equal(size_of(in(k.path, "frames/main/000003.r1.tif")), 64);
    free(k.records);
    free(k.events);
}

/* Full until the reserve gives something back. */
static int full_disk(void *ctx, const char *op, const char *path)
{
    bool *full = ctx;

    if (*full && strcmp(op, "truncate") == 0 && strstr(path, ".events-reserve"))
        *full = false;
    return *full && strcmp(op, "append") == 0 ? ENOSPC : 0;
}

/* Appends a slot line whose crc holds and whose file has no sha256 that could be. */
static void append_bad_entry(const char *path, int64_t seq)
{
    static const char TEXT[] =
        "\"index\":%d,\"segment\":0,\"due_ns\":0,\"result\":\"captured\","
        "\"images\":[{\"stream\":\"main\",\"n_averaged\":1,\"files\":[{\"role\":"
        "\"developed\",\"path\":\"frames/main/000001.tif\",\"bytes\":1,"
        "\"sha256\":\"no hash\"}]}]";
    char line[512], whole[600];
    size_t n, old;
    char *text = file_text(in(path, "records.jsonl"), &old);
    char *both = malloc(old + sizeof whole);

    assert_non_null(both);
    n = (size_t)snprintf(line, sizeof line, "{\"type\":\"slot\",\"seq\":%d,", (int)seq);
    n += (size_t)snprintf(line + n, sizeof line - n, TEXT, 1);
    n = (size_t)snprintf(whole, sizeof whole, "%s,\"crc\":\"%08x\"}\n", line,
                         ttf_crc32(0, line, n));
    memcpy(both, text, old);
    memcpy(both + old, whole, n);
    write_text(in(path, "records.jsonl"), both, old + n);
    free(both);
    free(text);
}

/* Found by the fuzzer: it was opened, and the damage came up at the first write, or half-way in a repair. */
static void a_file_entry_that_cannot_be_is_refused_before_anything_is_touched(void **state)
{
    const char *path = in(*state, "d");
    struct ttf_writer *writer = small_create(quick_io(), path);
    struct ttf_err err = {0};

    assert_int_equal(small_slot(writer, 0), 0);
    ttf_writer_close(writer);
    append_bad_entry(path, 3); /* behind plan, segment and slot */
    write_text(in(path, "SHA256SUMS"), "", 0);
    write_text(in(path, "frames/main/000005.tif.tmp"), "half", 4);
    assert_int_equal(ttf_writer_open(quick_io(), path, &writer, &err), -TTF_EDAMAGED);
    assert_non_null(strstr(err.where, "records.jsonl:4"));
    assert_non_null(strstr(err.what, "sha256"));
    assert_true(exists(in(path, "frames/main/000005.tif.tmp")));
    assert_int_equal(size_of(in(path, "SHA256SUMS")), 0);
    /* Sealed, the same. */
    write_text(in(path, "SHA256SUMS"),
               "0000000000000000000000000000000000000000000000000000000000000000  records.jsonl\n",
               80);
    assert_int_equal(ttf_writer_open(quick_io(), path, &writer, &err), -TTF_EDAMAGED);
}

static void events_are_written_on_a_full_disk(void **state)
{
    const char *path = in(*state, "d");
    bool full = false;
    struct ttf_io *io = ttf_io_faulty_create(quick_io(), full_disk, &full);
    struct ttf_writer *writer = small_create(io, path);
    int64_t before = size_of(in(path, ".events-reserve"));

    assert_true(before >= 64 * 1024);
    full = true;
    assert_int_equal(small_slot(writer, 0), -ENOSPC);
    assert_int_equal(ttf_writer_event(writer, "disk", 1, 2, "full", NULL, NULL), 0);
    assert_true(size_of(in(path, ".events-reserve")) < before);
    assert_int_equal(run("grep -q '\"disk\"' '%s/events.jsonl'", path), 0);
    assert_int_equal(small_slot(writer, 0), 0); /* there is room again */
    ttf_writer_close(writer);
    ttf_io_faulty_destroy(io);
    assert_whole(path, false);
}

int main(void)
{
#define T(f) cmocka_unit_test_setup_teardown(f, folder_setup, folder_teardown)
    const struct CMUnitTest tests[] = {
        T(order_of_a_commit),
        T(the_disk_may_be_gone_from_any_operation_on),
        T(any_one_operation_may_fail),
        T(the_disk_may_be_full_at_any_operation),
        T(a_failed_sync_is_answered_with_a_new_name),
        T(after_two_failed_syncs_the_error_is_told),
        T(a_record_whose_sync_fails_is_written_as_a_new_file),
        T(a_newline_that_found_no_room_comes_before_the_next_line),
        T(records_may_be_cut_off_at_every_byte),
        T(events_may_be_cut_off_at_every_byte),
        T(what_was_cut_off_is_set_aside_as_an_event),
        T(a_lost_newline_between_two_lines_spares_the_first),
        T(files_of_one_uncommitted_slot_are_reclaimed_of_several_left_alone),
        T(a_file_entry_that_cannot_be_is_refused_before_anything_is_touched),
        T(events_are_written_on_a_full_disk),
        T(a_calibration_is_copied_whole_or_not_at_all),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
