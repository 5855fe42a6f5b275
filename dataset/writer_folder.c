/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Folders whose names are on the disk. One that is seen may have been made by a
 * writer that was killed, or told an error, before the folder above was synced: it
 * is there for as long as the power is (DESIGN.md, "Folders").
 */
#include <errno.h>
#include <string.h>

#include "io_path.h"
#include "writer_private.h"

/* Not ours to sync: nothing more can be done. */
static bool out_of_reach(int r)
{
    return r == -EACCES || r == -EPERM || r == -EROFS;
}

/* One folder below another, and its name on the disk. */
static int one_folder(struct ttf_io *io, const char *path)
{
    struct ttf_io_stat st;
    int r;

    r = io->ops->stat(io, path, &st);
    if (r == 0 && !st.is_dir)
        return -ENOTDIR;
    if (r == -ENOENT)
        r = io->ops->mkdir(io, path);
    return r ? r : ttf_io_sync_parent(io, path);
}

int ttf_writer_folder(struct ttf_writer *writer, const char *folder, struct ttf_err *err)
{
    char path[TTF_PATH_MAX];
    size_t i = strlen(writer->path) + 1;
    int r;

    r = ttf_path_put(path, "%s/%s", writer->path, folder);
    for (; r == 0 && path[i - 1] != '\0'; i++)
        if (path[i] == '/' || path[i] == '\0') {
            char c = path[i];

            path[i] = '\0';
            r = one_folder(writer->io, path);
            path[i] = c;
        }
    return r ? ttf_err_set(err, r, folder, "this folder cannot be made: %s", strerrordesc_np(-r))
             : 0;
}

int ttf_writer_sync_names(struct ttf_writer *writer, struct ttf_err *err)
{
    int r;

    r = ttf_io_sync_parent(writer->io, writer->path);
    if (r == 0 || out_of_reach(r))
        r = writer->io->ops->sync_dir(writer->io, writer->path);
    return r ? ttf_err_set(err, r, writer->path, "this folder cannot be synced to the disk: %s",
                           strerrordesc_np(-r))
             : 0;
}

void ttf_writer_sync_above(struct ttf_writer *writer)
{
    char path[TTF_PATH_MAX], *slash;

    if (ttf_path_put(path, "%s", writer->path) != 0)
        return;
    while ((slash = strrchr(path, '/')) != NULL && slash > path) {
        *slash = '\0';
        (void)!ttf_io_sync_parent(writer->io, path);
    }
}
