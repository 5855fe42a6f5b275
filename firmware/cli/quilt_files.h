/* SPDX-License-Identifier: Apache-2.0 */
/* quilt_files.h: maps of a quilting on disk (--save-map, --map). */
#ifndef CLI_QUILT_FILES_H
#define CLI_QUILT_FILES_H

#include "cli.h"
#include "ttf/synth/quilt.h"

/* --map, if it is given. */
TTF_MUST_USE int quilt_map_load(struct cli *cli, struct ttf_quilt_map *ret);

/* What of config a loaded map says, for an input as it will be laid; nothing of a zeroed one. config borrows map. */
void quilt_map_describe(const struct ttf_quilt_map *map, const struct ttf_sequence *input,
                        struct ttf_quilt_config *config);

/* --save-map: all of it or nothing. */
TTF_MUST_USE int quilt_map_save(struct cli *cli, const struct ttf_quilt_map *map);

#endif
