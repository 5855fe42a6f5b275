/* SPDX-License-Identifier: Apache-2.0 */
#include "export_staging.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "io_path.h"

const char *staging_base(const char *path)
{
    const char *slash = strrchr(path, '/');

    return slash ? slash + 1 : path;
}

static int any_entry(void *ctx, const char *name, bool is_dir)
{
    (void)ctx;
    (void)name;
    (void)is_dir;
    return 1;
}

static int check_final(struct staging *staging, bool *ret_empty_folder, struct ttf_err *err)
{
    struct ttf_io *io = staging->io;
    struct ttf_io_stat stat;
    int r;

    *ret_empty_folder = false;
    if (io->ops->stat(io, staging->final, &stat) < 0)
        return 0;
    if (!staging->folder && stat.is_dir)
        return ttf_err_set(err, -EISDIR, staging->final, "there is a folder of that name");
    if (!staging->folder)
        return 0;
    if (!stat.is_dir)
        return ttf_err_set(err, -EEXIST, staging->final, "there is a file of that name");
    r = io->ops->list(io, staging->final, any_entry, NULL);
    if (r < 0)
        return ttf_err_set(err, r, staging->final, "the folder cannot be listed: %s",
                           strerrordesc_np(-r));
    if (r > 0) {
        ttf_err_set(err, -EEXIST, staging->final, "the folder is there already and is not empty");
        ttf_err_hint(err, "choose another name or remove it");
        return -EEXIST;
    }
    *ret_empty_folder = true;
    return 0;
}

static void release(struct staging *staging)
{
    free(staging->final);
    free(staging->temp);
    free(staging->beside);
    free(staging->beside_temp);
    memset(staging, 0, sizeof(*staging));
}

static void put_instead(char *text, size_t size, const char *old, const char *new)
{
    char *at = strstr(text, old), rest[sizeof(((struct ttf_err *)NULL)->what)];

    if (!at)
        return;
    (void)snprintf(rest, sizeof rest, "%s", at + strlen(old));
    (void)snprintf(at, size - (size_t)(at - text), "%s%s", new, rest);
}

void staging_name_final(const struct staging *staging, struct ttf_err *err)
{
    if (!err || !staging->temp)
        return;
    put_instead(err->where, sizeof err->where, staging->temp, staging->final);
    put_instead(err->what, sizeof err->what, staging->temp, staging->final);
}

static int prepare(struct staging *staging, struct ttf_err *err)
{
    char *parent = ttf_path_parent(staging->final);
    bool empty;
    int code;

    if (parent)
        /* The name is kept short: a dataset's is at most 64 characters. */
        staging->temp = ttf_path_format("%s/.%.40s.part-%ld", parent, staging_base(staging->final),
                                        (long)getpid());
    if (!staging->temp) {
        free(parent);
        return ttf_err_set(err, -ENOMEM, staging->final, "no memory for a path");
    }
    code = ttf_io_mkdirs(staging->io, parent, err);
    free(parent);
    if (code)
        return code;
    code = check_final(staging, &empty, err);
    if (code)
        return code;
    (void)ttf_io_remove_tree(staging->io,
                             staging->temp); /* of a process of the same number, long ago */
    if (!staging->folder)
        return 0;
    code = staging->io->ops->mkdir(staging->io, staging->temp);
    if (code)
        return ttf_err_set(err, code, staging->final, "the folder cannot be made: %s",
                           strerrordesc_np(-code));
    return 0;
}

/*
 * A link leads to the place that is meant, on another disk perhaps: what it leads to is replaced, and not the link.
 * Asked of the machine, as no table of file access knows links.
 */
static int follow_link(struct staging *staging, struct ttf_err *err)
{
    struct stat st;
    char *real;

    if (lstat(staging->final, &st) < 0 || !S_ISLNK(st.st_mode))
        return 0;
    real = realpath(staging->final, NULL);
    if (!real)
        return ttf_err_set(err, errno == ENOMEM ? -ENOMEM : -ENOENT, staging->final,
                           "is a link that leads nowhere");
    free(staging->final);
    staging->final = real;
    return 0;
}

int staging_begin(struct staging *staging, struct ttf_io *io, const char *final, bool folder,
                  struct ttf_err *err)
{
    size_t n = final ? strlen(final) : 0;
    int code;

