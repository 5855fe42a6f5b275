/* SPDX-License-Identifier: Apache-2.0 */
#include "pictures.h"

#include <errno.h>
#include <inttypes.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "derived.h"
#include "newest.h"
#include "ttf/dataset/thumbnail.h"

#define SIDE 1600

struct pictures {
    pthread_mutex_t lock; /* over all below, and one picture is made at a time */
    char etag[80];
    void *jpeg;
    size_t bytes;
};

struct pictures *pictures_create(void)
{
    struct pictures *pictures = calloc(1, sizeof *pictures);

    if (pictures && pthread_mutex_init(&pictures->lock, NULL) != 0) {
        free(pictures);
        return NULL;
    }
    return pictures;
}

void pictures_destroy(struct pictures *pictures)
{
    if (!pictures)
        return;
    (void)pthread_mutex_destroy(&pictures->lock);
    free(pictures->jpeg);
    free(pictures);
}

static int make(struct ttf_http_request *request, const char *dataset, const struct newest *newest,
                void **ret, size_t *ret_bytes)
{
    static const struct ttf_thumbnail_size SIZE = {.side = SIDE, .quality = 85};
    struct ttf_manifest *manifest = malloc(sizeof *manifest);
    char folder[4096], path[4096 + 256];
    const struct ttf_stream *stream;
    int r = manifest ? folder_dataset(request->folder, dataset, folder, sizeof folder) : -ENOMEM;

    if (r < 0)
        ttf_err_set(&request->err, r, dataset, "cannot be read");
    if (r == 0)
        r = ttf_manifest_load(request->io, folder, manifest, &request->err);
    if (r == 0) {
        stream = ttf_manifest_stream(manifest, newest->stream);
        (void)snprintf(path, sizeof path, "%s/%s", folder, newest->path);
        r = stream ? ttf_thumbnail_of_file(request->io, path, stream, &SIZE, ret, ret_bytes,
                                           &request->err)
                   : ttf_err_set(&request->err, -TTF_EDAMAGED, dataset,
                                 "does not list the stream %s", newest->stream);
    }
    free(manifest);
    return r;
}

/* ---- the answer ---- */

/* A copy of what is remembered under this tag, made now if it is another. */
static int give(struct ttf_http_request *request, const char *dataset, const struct newest *newest,
                struct ttf_http_answer *ret)
{
    struct pictures *pictures = request->derived->pictures;
    char *copy;
    int r = 0;

    if (strcmp(pictures->etag, ret->etag) != 0) {
        void *jpeg = NULL;
        size_t bytes = 0;

        r = make(request, dataset, newest, &jpeg, &bytes);
        if (r < 0)
            return r;
        free(pictures->jpeg);
        pictures->jpeg = jpeg;
        pictures->bytes = bytes;
        memcpy(pictures->etag, ret->etag, sizeof pictures->etag);
    }
    copy = malloc(pictures->bytes + 1);
    if (!copy)
        return ttf_err_set(&request->err, -ENOMEM, NULL, "no memory");
    if (pictures->jpeg)
        memcpy(copy, pictures->jpeg, pictures->bytes);
    answer_json(ret, copy, pictures->bytes);
    return 0;
}

int pictures_newest(struct ttf_http_request *request, const char *dataset,
                    struct ttf_http_answer *ret)
{
    struct newest newest;
    int r = newest_find(request->folder, dataset, &newest, &request->err);

    if (r < 0)
        return r;
    (void)snprintf(ret->etag, sizeof ret->etag, "%.64s-view", newest.sha256);
    answer_header(ret, "X-Ttfbox-Dataset", "%s", dataset);
    answer_header(ret, "X-Ttfbox-Index", "%" PRId64, newest.index);
    (void)pthread_mutex_lock(&request->derived->pictures->lock);
    r = give(request, dataset, &newest, ret);
    (void)pthread_mutex_unlock(&request->derived->pictures->lock);
    return r;
}
