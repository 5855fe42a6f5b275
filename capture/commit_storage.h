/* SPDX-License-Identifier: Apache-2.0 */
/*
 * commit_storage.h: getting lines onto a storage that may fail for a while. What
 * cannot be written waits in memory, in order. Committer thread only.
 */
#ifndef TTF_CAPTURE_PRIVATE_COMMIT_STORAGE_H
#define TTF_CAPTURE_PRIVATE_COMMIT_STORAGE_H

#include "commit.h"

/* Whether the box is without power: then nothing more is written. */
bool ttf_committer_power_lost(struct ttf_committer *c);

/* Adds a judged record to those to be written; takes ownership. */
void ttf_committer_keep(struct ttf_committer *c, struct ttf_slot_work *work);

/* Frees the oldest of them, written or not. */
void ttf_committer_drop_first(struct ttf_committer *c);

/*
 * Writes the records that wait, oldest first, opening the dataset anew after a
 * failure: nobody knows what is on the disk then. 0, or why the first of them could not be written.
 */
TTF_MUST_USE int ttf_committer_flush(struct ttf_committer *c, struct ttf_err *err);

/* Writes a change of plan, at a second try after a failure as above; takes it (*change NULL) once it is in force. */
TTF_MUST_USE int ttf_committer_write_change(struct ttf_committer *c,
                                            struct ttf_plan_change **change, struct ttf_err *err);

/* The session's numbers of segments and plans as the dataset has them: another one after a move. Negative: not of this one. */
int ttf_committer_segment_number(const struct ttf_committer *c, int segment);
int ttf_committer_plan_number(const struct ttf_committer *c, int plan);

/* Opens the dataset anew, which repairs what it must. */
TTF_MUST_USE int ttf_committer_reopen(struct ttf_committer *c);

/*
 * Goes on in the second storage, for this reason: what waits goes along, and the files of slots without
 * a record as far as they can be read (under_way: one that does not wait yet; NULL). -ENOENT: there is none, or it is
 * the one in use. Otherwise nothing has changed, and it may be tried again.
 */
TTF_MUST_USE int ttf_committer_move(struct ttf_committer *c, const char *why,
                                    struct ttf_slot_work *under_way);

/* Image files of a record not yet written that are not there any more are taken from it; it is judged when it is written. */
void ttf_committer_drop_lost_files(struct ttf_committer *c, struct ttf_slot_record *record);

/* One event, now; negative errno. */
TTF_MUST_USE int ttf_committer_write_event(struct ttf_committer *c, const struct ttf_job *event);

/* The run comes to so many slots from now on. What still waits for its storage will say so too, and takes nothing back. */
void ttf_committer_another_end(struct ttf_committer *c, int64_t total);

/* A correction of a segment's UTC, now; negative errno. */
TTF_MUST_USE int ttf_committer_write_correction(struct ttf_committer *c,
                                                const struct ttf_segment *of_session);

/* An event of kind "storage" into this dataset, now; negative errno. detail_json: an object's text, or NULL. */
int ttf_committer_say(struct ttf_committer *c, struct ttf_writer *writer, const char *text,
                      const char *detail_json);

/* Events and corrections of UTC that wait, as far as the storage takes them. */
void ttf_committer_write_late(struct ttf_committer *c);

/* Whether there is less room than the reserve: an event and an alarm when it begins, and when it is over. */
void ttf_committer_note_disk(struct ttf_committer *c, bool full);

/* Everything that waits. 0 once all records are written. */
int ttf_committer_catch_up(struct ttf_committer *c, struct ttf_err *err);

#endif
