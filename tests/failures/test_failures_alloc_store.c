/* SPDX-License-Identifier: Apache-2.0 */
/* Each allocation of a small run of the writer fails once (README.md). */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "each_allocation.h"
#include "small_run.h"

/* Of all allocations, each so-manieth in a plain test run. Most are of reading JSON. */
#define SHARE 13

static struct alloc_run run_of_all; /* set once, by main */

static struct figures {
    long told, wrong;
} figures;

static void wrong(long n, unsigned long site, const char *what)
{
    if (figures.wrong++ < 20)
        print_error("allocation %ld (addr2line -fipe PROGRAM 0x%lx): %s\n", n, site, what);
}

static bool all_there(const struct small_run *run)
{
    for (int i = 0; i < SMALL_SLOTS; i++)
        if (!run->committed[i])
            return false;
    return run->created && run->sealed && run->events == 2;
}

static void judge(const struct small_run *run, long n, struct model_disk *disk)
{
    unsigned long site = alloc_hook_failed_site();
    char text[SMALL_TEXT] = "";
    struct model_disk dark;

    if (run->refusals > 0 && run->first_code != -ENOMEM)
        wrong(n, site, run->refused);
    if (run->silent)
        wrong(n, site, run->silent_in);
    if (run->temper != SMALL_GIVES_UP && (!all_there(run) || run->refusals > 1))
        wrong(n, site, run->refused);
    if (model_disk_open_handles(disk) != 0)
        wrong(n, site, "a handle was left open");
    model_disk_copy(&dark, disk);
    model_disk_lose_power(&dark);
    if (!small_check(run, disk, false, text))
        wrong(n, site, text);
    if (!small_check(run, &dark, false, text)) {
        wrong(n, site, "after a power cut:");
        wrong(n, site, text);
    }
    model_disk_free(&dark);
}

/* Whether there were as many allocations. */
static bool one(long n, enum small_temper temper)
{
    long alive = alloc_hook_counts(run_of_all.whose).live, failed;
    struct model_disk disk;
    struct small_run run;

    small_disk_init(&disk);
    run = (struct small_run){.io = &disk.io, .temper = temper};
    alloc_hook_arm(run_of_all.whose, n, false);
    small_run(&run);
    failed = alloc_hook_disarm();
    figures.told += run.refusals > 0;
    if (failed)
        judge(&run, n, &disk);
    model_disk_free(&disk);
    if (alloc_hook_counts(run_of_all.whose).live != alive && n > 0)
        wrong(n, alloc_hook_failed_site(), "memory was not given back");
    return failed > 0;
}

static void each_fails(enum small_temper temper)
{
    long n;

    figures.told = figures.wrong = 0;
    (void)one(0, temper); /* libraries keep what they make at the first use */
    for (n = 1; one(n, temper);)
        n += run_of_all.everything || run_of_all.whose == ALLOC_OURS ? 1 : SHARE;
    print_message("%ld allocations, %ld failures told\n", n - 1, figures.told);
    assert_int_equal(figures.wrong, 0);
    assert_true(n > 200);
}

static void a_caller_that_gives_up_loses_nothing(void **state)
{
    each_fails(SMALL_GIVES_UP);
}

static void a_caller_that_makes_the_same_call_again_gets_what_it_wanted(void **state)
{
    each_fails(SMALL_REPEATS);
}

static void a_caller_that_opens_anew_loses_nothing(void **state)
{
    each_fails(SMALL_PERSISTS);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_caller_that_gives_up_loses_nothing),
        cmocka_unit_test(a_caller_that_makes_the_same_call_again_gets_what_it_wanted),
        cmocka_unit_test(a_caller_that_opens_anew_loses_nothing),
    };

    run_of_all = alloc_run_of(argc, argv);
    return cmocka_run_group_tests(tests, NULL, NULL);
}
