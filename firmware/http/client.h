/* SPDX-License-Identifier: Apache-2.0 */
/* client.h: who counts as one client, where something is limited for each. Private to this room. */
#ifndef HTTP_CLIENT_H
#define HTTP_CLIENT_H

#include <stdbool.h>
#include <stdint.h>
#include <sys/socket.h>

#define CLIENT_BYTES 8

/* Of IPv6 a whole /64 is one client; all of a UNIX socket are one; NULL too. */
void client_of_address(const struct sockaddr *address, uint8_t ret[CLIENT_BYTES]);

bool client_is_same(const uint8_t a[CLIENT_BYTES], const uint8_t b[CLIENT_BYTES]);

#endif
