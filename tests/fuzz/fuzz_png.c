/* SPDX-License-Identifier: Apache-2.0 */
/*
 * PNG files, told by their first bytes: whatever follows, none of another kind gets in here. As
 * they are, and with each chunk's CRC made to hold, so that what the chunks say is read.
 */
#include <stdlib.h>
#include <string.h>
#include <zlib.h>

#include "fuzz.h"
#include "picture.h"

static const uint8_t BEGIN[] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};

static uint32_t get32(const uint8_t *at)
{
    return (uint32_t)at[0] << 24 | (uint32_t)at[1] << 16 | (uint32_t)at[2] << 8 | at[3];
}

/* Chunk by chunk: length, four letters, data, CRC of letters and data. True: one was changed. */
static bool mend(uint8_t *data, size_t size)
{
    bool changed = false;

    for (size_t at = sizeof BEGIN; size - at >= 12;) {
        size_t n = get32(data + at);
        uint32_t crc;

        if (n > size - at - 12)
            break;
        crc = (uint32_t)crc32(0, data + at + 4, (uInt)n + 4);
        at += 8 + n;
        for (int i = 0; i < 4; i++, at++) {
            changed = changed || data[at] != (uint8_t)(crc >> (24 - 8 * i));
            data[at] = (uint8_t)(crc >> (24 - 8 * i));
        }
    }
    return changed;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    uint8_t *copy;

    if (size < sizeof BEGIN || memcmp(data, BEGIN, sizeof BEGIN) != 0)
        return 0;
    fuzz_picture(data, size);
    copy = malloc(size);
    if (!copy)
        abort();
    memcpy(copy, data, size);
    if (mend(copy, size))
        fuzz_picture(copy, size);
    free(copy);
    return 0;
}
