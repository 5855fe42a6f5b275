/* SPDX-License-Identifier: Apache-2.0 */
#include "ttf/synth/report.h"

#include <math.h>
#include <stdio.h>

static void put_hex(struct ttf_json *json, const char *key, uint64_t value)
{
    char text[17];

    snprintf(text, sizeof(text), "%016llx", (unsigned long long)value);
    ttf_json_kstring(json, key, text);
}

/* A name and two sizes. */
static void put_size(struct ttf_json *json, const char *key, uint32_t width, uint32_t height)
{
    ttf_json_key(json, key);
    ttf_json_array(json);
    ttf_json_int(json, width);
    ttf_json_int(json, height);
    ttf_json_array_end(json);
}

static void put_null(struct ttf_json *json, const char *key)
{
    ttf_json_key(json, key);
    ttf_json_null(json);
}

/* How blocks were looked for. A replay looks for none, and its map does not say how they were found. */
static void put_matching(const struct ttf_quilt_config *config, struct ttf_json *json)
{
    static const char *const UNKNOWN[] = {"tolerance", "seed",      "metric",  "mirror",
                                          "flips",     "rotations", "avoid_px"};
    char seed[21];

    for (size_t i = 0; config->replay && i < sizeof(UNKNOWN) / sizeof(*UNKNOWN); i++)
        put_null(json, UNKNOWN[i]);
    if (config->replay)
        return;
    ttf_json_kdouble(json, "tolerance", config->tolerance);
    snprintf(seed, sizeof(seed), "%llu", (unsigned long long)config->seed);
    ttf_json_kstring(json, "seed", seed);
    ttf_json_kstring(json, "metric", ttf_metric_name(config->metric));
    ttf_json_kbool(json, "mirror", config->mirror);
    ttf_json_kbool(json, "flips", config->flips);
    ttf_json_kbool(json, "rotations", config->rotations);
    ttf_json_kint(json, "avoid_px", config->avoid_px);
}

static void put_parameters(const struct ttf_quilt_report *report, struct ttf_json *json)
{
    const struct ttf_quilt_config *config = &report->config;

    ttf_json_key(json, "parameters");
    ttf_json_object(json);
    put_size(json, "size", config->width, config->height);
    if (report->block_known)
        put_size(json, "block", config->block_width, config->block_height);
    else
        put_null(json, "block");
    put_size(json, "overlap", report->overlap_x, report->overlap_y);
    put_matching(config, json);
    ttf_json_kbool(json, "per_frame", config->per_frame);
    ttf_json_kint(json, "feather_px", config->feather_px);
    ttf_json_kint(json, "jitter_frames", config->jitter_frames);
    if (config->jitter_frames > 0)
        ttf_json_kstring(json, "jitter", config->jitter_round ? "rounded" : "interpolated");
    if (config->jitter_frames > 0 && config->replay)
        put_null(json, "jitter_every");
    else if (config->jitter_frames > 0)
        ttf_json_kint(json, "jitter_every", config->jitter_every);
    ttf_json_kbool(json, "rate_map", config->rate != NULL);
    ttf_json_kbool(json, "tileable", config->tileable);
    ttf_json_kbool(json, "replayed", config->replay != NULL);
    ttf_json_kint(json, "inputs", report->inputs);
    ttf_json_kint(json, "threads", report->threads);
    ttf_json_object_end(json);
}

static void put_activity(struct ttf_json *json, const char *key,
                         const struct ttf_activity_figures *figures)
{
    ttf_json_key(json, key);
    ttf_json_object(json);
    ttf_json_kdouble(json, "mean_difference", figures->mean_difference);
    ttf_json_kdouble(json, "second_difference", figures->second_difference);
    ttf_json_key(json, "mean_rgb");
    ttf_json_array(json);
    for (int c = 0; c < 3; c++)
        ttf_json_double(json, figures->mean_rgb[c]);
    ttf_json_array_end(json);
    ttf_json_object_end(json);
}

/* A number, or null where it says nothing; NAN never does. */
static void put_figure(struct ttf_json *json, const char *key, bool known, double value)
{
    ttf_json_key(json, key);
    if (known && !isnan(value))
        ttf_json_double(json, value);
    else
        ttf_json_null(json);
}

