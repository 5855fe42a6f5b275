/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Opening an unsealed dataset to go on, cut off in the middle of a commit: by its records
 * alone, whatever its length. Counted through the I/O table; how long it takes is said
 * and never judged (`./dev bench recovery`).
 *
 *   store_recovery [SLOTS]
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "store_ios.h"
#include "store_test.h"
#include "ttf/hal/clock.h"

static int64_t n_slots = 2500;

/* The machine's table, but what is read of images is counted. */
static long image_opens, opens;

static int counting_open(struct ttf_io *io, const char *path, enum ttf_io_mode mode)
{
    opens++;
    image_opens += strstr(path, "/frames/main/") || strstr(path, "/raw/main/");
    return ttf_io_posix()->ops->open(io, path, mode);
}

static struct ttf_io *counting_io(void)
{
    static struct ttf_io_ops ops;
    static struct ttf_io io = {.ops = &ops};

    ops = *ttf_io_posix()->ops;
    ops.open = counting_open;
    image_opens = opens = 0;
    return &io;
}

/* Slot n_slots: its file is there, another is being written, its record is torn. */
static void cut_in_a_commit(const char *path)
{
    struct ttf_writer *writer = small_create(quick_io(), path);

    assert_non_null(writer);
    for (int64_t i = 0; i < n_slots; i++)
        assert_int_equal(small_slot(writer, i), 0);
    ttf_writer_abandon(writer);
    write_text(in(path, "frames/main/%06lld.tif", (long long)n_slots), "whole", 5);
    write_text(in(path, "frames/main/%06lld.mask.tif.tmp", (long long)n_slots), "half", 4);
    assert_int_equal(run("printf '{\"type\":\"slot\",\"se' >> '%s/records.jsonl'", path), 0);
    assert_int_equal(run("truncate -s -1000 '%s/SHA256SUMS'", path), 0);
}

static void a_cut_dataset_is_recovered_by_its_records_alone(void **state)
{
    struct ttf_clock *clock = ttf_clock_real_create();
    const char *path = in(*state, "d");
    struct ttf_writer *writer;
    struct ttf_err err = {0};
    int64_t begin_ns, took_ns;

    cut_in_a_commit(path);
    begin_ns = ttf_clock_now_ns(clock);
    if (ttf_writer_open(counting_io(), path, &writer, &err) != 0)
        fail_msg("%s: %s", err.where, err.what);
    took_ns = ttf_clock_now_ns(clock) - begin_ns;
    print_message("%lld slots, cut in a commit: open to go on after %.1f ms; %ld files opened, "
                  "%ld of them images\n",
                  (long long)n_slots, (double)took_ns / 1e6, opens, image_opens);
    assert_int_equal(image_opens, 0);
    assert_true(opens < 20); /* logs, SHA256SUMS, dataset.json, the folder, the reserve */
    assert_int_equal(ttf_writer_state(writer)->next_index, n_slots);
    assert_true(ttf_writer_state(writer)->repaired >= 4);
    assert_false(exists(in(path, "frames/main/%06lld.tif", (long long)n_slots)));
    assert_int_equal(small_slot(writer, n_slots), 0);
    ttf_writer_close(writer);
    assert_int_equal(small_check(ttf_io_posix(), path), n_slots + 1);
    assert_int_equal(sha256sum_check(path), 0);
    ttf_clock_destroy(clock);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(a_cut_dataset_is_recovered_by_its_records_alone,
                                        folder_setup, folder_teardown),
    };

    if (argc > 1)
        n_slots = strtoll(argv[1], NULL, 10);
    return cmocka_run_group_tests(tests, NULL, NULL);
}
