/* SPDX-License-Identifier: Apache-2.0 */
/* names.h: a growing list of names. One thread at a time. */
#ifndef TTFBOX_PULL_NAMES_H
#define TTFBOX_PULL_NAMES_H

#include <stddef.h>

#include "ttf/base/attr.h"

/* Zeroed: an empty one. names_first and names_next go through it. */
struct names {
    char *bytes; /* each name with its end */
    size_t n_bytes, room;
    size_t n;
};

/* The first n_bytes of `name`. -ENOMEM. */
TTF_MUST_USE int names_add(struct names *names, const char *name, size_t n_bytes);
void names_free(struct names *names);

/* Valid until the next addition; NULL: there is none (any more). */
const char *names_first(const struct names *names);
const char *names_next(const struct names *names, const char *name);

#endif
