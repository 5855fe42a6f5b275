/* SPDX-License-Identifier: Apache-2.0 */
#include "token_limits.h"

#include <netinet/in.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>

#define CLIENTS 256 /* remembered; the one whose debt ends first makes room */

struct client {
    uint8_t address[8];
    int64_t paid_ns; /* when all its wrong tokens will be forgotten */
};

struct limits {
    struct ttf_clock *clock;
    pthread_mutex_t lock; /* over what follows */
    struct client clients[CLIENTS];
};

struct limits *limits_create(struct ttf_clock *clock)
{
    struct limits *limits = calloc(1, sizeof *limits);

    if (!limits)
        return NULL;
    limits->clock = clock;
    if (pthread_mutex_init(&limits->lock, NULL) == 0)
        return limits;
    free(limits);
    return NULL;
}

void limits_destroy(struct limits *limits)
{
    if (!limits)
        return;
    (void)pthread_mutex_destroy(&limits->lock);
    free(limits);
}

static void take_address(const struct sockaddr *client, uint8_t ret[8])
{
    struct sockaddr_in v4;
    struct sockaddr_in6 v6;

    memset(ret, 0, 8);
    if (client && client->sa_family == AF_INET) {
        memcpy(&v4, client, sizeof v4);
        ret[0] = 4;
        memcpy(ret + 4, &v4.sin_addr, 4);
    } else if (client && client->sa_family == AF_INET6) {
        memcpy(&v6, client, sizeof v6);
        memcpy(ret, &v6.sin6_addr, 8);
    }
}

static struct client *find(struct limits *limits, const uint8_t address[8])
{
    struct client *least = &limits->clients[0];

    for (unsigned i = 0; i < CLIENTS; i++) {
        struct client *c = &limits->clients[i];

        if (c->paid_ns > 0 && memcmp(c->address, address, 8) == 0)
            return c;
        if (c->paid_ns < least->paid_ns)
            least = c;
    }
    memcpy(least->address, address, 8);
    least->paid_ns = 0;
    return least;
}

bool limits_allow(struct limits *limits, const struct sockaddr *client)
{
    int64_t now_ns = ttf_clock_now_ns(limits->clock);
    uint8_t address[8];
    bool allowed = true;

    take_address(client, address);
    (void)pthread_mutex_lock(&limits->lock);
    for (unsigned i = 0; i < CLIENTS; i++)
        if (memcmp(limits->clients[i].address, address, 8) == 0 &&
            limits->clients[i].paid_ns - now_ns > (LIMITS_AT_ONCE - 1) * LIMITS_ONE_NS)
            allowed = false;
    (void)pthread_mutex_unlock(&limits->lock);
    return allowed;
}

void limits_wrong(struct limits *limits, const struct sockaddr *client)
{
    int64_t now_ns = ttf_clock_now_ns(limits->clock);
    struct client *c;
    uint8_t address[8];

    take_address(client, address);
    (void)pthread_mutex_lock(&limits->lock);
    c = find(limits, address);
    c->paid_ns = (c->paid_ns > now_ns ? c->paid_ns : now_ns) + LIMITS_ONE_NS;
    (void)pthread_mutex_unlock(&limits->lock);
}
