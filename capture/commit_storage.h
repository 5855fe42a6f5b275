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

/* One event, now; negative errno. */
TTF_MUST_USE int ttf_committer_write_event(struct ttf_committer *c, const struct ttf_job *event);

/* Events and corrections of UTC that wait, as far as the storage takes them. */
void ttf_committer_write_late(struct ttf_committer *c);

/* Everything that waits. 0 once all records are written. */
int ttf_committer_catch_up(struct ttf_committer *c, struct ttf_err *err);

#endif
