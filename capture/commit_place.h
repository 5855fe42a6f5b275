/* SPDX-License-Identifier: Apache-2.0 */
/*
 * commit_place.h: where the dataset lies. Records go to files that are open, images by a path: when a disk is mounted over
 * the folder in which a run began, or comes back in its place, the two are of different datasets. So the folder
 * that the path leads to is looked at (device, inode) before something is written. Committer thread, and the session's while that does not run.
 */
#ifndef TTF_CAPTURE_PRIVATE_COMMIT_PLACE_H
#define TTF_CAPTURE_PRIVATE_COMMIT_PLACE_H

#include "commit.h"

/* What the watcher is told then. */
#define TTF_PLACE_ALARM \
    "another folder lies where the run began: the run ends, and what it captured lies beneath it"

enum ttf_place {
    TTF_PLACE_SAME, /* or nobody knows */
    TTF_PLACE_GONE, /* nothing: its disk was taken away, or one without it lies over it. As a storage that fails */
    TTF_PLACE_BACK, /* another folder, and the same dataset: its disk went and came back. To be opened anew */
    TTF_PLACE_OTHER /* another dataset, or none: nothing of the run may be written there any more */
};

/* The dataset was made, opened, or left for another one: this is its place. */
void ttf_committer_note_place(struct ttf_committer *c);

enum ttf_place ttf_committer_place(const struct ttf_committer *c);

/* Where its disk came back, opens it anew. -ESTALE: another one lies there; -EIO: none; negative errno of opening. */
TTF_MUST_USE int ttf_committer_come_back(struct ttf_committer *c, struct ttf_err *err);

#endif
