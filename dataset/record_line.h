/* SPDX-License-Identifier: Apache-2.0 */
/* record_line.h: the structs of record.h to lines and back, for the store's files only. */
#ifndef TTF_DATASET_RECORD_LINE_H
#define TTF_DATASET_RECORD_LINE_H

#include "json_read.h"
#include "lines.h"
#include "ttf/dataset/record.h"

/* Is it fit to be committed? -EINVAL naming the field. */
TTF_MUST_USE int ttf_slot_check(const struct ttf_slot_record *record, struct ttf_err *err);
TTF_MUST_USE int ttf_segment_check(const struct ttf_segment *s, struct ttf_err *err);

/* Fields behind type and seq, between ttf_line_begin and ttf_line_finish. */
void ttf_slot_put(struct ttf_json *json, const struct ttf_slot_record *record);
void ttf_segment_put(struct ttf_json *json, const struct ttf_segment *s);
void ttf_end_put(struct ttf_json *json, const struct ttf_end_record *e);

/* From parsed lines; -TTF_EDAMAGED naming the field if one contradicts FORMAT.md. */
TTF_MUST_USE int ttf_slot_get(const struct ttf_line *line, struct ttf_slot_record *ret,
                              struct ttf_err *err);
TTF_MUST_USE int ttf_segment_get(const struct ttf_line *line, struct ttf_segment *ret,
                                 struct ttf_err *err);
TTF_MUST_USE int ttf_end_get(const struct ttf_line *line, struct ttf_end_record *ret,
                             struct ttf_err *err);
/* Its number alone, for who reads no files by it. */
TTF_MUST_USE int ttf_plan_number(const struct ttf_line *line, int *ret, struct ttf_err *err);
TTF_MUST_USE int ttf_plan_get(const struct ttf_line *line, int *ret_number, struct ttf_err *err);
TTF_MUST_USE int ttf_calibration_get(const struct ttf_line *line, char ret_id[64],
                                     struct ttf_err *err);

/* What opening and verifying need of a slot line, without the images. */
struct ttf_slot_brief {
    int64_t index, due_ns;
    int segment;
    enum ttf_result result;
};
TTF_MUST_USE int ttf_slot_get_brief(const struct ttf_line *line, struct ttf_slot_brief *ret,
                                    struct ttf_err *err);

/*
 * The same, and the seq, by the first bytes of a line that a writer of this house wrote: some fifty times as fast as parsing it.
 * false: it is no slot line, or of another hand, and is to be parsed. What stands behind is not looked at.
 */
bool ttf_slot_head(const char *line, size_t bytes, int64_t *ret_seq, struct ttf_slot_brief *ret);

/* A file that a line names, of whatever role. */
struct ttf_named_file {
    const char *path, *sha256; /* valid during the call */
    int64_t bytes;             /* -1: the line does not say */
    bool of_image; /* of an image of a slot; else of a plan, a calibration, or dataset.json */
};
typedef int ttf_named_file_fn(void *ctx, const struct ttf_named_file *file, struct ttf_err *err);

/* Every file of a slot, plan, calibration or segment line, in its order. Non-zero stops and is returned. */
TTF_MUST_USE int ttf_line_files(const struct ttf_line *line, ttf_named_file_fn *fn, void *ctx,
                                struct ttf_err *err);

#endif
