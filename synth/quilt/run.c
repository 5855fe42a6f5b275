/* SPDX-License-Identifier: Apache-2.0 */
#include "ttf/synth/run.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "metrics/activity.h"
#include "quilt/compose.h"
#include "search/hash.h"

/* Frames that seams are measured on, evenly spread. */
#define SEAM_FRAMES 16u

/* Share of the progress bar that finding the map gets. */
#define PLAN_SHARE 0.6

struct run {
    const struct ttf_quilt_config *config; /* the caller's */
    struct ttf_quilt_config inner;         /* with progress of its own */
    struct ttf_sequence *input;
    struct ttf_pool *pool;
    const struct ttf_quilt_sink *sink;
    struct ttf_quilt_map map;
    struct ttf_activity *in, *out;
    struct ttf_seams *seams;
    uint16_t *source, *frame;
    struct ttf_quilt_report report;
};

static int64_t now_ns(const struct run *run)
{
    return run->config->now_ns ? run->config->now_ns(run->config->now_ctx) : 0;
}

static void show_progress(const struct run *run, double done)
{
    if (run->config->progress)
        run->config->progress(run->config->progress_ctx, done);
}

static void plan_progress(void *ctx, double done)
{
    const struct run *run = ctx;

    show_progress(run, PLAN_SHARE * done);
}

static int start(struct run *run, struct ttf_err *err)
{
    const struct ttf_quilt_config *config = run->config;
    const struct ttf_sequence *input = run->input;
    size_t in_bytes = (size_t)input->width * input->height * 3 * sizeof(uint16_t);
    size_t out_bytes = (size_t)config->width * config->height * 3 * sizeof(uint16_t);

    run->source = malloc(in_bytes);
    run->frame = malloc(out_bytes);
    run->in = ttf_activity_create(input->width, input->height, &input->encoding);
    run->out = ttf_activity_create(config->width, config->height, &input->encoding);
    if (!run->source || !run->frame || !run->in || !run->out ||
        ttf_activity_keep_pixels(run->in) < 0)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory for frames of %u x %u", config->width,
                           config->height);
    run->report = (struct ttf_quilt_report){
        .config = *config,
        .source_width = input->width,
        .source_height = input->height,
        .frames = input->n,
        .threads = ttf_pool_threads(run->pool),
        /* a frame of each, half of it again as display codes, and per pixel sums */
        .frame_bytes = in_bytes + in_bytes / 2 + in_bytes / 3 * 2 + out_bytes + out_bytes / 2};
    return 0;
}

static void finish(struct run *run)
{
    ttf_quilt_map_free(&run->map);
    ttf_activity_destroy(run->in);
    ttf_activity_destroy(run->out);
    ttf_seams_destroy(run->seams);
    free(run->source);
    free(run->frame);
}

/* Puts a map that has just been found into the report's sums and opens its seams. */
static int take_map(struct run *run, struct ttf_err *err)
{
    const struct ttf_quilt_search_figures *from = &run->map.figures;
    struct ttf_quilt_search_figures *to = &run->report.search;

    to->positions += from->positions;
    to->survived_cells += from->survived_cells;
    to->survived_rank += from->survived_rank;
    to->exact += from->exact;
    to->load_ns += from->load_ns;
    to->prepare_ns += from->prepare_ns;
    to->search_ns += from->search_ns;
    to->cut_ns += from->cut_ns;
    to->noise_variance = from->noise_variance;
    to->matching_bytes = from->matching_bytes;
    run->report.map_digest = ttf_mix64(run->report.map_digest) ^ ttf_quilt_map_digest(&run->map);
    ttf_seams_destroy(run->seams);
    run->seams = ttf_seams_create(&run->map, &run->input->encoding);
    if (!run->seams)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory for the seams' figures");
    return 0;
}

/* Each of the first frames of SEAM_FRAMES equal parts. */
static bool measures_seams(const struct run *run, uint32_t t)
{
    uint32_t n = run->input->n < SEAM_FRAMES ? run->input->n : SEAM_FRAMES;

    return t == 0 || (uint64_t)t * n / run->input->n != (uint64_t)(t - 1) * n / run->input->n;
}

static int one_frame(struct run *run, uint32_t t, struct ttf_err *err)
{
    int64_t start_ns = now_ns(run), rendered_ns, measured_ns;
    int r = ttf_sequence_read_rows(run->input, t, 0, run->input->height, run->source, err);

    if (r < 0)
        return r;
    ttf_compose_frame(&run->map, run->pool, run->source, run->frame);
    rendered_ns = now_ns(run);
    ttf_activity_add(run->in, run->pool, run->source);
    ttf_activity_add(run->out, run->pool, run->frame);
    if (measures_seams(run, t))
        ttf_seams_add(run->seams, run->source, run->frame);
    measured_ns = now_ns(run);
    r = run->sink->frame(run->sink->ctx, t, run->frame, err);
    run->report.render_ns += rendered_ns - start_ns;
    run->report.metrics_ns += measured_ns - rendered_ns;
    run->report.sink_ns += now_ns(run) - measured_ns;
    return r < 0 ? r : 0;
}

