/* SPDX-License-Identifier: Apache-2.0 */
/* map_of_sources.h: what a map says of the inputs it is of. */
#ifndef TTF_SYNTH_QUILT_MAP_OF_SOURCES_H
#define TTF_SYNTH_QUILT_MAP_OF_SOURCES_H

#include "search/sources.h"
#include "ttf/synth/quilt.h"

/* Fills inputs, n_inputs and source_pixels. */
void ttf_quilt_map_of_sources(const struct ttf_sources *sources, struct ttf_quilt_map *map);

#endif