    memset(staging, 0, sizeof(*staging));
    while (n > 1 && final[n - 1] == '/')
        n--;
    if (n == 0)
        return ttf_err_set(err, -EINVAL, NULL, "no output is named");
    staging->io = io;
    staging->folder = folder;
    staging->final = strndup(final, n);
    if (!staging->final)
        return ttf_err_set(err, -ENOMEM, final, "no memory for a path");
    code = follow_link(staging, err);
    if (!code)
        code = prepare(staging, err);
    if (code)
        release(staging);
    return code;
}

static int check_beside(const struct staging *staging, struct ttf_err *err)
{
    struct ttf_io *io = staging->io;
    struct ttf_io_stat stat;

    if (staging->beside && io->ops->stat(io, staging->beside, &stat) == 0 && stat.is_dir)
        return ttf_err_set(err, -EISDIR, staging->beside, "there is a folder of that name");
    return 0;
}

int staging_beside(struct staging *staging, const char *ending, struct ttf_err *err)
{
    staging->beside = ttf_path_format("%s%s", staging->final, ending);
    staging->beside_temp = ttf_path_format("%s%s", staging->temp, ending);
    if (!staging->beside || !staging->beside_temp)
        return ttf_err_set(err, -ENOMEM, staging->final, "no memory for a path");
    (void)staging->io->ops->unlink(staging->io, staging->beside_temp);
    return check_beside(staging, err);
}

/* A child may have written the file, so it is opened once more to be synced; or said so and has not. */
static int sync_file(struct ttf_io *io, const char *path)
{
    struct ttf_io_stat stat;
    int file, code = io->ops->stat(io, path, &stat);

    if (code == 0 && stat.bytes == 0)
        code = -ENODATA;
    if (code)
        return code;
    file = io->ops->open(io, path, TTF_IO_APPEND);
    if (file < 0)
        return file;
    code = io->ops->sync(io, file, false);
    io->ops->close(io, file);
    return code;
}

/* What lies beside goes first: an output is never there without it. */
static int put_in_place(const struct staging *staging, bool empty)
{
    struct ttf_io *io = staging->io;
    struct ttf_io_stat stat;
    bool added = staging->beside && io->ops->stat(io, staging->beside, &stat) == -ENOENT;
    int code = staging->beside ? io->ops->rename(io, staging->beside_temp, staging->beside) : 0;

    if (code)
        return code;
    if (empty)
        code = io->ops->unlink(io, staging->final);
    if (!code)
        code = io->ops->rename(io, staging->temp, staging->final);
    if (code && added)
        (void)io->ops->unlink(io, staging->beside);
    return code;
}

int staging_commit(struct staging *staging, struct ttf_err *err)
{
    struct ttf_io *io = staging->io;
    bool empty;
    int code = check_final(staging, &empty, err);

    if (!code)
        code = check_beside(staging, err);
    if (code) {
        staging_discard(staging);
        return code;
    }
    code = staging->folder ? io->ops->sync_dir(io, staging->temp) : sync_file(io, staging->temp);
    if (!code)
        code = put_in_place(staging, empty);
    if (!code)
        code = ttf_io_sync_parent(io, staging->final);
    if (code) {
        ttf_err_set(err, code, staging->final, "the output cannot be put in its place: %s",
                    strerrordesc_np(-code));
        staging_discard(staging);
        return code;
    }
    release(staging);
    return 0;
}

void staging_discard(struct staging *staging)
{
    if (staging->temp)
        (void)ttf_io_remove_tree(staging->io, staging->temp);
    if (staging->beside_temp)
        (void)staging->io->ops->unlink(staging->io, staging->beside_temp);
    release(staging);
}

int staging_write(struct ttf_io *io, const char *path,
                  int (*produce)(void *ctx, struct ttf_io *io, int file, struct ttf_err *err),
                  void *ctx, struct ttf_err *err)
{
    int file = io->ops->open(io, path, TTF_IO_CREATE_NEW);
    int code;

    if (file < 0)
        return ttf_err_set(err, file, path, "cannot be created: %s", strerrordesc_np(-file));
    code = produce(ctx, io, file, err);
    if (!code) {
        code = io->ops->sync(io, file, false);
        if (code)
            ttf_err_set(err, code, path, "cannot be synced: %s", strerrordesc_np(-code));
    }
    io->ops->close(io, file);
    if (code)
        io->ops->unlink(io, path);
    if (code && err && !err->where[0])
        (void)snprintf(err->where, sizeof err->where, "%s", path);
    return code;
}
