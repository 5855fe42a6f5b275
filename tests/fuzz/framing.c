/* SPDX-License-Identifier: Apache-2.0 */
#include "framing.h"

#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <zlib.h>

#define TAIL_BYTES 18u /* ,"crc":"01234567"} */
#define SEQ_WITHIN 64u /* of a line: where its seq is looked for */

/* Copies the line with its number in place of what stands behind "seq":. */
static size_t put_counted(const uint8_t *line, size_t n, long number, char *ret)
{
    static const char KEY[] = "\"seq\":";
    const uint8_t *seq = memmem(line, n < SEQ_WITHIN ? n : SEQ_WITHIN, KEY, sizeof KEY - 1);
    size_t before, digits;

    if (!seq) {
        memcpy(ret, line, n);
        return n;
    }
    before = (size_t)(seq - line) + sizeof KEY - 1;
    for (digits = before; digits < n && isdigit(line[digits]);)
        digits++;
    memcpy(ret, line, before);
    before += (size_t)sprintf(ret + before, "%ld", number);
    memcpy(ret + before, line + digits, n - digits);
    return before + n - digits;
}

/* A line's crc and end behind it, where its body ends with no '}' or crc of its own. */
static size_t frame(const uint8_t *line, size_t n, long number, char *ret)
{
    if (n >= TAIL_BYTES && memcmp(line + n - TAIL_BYTES, ",\"crc\":\"", 8) == 0)
        n -= TAIL_BYTES;
    n = put_counted(line, n, number, ret);
    return n +
           (size_t)sprintf(ret + n, ",\"crc\":\"%08lx\"}", crc32(0, (const Bytef *)ret, (uInt)n));
}

char *fuzz_frame_lines(const uint8_t *data, size_t size, size_t *ret_size)
{
    size_t lines = 1, n = 0;
    long number = 0;
    char *out;

    for (size_t i = 0; i < size; i++)
        lines += data[i] == '\n';
    out = malloc(size + lines * (TAIL_BYTES + 24));
    if (!out)
        abort();
    for (size_t at = 0; at < size;) {
        const uint8_t *end = memchr(data + at, '\n', size - at);
        size_t length = end ? (size_t)(end - data) - at : size - at;

        if (length > 0 && data[at] == '~') {
            memcpy(out + n, data + at + 1, length - 1);
            n += length - 1;
        } else {
            n += frame(data + at, length, number++, out + n);
        }
        if (end)
            out[n++] = '\n';
        at += length + 1;
    }
    *ret_size = n;
    return out;
}
