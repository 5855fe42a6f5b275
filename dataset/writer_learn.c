/* SPDX-License-Identifier: Apache-2.0 */
/* A writer's knowledge of the records that are there already. */
#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "json_read.h"
#include "record_line.h"
#include "writer_private.h"

int ttf_writer_room_for_calibration(struct ttf_writer *writer)
{
    char(*grown)[64];

    grown = reallocarray(writer->calibrations, writer->n_calibrations + 1, sizeof(*grown));
    if (!grown)
        return -ENOMEM;
    writer->calibrations = grown;
    return 0;
}

int ttf_writer_learn_calibration(struct ttf_writer *writer, const char *id)
{
    int r = ttf_writer_room_for_calibration(writer);

    if (r)
        return r;
    ttf_text_cut(writer->calibrations[writer->n_calibrations++], sizeof(writer->calibrations[0]),
                 id);
    return 0;
}

void ttf_writer_count_slot(struct ttf_writer_state *state, int64_t index, enum ttf_result result)
{
    bool lost = result == TTF_RESULT_POWER || result == TTF_RESULT_MISSED;

    state->next_index = index + 1;
    state->counts[result]++;
    state->lost_at_end = lost ? state->lost_at_end + 1 : 0;
}

static int learn_slot(struct ttf_writer *writer, const struct ttf_line *line, struct ttf_err *err)
{
    struct ttf_writer_state *state = &writer->state;
    struct ttf_slot_brief brief;
    int r;

    r = ttf_slot_get_brief(line, &brief, err);
    if (r)
        return r;
    if (brief.index < state->next_index)
        return ttf_err_set(err, -TTF_EDAMAGED, line->where,
                           "slot %lld comes where %lld or more is due", (long long)brief.index,
                           (long long)state->next_index);
    if (brief.segment >= state->n_segments)
        return ttf_err_set(err, -TTF_EDAMAGED, line->where,
                           "slot %lld is of segment %d, which has no line before it",
                           (long long)brief.index, brief.segment);
    ttf_writer_count_slot(state, brief.index, brief.result);
    return 0;
}

static int learn_segment(struct ttf_writer *writer, const struct ttf_line *line,
                         struct ttf_err *err)
{
    struct ttf_segment segment;
    int r;

    r = ttf_segment_get(line, &segment, err);
    if (r)
        return r;
    if (segment.dataset_sha256[0] && strcmp(segment.dataset_sha256, writer->manifest_sha256) != 0)
        return ttf_err_set(err, -TTF_EDAMAGED, writer->path,
                           "dataset.json has changed: segment %d gives another sha256 of it",
                           segment.segment);
    if (segment.plan >= writer->state.n_plans)
        return ttf_err_set(err, -TTF_EDAMAGED, line->where,
                           "segment %d follows plan %d, which has no line before it",
                           segment.segment, segment.plan);
    if (ttf_writer_learn_segment(writer, &segment) != 0)
        return ttf_err_set(err, -TTF_EDAMAGED, line->where,
                           "segment %d comes where segment %d is due", segment.segment,
                           writer->state.n_segments);
    return 0;
}

static int learn_plan(struct ttf_writer *writer, const struct ttf_line *line, struct ttf_err *err)
{
    int number, r = ttf_plan_get(line, &number, err);

    if (r == 0 && number != writer->state.n_plans)
        return ttf_err_set(err, -TTF_EDAMAGED, line->where, "plan %d comes where plan %d is due",
                           number, writer->state.n_plans);
    writer->state.n_plans++;
    return r;
}

static int learn_calibration(struct ttf_writer *writer, const struct ttf_line *line,
                             struct ttf_err *err)
{
    char id[64];
    int r = ttf_calibration_get(line, id, err);

    if (r)
        return r;
    r = ttf_writer_learn_calibration(writer, id);
    return r ? ttf_err_set(err, r, line->where, "no memory") : 0;
}

int ttf_writer_learn(struct ttf_writer *writer, const struct ttf_line *line, struct ttf_err *err)
{
    int r = 0;

    if (strcmp(line->type, "end") == 0) {
        writer->ended = true;
        return 0;
    }
    if (strcmp(line->type, "slot") == 0) {
        r = learn_slot(writer, line, err);
    } else if (strcmp(line->type, "segment") == 0) {
        r = learn_segment(writer, line, err);
    } else if (strcmp(line->type, "plan") == 0) {
        r = learn_plan(writer, line, err);
    } else if (strcmp(line->type, "calibration") == 0) {
        r = learn_calibration(writer, line, err);
    } else {
        return 0;
    }
    writer->ended = false;
    return r;
}
