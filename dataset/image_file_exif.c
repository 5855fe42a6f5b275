/* SPDX-License-Identifier: Apache-2.0 */
/* image_file_exif.c: orientation and times from an EXIF block (EXIF 2.32, 4.6); times in names. */
#include <ctype.h>
#include <string.h>

#include "image_file_codecs.h"

enum {
    TAG_ORIENTATION = 0x0112,
    TAG_DATE_TIME = 0x0132,
    TAG_EXIF_FOLDER = 0x8769,
    TAG_DATE_TIME_ORIGINAL = 0x9003,
    TAG_OFFSET_TIME = 0x9010,
    TAG_OFFSET_TIME_ORIGINAL = 0x9011,
    TAG_SUB_SECONDS_ORIGINAL = 0x9291
};

enum {
    TYPE_ASCII = 2,
    TYPE_SHORT = 3,
    TYPE_LONG = 4
};

struct exif_block {
    const uint8_t *data;
    size_t n;
    bool big_endian;
};

/* Texts as found; empty if absent. */
struct exif_texts {
    char date_time[24], original[24];
    char offset[8], offset_original[8];
    char sub_seconds[12];
    unsigned orientation;
    uint32_t exif_folder;
};

static uint32_t read_u16(const struct exif_block *block, size_t at)
{
    const uint8_t *p = block->data + at;

    if (at > block->n || block->n - at < 2)
        return 0;
    return block->big_endian ? (uint32_t)(p[0] << 8 | p[1]) : (uint32_t)(p[1] << 8 | p[0]);
}

static uint32_t read_u32(const struct exif_block *block, size_t at)
{
    uint32_t a = read_u16(block, at), b = read_u16(block, at + 2);

    return block->big_endian ? a << 16 | b : b << 16 | a;
}

/* An entry's text: of up to four bytes in the entry itself, else at an offset. */
static void read_text(const struct exif_block *block, size_t entry, char *ret, size_t size)
{
    uint32_t n = read_u32(block, entry + 4);
    size_t at = n <= 4 ? entry + 8 : read_u32(block, entry + 8);

    if (at > block->n || block->n - at < n)
        return;
    if (n > size - 1)
        n = (uint32_t)size - 1;
    memcpy(ret, block->data + at, n);
    ret[n] = 0;
}

static void read_entry(const struct exif_block *block, size_t entry, struct exif_texts *texts)
{
    uint32_t tag = read_u16(block, entry), type = read_u16(block, entry + 2);

    if (tag == TAG_ORIENTATION && type == TYPE_SHORT)
        texts->orientation = read_u16(block, entry + 8);
    else if (tag == TAG_EXIF_FOLDER && type == TYPE_LONG)
        texts->exif_folder = read_u32(block, entry + 8);
    else if (type != TYPE_ASCII)
        return;
    else if (tag == TAG_DATE_TIME)
        read_text(block, entry, texts->date_time, sizeof(texts->date_time));
    else if (tag == TAG_DATE_TIME_ORIGINAL)
        read_text(block, entry, texts->original, sizeof(texts->original));
    else if (tag == TAG_OFFSET_TIME)
        read_text(block, entry, texts->offset, sizeof(texts->offset));
    else if (tag == TAG_OFFSET_TIME_ORIGINAL)
        read_text(block, entry, texts->offset_original, sizeof(texts->offset_original));
    else if (tag == TAG_SUB_SECONDS_ORIGINAL)
        read_text(block, entry, texts->sub_seconds, sizeof(texts->sub_seconds));
}

static void read_folder(const struct exif_block *block, size_t at, struct exif_texts *texts)
{
    uint32_t n = read_u16(block, at);

    for (uint32_t i = 0; i < n; i++) {
        size_t entry = at + 2 + (size_t)i * 12;

        if (entry > block->n || block->n - entry < 12)
            return;
        read_entry(block, entry, texts);
    }
}

bool days_of_date(int year, int month, int day, int64_t *ret)
{
    static const int length[12] = {31, 28, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31};
    bool leap = year % 4 == 0 && (year % 100 != 0 || year % 400 == 0);
    int64_t days = 0;

    if (year < 1900 || year > 2199 || month < 1 || month > 12 || day < 1 ||
        day > length[month - 1] + (month == 2 && leap))
        return false;
    for (int y = 1970; y < year; y++)
        days += 365 + (y % 4 == 0 && (y % 100 != 0 || y % 400 == 0));
    for (int y = year; y < 1970; y++)
        days -= 365 + (y % 4 == 0 && (y % 100 != 0 || y % 400 == 0));
    for (int m = 1; m < month; m++)
        days += length[m - 1] + (m == 2 && leap);
    *ret = days + day - 1;
    return true;
}

