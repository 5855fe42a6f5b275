/* SPDX-License-Identifier: Apache-2.0 */
#include "datasets.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "listed.h"
#include "tar_read.h"
#include "ttf/dataset/json_writer.h"

static int no_dataset(struct ttf_http_request *request)
{
    return ttf_err_set(&request->err, -ENOENT, request->match->name,
                       "there is no dataset of this name");
}

/* A JSON writer's text as an answer. */
static int give(struct ttf_json *json, struct ttf_http_answer *ret)
{
    char *text;
    size_t bytes;
    int r = ttf_json_take(json, &text, &bytes);

    if (r == 0)
        answer_json(ret, text, bytes);
    return r;
}

static void put_one(struct ttf_http_request *request, struct ttf_json *json, const char *name)
{
    char *text = NULL, why[700];
    struct ttf_err err = {0};

    if (summaries_get(request->summaries, request->folder, request->io, name, &text, &err) == 0) {
        ttf_json_raw(json, text);
        free(text);
        return;
    }
    /* One that cannot be read is in the list all the same, with the reason. */
    ttf_json_object(json);
    ttf_json_kstring(json, "name", name);
    ttf_json_kstring(json, "error", ttf_err_text(&err, why, sizeof why));
    ttf_json_object_end(json);
}

int datasets_list(struct ttf_http_request *request, struct ttf_http_answer *ret)
{
    char(*names)[65] = NULL;
    int64_t n = folder_list(request->folder, &names);
    struct ttf_json json;

    if (n < 0)
        return ttf_err_set(&request->err, (int)n, NULL, "the data folder cannot be listed");
    ttf_json_init(&json, false);
    ttf_json_object(&json);
    ttf_json_key(&json, "datasets");
    ttf_json_array(&json);
    for (int64_t i = 0; i < n; i++)
        put_one(request, &json, names[i]);
    ttf_json_array_end(&json);
    ttf_json_object_end(&json);
    free(names);
    return give(&json, ret);
}

int datasets_one(struct ttf_http_request *request, struct ttf_http_answer *ret)
{
    char *text = NULL;
    int r = summaries_get(request->summaries, request->folder, request->io, request->match->name,
                          &text, &request->err);

    if (r == 0)
        answer_json(ret, text, strlen(text));
    return r;
}

/* ---- files ---- */

/*
 * A file that grows may lose its end as well (what a power cut left half is cut off at the next start), also while it is sent.
 * The kernel sends nothing then, for ever, and a client waits in vain; read here, its end is an error that cuts the connection.
 */
static ssize_t growing_read(void *ctx, int64_t offset, void *buf, size_t n)
{
    ssize_t got = pread(*(int *)ctx, buf, n, offset);

    return got < 0 ? -errno : got;
}

static void growing_done(void *ctx)
{
    (void)close(*(int *)ctx);
    free(ctx);
}

static int send_growing(struct ttf_http_request *request, const char *path,
                        struct ttf_http_answer *ret)
{
    int *file = malloc(sizeof *file);

    if (!file)
        return ttf_err_set(&request->err, -ENOMEM, path, "no memory");
    *file = ret->fd;
    ret->fd = -1;
    ret->source = (struct answer_source){growing_read, growing_done, file};
    return 0;
}

static int open_file(struct ttf_http_request *request, const char *path,
                     struct ttf_http_answer *ret)
{
    const char *name = request->match->name;
    char where[4096 + 80];
    struct stat st;
    int fd = folder_file(request->folder, name, path, &st);
    bool grows;

    if (fd == -ENOENT && folder_dataset(request->folder, name, where, sizeof where) == -ENOENT)
        return no_dataset(request);
    if (fd == -ENOENT)
        return ttf_err_set(&request->err, fd, path, "there is no such file in the dataset");
    if (fd < 0) /* whatever the disk has against it, it is nothing that a token mends */
        return ttf_err_set(&request->err, -EIO, path, "cannot be read: %s", strerrordesc_np(-fd));
    grows = folder_grows(path, listed_sealed(request->derived->listed, request->folder, name));
    answer_file(ret, fd, grows ? folder_whole_lines(fd, st.st_size) : st.st_size, &st);
    ret->ranges = true;
    if (ret->bytes < 0)
        return ttf_err_set(&request->err, (int)ret->bytes, path, "cannot be read");
    if (!grows &&
        listed_sha256(request->derived->listed, request->folder, name, path, ret->sha256) == 0)
        (void)snprintf(ret->etag, sizeof ret->etag, "%s", ret->sha256);
    return grows && ret->bytes > 0 ? send_growing(request, path, ret) : 0;
}

