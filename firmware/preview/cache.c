/* SPDX-License-Identifier: Apache-2.0 */
#include <errno.h>
#include <fcntl.h>
#include <ftw.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <unistd.h>

#include "preview.h"
#include "ttf/dataset/json_parse.h"
#include "ttf/dataset/json_writer.h"

#define STATE_MAX ((size_t)256 * 1024)
#define COUNT_MAX \
    (1 << 30) /* of refreshes, images and tries: more is nothing that was written here */

static int drop_entry(const char *path, const struct stat *st, int kind, struct FTW *ftw)
{
    (void)st;
    (void)kind;
    (void)ftw;
    return remove(path);
}

static void drop(const char *path)
{
    /* NOLINTNEXTLINE(concurrency-mt-unsafe): one thread runs */
    (void)nftw(path, drop_entry, 8, FTW_DEPTH | FTW_PHYS);
}

int preview_cache_lock(struct ttf_io *io, const char *folder, struct ttf_err *err)
{
    char path[4200];
    int fd, r;

    (void)snprintf(path, sizeof path, "%s/.preview", folder);
    r = ttf_io_mkdirs(io, path, err);
    if (r < 0)
        return r;
    (void)snprintf(path, sizeof path, "%s/.preview/lock", folder);
    fd = open(path, O_RDWR | O_CREAT | O_CLOEXEC, 0644);
    if (fd < 0)
        return ttf_err_set(err, -errno, path, "cannot be opened");
    if (flock(fd, LOCK_EX | LOCK_NB) == 0)
        return fd;
    r = ttf_err_set(err, -EAGAIN, path, "another process makes previews of this folder");
    (void)close(fd);
    return r;
}

/* ---- what a kill left ---- */

struct leftovers {
    const char *path;
    int generation; /* what is in force, and the one before, stay */
};

static int look_at(void *ctx, const char *name, bool is_dir)
{
    const struct leftovers *l = ctx;
    char path[4300];
    char *end = NULL;
    long number = name[0] == 'g' ? strtol(name + 1, &end, 10) : 0;
    bool wanted = is_dir && end && *end == '\0' && number <= l->generation &&
                  number + 1 >= l->generation && number > 0;
    size_t n = strlen(name);
    bool ours = (!is_dir && n > 4 && strcmp(name + n - 4, ".tmp") == 0) ||
                (is_dir && (strcmp(name, "making") == 0 || (end && *end == '\0')));

    if (wanted || !ours)
        return 0;
    (void)snprintf(path, sizeof path, "%s/%s", l->path, name);
    drop(path);
    return 0;
}

static void clean(struct ttf_io *io, const struct preview_cache *cache)
{
    struct leftovers l = {cache->path, cache->generation};

    (void)io->ops->list(io, cache->path, look_at, &l);
}

/* ---- what is in force ---- */

static int count(const json_t *json, const char *key)
{
    json_int_t n = json_integer_value(json_object_get(json, key));

    return n < 0 || n > COUNT_MAX ? 0 : (int)n;
}

static void read_state(struct ttf_io *io, struct preview_cache *cache)
{
    char path[4300];
    char *text = NULL;
    size_t n = 0;
    json_t *json = NULL;

    (void)snprintf(path, sizeof path, "%s/state.json", cache->path);
    if (ttf_io_slurp(io, path, STATE_MAX, &text, &n, NULL) < 0)
        return;
    if (ttf_json_parse(text, n, &json, NULL) == 0 && json_is_object(json)) {
        const char *uuid = json_string_value(json_object_get(json, "uuid"));

        (void)snprintf(cache->uuid, sizeof cache->uuid, "%s", uuid ? uuid : "");
        cache->generation = count(json, "generation");
        cache->images = count(json, "images");
        cache->tried_images = count(json, "tried_images");
        cache->tries = count(json, "tries");
        cache->tried_utc_ns = json_integer_value(json_object_get(json, "tried_utc_ns"));
        (void)json_object_del(json, "state");
        (void)json_object_del(json, "why");
        (void)json_object_del(json, "tried_images");
        (void)json_object_del(json, "tries");
        (void)json_object_del(json, "tried_utc_ns");
        cache->kept = json_dumps(json, JSON_COMPACT);
    }
    json_decref(json);
    free(text);
}

int preview_cache_open(struct ttf_io *io, const char *folder, const struct preview_subject *subject,
                       struct preview_cache *ret, struct ttf_err *err)
{
    int r;

    *ret = (struct preview_cache){0};
    (void)snprintf(ret->path, sizeof ret->path, "%s/.preview/%s", folder, subject->name);
    r = ttf_io_mkdirs(io, ret->path, err);
    if (r < 0)
        return r;
    read_state(io, ret);
    if (*ret->uuid && strcmp(ret->uuid, subject->uuid) != 0) {
        /* Another dataset had this name. */
        drop(ret->path);
        preview_cache_close(ret);
        r = ttf_io_mkdirs(io, ret->path, err);
    }
    clean(io, ret);
    return r;
}

void preview_cache_close(struct preview_cache *cache)
{
    free(cache->kept);
    cache->kept = NULL;
    cache->generation = 0;
    cache->images = cache->tried_images = cache->tries = cache->tried_utc_ns = 0;
    cache->uuid[0] = '\0';
}

int preview_cache_begin(struct ttf_io *io, struct preview_cache *cache, struct ttf_err *err)
{
    char path[4300];

    (void)snprintf(path, sizeof path, "%s/making", cache->path);
    drop(path);
    return ttf_io_mkdirs(io, path, err);
}

