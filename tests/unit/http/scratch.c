/* SPDX-License-Identifier: Apache-2.0 */
#include "scratch.h"

#include <fcntl.h>
#include <ftw.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

int scratch_make(void **state)
{
    const char *tmp = getenv("TMPDIR"); /* NOLINT(concurrency-mt-unsafe) */
    char *path = NULL;

    if (asprintf(&path, "%s/ttf-http-XXXXXX", tmp ? tmp : "/tmp") < 0 || !mkdtemp(path) ||
        chdir(path) < 0)
        return -1;
    *state = path;
    return 0;
}

static int drop(const char *path, const struct stat *st, int kind, struct FTW *ftw)
{
    (void)st;
    (void)kind;
    (void)ftw;
    return remove(path);
}

int scratch_remove(void **state)
{
    char *path = *state;
    int r = chdir("/");

    if (r == 0)
        /* NOLINTNEXTLINE(concurrency-mt-unsafe): one thread runs */
        r = nftw(path, drop, 8, FTW_DEPTH | FTW_PHYS);
    free(path);
    return r;
}

void scratch_file(const char *path, const void *bytes, size_t n)
{
    char folder[512];
    int fd;

    for (const char *slash = strchr(path + 1, '/'); slash; slash = strchr(slash + 1, '/')) {
        (void)snprintf(folder, sizeof folder, "%.*s", (int)(slash - path), path);
        (void)mkdir(folder, 0755);
    }
    fd = open(path, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
    if (fd < 0 || write(fd, bytes, n) != (ssize_t)n)
        perror(path); /* what reads it fails the test */
    if (fd >= 0)
        (void)close(fd);
}
