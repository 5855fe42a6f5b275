/* SPDX-License-Identifier: Apache-2.0 */
#include "ttf/synth/run.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "quilt/ahead.h"
#include "quilt/map_of_sources.h"
#include "quilt/render.h"
#include "search/hash.h"
#include "ttf/synth/cancel.h"

/* Share of the progress bar that finding the map gets. */
#define PLAN_SHARE 0.6

struct run {
    struct ttf_quilt_config given;         /* the caller's, with what a replayed map says */
    const struct ttf_quilt_config *config; /* that */
    struct ttf_quilt_config inner;         /* with progress of its own */
    struct ttf_sources sources;
    struct ttf_pool *pool;
    const struct ttf_quilt_sink *sink;
    struct ttf_quilt_map map;
    struct ttf_figures *figures; /* NULL: nothing is measured */
    uint32_t frames;             /* of the output */
    struct ttf_kept kept;        /* frames whose rows are handed on while blocks are looked for */
    uint32_t handed_on;          /* so many, the first, were handed on that way */
    struct ttf_ahead *ahead;     /* NULL: none are */
    struct ttf_ahead_sums sums;  /* of the map, where some were */
    struct ttf_quilt_report report;
};

static int64_t now_ns(const struct run *run)
{
    return run->config->now_ns ? run->config->now_ns(run->config->now_ctx) : 0;
}

static void plan_progress(void *ctx, double done)
{
    const struct run *run = ctx;

    if (run->config->progress)
        run->config->progress(run->config->progress_ctx, PLAN_SHARE * done);
}

static int start(struct run *run, struct ttf_err *err)
{
    const struct ttf_quilt_config *config = run->config;
    int r = ttf_quilt_output_frames(config, run->sources.frames, &run->frames, err);

    if (r < 0)
        return r;
    run->report = (struct ttf_quilt_report){.config = *config,
                                            .measured = config->measure,
                                            .inputs = run->sources.n,
                                            .source_width = run->sources.list[0]->width,
                                            .source_height = run->sources.list[0]->height,
                                            .frames = run->sources.frames,
                                            .source_pixels = run->sources.pixels,
                                            .out_frames = run->frames,
                                            .threads = ttf_pool_threads(run->pool)};
    if (config->measure &&
        ttf_figures_create(config, &run->sources, run->frames, &run->figures) < 0)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory for the figures of %u x %u pixels",
                           config->width, config->height);
    return 0;
}

static void free_kept(struct run *run)
{
    ttf_ahead_destroy(run->ahead);
    run->ahead = NULL;
    ttf_kept_free(&run->kept);
}

static void finish(struct run *run)
{
    free_kept(run);
    ttf_quilt_map_free(&run->map);
    ttf_figures_destroy(run->figures);
}

/* Puts a map that has just been found into the report's sums and under the figures' eyes. */
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
    run->report.rank = run->map.rank;
    run->report.map_digest =
        ttf_mix64(run->report.map_digest) ^
        (run->handed_on > 0 ? run->sums.digest : ttf_quilt_map_digest(&run->map));
    if (run->figures && ttf_figures_map(run->figures, &run->map) < 0)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory for the seams' figures");
    return 0;
}

/* ---- the baseline ---- */

static int one_alone(struct run *run, struct ttf_render *render, uint32_t t, struct ttf_err *err)
{
    int r;

    ttf_quilt_map_free(&run->map);
    r = ttf_quilt_frame_map(&run->inner, run->sources.list[0], t, run->pool, &run->map, err);
    if (r == 0)
        r = take_map(run, err);
    return r < 0 ? r : ttf_render_one(render, t, err);
}

static int all_alone(struct run *run, struct ttf_render *render, struct ttf_quilt_map *ret_first,
                     struct ttf_err *err)
{
    const struct ttf_quilt_config *config = run->config;

    for (uint32_t t = 0; t < run->frames; t++) {
        int r = ttf_cancelled(config->cancel) ? ttf_err_set(err, -ECANCELED, NULL, "cancelled")
                                              : one_alone(run, render, t, err);

        if (r < 0)
            return r;
        if (config->progress)
            config->progress(config->progress_ctx, (t + 1.0) / run->frames);
        if (t == 0) {
            /* the next frame's map must not free this one, which is reported on */
            *ret_first = run->map;
            memset(&run->map, 0, sizeof(run->map));
        }
    }
    return 0;
}

/* ---- one map ---- */

