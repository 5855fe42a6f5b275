/* SPDX-License-Identifier: Apache-2.0 */
/*
 * notes.h: what people add to a dataset, during or after: notes.jsonl (FORMAT.md). Outside the seal,
 * and written without the dataset's lock, so that a note can be made while a capture runs.
 */
#ifndef TTF_DATASET_NOTES_H
#define TTF_DATASET_NOTES_H

#include <stdint.h>

#include "ttf/base/err.h"
#include "ttf/dataset/io.h"

#define TTF_NOTE_SLOTS_MAX 8
#define TTF_NOTE_TAGS_MAX  8

struct ttf_note {
    int64_t utc_ns;                       /* when it was made; TTF_NS_UNKNOWN */
    char author[64];                      /* empty: absent */
    char text[1024];                      /* empty: absent; then there is a tag */
    unsigned n_slots;                     /* ranges of slots it is about; 0: the whole */
    int64_t slots[TTF_NOTE_SLOTS_MAX][2]; /* first, last; 0 <= first <= last */
    unsigned n_tags;
    char tags[TTF_NOTE_TAGS_MAX][32]; /* "exclude", "reference", or people's own; not empty */
};

/*
 * 0, or -EINVAL naming the field: nothing said at all, an empty tag, too many, ranges turned round. Bytes that are
 * no UTF-8 are written as U+FFFD.
 */
TTF_MUST_USE int ttf_note_check(const struct ttf_note *note, struct ttf_err *err);

/*
 * Appends the note as one line, synced, in one write. What a crash left of a line before it is ended
 * first and stays. Any thread, any process. -ENOENT: there is no dataset at path.
 */
TTF_MUST_USE int ttf_note_append(struct ttf_io *io, const char *path, const struct ttf_note *note,
                                 struct ttf_err *err);

#endif
