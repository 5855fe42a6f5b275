/* SPDX-License-Identifier: Apache-2.0 */
/*
 * checked.h: sizes from outside are multiplied and added only through these.
 *
 * Each returns true and writes *ret if the result fits, and false, leaving
 * *ret alone, if it does not. Instants are added by those that return the
 * nearest that fits: what lies beyond all clocks is compared, not shown.
 */
#ifndef TTF_BASE_CHECKED_H
#define TTF_BASE_CHECKED_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "ttf/base/attr.h"

TTF_MUST_USE static inline bool ttf_mul_size(size_t a, size_t b, size_t *ret)
{
    size_t r;

    if (__builtin_mul_overflow(a, b, &r))
        return false;
    *ret = r;
    return true;
}

TTF_MUST_USE static inline bool ttf_add_size(size_t a, size_t b, size_t *ret)
{
    size_t r;

    if (__builtin_add_overflow(a, b, &r))
        return false;
    *ret = r;
    return true;
}

TTF_MUST_USE static inline bool ttf_mul_i64(int64_t a, int64_t b, int64_t *ret)
{
    int64_t r;

    if (__builtin_mul_overflow(a, b, &r))
        return false;
    *ret = r;
    return true;
}

TTF_MUST_USE static inline bool ttf_add_i64(int64_t a, int64_t b, int64_t *ret)
{
    int64_t r;

    if (__builtin_add_overflow(a, b, &r))
        return false;
    *ret = r;
    return true;
}

/* Never INT64_MIN, which stands for an instant that is not known (TTF_NS_UNKNOWN). */
TTF_MUST_USE static inline int64_t ttf_near_sum_i64(int64_t a, int64_t b)
{
    int64_t r;

    if (__builtin_add_overflow(a, b, &r))
        return a < 0 ? -INT64_MAX : INT64_MAX;
    return r < -INT64_MAX ? -INT64_MAX : r;
}

TTF_MUST_USE static inline int64_t ttf_near_difference_i64(int64_t a, int64_t b)
{
    int64_t r;

    if (__builtin_sub_overflow(a, b, &r))
        return a < 0 ? -INT64_MAX : INT64_MAX;
    return r < -INT64_MAX ? -INT64_MAX : r;
}

#endif
