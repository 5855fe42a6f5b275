/* SPDX-License-Identifier: Apache-2.0 */
/*
 * crew.h: threads that bring files, each by a connection of its own: while one waits for the box or the disk another hashes. A file at a
 * time over one connection leaves either side idle half of the time.
 */
#ifndef PULL_CREW_H
#define PULL_CREW_H

#include "landing.h"
#include "ttf/pull/pull.h"
#include "wire.h"

#define CREW_HANDS 3 /* threads */

/* One file to be brought. The crew has it from crew_do to crew_wait. */
struct errand {
    const char *name, *folder; /* the dataset's, there and here; borrowed */
    char path[192];
    char sha256[65];
    int64_t bytes;
    enum landing_trust trust;
    bool doubtful; /* landing.h */
    /* what came of it */
    int r;
    struct landed landed;
    struct ttf_err why;
    /* the crew's */
    bool done;
    struct errand *next;
};

struct crew;

/* config is borrowed as long as it lives. Where no thread can be had, files are brought by whoever asks for them. -ENOMEM. */
TTF_MUST_USE int crew_create(const struct ttf_pull_config *config, struct wire *wire,
                             struct crew **ret, struct ttf_err *err);
void crew_destroy(struct crew *crew); /* NULL allowed; nothing may be under way */

/* In the order in which they are asked for, as far as several at once have an order. */
void crew_do(struct crew *crew, struct errand *errand);

/* Until it is done. */
void crew_wait(struct crew *crew, const struct errand *errand);

/* Those that nobody has begun end at once, with -ECANCELED. */
void crew_drop(struct crew *crew);

#endif
