/* SPDX-License-Identifier: Apache-2.0 */
/* alloc_hook_private.h: what the hook's parts tell each other. */
#ifndef TTF_TESTS_ALLOC_HOOK_PRIVATE_H
#define TTF_TESTS_ALLOC_HOOK_PRIVATE_H

#include <stdbool.h>
#include <stddef.h>

#include "alloc_hook.h"

/* True: this allocation is to fail. Counts it. */
bool alloc_hook_asks(enum alloc_whose whose, size_t bytes, const void *site);

/* Bracket a call that our objects make: allocations in between belong to it and are not asked again. */
void alloc_hook_enter_ours(void);
void alloc_hook_leave_ours(void);
bool alloc_hook_in_ours(void);
bool alloc_hook_is_paused(void);

/* A block came to be, or (blocks -1) went. */
void alloc_hook_live(bool ours, long blocks, long bytes);

#endif