static void put_coherence(const struct ttf_quilt_report *report, struct ttf_json *json)
{
    ttf_json_key(json, "temporal_coherence");
    ttf_json_object(json);
    put_figure(json, "difference_ratio", true, report->coherence);
    put_figure(json, "difference_ratio_noise_subtracted", true, report->coherence_noise_free);
    put_figure(json, "difference_ratio_copied", true, report->coherence_copied);
    put_figure(json, "second_difference_ratio", true, report->flicker);
    put_figure(json, "second_difference_ratio_copied", true, report->flicker_copied);
    put_activity(json, "input", &report->input);
    put_activity(json, "output", &report->output);
    ttf_json_object_end(json);
    ttf_json_key(json, "synchrony");
    ttf_json_object(json);
    ttf_json_kint(json, "pairs", report->synchrony_pairs);
    put_figure(json, "correlation", report->synchrony_pairs > 0, report->synchrony);
    ttf_json_object_end(json);
}

static void put_colours(const struct ttf_quilt_report *report, struct ttf_json *json)
{
    ttf_json_key(json, "colour_distance");
    ttf_json_object(json);
    ttf_json_kstring(json, "measure", "sliced Wasserstein-1 of RGB, display codes");
    put_figure(json, "mean", report->n_colour > 0, report->colour.mean);
    put_figure(json, "largest", report->n_colour > 0, report->colour.largest);
    ttf_json_key(json, "frames");
    ttf_json_array(json);
    for (unsigned i = 0; i < report->n_colour; i++)
        ttf_json_int(json, report->colour_at[i]);
    ttf_json_array_end(json);
    ttf_json_key(json, "distances");
    ttf_json_array(json);
    for (unsigned i = 0; i < report->n_colour; i++)
        ttf_json_double(json, report->colour_distance[i]);
    ttf_json_array_end(json);
    ttf_json_object_end(json);
}

static void put_compression_kind(const struct ttf_quilt_report *report, struct ttf_json *json)
{
    const struct ttf_quilt_rank_figures *rank = &report->rank;

    if (report->config.replay) { /* nothing was matched */
        put_null(json, "rank");
        put_null(json, "of");
        put_null(json, "numbers_per_pixel");
        return;
    }
    if (rank->rank == TTF_QUILT_RANK_FULL)
        ttf_json_kstring(json, "rank", "full");
    else
        ttf_json_kint(json, "rank", rank->rank);
    ttf_json_kstring(json, "of", report->config.per_channel ? "each channel" : "all channels");
    ttf_json_kint(json, "numbers_per_pixel", rank->numbers);
}

double ttf_quilt_report_wanted_error(const struct ttf_quilt_report *report)
{
    return report->config.replay ? 0.0 : report->config.rank_error;
}

static void put_rank(const struct ttf_quilt_report *report, struct ttf_json *json)
{
    const struct ttf_quilt_rank_figures *rank = &report->rank;
    const struct ttf_agreement *agreement = &report->agreement;

    ttf_json_key(json, "compression");
    ttf_json_object(json);
    put_compression_kind(report, json);
    put_figure(json, "error", !report->config.replay, rank->error);
    put_figure(json, "rms_over_full_scale", !report->config.replay, rank->rms);
    if (ttf_quilt_report_wanted_error(report) > 0.0) {
        ttf_json_kdouble(json, "error_wanted", report->config.rank_error);
        ttf_json_kbool(json, "error_reached", rank->error <= report->config.rank_error);
    }
    ttf_json_kint(json, "frames_known_before", rank->known_frames);
    ttf_json_key(json, "errors_by_rank");
    ttf_json_array(json);
    for (unsigned k = 0; k < rank->n_errors; k++)
        ttf_json_double(json, rank->errors[k]);
    ttf_json_array_end(json);
    ttf_json_object_end(json);
    ttf_json_key(json, "agreement_with_full_time_search");
    ttf_json_object(json);
    ttf_json_kint(json, "queries", agreement->queries);
    put_figure(json, "best_block", agreement->queries > 0, agreement->best);
    put_figure(json, "extra_cost", agreement->queries > 0, agreement->extra_cost);
    put_figure(json, "candidates_jaccard", agreement->queries > 0, agreement->jaccard);
    ttf_json_kint(json, "jumps", agreement->jumps);
    put_figure(json, "jumps_best_block", agreement->jumps > 0, agreement->jump_best);
    put_figure(json, "jumps_extra_cost", agreement->jumps > 0, agreement->jump_extra_cost);
    ttf_json_object_end(json);
}

