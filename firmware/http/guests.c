/* SPDX-License-Identifier: Apache-2.0 */
#include "guests.h"

#include <pthread.h>
#include <stdlib.h>
#include <string.h>

#include "client.h"

enum doing {
    NOT_THERE = 0,
    UNFINISHED, /* waits, or its request is not whole */
    ANSWERED,
    SLEEPING,
    SHUT_DOWN, /* as good as gone */
    DOINGS
};

struct client {
    uint8_t who[CLIENT_BYTES];
    unsigned n[DOINGS]; /* its guests, by what they do */
};

struct guest {
    struct guests *guests;
    struct client *client;
    enum doing doing;
    int fd;
    int64_t since_ns; /* that it does so */
    int64_t until_ns; /* UNFINISHED: the latest */
};

struct guests {
    struct ttf_clock *clock;
    unsigned places, most, of_client;
    pthread_mutex_t lock; /* over all below */
    unsigned n[DOINGS];
    struct guest *all;      /* places */
    struct client *clients; /* places: there are never more clients than guests */
};

struct guests *guests_create(struct ttf_clock *clock, unsigned places)
{
    struct guests *guests = calloc(1, sizeof *guests);

    if (!guests)
        return NULL;
    guests->clock = clock;
    guests->places = places;
    guests->most = places - places / 8;
    guests->of_client = guests->most / 2 < GUESTS_OF_CLIENT ? guests->most / 2 : GUESTS_OF_CLIENT;
    guests->all = calloc(places, sizeof *guests->all);
    guests->clients = calloc(places, sizeof *guests->clients);
    if (guests->all && guests->clients && pthread_mutex_init(&guests->lock, NULL) == 0)
        return guests;
    free(guests->all);
    free(guests->clients);
    free(guests);
    return NULL;
}

void guests_destroy(struct guests *guests)
{
    if (!guests)
        return;
    (void)pthread_mutex_destroy(&guests->lock);
    free(guests->all);
    free(guests->clients);
    free(guests);
}

/* ---- counting; the lock is held ---- */

static unsigned staying(const unsigned n[DOINGS])
{
    return n[UNFINISHED] + n[ANSWERED] + n[SLEEPING];
}

static void set(struct guest *guest, enum doing doing, int64_t for_ns)
{
    struct guests *guests = guest->guests;

    if (guest->doing != NOT_THERE) {
        guest->client->n[guest->doing]--;
        guests->n[guest->doing]--;
    }
    if (doing != NOT_THERE) {
        guest->client->n[doing]++;
        guests->n[doing]++;
    }
    guest->doing = doing;
    guest->since_ns = ttf_clock_now_ns(guests->clock);
    guest->until_ns = guest->since_ns + for_ns;
}

static bool is_free(const struct client *client)
{
    return staying(client->n) + client->n[SHUT_DOWN] == 0;
}

static struct client *client_of(struct guests *guests, const struct sockaddr *address)
{
    struct client *free_one = NULL;
    uint8_t who[CLIENT_BYTES];

    client_of_address(address, who);
    for (unsigned i = 0; i < guests->places; i++) {
        struct client *c = &guests->clients[i];

        if (!is_free(c) && client_is_same(c->who, who))
            return c;
        if (is_free(c) && !free_one)
            free_one = c;
    }
    if (free_one)
        memcpy(free_one->who, who, CLIENT_BYTES);
    return free_one;
}

static struct guest *free_place(struct guests *guests)
{
    for (unsigned i = 0; i < guests->places; i++)
        if (guests->all[i].doing == NOT_THERE)
            return &guests->all[i];
    return NULL;
}

/* ---- who has to go; the lock is held ---- */

static struct guest *longest(struct guests *guests, const struct client *client, enum doing doing)
{
    struct guest *found = NULL;

    for (unsigned i = 0; client && i < guests->places; i++) {
        struct guest *g = &guests->all[i];

        if (g->doing == doing && g->client == client && (!found || g->since_ns < found->since_ns))
            found = g;
    }
    return found;
}

static const struct client *with_most(const struct guests *guests, enum doing doing)
{
    const struct client *most = NULL;

    for (unsigned i = 0; i < guests->places; i++) {
        const struct client *c = &guests->clients[i];

        if (c->n[doing] > (most ? most->n[doing] : 0))
            most = c;
    }
    return most;
}

static bool shut_down(struct guest *guest)
{
    if (!guest)
        return false;
    (void)shutdown(guest->fd, SHUT_RDWR);
    set(guest, SHUT_DOWN, 0);
    return true;
}

/* false: all that could go sleep, or are this client's own and answered. */
static bool make_room(struct guests *guests, const struct client *client, bool local)
{
    if (!local && staying(client->n) >= guests->of_client)
        return shut_down(longest(guests, client, UNFINISHED));
    return staying(guests->n) < guests->most ||
           shut_down(longest(guests, with_most(guests, UNFINISHED), UNFINISHED)) ||
           shut_down(longest(guests, with_most(guests, ANSWERED), ANSWERED));
}

/* ---- what they do ---- */

struct guest *guests_enter(struct guests *guests, const struct sockaddr *address, int fd)
{
    bool local = !address || address->sa_family == AF_UNIX;
    struct client *client;
    struct guest *guest;

    (void)pthread_mutex_lock(&guests->lock);
    client = client_of(guests, address);
    guest = free_place(guests);
    if (client && guest && make_room(guests, client, local)) {
        *guest = (struct guest){.guests = guests, .client = client, .fd = fd};
        set(guest, UNFINISHED, GUEST_HEADERS_NS);
    } else {
        (void)shutdown(fd, SHUT_RDWR);
        guest = NULL;
    }
    (void)pthread_mutex_unlock(&guests->lock);
    return guest;
}

/* One that was shut down stays so until it leaves. */
static void does(struct guest *guest, enum doing doing, int64_t for_ns)
{
    if (!guest)
        return;
    (void)pthread_mutex_lock(&guest->guests->lock);
    if (guest->doing != SHUT_DOWN || doing == NOT_THERE)
        set(guest, doing, for_ns);
    (void)pthread_mutex_unlock(&guest->guests->lock);
}

void guest_reads_body(struct guest *guest)
{
    does(guest, UNFINISHED, GUEST_BODY_NS);
}

void guest_is_answered(struct guest *guest)
{
    does(guest, ANSWERED, 0);
}

void guest_sleeps(struct guest *guest)
{
    does(guest, SLEEPING, 0);
}

void guest_waits(struct guest *guest)
{
    does(guest, UNFINISHED, GUEST_HEADERS_NS);
}

void guest_leaves(struct guest *guest)
{
    does(guest, NOT_THERE, 0);
}

void guests_tidy(struct guests *guests)
{
    int64_t now_ns = ttf_clock_now_ns(guests->clock);

    (void)pthread_mutex_lock(&guests->lock);
    for (unsigned i = 0; i < guests->places; i++) {
        struct guest *g = &guests->all[i];

        if (g->doing == UNFINISHED && now_ns >= g->until_ns)
            (void)shut_down(g);
    }
    (void)pthread_mutex_unlock(&guests->lock);
}
