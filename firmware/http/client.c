/* SPDX-License-Identifier: Apache-2.0 */
#include "client.h"

#include <netinet/in.h>
#include <string.h>

void client_of_address(const struct sockaddr *address, uint8_t ret[CLIENT_BYTES])
{
    struct sockaddr_in v4;
    struct sockaddr_in6 v6;

    memset(ret, 0, CLIENT_BYTES);
    if (address && address->sa_family == AF_INET) {
        memcpy(&v4, address, sizeof v4);
        ret[0] = 4;
        memcpy(ret + 4, &v4.sin_addr, 4);
    } else if (address && address->sa_family == AF_INET6) {
        memcpy(&v6, address, sizeof v6);
        memcpy(ret, &v6.sin6_addr, CLIENT_BYTES);
    }
}

bool client_is_same(const uint8_t a[CLIENT_BYTES], const uint8_t b[CLIENT_BYTES])
{
    return memcmp(a, b, CLIENT_BYTES) == 0;
}