/* What each input has its own figures of. */
static void put_steadied(const struct ttf_report_prepared *p, struct ttf_json *json)
{
    ttf_json_kbool(json, "gradient_removed", p->flattened);
    if (p->flattened) {
        ttf_json_kbool(json, "gradient_applied_again", p->gradient_reapplied);
        ttf_json_kdouble(json, "gradient_least", (double)p->gradient_least);
        ttf_json_kdouble(json, "gradient_most", (double)p->gradient_most);
    }
    ttf_json_kbool(json, "deflickered", p->deflickered);
    if (p->deflickered) {
        ttf_json_kdouble(json, "smallest_gain", p->deflicker.smallest_gain);
        ttf_json_kdouble(json, "largest_gain", p->deflicker.largest_gain);
        ttf_json_kdouble(json, "flicker_before", p->deflicker.before);
        ttf_json_kdouble(json, "flicker_after", p->deflicker.after);
    }
    ttf_json_kbool(json, "stabilised", p->stabilised);
    if (p->stabilised) {
        ttf_json_kdouble(json, "largest_shift_px", p->stabilise.largest_shift_px);
        ttf_json_kint(json, "frames_moved", p->stabilise.moved);
        ttf_json_kint(json, "frames_unlike", p->stabilise.unlike);
        put_size(json, "cropped_px", p->stabilise.crop_x, p->stabilise.crop_y);
    }
}

static void put_text(struct ttf_json *json, const char *key, const char *text)
{
    if (*text)
        ttf_json_kstring(json, key, text);
    else
        put_null(json, key);
}

static void put_sources(const struct ttf_quilt_report *report, struct ttf_json *json)
{
    ttf_json_key(json, "sources");
    ttf_json_array(json);
    for (uint32_t i = 0; i < report->inputs; i++) {
        ttf_json_object(json);
        put_text(json, "uuid", report->sources[i].uuid);
        put_text(json, "digest", report->sources[i].digest);
        ttf_json_key(json, "prepared");
        ttf_json_object(json);
        put_steadied(i ? &report->more_prepared[i - 1] : &report->prepared, json);
        ttf_json_object_end(json);
        ttf_json_object_end(json);
    }
    ttf_json_array_end(json);
}

/* The first input's; the others' are with the sources. */
static void put_prepared(const struct ttf_quilt_report *report, struct ttf_json *json)
{
    const struct ttf_report_prepared *p = &report->prepared;

    ttf_json_key(json, "prepared");
    ttf_json_object(json);
    put_steadied(p, json);
    ttf_json_kbool(json, "reduced", p->reduced);
    if (p->reduced) {
        ttf_json_kint(json, "shrunk_by", p->shrink);
        ttf_json_kint(json, "frame_step", p->step);
    }
    if (p->allowed_ns > 0) {
        ttf_json_kint(json, "preview_estimated_ns", p->estimated_ns);
        ttf_json_kint(json, "preview_allowed_ns", p->allowed_ns);
        ttf_json_kbool(json, "preview_within_time", p->estimated_ns <= p->allowed_ns);
    }
    ttf_json_kbool(json, "block_from_features", p->auto_block);
    if (p->auto_block) {
        ttf_json_kdouble(json, "correlation_x_px", p->feature.correlation_x_px);
        ttf_json_kdouble(json, "correlation_y_px", p->feature.correlation_y_px);
        ttf_json_kdouble(json, "period_x_px", p->feature.period_x_px);
        ttf_json_kdouble(json, "period_y_px", p->feature.period_y_px);
    }
    ttf_json_object_end(json);
}

/* Of frames quilted alone each has blocks of its own: which one's these are. */
static void put_frame(const struct ttf_quilt_report *report, uint32_t t, struct ttf_json *json)
{
    if (report->config.per_frame)
        ttf_json_kint(json, "of_frame", t);
}

static void put_seams(const struct ttf_quilt_report *report, struct ttf_json *json)
{
    const struct ttf_seams_figures *seams = &report->seams;
    bool known = seams->frames > 0; /* of a slowed output there are none */

    ttf_json_key(json, "seams");
    ttf_json_object(json);
    put_frame(report, report->seams_of_frame, json);
    ttf_json_kint(json, "pairs", (int64_t)seams->pairs);
    ttf_json_kdouble(json, "pair_share", seams->pair_share);
    ttf_json_kint(json, "frames", seams->frames);
    put_figure(json, "seam_gradient", known, seams->seam_gradient);
    put_figure(json, "source_gradient", known, seams->source_gradient);
    put_figure(json, "input_gradient", known, seams->input_gradient);
    put_figure(json, "excess", known, seams->excess);
    put_figure(json, "excess_over_input", known, seams->input_excess);
    ttf_json_object_end(json);
}

