/* SPDX-License-Identifier: Apache-2.0 */
#include "store_ios.h"

#include <stdio.h>
#include <string.h>

static int no_sync(struct ttf_io *io, int file, bool data_only)
{
    return 0;
}

static int no_sync_dir(struct ttf_io *io, const char *path)
{
    return 0;
}

struct ttf_io *quick_io(void)
{
    static struct ttf_io_ops ops;
    static struct ttf_io io = {.ops = &ops};

    ops = *ttf_io_posix()->ops;
    ops.sync = no_sync;
    ops.sync_dir = no_sync_dir;
    return &io;
}

int cue_fault(void *ctx, const char *op, const char *path)
{
    struct cue *cue = ctx;
    const char *name = strrchr(path, '/');

    if ((cue->op && strcmp(cue->op, op) != 0) || (cue->in && !strstr(path, cue->in)))
        return 0;
    cue->n++;
    if (cue->log)
        cue->log_used += (size_t)snprintf(cue->log + cue->log_used, cue->log_room - cue->log_used,
                                          "%s %s\n", op, name ? name + 1 : path);
    if (cue->at > 0 && (cue->n == cue->at || (cue->for_ever && cue->n > cue->at)))
        return cue->error;
    return 0;
}
