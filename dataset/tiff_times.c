/* SPDX-License-Identifier: Apache-2.0 */
/* Instants as the tags of TIFF 6.0 and Exif 2.31 hold them: local time, offset, fraction of a second. */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tiff_client.h"
#include "ttf/base/checked.h"

#define DATE_SIZE   20 /* "YYYY:MM:DD HH:MM:SS" */
#define OFFSET_SIZE 7  /* "+HH:MM" */

struct civil {
    int year, month, day, hour, minute, second;
};

/* Days since 1970-01-01 of a date of the Gregorian calendar, counted in years that begin in March. */
static int64_t days_of(int year, int month, int day)
{
    int64_t y = month <= 2 ? year - 1 : year;
    int64_t era = (y >= 0 ? y : y - 399) / 400;
    int64_t year_of_era = y - era * 400;
    int64_t day_of_year = (153 * (month > 2 ? month - 3 : month + 9) + 2) / 5 + day - 1;

    return era * 146097 + year_of_era * 365 + year_of_era / 4 - year_of_era / 100 + day_of_year -
           719468;
}

static struct civil civil_of(int64_t seconds)
{
    int64_t days = seconds / 86400, rest = seconds % 86400;
    int64_t era, day_of_era, year_of_era, day_of_year, month;
    struct civil c;

    if (rest < 0) {
        rest += 86400;
        days--;
    }
    days += 719468;
    era = (days >= 0 ? days : days - 146096) / 146097;
    day_of_era = days - era * 146097;
    year_of_era = (day_of_era - day_of_era / 1460 + day_of_era / 36524 - day_of_era / 146096) / 365;
    day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    month = (5 * day_of_year + 2) / 153;
    c.day = (int)(day_of_year - (153 * month + 2) / 5 + 1);
    c.month = (int)(month < 10 ? month + 3 : month - 9);
    c.year = (int)(year_of_era + era * 400 + (c.month <= 2 ? 1 : 0));
    c.hour = (int)(rest / 3600);
    c.minute = (int)(rest / 60 % 60);
    c.second = (int)(rest % 60);
    return c;
}

static int64_t floor_div(int64_t a, int64_t b)
{
    return a / b - (a % b < 0 ? 1 : 0);
}

static void date_text(const struct ttf_tiff_times *times, char ret[DATE_SIZE])
{
    int64_t seconds = floor_div(times->start_utc_ns, TTF_NS_PER_S) + times->zone_offset_s;
    struct civil c = civil_of(seconds);
    char text[80];

    snprintf(text, sizeof(text), "%04d:%02d:%02d %02d:%02d:%02d", c.year, c.month, c.day, c.hour,
             c.minute, c.second);
    memcpy(ret, text, DATE_SIZE - 1);
    ret[DATE_SIZE - 1] = '\0';
}

bool tiff_set_date_time(TIFF *tiff, const struct ttf_tiff_times *times)
{
    char text[DATE_SIZE];

    if (times->start_utc_ns == TTF_NS_UNKNOWN)
        return true;
    date_text(times, text);
    return TIFFSetField(tiff, TIFFTAG_DATETIME, text) == 1;
}

static bool set_exif_start(TIFF *tiff, const struct ttf_tiff_times *times)
{
    int64_t whole = floor_div(times->start_utc_ns, TTF_NS_PER_S);
    int minutes = times->zone_offset_s / 60;
    unsigned fraction = (unsigned)(times->start_utc_ns - whole * TTF_NS_PER_S);
    char date[DATE_SIZE], subsec[16], offset[32];
    bool ok;

    date_text(times, date);
    snprintf(subsec, sizeof(subsec), "%09u", fraction);
    snprintf(offset, sizeof(offset), "%c%02d:%02d", minutes < 0 ? '-' : '+', abs(minutes) / 60 % 24,
             abs(minutes) % 60);
    ok = TIFFSetField(tiff, EXIFTAG_DATETIMEORIGINAL, date) == 1;
    ok &= TIFFSetField(tiff, EXIFTAG_SUBSECTIMEORIGINAL, subsec) == 1;
    ok &= TIFFSetField(tiff, EXIFTAG_OFFSETTIME, offset) == 1;
    ok &= TIFFSetField(tiff, EXIFTAG_OFFSETTIMEORIGINAL, offset) == 1;
    return ok;
}

int tiff_write_exif(struct tiff_client *client, const struct ttf_tiff_times *times, unsigned iso,
                    uint64_t *ret_offset, struct ttf_err *err)
{
    static const uint8_t version[4] = {'0', '2', '3', '1'};
    bool has_start = times->start_utc_ns != TTF_NS_UNKNOWN;
    uint16_t iso_tag = (uint16_t)(iso > 65535 ? 65535 : iso);
    uint64_t offset = 0;

    *ret_offset = 0;
    if (!has_start && times->exposure_ns <= 0 && iso == 0)
        return 0;
    if (TIFFCreateEXIFDirectory(client->tiff) != 0 ||
        TIFFSetField(client->tiff, EXIFTAG_EXIFVERSION, version) != 1)
        return tiff_client_fail(client, err, -ENOMEM, "making the EXIF folder");
    if (has_start && !set_exif_start(client->tiff, times))
        return tiff_client_fail(client, err, -EINVAL, "setting the EXIF time");
    if (times->exposure_ns > 0 &&
        TIFFSetField(client->tiff, EXIFTAG_EXPOSURETIME, (double)times->exposure_ns / 1e9) != 1)
        return tiff_client_fail(client, err, -EINVAL, "setting the exposure time");
    if (iso > 0 && TIFFSetField(client->tiff, EXIFTAG_ISOSPEEDRATINGS, 1, &iso_tag) != 1)
        return tiff_client_fail(client, err, -EINVAL, "setting the ISO number");
    if (!TIFFWriteCustomDirectory(client->tiff, &offset))
        return tiff_client_fail(client, err, -EIO, "writing the EXIF folder");
    TIFFFreeDirectory(client->tiff); /* libtiff 4.5's next call forgets what is in it */
    if (TIFFCreateDirectory(client->tiff) != 0)
        return tiff_client_fail(client, err, -ENOMEM, "beginning the image's folder");
    *ret_offset = offset;
    return 0;
}

