/* SPDX-License-Identifier: Apache-2.0 */
/*
 * notes.h: what people say of a dataset, during or after: notes.jsonl (FORMAT.md). Outside the seal, and
 * written without the dataset's lock, so that a note can be made while a capture runs.
 */
#ifndef TTF_DATASET_NOTES_H
#define TTF_DATASET_NOTES_H

#include <stdbool.h>
#include <stdint.h>

#include "ttf/base/err.h"
#include "ttf/dataset/io.h"

#define TTF_NOTE_SLOTS_MAX 64
#define TTF_NOTE_TAGS_MAX  8

struct ttf_note {
    int64_t utc_ns;                       /* when it was made; TTF_NS_UNKNOWN */
    char author[64];                      /* empty: absent */
    char text[1024];                      /* empty: absent; then there is a tag */
    unsigned n_slots;                     /* ranges of slots it is about; 0: the whole */
    int64_t slots[TTF_NOTE_SLOTS_MAX][2]; /* first, last; 0 <= first <= last */
    unsigned n_tags;
    char tags[TTF_NOTE_TAGS_MAX][32]; /* "exclude", "reference", or people's own; a word */
};

/*
 * 0, or -EINVAL naming the field: nothing said at all, an empty tag, too many, ranges turned round. Bytes that are
 * no UTF-8 are written as U+FFFD.
 */
TTF_MUST_USE int ttf_note_check(const struct ttf_note *note, struct ttf_err *err);

/*
 * Adds the note as one line: when this returns 0 it is on the disk and stays there. Else it may be seen and is not promised; what was noted
 * before is as it was. What a crash left of a line of somebody else's is ended first and stays. Any thread, any process: -EAGAIN, at once, while
 * another adds one; try again. -ENOENT: there is no dataset at path.
 */
TTF_MUST_USE int ttf_note_append(struct ttf_io *io, const char *path, const struct ttf_note *note,
                                 struct ttf_err *err);

/* A note is said of this slot, or of the whole. */
bool ttf_note_is_of(const struct ttf_note *note, int64_t index);
bool ttf_note_has_tag(const struct ttf_note *note, const char *tag);

/* What is read. note: one more, texts longer than their room cut; wrong: a line that is none, and why. Either may be NULL. */
struct ttf_note_visitor {
    void (*note)(void *ctx, const struct ttf_note *note);
    void (*wrong)(void *ctx, int64_t line, const char *what); /* line from 1 */
    void *ctx;
};

/*
 * All notes in the order of their lines; a last line that a crash left unfinished is passed over in silence.
 * 0, also if there are none. Errors of the disk; -ENOMEM.
 */
TTF_MUST_USE int ttf_notes_read(struct ttf_io *io, const char *path,
                                const struct ttf_note_visitor *visitor, struct ttf_err *err);

#endif
