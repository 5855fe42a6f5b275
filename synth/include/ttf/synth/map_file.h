/* SPDX-License-Identifier: Apache-2.0 */
/*
 * map_file.h: a quilting's map as JSON text that people can read and programs can change: which
 * block was taken from where, its cuts and its times, and the pace M. What it leaves out (each pixel's
 * source) follows from it and is put together again when it is read. Its fields: quilt/README.md, "The map's file".
 */
#ifndef TTF_SYNTH_MAP_FILE_H
#define TTF_SYNTH_MAP_FILE_H

#include <stddef.h>
#include <stdint.h>

#include "ttf/base/attr.h"
#include "ttf/base/err.h"
#include "ttf/dataset/json_writer.h"
#include "ttf/synth/quilt.h"

/* Writes the map as one JSON object, a line for each block. Errors stick in *json. */
void ttf_quilt_map_json(const struct ttf_quilt_map *map, struct ttf_json *json);

/*
 * Back again: a map of the same digest, without the figures of its search. Nothing in the text is
 * trusted: -EINVAL says what is wrong and where ("blocks[3].cuts.left"); -EFBIG: an
 * output of more than most_pixels (0: any); -ENOMEM. To free: ttf_quilt_map_free.
 */
TTF_MUST_USE int ttf_quilt_map_parse(const char *text, size_t bytes, uint64_t most_pixels,
                                     struct ttf_quilt_map *ret, struct ttf_err *err);

#endif
