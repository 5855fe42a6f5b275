/* SPDX-License-Identifier: Apache-2.0 */
#include "second_storage.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "path_name.h"
#include "second_left.h"
#include "ttf/base/time.h"
#include "ttf/capture/session.h"
#include "ttf/dataset/reader.h"

int ttf_second_path(const struct ttf_plan *plan, const char *first, char *ret, size_t size,
                    struct ttf_err *err)
{
    size_t at, n;

    ret[0] = '\0';
    if (plan->second_storage[0] == '\0')
        return 0;
    at = ttf_path_name(first, &n);
    if (snprintf(ret, size, "%s/%.*s", plan->second_storage, (int)n, first + at) >= (int)size)
        return ttf_err_set(err, -ENAMETOOLONG, "storage.second", "the path is too long");
    return 0;
}

static int foreign(const char *second, struct ttf_err *err)
{
    ttf_err_set(err, -EEXIST, second,
                "the second storage holds a dataset of this name, and not of this run");
    ttf_err_hint(err, "give another -o, or move that one away");
    return -EEXIST;
}

int ttf_second_find(struct ttf_io *io, const char *first, const char *second, struct ttf_err *err)
{
    struct ttf_manifest of_first;
    struct ttf_manifest of_second;
    struct ttf_reader *reader;
    bool alone;
    bool begun;
    bool sealed;
    int r;

    if (second[0] == '\0')
        return 0;
    r = ttf_manifest_load(io, second, &of_second, err);
    if (r == -ENOENT)
        return ttf_second_expect_not_left(io, first, second, err);
    if (r < 0) { /* it may have been moved on to: two datasets of the same slots would be worse */
        ttf_err_hint(err, "mend or move away what lies in the second storage");
        return r;
    }
    alone = ttf_manifest_load(io, first, &of_first, NULL) < 0;
    if (strcmp(of_second.group_member, TTF_MEMBER_SECOND) != 0 ||
        (!alone && strcmp(of_second.group_uuid, ttf_manifest_group(&of_first)) != 0))
        return foreign(second, err);
    r = ttf_reader_open(io, second, &reader, err);
    if (r < 0)
        return r;
    begun = ttf_reader_summary(reader)->n_segments > 0;
    sealed = ttf_reader_summary(reader)->sealed;
    ttf_reader_close(reader);
    /* The first one's disk may be gone. If the run had ended, this is rather another one, by the same name. */
    if (alone && (!begun || sealed))
        return foreign(second, err);
    return begun ? 1 : ttf_second_expect_not_left(io, first, second, err);
}

int ttf_session_find(struct ttf_io *io, const char *path, const struct ttf_plan *plan, char *ret,
                     size_t size, struct ttf_err *err)
{
    char second[4096];
    int r = ttf_second_path(plan, path, second, sizeof(second), err);

    if (r == 0)
        r = ttf_second_find(io, path, second, err);
    if (r < 0)
        return r;
    if (snprintf(ret, size, "%s", r > 0 ? second : path) >= (int)size)
        return ttf_err_set(err, -ENAMETOOLONG, NULL, "the dataset's path is too long");
    return 0;
}

int ttf_second_manifest(const struct ttf_manifest *first, struct ttf_manifest *ret,
                        struct ttf_err *err)
{
    struct ttf_manifest fresh;
    int r = ttf_manifest_init(&fresh, err);

    if (r < 0)
        return r;
    *ret = *first;
    if (ret->group_uuid[0] == '\0') /* ret may be first */
        memcpy(ret->group_uuid, ret->uuid, sizeof(ret->group_uuid));
    memcpy(ret->uuid, fresh.uuid, sizeof(ret->uuid));
    snprintf(ret->group_member, sizeof(ret->group_member), "%s", TTF_MEMBER_SECOND);
    return 0;
}

/* Whether its plan of this number is this one, to the letter. */
static bool is_plan(struct ttf_io *io, const char *path, int number, const char *json)
{
    char name[4096 + 32];
    char *text = NULL;
    size_t bytes;
    bool same;

    snprintf(name, sizeof(name), "%s/plans/%d.json", path, number);
    same = ttf_io_slurp(io, name, 1 << 20, &text, &bytes, NULL) == 0 && strcmp(text, json) == 0;
    free(text);
    return same;
}

