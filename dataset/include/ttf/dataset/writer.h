/* SPDX-License-Identifier: Apache-2.0 */
/*
 * writer.h: a dataset being written, safe against power cuts.
 *
 * Promise: when ttf_writer_commit returns 0, the slot and all its files are on
 * the disk as far as the kernel says so, and stay whatever happens next. Until
 * then the slot does not exist. DESIGN.md has the order of operations.
 *
 * One thread at a time. One writer per dataset: the folder is locked.
 */
#ifndef TTF_DATASET_WRITER_H
#define TTF_DATASET_WRITER_H

#include "ttf/base/err.h"
#include "ttf/dataset/io.h"
#include "ttf/dataset/manifest.h"
#include "ttf/dataset/record.h"

struct ttf_writer;

/* What the writer knows of what is on the disk. */
struct ttf_writer_state {
    int64_t
        next_index; /* of the first slot without a record, from the first segment's first_index on */
    int n_segments;
    struct ttf_segment last_segment; /* valid if n_segments > 0 */
    int64_t
        lost_at_end; /* slots at the end that are `power` or `missed`: recorded perhaps before they were due */
    int n_plans;
    bool sealed; /* it is, and nothing was added since (the first write removes the seal) */
    int64_t counts[TTF_RESULT_COUNT];
    unsigned repaired; /* leftovers put right on opening */
};

/*
 * A new dataset at `path`, which must not exist (-EEXIST) or be an empty folder.
 * The name must be of [A-Za-z0-9._-], 64 at most. plan_yaml, plan_json: plan 0,
 * NULL where there is none.
 */
TTF_MUST_USE int ttf_writer_create(struct ttf_io *io, const char *path,
                                   const struct ttf_manifest *manifest, const char *plan_yaml,
                                   const char *plan_json, struct ttf_writer **ret,
                                   struct ttf_err *err);

/*
 * Opens an existing one to go on, repairing what a crash can leave and nothing
 * else. -ENOENT; -EBUSY if somebody writes it; -TTF_EDAMAGED for damage.
 */
TTF_MUST_USE int ttf_writer_open(struct ttf_io *io, const char *path, struct ttf_writer **ret,
                                 struct ttf_err *err);

/*
 * The same after a write of `old` failed (NULL: none is left), which is abandoned: what is seen
 * of files whose sync failed may never have reached the disk, so then the logs are written as
 * new files. *doubt: false at first; kept by the caller until an opening succeeds.
 */
TTF_MUST_USE int ttf_writer_open_anew(struct ttf_io *io, const char *path, struct ttf_writer *old,
                                      bool *doubt, struct ttf_writer **ret, struct ttf_err *err);

/*
 * Memory for record lines of line_bytes: slots and events whose lines are no longer
 * (an event without detail never is) are then written without allocating. Kept until
 * the writer is freed; without it the memory grows with the longest line. -ENOMEM.
 */
TTF_MUST_USE int ttf_writer_reserve(struct ttf_writer *writer, size_t line_bytes,
                                    struct ttf_err *err);

/* Bytes that a slot's line can come to: images, shots of all of them, lamps of each shot. */
size_t ttf_slot_line_bytes(unsigned n_images, unsigned n_shots, unsigned n_lamps);

const struct ttf_manifest *ttf_writer_manifest(const struct ttf_writer *writer);
const struct ttf_writer_state *ttf_writer_state(const struct ttf_writer *writer);

/* Appends a segment line, synced. */
TTF_MUST_USE int ttf_writer_segment(struct ttf_writer *writer, const struct ttf_segment *segment,
                                    struct ttf_err *err);

/* A changed plan: plans/N.yaml, plans/N.json and a "plan" line. Returns N. */
TTF_MUST_USE int ttf_writer_plan(struct ttf_writer *writer, const char *yaml, const char *json,
                                 struct ttf_err *err);

/*
 * Copies a calibration's folder to calibration/ID/ and appends a "calibration"
 * line. Doing it again for an ID that is there is harmless.
 */
TTF_MUST_USE int ttf_writer_calibration(struct ttf_writer *writer, const char *id,
                                        const char *folder, struct ttf_err *err);

/* Writes a file's whole contents to the handle, from offset 0. May be called again for another handle. */
typedef int ttf_produce_fn(void *ctx, struct ttf_io *io, int file, struct ttf_err *err);

/*
 * Writes one image file durably and fills *ret (role, path, bytes, sha256) for
 * the slot's record. role "developed" goes to frames/STREAM/, "raw" to
 * raw/STREAM/; others to frames/STREAM/ with the role in the name. extension
 * without a dot. bracket -1: none. After a failed sync the file is produced
 * again under a new name, once; then the error is returned.
 */
TTF_MUST_USE int ttf_writer_file(struct ttf_writer *writer, const char *role, const char *stream,
                                 int64_t index, int bracket, const char *extension,
                                 ttf_produce_fn *produce, void *ctx, struct ttf_file_ref *ret,
                                 struct ttf_err *err);

/* Appends the slot's record line, synced: the slot is committed. record->index must be >= state.next_index. */
TTF_MUST_USE int ttf_writer_commit(struct ttf_writer *writer, const struct ttf_slot_record *record,
                                   struct ttf_err *err);

/*
 * Appends to events.jsonl: kind ("retry", "lamp-trip", "clock-step", "resume",
 * "disk", "door", ...), its instant on the boot clock and in UTC (TTF_NS_UNKNOWN
 * allowed) and text. detail_json: an object's text, or NULL.
 */
TTF_MUST_USE int ttf_writer_event(struct ttf_writer *writer, const char *kind, int64_t at_ns,
                                  int64_t at_utc_ns, const char *text, const char *detail_json,
                                  struct ttf_err *err);

/* Ends the run: the "end" line, then the full SHA256SUMS. *ret_digest (may be NULL): the dataset's digest. */
TTF_MUST_USE int ttf_writer_seal(struct ttf_writer *writer, const char *reason, char ret_digest[65],
                                 struct ttf_err *err);

/* A write of its logs has failed for good: whatever is asked of it now is refused, and only opening anew helps. */
bool ttf_writer_broken(const struct ttf_writer *writer);

/* Bytes free where the dataset lies; and the folder's path. */
TTF_MUST_USE int ttf_writer_space(struct ttf_writer *writer, struct ttf_io_space *ret);
const char *ttf_writer_path(const struct ttf_writer *writer);

/* Brings SHA256SUMS up to date and frees. Sealed or not. NULL allowed. */
void ttf_writer_close(struct ttf_writer *writer);

/* Frees without touching the disk again: what a box without power does. NULL allowed. */
void ttf_writer_abandon(struct ttf_writer *writer);

#endif
