/* SPDX-License-Identifier: Apache-2.0 */
/* A sync on f2fs, where a file's own is not enough (DESIGN.md): what the kernel is asked for, and in which order. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/statfs.h>
#include <unistd.h>

#include "ttf/dataset/io.h"

/* In place of the C library's: which file system it is, what was asked for, and what comes of it. */
static struct {
    unsigned long kind;
    char asked[64];
    int result; /* of syncfs: an errno, or 0 */
} kernel;

static int asked(const char *what, int error)
{
    size_t used = strlen(kernel.asked);

    (void)snprintf(kernel.asked + used, sizeof kernel.asked - used, "%s ", what);
    errno = error;
    return error ? -1 : 0;
}

/* NOLINTNEXTLINE(readability-inconsistent-declaration-parameter-name): its own are reserved ones */
int fstatfs(int fd, struct statfs *ret)
{
    memset(ret, 0, sizeof *ret);
    ret->f_type = (__typeof__(ret->f_type))kernel.kind;
    return 0;
}

int fsync(int fd)
{
    return asked("fsync", 0);
}

/* NOLINTNEXTLINE(readability-inconsistent-declaration-parameter-name) */
int fdatasync(int fd)
{
    return asked("fdatasync", 0);
}

int syncfs(int fd)
{
    return asked("syncfs", kernel.result);
}

static int synced(unsigned long kind, bool data_only, int result)
{
    char path[] = "/tmp/ttf-f2fs.XXXXXX";
    int made = mkstemp(path), file, r;
    struct ttf_io *io = ttf_io_posix();

    assert_true(made >= 0);
    close(made);
    file = io->ops->open(io, path, TTF_IO_APPEND);
    assert_true(file >= 0);
    kernel.kind = kind;
    kernel.result = result;
    kernel.asked[0] = '\0';
    r = io->ops->sync(io, file, data_only);
    assert_int_equal(io->ops->close(io, file), 0);
    assert_int_equal(unlink(path), 0);
    return r;
}

#define EXT4 0xEF53ul
#define F2FS 0xF2F52010ul

static void a_file_on_f2fs_is_synced_with_a_checkpoint(void **state)
{
    assert_int_equal(synced(F2FS, true, 0), 0);
    assert_string_equal(kernel.asked, "fdatasync syncfs ");
    assert_int_equal(synced(F2FS, false, 0), 0);
    assert_string_equal(kernel.asked, "fsync syncfs ");
}

static void a_checkpoint_that_fails_is_a_sync_that_failed(void **state)
{
    assert_int_equal(synced(F2FS, true, EIO), -EIO);
}

static void elsewhere_a_sync_is_of_the_file_alone(void **state)
{
    assert_int_equal(synced(EXT4, true, EIO), 0);
    assert_string_equal(kernel.asked, "fdatasync ");
}

int main(void)
{
    static const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_file_on_f2fs_is_synced_with_a_checkpoint),
        cmocka_unit_test(a_checkpoint_that_fails_is_a_sync_that_failed),
        cmocka_unit_test(elsewhere_a_sync_is_of_the_file_alone),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
