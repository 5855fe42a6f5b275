/* SPDX-License-Identifier: Apache-2.0 */
#include "history.h"

#include <errno.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define KEPT      4                 /* datasets; 100 kB to 2 MB each, and 16 bytes for each slot */
#define PLAN_MAX  ((size_t)1 << 20) /* bytes of its JSON */
#define LINES_MAX ((size_t)1000000) /* of later slots it is not known where they lie */

struct remembered {
    char dataset[65]; /* empty: free */
    uint64_t used;    /* larger is later */
    struct history_of of;
};

struct history {
    pthread_mutex_t lock; /* over all below */
    struct remembered kept[KEPT];
    uint64_t uses;
};

struct history *history_create(void)
{
    struct history *history = calloc(1, sizeof *history);

    if (history && pthread_mutex_init(&history->lock, NULL) != 0) {
        free(history);
        return NULL;
    }
    return history;
}

static void forget(struct history_of *of)
{
    uint64_t begun = of->begun + 1;

    chart_points_free(&of->points);
    chart_segments_free(&of->segments);
    free(of->lines);
    *of = (struct history_of){.begun = begun};
}

void history_destroy(struct history *history)
{
    if (!history)
        return;
    for (unsigned i = 0; i < KEPT; i++)
        forget(&history->kept[i].of);
    (void)pthread_mutex_destroy(&history->lock);
    free(history);
}

static struct history_of *recall(struct history *history, const char *dataset)
{
    struct remembered *oldest = &history->kept[0];

    for (unsigned i = 0; i < KEPT; i++) {
        struct remembered *r = &history->kept[i];

        if (strcmp(r->dataset, dataset) == 0) {
            r->used = ++history->uses;
            return &r->of;
        }
        if (r->used < oldest->used)
            oldest = r;
    }
    forget(&oldest->of);
    (void)snprintf(oldest->dataset, sizeof oldest->dataset, "%s", dataset);
    oldest->used = ++history->uses;
    return &oldest->of;
}

static int add_line(struct history_of *of, int64_t index)
{
    if (of->n_lines == LINES_MAX || (of->n_lines > 0 && index <= of->lines[of->n_lines - 1].index))
        return 0;
    if (of->n_lines == of->lines_room) {
        size_t room = of->lines_room ? 2 * of->lines_room : 256;
        struct history_line *more = reallocarray(of->lines, room, sizeof *more);

        if (!more)
            return -ENOMEM;
        of->lines = more;
        of->lines_room = room;
    }
    of->lines[of->n_lines++] = (struct history_line){index, of->growth.bytes};
    return 0;
}

/* The plan of a segment, so that lamps are counted as it has them burn; what cannot be read is not known. */
static void read_plan(struct ttf_http_request *request, struct history_of *of, int plan)
{
    char path[40], *text = malloc(PLAN_MAX);
    int fd = -ENOENT;
    ssize_t n = 0;

    (void)snprintf(path, sizeof path, "plans/%d.json", plan);
    if (plan >= 0 && text)
        fd = folder_file(request->folder, request->match->name, path, NULL);
    if (fd >= 0) {
        n = pread(fd, text, PLAN_MAX, 0);
        (void)close(fd);
    }
    chart_lamps_plan(&of->lamps, text ? text : "", n > 0 ? (size_t)n : 0);
    free(text);
}

struct reading {
    struct ttf_http_request *request;
    struct history_of *of;
};

static int take_line(void *ctx, const struct ttf_growth_line *line, struct ttf_err *err)
{
    struct reading *reading = ctx;
    struct history_of *of = reading->of;
    struct ttf_slot_record record;
    struct ttf_segment segment;
    int r;

    if (strcmp(line->type, "segment") == 0) {
        r = ttf_growth_segment(line, &segment, err);
        if (r == 0) {
            read_plan(reading->request, of, segment.plan);
            chart_lamps_segment(&of->lamps, &segment);
        }
        return r == 0 ? chart_segments_put(&of->segments, &segment) : r;
    }
    if (strcmp(line->type, "slot") != 0)
        return 0;
    r = ttf_growth_slot(line, &record, err);
    if (r < 0)
        return r == -ENOMEM ? r : 0; /* one that contradicts the format: verify says so */
    r = add_line(of, record.index);
    if (r == 0)
        r = chart_points_add(&of->points, &of->lamps, &record);
    ttf_slot_record_free(&record);
    return r;
}

static int read_on(struct ttf_http_request *request, const char *path, struct history_of *of,
                   int64_t max_bytes)
{
    struct reading reading = {request, of};
    int r = ttf_growth_read(request->io, path, &of->growth, max_bytes, take_line, &reading,
                            &request->err);

    if (r != -ESTALE)
        return r;
    forget(of);
    memset(&request->err, 0, sizeof request->err);
    return ttf_growth_read(request->io, path, &of->growth, max_bytes, take_line, &reading,
                           &request->err);
}

int history_hold(struct ttf_http_request *request, int64_t max_bytes, const struct history_of **ret)
{
    struct history *history = request->derived->history;
    const char *name = request->match->name;
    struct history_of *of;
    char folder[4096 + 80], path[4096 + 96];
    int r = folder_dataset(request->folder, name, folder, sizeof folder);
    int fd = r < 0 ? r : folder_file(request->folder, name, "records.jsonl", NULL);

    if (fd < 0)
        return ttf_err_set(&request->err, fd, name, "there is no dataset of this name");
    (void)close(fd);
    (void)snprintf(path, sizeof path, "%s/records.jsonl", folder);
    (void)pthread_mutex_lock(&history->lock);
    of = recall(history, name);
    r = read_on(request, path, of, max_bytes);
    if (r < 0)
        (void)pthread_mutex_unlock(&history->lock);
    else
        *ret = of;
    return r;
}

void history_release(struct ttf_http_request *request)
{
    (void)pthread_mutex_unlock(&request->derived->history->lock);
}

int64_t history_find(const struct history_of *of, int64_t index)
{
    size_t low = 0, high = of->n_lines;

    while (low < high) {
        size_t middle = low + (high - low) / 2;

        if (of->lines[middle].index < index)
            low = middle + 1;
        else
            high = middle;
    }
    return low < of->n_lines && of->lines[low].index == index ? of->lines[low].offset : -ENOENT;
}
