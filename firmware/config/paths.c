/* SPDX-License-Identifier: Apache-2.0 */
#include "paths.h"

#include <limits.h>
#include <stdio.h>
#include <string.h>

void cfg_from_folder_of(const char *file, char path[512])
{
    const char *slash = strrchr(file, '/');
    char whole[PATH_MAX];

    if (!*path || *path == '/' || !slash)
        return;
    snprintf(whole, sizeof whole, "%.*s/%s", (int)(slash - file), file, path);
    if (strlen(whole) < 512)
        memcpy(path, whole, strlen(whole) + 1);
}

void cfg_dataset_of_plan(const char *plan, char ret[128])
{
    const char *slash = strrchr(plan, '/'), *name = slash ? slash + 1 : plan;
    size_t n = strlen(name);

    if (n > 5 && strcmp(name + n - 5, ".yaml") == 0)
        n -= 5;
    (void)snprintf(ret, 128, "%.*s", (int)n, name);
}
