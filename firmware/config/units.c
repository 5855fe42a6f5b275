/* SPDX-License-Identifier: Apache-2.0 */
/* units.c: exact quantities; see units.h. */
#include "ttf/config/units.h"

#include <ctype.h>
#include <errno.h>
#include <inttypes.h>
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ttf/base/checked.h"
#include "ttf/base/time.h"

struct unit {
    const char *name;
    int64_t factor; /* base units */
};

/* Largest first within a kind: ttf_unit_format takes the first that divides. */
static const struct unit TIME[] = {{"d", TTF_NS_PER_DAY},
                                   {"h", TTF_NS_PER_H},
                                   {"min", TTF_NS_PER_MIN},
                                   {"s", TTF_NS_PER_S},
                                   {"ms", TTF_NS_PER_MS},
                                   {"us", TTF_NS_PER_US},
                                   {"ns", 1},
                                   {NULL, 0}};
static const struct unit BYTES[] = {{"TiB", INT64_C(1) << 40},
                                    {"TB", INT64_C(1000000000000)},
                                    {"GiB", INT64_C(1) << 30},
                                    {"GB", INT64_C(1000000000)},
                                    {"MiB", INT64_C(1) << 20},
                                    {"MB", INT64_C(1000000)},
                                    {"KiB", INT64_C(1) << 10},
                                    {"kB", INT64_C(1000)},
                                    {"B", 1},
                                    {NULL, 0}};
static const struct unit FREQUENCY[] = {{"kHz", 1000000}, {"Hz", 1000}, {"mHz", 1}, {NULL, 0}};
static const struct unit SHARE[] = {{"%", 10000}, {"permille", 1000}, {"ppm", 1}, {NULL, 0}};
static const struct unit TEMPERATURE[] = {{"degC", 1000}, {"mdegC", 1}, {NULL, 0}};
static const struct unit LENS[] = {{"dpt", 1000}, {"mdpt", 1}, {NULL, 0}};
static const struct unit PIXELS[] = {{"px", 1}, {NULL, 0}};

static const struct {
    const struct unit *units;
    const char *meant, *list, *example;
    unsigned typical; /* index of the unit that is most likely meant */
} KINDS[TTF_UNIT_KIND_COUNT] = {
    [TTF_UNIT_TIME] = {TIME, "a time", "ns, us, ms, s, min, h, d", "10min", 3},
    [TTF_UNIT_BYTES] = {BYTES, "an amount of data", "B, kB, MB, GB, TB, KiB, MiB, GiB, TiB", "2GiB",
                        2},
    [TTF_UNIT_FREQUENCY] = {FREQUENCY, "a frequency", "mHz, Hz, kHz", "50Hz", 1},
    [TTF_UNIT_SHARE] = {SHARE, "a share", "%, permille, ppm", "80%", 0},
    [TTF_UNIT_TEMPERATURE] = {TEMPERATURE, "a temperature", "degC, mdegC", "45degC", 0},
    [TTF_UNIT_LENS] = {LENS, "a lens position", "dpt, mdpt", "2.5dpt", 0},
    [TTF_UNIT_PIXELS] = {PIXELS, "a number of pixels", "px", "640px", 0},
};

const char *ttf_unit_meant(enum ttf_unit_kind kind)
{
    return KINDS[kind].meant;
}

const char *ttf_unit_list(enum ttf_unit_kind kind)
{
    return KINDS[kind].list;
}

/* A decimal number taken apart: value = (negative ? -1 : 1) * digits / 10^decimals. */
struct decimal {
    bool negative;
    int64_t digits;
    unsigned decimals;
};

/* Reads a decimal from the start of text; returns its end, or NULL (*ret_code says why). */
static const char *read_decimal(const char *text, struct decimal *ret, int *ret_code)
{
    struct decimal d = {0};
    bool any = false, point = false;
    unsigned zeros = 0; /* after the point, not yet known to matter */

    if (*text == '-' || *text == '+')
        d.negative = *text++ == '-';
    for (;; text++) {
        if (*text == '.' && !point) {
            point = true;
            continue;
        }
        if (*text < '0' || *text > '9')
            break;
        any = true;
        if (point && *text == '0') {
            zeros++;
            continue;
        }
        unsigned shift = point ? zeros + 1 : 1;

        d.decimals += point ? shift : 0;
        zeros = 0;
        for (; shift; shift--) {
            if (!ttf_mul_i64(d.digits, 10, &d.digits)) {
                *ret_code = -ERANGE;
                return NULL;
            }
        }
        if (!ttf_add_i64(d.digits, *text - '0', &d.digits)) {
            *ret_code = -ERANGE;
            return NULL;
        }
    }
    *ret_code = -EINVAL;
    if (!any)
        return NULL;
    *ret = d;
    return text;
}

/* digits * factor / 10^decimals, exactly. */
static int scale(const struct decimal *d, int64_t factor, int64_t *ret)
{
    int64_t digits = d->digits;
    unsigned twos = d->decimals, fives = d->decimals;

    for (; twos && factor % 2 == 0; twos--)
        factor /= 2;
    for (; fives && factor % 5 == 0; fives--)
        factor /= 5;
    for (; twos && digits % 2 == 0; twos--)
        digits /= 2;
    for (; fives && digits % 5 == 0; fives--)
        digits /= 5;
    if (digits && (twos || fives))
        return -EDOM;
    if (!ttf_mul_i64(digits, factor, &digits))
        return -ERANGE;
    *ret = d->negative ? -digits : digits;
    return 0;
}

