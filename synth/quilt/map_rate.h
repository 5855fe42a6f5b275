/* SPDX-License-Identifier: Apache-2.0 */
/*
 * map_rate.h: the pace M in a map's file: a row is the bits of its floats, 8 hex digits each, so that it comes back
 * exactly.
 */
#ifndef TTF_SYNTH_QUILT_MAP_RATE_H
#define TTF_SYNTH_QUILT_MAP_RATE_H

#include <stdint.h>

#include "ttf/dataset/json_writer.h"
#include "ttf/synth/rate_map.h"

#define TTF_MAP_RATE_DIGITS 8u

/* The field "rate". Errors stick in *json. */
void ttf_map_rate_put(struct ttf_json *json, const struct ttf_rate_map *rate);

/* A row of `width` rates out of as many times 8 digits: width, or the first that is no rate (0 to 2^20). */
uint32_t ttf_map_rate_row(const char *text, uint32_t width, float *ret);

#endif
