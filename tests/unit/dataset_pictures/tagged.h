/* SPDX-License-Identifier: Apache-2.0 */
/* tagged.h: TIFF files made tag by tag, little-endian, with one directory: what no library would write. */
#ifndef TAGGED_H
#define TAGGED_H

#include <stdint.h>

struct tag {
    uint16_t tag, type; /* 1: 8 bits, 3: 16, 4: 32 */
    uint32_t n, value;  /* in the entry itself, or where it lies */
};

#define TAG_ABSENT UINT32_MAX /* as a value: the tag is left out */

/* So many bytes of a value, the lowest first. */
void tagged_put(uint8_t *at, uint32_t value, unsigned bytes);

/* A file's head and directory: these tags, in their order, of which up to two are changed into a and b. */
void tagged_head(uint8_t *file, const struct tag *tags, unsigned n, struct tag a, struct tag b);

#endif