/* A copy of a map that was kept, for these sources. */
static int replay(struct run *run, const struct ttf_quilt_map *kept, struct ttf_err *err)
{
    struct ttf_quilt_map own = {0};

    ttf_quilt_map_of_sources(&run->sources, &own);
    if (own.n_inputs != kept->n_inputs ||
        memcmp(own.inputs, kept->inputs, own.n_inputs * sizeof(own.inputs[0])) != 0) {
        ttf_err_set(err, -EINVAL, "map", "it is of %u input%s, the first of %u x %u pixels",
                    kept->n_inputs, kept->n_inputs == 1 ? "" : "s", kept->inputs[0].width,
                    kept->inputs[0].height);
        ttf_err_hint(err, "a map is replayed on inputs of the sizes that it was found on");
        return -EINVAL;
    }
    if (kept->width != run->config->width || kept->height != run->config->height)
        return ttf_err_set(err, -EINVAL, "map", "it is of %u x %u pixels, not %u x %u", kept->width,
                           kept->height, run->config->width, run->config->height);
    if (kept->times && kept->n_times < run->sources.frames)
        return ttf_err_set(err, -EINVAL, "map", "its times are of %u frames, the input has %u",
                           kept->n_times, run->sources.frames);
    return ttf_quilt_map_copy(kept, &run->map) < 0
               ? ttf_err_set(err, -ENOMEM, NULL, "no memory for a map of %u x %u pixels",
                             kept->width, kept->height)
               : 0;
}

/* Can rows be final before the whole map is, as the codes that blocks are matched by? */
static bool may_go_ahead(const struct run *run)
{
    const struct ttf_quilt_config *config = run->config;

    return run->sink->rows8 && config->metric == TTF_METRIC_DISPLAY && !run->figures &&
           !config->rate && config->jitter_frames == 0 && config->feather_px <= 1 &&
           !config->tileable && !config->known.bytes &&
           (config->rank != TTF_QUILT_RANK_FULL || config->rank_error > 0.0);
}

static int go_ahead(struct run *run, struct ttf_err *err)
{
    const struct ttf_quilt_config *config = run->config;
    size_t bytes = config->keep_bytes, pixels = run->sources.pixels;
    int r;

    if (config->memory_bytes > 0) {
        size_t left = config->memory_bytes -
                      ttf_quilt_matching_bytes(config, (uint32_t)pixels, run->sources.frames);
        size_t sums = ttf_ahead_sums_bytes(pixels);

        left -= left < sums ? left : sums;
        bytes = left < bytes ? left : bytes;
    }
    r = ttf_kept_create(pixels, run->sources.frames, bytes, &run->kept);
    if (r == 0 && run->kept.frames > 0)
        r = ttf_ahead_create(config, &run->kept, run->sink, ttf_pool_threads(run->pool),
                             &run->ahead);
    return r < 0 ? ttf_err_set(err, r, NULL, "no memory to keep frames of %zu pixels", pixels) : 0;
}

static int search_map(struct run *run, struct ttf_err *err)
{
    int r = may_go_ahead(run) ? go_ahead(run, err) : 0;

    if (r == 0)
        r = ttf_plan_ahead(&run->inner, run->sources.list[0], run->pool, run->ahead, &run->map,
                           err);
    if (r == 0 && run->ahead) {
        ttf_ahead_costs(run->ahead, &run->report);
        run->sums = *ttf_ahead_sums(run->ahead);
        run->handed_on = run->kept.frames;
        free_kept(run); /* the other frames need the room */
    }
    return r;
}

/* What a map's file carries of the pace: the one of this run. */
static int keep_pace(struct run *run, struct ttf_err *err)
{
    const struct ttf_rate_map *rate = run->config->rate;
    size_t bytes = (size_t)run->map.width * run->map.height * sizeof(float);

    run->map.rounded = run->config->jitter_round && (run->map.times || rate);
    if (!rate || (run->config->replay && rate == &run->config->replay->rate))
        return 0;
    ttf_rate_map_free(&run->map.rate);
    run->map.rate = (struct ttf_rate_map){rate->width, rate->height, malloc(bytes)};
    if (!run->map.rate.m)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory for the rates of %u x %u pixels",
                           rate->width, rate->height);
    memcpy(run->map.rate.m, rate->m, bytes);
    return 0;
}

