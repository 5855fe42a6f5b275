/* SPDX-License-Identifier: Apache-2.0 */
#include "tagged.h"

#include <string.h>

void tagged_put(uint8_t *at, uint32_t value, unsigned bytes)
{
    for (unsigned i = 0; i < bytes; i++)
        at[i] = (uint8_t)(value >> 8 * i);
}

void tagged_head(uint8_t *file, const struct tag *tags, unsigned n, struct tag a, struct tag b)
{
    unsigned entries = 0;

    memcpy(file, "II*", 4);
    tagged_put(file + 4, 8, 4);
    for (unsigned i = 0; i < n; i++) {
        struct tag tag = tags[i].tag == a.tag ? a : tags[i].tag == b.tag ? b : tags[i];
        uint8_t *entry = file + 10 + entries * 12;

        if (tag.value == TAG_ABSENT)
            continue;
        tagged_put(entry, tag.tag, 2);
        tagged_put(entry + 2, tag.type, 2);
        tagged_put(entry + 4, tag.n, 4);
        tagged_put(entry + 8, tag.value, 4);
        entries++;
    }
    tagged_put(file + 8, entries, 2);
}
