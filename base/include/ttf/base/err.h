/* SPDX-License-Identifier: Apache-2.0 */
/*
 * err.h: what went wrong, where, and what to do about it.
 *
 * Functions return 0 (or a count) on success and a negative errno on failure.
 * Many take, as their last argument, an optional `struct ttf_err *`; it is
 * written only on failure, and NULL is always allowed. Libraries never print:
 * the program decides what becomes of an error.
 */
#ifndef TTF_BASE_ERR_H
#define TTF_BASE_ERR_H

#include "ttf/base/attr.h"

/*
 * Damaged data: a checksum that does not hold, a file that contradicts its
 * record. Programs exit 3 on it. (EUCLEAN, "structure needs cleaning".)
 */
#define TTF_EDAMAGED 117

/* A plain struct: no ownership, may be copied, zero-initialise it. Texts are cut, never overrun. */
struct ttf_err {
    int code;        /* the negative errno that was returned; 0 = nothing set */
    char what[320];  /* what went wrong, a sentence without a full stop */
    char where[256]; /* a path, `file:line`, a field, a device; empty if none */
    char hint[256];  /* what the user can do; empty if none */
};

/*
 * Sets all of *err (hint empty) and returns `code`, so that a function can end
 * in `return ttf_err_set(err, -EINVAL, path, "...")`. `where` may be NULL.
 * code: a negative errno. err: may be NULL.
 */
int ttf_err_set(struct ttf_err *err, int code, const char *where, const char *fmt, ...)
    TTF_PRINTF(4, 5);

/* Adds what the user can do. Does nothing if err is NULL; returns nothing, so that nobody returns it as a code. */
void ttf_err_hint(struct ttf_err *err, const char *fmt, ...) TTF_PRINTF(2, 3);

/* Puts "prefix: " before `what` on the way up. */
void ttf_err_prefix(struct ttf_err *err, const char *fmt, ...) TTF_PRINTF(2, 3);

/*
 * Writes "where: what; hint" (parts that exist) into buf, always terminated.
 * An err with no text gives strerror of its code. Returns buf.
 */
const char *ttf_err_text(const struct ttf_err *err, char *buf, unsigned size);

#endif
