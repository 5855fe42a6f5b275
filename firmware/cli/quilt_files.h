/* SPDX-License-Identifier: Apache-2.0 */
/* quilt_files.h: what a quilting keeps beside its output: factors (--factors) and maps (--save-map, --map). */
#ifndef CLI_QUILT_FILES_H
#define CLI_QUILT_FILES_H

#include "cli.h"
#include "ttf/synth/quilt.h"

/* What is passed as ttf_quilt_config.keep_ctx. Zeroed: nothing is kept. */
struct quilt_factors {
    struct cli *cli;
    char *bytes; /* as read; NULL: there was no file */
    char *grown; /* of this run; NULL: none yet */
    size_t grown_size;
    struct ttf_err err;
};

/* Reads --factors if it is there, and sets known and keep_factors of config. */
TTF_MUST_USE int quilt_factors_open(struct cli *cli, struct quilt_factors *ret,
                                    struct ttf_quilt_config *config);

/* When the result is whole: what this run learnt goes into the file, all of it or nothing. */
TTF_MUST_USE int quilt_factors_save(const struct quilt_factors *factors);
void quilt_factors_close(struct quilt_factors *factors);

/* --map, if it is given. */
TTF_MUST_USE int quilt_map_load(struct cli *cli, struct ttf_quilt_map *ret);

/* What of config a loaded map says, for an input as it will be laid; nothing of a zeroed one. config borrows map. */
void quilt_map_describe(const struct ttf_quilt_map *map, const struct ttf_sequence *input,
                        struct ttf_quilt_config *config);

/* --save-map: all of it or nothing. */
TTF_MUST_USE int quilt_map_save(struct cli *cli, const struct ttf_quilt_map *map);

#endif
