/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What the kernel is told: every sync that the store believes in is a call of the kernel's, on the file or folder that is
 * meant, in its place among the renames; and what the kernel answers is what the store hears. The calls of this program
 * are wrapped (CMakeLists.txt): each is noted, made, and can be made to fail.
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
#include <unistd.h>

#include "export_staging.h"
#include "store_test.h"
#include "ttf/dataset/calibration.h"

#define CALLS_MAX 200

/* "fsync NAME", "rename NAME"; of names the last part, of a rename the new one. */
static struct {
    unsigned n;
    char call[CALLS_MAX][64];
    int answer; /* errno of the next syncs; 0: the kernel's own */
} told;

static void note(const char *what, const char *path)
{
    const char *slash = strrchr(path, '/');

    assert_true(told.n < CALLS_MAX);
    snprintf(told.call[told.n++], sizeof(told.call[0]), "%s %.40s", what, slash ? slash + 1 : path);
}

static int synced(const char *what, int fd, int real(int))
{
    char link[40], path[512];
    ssize_t n;

    snprintf(link, sizeof(link), "/proc/self/fd/%d", fd);
    n = readlink(link, path, sizeof(path) - 1);
    assert_true(n > 0);
    path[n] = '\0';
    note(what, path);
    if (told.answer == 0)
        return real(fd);
    errno = told.answer;
    return -1;
}

/* The names that the linker gives. NOLINTBEGIN(bugprone-reserved-identifier,cert-dcl37-c,cert-dcl51-cpp) */
int __real_fsync(int fd);
int __real_fdatasync(int fd);
int __real_syncfs(int fd);
int __real_rename(const char *from, const char *to);
int __wrap_fsync(int fd);
int __wrap_fdatasync(int fd);
int __wrap_syncfs(int fd);
int __wrap_rename(const char *from, const char *to);
/* NOLINTEND(bugprone-reserved-identifier,cert-dcl37-c,cert-dcl51-cpp) */

int __wrap_fsync(int fd)
{
    return synced("fsync", fd, __real_fsync);
}

int __wrap_fdatasync(int fd)
{
    return synced("fdatasync", fd, __real_fdatasync);
}

int __wrap_syncfs(int fd)
{
    return synced("syncfs", fd, __real_syncfs);
}

int __wrap_rename(const char *from, const char *to)
{
    note("rename", to);
    return __real_rename(from, to);
}

static void forget(void)
{
    memset(&told, 0, sizeof(told));
}

/* Where it came for the first time from call `from` on; fails if it did not. */
static unsigned came_after(unsigned from, const char *call)
{
    unsigned i;

    for (i = from; i < told.n; i++)
        if (strcmp(told.call[i], call) == 0)
            return i;
    for (i = 0; i < told.n; i++)
        print_error("%2u %s\n", i, told.call[i]);
    fail_msg("no '%s' from call %u on", call, from);
    return 0;
}

/* They came in this order, others between them or not; ends in NULL. */
static void expect_order(const char *const calls[])
{
    unsigned at = 0, i;

    for (i = 0; calls[i]; i++)
        at = came_after(at, calls[i]) + 1;
}

static unsigned count(const char *call)
{
    unsigned n = 0;

    for (unsigned i = 0; i < told.n; i++)
        n += strncmp(told.call[i], call, strlen(call)) == 0;
    return n;
}

/* ---- the table ---- */

static int open_file(struct ttf_io *io, const char *path)
{
    int file = io->ops->open(io, path, TTF_IO_APPEND);

    assert_true(file >= 0);
    assert_int_equal(ttf_io_append_all(io, file, "bytes", 5), 0);
    return file;
}

