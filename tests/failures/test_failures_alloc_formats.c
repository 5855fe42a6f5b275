/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Each allocation of reading and writing each format, of calibrating and developing, of importing and
 * exporting fails once (README.md).
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <dirent.h>
#include <errno.h>
#include <ftw.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "each_allocation.h"
#include "format_works.h"
#include "more_works.h"

static struct alloc_run run_of_all; /* set once, by main */
static char folder[] = "/tmp/ttf-alloc-formats-XXXXXX";

static void run_each(const struct alloc_piece *pieces, size_t n)
{
    for (size_t i = 0; i < n; i++)
        each_allocation_fails(&pieces[i], run_of_all);
}

#define RUN_EACH(pieces) run_each(pieces, sizeof(pieces) / sizeof((pieces)[0]))

/* ---- writing ---- */

static void begin_file(void)
{
    alloc_hook_pause();
    format_open_new();
    alloc_hook_resume();
}

static void end_file(int r)
{
    assert_int_equal(format_close_new(), 0);
}

static void a_file_that_found_no_memory_says_so(void **state)
{
    static const struct alloc_piece pieces[] = {
        {.name = "writing TIFF",
         .begin = begin_file,
         .work = format_write_tiff,
         .ours_only = true,
         .end = end_file},
        {.name = "writing PNG", .begin = begin_file, .work = format_write_png, .end = end_file},
        {.name = "writing JPEG", .begin = begin_file, .work = format_write_jpeg, .end = end_file},
        {.name = "writing DNG",
         .begin = begin_file,
         .work = format_write_dng,
         .ours_only = true,
         .end = end_file},
        {.name = "developing",
         .begin = begin_file,
         .work = format_develop_to_tiff,
         .ours_only = true,
         .end = end_file},
        {.name = "developing in reserve", .work = format_develop_in_reserve, .ours_only = true},
    };

    RUN_EACH(pieces);
}

/* ---- reading ---- */

static void a_picture_is_read_as_it_is_or_not_at_all(void **state)
{
    static const struct alloc_piece pieces[] = {
        {.name = "reading TIFF", .work = format_read_tiff, .ours_only = true},
        {.name = "reading TIFF of floats", .work = format_read_floats, .ours_only = true},
        {.name = "reading PNG", .work = format_read_png},
        {.name = "reading JPEG", .work = format_read_jpeg},
        {.name = "looking at pictures", .work = format_probe, .ours_only = true},
        {.name = "reading DNG", .work = format_read_dng, .ours_only = true},
        {.name = "a picture as a sequence", .work = format_read_sequence},
        {.name = "small pictures", .work = more_show_small, .ours_only = true},
        {.name = "floats of a dataset", .work = more_read_float_dataset, .ours_only = true},
    };

    RUN_EACH(pieces);
}

/* ---- calibrations ---- */

static void a_calibration_is_whole_or_none(void **state)
{
    static const struct alloc_piece pieces[] = {
        {.name = "fitting a calibration", .work = format_fit},
        {.name = "saving one", .work = format_save, .ours_only = true},
        {.name = "loading one", .work = format_load, .ours_only = true},
        {.name = "measuring a printed grid", .work = more_measure_grid},
        {.name = "measuring flicker", .work = more_measure_flicker},
    };

    RUN_EACH(pieces);
}

/* ---- import and export ---- */

static int remove_one(const char *path, const struct stat *what, int kind, struct FTW *at)
{
    return remove(path);
}

static void remove_tree(const char *path)
{
    alloc_hook_pause();
    /* NOLINTNEXTLINE(concurrency-mt-unsafe): one thread */
    assert_int_equal(nftw(path, remove_one, 8, FTW_DEPTH | FTW_PHYS), 0);
    alloc_hook_resume();
}

static void begin_output(void)
{
    if (access(format_in("out"), F_OK) == 0)
        remove_tree(format_in("out"));
    (void)remove(format_in("out.json"));
}

/* Neither it nor a piece of it is there, unless it is whole. */
static void end_output(int r)
{
    const struct dirent *entry;
    DIR *dir;

    alloc_hook_pause();
    dir = opendir(folder);
    assert_non_null(dir);
    /* NOLINTNEXTLINE(concurrency-mt-unsafe): one thread */
    while (dir && (entry = readdir(dir)))
        if (r != 0 && (strncmp(entry->d_name, "out", 3) == 0 || strstr(entry->d_name, ".tmp")))
            fail_msg("%s was left behind", entry->d_name);
    if (dir)
        closedir(dir);
    alloc_hook_resume();
    if (r == 0)
        assert_int_equal(access(format_in("out"), F_OK), 0);
}

static void what_is_imported_or_exported_is_whole_or_not_there(void **state)
{
    static const struct alloc_piece pieces[] = {
        {.name = "importing pictures",
         .begin = begin_output,
         .work = format_import_pictures,
         .ours_only = true,
         .end = end_output,
         .may_do_without = true, /* the dataset's reserve */
         .share = 3,
         .share_of_all = 61},
        {.name = "importing by time",
         .begin = begin_output,
         .work = more_import_by_time,
         .ours_only = true,
         .end = end_output,
         .may_do_without = true, /* the dataset's reserve */
         .share = 3},
        {.name = "exporting PNG",
         .begin = begin_output,
         .work = format_export_png,
         .end = end_output},
        {.name = "exporting TIFF",
         .begin = begin_output,
         .work = format_export_tiff,
         .ours_only = true,
         .end = end_output,
         .share_of_all = 7},
        {.name = "exporting NPY",
         .begin = begin_output,
         .work = format_export_npy,
         .end = end_output},
        {.name = "exporting Y4M",
         .begin = begin_output,
         .work = format_export_y4m,
         .end = end_output},
        {.name = "exporting a sheet",
         .begin = begin_output,
         .work = format_export_sheet,
         .end = end_output},
    };

    RUN_EACH(pieces);
}

/* ---- */

static int make(void **state)
{
    if (!mkdtemp(folder))
        return -1;
    format_works_begin(ttf_io_posix(), folder);
    format_works_files();
    more_works_begin();
    more_works_files();
    return 0;
}

static int clear(void **state)
{
    more_works_end();
    format_works_end();
    remove_tree(folder);
    return 0;
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_file_that_found_no_memory_says_so),
        cmocka_unit_test(a_picture_is_read_as_it_is_or_not_at_all),
        cmocka_unit_test(a_calibration_is_whole_or_none),
        cmocka_unit_test(what_is_imported_or_exported_is_whole_or_not_there),
    };

    run_of_all = alloc_run_of(argc, argv);
    return cmocka_run_group_tests(tests, make, clear);
}
