/* SPDX-License-Identifier: Apache-2.0 */
/* seal.h: a sealed dataset's list of hashes, here and on the box. One thread. */
#ifndef PULL_SEAL_H
#define PULL_SEAL_H

#include <stdbool.h>
#include <stdint.h>

#include "grown.h"
#include "landing.h"
#include "settle.h"
#include "ttf/base/attr.h"
#include "ttf/base/err.h"
#include "ttf/dataset/io.h"
#include "vouched.h"
#include "wire.h"

struct seal_state {
    int64_t slots;
    bool sealed;
    char digest[65]; /* of a sealed one */
    bool here;       /* sealed here, with this digest */
    bool other_here; /* sealed here, with another */
    int64_t aside;   /* files here that it does not list, put aside: strays.h */
};

/* How the dataset stands on the box. */
TTF_MUST_USE int seal_ask(struct wire *wire, const char *name, struct seal_state *ret,
                          struct ttf_err *err);

/* Is it sealed here, too? state->here and other_here are set; nothing is changed. */
TTF_MUST_USE int seal_look(struct ttf_io *io, const char *folder, struct seal_state *state,
                           struct ttf_err *err);

/* Takes the list of hashes here away, before what it lists changes: without one, the records tell. */
TTF_MUST_USE int seal_drop(struct ttf_io *io, const char *folder, struct ttf_err *err);

/*
 * Checks and completes all that the box's seal lists, and puts it in place. *ret_sealed: false where the box has none (any
 * more). records: as they are here, open. -TTF_EDAMAGED: what is listed is not so on the box, or its records say otherwise.
 */
TTF_MUST_USE int seal_close(struct landing *landing, struct settling *settling,
                            struct grown *records, struct vouched *vouched,
                            struct seal_state *state, bool *ret_sealed, struct ttf_err *err);

#endif
