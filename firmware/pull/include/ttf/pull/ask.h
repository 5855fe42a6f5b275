/* SPDX-License-Identifier: Apache-2.0 */
/* ask.h: something asked of a box beside datasets, over the same wire. Waits for the network; one thread. */
#ifndef TTF_PULL_ASK_H
#define TTF_PULL_ASK_H

#include "ttf/pull/pull.h"

/* A pull's config; of it box, clock, token, ended and stop are used. *ret: by malloc. */

/* The box's token, which it shows once to whoever is at its cable. -EEXIST: it has been shown; -EPERM: this is no cable. */
TTF_MUST_USE int ttf_pull_token(const struct ttf_pull_config *config, char **ret_token,
                                struct ttf_err *err);

/*
 * This machine's UTC, for a box that has none better; config->token is needed. 1: it took it, 0: it did not (it has a better
 * one).
 */
TTF_MUST_USE int ttf_pull_offer_time(const struct ttf_pull_config *config, struct ttf_err *err);

#endif
