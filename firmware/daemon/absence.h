/* SPDX-License-Identifier: Apache-2.0 */
/*
 * absence.h: why slots of a run have no records, as far as this process was there to see it (ttf/capture/session.h).
 * Of the thread that runs things.
 */
#ifndef DAEMON_ABSENCE_H
#define DAEMON_ABSENCE_H

#include <stdbool.h>
#include <stdint.h>

#include "ttf/capture/session.h"

/* Zeroed: nothing was seen. What was seen of another dataset than the one named last is forgotten. */
struct absence {
    char dataset[65];
    struct ttf_absence it;
    bool tried; /* since the last stop */
};

/*
 * A person had stopped it: so it was found at from_ns, and gone on with at until_ns. Of more than TTF_ABSENCE_STOPS in one
 * absence the last are told.
 */
void absence_rested(struct absence *absence, const char *dataset, int64_t from_ns,
                    int64_t until_ns);

/* What was begun at since_ns could not go on. */
void absence_tried(struct absence *absence, const char *dataset, int64_t since_ns);

/* The run was armed: what has no record until now gets one, and what is lost from now on has its own reasons. */
void absence_over(struct absence *absence);

struct ttf_absence absence_of(struct absence *absence, const char *dataset);

#endif
