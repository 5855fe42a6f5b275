/* SPDX-License-Identifier: Apache-2.0 */
#include "lines.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ttf/dataset/hash.h"

#define PIECE_BYTES ((size_t)64 * 1024)

void ttf_line_begin(struct ttf_json *json, const char *type, int64_t seq)
{
    ttf_json_init(json, false);
    ttf_line_again(json, type, seq);
}

void ttf_line_again(struct ttf_json *json, const char *type, int64_t seq)
{
    ttf_json_again(json, false);
    ttf_json_object(json);
    ttf_json_kstring(json, "type", type);
    ttf_json_kint(json, "seq", seq);
}

int ttf_line_finish(struct ttf_json *json, const char **ret_text, size_t *ret_bytes)
{
    char hex[9];

    if (json->error == 0) {
        snprintf(hex, sizeof(hex), "%08x", ttf_crc32(0, json->text, json->used));
        ttf_json_kstring(json, "crc", hex);
    }
    ttf_json_object_end(json);
    if (json->error == 0 && json->used > TTF_LINE_MAX)
        json->error = -EFBIG;
    return ttf_json_finish(json, ret_text, ret_bytes);
}

bool ttf_line_holds(const char *line, size_t n)
{
    char tail[TTF_LINE_TAIL + 1];

    if (n <= TTF_LINE_TAIL)
        return false;
    snprintf(tail, sizeof(tail), ",\"crc\":\"%08x\"}", ttf_crc32(0, line, n - TTF_LINE_TAIL));
    return memcmp(line + n - TTF_LINE_TAIL, tail, TTF_LINE_TAIL) == 0;
}

void ttf_lines_init(struct ttf_lines *lines, struct ttf_io *io, int file)
{
    *lines = (struct ttf_lines){.io = io, .file = file};
}

void ttf_lines_free(struct ttf_lines *lines)
{
    free(lines->buf);
    lines->buf = NULL;
}

/* Reads one more piece behind what is there, dropping what was given already. */
static int fill(struct ttf_lines *l)
{
    size_t room = l->room;
    int64_t got;
    char *grown;

    if (l->at > 0) {
        memmove(l->buf, l->buf + l->at, l->have - l->at);
        l->base += (int64_t)l->at;
        l->have -= l->at;
        l->at = 0;
    }
    while (room - l->have < PIECE_BYTES)
        room = room ? room * 2 : PIECE_BYTES;
    if (room > TTF_LINE_MAX + 4 * PIECE_BYTES)
        return -EFBIG;
    if (room != l->room) {
        grown = realloc(l->buf, room);
        if (!grown)
            return -ENOMEM;
        l->buf = grown;
        l->room = room;
    }
    got =
        ttf_io_pread_all(l->io, l->file, l->buf + l->have, PIECE_BYTES, l->base + (int64_t)l->have);
    if (got < 0)
        return (int)got;
    l->have += (size_t)got;
    l->at_end = (size_t)got < PIECE_BYTES;
    return 0;
}

int ttf_lines_next(struct ttf_lines *l, const char **ret_line, size_t *ret_bytes,
                   int64_t *ret_offset, bool *ret_terminated)
{
    size_t searched = 0, n;
    const char *end = NULL;
    int r;

    for (;;) {
        n = l->have - l->at;
        if (n > searched)
            end = memchr(l->buf + l->at + searched, '\n', n - searched);
        if (end || l->at_end)
            break;
        searched = n;
        r = fill(l);
        if (r)
            return r;
    }
    if (!end && n == 0)
        return 0;
    *ret_line = l->buf + l->at;
    *ret_bytes = end ? (size_t)(end - *ret_line) : n;
    *ret_offset = l->base + (int64_t)l->at;
    *ret_terminated = end != NULL;
    l->at += *ret_bytes + (end ? 1 : 0);
    l->number++;
    return 1;
}
