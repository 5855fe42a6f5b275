/* SPDX-License-Identifier: Apache-2.0 */
/* colour_distance.h: the directions of the colour distance, for its tests. */
#ifndef TTF_SYNTH_METRICS_COLOUR_DISTANCE_H
#define TTF_SYNTH_METRICS_COLOUR_DISTANCE_H

#include <stdint.h>

#define TTF_COLOUR_DIRECTIONS 32u

/* Direction `which` through R, G, B, of length TTF_SLICED_UNIT. */
void ttf_colour_direction(unsigned which, int16_t ret[3]);

#endif
