/* SPDX-License-Identifier: Apache-2.0 */
#include "listing.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "parts.h"

#define TEXT_MAX ((size_t)256 * 1024)

static int by_name(const void *a, const void *b)
{
    return strcmp(a, b);
}

static bool is_name(const char *name)
{
    return *name != '.' && *name &&
           strspn(name, "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789._-") ==
               strlen(name);
}

static int take(void *ctx, const char *name, bool is_dir)
{
    struct listing *names = ctx;
    size_t n = strlen(name), end = sizeof LISTING_SUFFIX - 1;
    char text[65];

    if (is_dir != names->folders || names->n == names->max)
        return 0;
    if (!names->folders) {
        if (n <= end || strcmp(name + n - end, LISTING_SUFFIX) != 0)
            return 0;
        n -= end;
    }
    if (n >= sizeof text)
        return 0;
    memcpy(text, name, n);
    text[n] = '\0';
    if (is_name(text))
        memcpy(names->name[names->n++], text, sizeof text);
    return 0;
}

int listing_read(struct ttf_io *io, const char *folder, unsigned max, bool folders,
                 struct listing *ret)
{
    int r;

    *ret = (struct listing){.name = calloc(max, sizeof *ret->name), .max = max, .folders = folders};
    if (!ret->name)
        return -ENOMEM;
    r = io->ops->list(io, folder, take, ret);
    if (r == -ENOENT)
        r = 0;
    qsort(ret->name, ret->n, sizeof *ret->name, by_name);
    return r;
}

int listing_give(struct ttf_json *json, int r, char **ret, struct ttf_err *err)
{
    if (r == 0)
        return daemon_give(json, ret, err);
    ttf_json_free(json);
    return ttf_err_set(err, r, NULL, "%s", strerrordesc_np(-r));
}

int listing_text(struct ttf_io *io, const char *path, const char *what, char **ret,
                 struct ttf_err *err)
{
    size_t bytes;
    int r = ttf_io_slurp(io, path, TEXT_MAX, ret, &bytes, err);

    if (r == -ENOENT)
        return ttf_err_set(err, r, NULL, "there is no %s of this name", what);
    /* It is not what was asked that is too large: -EFBIG is a request's. */
    return r == -EFBIG ? ttf_err_set(err, -EIO, path, "is longer than a %s may be", what) : r;
}

int listing_remove(struct ttf_io *io, const char *folder, const char *path, const char *what,
                   struct ttf_err *err)
{
    int r = io->ops->unlink(io, path);

    if (r == -ENOENT)
        return ttf_err_set(err, r, NULL, "there is no %s of this name", what);
    if (r == 0)
        r = io->ops->sync_dir(io, folder);
    return r < 0 ? ttf_err_set(err, r, NULL, "%s", strerrordesc_np(-r)) : 0;
}
