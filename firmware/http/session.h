/* SPDX-License-Identifier: Apache-2.0 */
/*
 * session.h: the cookie that stands for the token in a browser: a random number and its HMAC under the token. Nothing is
 * remembered here: a cookie outlives a restart, and dies with its token.
 */
#ifndef HTTP_SESSION_H
#define HTTP_SESSION_H

#include <stdbool.h>

#include "request.h"

#define SESSION_SIZE \
    98 /* bytes of a value with the terminator: 32 and 64 hex digits, a dot between */
#define SESSION_NAME_SIZE 16

/* The cookie's name: with the Host's port, as browsers share cookies between the ports of a name. Returns ret. */
const char *session_name(const char *host, char ret[SESSION_NAME_SIZE]);

TTF_MUST_USE int session_make(const char *token, char ret[SESSION_SIZE], struct ttf_err *err);

/* The value of that name in a Cookie header (NULL allowed). false: none that could be one of ours. */
bool session_find(const char *header, const char *name, char ret[SESSION_SIZE]);

/* Was it made under this token (NULL: never)? The time it takes does not tell how much of it was right. */
bool session_valid(const char *value, const char *token);

/* Routes. */
int session_begin(struct ttf_http_request *request, struct ttf_http_answer *ret);
int session_show(struct ttf_http_request *request, struct ttf_http_answer *ret);
int session_end(struct ttf_http_request *request, struct ttf_http_answer *ret);
int session_token(struct ttf_http_request *request, struct ttf_http_answer *ret);

#endif
