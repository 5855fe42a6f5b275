/* SPDX-License-Identifier: Apache-2.0 */
/*
 * each_allocation.h: a piece of work in which each allocation fails once, n = 1, 2, ... until none
 * does; and what must hold each time.
 */
#ifndef TTF_TESTS_EACH_ALLOCATION_H
#define TTF_TESTS_EACH_ALLOCATION_H

#include <stdbool.h>

#include "alloc_hook.h"
#include "ttf/base/err.h"

/* A piece of work. Each attempt is begin, work, end; only in work something may fail. */
struct alloc_piece {
    const char *name;
    void (*begin)(void); /* NULL: nothing to prepare; asserts */
    /* What it did: 0, or as the function it tries. Gives back all that it took. err starts empty. */
    int (*work)(struct ttf_err *err);
    /*
     * NULL: nothing more to see. r: what work returned. Asserts that what there is now is what such
     * an end leaves: of 0 the whole of it; of an error nothing half-done. Clears away what begin made.
     */
    void (*end)(int r);
    /* Allocations whose failure costs no more than time or something that is told: 0 is fine, too.
     * Why, stands in README.md. */
    bool may_do_without;
    /* A library between does not survive a failure of its own (README.md): only ours are made to fail. */
    bool ours_only;
    /* err->what is no promise of the function: it has no error object. */
    bool speechless;
    /* Each so-manieth allocation in a plain test run, of ours and of all; 0: each. */
    unsigned share, share_of_all;
};

struct alloc_run {
    enum alloc_whose whose;
    bool everything; /* each of ours; of all, twenty times as many */
};

/*
 * Without a failure the piece must end well and leave nothing alive; with any one, it returns -ENOMEM
 * with a message and that code, crashes nowhere, leaves nothing alive, and does the same work right
 * afterwards. A library may do without what it did not get, as long as the work asserts the same. Asserts; prints a line. What is wrong is told with the place that asked (addr2line).
 */
void each_allocation_fails(const struct alloc_piece *piece, struct alloc_run run);

/* Of a test program: "all" of its arguments takes more of them; "libraries" lets theirs fail, too. */
struct alloc_run alloc_run_of(int argc, char **argv);

#endif