static bool parse_date(const char *text, int64_t *ret_seconds)
{
    struct civil c;

    if (strnlen(text, DATE_SIZE) < DATE_SIZE - 1)
        return false;
    /* NOLINTNEXTLINE(cert-err34-c): each field is bounded by its width and checked below */
    if (sscanf(text, "%4d:%2d:%2d %2d:%2d:%2d", &c.year, &c.month, &c.day, &c.hour, &c.minute,
               &c.second) != 6)
        return false;
    if (c.year < 1 || c.month < 1 || c.month > 12 || c.day < 1 || c.day > 31 || c.hour < 0 ||
        c.hour > 23 || c.minute < 0 || c.minute > 59 || c.second < 0 || c.second > 60)
        return false;
    *ret_seconds =
        days_of(c.year, c.month, c.day) * 86400 + c.hour * 3600 + c.minute * 60 + c.second;
    return true;
}

/* "123" is 0.123 s. */
static int64_t parse_fraction(const char *text)
{
    int64_t ns = 0, unit = TTF_NS_PER_S / 10;

    for (; *text >= '0' && *text <= '9' && unit > 0; text++, unit /= 10)
        ns += (*text - '0') * unit;
    return ns;
}

static bool parse_offset(const char *text, int *ret_seconds)
{
    int hours, minutes;
    char sign;

    /* NOLINTNEXTLINE(cert-err34-c): bounded by width and checked below */
    if (sscanf(text, "%c%2d:%2d", &sign, &hours, &minutes) != 3 || (sign != '+' && sign != '-'))
        return false;
    if (hours < 0 || hours > 23 || minutes < 0 || minutes > 59)
        return false;
    *ret_seconds = (sign == '-' ? -1 : 1) * (hours * 3600 + minutes * 60);
    return true;
}

static bool read_zone(TIFF *tiff, int *ret_seconds)
{
    static const uint32_t tags[] = {EXIFTAG_OFFSETTIMEORIGINAL, EXIFTAG_OFFSETTIME};
    char *text = NULL;

    for (unsigned i = 0; i < TTF_COUNT_OF(tags); i++) {
        if (TIFFGetField(tiff, tags[i], &text) == 1 && text && parse_offset(text, ret_seconds))
            return true;
    }
    return false;
}

/* *seconds: of DateTime, INT64_MIN: it told none. */
static void read_exif(TIFF *tiff, int64_t *seconds, int64_t *fraction_ns,
                      struct ttf_tiff_times *ret, bool *ret_zone_known)
{
    char *text = NULL;
    double exposure_s = 0.0;
    float exposure_f = 0.0f;

    if (TIFFGetField(tiff, EXIFTAG_DATETIMEORIGINAL, &text) == 1 && text &&
        parse_date(text, seconds)) {
        if (TIFFGetField(tiff, EXIFTAG_SUBSECTIMEORIGINAL, &text) == 1 && text)
            *fraction_ns = parse_fraction(text);
    }
    if (*seconds != INT64_MIN)
        *ret_zone_known = read_zone(tiff, &ret->zone_offset_s);
    /* libtiff hands out a float or a double, whatever its table says. */
    if (TIFFFieldSetGetSize(TIFFFieldWithTag(tiff, EXIFTAG_EXPOSURETIME)) == 8) {
        if (TIFFGetField(tiff, EXIFTAG_EXPOSURETIME, &exposure_s) != 1)
            exposure_s = 0.0;
    } else if (TIFFGetField(tiff, EXIFTAG_EXPOSURETIME, &exposure_f) == 1) {
        exposure_s = (double)exposure_f;
    }
    if (exposure_s > 0.0 && exposure_s < 1e6)
        ret->exposure_ns = (int64_t)(exposure_s * 1e9 + 0.5);
}

void tiff_read_times(TIFF *tiff, struct ttf_tiff_times *ret, bool *ret_zone_known)
{
    tdir_t page = TIFFCurrentDirectory(tiff);
    int64_t seconds = INT64_MIN, fraction_ns = 0;
    uint64_t offset = 0;
    char *text = NULL;

    *ret = (struct ttf_tiff_times){.start_utc_ns = TTF_NS_UNKNOWN};
    *ret_zone_known = false;
    if (TIFFGetField(tiff, TIFFTAG_DATETIME, &text) == 1 && text)
        (void)parse_date(text, &seconds);
    if (TIFFGetField(tiff, TIFFTAG_EXIFIFD, &offset) == 1 && offset != 0) {
        if (TIFFReadEXIFDirectory(tiff, offset) == 1)
            read_exif(tiff, &seconds, &fraction_ns, ret, ret_zone_known);
        if (TIFFSetDirectory(tiff, page) != 1)
            return;
    }
    if (seconds != INT64_MIN) {
        int64_t ns;

        if (ttf_mul_i64(seconds - ret->zone_offset_s, TTF_NS_PER_S, &ns) &&
            ttf_add_i64(ns, fraction_ns, &ns))
            ret->start_utc_ns = ns;
    }
}
