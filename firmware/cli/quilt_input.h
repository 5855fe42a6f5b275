/* SPDX-License-Identifier: Apache-2.0 */
/* quilt_input.h: what a synthesis is made from: a dataset or a picture, and what is done to it before. */
#ifndef CLI_QUILT_INPUT_H
#define CLI_QUILT_INPUT_H

#include "cli.h"
#include "ttf/dataset/reader.h"
#include "ttf/dataset/sequence.h"
#include "ttf/synth/prepare.h"
#include "ttf/synth/report.h"

/* As read, the first frames, reduced, stabilised, deflickered, flattened. */
#define QUILT_CHAIN_MAX 6

/* A zeroed one is closed. */
struct quilt_input {
    struct ttf_reader *reader;                   /* NULL: a picture */
    struct ttf_sequence *chain[QUILT_CHAIN_MAX]; /* each over the one before */
    unsigned depth;
    struct ttf_gradient gradient; /* what the last was flattened by */
};

/* Opens it and takes the first --frames. */
TTF_MUST_USE int quilt_input_open(struct cli *cli, const char *path, struct quilt_input *ret);
void quilt_input_close(struct quilt_input *input);

/*
 * -EINVAL, naming --source and path, unless what its codes mean (quantity, unit, colours) is what the first's mean:
 * pixels of both will stand side by side in one output. A picture means what an import of it would.
 */
TTF_MUST_USE int quilt_input_mixes(struct cli *cli, const struct quilt_input *first,
                                   const struct quilt_input *other, const char *path);

/* What names it in a report; a picture has no names. */
void quilt_input_name(const struct quilt_input *input, struct ttf_report_source *ret);

/* The sequence as it is so far. */
struct ttf_sequence *quilt_input_top(const struct quilt_input *input);

/* Each of these lays one more over it; *prepared says so. Errors name the option. */
TTF_MUST_USE int quilt_input_reduce(struct cli *cli, struct quilt_input *input, uint32_t shrink,
                                    uint32_t step);
TTF_MUST_USE int quilt_input_steady(struct cli *cli, struct quilt_input *input,
                                    struct ttf_report_prepared *prepared); /* nudges, flicker */
TTF_MUST_USE int quilt_input_flatten(struct cli *cli, struct quilt_input *input, double sigma_px,
                                     struct ttf_report_prepared *prepared);

#endif
