/* SPDX-License-Identifier: Apache-2.0 */
/*
 * alloc_hook.h: counts the allocations of a test program and lets chosen ones fail.
 *
 * How to use it. In CMakeLists.txt, after ttf_test(NAME ...) or add_executable(NAME ...):
 *
 *     ttf_alloc_hook(NAME)
 *
 * Whose allocation it is:
 *   ALLOC_OURS  asked for by an object linked into the program: our rooms, and the test itself
 *               (malloc, calloc, realloc, reallocarray, aligned_alloc, posix_memalign, strdup,
 *               strndup, asprintf, vasprintf, getline, open_memstream, fopen; one call is one
 *               allocation). The linker's --wrap tells them apart from those of libraries.
 *   ALLOC_ALL   these, and those of all shared libraries (jansson, libtiff, libc, ...).
 * Who asked in particular, alloc_hook_print_sites tells by return address.
 *
 * To see that a piece of work allocates nothing, or does not grow:
 *
 *     struct alloc_counts before = alloc_hook_counts(ALLOC_ALL), after;
 *     ... the work ...
 *     after = alloc_hook_counts(ALLOC_ALL);
 *     assert_int_equal(after.calls - before.calls, 0);
 *     assert_int_equal(after.live, before.live);
 *
 * To let each allocation fail once (n = 1, 2, ... until alloc_hook_disarm() says that none failed):
 *
 *     alloc_hook_arm(ALLOC_OURS, n, false);
 *     r = the call;
 *     failed = alloc_hook_disarm();
 *     ... if (failed) r is -ENOMEM; nothing is lost ...
 *
 * What the test itself allocates in between stands within alloc_hook_pause() and alloc_hook_resume():
 * then this thread's calls are neither counted nor made to fail (they are still known to be live or freed).
 *
 * Threads: all functions may be called by any thread. Counting and failing see all threads, in the
 * order in which they come; pausing is of the calling thread alone.
 *
 * Sanitizers have an allocator of their own. There alloc_hook_sees_all() is false: ALLOC_ALL is the
 * same as ALLOC_OURS, and live and live_bytes stay 0. Failing and counting our calls works as always,
 * so that a sanitizer can look on.
 */
#ifndef TTF_TESTS_ALLOC_HOOK_H
#define TTF_TESTS_ALLOC_HOOK_H

#include <stdbool.h>
#include <stdio.h>

enum alloc_whose {
    ALLOC_OURS,
    ALLOC_ALL
};

/* Since the program's start. */
struct alloc_counts {
    long calls;      /* allocations asked for; one of realloc counts */
    long live;       /* blocks not yet freed */
    long live_bytes; /* in them, as asked for */
    long
        peak_bytes; /* the most that live_bytes ever was, since the start or alloc_hook_reset_peak */
};

struct alloc_counts alloc_hook_counts(enum alloc_whose whose);

/* peak_bytes of both begin anew at what is live now. */
void alloc_hook_reset_peak(void);

/* Whether libraries' allocations and what is live are known: not in builds with a sanitizer. */
bool alloc_hook_sees_all(void);

/*
 * From now on the n-th allocation (from 1) of these fails, for_ever: and all after it. malloc and
 * its like return NULL with errno ENOMEM; posix_memalign returns it; asprintf returns -1. 0: none fails.
 */
void alloc_hook_arm(enum alloc_whose whose, long n, bool for_ever);

/* Nothing fails any more. How many were made to fail since arming. */
long alloc_hook_disarm(void);

/* How many allocations that count were asked for since arming. */
long alloc_hook_asked(void);

/* Where the first failing one was asked for: what addr2line -e PROGRAM understands; 0: none failed. */
unsigned long alloc_hook_failed_site(void);

/* Of the calling thread; may be nested. */
void alloc_hook_pause(void);
void alloc_hook_resume(void);

/*
 * From alloc_hook_watch_sites(true) on, where our objects ask is remembered (up to 1,024 places);
 * the printing gives "calls bytes address" of each, for addr2line -fpe PROGRAM.
 */
void alloc_hook_watch_sites(bool on);
void alloc_hook_print_sites(FILE *to);

#endif
