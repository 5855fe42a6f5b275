/* SPDX-License-Identifier: Apache-2.0 */
/* seal.h: a sealed dataset's list of hashes, here and on the box. One thread. */
#ifndef PULL_SEAL_H
#define PULL_SEAL_H

#include <stdbool.h>
#include <stdint.h>

#include "landing.h"
#include "ttf/base/attr.h"
#include "ttf/base/err.h"
#include "ttf/dataset/io.h"
#include "wire.h"

struct seal_state {
    int64_t slots;
    bool sealed;
    char digest[65]; /* of a sealed one */
    bool here;       /* sealed here, with this digest: nothing it lists needs to be looked at */
};

/* How the dataset stands on the box. */
TTF_MUST_USE int seal_ask(struct wire *wire, const char *name, struct seal_state *ret,
                          struct ttf_err *err);

/* A seal here that is not the box's is taken away, for what follows changes the dataset; state->here is set. */
TTF_MUST_USE int seal_open(struct ttf_io *io, const char *folder, struct seal_state *state,
                           struct ttf_err *err);

/*
 * Checks and completes all that the box's seal lists, and puts it in place. *ret_sealed: false where the box has none (any
 * more). -TTF_EDAMAGED: what is listed is not so on the box.
 */
TTF_MUST_USE int seal_close(struct landing *landing, struct wire *wire,
                            const struct seal_state *state, bool *ret_sealed, struct ttf_err *err);

#endif
