/* SPDX-License-Identifier: Apache-2.0 */
/* Operations of the I/O table that a dataset's writer does not use. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

#include "store_test.h"
#include "ttf/dataset/io.h"

static void room_that_was_reserved_is_the_files_and_changes_nothing_in_it(void **state)
{
    struct ttf_io *io = ttf_io_posix();
    char path[300], read[6] = {1, 1, 1, 1, 1, 1};
    struct stat now;
    int64_t bytes;
    int file, r;

    (void)snprintf(path, sizeof path, "%s/f", (const char *)*state);
    file = io->ops->open(io, path, TTF_IO_CREATE_NEW);
    assert_true(file >= 0);
    assert_int_equal(ttf_io_pwrite_all(io, file, "abc", 3, 0), 0);
    r = ttf_io_reserve(io, file, 0, 100000);
    if (r == -EOPNOTSUPP) { /* a file system that cannot: no harm is done */
        assert_int_equal(io->ops->size(io, file, &bytes), 0);
        assert_int_equal(bytes, 3);
        io->ops->close(io, file);
        skip();
    }
    assert_int_equal(r, 0);
    assert_int_equal(io->ops->size(io, file, &bytes), 0);
    assert_int_equal(bytes, 100000);
    assert_int_equal(stat(path, &now), 0);
    assert_true((int64_t)now.st_blocks * 512 >= 100000); /* no hole: what is written later fits */
    assert_int_equal(ttf_io_pread_all(io, file, read, 6, 0), 6);
    assert_memory_equal(read, "abc\0\0\0", 6);
    assert_int_equal(ttf_io_reserve(io, file, 1, -1), -EINVAL);
    io->ops->close(io, file);
}

static int says; /* a file system */

static int say(struct ttf_io *io, int file, int64_t offset, int64_t n)
{
    return says;
}

static void a_table_without_it_says_so_and_errors_are_passed_on(void **state)
{
    struct ttf_io_ops ops = *ttf_io_posix()->ops;
    struct ttf_io io = {.ops = &ops};

    (void)state;
    ops.reserve = NULL;
    assert_int_equal(ttf_io_reserve(&io, 0, 0, 10), -EOPNOTSUPP);
    ops.reserve = say;
    says = -ENOSPC;
    assert_int_equal(ttf_io_reserve(&io, 0, 0, 10), -ENOSPC);
}

/* Room that cannot be had before is no reason to write nothing; no room is. */
static void what_only_reserving_meets_is_no_error(void **state)
{
    static const int cannot[] = {EOPNOTSUPP, ENOSYS, EINVAL, ENODEV, EPERM, ESPIPE, EBADF},
                     fails[] = {ENOSPC, EDQUOT, EFBIG, EIO};
    struct ttf_io_ops ops = *ttf_io_posix()->ops;
    struct ttf_io io = {.ops = &ops};

    (void)state;
    ops.reserve = say;
    for (size_t i = 0; i < sizeof cannot / sizeof *cannot; i++) {
        says = -cannot[i];
        assert_int_equal(ttf_io_reserve(&io, 0, 0, 10), -EOPNOTSUPP);
    }
    for (size_t i = 0; i < sizeof fails / sizeof *fails; i++) {
        says = -fails[i];
        assert_int_equal(ttf_io_reserve(&io, 0, 0, 10), -fails[i]);
    }
    says = 0;
    assert_int_equal(ttf_io_reserve(&io, 0, 0, 10), 0);
    assert_int_equal(ttf_io_reserve(&io, 0, -1, 10), -EINVAL);
    assert_int_equal(ttf_io_reserve(&io, 0, 0, 0), -EINVAL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(
            room_that_was_reserved_is_the_files_and_changes_nothing_in_it, folder_setup,
            folder_teardown),
        cmocka_unit_test(a_table_without_it_says_so_and_errors_are_passed_on),
        cmocka_unit_test(what_only_reserving_meets_is_no_error),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
