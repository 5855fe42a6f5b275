/* SPDX-License-Identifier: Apache-2.0 */
/* access.h: who may ask (README.md, "Who may"). */
#ifndef HTTP_ACCESS_H
#define HTTP_ACCESS_H

#include <stdbool.h>

#include "ttf/http/routes.h"

/* May a Host header name this server? names: further ones than addresses and "localhost", NULL-ended, or NULL. */
bool access_host(const char *host, const char *const *names);

/* Is this Authorization header the token's? The time it takes does not tell how much of it was right. */
bool access_token(const char *authorization, const char *token);

/* The same of a bare token; token NULL: never. */
bool access_same_token(const char *given, const char *token);

/* What a request says of who sends it; NULL: not said. */
struct access_said {
    const char *host, *authorization, *cookie;
    const char *origin; /* of the page that sends it */
    const char *site;   /* Sec-Fetch-Site */
    const char *marker; /* X-Ttfbox, which no page elsewhere can send */
};

enum access_verdict {
    ACCESS_YES = 0,
    ACCESS_NEEDS_TOKEN,
    ACCESS_OTHER_PAGE, /* it may do this, but the request may be another page's */
    ACCESS_ELSEWHERE   /* this is had at the cable alone */
};

/* free_to_read: the socket lets all read. token NULL: there is none. */
enum access_verdict access_decide(enum ttf_http_access needs, bool free_to_read,
                                  const struct access_said *said, const char *token);

#endif
