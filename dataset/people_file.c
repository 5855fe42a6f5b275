/* SPDX-License-Identifier: Apache-2.0 */
#include "people_file.h"

#include <errno.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include <sys/random.h>

#include "io_path.h"

/* Of one addition. */
struct adding {
    struct ttf_io *io;
    const struct ttf_people_file *what;
    void *ctx;
    const char *path;
    char *name, *fresh;   /* the file's, and its new one's */
    int guard, old, file; /* -1: none */
    bool there;           /* the file, and what its name stood for before it was opened */
    struct ttf_io_stat was;
};

/* Returns the size of what was there, or a negative errno. */
static int64_t fill(struct adding *a, struct ttf_err *err)
{
    int64_t bytes = 0;
    int r = a->old < 0 ? 0 : a->io->ops->size(a->io, a->old, &bytes);

    if (r == 0)
        r = a->what->fill(a->ctx, a->io, a->old, bytes, a->file, err);
    return r ? r : bytes;
}

/* By its name: a tool that takes no lock may have appended, made one, or put another in its place. */
static int still_as_it_was(const struct adding *a, int64_t bytes)
{
    struct ttf_io_stat now = {0}; /* not every table knows all of it */
    int r = a->io->ops->stat(a->io, a->name, &now);

    if (r == -ENOENT)
        return a->there ? -EAGAIN : 0;
    if (r)
        return r;
    if (!a->there || now.device != a->was.device || now.inode != a->was.inode)
        return -EAGAIN;
    return now.bytes != bytes || now.mtime_ns != a->was.mtime_ns ? -EAGAIN : 0;
}

/*
 * As a new file that takes the old one's place, for each addition: after a sync that failed, of this one or of anybody's before it, nobody knows
 * which bytes and names that are seen are on the disk, and what stands behind a hole is lost with it (DESIGN.md, "Notes and samples").
 */
static int write_fresh(struct adding *a, struct ttf_err *err)
{
    struct ttf_io *io = a->io;
    int64_t bytes;
    int r;

    a->file = io->ops->open(io, a->fresh, TTF_IO_CREATE_NEW);
    if (a->file < 0)
        return a->file;
    r = ttf_io_inherit(io, a->file, a->name);
    bytes = r ? r : fill(a, err);
    r = bytes < 0 ? (int)bytes : io->ops->sync(io, a->file, false);
    if (r == 0)
        r = still_as_it_was(a, bytes);
    if (r == 0)
        r = io->ops->rename(io, a->fresh, a->name);
    if (r == -ENOENT &&
        err->code != r) /* another one's remove_leftovers; fill says what it means by it */
        r = -EAGAIN;
    if (r)
        (void)io->ops->unlink(io, a->fresh);
    return r ? r : io->ops->sync_dir(io, a->path);
}

struct leftover {
    const char *begins;
    char name[TTF_PATH_MAX];
};

static int take_leftover(void *ctx, const char *name, bool is_dir)
{
    struct leftover *leftover = ctx;
    int r;

    (void)is_dir;
    if (strncmp(name, leftover->begins, strlen(leftover->begins)) != 0)
        return 0;
    r = ttf_path_put(leftover->name, "%s", name);
    return r ? r : 1;
}

/*
 * Of those that were cut off. Where the lock guards nothing, one may be somebody's who is writing it: he finds it gone when he renames it, and
 * tries again, as its name is his alone.
 */
static int remove_leftovers(const struct adding *a)
{
    struct leftover leftover = {.begins = a->what->fresh};
    char path[TTF_PATH_MAX];
    int r;

    while ((r = a->io->ops->list(a->io, a->path, take_leftover, &leftover)) > 0) {
        r = ttf_path_put(path, "%s/%s", a->path, leftover.name);
        if (r == 0)
            r = a->io->ops->unlink(a->io, path);
        if (r && r != -ENOENT)
            return r;
    }
    return r;
}

/* The lock is of dataset.json, which is there before any addition and is never replaced; the folder's is the writer's. */
static int lock(struct adding *a, struct ttf_err *err)
{
    char *manifest = ttf_path_format("%s/dataset.json", a->path);
    int r = -ENOMEM;

    if (manifest)
        r = a->guard = a->io->ops->open(a->io, manifest, TTF_IO_READ);
    free(manifest);
    if (r == -ENOMEM)
        return ttf_err_set(err, r, a->path, "no memory");
    if (r == -ENOENT)
        return ttf_err_set(err, r, a->path, "is no dataset");
    if (r < 0)
        return ttf_err_set(err, r, a->path, "cannot be read: %s", strerrordesc_np(-r));
    r = ttf_io_lock(a->io, a->guard);
    if (r == -EAGAIN)
        ttf_err_set(err, r, a->path, "another note is being written, or a sample: try again");
    else if (r)
        ttf_err_set(err, r, a->path, "cannot be locked: %s", strerrordesc_np(-r));
    return r;
}

/* No name that another adder has or had, on this machine or on another: what is renamed is whole, and his own. */
static int name_files(struct adding *a)
{
    unsigned long long random;

    if (getrandom(&random, sizeof(random), 0) != (ssize_t)sizeof(random))
        return -EIO;
    a->name = ttf_path_format("%s/%s", a->path, a->what->name);
    a->fresh = ttf_path_format("%s/%s-%016llx", a->path, a->what->fresh, random);
    return a->name && a->fresh ? 0 : -ENOMEM;
}

static int open_old(struct adding *a)
{
    int r = a->io->ops->stat(a->io, a->name, &a->was);

    a->there = r == 0;
    if (r)
        return r == -ENOENT ? 0 : r;
    a->old = a->io->ops->open(a->io, a->name, TTF_IO_READ);
    if (a->old == -ENOENT)
        return -EAGAIN;
    return a->old < 0 ? a->old : 0;
}

static int add(struct adding *a, struct ttf_err *err)
{
    struct ttf_err why = {0};
    int r = lock(a, err);

    if (r)
        return r;
    r = name_files(a);
    if (r == -ENOMEM)
        return ttf_err_set(err, r, a->path, "no memory");
    if (r == 0)
        r = remove_leftovers(a);
    if (r == 0)
        r = open_old(a);
    if (r == 0)
        r = write_fresh(a, &why);
    if (r && r == why.code) { /* fill's own words */
        if (err)
            *err = why;
        return r;
    }
    if (r == -EAGAIN)
        return ttf_err_set(err, r, a->name, "something else has written it meanwhile: try again");
    if (r == -ELOOP)
        return ttf_err_set(err, r, a->name, "is a link, whose place %s would take",
                           a->what->addition);
    return r ? ttf_err_set(err, r, a->name, "%s cannot be written: %s", a->what->addition,
                           strerrordesc_np(-r))
             : 0;
}

int ttf_people_file_replace(struct ttf_io *io, const char *path, const struct ttf_people_file *what,
                            void *ctx, struct ttf_err *err)
{
    struct adding a = {
        .io = io, .what = what, .ctx = ctx, .path = path, .guard = -1, .old = -1, .file = -1};
    int r = add(&a, err);
    const int files[] = {a.file, a.old, a.guard}; /* the lock last */

    for (unsigned i = 0; i < 3; i++)
        if (files[i] >= 0)
            (void)io->ops->close(io, files[i]);
    free(a.name);
    free(a.fresh);
    return r;
}
