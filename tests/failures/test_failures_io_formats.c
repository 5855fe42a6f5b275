/* SPDX-License-Identifier: Apache-2.0 */
/* Each file operation of reading and writing pictures and calibrations, of importing and exporting fails (README.md). */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <string.h>

#include "format_works.h"
#include "model_disk.h"
#include "more_works.h"

#define SHARE 5

static bool everything; /* set once, by main */
static struct model_disk clean;

struct piece {
    const char *name;
    int (*work)(struct ttf_err *err);
    bool into_new; /* it writes the file "new", which the test opens and closes */
};

struct how {
    const char *name;
    struct model_fault fault;
};

struct figures {
    long told, done, wrong;
};

static void wrong(struct figures *figures, const struct piece *piece, const struct how *how, long n,
                  const struct model_disk *disk, const char *what)
{
    if (figures->wrong++ < 20)
        print_error("%s, %s at operation %ld (%s of %s): %s\n", piece->name, how->name, n,
                    model_op_name(disk->failed.op), disk->failed.path, what);
}

/*
 * An import or export that failed may leave nothing, but a file whose sidecar could not be written; what could not be
 * removed; and the whole of it, where only its name could not be synced.
 */
static bool left_something(struct model_disk *disk)
{
    for (int i = 0; i < disk->n_names; i++)
        if (disk->names[i].seen >= 0 &&
            (strstr(disk->names[i].path, "/out/") || strstr(disk->names[i].path, ".part-")))
            return true;
    return false;
}

static void judge(const struct piece *piece, const struct how *how, long n, struct model_disk *disk,
                  int r, const struct ttf_err *err, struct figures *figures)
{
    bool whole_again = how->fault.lasts == 1;
    char what[700];

    figures->told += r < 0;
    figures->done += r == 0;
    if (r < 0 && (err->code != r || err->what[0] == '\0')) {
        snprintf(what, sizeof(what), "%d without a message, or with another's (%d: %s)", r,
                 err->code, err->what);
        wrong(figures, piece, how, n, disk, what);
    }
    if (r < 0 && r != -how->fault.error && r != -TTF_EDAMAGED) {
        snprintf(what, sizeof(what), "it said %d: %s: %s", r, err->where, err->what);
        wrong(figures, piece, how, n, disk, what);
    }
    if (r < 0 && whole_again && disk->failed.op != OP_UNLINK && disk->failed.op != OP_SYNC_DIR &&
        left_something(disk))
        wrong(figures, piece, how, n, disk, "something was left behind");
    if (model_disk_open_handles(disk) != 0)
        wrong(figures, piece, how, n, disk, "a handle was left open");
}

/* False: it asks for fewer operations. */
static bool one(const struct piece *piece, const struct how *how, long n, struct figures *figures)
{
    struct model_fault fault = how->fault;
    struct ttf_err err = {0};
    struct model_disk disk;
    bool met;
    int r;

    model_disk_copy(&disk, &clean);
    format_works_on(&disk.io);
    if (piece->into_new)
        format_open_new();
    fault.at = n;
    model_disk_fail(&disk, fault);
    r = piece->work(&err);
    met = disk.n_failed > 0;
    model_disk_fail(&disk, (struct model_fault){0});
    if (piece->into_new)
        (void)format_close_new();
    if (n == 0 && r != 0)
        fail_msg("%s: %s: %s", piece->name, err.where, err.what);
    if (met) {
        judge(piece, how, n, &disk, r, &err, figures);
        /* On a disk that works again the same goes well: what is there is not in the way. */
        err = (struct ttf_err){0};
        if (piece->into_new)
            format_open_new();
        r = piece->work(&err);
        if (piece->into_new)
            (void)format_close_new();
        if (r != 0 && r != -EEXIST)
            wrong(figures, piece, how, n, &disk, err.what);
    }
    model_disk_free(&disk);
    return met;
}

static void each_operation_fails(const struct piece *pieces, size_t n_pieces)
{
    static const struct how hows[] = {
        {"EIO once", {.lasts = 1, .error = EIO}},
        {"EIO from then on", {.lasts = LONG_MAX, .error = EIO}},
        {"ENOSPC from then on", {.lasts = LONG_MAX, .error = ENOSPC}},
        {"a short count", {.lasts = 1, .error = EIO, .how = SHORT_ONCE}},
        {"a short count, then EIO", {.lasts = 1, .error = EIO, .how = SHORT_THEN_ERROR}},
    };
    long all_wrong = 0;

    for (size_t i = 0; i < n_pieces; i++) {
        struct figures figures = {0};

        (void)one(&pieces[i], &hows[0], 0, &figures);
        for (size_t k = 0; k < sizeof(hows) / sizeof(hows[0]); k++)
            for (long n = 1; one(&pieces[i], &hows[k], n, &figures);)
                n += everything || n < 40 ? 1 : SHARE;
        print_message("%-26s %6ld failures: %ld told, %ld made good or done without\n",
                      pieces[i].name, figures.told + figures.done, figures.told, figures.done);
        all_wrong += figures.wrong;
    }
    assert_int_equal(all_wrong, 0);
}

#define EACH(pieces) each_operation_fails(pieces, sizeof(pieces) / sizeof((pieces)[0]))

static void pictures_say_what_failed(void **state)
{
    static const struct piece pieces[] = {
        {"writing TIFF", format_write_tiff, true},
        {"writing TIFF of floats", format_write_floats, true},
        {"writing PNG", format_write_png, true},
        {"writing JPEG", format_write_jpeg, true},
        {"writing DNG", format_write_dng, true},
        {"developing", format_develop_to_tiff, true},
        {"reading TIFF", format_read_tiff, false},
        {"reading TIFF of floats", format_read_floats, false},
        {"reading PNG", format_read_png, false},
        {"reading JPEG", format_read_jpeg, false},
        {"looking at pictures", format_probe, false},
        {"reading DNG", format_read_dng, false},
        {"a picture as a sequence", format_read_sequence, false},
        {"small pictures", more_show_small, false},
        {"floats of a dataset", more_read_float_dataset, false},
        {"a note", more_note, false},
        {"samples", more_sample, false},
    };

    EACH(pieces);
}

static void calibrations_say_what_failed(void **state)
{
    static const struct piece pieces[] = {
        {"saving a calibration", format_save, false},
        {"loading one", format_load, false},
    };

    EACH(pieces);
}

static void imports_and_exports_leave_nothing_half_done(void **state)
{
    static const struct piece pieces[] = {
        {"importing pictures", format_import_pictures, false},
        {"importing by time", more_import_by_time, false},
        {"exporting PNG", format_export_png, false},
        {"exporting TIFF", format_export_tiff, false},
        {"exporting NPY", format_export_npy, false},
        {"exporting Y4M", format_export_y4m, false},
        {"exporting a sheet", format_export_sheet, false},
    };

    EACH(pieces);
}

static int make(void **state)
{
    model_disk_init(&clean);
    format_works_begin(&clean.io, "/m");
    format_works_files();
    more_works_begin();
    more_works_files();
    return 0;
}

static int clear(void **state)
{
    more_works_end();
    format_works_end();
    model_disk_free(&clean);
    return 0;
}

/* "all": every operation; else the first forty and a share of the rest. */
int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pictures_say_what_failed),
        cmocka_unit_test(calibrations_say_what_failed),
        cmocka_unit_test(imports_and_exports_leave_nothing_half_done),
    };

    everything = argc > 1 && strcmp(argv[1], "all") == 0;
    return cmocka_run_group_tests(tests, make, clear);
}
