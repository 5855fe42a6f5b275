/* SPDX-License-Identifier: Apache-2.0 */
#include "charts.h"

#include <errno.h>
#include <inttypes.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "chart_points.h"
#include "chart_text.h"
#include "ttf/dataset/growth.h"

#define KEPT 4 /* datasets; some 100 kB to 2 MB each */

/* Read at most at one request, some tenths of a second on a small board: who asks again gets more. */
#define BYTES_AT_ONCE ((int64_t)4 << 20)

struct remembered {
    char dataset[65]; /* empty: free */
    uint64_t used;    /* larger is later */
    uint64_t begun;   /* counts how often it was begun anew: of another file, another tag */
    struct ttf_growth growth;
    struct chart_points points;
    struct chart_segments segments;
};

struct charts {
    pthread_mutex_t lock; /* over all below */
    struct remembered kept[KEPT];
    uint64_t uses;
};

struct charts *charts_create(void)
{
    struct charts *charts = calloc(1, sizeof *charts);

    if (charts && pthread_mutex_init(&charts->lock, NULL) != 0) {
        free(charts);
        return NULL;
    }
    return charts;
}

static void forget(struct remembered *r)
{
    chart_points_free(&r->points);
    chart_segments_free(&r->segments);
    memset(&r->growth, 0, sizeof r->growth);
    r->begun++;
}

void charts_destroy(struct charts *charts)
{
    if (!charts)
        return;
    for (unsigned i = 0; i < KEPT; i++)
        forget(&charts->kept[i]);
    (void)pthread_mutex_destroy(&charts->lock);
    free(charts);
}

static struct remembered *recall(struct charts *charts, const char *dataset)
{
    struct remembered *oldest = &charts->kept[0];

    for (unsigned i = 0; i < KEPT; i++) {
        struct remembered *r = &charts->kept[i];

        if (strcmp(r->dataset, dataset) == 0) {
            r->used = ++charts->uses;
            return r;
        }
        if (r->used < oldest->used)
            oldest = r;
    }
    forget(oldest);
    (void)snprintf(oldest->dataset, sizeof oldest->dataset, "%s", dataset);
    oldest->used = ++charts->uses;
    return oldest;
}

static int take_line(void *ctx, const struct ttf_growth_line *line, struct ttf_err *err)
{
    struct remembered *r = ctx;
    struct ttf_slot_record record;
    struct ttf_segment segment;
    int code;

    if (strcmp(line->type, "segment") == 0) {
        code = ttf_growth_segment(line, &segment, err);
        return code == 0 ? chart_segments_put(&r->segments, &segment) : code;
    }
    if (strcmp(line->type, "slot") != 0)
        return 0;
    code = ttf_growth_slot(line, &record, err);
    if (code < 0)
        return code == -ENOMEM ? code : 0; /* one that contradicts the format: verify says so */
    code = chart_points_add(&r->points, &record);
    ttf_slot_record_free(&record);
    return code;
}

/* 1: there is more to read. */
static int read_on(struct ttf_http_request *request, const char *path, struct remembered *r)
{
    int code =
        ttf_growth_read(request->io, path, &r->growth, BYTES_AT_ONCE, take_line, r, &request->err);

    if (code != -ESTALE)
        return code;
    forget(r);
    memset(&request->err, 0, sizeof request->err);
    return ttf_growth_read(request->io, path, &r->growth, BYTES_AT_ONCE, take_line, r,
                           &request->err);
}

static int answer(struct ttf_http_request *request, const char *path, struct ttf_http_answer *ret)
{
    struct remembered *r = recall(request->derived->charts, request->match->name);
    int code = read_on(request, path, r);
    char *text = NULL;
    size_t bytes = 0;
    bool complete = code == 0;

    if (code >= 0)
        code = chart_text(request->match->name, &r->points, &r->segments, complete, &text, &bytes);
    if (code < 0)
        return code;
    answer_json(ret, text, bytes);
    (void)snprintf(ret->etag, sizeof ret->etag, "%" PRIx64 "-%" PRIx64 "-%" PRIx64, r->growth.inode,
                   (uint64_t)r->growth.bytes, r->begun);
    return 0;
}

int charts_answer(struct ttf_http_request *request, struct ttf_http_answer *ret)
{
    const char *name = request->match->name;
    char path[4096 + 96];
    int r = folder_dataset(request->folder, name, path, sizeof path - 16);
    int fd = r < 0 ? r : folder_file(request->folder, name, "records.jsonl", NULL);

    if (fd < 0)
        return ttf_err_set(&request->err, fd, name, "there is no dataset of this name");
    (void)close(fd);
    (void)strncat(path, "/records.jsonl", 16);
    (void)pthread_mutex_lock(&request->derived->charts->lock);
    r = answer(request, path, ret);
    (void)pthread_mutex_unlock(&request->derived->charts->lock);
    return r;
}
