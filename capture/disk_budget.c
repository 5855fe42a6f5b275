/* SPDX-License-Identifier: Apache-2.0 */
#include "ttf/capture/disk_budget.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ttf/base/time.h"

#define PROBE_MAX_BYTES (INT64_C(64) << 20)
#define PROBE_MIN_BYTES (INT64_C(1) << 20)
#define CHUNK_BYTES     (256 << 10)
#define PATH_BYTES      4096

/* A slot must take less of its interval than this to write: cards slow down when they fill. */
#define BUSY_SHARE 0.7

/* The nearest folder above `path` that exists. */
static int existing_folder(struct ttf_io *io, const char *path, char *ret, size_t size)
{
    struct ttf_io_stat st;
    char *slash;

    if (strlen(path) >= size)
        return -ENAMETOOLONG;
    snprintf(ret, size, "%s", path);
    while (io->ops->stat(io, ret, &st) < 0 || !st.is_dir) {
        slash = strrchr(ret, '/');
        if (!slash) {
            snprintf(ret, size, ".");
            return 0;
        }
        if (slash == ret) {
            snprintf(ret, size, "/");
            return 0;
        }
        *slash = '\0';
    }
    return 0;
}

static int write_probe(struct ttf_io *io, int file, int64_t bytes)
{
    unsigned char *chunk = malloc(CHUNK_BYTES);
    uint32_t x = 1;
    int r = 0;

    if (!chunk)
        return -ENOMEM;
    for (size_t i = 0; i < CHUNK_BYTES; i++) { /* not compressible, for disks that would */
        x = x * 1664525u + 1013904223u;
        chunk[i] = (unsigned char)(x >> 24);
    }
    for (int64_t at = 0; at < bytes && r == 0; at += CHUNK_BYTES)
        r = ttf_io_pwrite_all(io, file, chunk, CHUNK_BYTES, at);
    free(chunk);
    return r < 0 ? r : io->ops->sync(io, file, false);
}

/* A new file. One of that name was left by a try whose power went; if it cannot be removed, that is what is wrong. */
static int begin_probe(struct ttf_io *io, const char *path)
{
    int r = io->ops->unlink(io, path);

    return r < 0 && r != -ENOENT ? r : io->ops->open(io, path, TTF_IO_CREATE_NEW);
}

/* Writes, syncs and removes a file; bytes per second. */
static int64_t measure(struct ttf_io *io, const char *folder, struct ttf_clock *clock,
                       int64_t bytes)
{
    char path[PATH_BYTES + 32];
    int64_t began;
    int64_t took;
    int file;
    int r;

    snprintf(path, sizeof(path), "%s/.write-speed.tmp", folder);
    file = begin_probe(io, path);
    if (file < 0)
        return file;
    began = ttf_clock_now_ns(clock);
    r = write_probe(io, file, bytes);
    took = ttf_clock_now_ns(clock) - began;
    (void)io->ops->close(io, file);
    (void)io->ops->unlink(io, path);
    if (r < 0)
        return r;
    return (int64_t)((double)bytes * 1e9 / (double)(took > 0 ? took : 1));
}

static int check_space(const struct ttf_plan *plan, const struct ttf_plan_figures *f,
                       const char *path, struct ttf_disk_figures *d, struct ttf_err *err)
{
    int64_t room = d->free_bytes - plan->reserve_bytes;

    d->slots_that_fit = f->slot_bytes > 0 && room > 0 ? room / f->slot_bytes : 0;
    if (f->slot_bytes == 0 || d->slots_that_fit >= plan->count)
        return 0;
    ttf_err_set(
        err, -ENOSPC, path, "the plan needs %.1f MB and %.1f MB of reserve; %.1f MB are free",
        (double)f->bytes / 1e6, (double)plan->reserve_bytes / 1e6, (double)d->free_bytes / 1e6);
    ttf_err_hint(err, "make room, or take at most %lld slots", (long long)d->slots_that_fit);
    return -ENOSPC;
}

static int check_speed(const struct ttf_plan *plan, const struct ttf_plan_figures *f,
                       struct ttf_disk_figures *d, struct ttf_err *err)
{
    double needs_ns = (double)f->slot_bytes * 1e9 / (double)d->bytes_per_s / BUSY_SHARE;

    d->shortest_interval_ns = (int64_t)needs_ns;
    if (d->shortest_interval_ns <= plan->interval_ns)
        return 0;
    ttf_err_set(err, -EINVAL, "interval",
                "the disk takes %.1f MB/s, written and synced; a slot of %.1f MB needs %.2f s",
                (double)d->bytes_per_s / 1e6, (double)f->slot_bytes / 1e6, needs_ns / 1e9);
    ttf_err_hint(err, "take an interval of %.1f s or more, a smaller region, or another disk",
                 needs_ns / 1e9 + 0.05);
    return -EINVAL;
}