static int put_state(struct ttf_io *io, const struct preview_cache *cache, const char *text,
                     size_t n, struct ttf_err *err)
{
    char path[4300];

    (void)snprintf(path, sizeof path, "%s/state.json", cache->path);
    return ttf_io_write_file(io, path, text, n, err);
}

static int write_made(struct ttf_io *io, const struct preview_cache *cache,
                      const struct preview_subject *subject, const struct preview_made *made,
                      int64_t utc_ns, struct ttf_err *err)
{
    struct ttf_json json;
    const char *text;
    char path[40];
    size_t n;
    int r;

    ttf_json_init(&json, false);
    ttf_json_object(&json);
    ttf_json_kstring(&json, "state", "ready");
    ttf_json_kstring(&json, "dataset", subject->name);
    ttf_json_kstring(&json, "uuid", subject->uuid);
    ttf_json_kint(&json, "generation", cache->generation);
    ttf_json_kint(&json, "images", subject->images);
    ttf_json_kint(&json, "tried_images", subject->images);
    ttf_json_kint(&json, "made_utc_ns", utc_ns);
    ttf_json_kint(&json, "width", made->width);
    ttf_json_kint(&json, "height", made->height);
    ttf_json_kint(&json, "shrunk_by", made->shrunk_by);
    ttf_json_kint(&json, "frame_step", made->frame_step);
    ttf_json_key(&json, "frames");
    ttf_json_array(&json);
    for (unsigned k = 0; k < made->n_frames; k++) {
        (void)snprintf(path, sizeof path, "g%d/%03u.jpg", cache->generation, k);
        ttf_json_object(&json);
        ttf_json_kstring(&json, "path", path);
        ttf_json_kint(&json, "slot", made->slot[k]);
        ttf_json_object_end(&json);
    }
    ttf_json_array_end(&json);
    ttf_json_object_end(&json);
    r = ttf_json_finish(&json, &text, &n);
    if (r == 0)
        r = put_state(io, cache, text, n, err);
    ttf_json_free(&json);
    return r;
}

int preview_cache_commit(struct ttf_io *io, struct preview_cache *cache,
                         const struct preview_subject *subject, const struct preview_made *made,
                         int64_t utc_ns, struct ttf_err *err)
{
    char from[4300], to[4300];
    int r;

    cache->generation++;
    (void)snprintf(from, sizeof from, "%s/making", cache->path);
    (void)snprintf(to, sizeof to, "%s/g%d", cache->path, cache->generation);
    drop(to); /* of a try that came no further */
    r = io->ops->sync_dir(io, from);
    if (r == 0)
        r = io->ops->rename(io, from, to);
    if (r == 0)
        r = io->ops->sync_dir(io, cache->path);
    if (r < 0)
        return ttf_err_set(err, r, to, "cannot be put in place");
    r = write_made(io, cache, subject, made, utc_ns, err);
    if (r == 0) {
        cache->images = cache->tried_images = subject->images;
        clean(io, cache);
    }
    return r;
}

int preview_cache_fail(struct ttf_io *io, struct preview_cache *cache,
                       const struct preview_subject *subject, const char *why, int64_t utc_ns,
                       struct ttf_err *err)
{
    json_t *json = NULL;
    char path[4300];
    char *text;
    int r;

    (void)snprintf(path, sizeof path, "%s/making", cache->path);
    drop(path);
    cache->tries = cache->tried_images == subject->images ? cache->tries + 1 : 1;
    if (!cache->kept || ttf_json_parse(cache->kept, strlen(cache->kept), &json, NULL) < 0)
        json = json_object();
    (void)json_object_set_new(json, "state", json_string("failed"));
    (void)json_object_set_new(json, "why", json_string(why));
    (void)json_object_set_new(json, "dataset", json_string(subject->name));
    (void)json_object_set_new(json, "uuid", json_string(subject->uuid));
    (void)json_object_set_new(json, "tried_images", json_integer(subject->images));
    (void)json_object_set_new(json, "tries", json_integer(cache->tries));
    (void)json_object_set_new(json, "tried_utc_ns", json_integer(utc_ns));
    if (!json_object_get(json, "frames"))
        (void)json_object_set_new(json, "frames", json_array());
    text = json_dumps(json, JSON_COMPACT);
    r = text ? put_state(io, cache, text, strlen(text), err) : -ENOMEM;
    cache->tried_images = subject->images;
    free(text);
    json_decref(json);
    return r;
}

/* ---- of datasets that are gone ---- */

struct sweep {
    struct ttf_io *io;
    const char *folder;
};

static int look_for_dataset(void *ctx, const char *name, bool is_dir)
{
    const struct sweep *sweep = ctx;
    struct ttf_io_stat st;
    char path[4300];

    (void)snprintf(path, sizeof path, "%s/%s", sweep->folder, name);
    if (!is_dir || sweep->io->ops->stat(sweep->io, path, &st) != -ENOENT)
        return 0;
    (void)snprintf(path, sizeof path, "%s/.preview/%s", sweep->folder, name);
    drop(path);
    return 0;
}

void preview_cache_sweep(struct ttf_io *io, const char *folder)
{
    struct sweep sweep = {io, folder};
    char path[4200];

    (void)snprintf(path, sizeof path, "%s/.preview", folder);
    (void)io->ops->list(io, path, look_for_dataset, &sweep);
}
