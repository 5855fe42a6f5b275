/* SPDX-License-Identifier: Apache-2.0 */
#include "announce.h"

#include <arpa/inet.h>
#include <errno.h>
#include <net/if.h>
#include <netinet/in.h>
#include <stdio.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include "log.h"

#define TIMES    2            /* RFC 6762, 8.3: told unasked, so often, a second apart */
#define APART_NS TTF_NS_PER_S /* nor is it told to all more often because somebody asks (6) */
#define ALONE    20           /* answers to one alone, of all who ask, within APART_NS */
#define AT_ONCE  16           /* questions that are read before other things are looked after */

void announce_init(struct announce *a, const char *serial)
{
    char name[80];

    *a = (struct announce){0};
    (void)snprintf(name, sizeof name, "ttfbox-%.64s", serial);
    if (mdns_is_name(name))
        memcpy(a->name, name, strlen(name) + 1);
    for (unsigned i = 0; i < TTF_DAEMON_LISTEN_MAX; i++)
        a->places[i].fd = -1;
}

/* ---- sockets ---- */

/* "usb0" of "usb0:8417", if that is open. */
static bool interface_of(const struct ttf_http_place *place, char ret[16])
{
    const char *colon = strrchr(place->text, ':');
    size_t n = colon ? (size_t)(colon - place->text) : 0;

    if (place->fd < 0 || strcmp(place->text, place->at) == 0 || n == 0 || n >= 16)
        return false;
    memcpy(ret, place->text, n);
    ret[n] = '\0';
    return true;
}

/* What comes by this interface alone, and goes out by it. */
static int make_socket(const struct announce_place *p)
{
    const struct sockaddr_in any = {.sin_family = AF_INET, .sin_port = htons(MDNS_PORT)};
    const struct ip_mreqn group = {.imr_multiaddr.s_addr = htonl(MDNS_GROUP),
                                   .imr_ifindex = (int)p->number};
    const int on = 1, hops = 255;
    int fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    int r;

    if (fd < 0)
        return -errno;
    /* Others of this machine may answer there as well, to their own names. */
    if (setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on) < 0 ||
        setsockopt(fd, SOL_SOCKET, SO_BINDTODEVICE, p->interface, (socklen_t)strlen(p->interface)) <
            0 ||
        setsockopt(fd, IPPROTO_IP, IP_MULTICAST_IF, &group, sizeof group) < 0 ||
        setsockopt(fd, IPPROTO_IP, IP_MULTICAST_TTL, &hops, sizeof hops) < 0 ||
        setsockopt(fd, IPPROTO_IP, IP_TTL, &hops, sizeof hops) < 0 ||
        setsockopt(fd, IPPROTO_IP, IP_ADD_MEMBERSHIP, &group, sizeof group) < 0 ||
        bind(fd, (const struct sockaddr *)(const void *)&any, sizeof any) < 0) {
        r = -errno;
        (void)close(fd);
        return r;
    }
    return fd;
}

static void close_place(struct announce_place *p)
{
    if (p->fd >= 0)
        (void)close(p->fd);
    p->fd = -1;
}

/* Which addresses are of the interface's network. */
static int find_network(struct announce_place *p)
{
    struct ifreq request = {.ifr_addr = {.sa_family = AF_INET}};
    const struct sockaddr_in *has = (const void *)&request.ifr_netmask;

    memcpy(request.ifr_name, p->interface, sizeof p->interface);
    if (ioctl(p->fd, SIOCGIFNETMASK, &request) < 0)
        return -errno;
    p->mask = has->sin_addr.s_addr;
    return 0;
}

static int open_socket(struct announce_place *p)
{
    int r;

    p->fd = make_socket(p);
    if (p->fd < 0)
        return p->fd;
    r = find_network(p);
    if (r < 0)
        close_place(p);
    return r;
}

static void open_place(struct announce *a, struct announce_place *p, const char *at,
                       unsigned number, int64_t now_ns)
{
    char address[TTF_HTTP_WHERE_SIZE];
    int r;

    (void)snprintf(p->at, sizeof p->at, "%s", at);
    (void)snprintf(address, sizeof address, "%.*s", (int)strcspn(at, ":"), at);
    p->host.name = a->name;
    p->number = number;
    if (inet_pton(AF_INET, address, p->host.address) != 1)
        return; /* of IPv6 there is no such place */
    r = open_socket(p);
    if (r < 0) {
        if (!p->complained)
            log_line(LOG_LEVEL_WARNING, "unnamed", "at=\"%s\" why=\"%s\"", p->interface,
                     strerrordesc_np(-r));
        p->complained = true;
        p->fd = -1;
        return;
    }
    p->complained = false;
    p->left = TIMES;
    p->told_ns = p->else_ns = now_ns - APART_NS;
    p->alone_ns = now_ns;
    p->alone = 0;
    log_line(LOG_LEVEL_NOTICE, "named", "name=\"%s.local\" at=\"%s\" for=\"%s\"", a->name, address,
             p->interface);
}

