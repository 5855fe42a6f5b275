/* SPDX-License-Identifier: Apache-2.0 */
#include "walk.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "io_path.h"
#include "manifest_rules.h"
#include "sums.h"

#define DEPTH_MAX 16

int ttf_paths_add(struct ttf_paths *paths, const char *path)
{
    char **grown;
    size_t room;

    if (paths->n == paths->room) {
        room = paths->room ? paths->room * 2 : 64;
        grown = reallocarray(paths->items, room, sizeof(*grown));
        if (!grown)
            return -ENOMEM;
        paths->items = grown;
        paths->room = room;
    }
    paths->items[paths->n] = strdup(path);
    if (!paths->items[paths->n])
        return -ENOMEM;
    paths->n++;
    return 0;
}

static int by_bytes(const void *a, const void *b)
{
    return strcmp(*(char *const *)a, *(char *const *)b);
}

void ttf_paths_sort(struct ttf_paths *paths)
{
    if (paths->n > 1)
        qsort(paths->items, paths->n, sizeof(*paths->items), by_bytes);
}

void ttf_paths_free(struct ttf_paths *paths)
{
    size_t i;

    for (i = 0; i < paths->n; i++)
        free(paths->items[i]);
    free(paths->items);
    *paths = (struct ttf_paths){0};
}

struct folder {
    const char *at; /* relative, "" at the top */
    struct ttf_paths *files, folders;
};

static int one_entry(void *ctx, const char *name, bool is_dir)
{
    struct folder *folder = ctx;
    char *path;
    int r;

    if (name[0] == '.' || (is_dir && folder->at[0] == '\0' && strcmp(name, "preview") == 0))
        return 0;
    path = folder->at[0] ? ttf_path_format("%s/%s", folder->at, name) : strdup(name);
    if (!path)
        return -ENOMEM;
    r = ttf_paths_add(is_dir ? &folder->folders : folder->files, path);
    free(path);
    return r;
}

static int walk_folder(struct ttf_io *io, const char *dataset, const char *at, int depth,
                       struct ttf_paths *files)
{
    struct folder folder = {.at = at, .files = files};
    char *full = ttf_path_format("%s/%s", dataset, at);
    size_t i;
    int r;

    if (!full)
        return -ENOMEM;
    r = depth > DEPTH_MAX ? -ELOOP : io->ops->list(io, full, one_entry, &folder);
    for (i = 0; r == 0 && i < folder.folders.n; i++)
        r = walk_folder(io, dataset, folder.folders.items[i], depth + 1, files);
    ttf_paths_free(&folder.folders);
    free(full);
    return r;
}

int ttf_walk(struct ttf_io *io, const char *dataset, struct ttf_paths *ret, struct ttf_err *err)
{
    struct ttf_paths files = {0};
    int r;

    r = walk_folder(io, dataset, "", 0, &files);
    if (r) {
        ttf_paths_free(&files);
        return ttf_err_set(err, r, dataset, "its files cannot be listed: %s", strerrordesc_np(-r));
    }
    ttf_paths_sort(&files);
    *ret = files;
    return 0;
}

bool ttf_is_temporary(const char *path)
{
    size_t n = strlen(path);

    return n > 4 && strcmp(path + n - 4, ".tmp") == 0;
}

bool ttf_is_sealed_file(const char *path)
{
    return strcmp(path, "notes.jsonl") != 0 && strcmp(path, "samples.json") != 0 &&
           strcmp(path, "report.json") != 0 && strcmp(path, TTF_SUMS_NAME) != 0 &&
           !ttf_is_temporary(path) && ttf_path_ok(path);
}

int64_t ttf_path_index(const char *path)
{
    const char *name = strrchr(path, '/');
    int64_t index = 0;
    size_t digits;

    if (!name || (strncmp(path, "frames/", 7) != 0 && strncmp(path, "raw/", 4) != 0))
        return -1;
    name++;
    digits = strspn(name, "0123456789");
    if (digits < 6 || digits > 18 || name[digits] != '.')
        return -1;
    while (*name != '.')
        index = index * 10 + (*name++ - '0');
    return index;
}
