/* SPDX-License-Identifier: Apache-2.0 */
/* Every file operation of a pull fails on the side that pulls, once or for good, in every way (README.md). */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "faults.h"
#include "pull_box.h"
#include "unit/http/scratch.h"

#define LOG_ROOM 2000
#define SHARE    23 /* of what may fail, each so-manieth does; of some kinds each QUICK-th */
#define QUICK    4

static bool everything; /* set once, by main */

/* The operations of a pull on which nothing fails. */
static long clean_pull(struct pull_box *box, uint64_t device, struct model_call *log)
{
    struct ttf_pull_result result;
    struct model_disk disk;
    char text[SMALL_TEXT] = "";
    struct ttf_err err = {0};
    long n;

    model_disk_init(&disk);
    model_disk_fail(&disk, (struct model_fault){0});
    disk.device = device;
    disk.log = log;
    disk.log_room = LOG_ROOM;
    if (pull_box_pull(box, &disk, &result, &err) < 0)
        fail_msg("%s: %s", err.where, err.what);
    n = disk.n;
    disk.log = NULL;
    assert_int_equal(result.sealed, 1);
    model_disk_lose_power(&disk);
    if (!pull_box_is_same(box, &disk, text))
        fail_msg("after a power cut: %s", text);
    model_disk_free(&disk);
    assert_true(n > 60 && n < LOG_ROOM);
    return n;
}

/* ---- what must hold ---- */

#define WRONG(...) return (void)snprintf(ret, SMALL_TEXT, __VA_ARGS__), false

/* Run again on a sound disk, it brings the rest. */
static bool goes_on(struct pull_box *box, struct model_disk *disk, char ret[SMALL_TEXT])
{
    struct ttf_pull_result result;
    struct ttf_err err = {0};
    int r;

    model_disk_fail(disk, (struct model_fault){0});
    if (!pull_box_is_whole(disk, ret))
        return false;
    r = pull_box_pull(box, disk, &result, &err);
    if (r < 0)
        WRONG("pulled again: %s: %s (%d)", err.where, err.what, r);
    if (result.sealed != 1 || result.damaged != 0)
        WRONG("pulled again, it is not sealed");
    if (!pull_box_is_whole(disk, ret) || !pull_box_is_same(box, disk, ret))
        return false;
    model_disk_lose_power(disk); /* what was said to be here is on the disk */
    return pull_box_is_whole(disk, ret) && pull_box_is_same(box, disk, ret);
}

struct figures {
    long injections, recovered, told, wrong;
};

static void wrong(struct figures *figures, const char *what, const char *text)
{
    if (figures->wrong++ < 20)
        print_error("%s: %s\n", what, text);
}

