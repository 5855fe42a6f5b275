/* SPDX-License-Identifier: Apache-2.0 */
/* disk.c: the machine's disks as a box sees them; see box.h. */
#include <errno.h>
#include <string.h>

#include "box.h"
#include "ttf/hal/sim.h"

/* Which operations a full disk refuses; a failing one refuses all that reach it. */
static bool needs_room(const char *op)
{
    static const char *const OPS[] = {"open", "pwrite", "append", "mkdir"};

    for (unsigned i = 0; i < TTF_COUNT_OF(OPS); i++)
        if (strcmp(OPS[i], op) == 0)
            return true;
    return false;
}

static unsigned storage_of(const struct box_disk *disk, const char *path)
{
    size_t n = strlen(disk->second);

    return n > 0 && strncmp(path, disk->second, n) == 0 && (path[n] == '/' || path[n] == '\0');
}

static void disk_space(void *ctx, const char *path, struct ttf_io_space *space)
{
    const struct box_disk *disk = ctx;
    int64_t free_bytes;
    bool read_only;

    ttf_sim_storage_state(disk->box, storage_of(disk, path), &free_bytes, &read_only);
    if (free_bytes != TTF_NS_UNKNOWN && free_bytes < space->free_bytes)
        space->free_bytes = free_bytes;
    space->read_only |= read_only;
}

static int disk_fault(void *ctx, const char *op, const char *path)
{
    const struct box_disk *disk = ctx;
    unsigned storage = storage_of(disk, path);

    if (ttf_sim_storage_fault_at(disk->box, TTF_FAULT_IO_ERROR, storage))
        return -EIO;
    if (ttf_sim_storage_fault_at(disk->box, TTF_FAULT_READ_ONLY, storage))
        return -EROFS;
    if (needs_room(op) && ttf_sim_storage_fault_at(disk->box, TTF_FAULT_DISK_FULL, storage))
        return -ENOSPC;
    return 0;
}

int box_disk_create(struct box_disk *disk, struct ttf_io *machine, const struct ttf_box *box,
                    const char *second)
{
    *disk = (struct box_disk){.box = box, .second = second, .io = machine};
    if (!box->simulated)
        return 0;
    disk->faulty = ttf_io_faulty_create(machine, disk_fault, disk);
    if (!disk->faulty)
        return -ENOMEM;
    ttf_io_faulty_space(disk->faulty, disk_space);
    disk->io = disk->faulty;
    return 0;
}

void box_disk_destroy(struct box_disk *disk)
{
    ttf_io_faulty_destroy(disk->faulty);
    disk->faulty = disk->io = NULL;
}
