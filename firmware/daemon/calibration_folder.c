/* SPDX-License-Identifier: Apache-2.0 */
#include "calibration_folder.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

#define ASIDE "removed" /* ".NAME.removed": names of calibrations begin with no dot */
#define PATH  1024

/* One entry of a folder. */
struct entry {
    char name[256];
    bool is_dir;
};

static int take_first(void *ctx, const char *name, bool is_dir)
{
    struct entry *entry = ctx;

    (void)snprintf(entry->name, sizeof entry->name, "%s", name);
    entry->is_dir = is_dir;
    return 1;
}

static int take_aside(void *ctx, const char *name, bool is_dir)
{
    size_t n = strlen(name), end = sizeof "." ASIDE - 1;

    return is_dir && *name == '.' && n > end && strcmp(name + n - end, "." ASIDE) == 0
               ? take_first(ctx, name, is_dir)
               : 0;
}

/* A calibration has files alone; what else a person put there stops it. */
static int empty_and_remove(struct ttf_io *io, const char *folder)
{
    char path[PATH + 300];
    struct entry entry;
    int r;

    while ((r = io->ops->list(io, folder, take_first, &entry)) == 1) {
        (void)snprintf(path, sizeof path, "%s/%s", folder, entry.name);
        r = entry.is_dir ? -ENOTEMPTY : io->ops->unlink(io, path);
        if (r < 0)
            return r;
    }
    return r < 0 ? r : io->ops->unlink(io, folder);
}

int calibration_folder_put_aside(struct ttf_io *io, const char *above, const char *name,
                                 struct ttf_err *err)
{
    char path[PATH], aside[PATH];
    struct ttf_io_stat st;
    int r;

    (void)snprintf(path, sizeof path, "%.700s/%.64s", above, name);
    (void)snprintf(aside, sizeof aside, "%.700s/.%.64s." ASIDE, above, name);
    r = io->ops->stat(io, path, &st);
    if (r == -ENOENT || (r == 0 && !st.is_dir))
        return ttf_err_set(err, -ENOENT, NULL, "there is no calibration of this name");
    if (r == 0 && io->ops->stat(io, aside, &st) == 0)
        r = empty_and_remove(io, aside); /* of one of the same name, cut off */
    if (r == 0)
        r = io->ops->rename(io, path, aside);
    return r < 0 ? ttf_err_set(err, r, name, "cannot be removed: %s", strerrordesc_np(-r)) : 0;
}

int calibration_folder_sweep(struct ttf_io *io, const char *above, struct ttf_err *err)
{
    char path[PATH];
    struct entry entry;
    bool some = false;
    int r;

    r = io->ops->list(io, above, take_aside, &entry);
    if (r == 1) /* that it is away comes first: what is emptied next never comes back by its name */
        r = io->ops->sync_dir(io, above);
    while (r == 0 && (r = io->ops->list(io, above, take_aside, &entry)) == 1) {
        (void)snprintf(path, sizeof path, "%.700s/%.255s", above, entry.name);
        r = empty_and_remove(io, path);
        some = true;
    }
    if (r == 0 && some)
        r = io->ops->sync_dir(io, above);
    return r < 0 && r != -ENOENT ? ttf_err_set(err, r, above, "what was removed is still there: %s",
                                               strerrordesc_np(-r))
                                 : 0;
}