static int find_map(struct run *run, struct ttf_err *err)
{
    const struct ttf_quilt_config *config = run->config;
    int r = config->replay ? replay(run, config->replay, err) : search_map(run, err);

    if (r == 0)
        r = keep_pace(run, err);
    if (r == 0 && config->agreement_queries > 0)
        r = ttf_quilt_agreement(config, run->sources.list[0], &run->map, config->agreement_queries,
                                run->pool, &run->report.agreement, err);
    return r < 0 ? r : take_map(run, err);
}

/* ---- the report ---- */

/* A replayed map's errors are of the frames that it was found on, not of those it is laid on. */
static void sum_up_blocks(const struct ttf_quilt_map *map, struct ttf_quilt_report *report)
{
    double candidates = 0.0, rms = 0.0;

    report->blocks = map->n_blocks;
    report->overlap_x = map->overlap_x;
    report->overlap_y = map->overlap_y;
    report->block_known = map->block_width > 0;
    for (unsigned i = 1; i < map->n_blocks; i++) {
        const struct ttf_quilt_block *block = &map->blocks[i];
        double own = sqrt(block->error / (3.0 * map->frames * block->overlap_pixels));

        candidates += block->candidates;
        rms += own;
        report->max_rms_error = own > report->max_rms_error ? own : report->max_rms_error;
        report->single_candidate_blocks += block->candidates == 1;
    }
    report->mean_candidates = map->n_blocks > 1 ? candidates / (map->n_blocks - 1) : 0.0;
    report->mean_rms_error = map->n_blocks > 1 ? rms / (map->n_blocks - 1) : 0.0;
    if (map->frames == 0)
        report->mean_rms_error = report->max_rms_error = (double)NAN;
}

static int sum_up(struct run *run, const struct ttf_quilt_map *map, struct ttf_render *render,
                  struct ttf_err *err)
{
    struct ttf_quilt_report *report = &run->report;

    sum_up_blocks(map, report);
    ttf_render_costs(render, report);
    if (run->figures)
        report->frame_bytes += ttf_figures_bytes(run->figures);
    if (run->handed_on > 0) /* and so without figures */
        report->repetition = run->sums.repetition;
    else if ((run->figures ? ttf_figures_finish(run->figures, map, report)
                           : ttf_repetition_of_map(map, &report->repetition)) < 0)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory for the figures of repetition");
    return 0;
}

static int render_all(struct run *run, struct ttf_quilt_map *ret_first, struct ttf_err *err)
{
    const struct ttf_render_job job = {.config = run->config,
                                       .sources = &run->sources,
                                       .map = &run->map,
                                       .figures = run->figures,
                                       .sink = run->sink,
                                       .pool = run->pool,
                                       .first = run->handed_on,
                                       .frames = run->frames,
                                       .progress_from = PLAN_SHARE};
    struct ttf_render *render;
    int r = ttf_render_create(&job, &render);

    if (r < 0)
        return ttf_err_set(err, r, NULL, "no memory for frames of %u x %u", run->config->width,
                           run->config->height);
    r = run->config->per_frame ? all_alone(run, render, ret_first, err)
                               : ttf_render_all(render, err);
    if (r == 0)
        r = sum_up(run, ret_first->source ? ret_first : &run->map, render, err);
    ttf_render_destroy(render);
    return r;
}

/* A map's own pace and rounding, where the caller does not say otherwise. */
static struct ttf_quilt_config as_replayed(const struct ttf_quilt_config *config)
{
    struct ttf_quilt_config own = *config;

    if (own.replay && own.replay->rate.m && !own.rate)
        own.rate = &own.replay->rate;
    if (own.replay && own.replay->rounded)
        own.jitter_round = true;
    return own;
}

int ttf_quilt_run(const struct ttf_quilt_config *config, struct ttf_sequence *input,
                  struct ttf_pool *pool, const struct ttf_quilt_sink *sink,
                  struct ttf_quilt_report *ret_report, struct ttf_quilt_map *ret_map,
                  struct ttf_err *err)
{
    struct run run = {.given = as_replayed(config), .pool = pool, .sink = sink};
    struct ttf_quilt_map first = {0};
    int64_t start_ns;
    int r;

    config = run.config = &run.given;
    start_ns = now_ns(&run);
    r = ttf_quilt_validate(config, input, err);

    if (r == 0)
        r = ttf_sources_of(config, input, &run.sources, err);
    if (r < 0)
        return r;
    run.inner = *config;
    run.inner.progress = config->per_frame ? NULL : plan_progress;
    run.inner.progress_ctx = &run;
    r = start(&run, err);
    if (r == 0 && !config->per_frame)
        r = find_map(&run, err);
    if (r == 0)
        r = render_all(&run, &first, err);
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
