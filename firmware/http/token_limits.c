/* SPDX-License-Identifier: Apache-2.0 */
#include "token_limits.h"

#include <pthread.h>
#include <stdlib.h>
#include <string.h>

#include "client.h"

#define DEBTORS 256 /* remembered; the one whose debt ends first makes room */

struct debtor {
    uint8_t address[CLIENT_BYTES];
    int64_t paid_ns; /* when all its wrong tokens will be forgotten */
};

struct limits {
    struct ttf_clock *clock;
    pthread_mutex_t lock; /* over what follows */
    struct debtor debtors[DEBTORS];
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

static struct debtor *find(struct limits *limits, const uint8_t address[CLIENT_BYTES])
{
    struct debtor *least = &limits->debtors[0];

    for (unsigned i = 0; i < DEBTORS; i++) {
        struct debtor *c = &limits->debtors[i];

        if (c->paid_ns > 0 && client_is_same(c->address, address))
            return c;
        if (c->paid_ns < least->paid_ns)
            least = c;
    }
    memcpy(least->address, address, CLIENT_BYTES);
    least->paid_ns = 0;
    return least;
}

bool limits_wrong(struct limits *limits, const struct sockaddr *client)
{
    int64_t now_ns = ttf_clock_now_ns(limits->clock);
    uint8_t address[CLIENT_BYTES];
    struct debtor *c;
    bool counts;

    client_of_address(client, address);
    (void)pthread_mutex_lock(&limits->lock);
    c = find(limits, address);
    counts = c->paid_ns - now_ns <= (LIMITS_AT_ONCE - 1) * LIMITS_ONE_NS;
    if (counts)
        c->paid_ns = (c->paid_ns > now_ns ? c->paid_ns : now_ns) + LIMITS_ONE_NS;
    (void)pthread_mutex_unlock(&limits->lock);
    return counts;
}
