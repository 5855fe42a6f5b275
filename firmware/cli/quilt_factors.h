/* SPDX-License-Identifier: Apache-2.0 */
/*
 * quilt_factors.h: factors of a quilting kept in a file (--factors), with how the input was
 * prepared that they are of.
 */
#ifndef CLI_QUILT_FACTORS_H
#define CLI_QUILT_FACTORS_H

#include "cli.h"
#include "ttf/dataset/sequence.h"
#include "ttf/synth/quilt.h"
#include "ttf/synth/report.h"

/* What stands in the file before the factors. */
struct quilt_factors_how {
    char magic[8];
    uint32_t byte_order; /* 1 as this machine writes it */
    uint32_t shrink, step;
    uint32_t stabilised, deflicker_window, flattened; /* window 0: not deflickered */
    uint32_t preview;                                 /* made by one */
    double sigma_px;
    char uuid[40]; /* of the dataset; empty: pictures */
};

/* What is passed as ttf_quilt_config.keep_ctx. Zeroed: nothing is kept. */
struct quilt_factors {
    struct cli *cli;
    char *bytes; /* as read; NULL: there was no file */
    bool told;   /* and it says how its input was prepared */
    bool stays;  /* what was begun anew is another thing's: the file is left as it is */
    struct quilt_factors_how was, is;
    char *grown; /* of this run, as it will be written; NULL: none yet */
    size_t grown_size;
    struct ttf_err err;
};

/* Reads --factors if it is there, and sets known and keep_factors of config. */
TTF_MUST_USE int quilt_factors_open(struct cli *cli, struct quilt_factors *ret,
                                    struct ttf_quilt_config *config);

/*
 * When the input is prepared and config valid. Factors of an input that was prepared otherwise, or that
 * preparation has made another as it grew, are begun anew, with a warning: config->known is zeroed. The file is replaced only if
 * it is of the same dataset grown longer, or if both are of previews. Others that do not suit are refused. uuid: the dataset's; "" of pictures.
 */
TTF_MUST_USE int quilt_factors_suit(struct quilt_factors *factors,
                                    const struct ttf_report_prepared *prepared, const char *uuid,
                                    struct ttf_sequence *input, struct ttf_quilt_config *config);

/* When the result is whole: what this run learnt goes into the file, all of it or nothing. */
TTF_MUST_USE int quilt_factors_save(const struct quilt_factors *factors);
void quilt_factors_close(struct quilt_factors *factors);

#endif
