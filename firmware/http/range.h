/* SPDX-License-Identifier: Apache-2.0 */
/* range.h: the text of a Range header (RFC 9110, 14.1.2), bytes, one part. */
#ifndef HTTP_RANGE_H
#define HTTP_RANGE_H

#include <stdint.h>

enum range_kind {
    RANGE_WHOLE =
        0, /* none asked for, or one that may be passed over: another unit, several parts, no sense */
    RANGE_PART,
    RANGE_OUTSIDE /* begins at or behind the end */
};

struct range {
    enum range_kind kind;
    int64_t first, bytes; /* of a part; of the whole: 0 and total */
};

/* text: the header's value, or NULL. total: bytes there are. */
struct range range_read(const char *text, int64_t total);

#endif
