/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The program's own malloc and free: what every library calls, too. Each block has a head before it
 * that says how long it is and whose. Not in builds with a sanitizer, which bring their own.
 */
/* NOLINTBEGIN(bugprone-reserved-identifier,cert-dcl37-c,cert-dcl51-cpp,readability-inconsistent-declaration-parameter-name): names of the C library */
#include <errno.h>
#include <malloc.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "alloc_hook_private.h"

#define SITE  __builtin_return_address(0)
#define MAGIC UINT32_C(0x7a11c0de)

/* glibc's own, under the names that it keeps for this. */
void *__libc_malloc(size_t n);
void *__libc_realloc(void *p, size_t n);
void __libc_free(void *p);

/* Directly before the block. 16 bytes, so that the block is aligned as malloc promises. */
struct head {
    uint64_t bytes;
    uint32_t before; /* from the start of what glibc gave to the block; the highest bit: ours */
    uint32_t magic;
};

#define OURS_BIT UINT32_C(0x80000000)

_Static_assert(sizeof(struct head) == 16, "blocks stay aligned");

bool alloc_hook_sees_all(void)
{
    return true;
}

static struct head *head_of(void *p)
{
    return (struct head *)p - 1;
}

/* alignment: a power of two from 16 on. */
static void *give(size_t n, size_t alignment)
{
    struct head *head;
    char *base, *at;

    if (n > PTRDIFF_MAX - alignment - sizeof(*head)) {
        errno = ENOMEM;
        return NULL;
    }
    base = __libc_malloc(n + alignment + sizeof(*head) - 16);
    if (!base)
        return NULL;
    at = base + sizeof(*head);
    at += (alignment - (uintptr_t)at % alignment) % alignment;
    head = (struct head *)at - 1;
    *head = (struct head){.bytes = n, .before = (uint32_t)(at - base), .magic = MAGIC};
    if (alloc_hook_in_ours())
        head->before |= OURS_BIT;
    alloc_hook_live(alloc_hook_in_ours(), 1, (long)n);
    return at;
}

static bool fails(size_t n, const void *site)
{
    /* Ours was asked where it was called. */
    if (alloc_hook_in_ours() || !alloc_hook_asks(ALLOC_ALL, n, site))
        return false;
    errno = ENOMEM;
    return true;
}

void *malloc(size_t n)
{
    return fails(n, SITE) ? NULL : give(n, 16);
}

void free(void *p)
{
    struct head *head;
    bool ours;

    if (!p)
        return;
    head = head_of(p);
    if (head->magic != MAGIC) { /* from before the program's malloc was in force */
        __libc_free(p);
        return;
    }
    ours = (head->before & OURS_BIT) != 0;
    alloc_hook_live(ours, -1, -(long)head->bytes);
    head->magic = 0;
    __libc_free((char *)p - (head->before & ~OURS_BIT));
}

static void *give_zeroed(size_t n, size_t each)
{
    size_t bytes;
    void *p;

    if (__builtin_mul_overflow(n, each, &bytes)) {
        errno = ENOMEM;
        return NULL;
    }
    p = give(bytes, 16);
    return p ? memset(p, 0, bytes) : NULL;
}

void *calloc(size_t n, size_t each)
{
    return fails(n * each, SITE) ? NULL : give_zeroed(n, each);
}

static void *give_again(void *old, size_t n)
{
    void *p;

    if (old && n == 0) {
        free(old);
        return NULL;
    }
    if (old && head_of(old)->magic != MAGIC)
        return __libc_realloc(old, n);
    p = give(n, 16);
    if (p && old) {
        size_t was = head_of(old)->bytes;

        memcpy(p, old, was < n ? was : n);
        free(old);
    }
    return p;
}

void *realloc(void *old, size_t n)
{
    return fails(n, SITE) ? NULL : give_again(old, n);
}

void *reallocarray(void *old, size_t n, size_t each)
{
    size_t bytes;

    if (__builtin_mul_overflow(n, each, &bytes)) {
        errno = ENOMEM;
        return NULL;
    }
    return fails(bytes, SITE) ? NULL : give_again(old, bytes);
}

void *aligned_alloc(size_t alignment, size_t n)
{
    return fails(n, SITE) ? NULL : give(n, alignment < 16 ? 16 : alignment);
}

void *memalign(size_t alignment, size_t n)
{
    return fails(n, SITE) ? NULL : give(n, alignment < 16 ? 16 : alignment);
}

int posix_memalign(void **ret, size_t alignment, size_t n)
{
    void *p = fails(n, SITE) ? NULL : give(n, alignment < 16 ? 16 : alignment);

    if (!p)
        return ENOMEM;
    *ret = p;
    return 0;
}

size_t malloc_usable_size(void *p)
{
    return p ? head_of(p)->bytes : 0;
}
/* NOLINTEND(bugprone-reserved-identifier,cert-dcl37-c,cert-dcl51-cpp,readability-inconsistent-declaration-parameter-name) */
