/* SPDX-License-Identifier: Apache-2.0 */
/* choose.h: what a power cut keeps, drawn at random. */
#ifndef TTF_TESTS_CRASH_CHOOSE_H
#define TTF_TESTS_CRASH_CHOOSE_H

#include "disk.h"
#include "draw.h"

/* Any choice, of all effects: so many of a hundred kept; or all up to one; torn here and there. */
void choose_kept(struct draw *draw, const struct disk *disk, struct disk_kept *kept);

#endif
