/* SPDX-License-Identifier: Apache-2.0 */
#include "ttf/hal/program.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define LONGEST 80 /* a place and a name */

/* The folder of the running program, without a slash at its end. */
static int own_folder(char *ret, size_t size)
{
    ssize_t n = readlink("/proc/self/exe", ret, size - 1);
    char *slash;

    if (n < 0 || (size_t)n == size - 1)
        return -ENOENT;
    ret[n] = '\0';
    slash = strrchr(ret, '/');
    if (!slash)
        return -ENOENT;
    *slash = '\0';
    return 0;
}

int ttf_program_find(const char *name, char ret[TTF_PROGRAM_PATH_MAX])
{
    static const char *const places[] = {"/", "/../lib/ttfbox/"};
    char folder[TTF_PROGRAM_PATH_MAX - LONGEST];
    struct stat st;
    int r = -ENOENT;

    if (own_folder(folder, sizeof(folder)) < 0)
        return -ENOENT;
    for (unsigned i = 0; i < TTF_COUNT_OF(places); i++) {
        (void)snprintf(ret, TTF_PROGRAM_PATH_MAX, "%s%s%s", folder, places[i], name);
        if (stat(ret, &st) < 0 || !S_ISREG(st.st_mode))
            continue;
        if (access(ret, X_OK) == 0)
            return 0;
        r = -EACCES;
    }
    return r;
}