static bool has_plan(struct ttf_io *io, const char *path, int n_plans, const char *json)
{
    while (n_plans > 0 && !is_plan(io, path, n_plans - 1, json))
        n_plans--;
    return n_plans > 0;
}

/* The number of its newest plan, which is this one: added, if it was another. */
static int with_plan(struct ttf_io *io, const char *path, struct ttf_writer *writer,
                     const struct ttf_plan_text *plan, struct ttf_err *err)
{
    int n = ttf_writer_state(writer)->n_plans;

    if (n > 0 && is_plan(io, path, n - 1, plan->json))
        return n - 1;
    return ttf_writer_plan(writer, plan->yaml, plan->json, err);
}

static int make_or_open(struct ttf_io *io, const char *path, const struct ttf_manifest *manifest,
                        const struct ttf_plan_text *plan, struct ttf_writer **ret,
                        struct ttf_err *err)
{
    struct ttf_manifest there;
    int r;

    if (ttf_manifest_load(io, path, &there, NULL) < 0)
        return ttf_writer_create(io, path, manifest, plan->yaml, plan->json, ret, err);
    r = ttf_writer_open(io, path, ret, err);
    if (r == 0 && (strcmp(there.group_uuid, manifest->group_uuid) != 0 ||
                   ttf_writer_state(*ret)->n_segments > 0)) {
        ttf_writer_abandon(*ret);
        return foreign(path, err);
    }
    return r;
}

int ttf_second_open(struct ttf_io *io, const char *path, const struct ttf_manifest *manifest,
                    const struct ttf_plan_text *given, const struct ttf_plan_text *in_force,
                    struct ttf_writer **ret, struct ttf_err *err)
{
    struct ttf_writer *writer = NULL;
    int plan = make_or_open(io, path, manifest, given ? given : in_force, &writer, err);

    if (plan < 0)
        return plan;
    /* Plans may have changed since it was made, the given one, too. */
    if (given && !has_plan(io, path, ttf_writer_state(writer)->n_plans, given->json))
        plan = ttf_writer_plan(writer, given->yaml, given->json, err);
    if (plan >= 0)
        plan = with_plan(io, path, writer, in_force, err);
    if (plan < 0) {
        ttf_writer_abandon(writer);
        return plan;
    }
    *ret = writer;
    return plan;
}

/* Of the last slots how many were not taken, for ttf_writer_state. */
static int64_t count_lost(const struct ttf_reader *reader, int64_t slots)
{
    enum ttf_result result;
    int64_t n = 0, index;

    while (ttf_reader_brief(reader, slots - 1 - n, &index, &result) == 0 &&
           (result == TTF_RESULT_POWER || result == TTF_RESULT_MISSED))
        n++;
    return n;
}

int ttf_second_state_of(struct ttf_io *io, const char *first, struct ttf_writer_state *ret,
                        struct ttf_manifest *ret_manifest, struct ttf_err *err)
{
    struct ttf_writer_state state = {0};
    const struct ttf_reader_summary *summary;
    struct ttf_reader *reader;
    int r = ttf_reader_open(io, first, &reader, err);

    if (r < 0)
        return r;
    summary = ttf_reader_summary(reader);
    state.next_index = summary->slots > 0 ? summary->last_index + 1 : 0;
    state.n_segments = summary->n_segments;
    state.n_plans = summary->n_plans;
    state.sealed = summary->sealed;
    memcpy(state.counts, summary->counts, sizeof(state.counts));
    if (state.n_segments > 0)
        r = ttf_reader_segment(reader, state.n_segments - 1, &state.last_segment);
    state.lost_at_end = count_lost(reader, summary->slots);
    *ret_manifest = *ttf_reader_manifest(reader);
    ttf_reader_close(reader);
    if (r == 0)
        *ret = state;
    return r;
}
