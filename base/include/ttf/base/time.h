/* SPDX-License-Identifier: Apache-2.0 */
/*
 * time.h: the one time type of the tree.
 *
 * Every instant and every duration is an int64_t number of nanoseconds, and its
 * name ends in `_ns`. Instants are of one of two kinds, told apart by name:
 *
 *   xxx_ns      on the boot clock: starts near 0 at boot, never steps, counts
 *               through suspend (CLOCK_BOOTTIME);
 *   xxx_utc_ns  nanoseconds since 1970-01-01T00:00:00Z, leap seconds smeared
 *               away as POSIX does.
 *
 * Instants come only from a `struct ttf_clock` (hal). Nothing below reads one.
 */
#ifndef TTF_BASE_TIME_H
#define TTF_BASE_TIME_H

#include <stdint.h>

#define TTF_NS_PER_US  INT64_C(1000)
#define TTF_NS_PER_MS  INT64_C(1000000)
#define TTF_NS_PER_S   INT64_C(1000000000)
#define TTF_NS_PER_MIN (60 * TTF_NS_PER_S)
#define TTF_NS_PER_H   (3600 * TTF_NS_PER_S)
#define TTF_NS_PER_DAY (24 * TTF_NS_PER_H)

/* "Never": a deadline that does not come. */
#define TTF_NS_NEVER INT64_MAX

/* "Not known": an instant or duration that nobody measured. */
#define TTF_NS_UNKNOWN INT64_MIN

#endif