static void put_blocks(const struct ttf_quilt_report *report, struct ttf_json *json)
{
    const struct ttf_repetition_figures *repetition = &report->repetition;

    ttf_json_key(json, "blocks");
    ttf_json_object(json);
    put_frame(report, 0, json);
    ttf_json_kint(json, "count", report->blocks);
    ttf_json_kdouble(json, "mean_candidates", report->mean_candidates);
    ttf_json_kint(json, "with_one_candidate", report->single_candidate_blocks);
    put_figure(json, "mean_rms_error", true, report->mean_rms_error);
    put_figure(json, "max_rms_error", true, report->max_rms_error);
    ttf_json_object_end(json);
    ttf_json_key(json, "repetition");
    ttf_json_object(json);
    put_frame(report, 0, json);
    ttf_json_kdouble(json, "verbatim_share", repetition->verbatim_share);
    ttf_json_kdouble(json, "source_coverage", repetition->source_coverage);
    ttf_json_kdouble(json, "mean_uses", repetition->mean_uses);
    ttf_json_kint(json, "max_uses", repetition->max_uses);
    ttf_json_object_end(json);
}

static void put_search(const struct ttf_quilt_report *report, struct ttf_json *json)
{
    const struct ttf_quilt_search_figures *search = &report->search;

    ttf_json_key(json, "search");
    ttf_json_object(json);
    ttf_json_kint(json, "positions", (int64_t)search->positions);
    ttf_json_kint(json, "past_cells", (int64_t)search->survived_cells);
    if (report->rank.rank == TTF_QUILT_RANK_FULL && !report->config.replay)
        ttf_json_kint(json, "past_rank", (int64_t)search->survived_rank);
    ttf_json_kint(json, "exact", (int64_t)search->exact);
    put_figure(json, "noise_variance", !report->config.replay, search->noise_variance);
    ttf_json_object_end(json);
}

static void put_cost(const struct ttf_quilt_report *report, struct ttf_json *json)
{
    ttf_json_key(json, "memory_bytes");
    ttf_json_object(json);
    ttf_json_kint(json, "matching", (int64_t)report->search.matching_bytes);
    ttf_json_kint(json, "frames", (int64_t)report->frame_bytes);
    if (report->peak_bytes > 0)
        ttf_json_kint(json, "peak_resident", (int64_t)report->peak_bytes);
    ttf_json_object_end(json);
    if (!report->config.now_ns)
        return;
    ttf_json_key(json, "times_ns");
    ttf_json_object(json);
    ttf_json_kint(json, "load", report->search.load_ns);
    ttf_json_kint(json, "prepare", report->search.prepare_ns);
    ttf_json_kint(json, "search", report->search.search_ns);
    ttf_json_kint(json, "cut", report->search.cut_ns);
    ttf_json_kint(json, "render", report->render_ns);
    ttf_json_kint(json, "metrics", report->metrics_ns);
    ttf_json_kint(json, "sink", report->sink_ns);
    ttf_json_kint(json, "total", report->total_ns);
    ttf_json_object_end(json);
}

void ttf_quilt_report_json(const struct ttf_quilt_report *report, struct ttf_json *json)
{
    ttf_json_object(json);
    ttf_json_kstring(json, "synthesis", "quilt");
    ttf_json_kbool(json, "simulated", report->simulated);
    put_parameters(report, json);
    put_size(json, "source_size", report->source_width, report->source_height);
    ttf_json_kint(json, "frames", report->frames);
    ttf_json_kint(json, "output_frames", report->out_frames);
    put_hex(json, "map_digest", report->map_digest);
    put_prepared(report, json);
    put_sources(report, json);
    put_rank(report, json);
    ttf_json_kbool(json, "measured", report->measured);
    if (report->measured) {
        put_coherence(report, json);
        put_colours(report, json);
        put_seams(report, json);
    }
    put_blocks(report, json);
    put_search(report, json);
    put_cost(report, json);
    ttf_json_object_end(json);
}
