/* SPDX-License-Identifier: Apache-2.0 */
/*
 * seen.h: what was judged already, and who takes which step: shared by the processes of a campaign,
 * so that nothing is judged twice and none waits for another.
 */
#ifndef TTF_TESTS_CRASH_SEEN_H
#define TTF_TESTS_CRASH_SEEN_H

#include <stdbool.h>
#include <stdint.h>

struct seen;

/* Room for 2^room_bits hashes, of which three quarters may be used; made before the processes. Ends the program where
 * there is no memory. */
struct seen *seen_create(unsigned room_bits);
void seen_destroy(struct seen *seen); /* NULL allowed */

/* True if it was not there yet. Ends the program when the room is used up. */
bool seen_add(struct seen *seen, uint64_t hash);

bool seen_has(struct seen *seen, uint64_t hash);

/* True for the first who asks for this step, from 0 on. */
bool seen_claim(struct seen *seen, uint64_t step);

#endif