int datasets_records(struct ttf_http_request *request, struct ttf_http_answer *ret)
{
    return open_file(request, "records.jsonl", ret);
}

int datasets_file(struct ttf_http_request *request, struct ttf_http_answer *ret)
{
    return open_file(request, request->match->path, ret);
}

/* One that need not be there: nobody has said anything yet. */
static int open_log(struct ttf_http_request *request, const char *path, struct ttf_http_answer *ret)
{
    char where[4096 + 80];
    int r;

    if (folder_dataset(request->folder, request->match->name, where, sizeof where) == -ENOENT)
        return no_dataset(request);
    r = open_file(request, path, ret);
    if (r != -ENOENT)
        return r;
    request->err = (struct ttf_err){0};
    ret->fixed = "";
    ret->bytes = 0;
    return 0;
}

int datasets_notes(struct ttf_http_request *request, struct ttf_http_answer *ret)
{
    return open_log(request, "notes.jsonl", ret);
}

int datasets_events(struct ttf_http_request *request, struct ttf_http_answer *ret)
{
    return open_log(request, "events.jsonl", ret);
}

/* ---- archives ---- */

/* Under way at once: each holds a list of all its files, and keeps a disk busy. */
#define ARCHIVES_MAX 8

struct archive {
    struct tar_reader *reader;
    int *under_way; /* of all */
};

static ssize_t archive_read(void *ctx, int64_t offset, void *buf, size_t n)
{
    const struct archive *archive = ctx;

    return tar_read(archive->reader, offset, buf, n);
}

static void archive_done(void *ctx)
{
    struct archive *archive = ctx;

    tar_reader_destroy(archive->reader);
    (void)__atomic_sub_fetch(archive->under_way, 1, __ATOMIC_RELAXED);
    free(archive);
}

/* The layout is taken over, also on failure. */
static int send_archive(struct ttf_http_request *request, struct tar_layout *layout,
                        struct ttf_http_answer *ret)
{
    int *under_way = &request->derived->archives;
    struct archive *archive = malloc(sizeof *archive);
    struct tar_reader *reader = tar_reader_create(request->folder, layout);
    int r = archive && reader ? 0 : -ENOMEM;

    if (r == 0 && __atomic_add_fetch(under_way, 1, __ATOMIC_RELAXED) > ARCHIVES_MAX) {
        (void)__atomic_sub_fetch(under_way, 1, __ATOMIC_RELAXED);
        r = ttf_err_set(&request->err, -EAGAIN, request->match->name,
                        "%d archives are being sent already", ARCHIVES_MAX);
        ttf_err_hint(&request->err, "ask again when one of them has come");
    }
    if (r < 0) {
        tar_reader_destroy(reader);
        free(archive);
        return r;
    }
    *archive = (struct archive){reader, under_way};
    ret->source = (struct answer_source){archive_read, archive_done, archive};
    return 0;
}

int datasets_tar(struct ttf_http_request *request, struct ttf_http_answer *ret)
{
    struct tar_layout layout;
    int r = tar_layout_make(request->folder, request->match->name, &layout);

    if (r == -ENOENT)
        return no_dataset(request);
    if (r == -ENAMETOOLONG)
        return ttf_err_set(&request->err, r, request->match->name,
                           "has paths that are too long for an archive: pull it file by file");
    if (r < 0)
        return ttf_err_set(&request->err, r, request->match->name, "cannot be listed");
    ret->bytes = layout.bytes;
    ret->ranges = layout.sealed; /* one that grows would be another the next time */
    if (layout.sealed)
        (void)snprintf(ret->etag, sizeof ret->etag, "%s", layout.etag);
    r = send_archive(request, &layout, ret);
    if (r < 0)
        return r;
    (void)snprintf(ret->file_name, sizeof ret->file_name, "%s.tar", request->match->name);
    return 0;
}
