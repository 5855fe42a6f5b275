/* SPDX-License-Identifier: Apache-2.0 */
/* token_limits.h: how many wrong tokens an address may send: 10 at once, and one more each 3 s. Any thread. */
#ifndef HTTP_TOKEN_LIMITS_H
#define HTTP_TOKEN_LIMITS_H

#include <stdbool.h>
#include <stdint.h>
#include <sys/socket.h>

#include "ttf/base/attr.h"
#include "ttf/hal/clock.h"

#define LIMITS_AT_ONCE 10
#define LIMITS_ONE_NS  (3 * TTF_NS_PER_S)

struct limits;

struct limits *limits_create(struct ttf_clock *clock); /* NULL: no memory */
void limits_destroy(struct limits *limits);            /* NULL allowed */

/* One of this client (client.h) was wrong: counted. false: too many were, and this one counts no more. Whoever brings the right one is
 * not asked about, and never suffers from others. */
TTF_MUST_USE bool limits_wrong(struct limits *limits, const struct sockaddr *client);

#endif
