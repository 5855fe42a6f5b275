/* SPDX-License-Identifier: Apache-2.0 */
#include "thumbs.h"

#include <errno.h>
#include <inttypes.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "history.h"
#include "ttf/dataset/thumbnail.h"

#define SIDE 256

/* Remembered at most; the ones that were not asked for longest go. */
#define KEPT       1024
#define KEPT_BYTES ((size_t)8 << 20)

/* By the hash of the file that it was made from: it stays right whatever becomes of the dataset. */
struct thumb {
    char sha256[65];
    uint64_t used; /* larger is later */
    void *jpeg;    /* NULL: free */
    size_t bytes;
};

struct thumbs {
    pthread_mutex_t
        making; /* one at a time: an image takes memory, and the box's processors are the capture's */
    pthread_mutex_t lock; /* over all below */
    struct thumb kept[KEPT];
    size_t bytes;
    uint64_t uses;
};

struct thumbs *thumbs_create(void)
{
    struct thumbs *thumbs = calloc(1, sizeof *thumbs);

    if (!thumbs)
        return NULL;
    (void)pthread_mutex_init(&thumbs->making, NULL);
    (void)pthread_mutex_init(&thumbs->lock, NULL);
    return thumbs;
}

void thumbs_destroy(struct thumbs *thumbs)
{
    if (!thumbs)
        return;
    for (unsigned i = 0; i < KEPT; i++)
        free(thumbs->kept[i].jpeg);
    (void)pthread_mutex_destroy(&thumbs->lock);
    (void)pthread_mutex_destroy(&thumbs->making);
    free(thumbs);
}

/* ---- what is remembered ---- */

static void *copy(const void *bytes, size_t n)
{
    void *copied = malloc(n + 1);

    if (copied)
        memcpy(copied, bytes, n);
    return copied;
}

static void *recall(struct thumbs *thumbs, const char *sha256, size_t *ret_bytes)
{
    void *jpeg = NULL;

    (void)pthread_mutex_lock(&thumbs->lock);
    for (unsigned i = 0; i < KEPT && !jpeg; i++) {
        struct thumb *t = &thumbs->kept[i];

        if (!t->jpeg || strcmp(t->sha256, sha256) != 0)
            continue;
        t->used = ++thumbs->uses;
        jpeg = copy(t->jpeg, t->bytes);
        *ret_bytes = t->bytes;
    }
    (void)pthread_mutex_unlock(&thumbs->lock);
    return jpeg;
}

/* A free place, or that of the one not asked for longest. */
static struct thumb *place(struct thumbs *thumbs)
{
    struct thumb *best = &thumbs->kept[0];

    for (unsigned i = 0; i < KEPT; i++) {
        struct thumb *t = &thumbs->kept[i];

        if (!t->jpeg)
            return t;
        if (t->used < best->used)
            best = t;
    }
    return best;
}

static void drop(struct thumbs *thumbs, struct thumb *t)
{
    thumbs->bytes -= t->bytes;
    free(t->jpeg);
    *t = (struct thumb){0};
}

static void remember(struct thumbs *thumbs, const char *sha256, const void *jpeg, size_t n)
{
    struct thumb *t;
    void *copied = n <= KEPT_BYTES / 8 ? copy(jpeg, n) : NULL;

    if (!copied)
        return; /* it is made anew next time */
    (void)pthread_mutex_lock(&thumbs->lock);
    t = place(thumbs);
    drop(thumbs, t);
    *t = (struct thumb){.used = ++thumbs->uses, .jpeg = copied, .bytes = n};
    (void)snprintf(t->sha256, sizeof t->sha256, "%s", sha256);
    thumbs->bytes += n;
    while (thumbs->bytes > KEPT_BYTES) {
        struct thumb *oldest = NULL;

        for (unsigned i = 0; i < KEPT; i++)
            if (thumbs->kept[i].jpeg && (!oldest || thumbs->kept[i].used < oldest->used))
                oldest = &thumbs->kept[i];
        if (!oldest)
            break;
        drop(thumbs, oldest);
    }
    (void)pthread_mutex_unlock(&thumbs->lock);
}

/* ---- which file ---- */

struct wanted {
    const char *stream; /* the primary one */
    struct ttf_file_ref file;
    char of[32]; /* the stream whose image it is; empty: there is none */
};

/* The developed file rather than the raw one. */
static bool take_file(const struct ttf_image *image, struct wanted *wanted)
{
    const struct ttf_file_ref *best = NULL;

    for (unsigned i = 0; i < image->n_files; i++) {
        const struct ttf_file_ref *file = &image->files[i];

        if (strcmp(file->role, "developed") == 0 || (strcmp(file->role, "raw") == 0 && !best))
            best = file;
    }
    if (!best)
        return false;
    wanted->file = *best;
    (void)snprintf(wanted->of, sizeof wanted->of, "%s", image->stream);
    return true;
}

/* The primary stream's image, of a bracket the reference one; else any. */
static int take_slot(void *ctx, const struct ttf_growth_line *line, struct ttf_err *err)
{
    struct wanted *wanted = ctx;
    struct ttf_slot_record record;
    bool best = false;
    int r = ttf_growth_slot(line, &record, err);

    if (r < 0)
        return r;
    for (unsigned i = 0; i < record.n_images && !best; i++) {
        const struct ttf_image *image = &record.images[i];
        bool primary = strcmp(image->stream, wanted->stream) == 0;

        if ((!*wanted->of || primary) && take_file(image, wanted))
            best = primary && (image->bracket < 0 || image->relative_exposure == 1);
    }
    ttf_slot_record_free(&record);
    return 0;
}

