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
#include "ttf/synth/metrics.h"
#include "ttf/synth/quilt.h"

struct ttf_quilt_report {
    struct ttf_quilt_config config; /* as given; its pointers are not for the reader */
    bool simulated;                 /* the input was: set by who knows it, after the run */
    uint32_t overlap_x, overlap_y;  /* as used */
    uint32_t source_width, source_height, frames;
    unsigned threads;
    uint64_t map_digest; /* per frame: of all frames' maps together */

    /* Temporal coherence: output over input. 0 where the input's own is 0 or frames are too few. */
    struct ttf_activity_figures input, output;
    double coherence; /* ratio of mean absolute frame differences, to the whole input */
    double
        coherence_copied; /* the same, to the source pixels that were copied, each as often; 0 if per frame */
    double flicker; /* ratio of low-passed second differences, to the whole input */

    struct ttf_seams_figures seams; /* per frame: of the last frame looked at */
    struct ttf_repetition_figures repetition;

    /* The blocks' table in short. Errors as RMS in codes, per overlap sample. */
    unsigned blocks;
    double mean_candidates, mean_rms_error, max_rms_error;
    unsigned single_candidate_blocks;

    struct ttf_quilt_search_figures search; /* summed over frames if per frame */
    int64_t render_ns, sink_ns, metrics_ns, total_ns;
    size_t frame_bytes; /* memory for frames in flight */
};

/* Writes the report as one JSON object. Errors stick in *json. */
void ttf_quilt_report_json(const struct ttf_quilt_report *report, struct ttf_json *json);

#endif
