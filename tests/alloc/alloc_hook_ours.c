/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What our objects call instead of the C library's (the linker's --wrap): __real_X is the library's.
 * The names are the linker's.
 */
/* NOLINTBEGIN(bugprone-reserved-identifier,cert-dcl37-c,cert-dcl51-cpp) */
#include <errno.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "alloc_hook_private.h"

#define SITE __builtin_return_address(0)

#define WRAPPED(type, name, ...)     \
    type __real_##name(__VA_ARGS__); \
    type __wrap_##name(__VA_ARGS__); \
    type __wrap_##name(__VA_ARGS__)

static bool fails(size_t bytes, const void *site)
{
    if (!alloc_hook_asks(ALLOC_OURS, bytes, site))
        return false;
    errno = ENOMEM;
    return true;
}

/* The call itself, between the brackets. */
#define OURS(ret, call)          \
    do {                         \
        alloc_hook_enter_ours(); \
        (ret) = (call);          \
        alloc_hook_leave_ours(); \
    } while (0)

WRAPPED(void *, malloc, size_t n)
{
    void *p;

    if (fails(n, SITE))
        return NULL;
    OURS(p, __real_malloc(n));
    return p;
}

WRAPPED(void *, calloc, size_t n, size_t each)
{
    void *p;

    if (fails(n * each, SITE))
        return NULL;
    OURS(p, __real_calloc(n, each));
    return p;
}

WRAPPED(void *, realloc, void *old, size_t n)
{
    void *p;

    if (fails(n, SITE))
        return NULL;
    OURS(p, __real_realloc(old, n));
    return p;
}

WRAPPED(void *, reallocarray, void *old, size_t n, size_t each)
{
    void *p;

    if (fails(n * each, SITE))
        return NULL;
    OURS(p, __real_reallocarray(old, n, each));
    return p;
}

WRAPPED(void *, aligned_alloc, size_t alignment, size_t n)
{
    void *p;

    if (fails(n, SITE))
        return NULL;
    OURS(p, __real_aligned_alloc(alignment, n));
    return p;
}

WRAPPED(int, posix_memalign, void **ret, size_t alignment, size_t n)
{
    int r;

    if (fails(n, SITE))
        return ENOMEM;
    OURS(r, __real_posix_memalign(ret, alignment, n));
    return r;
}

WRAPPED(char *, strdup, const char *text)
{
    char *p;

    if (fails(strlen(text) + 1, SITE))
        return NULL;
    OURS(p, __real_strdup(text));
    return p;
}

WRAPPED(char *, strndup, const char *text, size_t n)
{
    char *p;

    if (fails(strnlen(text, n) + 1, SITE))
        return NULL;
    OURS(p, __real_strndup(text, n));
    return p;
}

WRAPPED(int, vasprintf, char **ret, const char *fmt, va_list args)
{
    int r;

    if (fails(0, SITE))
        return -1;
    OURS(r, __real_vasprintf(ret, fmt, args));
    return r;
}

int __wrap_asprintf(char **ret, const char *fmt, ...);
int __wrap_asprintf(char **ret, const char *fmt, ...)
{
    va_list args;
    int r;

    if (fails(0, SITE))
        return -1;
    va_start(args, fmt);
    OURS(r, __real_vasprintf(ret, fmt, args));
    va_end(args);
    return r;
}

WRAPPED(ssize_t, getline, char **line, size_t *room, FILE *from)
{
    ssize_t r;

    if (fails(0, SITE))
        return -1;
    OURS(r, __real_getline(line, room, from));
    return r;
}

WRAPPED(FILE *, open_memstream, char **ret, size_t *ret_bytes)
{
    FILE *f;

    if (fails(0, SITE))
        return NULL;
    OURS(f, __real_open_memstream(ret, ret_bytes));
    return f;
}

WRAPPED(FILE *, fopen, const char *path, const char *mode)
{
    FILE *f;

    if (fails(0, SITE))
        return NULL;
    OURS(f, __real_fopen(path, mode));
    return f;
}
/* NOLINTEND(bugprone-reserved-identifier,cert-dcl37-c,cert-dcl51-cpp) */