static bool read_index(const char *text, int64_t *ret)
{
    int64_t index = 0;

    if (!*text || strlen(text) > 15)
        return false;
    for (; *text; text++) {
        if (*text < '0' || *text > '9')
            return false;
        index = index * 10 + (*text - '0');
    }
    *ret = index;
    return true;
}

/* wanted->of stays empty: the slot has no image. -ENOENT: there is no such slot; -EAGAIN: that is not known yet. */
static int find_file(struct ttf_http_request *request, const char *folder, int64_t index,
                     struct wanted *wanted)
{
    const struct history_of *of = NULL;
    struct ttf_growth at = {0};
    char path[4096 + 96];
    int r = history_hold(request, HISTORY_AT_ONCE, &of);
    bool more = r > 0;

    if (r < 0)
        return r;
    at.inode = of->growth.inode;
    at.bytes = history_find(of, index);
    history_release(request);
    if (at.bytes < 0 && more) {
        r = ttf_err_set(&request->err, -EAGAIN, request->match->path,
                        "the records have not been read up to there yet");
        ttf_err_hint(&request->err, "ask again");
        return r;
    }
    if (at.bytes < 0)
        return ttf_err_set(&request->err, -ENOENT, request->match->path, "there is no such slot");
    (void)snprintf(path, sizeof path, "%s/records.jsonl", folder);
    r = ttf_growth_read(request->io, path, &at, 1, take_slot, wanted, &request->err);
    return r < 0 ? r : 0;
}

/* ---- answers ---- */

/* A picture that lies in the dataset's preview/. */
static bool give_preview(struct ttf_http_request *request, int64_t index, const char *stream,
                         struct ttf_http_answer *ret)
{
    const char *name = request->match->name;
    char path[160];
    struct stat st;
    int fd;

    (void)snprintf(path, sizeof path, "preview/%s/%06" PRId64 ".jpg", stream, index);
    fd = folder_file(request->folder, name, path, &st);
    if (fd < 0) {
        (void)snprintf(path, sizeof path, "preview/%06" PRId64 ".jpg", index);
        fd = folder_file(request->folder, name, path, &st);
    }
    if (fd < 0)
        return false;
    answer_file(ret, fd, st.st_size, &st);
    return true;
}

static int make(struct ttf_http_request *request, const char *folder,
                const struct ttf_manifest *manifest, const struct wanted *wanted,
                struct ttf_http_answer *ret)
{
    static const struct ttf_thumbnail_size size = {.side = SIDE};
    struct thumbs *thumbs = request->derived->thumbs;
    const struct ttf_stream *stream = ttf_manifest_stream(manifest, wanted->of);
    char path[4096 + 320];
    void *jpeg = NULL;
    size_t n = 0;
    int r = folder_file(request->folder, request->match->name, wanted->file.path, NULL);

    if (r < 0 || !stream)
        return ttf_err_set(&request->err, -ENOENT, wanted->file.path, "this file is missing");
    (void)close(r);
    (void)snprintf(path, sizeof path, "%s/%s", folder, wanted->file.path);
    r = 0;
    (void)pthread_mutex_lock(&thumbs->making);
    jpeg = recall(thumbs, wanted->file.sha256, &n); /* perhaps somebody else's, by now */
    if (!jpeg) {
        r = ttf_thumbnail_of_file(request->io, path, stream, &size, &jpeg, &n, &request->err);
        if (r == 0)
            remember(thumbs, wanted->file.sha256, jpeg, n);
    }
    (void)pthread_mutex_unlock(&thumbs->making);
    if (r < 0)
        return r;
    answer_json(ret, jpeg, n);
    return 0;
}

int thumbs_answer(struct ttf_http_request *request, struct ttf_http_answer *ret)
{
    const char *name = request->match->name;
    struct ttf_manifest *manifest = malloc(sizeof *manifest);
    struct wanted wanted = {0};
    char folder[4096 + 80];
    int64_t index = 0;
    int r = folder_dataset(request->folder, name, folder, sizeof folder);

    if (!manifest)
        r = ttf_err_set(&request->err, -ENOMEM, NULL, "no memory");
    else if (r < 0)
        ttf_err_set(&request->err, r, name, "there is no dataset of this name");
    else if (!read_index(request->match->path, &index))
        r = ttf_err_set(&request->err, -ENOENT, request->match->path, "this is no slot's index");
    else
        r = ttf_manifest_load(request->io, folder, manifest, &request->err);
    if (r == 0) {
        const struct ttf_stream *primary = ttf_manifest_primary(manifest);

        wanted.stream = primary ? primary->id : "";
        r = find_file(request, folder, index, &wanted);
    }
    if (r == 0 && !*wanted.of) { /* nothing is wrong: it was missed */
        ret->fixed = "";
        ret->bytes = 0;
        ret->none = true;
    } else if (r == 0 && !give_preview(request, index, wanted.of, ret)) {
        r = make(request, folder, manifest, &wanted, ret);
        (void)snprintf(ret->etag, sizeof ret->etag, "%.60s-t%d", wanted.file.sha256, SIDE);
    }
    free(manifest);
    return r;
}