static void each_sync_is_a_call_of_the_kernel_s(void **state)
{
    struct ttf_io *io = ttf_io_posix();
    int file = open_file(io, in(*state, "file"));
    int r;

    forget();
    assert_int_equal(io->ops->sync(io, file, false), 0);
    assert_int_equal(told.n, 1);
    assert_string_equal(told.call[0], "fsync file");
    assert_int_equal(io->ops->sync(io, file, true), 0);
    assert_int_equal(told.n, 2);
    assert_string_equal(told.call[1], "fdatasync file");
    assert_int_equal(io->ops->mkdir(io, in(*state, "folder")), 0);
    assert_int_equal(io->ops->sync_dir(io, in(*state, "folder")), 0);
    assert_int_equal(told.n, 3);
    assert_string_equal(told.call[2], "fsync folder");
    /* Where it can say that all is written, it was; elsewhere it says so and is not asked. */
    r = io->ops->sync_all(io, file);
    assert_true(r == 0 || r == -EOPNOTSUPP);
    assert_int_equal(count("syncfs"), r == 0);
    assert_int_equal(io->ops->close(io, file), 0);
}

static void what_the_kernel_answers_is_heard(void **state)
{
    struct ttf_io *io = ttf_io_posix();
    int file = open_file(io, in(*state, "file"));
    int r;

    forget();
    told.answer = EIO;
    assert_int_equal(io->ops->sync(io, file, false), -EIO);
    assert_int_equal(io->ops->sync(io, file, true), -EIO);
    assert_int_equal(io->ops->sync_dir(io, *state), -EIO);
    r = io->ops->sync_all(io, file);
    assert_true(r == -EIO || r == -EOPNOTSUPP);
    /* A sync that was interrupted is no sync, and is not made again as if it were the first. */
    told.answer = EINTR;
    assert_int_equal(io->ops->sync(io, file, false), -EINTR);
    assert_int_equal(count("fsync file"), 2);
    /* A folder that cannot be synced on its file system, and that alone, counts as synced. */
    told.answer = EINVAL;
    assert_int_equal(io->ops->sync_dir(io, *state), 0);
    assert_int_equal(io->ops->sync(io, file, false), -EINVAL);
    forget();
    assert_int_equal(io->ops->close(io, file), 0);
}

/* ---- what stands on it ---- */

static void the_kernel_is_told_of_each_sync_of_a_commit_in_its_order(void **state)
{
    static const char *const creating[] = {"fsync 0.json.tmp",
                                           "rename 0.json",
                                           "fsync plans",
                                           "fsync dataset.json.tmp",
                                           "rename dataset.json",
                                           "fsync d",
                                           "fdatasync records.jsonl",
                                           NULL};
    struct ttf_writer *writer;

    forget();
    writer = small_create(ttf_io_posix(), in(*state, "d"));
    expect_order(creating);
    for (int64_t k = 0; k < 2; k++) {
        char file[40], name[40];
        const char *const slot[] = {file, name, "fsync main", "fdatasync records.jsonl", NULL};

        forget();
        snprintf(file, sizeof(file), "fsync %06d.tif.tmp", (int)k);
        snprintf(name, sizeof(name), "rename %06d.tif", (int)k);
        assert_int_equal(small_slot(writer, k), 0);
        expect_order(slot);
    }
    forget();
    assert_int_equal(ttf_writer_seal(writer, "count", (char[65]){0}, NULL), 0);
    expect_order(
        (const char *const[]){"fsync SHA256SUMS.tmp", "rename SHA256SUMS", "fsync d", NULL});
    ttf_writer_close(writer);
}

static void a_calibration_is_on_the_disk_before_it_has_its_names(void **state)
{
    static const char *const calls[] = {
        "fsync .dark.tif.tmp",     "rename dark.tif", "fsync calibration.json.tmp",
        "rename calibration.json", "fsync cal",       NULL};
    struct ttf_calibration calibration;

    ttf_calibration_init(&calibration);
    calibration.has_dark = true;
    calibration.width = calibration.height = 4;
    calibration.cfa = TTF_CFA_RGGB;
    calibration.dark_offset_16 = calloc(16, sizeof(int32_t));
    assert_non_null(calibration.dark_offset_16);
    assert_int_equal(ttf_calibration_name(&calibration, NULL), 0);
    forget();
    assert_int_equal(ttf_calibration_save(&calibration, ttf_io_posix(), in(*state, "cal"), NULL),
                     0);
    expect_order(calls);
    assert_int_equal(count("fsync cal"), 2); /* calibration.json.tmp and the folder */
    ttf_calibration_free(&calibration);
}

