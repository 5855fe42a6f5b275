/* SPDX-License-Identifier: Apache-2.0 */
#include "ttf/base/err.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

int ttf_err_set(struct ttf_err *err, int code, const char *where, const char *fmt, ...)
{
    va_list ap;

    if (!err)
        return code;
    err->code = code;
    err->hint[0] = '\0';
    snprintf(err->where, sizeof(err->where), "%s", where ? where : "");
    va_start(ap, fmt);
    vsnprintf(err->what, sizeof(err->what), fmt, ap);
    va_end(ap);
    return code;
}

void ttf_err_hint(struct ttf_err *err, const char *fmt, ...)
{
    va_list ap;

    if (!err)
        return;
    va_start(ap, fmt);
    vsnprintf(err->hint, sizeof(err->hint), fmt, ap);
    va_end(ap);
}

void ttf_err_prefix(struct ttf_err *err, const char *fmt, ...)
{
    char old[sizeof(err->what)];
    va_list ap;
    int n;

    if (!err)
        return;
    memcpy(old, err->what, sizeof(old));
    va_start(ap, fmt);
    n = vsnprintf(err->what, sizeof(err->what), fmt, ap);
    va_end(ap);
    if (n >= 0 && (size_t)n + 2 < sizeof(err->what))
        snprintf(err->what + n, sizeof(err->what) - (size_t)n, ": %.*s",
                 (int)(sizeof(err->what) - (size_t)n - 3), old); /* cut to what there is room for */
}

const char *ttf_err_text(const struct ttf_err *err, char *buf, unsigned size)
{
    /* Not strerror: it is not thread-safe. */
    const char *what = err->what[0] ? err->what : strerrordesc_np(-err->code);

    if (!what)
        what = "unknown error";
    snprintf(buf, size, "%s%s%s%s%s", err->where, err->where[0] ? ": " : "", what,
             err->hint[0] ? "; " : "", err->hint);
    return buf;
}
