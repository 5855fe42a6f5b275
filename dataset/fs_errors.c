/* SPDX-License-Identifier: Apache-2.0 */
/*
 * fs_errors.c: errors that a file system has found in itself. A card that wears out shows in these before our own
 * writes fail: ext4 counts them in its superblock until a check (e2fsck) has mended them, and tells by
 * /sys/fs/ext4/DEVICE/errors_count (the kernel's fs/ext4/sysfs.c), which anyone may read.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/sysmacros.h>
#include <unistd.h>

#include "ttf/dataset/io.h"

int64_t ttf_io_fs_errors(const char *sys, uint64_t device)
{
    char path[512], target[256];
    const char *name;
    int64_t errors = 0;
    FILE *file;
    ssize_t n;

    (void)snprintf(path, sizeof path, "%s/dev/block/%u:%u", sys, major(device), minor(device));
    n = readlink(path, target, sizeof target - 1);
    if (n <= 0)
        return 0; /* on no device: in memory, over a network */
    target[n] = '\0';
    name = strrchr(target, '/');
    (void)snprintf(path, sizeof path, "%s/fs/ext4/%s/errors_count", sys, name ? name + 1 : target);
    file = fopen(path, "re");
    if (!file)
        return 0;
    if (fgets(path, sizeof path, file))
        errors = strtoll(path, NULL, 10);
    (void)fclose(file);
    return errors > 0 ? errors : 0;
}
