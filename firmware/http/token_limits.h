/* SPDX-License-Identifier: Apache-2.0 */
/* token_limits.h: how many wrong tokens an address may send: 10 at once, and one more each 3 s. Any thread. */
#ifndef HTTP_TOKEN_LIMITS_H
#define HTTP_TOKEN_LIMITS_H

#include <stdbool.h>
#include <stdint.h>
#include <sys/socket.h>

#include "ttf/hal/clock.h"

#define LIMITS_AT_ONCE 10
#define LIMITS_ONE_NS  (3 * TTF_NS_PER_S)

struct limits;

struct limits *limits_create(struct ttf_clock *clock); /* NULL: no memory */
void limits_destroy(struct limits *limits);            /* NULL allowed */

/* May this client (client.h) send a wrong one? Asked once it is known to be wrong: whoever brings the right one never suffers from others. */
bool limits_allow(struct limits *limits, const struct sockaddr *client);

/* One was wrong. */
void limits_wrong(struct limits *limits, const struct sockaddr *client);

#endif
