/* SPDX-License-Identifier: Apache-2.0 */
#include "search/lanes.h"

#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

#include "ttf/base/checked.h"

#define LINE       64u
#define LARGE_PAGE ((size_t)2 << 20)

int16_t *ttf_lanes_alloc(size_t n)
{
    void *numbers;
    size_t bytes;

    if (!ttf_mul_size(n, sizeof(int16_t), &bytes) || bytes > SIZE_MAX - LINE ||
        posix_memalign(&numbers, bytes < LARGE_PAGE ? LINE : LARGE_PAGE, bytes + LINE) != 0)
        return NULL;
    if (bytes >= LARGE_PAGE)
        (void)madvise(numbers, bytes, MADV_HUGEPAGE); /* a wish: else the same, but slower */
    memset(numbers, 0, bytes + LINE);
    return numbers;
}
