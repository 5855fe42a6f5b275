/* SPDX-License-Identifier: Apache-2.0 */
#include "lines_cut.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <zlib.h>

#include "lines.h"
#include "ttf/dataset/hash.h"
#include "ttf/dataset/json_parse.h"

#define LINE_LEAST 37 /* {"type":"x","seq":0,"crc":"01234567"} */

size_t ttf_line_whole_in(const char *text, size_t n)
{
    static const char mark[] = ",\"crc\":\"";
    const char *at = text, *hit;
    size_t end;

    while ((hit = memmem(at, n - (size_t)(at - text), mark, sizeof(mark) - 1)) != NULL) {
        end = (size_t)(hit - text) + TTF_LINE_TAIL;
        if (end <= n && ttf_line_holds(text, end))
            return end;
        at = hit + 1;
    }
    return 0;
}

/* By how many bits texts of the same length differ; more than 1 count as 2. */
static unsigned bits_between(const char *a, const char *b, size_t n)
{
    unsigned bits = 0;

    for (size_t i = 0; i < n && bits < 2; i++)
        bits += (unsigned)__builtin_popcount((unsigned char)(a[i] ^ b[i]));
    return bits < 2 ? bits : 2;
}

/* Is there a bit of n bytes that changes their crc by just this? Behind a bit come zeros: how they carry it on is known. */
static bool one_bit_does(uint32_t difference, size_t n)
{
    const z_crc_t *table = get_crc_table();
    uint32_t of[8];
    unsigned bit;

    for (bit = 0; bit < 8; bit++)
        of[bit] = (uint32_t)table[1u << bit];
    for (; n > 0; n--)
        for (bit = 0; bit < 8; bit++) {
            if (of[bit] == difference)
                return true;
            of[bit] = of[bit] >> 8 ^ (uint32_t)table[of[bit] & 0xff];
        }
    return false;
}

bool ttf_line_nearly_holds(const char *line, size_t n)
{
    char due[TTF_LINE_TAIL + 1], digits[9];
    const char *tail;
    uint32_t crc;
    char *end;

    if (n <= TTF_LINE_TAIL)
        return false;
    n -= TTF_LINE_TAIL;
    tail = line + n;
    crc = ttf_crc32(0, line, n);
    snprintf(due, sizeof(due), ",\"crc\":\"%08x\"}", crc);
    if (bits_between(tail, due, TTF_LINE_TAIL) == 1)
        return true;
    memcpy(digits, tail + 8, 8);
    digits[8] = '\0';
    crc ^= (uint32_t)strtoul(digits, &end, 16);
    return end == digits + 8 && memcmp(tail, due, 8) == 0 &&
           memcmp(tail + 16, due + 16, TTF_LINE_TAIL - 16) == 0 && one_bit_does(crc, n);
}

/* A whole line at `at` that may be one of the file's own, behind the one due: 1; 0; -ENOMEM. */
static int is_own(const char *text, size_t at, size_t n, int64_t due_seq)
{
    size_t whole = n > at ? ttf_line_whole_in(text + at, n - at) : 0;
    const json_t *seq;
    json_t *json;
    int64_t number;
    int r;

    if (whole == 0)
        return 0;
    r = ttf_json_parse(text + at, whole, &json, NULL);
    if (r)
        return r == -ENOMEM ? r : 1;
    seq = json_object_get(json, "seq");
    number = json_is_integer(seq) ? json_integer_value(seq) : due_seq;
    json_decref(json);
    /* So many lines there is room for before it. Of an old block another file's lines may be whole as well. */
    return number >= due_seq && number <= due_seq + (int64_t)(at / LINE_LEAST) + 1;
}

/* What a cut cannot have left: a line of ours, one that has a wrong bit, a newline that came last, as newlines do. */
static int may_be_lines(const char *text, size_t n, int64_t due_seq)
{
    const char *lf = memchr(text, '\n', n), *next;
    size_t at;
    int r;

    if (!lf || text[n - 1] == '\n' || ttf_line_nearly_holds(text, (size_t)(lf - text)))
        return 1;
    next = memchr(lf + 1, '\n', n - (size_t)(lf + 1 - text));
    /* the newline is the bit */
    if (next && ttf_line_nearly_holds(text, (size_t)(next - text)))
        return 1;
    /* the newline before it has changed */
    r = is_own(text, 1, n, due_seq);
    for (; r == 0 && lf; lf = memchr(lf + 1, '\n', n - at)) {
        at = (size_t)(lf + 1 - text);
        r = is_own(text, at, n, due_seq);
    }
    return r;
}

/* Up to the file's end: 0 bytes if that is more than one line can have. */
static int read_rest(struct ttf_io *io, int file, int64_t offset, char **ret, size_t *ret_n)
{
    size_t room = 0, most = TTF_LINE_MAX + 2;
    char *text = NULL, *grown;
    int64_t got = 0;

    *ret_n = 0;
    do {
        *ret_n += (size_t)got;
        room = room ? 4 * room : (size_t)64 * 1024;
        room = room < most ? room : most;
        grown = realloc(text, room);
        if (!grown) {
            free(text);
            return -ENOMEM;
        }
        text = grown;
        got = ttf_io_pread_all(io, file, text + *ret_n, room - *ret_n, offset + (int64_t)*ret_n);
    } while (got > 0 && *ret_n + (size_t)got == room && room < most);
    if (got < 0) {
        free(text);
        return (int)got;
    }
    *ret_n += (size_t)got;
    if (*ret_n == most)
        *ret_n = 0;
    *ret = text;
    return 0;
}

int ttf_lines_cut_off(struct ttf_io *io, int file, int64_t offset, int64_t due_seq,
                      int64_t *ret_bytes)
{
    char *text = NULL;
    size_t n;
    int r = read_rest(io, file, offset, &text, &n);

    if (r)
        return r;
    r = n > 0 ? may_be_lines(text, n, due_seq) : 1;
    free(text);
    if (r < 0)
        return r;
    *ret_bytes = r ? 0 : (int64_t)n;
    return 0;
}
