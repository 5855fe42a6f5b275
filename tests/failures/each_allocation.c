/* SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>

#include "each_allocation.h"

#define NONE 0

/* Made by the linker: where the program begins in memory. */
extern const char
    __executable_start; /* NOLINT(bugprone-reserved-identifier,cert-dcl37-c,cert-dcl51-cpp) */

struct attempt {
    int r;
    struct ttf_err err;
    long failed, leaked;
    int files;
};

static unsigned open_files(void)
{
    unsigned n = 0;

    for (int file = 0; file < 64; file++)
        n += fcntl(file, F_GETFD) >= 0;
    return n;
}

struct figures {
    long told, done_without, wrong;
};

/* One attempt in which the n-th allocation fails; n NONE: none. */
static struct attempt attempt(const struct alloc_piece *piece, enum alloc_whose whose, long n)
{
    long alive = alloc_hook_counts(whose).live;
    unsigned files = open_files();
    struct attempt a = {0};

    if (piece->begin)
        piece->begin();
    alloc_hook_arm(whose, n, false);
    a.r = piece->work(&a.err);
    a.failed = alloc_hook_disarm();
    if (piece->end)
        piece->end(a.r);
    a.leaked = alloc_hook_counts(whose).live - alive;
    a.files = (int)(open_files() - files);
    return a;
}

static void wrong(struct figures *figures, const struct alloc_piece *piece, long n,
                  unsigned long site, const char *what)
{
    Dl_info at = {0};

    if (dladdr(&__executable_start + site, &at) && at.dli_sname)
        print_error("in %s of %s: ", at.dli_sname, at.dli_fname);
    if (figures->wrong++ < 20)
        print_error("%s, allocation %ld (addr2line -fipe PROGRAM 0x%lx): %s\n", piece->name, n,
                    site, what);
}

static void judge(const struct alloc_piece *piece, const struct alloc_run *run, long n,
                  const struct attempt *a, struct figures *figures)
{
    unsigned long site = alloc_hook_failed_site();
    char what[700];

    if (a->r == 0)
        figures->done_without++;
    else
        figures->told++;
    if (a->r == 0 && !piece->may_do_without && run->whose == ALLOC_OURS)
        wrong(figures, piece, n, site, "a failure was not told");
    if (a->r != 0 && a->r != -ENOMEM) {
        snprintf(what, sizeof(what), "it said %d: %s: %s", a->r, a->err.where, a->err.what);
        wrong(figures, piece, n, site, what);
    }
    if (a->r != 0 && !piece->speechless && (a->err.code != a->r || a->err.what[0] == '\0')) {
        snprintf(what, sizeof(what), "%d without a message, or with another's (%d: %s: %s)", a->r,
                 a->err.code, a->err.where, a->err.what);
        wrong(figures, piece, n, site, what);
    }
    if (a->files != 0)
        wrong(figures, piece, n, site, "a file is open that was not before");
    if (a->leaked != 0) {
        snprintf(what, sizeof(what), "%ld blocks more are alive than before", a->leaked);
        wrong(figures, piece, n, site, what);
    }
}

static void expect_well(const struct alloc_piece *piece, struct attempt a, const char *when, long n)
{
    if (a.r != 0)
        fail_msg("%s, %s %ld: %d: %s: %s", piece->name, when, n, a.r, a.err.where, a.err.what);
}

static unsigned step_of(const struct alloc_piece *piece, const struct alloc_run *run)
{
    unsigned share = piece->share;

    if (run->whose == ALLOC_ALL)
        share = run->everything ? piece->share_of_all / 20 : piece->share_of_all;
    else if (run->everything)
        share = 1;
    return share ? share : 1;
}

void each_allocation_fails(const struct alloc_piece *piece, struct alloc_run run)
{
    unsigned step = step_of(piece, &run);
    struct figures figures = {0};
    struct attempt a;
    long n, asked;

    if (run.whose == ALLOC_ALL && piece->ours_only)
        return;
    /* Twice: libraries keep what they make at the first use. */
    expect_well(piece, attempt(piece, run.whose, NONE), "before failure", 0);
    a = attempt(piece, run.whose, NONE);
    asked = alloc_hook_asked();
    expect_well(piece, a, "before failure", 0);
    assert_int_equal(a.leaked, 0);
    for (n = 1; n <= asked; n += step) {
        a = attempt(piece, run.whose, n);
        if (a.failed == 0)
            break; /* threads: not always as many */
        judge(piece, &run, n, &a, &figures);
        expect_well(piece, attempt(piece, run.whose, NONE), "after failure", n);
    }
    print_message("%-34s %6ld allocations: %ld told, %ld done without\n", piece->name, asked,
                  figures.told, figures.done_without);
    assert_int_equal(figures.wrong, 0);
    /* A piece may leave all allocations to libraries: with a sanitizer they are not seen. */
    assert_true(asked > 0 || run.whose == ALLOC_OURS || !alloc_hook_sees_all());
}

struct alloc_run alloc_run_of(int argc, char **argv)
{
    struct alloc_run run = {.whose = ALLOC_OURS};

    for (int i = 1; i < argc; i++) {
        run.everything |= strcmp(argv[i], "all") == 0;
        if (strcmp(argv[i], "libraries") == 0)
            run.whose = ALLOC_ALL;
    }
    return run;
}