static void one(struct pull_box *box, uint64_t device, const struct fault_kind *kind, long at,
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
    disk.device = device;
    fault.at = at;
    model_disk_fail(&disk, fault);
    r = pull_box_pull(box, &disk, &result, &err);
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

/* On a disk that can be synced as a whole, or not. */
static long each_on(struct pull_box *box, uint64_t device)
{
    static struct model_call log[LOG_ROOM];
    long n = clean_pull(box, device, log), all_wrong = 0;

    for (unsigned i = 0; i < n_fault_kinds; i++) {
        struct figures figures = {0};

        for (long at = 1; at <= n; at++)
            if (fault_fits(&fault_kinds[i], &log[at - 1]) &&
                (everything || log[at - 1].op == OP_SYNC_ALL ||
                 (at + i) % (is_of_all(&fault_kinds[i]) ? QUICK : SHARE) == 0))
                one(box, device, &fault_kinds[i], at, &log[at - 1], &figures);
        print_message("%-28s %5ld injected: %ld recovered, %ld told\n", fault_kinds[i].name,
                      figures.injections, figures.recovered, figures.told);
        all_wrong += figures.wrong;
    }
    return all_wrong;
}

static void each_operation_fails(void **state)
{
    static struct pull_box box;
    long all_wrong = 0;

    (void)state;
    pull_box_begin(&box, 0);
    for (uint64_t device = 0; device < 2; device++)
        all_wrong += each_on(&box, device);
    pull_box_end(&box);
    assert_int_equal(all_wrong, 0);
}

/* What the dataset takes, of all that is on the box's disk. */
static int64_t bytes_of_dataset(const struct model_disk *disk)
{
    int64_t bytes = 0;

    for (int i = 0; i < disk->n_names; i++)
        if (disk->names[i].seen >= 0 &&
            strncmp(disk->names[i].path, SMALL_PATH "/", strlen(SMALL_PATH) + 1) == 0)
            bytes += (int64_t)disk->inodes[disk->names[i].seen].seen_bytes;
    return bytes;
}

/* Each size of the disk, from nothing to all that the dataset takes. */
static void a_full_disk_takes_what_fits_and_goes_on_when_there_is_room(void **state)
{
    static struct pull_box box;
    struct figures figures = {0};

    (void)state;
    pull_box_begin(&box, 0);
    for (int64_t room = 1; room < bytes_of_dataset(&box.disk); room += everything ? 13 : 397) {
        char what[64], text[SMALL_TEXT] = "";
        struct ttf_pull_result result;
        struct model_disk disk;
        struct ttf_err err = {0};
        int r;

        (void)snprintf(what, sizeof what, "a disk of %lld bytes", (long long)room);
        model_disk_init(&disk);
        disk.capacity_bytes = room;
        r = pull_box_pull(&box, &disk, &result, &err);
        if (r != -ENOSPC || err.code != r)
            wrong(&figures, what, r == 0 ? "all is said to be here" : err.what);
        disk.capacity_bytes = 0;
        if (!goes_on(&box, &disk, text))
            wrong(&figures, what, text);
        figures.injections++;
        model_disk_free(&disk);
    }
    pull_box_end(&box);
    assert_true(figures.injections > 5);
    assert_int_equal(figures.wrong, 0);
}

static void what_another_program_is_writing_is_left_alone(void **state)
{
    static struct pull_box box;
    struct ttf_pull_result result;
    struct model_disk disk;
    struct ttf_err err = {0};
    int file;

    (void)state;
    pull_box_begin(&box, 0);
    model_disk_init(&disk);
    assert_int_equal(pull_box_pull(&box, &disk, &result, &err), 0);
    file = disk.io.ops->open(&disk.io, SMALL_PATH, TTF_IO_READ);
    assert_true(file >= 0);
    assert_int_equal(disk.io.ops->lock(&disk.io, file), 0);
    assert_int_equal(pull_box_pull(&box, &disk, &result, &err), -EBUSY);
    assert_int_equal(disk.io.ops->close(&disk.io, file), 0);
    assert_int_equal(pull_box_pull(&box, &disk, &result, &err), 0);
    model_disk_free(&disk);
    pull_box_end(&box);
}

/* ---- many files, made durable together ---- */

#define MANY 2300 /* slots: more than two batches */

static unsigned pictures_seen(struct model_disk *disk)
{
    unsigned n = 0;

    for (int i = 0; i < disk->n_names; i++)
        n += disk->names[i].seen >= 0 && strstr(disk->names[i].path, "/frames/main/") &&
             strstr(disk->names[i].path, ".tif");
    return n;
}

static unsigned slots_seen(const struct model_disk *disk)
{
    unsigned n = 0;

    for (int i = 0; i < disk->n_names; i++)
        if (disk->names[i].seen >= 0 &&
            strcmp(disk->names[i].path, SMALL_PATH "/records.jsonl") == 0) {
            const struct model_inode *inode = &disk->inodes[disk->names[i].seen];

            for (size_t k = 0; k + 13 <= inode->seen_bytes; k++)
                n += memcmp(inode->seen + k, "\"type\":\"slot\"", 13) == 0;
        }
    return n;
}

static void fails_at_sync(struct pull_box *box, long nth, long lasts, struct model_disk *ret)
{
    struct ttf_pull_result result;
    struct ttf_err err = {0};

    model_disk_init(ret);
    ret->device = 1;
    model_disk_fail(ret,
                    (struct model_fault){
                        .at = nth, .of_op = true, .op = OP_SYNC_ALL, .error = EIO, .lasts = lasts});
    assert_int_equal(pull_box_pull(box, ret, &result, &err), -EIO);
    assert_int_equal(result.damaged, 0);
    assert_int_equal(ret->failed.op, OP_SYNC_ALL);
}

static void goes_on_or_fail(struct pull_box *box, struct model_disk *disk)
{
    char text[SMALL_TEXT] = "";

    if (!goes_on(box, disk, text))
        fail_msg("%s", text);
}

/* Whose bytes a sync of all did not bring over is not known: neither lines nor pictures behind it stay, those of the next batch included. */
static void what_a_failed_sync_of_all_was_for_is_taken_away(void **state)
{
    static struct pull_box box;
    struct model_disk disk;
    unsigned lines;

    (void)state;
    pull_box_begin(&box, MANY);
    fails_at_sync(&box, 1, 1, &disk);
    assert_int_equal(pictures_seen(&disk), 0);
    goes_on_or_fail(&box, &disk);
    model_disk_free(&disk);
    fails_at_sync(&box, 2, 1, &disk);
    lines = slots_seen(&disk);
    assert_true(lines > 200);
    assert_int_equal(pictures_seen(&disk), lines);
    goes_on_or_fail(&box, &disk);
    model_disk_free(&disk);
    pull_box_end(&box);
}

/* The power goes while the second batch is not synced yet: what has a line is there, and some have. */
static void a_power_cut_before_a_batch_is_synced_takes_that_batch_alone(void **state)
{
    static struct pull_box box;
    struct model_disk disk;
    unsigned lines;

    (void)state;
    pull_box_begin(&box, MANY);
    fails_at_sync(&box, 2, LONG_MAX, &disk);
    lines = slots_seen(&disk);
    model_disk_lose_power(&disk);
    assert_true(lines > 200);
    assert_int_equal(slots_seen(&disk), lines);
    assert_true(pictures_seen(&disk) >= lines);
    goes_on_or_fail(&box, &disk);
    model_disk_free(&disk);
    pull_box_end(&box);
}

/* The box's records without their last three lines, and without a seal: what a power cut left of them. */
static void forget_last_lines(void)
{
    static char text[1 << 20];
    FILE *file = fopen("data/d/records.jsonl", "r+");
    size_t n;

    assert_non_null(file);
    n = fread(text, 1, sizeof text, file);
    for (unsigned lines = 0; lines < 3; n--)
        lines += n >= 2 && text[n - 2] == '\n';
    assert_true(n > 0 && text[n - 1] == '\n');
    assert_int_equal(ftruncate(fileno(file), (off_t)n), 0);
    assert_int_equal(fclose(file), 0);
    assert_int_equal(unlink("data/d/SHA256SUMS"), 0);
}

/* A pull that ends at operation at of taking lines back, with or without the power. 0: it got through. */
static int taken_back_until(struct pull_box *box, struct model_disk *whole, long at, bool dark)
{
    struct ttf_pull_result result;
    struct model_disk disk;
    struct ttf_err err = {0};
    char text[SMALL_TEXT] = "";
    int r;

    model_disk_copy(&disk, whole);
    model_disk_fail(&disk, (struct model_fault){.at = at, .error = EIO, .lasts = LONG_MAX});
    r = pull_box_pull(box, &disk, &result, &err);
    model_disk_fail(&disk, (struct model_fault){0});
    if (dark)
        model_disk_lose_power(&disk);
    if (!pull_box_is_whole(&disk, text))
        fail_msg("cut off at operation %ld%s: %s", at, dark ? " with the power" : "", text);
    if (r == 0) {
        if (!dark) /* else the disk may not have heard that files went: they are nobody's */
            assert_int_equal(pictures_seen(&disk), slots_seen(&disk));
        assert_true(slots_seen(&disk) < slots_seen(whole));
    }
    model_disk_free(&disk);
    return r;
}

/* The box lost lines that were pulled: cut off anywhere while they are taken back, no line here is without its file. */
static void lines_that_the_box_lost_go_before_their_files(void **state)
{
    static struct pull_box box;
    struct ttf_pull_result result;
    struct model_disk disk;
    struct ttf_err err = {0};
    long n = 0;

    (void)state;
    pull_box_begin(&box, 8);
    model_disk_init(&disk);
    assert_int_equal(pull_box_pull(&box, &disk, &result, &err), 0);
    assert_int_equal(result.sealed, 1);
    forget_last_lines();
    for (int dark = 0; dark < 2; dark++)
        for (n = 1; taken_back_until(&box, &disk, n, dark != 0) < 0; n++)
            ;
    assert_true(n > 20);
    model_disk_free(&disk);
    pull_box_end(&box);
}

/* "all": every operation fails in every way; else a share of it, in some seconds. */
int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(each_operation_fails, scratch_make, scratch_remove),
        cmocka_unit_test_setup_teardown(a_full_disk_takes_what_fits_and_goes_on_when_there_is_room,
                                        scratch_make, scratch_remove),
        cmocka_unit_test_setup_teardown(what_a_failed_sync_of_all_was_for_is_taken_away,
                                        scratch_make, scratch_remove),
        cmocka_unit_test_setup_teardown(a_power_cut_before_a_batch_is_synced_takes_that_batch_alone,
                                        scratch_make, scratch_remove),
        cmocka_unit_test_setup_teardown(lines_that_the_box_lost_go_before_their_files, scratch_make,
                                        scratch_remove),
        cmocka_unit_test_setup_teardown(what_another_program_is_writing_is_left_alone, scratch_make,
                                        scratch_remove),
    };

    everything = argc > 1 && strcmp(argv[1], "all") == 0;
    return cmocka_run_group_tests(tests, NULL, NULL);
}
