/* SPDX-License-Identifier: Apache-2.0 */
#include "parts.h"

#include <stdio.h>
#include <stdlib.h>
#include <sys/wait.h>
#include <unistd.h>

unsigned parts_of_cores(void)
{
    long cores = sysconf(_SC_NPROCESSORS_ONLN);

    return cores > PARTS_MAX ? PARTS_MAX : cores < 1 ? 1 : (unsigned)cores;
}

static _Noreturn void work_and_end(const struct parts *parts, unsigned part, void *found, int to)
{
    parts->work(parts->ctx, part, found);
    (void)fflush(stdout);
    _exit(write(to, found, parts->bytes) == (ssize_t)parts->bytes ? 0 : 1);
}

bool parts_work(const struct parts *parts)
{
    void *found = calloc(1, parts->bytes);
    int ends[PARTS_MAX][2], status;
    bool well = found != NULL;
    unsigned begun;

    (void)fflush(stdout);
    for (begun = 0; well && begun < parts->n; begun++) {
        pid_t pid;

        if (pipe(ends[begun]) != 0) {
            well = false;
            break;
        }
        pid = fork();
        if (pid == 0)
            work_and_end(parts, begun, found, ends[begun][1]);
        well = pid > 0;
        (void)close(ends[begun][1]);
    }
    for (unsigned i = 0; i < begun; i++) {
        if (read(ends[i][0], found, parts->bytes) == (ssize_t)parts->bytes)
            parts->add(parts->ctx, found);
        else
            well = false;
        (void)close(ends[i][0]);
    }
    while (wait(&status) > 0)
        well = well && WIFEXITED(status) && WEXITSTATUS(status) == 0;
    free(found);
    return well;
}
