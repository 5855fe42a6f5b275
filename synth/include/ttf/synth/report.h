/* SPDX-License-Identifier: Apache-2.0 */
/*
 * report.h: what a synthesis did and how good it is: report.json.
 *
 * A plain struct, filled by ttf_quilt_run (run.h), may be copied.
 */
#ifndef TTF_SYNTH_REPORT_H
#define TTF_SYNTH_REPORT_H

#include <stdbool.h>
#include <stdint.h>

#include "ttf/base/attr.h"
#include "ttf/dataset/json_writer.h"
#include "ttf/synth/agreement.h"
#include "ttf/synth/likeness.h"
#include "ttf/synth/metrics.h"
#include "ttf/synth/prepare.h"
#include "ttf/synth/quilt.h"

/* Times that the colour distance is given for, at most, evenly spread. */
#define TTF_REPORT_TIMES 64

/* What was done to the input before (prepare.h): for the report, filled in by who did it. */
struct ttf_report_prepared {
    bool flattened, gradient_reapplied, deflickered, stabilised, reduced, auto_block;
    float gradient_least, gradient_most;
    double gradient_sigma_px;  /* if flattened */
    uint32_t deflicker_window; /* frames, if deflickered */
    struct ttf_deflicker_figures deflicker;
    struct ttf_stabilise_figures stabilise;
    struct ttf_feature_size feature;
    uint32_t shrink, step;
    int64_t estimated_ns,
        allowed_ns; /* of a preview: what it was thought to take, and may; 0: none */
};

/* A dataset that was an input; empty: none, or not sealed. For the report, filled in by who knows. */
struct ttf_report_source {
    char uuid[37], digest[65];
};

struct ttf_quilt_report {
    struct ttf_quilt_config config; /* as given; its pointers are not for the reader */
    struct ttf_report_prepared
        prepared; /* the first input; of the others what reduced, steadied and flattened them: */
    struct ttf_report_prepared more_prepared[TTF_QUILT_INPUTS_MAX - 1];
    struct ttf_report_source sources[TTF_QUILT_INPUTS_MAX];
    bool measured;     /* the figures from `input` to `repetition` were taken */
    size_t peak_bytes; /* peak resident of the process: set by who knows it, after the run */
    uint32_t inputs;   /* sequences */
    uint32_t out_frames;
    bool simulated;                /* the input was: set by who knows it, after the run */
    uint32_t overlap_x, overlap_y; /* as used */
    bool block_known; /* the map says what block was asked for: a replayed one may not */
    uint32_t source_width, source_height, frames; /* of the first */
    uint32_t source_pixels;                       /* of all inputs */
    unsigned threads;
    uint64_t map_digest; /* per frame: of all frames' maps together */

    /*
     * Temporal coherence: output over input. NAN (null in the JSON) where there is nothing to compare
     * with: the input does not change, no more than its noise, or frames are too few.
     */
    struct ttf_activity_figures input, output;
    struct ttf_activity_figures copied; /* of the source pixels copied, at their own time */
    double coherence;            /* ratio of mean absolute frame differences, to the whole input */
    double coherence_noise_free; /* the same, measured noise subtracted (in quadrature) */
    double
        coherence_copied; /* to the source pixels that were copied, each as often; NAN if per frame or slowed */
    double flicker;        /* ratio of low-passed second differences, to the whole input */
    double flicker_copied; /* to the source pixels that were copied */

    unsigned synchrony_pairs; /* 0: nothing is repeated, and there is no figure */
    double synchrony;

    /* Sliced Wasserstein distance of colours, input to output, codes; of some times and of those together. */
    struct ttf_colour_figures colour;
    unsigned n_colour;
    uint32_t colour_at[TTF_REPORT_TIMES];
    double colour_distance[TTF_REPORT_TIMES];

    struct ttf_seams_figures seams; /* per frame: of the last frame looked at: */
    uint32_t seams_of_frame;
    struct ttf_repetition_figures repetition; /* per frame: of frame 0, as the blocks */

    /* The blocks' table in short. Errors as RMS in codes, per overlap sample; NAN: of a map that does not say of how many frames. */
    unsigned blocks;
    double mean_candidates, mean_rms_error, max_rms_error;
    unsigned single_candidate_blocks;

    struct ttf_quilt_rank_figures rank;
    struct ttf_agreement agreement;         /* queries 0: not measured */
    struct ttf_quilt_search_figures search; /* summed over frames if per frame */
    int64_t render_ns, sink_ns, metrics_ns, total_ns;
    size_t frame_bytes; /* memory for frames in flight */
};

/* The error that a rank was chosen for, 0: none. Reached or not: rank.error. */
double ttf_quilt_report_wanted_error(const struct ttf_quilt_report *report);

/* Writes the report as one JSON object. Errors stick in *json. */
void ttf_quilt_report_json(const struct ttf_quilt_report *report, struct ttf_json *json);

#endif
