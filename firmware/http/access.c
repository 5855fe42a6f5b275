/* SPDX-License-Identifier: Apache-2.0 */
#include "access.h"

#include <arpa/inet.h>
#include <nettle/memops.h>
#include <string.h>
#include <strings.h>

#include "session.h"

/* The name without its port. false: no such text. */
static bool take_name(const char *host, char ret[256])
{
    const char *end = NULL;
    size_t n;

    if (*host == '[') {
        host++;
        end = strchr(host, ']');
        if (!end || (end[1] != '\0' && end[1] != ':'))
            return false;
    } else {
        end = strchr(host, ':');
    }
    n = end ? (size_t)(end - host) : strlen(host);
    if (n == 0 || n >= 256)
        return false;
    memcpy(ret, host, n);
    ret[n] = '\0';
    if (ret[n - 1] == '.')
        ret[n - 1] = '\0'; /* the root's own dot */
    return true;
}

bool access_host(const char *host, const char *const *names)
{
    unsigned char address[sizeof(struct in6_addr)];
    char name[256];

    if (!host || !take_name(host, name))
        return false;
    if (inet_pton(AF_INET, name, address) == 1 || inet_pton(AF_INET6, name, address) == 1)
        return true;
    if (strcasecmp(name, "localhost") == 0)
        return true;
    for (; names && *names; names++)
        if (strcasecmp(name, *names) == 0)
            return true;
    return false;
}

bool access_same_token(const char *given, const char *token)
{
    size_t n = token ? strlen(token) : 0; /* its length is no secret */

    return token && strlen(given) == n && memeql_sec(given, token, n);
}

bool access_token(const char *authorization, const char *token)
{
    static const char BEARER[] = "Bearer ";

    if (!authorization || strncasecmp(authorization, BEARER, sizeof BEARER - 1) != 0)
        return false;
    return access_same_token(authorization + sizeof BEARER - 1, token);
}

static bool cookie_is_right(const struct access_said *said, const char *token)
{
    char name[SESSION_NAME_SIZE], value[SESSION_SIZE];

    return session_find(said->cookie, session_name(said->host, name), value) &&
           session_valid(value, token);
}

/* "http://HOST": a page of this very server. */
static bool is_own(const char *origin, const char *host)
{
    const char *name = origin ? strstr(origin, "://") : NULL;

    return name && host && strcasecmp(name + 3, host) == 0;
}

/* A page elsewhere would have to be let by us before it could send this header. */
static bool is_marked(const struct access_said *said)
{
    return said->marker && strcmp(said->marker, "1") == 0;
}

enum access_verdict access_decide(enum ttf_http_access needs, bool free_to_read,
                                  const struct access_said *said, const char *token)
{
    bool elsewhere = said->site && strcasecmp(said->site, "same-origin") != 0;

    if (needs == TTF_HTTP_CABLE) {
        if (!free_to_read)
            return ACCESS_ELSEWHERE;
        return is_marked(said) && !elsewhere ? ACCESS_YES : ACCESS_OTHER_PAGE;
    }
    if (needs == TTF_HTTP_OPEN || (needs == TTF_HTTP_READ && free_to_read))
        return ACCESS_YES;
    if (access_token(said->authorization, token))
        return ACCESS_YES; /* a page elsewhere cannot send it */
    if (!cookie_is_right(said, token))
        return ACCESS_NEEDS_TOKEN;
    if (needs == TTF_HTTP_READ)
        return ACCESS_YES;
    if (needs ==
        TTF_HTTP_TOKEN) /* a picture, which a person may open in a window of its own as well */
        return elsewhere && strcasecmp(said->site, "none") != 0 ? ACCESS_OTHER_PAGE : ACCESS_YES;
    return elsewhere || !is_marked(said) || !is_own(said->origin, said->host) ? ACCESS_OTHER_PAGE
                                                                              : ACCESS_YES;
}