static int no_number(const char *text, const char *meant, const char *example, struct ttf_err *err)
{
    if (!*text)
        ttf_err_set(err, -EINVAL, NULL, "has no value");
    else
        ttf_err_set(err, -EINVAL, NULL, "'%.60s' is not %s", text, meant);
    return ttf_err_hint(err, "write %s as in %s", meant, example), -EINVAL;
}

/* Far beyond 64 bits even in the smallest unit, or beyond them after scaling. */
static int too_large(const char *text, struct ttf_err *err)
{
    ttf_err_set(err, -ERANGE, NULL, "'%.60s' is far too large", text);
    ttf_err_hint(err, "a value must fit 64 bits");
    return -ERANGE;
}

/* A hint is followed to the letter: where two units are as likely, both stand there. */
static void hint_unit(enum ttf_unit_kind kind, const char *text, const struct decimal *d,
                      struct ttf_err *err)
{
    const char *unit = KINDS[kind].units[KINDS[kind].typical].name;
    double value = (double)d->digits / pow(10, d->decimals);

    if (kind == TTF_UNIT_TIME)
        ttf_err_hint(err, "%s is meant: write %.20s%s, %.20sms or %.20smin, one of %s",
                     KINDS[kind].meant, text, unit, text, text, KINDS[kind].list);
    else if (kind == TTF_UNIT_SHARE && d->decimals > 0 && value < 1)
        ttf_err_hint(err, "%s is meant: write %.6g%s, or %.20s%s if it is that little, one of %s",
                     KINDS[kind].meant, value * 100, unit, text, unit, KINDS[kind].list);
    else
        ttf_err_hint(err, "%s is meant: write %.40s%s, one of %s", KINDS[kind].meant, text, unit,
                     KINDS[kind].list);
}

int ttf_unit_parse(enum ttf_unit_kind kind, const char *text, int64_t *ret, struct ttf_err *err)
{
    struct decimal d;
    int r;
    const char *rest = read_decimal(text, &d, &r);

    if (!rest) {
        if (r == -ERANGE)
            return too_large(text, err);
        return no_number(text, KINDS[kind].meant, KINDS[kind].example, err);
    }
    if (*rest == ' ')
        rest++;
    if (!*rest) {
        ttf_err_set(err, -EINVAL, NULL, "'%.60s' has no unit", text);
        hint_unit(kind, text, &d, err);
        return -EINVAL;
    }
    for (const struct unit *u = KINDS[kind].units; u->name; u++) {
        if (strcmp(u->name, rest) != 0)
            continue;
        r = scale(&d, u->factor, ret);
        if (r == -ERANGE)
            return too_large(text, err);
        if (r == -EDOM) {
            ttf_err_set(err, -EINVAL, NULL, "'%.60s' is finer than can be kept", text);
            ttf_err_hint(err, "the finest of its units are %s", KINDS[kind].list);
            return -EINVAL;
        }
        return 0;
    }
    if (isalpha((unsigned char)*rest) || *rest == '%')
        ttf_err_set(err, -EINVAL, NULL, "'%.60s': '%.40s' is no unit of %s", text, rest,
                    KINDS[kind].meant + 2);
    else
        return no_number(text, KINDS[kind].meant, KINDS[kind].example, err);
    ttf_err_hint(err, "%s is meant, in one of %s", KINDS[kind].meant, KINDS[kind].list);
    return -EINVAL;
}

const char *ttf_unit_format(enum ttf_unit_kind kind, int64_t value, char *buf, size_t size)
{
    const struct unit *u = KINDS[kind].units;

    if (value == 0)
        u += KINDS[kind].typical;
    while (u[1].name && value % u->factor != 0)
        u++;
    snprintf(buf, size, "%" PRId64 "%s", value / u->factor, u->name);
    return buf;
}

int ttf_integer_parse(const char *text, int64_t *ret, struct ttf_err *err)
{
    struct decimal d;
    int r;
    const char *rest = read_decimal(text, &d, &r);

    if (!rest && r == -ERANGE)
        return too_large(text, err);
    if (!rest || *rest || strchr(text, '.'))
        return no_number(text, "a whole number", "12", err);
    *ret = d.negative ? -d.digits : d.digits;
    return 0;
}

int ttf_number_parse(const char *text, double *ret, struct ttf_err *err)
{
    const char *p = text;
    bool any = false;

    if (*p == '-' || *p == '+')
        p++;
    for (; isdigit((unsigned char)*p); p++)
        any = true;
    if (*p == '.')
        for (p++; isdigit((unsigned char)*p); p++)
            any = true;
    if (any && (*p == 'e' || *p == 'E')) {
        p++;
        if (*p == '-' || *p == '+')
            p++;
        any = isdigit((unsigned char)*p);
        while (isdigit((unsigned char)*p))
            p++;
    }
    if (!any || *p)
        return no_number(text, "a number", "0.25", err);
    double v = strtod(text, NULL);

    if (!isfinite(v))
        return too_large(text, err);
    *ret = v;
    return 0;
}

int ttf_size_parse(const char *text, uint32_t *ret_width, uint32_t *ret_height, struct ttf_err *err)
{
    uint32_t v[2] = {0, 0};
    const char *p = text;

    for (unsigned i = 0; i < 2; i++) {
        unsigned digits = 0;

        for (; isdigit((unsigned char)*p) && digits < 5; p++, digits++)
            v[i] = v[i] * 10 + (uint32_t)(*p - '0');
        if (!digits || v[i] < 1 || v[i] > 65535 || *p != (i == 0 ? 'x' : '\0'))
            return no_number(text, "a size in pixels", "512x512", err);
        p++;
    }
    *ret_width = v[0];
    *ret_height = v[1];
    return 0;
}
