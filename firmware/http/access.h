/* SPDX-License-Identifier: Apache-2.0 */
/* access.h: who may ask (README.md, "Who may"). */
#ifndef HTTP_ACCESS_H
#define HTTP_ACCESS_H

#include <stdbool.h>

/* May a Host header name this server? names: further ones than addresses and "localhost", NULL-ended, or NULL. */
bool access_host(const char *host, const char *const *names);

/* Is this Authorization header the token's? The time it takes does not tell how much of it was right. */
bool access_token(const char *authorization, const char *token);

#endif
