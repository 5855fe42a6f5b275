/* SPDX-License-Identifier: Apache-2.0 */
#include "search/lanes.h"

#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

#include "ttf/base/checked.h"

#define LINE       64u
#define LARGE_PAGE ((size_t)2 << 20)

/*
 * Not written to here: large blocks come fresh from the system, as zeros at the first touch of each page, which is by whichever thread needs it.
 * (posix_memalign would leave it to this thread to write zeros.) Before the numbers lies where their memory begins.
 */
int16_t *ttf_lanes_alloc(size_t n)
{
    size_t bytes, align;
    char *memory, *numbers;

    if (!ttf_mul_size(n, sizeof(int16_t), &bytes) || bytes > SIZE_MAX - 2 * LARGE_PAGE)
        return NULL;
    align = bytes < LARGE_PAGE ? LINE : LARGE_PAGE;
    memory = calloc(1, align + bytes + LINE);
    if (!memory)
        return NULL;
    /* calloc's own alignment leaves room for a pointer */
    numbers = memory + align - (uintptr_t)memory % align;
    memcpy(numbers - sizeof(memory), &memory, sizeof(memory));
    if (align == LARGE_PAGE)
        (void)madvise(numbers, bytes, MADV_HUGEPAGE); /* a wish: else the same, but slower */
    return (int16_t *)(void *)numbers;
}

void ttf_lanes_free(void *numbers)
{
    char *memory;

    if (!numbers)
        return;
    memcpy(&memory, (char *)numbers - sizeof(memory), sizeof(memory));
    free(memory);
}
