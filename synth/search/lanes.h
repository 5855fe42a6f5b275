/* SPDX-License-Identifier: Apache-2.0 */
/* lanes.h: memory for numbers that are read a vector at a time: no vector of up to 64 bytes lies across two lines of the cache. */
#ifndef TTF_SYNTH_SEARCH_LANES_H
#define TTF_SYNTH_SEARCH_LANES_H

#include <stddef.h>
#include <stdint.h>

/* n numbers, all 0. NULL: no memory. */
int16_t *ttf_lanes_alloc(size_t n);

/* Of ttf_lanes_alloc, as whatever they were used; NULL allowed. */
void ttf_lanes_free(void *numbers);

#endif
