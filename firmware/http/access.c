/* SPDX-License-Identifier: Apache-2.0 */
#include "access.h"

#include <arpa/inet.h>
#include <nettle/memops.h>
#include <string.h>
#include <strings.h>

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

bool access_token(const char *authorization, const char *token)
{
    static const char BEARER[] = "Bearer ";
    size_t n;

    if (!token || !authorization || strncasecmp(authorization, BEARER, sizeof BEARER - 1) != 0)
        return false;
    authorization += sizeof BEARER - 1;
    n = strlen(token); /* its length is no secret */
    return strlen(authorization) == n && memeql_sec(authorization, token, n);
}
