/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A datagram of multicast DNS, behind a byte whose lowest bit says whether it came from one who knows plain DNS alone. Whatever it holds,
 * what is answered fits, is an answer of one record at least about the box's name, and asks for nothing itself.
 */
#include <stdlib.h>
#include <string.h>

#include "fuzz.h"
#include "mdns.h"

static const struct mdns_host HOST = {.name = "ttfbox-0007", .address = {10, 60, 7, 1}};

static const uint8_t NAME[] = "\x0bttfbox-0007\x05local";

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    uint8_t answer[MDNS_SIZE], again[MDNS_SIZE], *copy;
    bool legacy = size > 0 && data[0] & 1;
    size_t n = 0;
    enum mdns_to to;

    if (size == 0)
        return 0;
    /* Of exactly that size, so that a read beyond its end is seen. */
    copy = malloc(size - 1 ? size - 1 : 1);
    if (!copy)
        return 0;
    memcpy(copy, data + 1, size - 1);
    to = mdns_answer(&HOST, copy, size - 1, legacy, answer, &n);
    free(copy);
    if (to == MDNS_NOBODY)
        return 0;
    if (n > sizeof answer || n < 12 + sizeof NAME || !(answer[2] & 0x80) || answer[7] != 1 ||
        memcmp(answer + 12, NAME, sizeof NAME) != 0)
        abort();
    if (legacy && to != MDNS_ASKER)
        abort();
    /* Two boxes that hear each other say nothing more. */
    if (mdns_answer(&HOST, answer, n, false, again, &n) != MDNS_NOBODY)
        abort();
    return 0;
}
