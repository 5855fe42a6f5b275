/* SPDX-License-Identifier: Apache-2.0 */
/* Takes what lies in a folder of this machine onto the disk in memory. */
#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "alloc_hook.h"
#include "model_disk_private.h"
#include "ttf/dataset/io.h"

static void must_be(bool ok)
{
    if (!ok)
        abort();
}

static void take_file(struct model_disk *disk, const char *path, const char *as)
{
    char *text = NULL;
    size_t n = 0;

    must_be(ttf_io_slurp(ttf_io_posix(), path, 1 << 24, &text, &n, NULL) == 0);
    must_be(ttf_io_write_file(&disk->io, as, text, n, NULL) == 0);
    free(text);
}

static void take(struct model_disk *disk, const char *folder, const char *as)
{
    struct dirent **names;
    struct stat what;
    int n = scandir(folder, &names, NULL, alphasort);

    must_be(n >= 0 && ttf_io_mkdirs(&disk->io, as, NULL) == 0);
    for (int i = 0; i < n; i++) {
        const char *name = names[i]->d_name;
        char from[400], to[400];

        snprintf(from, sizeof(from), "%s/%s", folder, name);
        snprintf(to, sizeof(to), "%s/%s", as, name);
        must_be(stat(from, &what) == 0);
        if (S_ISREG(what.st_mode))
            take_file(disk, from, to);
        else if (strcmp(name, ".") != 0 && strcmp(name, "..") != 0)
            take(disk, from, to);
        free(names[i]);
    }
    free(names);
}

void model_disk_take(struct model_disk *disk, const char *folder, const char *as)
{
    alloc_hook_pause();
    take(disk, folder, as);
    alloc_hook_resume();
}
