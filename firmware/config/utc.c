/* SPDX-License-Identifier: Apache-2.0 */
/* utc.c: instants as ISO 8601 text, without the C library's time zones. */
#include <errno.h>
#include <inttypes.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

#include "ttf/base/time.h"
#include "ttf/config/units.h"

/* Days from 1970-01-01 to a day of the proleptic Gregorian calendar. */
static int64_t days_of_date(int64_t year, int month, int day)
{
    /* Years that begin in March put the leap day last. */
    int64_t y = month <= 2 ? year - 1 : year;
    int64_t era = y / 400;
    int64_t of_era = y - era * 400;
    int64_t of_year = (153 * (month + (month > 2 ? -3 : 9)) + 2) / 5 + day - 1;

    return era * 146097 + of_era * 365 + of_era / 4 - of_era / 100 + of_year - 719468;
}

static int days_in_month(int year, int month)
{
    static const int DAYS[] = {31, 28, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31};
    bool leap = (year % 4 == 0 && year % 100 != 0) || year % 400 == 0;

    return month == 2 && leap ? 29 : DAYS[month - 1];
}

/* Exactly n digits at *p; moves on. -1 if they are not there. */
static int digits(const char **p, int n)
{
    int v = 0;

    for (; n; n--, (*p)++) {
        if (**p < '0' || **p > '9')
            return -1;
        v = v * 10 + (**p - '0');
    }
    return v;
}

static bool literal(const char **p, char c)
{
    if (**p != c)
        return false;
    (*p)++;
    return true;
}

int ttf_utc_parse(const char *text, int64_t *ret_utc_ns, struct ttf_err *err)
{
    const char *p = text;
    int64_t offset = 0;
    int year = digits(&p, 4);
    int month = literal(&p, '-') ? digits(&p, 2) : -1;
    int day = literal(&p, '-') ? digits(&p, 2) : -1;
    int hour = literal(&p, 'T') ? digits(&p, 2) : -1;
    int minute = literal(&p, ':') ? digits(&p, 2) : -1;
    int second = literal(&p, ':') ? digits(&p, 2) : -1;
    bool ok = year >= 1970 && year <= 2200 && month >= 1 && month <= 12 && day >= 1 &&
              day <= days_in_month(year, month) && hour >= 0 && hour <= 23 && minute >= 0 &&
              minute <= 59 && second >= 0 && second <= 59;

    if (ok && (*p == '+' || *p == '-')) {
        int sign = *p++ == '-' ? -1 : 1;
        int h = digits(&p, 2), m = literal(&p, ':') ? digits(&p, 2) : -1;

        ok = h >= 0 && h <= 14 && m >= 0 && m <= 59 && !*p;
        offset = sign * (int64_t)(h * 3600 + m * 60);
    } else {
        ok = ok && literal(&p, 'Z') && !*p;
    }
    if (!ok) {
        ttf_err_set(err, -EINVAL, NULL, "'%.60s' is not an instant", text);
        ttf_err_hint(err, "write it as 2026-03-01T08:00:00Z, or with an offset from UTC as "
                          "2026-03-01T09:00:00+01:00");
        return -EINVAL;
    }
    *ret_utc_ns =
        (days_of_date(year, month, day) * 86400 + hour * 3600 + minute * 60 + second - offset) *
        TTF_NS_PER_S;
    return 0;
}

const char *ttf_utc_format(int64_t utc_ns, char *buf, size_t size)
{
    int64_t s = utc_ns / TTF_NS_PER_S - (utc_ns % TTF_NS_PER_S < 0);
    int64_t day = s / 86400 - (s % 86400 < 0);
    int of_day = (int)(s - day * 86400);
    int64_t z = day + 719468;
    int64_t era = (z >= 0 ? z : z - 146096) / 146097;
    int64_t of_era = z - era * 146097;
    int64_t y = (of_era - of_era / 1460 + of_era / 36524 - of_era / 146096) / 365;
    int64_t of_year = of_era - (365 * y + y / 4 - y / 100);
    int64_t m = (5 * of_year + 2) / 153;
    int d = (int)(of_year - (153 * m + 2) / 5 + 1);
    int month = (int)(m < 10 ? m + 3 : m - 9);

    snprintf(buf, size, "%04" PRId64 "-%02d-%02dT%02d:%02d:%02dZ", y + era * 400 + (month <= 2),
             month, d, of_day / 3600, of_day / 60 % 60, of_day % 60);
    return buf;
}
