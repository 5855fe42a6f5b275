/* SPDX-License-Identifier: Apache-2.0 */
/*
 * mailbox.h: what a run says of itself, on its way to whoever tells it on. Putting in takes no lock and waits for
 * nobody, as slots wait for it; where it is full, what comes is dropped and counted. One thread at a time puts in, one takes out.
 */
#ifndef DAEMON_MAILBOX_H
#define DAEMON_MAILBOX_H

#include <stdbool.h>
#include <stdint.h>

#include "ttf/capture/session.h"

#define MAILBOX_ROOM 512

struct letter {
    enum ttf_progress_kind kind;
    enum ttf_alarm_until until;
    int result;
    bool waits;
    int64_t run; /* of the mailbox, then */
    int64_t lit_ns, settled_ns;
    int64_t index, total, now_ns, error_ns, wakeup_ns;
    char text[256]; /* cut */
};

struct mailbox {
    uint32_t in, out, told; /* counts of letters, atomically */
    uint32_t dropped;
    int64_t run; /* which one says what is put in from now on; between runs alone */
    struct letter letters[MAILBOX_ROOM];
};

void mailbox_put(struct mailbox *box, const struct ttf_progress *progress);

/* The oldest; false: there is none. */
bool mailbox_take(struct mailbox *box, struct letter *ret);

/* Whoever takes out: what it took has been told on. Whoever puts in: whether all of it has. */
void mailbox_tell(struct mailbox *box);
bool mailbox_all_told(const struct mailbox *box);

/* How many were dropped since this was asked last. */
uint32_t mailbox_dropped(struct mailbox *box);

#endif
