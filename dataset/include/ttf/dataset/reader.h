/* SPDX-License-Identifier: Apache-2.0 */
/*
 * reader.h: random access to a dataset, whatever its length; repairs nothing.
 *
 * Holds an offset per record line and one parsed record at a time, never the
 * frames. Threads: one at a time per reader (open several), but for ttf_reader_slot.
 */
#ifndef TTF_DATASET_READER_H
#define TTF_DATASET_READER_H

#include "ttf/base/err.h"
#include "ttf/dataset/io.h"
#include "ttf/dataset/manifest.h"
#include "ttf/dataset/pixbuf.h"
#include "ttf/dataset/record.h"

struct ttf_reader;

struct ttf_reader_summary {
    int64_t slots; /* slot lines */
    int64_t counts[TTF_RESULT_COUNT];
    int n_segments, n_plans, n_calibrations;
    bool ended; /* there is an "end" line */
    bool sealed;
    bool unterminated; /* what stands behind the last whole line is ignored (a crash) */
    int64_t first_index, last_index;
};

/* -ENOENT, -ENOTSUP (another major or an unknown required name), -TTF_EDAMAGED naming the line. */
TTF_MUST_USE int ttf_reader_open(struct ttf_io *io, const char *path, struct ttf_reader **ret,
                                 struct ttf_err *err);

/*
 * The same for who asks for every slot before anything that the dataset says counts: slot lines that begin as a writer of
 * this house begins them are not parsed yet. Each line's crc, seq and order is looked at; what stands behind a slot's head is
 * first looked at by ttf_reader_slot. For 500 slots 0.6 ms, where parsing takes 10.
 */
TTF_MUST_USE int ttf_reader_open_by_heads(struct ttf_io *io, const char *path,
                                          struct ttf_reader **ret, struct ttf_err *err);
void ttf_reader_close(struct ttf_reader *reader); /* NULL allowed */

const struct ttf_manifest *ttf_reader_manifest(const struct ttf_reader *reader);
const struct ttf_reader_summary *ttf_reader_summary(const struct ttf_reader *reader);
const char *ttf_reader_path(const struct ttf_reader *reader);
struct ttf_io *ttf_reader_io(const struct ttf_reader *reader);

/* Segment i as corrected by later lines; -ENOENT. */
TTF_MUST_USE int ttf_reader_segment(struct ttf_reader *reader, int i, struct ttf_segment *ret);

/* The i-th slot line (0..slots-1), parsed: free it with ttf_slot_record_free. By several threads at once, while nothing else is done with the reader. */
TTF_MUST_USE int ttf_reader_slot(struct ttf_reader *reader, int64_t i, struct ttf_slot_record *ret,
                                 struct ttf_err *err);

/*
 * Index and result of the i-th slot line as the opening saw them: reads nothing, where it is looked for among many.
 * -ENOENT, leaving both alone.
 */
TTF_MUST_USE int ttf_reader_brief(const struct ttf_reader *reader, int64_t i, int64_t *ret_index,
                                  enum ttf_result *ret_result);

/* Which slot line (0..slots-1) has this index; -ENOENT: none. */
int64_t ttf_reader_find(const struct ttf_reader *reader, int64_t index);

/* UTC of a slot's due time; TTF_NS_UNKNOWN if nobody knows. */
int64_t ttf_reader_due_utc_ns(struct ttf_reader *reader, const struct ttf_slot_record *record);

/* The dataset's digest: of SHA256SUMS, hex; -ENODATA while unsealed. */
TTF_MUST_USE int ttf_reader_digest(struct ttf_reader *reader, char ret[65], struct ttf_err *err);

#endif
