/* SPDX-License-Identifier: Apache-2.0 */
/*
 * units.h: quantities as people write them, exactly.
 *
 * One decimal number (digits, at most one point, a sign; no exponent) and one
 * unit, with at most one space between. The value is a whole number of the
 * kind's base unit: what would have to be rounded is refused, as is what does
 * not fit 64 bits. Nothing here depends on the locale.
 */
#ifndef TTF_CONFIG_UNITS_H
#define TTF_CONFIG_UNITS_H

#include <stddef.h>
#include <stdint.h>

#include "ttf/base/attr.h"
#include "ttf/base/err.h"

enum ttf_unit_kind {
    TTF_UNIT_TIME = 0,    /* nanoseconds: ns us ms s min h d */
    TTF_UNIT_BYTES,       /* bytes: B kB MB GB TB KiB MiB GiB TiB */
    TTF_UNIT_FREQUENCY,   /* millihertz: Hz kHz */
    TTF_UNIT_SHARE,       /* parts per million: % permille ppm */
    TTF_UNIT_TEMPERATURE, /* thousandths of a degree: degC */
    TTF_UNIT_LENS,        /* milli-dioptres: dpt */
    TTF_UNIT_PIXELS,      /* px */
    TTF_UNIT_KIND_COUNT
};

/* "a time", "an amount of data", ...; and the units' names, "ns, us, ms, ...". Constant texts. */
const char *ttf_unit_meant(enum ttf_unit_kind kind);
const char *ttf_unit_list(enum ttf_unit_kind kind);

/*
 * 0 and *ret, or -EINVAL (no number, no unit, an unknown unit, not exact) or
 * -ERANGE (does not fit), with err->what saying which and err->hint what was
 * meant; err->where stays empty.
 */
TTF_MUST_USE int ttf_unit_parse(enum ttf_unit_kind kind, const char *text, int64_t *ret,
                                struct ttf_err *err);

/* The value in the largest unit that holds it as a whole number ("90s", "7d", "2GiB"). Returns buf. */
const char *ttf_unit_format(enum ttf_unit_kind kind, int64_t value, char *buf, size_t size);

/* Whole numbers without a unit, decimal. -EINVAL, -ERANGE. */
TTF_MUST_USE int ttf_integer_parse(const char *text, int64_t *ret, struct ttf_err *err);

/* Finite decimal numbers, exponent allowed; never nan, inf or hexadecimal. -EINVAL, -ERANGE. */
TTF_MUST_USE int ttf_number_parse(const char *text, double *ret, struct ttf_err *err);

/* "WxH", each 1..65535. -EINVAL. */
TTF_MUST_USE int ttf_size_parse(const char *text, uint32_t *ret_width, uint32_t *ret_height,
                                struct ttf_err *err);

/* "2026-03-01T08:00:00Z" or with an offset "+01:00" -> ns since 1970 UTC. -EINVAL, -ERANGE. */
TTF_MUST_USE int ttf_utc_parse(const char *text, int64_t *ret_utc_ns, struct ttf_err *err);

/* The reverse: "2026-03-01T08:00:00Z" (fractions of a second cut). Returns buf. */
const char *ttf_utc_format(int64_t utc_ns, char *buf, size_t size);

#endif
