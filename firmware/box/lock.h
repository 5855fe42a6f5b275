/* SPDX-License-Identifier: Apache-2.0 */
/*
 * lock.h: who owns a box. A file that its owner holds locked (flock) as long as it lives, with a line that says who it
 * is: so a lock never outlives its process, whatever ended it.
 */
#ifndef FIRMWARE_BOX_LOCK_H
#define FIRMWARE_BOX_LOCK_H

#include <stdbool.h>

#include "ttf/base/attr.h"
#include "ttf/base/err.h"

struct box_lock {
    int fd; /* -1: none is held */
};

/*
 * Takes it. path: empty: nobody asks, nothing is held, 0. who: "ttfboxd, process 123, into /data/grass". make_folder: the
 * folder is made if it is missing; without, a missing one means that nobody owns boxes on this machine: 0. -EBUSY: err
 * says who owns the box. -EACCES and the like.
 */
TTF_MUST_USE int box_lock_take(const char *path, const char *who, bool make_folder,
                               struct box_lock *ret, struct ttf_err *err);

/* Who owns it now: 1 and the owner's line; 0: nobody. Holds nothing. */
int box_lock_owner(const char *path, char ret[256]);

void box_lock_drop(struct box_lock *lock);

#endif
