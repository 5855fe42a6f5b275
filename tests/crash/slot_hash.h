/* SPDX-License-Identifier: Apache-2.0 */
/* slot_hash.h: the hash by which records are compared: of a record's line, without its seq. */
#ifndef TTF_TESTS_CRASH_SLOT_HASH_H
#define TTF_TESTS_CRASH_SLOT_HASH_H

#include <stdint.h>

#include "ttf/dataset/record.h"

/* Ends the program where there is no memory. */
uint64_t slot_hash(const struct ttf_slot_record *record);

#endif
