/* SPDX-License-Identifier: Apache-2.0 */
#include "log.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

const char *log_text(const char *text, char *buf, size_t size)
{
    size_t n = 0;

    buf[n++] = '"';
    for (; *text && n + 3 < size; text++) {
        if (*text == '"' || *text == '\\')
            buf[n++] = '\\';
        buf[n++] = (unsigned char)*text < ' ' ? ' ' : *text;
    }
    buf[n++] = '"';
    buf[n] = '\0';
    return buf;
}

void log_line(enum log_level level, const char *word, const char *fmt, ...)
{
    char line[2048];
    size_t n = 0;
    va_list args;

    if (!isatty(STDERR_FILENO))
        n = (size_t)snprintf(line, sizeof line, "<%d>", (int)level);
    n += (size_t)snprintf(line + n, sizeof line - n, "%s%s", word, *fmt ? " " : "");
    va_start(args, fmt);
    /* NOLINTNEXTLINE(clang-analyzer-valist.Uninitialized): it is begun above */
    (void)vsnprintf(line + n, sizeof line - n - 1, fmt, args);
    va_end(args);
    n = strlen(line);
    line[n++] = '\n';
    /* Whole or not at all; with nobody to read it, there is nobody to tell. */
    (void)!write(STDERR_FILENO, line, n);
}