/* What there is where the path lies or will lie; -EROFS: and it can only be read. */
static int find_space(struct ttf_io *io, const char *path, char folder[PATH_BYTES],
                      struct ttf_io_space *ret, struct ttf_err *err)
{
    int r = existing_folder(io, path, folder, PATH_BYTES);

    if (r == 0)
        r = io->ops->space(io, folder, ret);
    if (r < 0)
        return ttf_err_set(err, r, path, "the folder's free space cannot be found out");
    return ret->read_only ? ttf_err_set(err, -EROFS, folder, "the disk can only be read") : 0;
}

int ttf_disk_room_check(struct ttf_io *io, const char *path, const char *what, int64_t bytes,
                        struct ttf_err *err)
{
    struct ttf_io_space space = {0};
    char folder[PATH_BYTES];
    int r = find_space(io, path, folder, &space, err);

    if (r < 0 || space.free_bytes >= bytes)
        return r;
    ttf_err_set(err, -ENOSPC, path, "%s needs %.1f MB; %.1f MB are free", what, (double)bytes / 1e6,
                (double)space.free_bytes / 1e6);
    ttf_err_hint(err, "make room");
    return -ENOSPC;
}

int ttf_disk_budget_check(struct ttf_io *io, const char *path, struct ttf_clock *clock,
                          const struct ttf_plan *plan, const struct ttf_plan_figures *figures,
                          struct ttf_disk_figures *ret, struct ttf_err *err)
{
    struct ttf_disk_figures d = {0};
    struct ttf_io_space space = {0};
    char folder[PATH_BYTES];
    int r = find_space(io, path, folder, &space, err);

    if (r < 0)
        return r;
    d.free_bytes = space.free_bytes;
    r = check_space(plan, figures, path, &d, err);
    if (r == 0 && clock && !ttf_clock_is_virtual(clock)) {
        int64_t bytes = figures->slot_bytes;

        bytes = bytes < PROBE_MIN_BYTES ? PROBE_MIN_BYTES : bytes;
        bytes = bytes > PROBE_MAX_BYTES ? PROBE_MAX_BYTES : bytes;
        d.bytes_per_s = measure(io, folder, clock, bytes);
        if (d.bytes_per_s < 0)
            r = ttf_err_set(err, (int)d.bytes_per_s, folder, "nothing can be written here");
        else
            r = check_speed(plan, figures, &d, err);
    }
    if (ret)
        *ret = d;
    return r;
}

/* A file of a few bytes, written, synced and removed again. */
static int try_writing(struct ttf_io *io, const char *folder)
{
    char path[PATH_BYTES + 32];
    int file;
    int r;

    snprintf(path, sizeof(path), "%s/.second-storage.tmp", folder);
    file = begin_probe(io, path);
    if (file < 0)
        return file;
    r = ttf_io_pwrite_all(io, file, path, 16, 0);
    if (r == 0)
        r = io->ops->sync(io, file, false);
    (void)io->ops->close(io, file);
    (void)io->ops->unlink(io, path);
    return r;
}

int ttf_second_storage_check(struct ttf_io *io, const char *path, const struct ttf_plan *plan,
                             bool *ret_same, struct ttf_err *err)
{
    int r = ttf_second_storage_look(io, path, plan, ret_same, err);

    if (r < 0 || plan->second_storage[0] == '\0')
        return r;
    r = try_writing(io, plan->second_storage);
    return r < 0 ? ttf_err_set(err, r, "storage.second", "nothing can be written in %s",
                               plan->second_storage)
                 : 0;
}

int ttf_second_storage_look(struct ttf_io *io, const char *path, const struct ttf_plan *plan,
                            bool *ret_same, struct ttf_err *err)
{
    static const char field[] = "storage.second";
    const char *second = plan->second_storage;
    struct ttf_io_stat of_first = {0};
    struct ttf_io_stat of_second = {0};
    char folder[PATH_BYTES];
    int r;

    if (ret_same)
        *ret_same = false;
    if (second[0] == '\0')
        return 0;
    r = io->ops->stat(io, second, &of_second);
    if (r == 0 && !of_second.is_dir)
        r = -ENOTDIR;
    if (r < 0) {
        ttf_err_set(err, r, field, "%s is no folder that is there", second);
        ttf_err_hint(err, "mount the disk, or make the folder");
        return r;
    }
    if (path[0] == '\0' || existing_folder(io, path, folder, sizeof(folder)) < 0 ||
        io->ops->stat(io, folder, &of_first) < 0 || of_first.device == 0 ||
        of_first.device != of_second.device)
        return 0;
    if (of_first.inode == of_second.inode) {
        ttf_err_set(err, -EINVAL, field, "%s is the folder that the dataset itself lies in",
                    second);
        ttf_err_hint(err, "name one on another disk");
        return -EINVAL;
    }
    if (ret_same)
        *ret_same = true;
    return 0;
}
