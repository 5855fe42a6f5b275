/* SPDX-License-Identifier: Apache-2.0 */
/*
 * keeper.h: a thread of low priority that tells on what happens: it empties the mailbox, follows the records, opens the
 * sockets, and tries again where one cannot be had. Whatever becomes of it, a run goes on.
 */
#ifndef DAEMON_KEEPER_H
#define DAEMON_KEEPER_H

#include "parts.h"

/* Begins; without sockets too. -ENOMEM and the like: there is no thread. */
TTF_MUST_USE int keeper_start(struct daemon *d, struct keeper **ret, struct ttf_err *err);

/* Ends all connections. NULL allowed. */
void keeper_stop(struct keeper *keeper);

#endif
