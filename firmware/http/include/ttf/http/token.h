/* SPDX-License-Identifier: Apache-2.0 */
/* token.h: the secret that lets a client read from elsewhere, and change the box. */
#ifndef TTF_HTTP_TOKEN_H
#define TTF_HTTP_TOKEN_H

#include <stdbool.h>

#include "ttf/base/attr.h"
#include "ttf/base/err.h"

#define TTF_HTTP_TOKEN_SIZE 65 /* bytes with the terminator */

/* 32 hex digits of the kernel's randomness. */
TTF_MUST_USE int ttf_http_token_make(char ret[TTF_HTTP_TOKEN_SIZE], struct ttf_err *err);

/*
 * The first word of a file, 16 to 64 printable characters; a file that is not there, or empty, is made with a fresh one, mode 0600:
 * whole and on the disk, or not at all.
 * -EINVAL: no token in it; -EPERM: others may read it; errors of opening.
 */
TTF_MUST_USE int ttf_http_token_load(const char *path, char ret[TTF_HTTP_TOKEN_SIZE],
                                     struct ttf_err *err);

/*
 * The same, for a token that may be shown once (README.md, "How a person gets the token"): of one that is made here that is remembered
 * in a file beside it, PATH.unshown, before it is there. Of a token that somebody else wrote it never is.
 */
TTF_MUST_USE int ttf_http_token_load_to_show(const char *path, char ret[TTF_HTTP_TOKEN_SIZE],
                                             struct ttf_err *err);

/* Does this token wait to be shown? */
bool ttf_http_token_waits(const char *path, const char *token);

/* 0, once, when the disk knows that it does so no longer: show it. -EEXIST: it does not; errors of the disk. Any thread. */
TTF_MUST_USE int ttf_http_token_show(const char *path, const char *token, struct ttf_err *err);

/* The same of a file that has to be there: -ENOENT. */
TTF_MUST_USE int ttf_http_token_read(const char *path, char ret[TTF_HTTP_TOKEN_SIZE],
                                     struct ttf_err *err);

#endif