static int map_of_frame(struct run *run, uint32_t t, struct ttf_err *err)
{
    int r;

    ttf_quilt_map_free(&run->map);
    r = ttf_quilt_frame_map(&run->inner, run->input, t, run->pool, &run->map, err);
    return r < 0 ? r : take_map(run, err);
}

static int all_frames(struct run *run, struct ttf_quilt_map *ret_first, struct ttf_err *err)
{
    const struct ttf_quilt_config *config = run->config;
    double from = config->per_frame ? 0.0 : PLAN_SHARE;
    int r = 0;

    for (uint32_t t = 0; t < run->input->n && r == 0; t++) {
        if (config->cancel && *config->cancel)
            return ttf_err_set(err, -ECANCELED, NULL, "cancelled");
        if (config->per_frame)
            r = map_of_frame(run, t, err);
        if (r == 0)
            r = one_frame(run, t, err);
        if (r == 0 && config->per_frame && measures_seams(run, t))
            ttf_seams_figures(run->seams, &run->report.seams);
        show_progress(run, from + (1.0 - from) * (t + 1.0) / run->input->n);
        if (r == 0 && config->per_frame && t == 0 && ret_first) {
            ttf_seams_destroy(run->seams);
            run->seams = NULL;
            *ret_first = run->map;
            memset(&run->map, 0, sizeof(run->map));
        }
    }
    return r;
}

static double ratio(double a, double b)
{
    return b > 0.0 ? a / b : 0.0;
}

/* Activity of the source pixels, each counted as often as it was copied, over all frames. */
static double copied_difference(const struct run *run)
{
    const uint32_t *sums = ttf_activity_pixels(run->in);
    size_t pixels = (size_t)run->map.width * run->map.height;
    uint64_t sum = 0;

    for (size_t i = 0; i < pixels; i++)
        sum += sums[run->map.source[i]];
    return run->input->n < 2 ? 0.0 : (double)sum / (3.0 * (double)pixels * (run->input->n - 1));
}

static void sum_up_blocks(const struct ttf_quilt_map *map, uint32_t frames,
                          struct ttf_quilt_report *report)
{
    double candidates = 0.0, rms = 0.0;

    report->blocks = map->n_blocks;
    report->overlap_x = map->overlap_x;
    report->overlap_y = map->overlap_y;
    for (unsigned i = 1; i < map->n_blocks; i++) {
        const struct ttf_quilt_block *block = &map->blocks[i];
        double own = sqrt(block->error / (3.0 * frames * block->overlap_pixels));

        candidates += block->candidates;
        rms += own;
        report->max_rms_error = own > report->max_rms_error ? own : report->max_rms_error;
        report->single_candidate_blocks += block->candidates == 1;
    }
    report->mean_candidates = map->n_blocks > 1 ? candidates / (map->n_blocks - 1) : 0.0;
    report->mean_rms_error = map->n_blocks > 1 ? rms / (map->n_blocks - 1) : 0.0;
}

static int sum_up(struct run *run, const struct ttf_quilt_map *map, struct ttf_err *err)
{
    struct ttf_quilt_report *report = &run->report;

    ttf_activity_figures(run->in, &report->input);
    ttf_activity_figures(run->out, &report->output);
    report->coherence = ratio(report->output.mean_difference, report->input.mean_difference);
    report->flicker = ratio(report->output.second_difference, report->input.second_difference);
    if (!run->config->per_frame)
        report->coherence_copied = ratio(report->output.mean_difference, copied_difference(run));
    if (!run->config->per_frame)
        ttf_seams_figures(run->seams, &report->seams);
    sum_up_blocks(map, run->config->per_frame ? 1 : run->input->n, report);
    if (ttf_repetition_of_map(map, &report->repetition) < 0)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory for the figures of repetition");
    return 0;
}

int ttf_quilt_run(const struct ttf_quilt_config *config, struct ttf_sequence *input,
                  struct ttf_pool *pool, const struct ttf_quilt_sink *sink,
                  struct ttf_quilt_report *ret_report, struct ttf_quilt_map *ret_map,
                  struct ttf_err *err)
{
    struct run run = {
        .config = config, .inner = *config, .input = input, .pool = pool, .sink = sink};
    struct ttf_quilt_map first = {0};
    int64_t start_ns = now_ns(&run);
    int r = ttf_quilt_validate(config, input, err);

    if (r < 0)
        return r;
    run.inner.progress = config->per_frame ? NULL : plan_progress;
    run.inner.progress_ctx = &run;
    r = start(&run, err);
    if (r == 0 && !config->per_frame) {
        r = ttf_quilt_plan(&run.inner, input, pool, &run.map, err);
        if (r == 0)
            r = take_map(&run, err);
    }
    if (r == 0)
        r = all_frames(&run, &first, err);
    if (r == 0)
        r = sum_up(&run, first.source ? &first : &run.map, err);
    run.report.total_ns = now_ns(&run) - start_ns;
    if (r == 0 && ret_report)
        *ret_report = run.report;
    if (r == 0 && ret_map) {
        *ret_map = first.source ? first : run.map;
        memset(first.source ? &first : &run.map, 0, sizeof(first));
    }
    ttf_quilt_map_free(&first);
    finish(&run);
    return r;
}
