/* SPDX-License-Identifier: Apache-2.0 */
/* one.h: one dataset, brought as far as the box has it. One thread. */
#ifndef PULL_ONE_H
#define PULL_ONE_H

#include <stdbool.h>
#include <stdint.h>

#include "ttf/pull/pull.h"
#include "wire.h"

struct one_result {
    int64_t slots, files, damaged;
    char first_damaged[256];
    bool sealed;     /* here now, with the box's digest */
    bool box_sealed; /* there: nothing more will come */
    char stuck[192]; /* the file at which the wire failed; empty: at none */
};

#define ONE_SKIPS_MAX 16

/* Files at which the wire failed again and again: the box cannot read them, most likely. Counted as damaged. */
struct one_skips {
    unsigned n;
    char paths[ONE_SKIPS_MAX][192];
};

/*
 * Once: what the box has now. Whatever comes before an error stays, and is gone on with the next time. *ret is set also on
 * failure. Errors of ttf_pull; damaged files are no error here, but counted.
 */
struct crew;
TTF_MUST_USE int one_pull(const struct ttf_pull_config *config, struct wire *wire,
                          struct crew *crew, const char *name, const struct one_skips *skips,
                          struct one_result *ret, struct ttf_err *err);

#endif
