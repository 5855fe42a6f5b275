/* SPDX-License-Identifier: Apache-2.0 */
/*
 * mdns.h: one name of one address in multicast DNS (RFC 6762), as bytes: what is answered to a datagram, and what is told unasked. No I/O,
 * no time. Whoever reads these datagrams is on the same network, and may have written anything into them.
 */
#ifndef DAEMON_MDNS_H
#define DAEMON_MDNS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "ttf/base/attr.h"

#define MDNS_PORT  5353
#define MDNS_GROUP 0xe00000fbU /* 224.0.0.251 */
#define MDNS_SIZE  256         /* of what is sent, at most */
#define MDNS_TTL_S 120         /* RFC 6762, section 10: of names of machines */

struct mdns_host {
    const char *name; /* without ".local": mdns_is_name */
    uint8_t address[4];
};

enum mdns_to {
    MDNS_NOBODY = 0, /* it is not about this name, or no question, or known to who asks */
    MDNS_ALL,        /* the group */
    MDNS_ALL_ELSE,   /* it as well, but the address, which who asks knows, is not in it */
    MDNS_ASKER       /* it alone */
};

/* 1 to 63 letters, digits and '-'. */
bool mdns_is_name(const char *name);

/* legacy: it came from another port than MDNS_PORT, from one who knows plain DNS alone. *ret_n: of ret; only where somebody is to get it. */
TTF_MUST_USE enum mdns_to mdns_answer(const struct mdns_host *host, const uint8_t *datagram,
                                      size_t n, bool legacy, uint8_t ret[MDNS_SIZE], size_t *ret_n);

/* Told to all, unasked; ttl_s 0: that it is the name's address no more. Its length. */
size_t mdns_tell(const struct mdns_host *host, uint32_t ttl_s, uint8_t ret[MDNS_SIZE]);

#endif
