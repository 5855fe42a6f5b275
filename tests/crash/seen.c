/* SPDX-License-Identifier: Apache-2.0 */
#include "seen.h"

#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/mman.h>

#define STEPS_MAX 4096

struct seen {
    size_t bytes, room;
    atomic_size_t n;
    atomic_bool claimed[STEPS_MAX];
    _Atomic uint64_t hashes[]; /* 0: free */
};

static void give_up(const char *why)
{
    fprintf(stderr, "crash: %s\n", why);
    abort();
}

struct seen *seen_create(unsigned room_bits)
{
    size_t room = (size_t)1 << room_bits;
    size_t bytes = sizeof(struct seen) + room * sizeof(uint64_t);
    /* Pages come as they are touched, as zeros. */
    struct seen *seen = mmap(NULL, bytes, PROT_READ | PROT_WRITE,
                             MAP_SHARED | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);

    if (seen == MAP_FAILED)
        give_up("no memory for what was seen");
    seen->bytes = bytes;
    seen->room = room;
    return seen;
}

void seen_destroy(struct seen *seen)
{
    if (seen)
        (void)munmap(seen, seen->bytes);
}

/* The place of a hash, or a free one; what stands there is in *ret. */
static size_t find(struct seen *seen, uint64_t hash, uint64_t *ret)
{
    size_t i = (hash ^ hash >> 32) & (seen->room - 1);

    for (;; i = (i + 1) & (seen->room - 1)) {
        *ret = atomic_load_explicit(&seen->hashes[i], memory_order_relaxed);
        if (*ret == 0 || *ret == hash)
            return i;
    }
}

bool seen_add(struct seen *seen, uint64_t hash)
{
    uint64_t there;
    size_t i;

    hash += hash == 0;
    do {
        i = find(seen, hash, &there);
        if (there == hash)
            return false;
    } while (!atomic_compare_exchange_strong(&seen->hashes[i], &there, hash));
    if (4 * (atomic_fetch_add(&seen->n, 1) + 1) > 3 * seen->room)
        give_up("more different disks than there is room for");
    return true;
}

bool seen_has(struct seen *seen, uint64_t hash)
{
    uint64_t there;

    hash += hash == 0;
    (void)find(seen, hash, &there);
    return there == hash;
}

bool seen_claim(struct seen *seen, uint64_t step)
{
    if (step >= STEPS_MAX)
        give_up("more steps than there is room for");
    return !atomic_exchange(&seen->claimed[step], true);
}
