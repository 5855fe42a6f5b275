/* SPDX-License-Identifier: Apache-2.0 */
#include "named_files.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "record_line.h"

int ttf_named_files_add(struct ttf_named_files *files, const char *path, const char *sha256)
{
    struct ttf_named *grown, *item;
    size_t room;

    if (files->n == files->room) {
        room = files->room ? files->room * 2 : 64;
        grown = reallocarray(files->items, room, sizeof(*grown));
        if (!grown)
            return -ENOMEM;
        files->items = grown;
        files->room = room;
    }
    item = &files->items[files->n];
    item->path = strdup(path);
    if (!item->path)
        return -ENOMEM;
    memcpy(item->sha256, sha256, 64);
    item->sha256[64] = '\0';
    files->n++;
    return 0;
}

static int by_path(const void *a, const void *b)
{
    return strcmp(((const struct ttf_named *)a)->path, ((const struct ttf_named *)b)->path);
}

void ttf_named_files_sort(struct ttf_named_files *files)
{
    size_t i, kept = 0;

    if (files->n < 2)
        return;
    qsort(files->items, files->n, sizeof(*files->items), by_path);
    for (i = 0; i < files->n; i++) {
        if (kept > 0 && strcmp(files->items[kept - 1].path, files->items[i].path) == 0)
            free(files->items[i].path); /* one file in two records */
        else
            files->items[kept++] = files->items[i];
    }
    files->n = kept;
}

static int add_file(void *ctx, const struct ttf_named_file *file, struct ttf_err *err)
{
    int r = ttf_named_files_add(ctx, file->path, file->sha256);

    return r ? ttf_err_set(err, r, file->path, "no memory") : 0;
}

static int add_line(void *ctx, const struct ttf_line *line, struct ttf_err *err)
{
    return ttf_line_files(line, add_file, ctx, err);
}

int ttf_named_files_load(struct ttf_io *io, const char *records, struct ttf_named_files *ret,
                         struct ttf_err *err)
{
    struct ttf_named_files files = {0};
    int r;

    r = ttf_lines_scan(io, records, add_line, NULL, &files, NULL, err);
    if (r) {
        ttf_named_files_free(&files);
        return r;
    }
    ttf_named_files_sort(&files);
    *ret = files;
    return 0;
}

const struct ttf_named *ttf_named_files_find(const struct ttf_named_files *files, const char *path)
{
    struct ttf_named key = {.path = (char *)path};

    if (files->n == 0)
        return NULL;
    return bsearch(&key, files->items, files->n, sizeof(*files->items), by_path);
}

void ttf_named_files_free(struct ttf_named_files *files)
{
    size_t i;

    for (i = 0; i < files->n; i++)
        free(files->items[i].path);
    free(files->items);
    *files = (struct ttf_named_files){0};
}