/* n digits at *text, which moves on; -1 if there are fewer. */
static int take_digits(const char **text, int n)
{
    int value = 0;

    for (int i = 0; i < n; i++, (*text)++) {
        if (!isdigit((unsigned char)**text))
            return -1;
        value = value * 10 + (**text - '0');
    }
    return value;
}

/*
 * A time after a pattern: Y four digits, y two digits, M D h m s two each, '?' at most
 * one separator, '_' exactly one; nothing else. *text moves past it.
 */
static bool take_time(const char **text, const char *pattern, int64_t *ret_ns)
{
    int year = 0, month = 0, day = 0, hour = 0, minute = 0, second = 0, *field;
    const char *p = *text;
    int64_t days;

    for (; *pattern; pattern++) {
        if (*pattern == '?' || *pattern == '_') {
            if (*p && strchr("-_.:T ", *p))
                p++;
            else if (*pattern == '_')
                return false;
            continue;
        }
        field = *pattern == 'M'   ? &month
                : *pattern == 'D' ? &day
                : *pattern == 'h' ? &hour
                : *pattern == 'm' ? &minute
                : *pattern == 's' ? &second
                                  : &year;
        *field = take_digits(&p, *pattern == 'Y' ? 4 : 2);
        if (*field < 0)
            return false;
        if (*pattern == 'y')
            year += year < 70 ? 2000 : 1900;
    }
    if (isdigit((unsigned char)*p) || hour > 23 || minute > 59 || second > 60 ||
        !days_of_date(year, month, day, &days))
        return false;
    *ret_ns = days * TTF_NS_PER_DAY + hour * TTF_NS_PER_H + minute * TTF_NS_PER_MIN +
              second * TTF_NS_PER_S;
    *text = p;
    return true;
}

/* "+02:00", "-0330" or "Z". */
static bool take_zone(const char *text, int *ret_s)
{
    int sign = *text == '-' ? -1 : 1, hours, minutes;

    if (*text == 'Z') {
        *ret_s = 0;
        return true;
    }
    if (*text != '+' && *text != '-')
        return false;
    text++;
    hours = take_digits(&text, 2);
    if (*text == ':')
        text++;
    minutes = take_digits(&text, 2);
    if (hours < 0 || hours > 14 || minutes < 0 || minutes > 59)
        return false;
    *ret_s = sign * (hours * 3600 + minutes * 60);
    return true;
}

static int64_t sub_seconds_ns(const char *text)
{
    int64_t ns = 0, digit = TTF_NS_PER_S / 10;

    for (; isdigit((unsigned char)*text) && digit > 0; text++, digit /= 10)
        ns += (*text - '0') * digit;
    return ns;
}

void exif_read(const uint8_t *data, size_t n, struct ttf_image_info *info)
{
    struct exif_block block = {.data = data, .n = n};
    struct exif_texts texts = {0};
    const char *text;
    bool original;

    if (n < 8 || (memcmp(data, "II*\0", 4) != 0 && memcmp(data, "MM\0*", 4) != 0))
        return;
    block.big_endian = data[0] == 'M';
    read_folder(&block, read_u32(&block, 4), &texts);
    if (texts.exif_folder)
        read_folder(&block, texts.exif_folder, &texts);
    if (texts.orientation >= 1 && texts.orientation <= 8)
        info->orientation = texts.orientation;
    /* Cameras whose clock is not set write blanks or zeros there. */
    text = texts.original;
    original = take_time(&text, "Y?M?D?h?m?s", &info->taken_utc_ns);
    text = texts.date_time;
    if (!original && !take_time(&text, "Y?M?D?h?m?s", &info->taken_utc_ns))
        return;
    if (original)
        info->taken_utc_ns += sub_seconds_ns(texts.sub_seconds);
    info->zone_known = take_zone(texts.offset_original, &info->zone_offset_s) ||
                       take_zone(texts.offset, &info->zone_offset_s);
    if (info->zone_known)
        info->taken_utc_ns -= info->zone_offset_s * TTF_NS_PER_S;
}

int64_t ttf_time_in_name(const char *name)
{
    /* Longest first, so that seconds are not left behind. */
    static const char *const patterns[] = {"Y?M?D?h?m?s", "Y?M?D?h?m", "yMD_hms"};
    int64_t ns;

    for (size_t i = 0; i < sizeof(patterns) / sizeof(patterns[0]); i++) {
        for (const char *at = name; *at; at++) {
            const char *text = at;

            if (at > name && isdigit((unsigned char)at[-1]))
                continue;
            if (take_time(&text, patterns[i], &ns))
                return ns;
        }
    }
    return TTF_NS_UNKNOWN;
}
