/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A capture that may be killed at any moment:
 *
 *   capture_child DATASET POWER_ON_NS SLOTS [waits]
 *
 * Prints "INDEX ELAPSED_NS RESULT" once a slot is committed, and not before. Exits 0 when
 * the dataset is sealed. waits: nothing more is committed before a byte has come from standard
 * input for each line, so that whoever logs what the disk is told knows where the line belongs.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "sim_run.h"
#include "ttf/base/time.h"

static bool waits;

static void say(struct sim_run *run, const struct ttf_progress *progress)
{
    if (progress->kind != TTF_PROGRESS_SLOT)
        return;
    printf("%lld %lld %c\n", (long long)progress->index,
           (long long)ttf_sim_elapsed_ns(run->box, progress->now_ns), "cpmfzw"[progress->result]);
    fflush(stdout);
    if (waits)
        (void)getchar();
}

int main(int argc, char **argv)
{
    static struct sim_run run;

    if (argc != 4 && (argc != 5 || strcmp(argv[4], "waits") != 0))
        return 2;
    waits = argc == 5;
    sim_run_plain(&run);
    snprintf(run.path, sizeof(run.path), "%s", argv[1]);
    run.config.power_on_ns = strtoll(argv[2], NULL, 10);
    run.plan.count = strtoll(argv[3], NULL, 10);
    run.on_progress = say;
    if (sim_run_boot(&run) < 0) {
        fprintf(stderr, "%s: %s\n", run.err.where, run.err.what);
        return 1;
    }
    return run.result.sealed ? 0 : 1;
}
