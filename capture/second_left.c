/* SPDX-License-Identifier: Apache-2.0 */
#include "second_left.h"

#include <errno.h>
#include <inttypes.h>
#include <jansson.h>
#include <stdio.h>
#include <string.h>

#include "second_storage.h"
#include "ttf/dataset/growth.h"
#include "ttf/dataset/reader.h"

void ttf_second_put_left(int n_segments, int64_t slot, char ret[TTF_SECOND_LEFT_SIZE])
{
    snprintf(ret, TTF_SECOND_LEFT_SIZE, "{\"left_from\":%" PRId64 ",\"segments\":%d}", slot,
             n_segments);
}

/* What the last event of this kind says. */
struct left {
    int64_t slot; /* the first that is not the first dataset's; -1: it was not left */
    int64_t n_segments;
};

static int on_event(void *ctx, const struct ttf_growth_line *line, struct ttf_err *err)
{
    const json_t *detail = json_object_get(line->json, "detail");
    const json_t *slot = json_object_get(detail, "left_from");
    const json_t *segments = json_object_get(detail, "segments");
    struct left *left = ctx;

    (void)err;
    if (json_is_integer(slot) && json_is_integer(segments)) {
        left->slot = json_integer_value(slot);
        left->n_segments = json_integer_value(segments);
    }
    return 0;
}

static int read_left(struct ttf_io *io, const char *first, struct left *ret, struct ttf_err *err)
{
    struct ttf_growth growth = {0};
    char path[4096 + 16];
    int r;

    *ret = (struct left){.slot = -1};
    snprintf(path, sizeof(path), "%s/events.jsonl", first);
    r = ttf_growth_read(io, path, &growth, 0, on_event, ret, err);
    if (r == -ENOMEM)
        return r;
    if (r < 0 &&
        err) /* it says nothing: an error of its disk is met with by whoever goes on in it */
        *err = (struct ttf_err){0};
    return 0;
}

/* A dataset of which slots may lie elsewhere. */
struct open_end {
    bool first; /* member of its group; else one whose plan came to a second storage later */
    int n_segments;
};

/* 1: it is begun and not ended; 0: there is no such dataset, or opening it will say what is wrong with it. */
static int look(struct ttf_io *io, const char *path, struct open_end *ret, struct ttf_err *err)
{
    struct ttf_reader *reader = NULL;
    int r = ttf_reader_open(io, path, &reader, err);
    bool sealed;

    if (r == -ENOMEM)
        return r; /* it may be begun: who went on in it would do so beside the second one */
    if (r < 0) {
        if (err)
            *err = (struct ttf_err){0};
        return 0;
    }
    sealed = ttf_reader_summary(reader)->sealed;
    ret->n_segments = ttf_reader_summary(reader)->n_segments;
    ret->first = strcmp(ttf_reader_manifest(reader)->group_member, TTF_MEMBER_FIRST) == 0;
    ttf_reader_close(reader);
    return !sealed && ret->n_segments > 0;
}

static int refuse_left(const char *second, const struct left *left, struct ttf_err *err)
{
    ttf_err_set(err, -ENODEV, "storage.second",
                "the run went on in %s from slot %" PRId64 " on, and nothing of it is there",
                second, left->slot);
    ttf_err_hint(err,
                 "plug its disk in and mount it; if it is lost for good, run a plan without "
                 "storage.second (its slots are then missed), or begin another dataset with this "
                 "one's name as 'group:' of its plan");
    return -ENODEV;
}

static int refuse_missing(const char *folder, struct ttf_err *err)
{
    ttf_err_set(err, -EINVAL, "storage.second",
                "%s is not there, and the run may have gone on in it", folder);
    ttf_err_hint(err, "mount it; or take storage.second out of the plan, to go on here alone");
    return -EINVAL;
}

int ttf_second_expect_not_left(struct ttf_io *io, const char *first, const char *second,
                               struct ttf_err *err)
{
    const char *slash = strrchr(second, '/');
    struct open_end open_end = {0};
    struct ttf_io_stat st;
    struct left left;
    char folder[4096];
    int r = look(io, first, &open_end, err);

    if (r <= 0)
        return r;
    r = read_left(io, first, &left, err);
    if (r < 0)
        return r;
    if (left.slot >= 0 && open_end.n_segments <= left.n_segments)
        return refuse_left(second, &left, err);
    snprintf(folder, sizeof(folder), "%.*s", slash > second ? (int)(slash - second) : 1, second);
    if (open_end.first && io->ops->stat(io, folder, &st) == -ENOENT)
        return refuse_missing(folder, err);
    return 0;
}