void announce_follow(struct announce *a, const struct ttf_http_places *sockets, int64_t now_ns)
{
    a->n = *a->name ? sockets->n : 0;
    for (unsigned i = 0; i < a->n; i++) {
        const struct ttf_http_place *place = &sockets->places[i];
        struct announce_place *p = &a->places[i];
        bool there = interface_of(place, p->interface);
        unsigned number = there ? if_nametoindex(p->interface) : 0;

        if (p->fd >= 0 && (number != p->number || strcmp(place->at, p->at) != 0))
            close_place(p);
        if (number > 0 && p->fd < 0)
            open_place(a, p, place->at, number, now_ns);
    }
}

/* ---- what is told ---- */

static void tell_all(const struct announce_place *p, const uint8_t *data, size_t n)
{
    const struct sockaddr_in group = {
        .sin_family = AF_INET, .sin_port = htons(MDNS_PORT), .sin_addr.s_addr = htonl(MDNS_GROUP)};

    /* What does not arrive is asked for again. */
    (void)!sendto(p->fd, data, n, 0, (const struct sockaddr *)(const void *)&group, sizeof group);
}

/* *told_ns: when it was last. */
static void tell_all_again(const struct announce_place *p, const uint8_t *data, size_t n,
                           int64_t *told_ns, int64_t now_ns)
{
    if (now_ns - *told_ns < APART_NS)
        return;
    tell_all(p, data, n);
    *told_ns = now_ns;
}

/* Who it goes to may be made up, and another than who asked: so it is a trickle, whoever asks how often. One that is not told asks again. */
static void tell_one(struct announce_place *p, const uint8_t *data, size_t n,
                     const struct sockaddr_in *to, int64_t now_ns)
{
    if (now_ns - p->alone_ns >= APART_NS) {
        p->alone_ns = now_ns;
        p->alone = 0;
    }
    if (p->alone == ALONE)
        return;
    p->alone++;
    (void)!sendto(p->fd, data, n, 0, (const struct sockaddr *)(const void *)to, sizeof *to);
}

/* 5.5 and 11: what was sent to this address alone may have come from anywhere, and nobody elsewhere is answered. */
static bool is_neighbour(const struct announce_place *p, const struct sockaddr_in *from)
{
    uint32_t own;

    memcpy(&own, p->host.address, sizeof own);
    return from->sin_family == AF_INET && ((from->sin_addr.s_addr ^ own) & p->mask) == 0;
}

static void answer_one(struct announce_place *p, const uint8_t *datagram, size_t n,
                       const struct sockaddr_in *from, int64_t now_ns)
{
    uint8_t data[MDNS_SIZE];
    size_t bytes = 0;

    switch (mdns_answer(&p->host, datagram, n, ntohs(from->sin_port) != MDNS_PORT, data, &bytes)) {
    case MDNS_ALL:
        tell_all_again(p, data, bytes, &p->told_ns, now_ns);
        break;
    case MDNS_ALL_ELSE:
        tell_all_again(p, data, bytes, &p->else_ns, now_ns);
        break;
    case MDNS_ASKER:
        tell_one(p, data, bytes, from, now_ns);
        break;
    case MDNS_NOBODY:
        break;
    }
}

static void hear_place(struct announce_place *p, int64_t now_ns)
{
    uint8_t data[MDNS_SIZE], datagram[9000]; /* 17: the largest */

    if (p->left > 0 && now_ns - p->told_ns >= APART_NS) {
        tell_all_again(p, data, mdns_tell(&p->host, MDNS_TTL_S, data), &p->told_ns, now_ns);
        p->left--;
    }
    for (unsigned i = 0; i < AT_ONCE; i++) {
        struct sockaddr_in from = {.sin_family = AF_UNSPEC};
        socklen_t size = sizeof from;
        ssize_t n =
            recvfrom(p->fd, datagram, sizeof datagram, 0, (struct sockaddr *)(void *)&from, &size);

        if (n < 0)
            break;
        if (is_neighbour(p, &from))
            answer_one(p, datagram, (size_t)n, &from, now_ns);
    }
}

void announce_hear(struct announce *a, int64_t now_ns)
{
    for (unsigned i = 0; i < a->n; i++)
        if (a->places[i].fd >= 0)
            hear_place(&a->places[i], now_ns);
}

void announce_end(struct announce *a)
{
    uint8_t data[MDNS_SIZE];

    for (unsigned i = 0; i < a->n; i++) {
        if (a->places[i].fd >= 0)
            tell_all(&a->places[i], data, mdns_tell(&a->places[i].host, 0, data));
        close_place(&a->places[i]);
    }
}