/* ---- what is exported ---- */

static int produce(void *ctx, struct ttf_io *io, int file, struct ttf_err *err)
{
    (void)ctx;
    (void)err;
    return ttf_io_append_all(io, file, "bytes", 5);
}

static void an_exported_file_is_on_the_disk_before_it_has_its_name(void **state)
{
    struct ttf_io *io = ttf_io_posix();
    struct staging staging = {0};
    char temp[300], call[100];

    assert_int_equal(staging_begin(&staging, io, in(*state, "film"), false, NULL), 0);
    snprintf(temp, sizeof(temp), "%s", staging.temp);
    write_text(temp, "bytes", 5); /* as a child writes it, who syncs nothing */
    forget();
    assert_int_equal(staging_commit(&staging, NULL), 0);
    snprintf(call, sizeof(call), "fsync %.40s", strrchr(temp, '/') + 1);
    assert_int_equal(told.n, 3);
    assert_string_equal(told.call[0], call);
    assert_string_equal(told.call[1], "rename film");
    assert_memory_equal(told.call[2], "fsync ", 6); /* the folder */
}

static void an_exported_folder_is_on_the_disk_before_it_has_its_name(void **state)
{
    struct ttf_io *io = ttf_io_posix();
    struct staging staging = {0};
    char file[300], call[100];

    assert_int_equal(staging_begin(&staging, io, in(*state, "pictures"), true, NULL), 0);
    snprintf(file, sizeof(file), "%s/one.png", staging.temp);
    snprintf(call, sizeof(call), "fsync %.40s", strrchr(staging.temp, '/') + 1);
    forget();
    assert_int_equal(staging_write(io, file, produce, NULL, NULL), 0);
    assert_int_equal(staging_commit(&staging, NULL), 0);
    assert_int_equal(told.n, 4);
    assert_string_equal(told.call[0], "fsync one.png");
    assert_string_equal(told.call[1], call);
    assert_string_equal(told.call[2], "rename pictures");
    assert_memory_equal(told.call[3], "fsync ", 6);
}

/* A child that said it wrote the file, and did not; a disk that does not take it. */
static void an_export_that_is_not_on_the_disk_is_none(void **state)
{
    struct ttf_io *io = ttf_io_posix();
    struct staging staging = {0};

    assert_int_equal(staging_begin(&staging, io, in(*state, "film"), false, NULL), 0);
    write_text(staging.temp, "", 0);
    assert_int_equal(staging_commit(&staging, NULL), -ENODATA);
    assert_false(exists(in(*state, "film")));
    forget();
    told.answer = EIO;
    assert_int_equal(staging_begin(&staging, io, in(*state, "film"), false, NULL), 0);
    write_text(staging.temp, "bytes", 5);
    assert_int_equal(staging_commit(&staging, NULL), -EIO);
    assert_false(exists(in(*state, "film")));
    assert_int_equal(staging_write(io, in(*state, "one.png"), produce, NULL, NULL), -EIO);
    assert_false(exists(in(*state, "one.png")));
    forget();
}

#define T(f) cmocka_unit_test_setup_teardown(f, folder_setup, folder_teardown)

int main(void)
{
    const struct CMUnitTest tests[] = {
        T(each_sync_is_a_call_of_the_kernel_s),
        T(what_the_kernel_answers_is_heard),
        T(the_kernel_is_told_of_each_sync_of_a_commit_in_its_order),
        T(a_calibration_is_on_the_disk_before_it_has_its_names),
        T(an_exported_file_is_on_the_disk_before_it_has_its_name),
        T(an_exported_folder_is_on_the_disk_before_it_has_its_name),
        T(an_export_that_is_not_on_the_disk_is_none),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
