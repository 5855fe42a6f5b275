/* SPDX-License-Identifier: Apache-2.0 */
#include "trouble.h"

#include <errno.h>
#include <string.h>

const char *trouble_name(enum trouble_kind kind)
{
    static const char *const names[TROUBLE_KIND_COUNT] = {"nothing", "killed", "a sync fails",
                                                          "an operation fails", "disk full"};

    return names[kind];
}

static bool fits(enum trouble_kind kind, const char *op)
{
    switch (kind) {
    case TROUBLE_NONE:
        return false;
    case TROUBLE_SYNC:
        return strcmp(op, "sync") == 0;
    case TROUBLE_STEP:
        return strcmp(op, "sync") != 0;
    case TROUBLE_FULL:
        return strcmp(op, "append") == 0 || strcmp(op, "open") == 0 || strcmp(op, "mkdir") == 0;
    default:
        return true;
    }
}

int trouble_step(struct trouble *trouble, struct run *run, const char *op, const char *path)
{
    enum trouble_kind kind = trouble->kind;

    trouble->step++;
    if (trouble->step < trouble->at || !fits(kind, op))
        return 0;
    trouble->kind = TROUBLE_NONE;
    trouble->over = run->may_fail = run->promise.troubled = true;
    if (kind == TROUBLE_KILLED)
        disk_kill(run->disk);
    if (kind == TROUBLE_SYNC)
        disk_lose_dirty(run->disk, path);
    return kind == TROUBLE_FULL ? -ENOSPC : -EIO;
}

bool trouble_killed(const struct run *run)
{
    struct ttf_io *io = disk_io(run->disk);

    return io->ops->lock(io, 0) == -EIO;
}

bool trouble_begin_anew(struct trouble *trouble, struct run *run)
{
    run_end(run);
    disk_revive(run->disk);
    trouble->over = run->may_fail = false;
    return run_do(run, RUN_CREATE);
}
