/* SPDX-License-Identifier: Apache-2.0 */
/*
 * quilt_job.h: a quilting as the commands do it: inputs prepared, options turned into a
 * configuration, the run, what is said of it. What commands add: a control of the pace, an edit
 * of each frame.
 */
#ifndef CLI_QUILT_JOB_H
#define CLI_QUILT_JOB_H

#include "cli.h"
#include "quilt_factors.h"
#include "quilt_files.h"
#include "quilt_input.h"
#include "quilt_preview.h"
#include "quilt_sink.h"
#include "ttf/hal/clock.h"
#include "ttf/synth/run.h"

struct quilt_job {
    struct cli *cli;
    const char *source; /* the first input's path */
    /* Of the output, where --size says nothing; 0: twice the input. Before it is shrunk. */
    uint32_t default_width, default_height;
    /* Fills rate for config's size (its m may stay NULL). */
    int (*control)(struct quilt_job *job);
    /* For previews: the pace of the fastest pixel that control would find at this size. NULL: 1. */
    int (*fastest)(void *job, uint32_t width, uint32_t height, float *ret);
    /* See struct quilt_sink_spec. NULL: none. */
    void (*edit)(void *ctx, const struct ttf_encoding *encoding, uint16_t *codes);
    void *edit_ctx;

    enum quilt_sink_kind kind;
    struct ttf_clock *clock;
    struct ttf_pool *pool;
    struct quilt_input inputs[1 + CLI_SOURCES_MAX];
    unsigned n_inputs;
    struct ttf_sequence *more[CLI_SOURCES_MAX];
    struct ttf_quilt_config config;
    struct ttf_report_prepared prepared;                       /* the first input */
    struct ttf_report_prepared more_prepared[CLI_SOURCES_MAX]; /* the others */
    struct quilt_preview preview;
    struct ttf_gradient gradient; /* of the output's size, to be laid over it again */
    struct ttf_rate_map rate;
    struct quilt_factors factors;
    struct ttf_quilt_map kept; /* --map */
    struct quilt_sink *sink;
    struct ttf_quilt_report report;
    struct ttf_quilt_map map;
    struct ttf_quilt_check check;
    struct cli_progress bar;
    bool checked;
};

/* All of it, from refusing options to saying what came out. 0, an exit code, or a negative errno. */
int quilt_job_run(struct quilt_job *job);
void quilt_job_free(struct quilt_job *job);

#endif
