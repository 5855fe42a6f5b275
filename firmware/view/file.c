/* SPDX-License-Identifier: Apache-2.0 */
/* file.c: see file.h. */
#include "file.h"

#include <string.h>

static void empty_piece(struct view_file *file)
{
    if (!file->code && file->used)
        file->code =
            ttf_io_pwrite_all(file->io, file->handle, file->piece, file->used, file->offset);
    file->offset += (int64_t)file->used;
    file->used = 0;
}

void view_file_put(struct view_file *file, const char *text, size_t n)
{
    while (n > 0) {
        size_t part = sizeof file->piece - file->used;

        if (part > n)
            part = n;
        memcpy(file->piece + file->used, text, part);
        file->used += part;
        text += part;
        n -= part;
        if (file->used == sizeof file->piece)
            empty_piece(file);
    }
}

void view_file_text(struct view_file *file, const char *text)
{
    view_file_put(file, text, strlen(text));
}

void view_file_escaped(struct view_file *file, const char *text)
{
    for (; *text; text++) {
        switch (*text) {
        case '&':
            view_file_text(file, "&amp;");
            break;
        case '<':
            view_file_text(file, "&lt;");
            break;
        case '>':
            view_file_text(file, "&gt;");
            break;
        case '"':
            view_file_text(file, "&quot;");
            break;
        default:
            view_file_put(file, text, 1);
            break;
        }
    }
}

void view_file_json(struct view_file *file, const char *text)
{
    for (const char *lt; (lt = strchr(text, '<')) != NULL; text = lt + 1) {
        view_file_put(file, text, (size_t)(lt - text));
        view_file_text(file, "\\u003c");
    }
    view_file_text(file, text);
}

void view_file_base64(struct view_file *file, const uint8_t *data, size_t n)
{
    static const char digit[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

    for (size_t i = 0; i < n; i += 3) {
        uint32_t three = (uint32_t)data[i] << 16 | (i + 1 < n ? (uint32_t)data[i + 1] << 8 : 0) |
                         (i + 2 < n ? data[i + 2] : 0);
        char four[4] = {digit[three >> 18], digit[three >> 12 & 63],
                        i + 1 < n ? digit[three >> 6 & 63] : '=',
                        i + 2 < n ? digit[three & 63] : '='};

        view_file_put(file, four, sizeof four);
    }
}

int view_file_flush(struct view_file *file, struct ttf_err *err)
{
    empty_piece(file);
    if (file->code)
        return ttf_err_set(err, file->code, file->path, "cannot be written: %s",
                           strerrordesc_np(-file->code));
    return 0;
}
