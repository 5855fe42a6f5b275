/* SPDX-License-Identifier: Apache-2.0 */
#include "range.h"

#include <string.h>

/* Digits at *text, which then points behind them; -1: there is none. What is too large for 63 bits counts as the largest. */
static int64_t take_number(const char **text)
{
    const char *p = *text;
    int64_t value = 0;

    if (*p < '0' || *p > '9')
        return -1;
    for (; *p >= '0' && *p <= '9'; p++)
        if (__builtin_mul_overflow(value, (int64_t)10, &value) ||
            __builtin_add_overflow(value, (int64_t)(*p - '0'), &value))
            value = INT64_MAX;
    *text = p;
    return value;
}

struct range range_read(const char *text, int64_t total)
{
    struct range whole = {RANGE_WHOLE, 0, total};
    int64_t first, last;

    if (!text || strncmp(text, "bytes=", 6) != 0)
        return whole;
    text += 6;
    first = take_number(&text);
    if (*text++ != '-')
        return whole;
    last = take_number(&text);
    if (*text != '\0' || (first < 0 && last < 0) || (first >= 0 && last >= 0 && last < first))
        return whole;
    if (first < 0) { /* the last so many bytes */
        if (last == 0)
            return (struct range){RANGE_OUTSIDE, 0, 0};
        if (total == 0)
            return whole; /* all of nothing, which is no error (RFC 9110, 14.1.2) */
        first = last < total ? total - last : 0;
        last = -1;
    }
    if (first >= total)
        return (struct range){RANGE_OUTSIDE, 0, 0};
    if (last < 0 || last >= total)
        last = total - 1;
    return (struct range){RANGE_PART, first, last - first + 1};
}
