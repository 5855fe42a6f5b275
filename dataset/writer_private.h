/* SPDX-License-Identifier: Apache-2.0 */
/* writer_private.h: what the writer's files share. */
#ifndef TTF_DATASET_WRITER_PRIVATE_H
#define TTF_DATASET_WRITER_PRIVATE_H

#include "jsonl.h"
#include "sums.h"
#include "ttf/dataset/writer.h"

#define TTF_RESERVE_NAME  ".events-reserve"
#define TTF_RESERVE_BYTES ((int64_t)256 * 1024)

struct ttf_writer {
    struct ttf_io *io;
    char *path;
    void *piece; /* TTF_SHA256_PIECE bytes, for reading back what was written */
    int lock;    /* handle of the folder, locked; -1 */
    struct ttf_manifest manifest;
    char manifest_sha256[65]; /* of dataset.json's bytes */
    struct ttf_writer_state state;
    struct ttf_jsonl records, events;
    bool sealed; /* a seal is on the disk, or may be: to be undone before anything is written */
    bool ended;  /* the last line is an "end" line */
    int sums;    /* handle of SHA256SUMS, appended to; -1: not open */
    bool sums_behind;                     /* an append failed: to be rebuilt */
    uint32_t frames_durable, raw_durable; /* streams whose folder's name is on the disk: bits */
    unsigned n_leftovers; /* files that could not be removed again; those beyond are forgotten */
    char leftovers[8][192];
    unsigned n_calibrations;
    char (*calibrations)[64]; /* ids that have a line */
};

/* Tries once more to remove what could not be removed. */
void ttf_writer_remove_leftovers(struct ttf_writer *writer);

/* Takes the folder's lock. -EBUSY. */
TTF_MUST_USE int ttf_writer_lock(struct ttf_writer *writer, struct ttf_err *err);

/* An empty writer for path; NULL: no memory. ttf_writer_abandon frees it. */
struct ttf_writer *ttf_writer_alloc(struct ttf_io *io, const char *path);

/* Makes a folder of the dataset, and makes sure that its name is on the disk even if it was there. */
TTF_MUST_USE int ttf_writer_folder(struct ttf_writer *writer, const char *folder,
                                   struct ttf_err *err);
/* The names in the dataset's folder, and its own, are on the disk after this. */
TTF_MUST_USE int ttf_writer_sync_names(struct ttf_writer *writer, struct ttf_err *err);
/* The names of the folders above, as far as we may. */
void ttf_writer_sync_above(struct ttf_writer *writer);

/* Before anything is written: the seal goes first. */
TTF_MUST_USE int ttf_writer_unseal(struct ttf_writer *writer, struct ttf_err *err);

/* Remembers what a line of records.jsonl says; also when reading them on opening. */
TTF_MUST_USE int ttf_writer_learn(struct ttf_writer *writer, const struct ttf_line *line,
                                  struct ttf_err *err);
TTF_MUST_USE int ttf_writer_learn_segment(struct ttf_writer *writer,
                                          const struct ttf_segment *segment);
/* Memory for one more, so that learning it cannot fail once its line is written. */
TTF_MUST_USE int ttf_writer_room_for_calibration(struct ttf_writer *writer);
/* What the state knows of one more slot line. */
void ttf_writer_count_slot(struct ttf_writer_state *state, int64_t index, enum ttf_result result);
TTF_MUST_USE int ttf_writer_learn_calibration(struct ttf_writer *writer, const char *id);

/* Space that events can fall back on. Making it may fail quietly: the disk is full already. */
void ttf_reserve_make(struct ttf_writer *writer);
/* Frees a part of it: true if there was one. */
bool ttf_reserve_use(struct ttf_writer *writer);

/*
 * Puts right what a crash left: temporary files, orphans, ends of lines, SHA256SUMS. doubt: a sync of the logs
 * has failed in this process, so they are written anew before anything they say counts.
 */
TTF_MUST_USE int ttf_writer_repair(struct ttf_writer *writer, const struct ttf_lines_tail *records,
                                   const struct ttf_lines_tail *events, enum ttf_sums_state sums,
                                   bool doubt, struct ttf_err *err);

/* Writes plans/N.yaml and .json and puts their entries into json as "files". */
TTF_MUST_USE int ttf_writer_plan_files(struct ttf_writer *writer, int n, const char *yaml,
                                       const char *text, struct ttf_json *json,
                                       struct ttf_err *err);

#endif
