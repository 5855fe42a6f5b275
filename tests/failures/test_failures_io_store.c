/* SPDX-License-Identifier: Apache-2.0 */
/* Every file operation of a small run of the writer fails, once or for good, in every way (README.md). */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "faults.h"
#include "small_run.h"

#define LOG_ROOM 2000
#define SHARE    7

static bool everything; /* set once, by main */

/* The operations of a run on which nothing fails. */
static long clean_run(struct model_call *log)
{
    struct model_disk disk;
    struct small_run run;
    char text[SMALL_TEXT];
    long n;

    small_disk_init(&disk);
    run = (struct small_run){.io = &disk.io};
    model_disk_fail(&disk, (struct model_fault){0});
    disk.log = log;
    disk.log_room = LOG_ROOM;
    small_run(&run);
    n = disk.n;
    disk.log = NULL;
    assert_int_equal(run.refusals, 0);
    assert_true(run.sealed);
    if (!small_check(&run, &disk, false, text))
        fail_msg("%s", text);
    model_disk_free(&disk);
    assert_true(n > 200 && n < LOG_ROOM);
    return n;
}

struct figures {
    long injections, recovered, refused, not_created, wrong;
};

static void wrong(struct figures *figures, const char *what, const char *text)
{
    if (figures->wrong++ < 20)
        print_error("%s: %s\n", what, text);
}

static void one(const struct fault_kind *kind, long at, const struct model_call *call,
                enum small_temper temper, struct figures *figures)
{
    char what[300], dark_what[340], text[SMALL_TEXT] = "";
    struct model_fault fault = kind->fault;
    struct model_disk disk, dark;
    struct small_run run;

    fault_text(kind, at, call, what);
    small_disk_init(&disk);
    run = (struct small_run){.io = &disk.io, .temper = temper};
    fault.at = at;
    model_disk_fail(&disk, fault);
    small_run(&run);
    figures->injections++;
    figures->recovered += run.refusals == 0;
    figures->refused += run.refusals > 0;
    figures->not_created += !run.created;
    if (run.silent)
        wrong(figures, what, run.silent_in);
    if (model_disk_open_handles(&disk) != 0)
        wrong(figures, what, "a handle was left open");
    model_disk_copy(&dark, &disk);
    model_disk_lose_power(&dark);
    if (!small_check(&run, &disk, fault.lasts > 1, text))
        wrong(figures, what, text);
    snprintf(dark_what, sizeof(dark_what), "%s, then a power cut", what);
    if (!small_check(&run, &dark, fault.lasts > 1, text))
        wrong(figures, dark_what, text);
    model_disk_free(&dark);
    model_disk_free(&disk);
}

/* Of the quick run: all of what the store answers by more than an error, and a share of the rest. */
static bool is_of_this_run(const struct fault_kind *kind, long at, enum small_temper temper)
{
    if (everything || (kind->quick && temper == SMALL_PERSISTS))
        return true;
    return (at + (kind - fault_kinds)) % SHARE == 0;
}

static void each_operation_fails(enum small_temper temper)
{
    static struct model_call log[LOG_ROOM];
    long n = clean_run(log), all_wrong = 0;

    for (unsigned i = 0; i < n_fault_kinds; i++) {
        struct figures figures = {0};

        for (long at = 1; at <= n; at++)
            if (fault_fits(&fault_kinds[i], &log[at - 1]) &&
                is_of_this_run(&fault_kinds[i], at, temper))
                one(&fault_kinds[i], at, &log[at - 1], temper, &figures);
        print_message("%-28s %5ld injected: %ld recovered, %ld told (%ld of them: no dataset)\n",
                      fault_kinds[i].name, figures.injections, figures.recovered, figures.refused,
                      figures.not_created);
        all_wrong += figures.wrong;
    }
    assert_int_equal(all_wrong, 0);
}

static void a_caller_that_gives_up_loses_nothing(void **state)
{
    each_operation_fails(SMALL_GIVES_UP);
}

static void a_caller_that_opens_anew_and_goes_on_loses_nothing(void **state)
{
    each_operation_fails(SMALL_PERSISTS);
}

/* "all": every operation fails in every way; else a share of it, in some seconds. */
int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_caller_that_gives_up_loses_nothing),
        cmocka_unit_test(a_caller_that_opens_anew_and_goes_on_loses_nothing),
    };

    everything = argc > 1 && strcmp(argv[1], "all") == 0;
    return cmocka_run_group_tests(tests, NULL, NULL);
}
