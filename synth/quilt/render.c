/* SPDX-License-Identifier: Apache-2.0 */
#include "quilt/render.h"

#include <errno.h>
#include <stdbool.h>
#include <stdlib.h>

#include "quilt/compose.h"
#include "quilt/timed.h"
#include "ttf/synth/cancel.h"

/* Source frames held where pixels are of different times: the smallest board still has room. */
#define WINDOW_BYTES ((size_t)64 << 20)

/* Parts that composing a frame is cut into: enough for any number of threads there is. */
#define PARTS 16u

/* What else is done in a round: a frame is handed on, measured, and another read. The longest first. */
#define OTHERS 3u

/* A frame on its way: read, put together, handed on. Three are in work at once. */
struct stage {
    void *source, *output; /* 16-bit codes, or 8-bit ones */
};

struct ttf_render {
    struct ttf_render_job job;
    bool narrow; /* 8-bit codes all the way */
    size_t code; /* bytes of one */
    struct stage stages[3];
    uint8_t *table;
    uint16_t *scratch; /* narrow: one piece */
    struct ttf_timed *timed;
    bool is_timed;
    size_t bytes;
    int64_t render_ns, sink_ns, metrics_ns;
    /* of the running round: frame `hand` is handed on and measured, hand + 1 put together, hand + 2 read */
    int64_t hand;
    int read_code, hand_code;
    struct ttf_err read_err, hand_err;
};

static int64_t now_ns(const struct ttf_render *r)
{
    const struct ttf_quilt_config *config = r->job.config;

    return config->now_ns ? config->now_ns(config->now_ctx) : 0;
}

/* What the map says counts: a replayed one may be blended or of its own times, whatever was asked for. */
static bool is_narrow(const struct ttf_render_job *job)
{
    const struct ttf_quilt_config *config = job->config;

    return job->sink->rows8 && !job->figures && !config->per_frame && !config->rate &&
           !job->map->times && job->map->n_layers == 0;
}

static int alloc_stages(struct ttf_render *r)
{
    size_t in = (size_t)r->job.sources->pixels * 3 * r->code;
    size_t out = (size_t)r->job.config->width * r->job.config->height * 3 * r->code;

    for (int i = 0; i < 3; i++) {
        bool both = !r->is_timed || i == 0; /* a timed frame is put together alone */

        if (!both)
            continue;
        r->stages[i].source = malloc(in);
        r->stages[i].output = malloc(out);
        if (!r->stages[i].source || !r->stages[i].output)
            return -ENOMEM;
        r->bytes += in + out;
    }
    if (!r->narrow)
        return 0;
    r->table = malloc(65536);
    r->scratch = malloc(TTF_SOURCES_PIECE * sizeof(*r->scratch));
    if (!r->table || !r->scratch)
        return -ENOMEM;
    ttf_display8_table(&r->job.sources->list[0]->encoding, r->table);
    return 0;
}

int ttf_render_create(const struct ttf_render_job *job, struct ttf_render **ret)
{
    struct ttf_render *r = calloc(1, sizeof(*r));

    if (!r)
        return -ENOMEM;
    r->job = *job;
    r->narrow = is_narrow(job);
    r->code = r->narrow ? 1 : sizeof(uint16_t);
    r->is_timed = job->config->rate || (!job->config->per_frame && job->map->times);
    if (alloc_stages(r) < 0 || (r->is_timed && ttf_timed_create(job->config, job->map, job->sources,
                                                                WINDOW_BYTES, &r->timed) < 0)) {
        ttf_render_destroy(r);
        return -ENOMEM;
    }
    if (r->timed)
        r->bytes += ttf_timed_bytes(r->timed);
    *ret = r;
    return 0;
}

void ttf_render_destroy(struct ttf_render *render)
{
    if (!render)
        return;
    for (int i = 0; i < 3; i++) {
        free(render->stages[i].source);
        free(render->stages[i].output);
    }
    free(render->table);
    free(render->scratch);
    ttf_timed_destroy(render->timed);
    free(render);
}

static int read_frame(struct ttf_render *r, uint32_t t, void *dst, struct ttf_err *err)
{
    if (r->narrow)
        return ttf_sources_read_codes(r->job.sources, t, r->table, r->scratch, dst, err);
    return ttf_sources_read(r->job.sources, t, dst, err);
}

/* Figures of a frame. with_source: the input has such a frame. */
static void measure(struct ttf_render *r, uint32_t t, const struct stage *stage, bool with_source)
{
    int64_t start_ns = now_ns(r);

    if (r->job.figures)
        ttf_figures_add(r->job.figures, t, with_source ? stage->source : NULL, stage->output, NULL);
    r->metrics_ns += now_ns(r) - start_ns;
}

static int hand_on(struct ttf_render *r, uint32_t t, const struct stage *stage, struct ttf_err *err)
{
    const struct ttf_quilt_sink *sink = r->job.sink;
    int64_t start_ns = now_ns(r);
    int code = r->narrow ? sink->rows8(sink->ctx, t, 0, r->job.config->height, stage->output, err)
                         : sink->frame(sink->ctx, t, stage->output, err);

    r->sink_ns += now_ns(r) - start_ns;
    return code < 0 ? code : 0;
}

/* A frame that is put together alone. */
struct alone {
    struct ttf_render *render;
    uint32_t t;
    bool with_source;
    int code;
    struct ttf_err err;
};

static void alone_tile(void *ctx, unsigned tile, unsigned worker)
{
    struct alone *alone = ctx;
    struct stage *stage = &alone->render->stages[0];

    (void)worker;
    if (tile == 0)
        alone->code = hand_on(alone->render, alone->t, stage, &alone->err);
    else
        measure(alone->render, alone->t, stage, alone->with_source);
}

int ttf_render_one(struct ttf_render *r, uint32_t t, struct ttf_err *err)
{
    struct stage *stage = &r->stages[0];
    struct alone alone = {.render = r, .t = t, .with_source = t < r->job.sources->frames};
    int64_t start_ns = now_ns(r);
    int code = 0;

    if (alone.with_source && (!r->timed || r->job.figures))
        code = read_frame(r, t, stage->source, err);
    if (code == 0 && r->timed)
        code = ttf_timed_frame(r->timed, t, r->job.pool, stage->output, err);
    else if (code == 0)
        ttf_compose_frame(r->job.map, r->job.pool, stage->source, stage->output);
    r->render_ns += now_ns(r) - start_ns;
    if (code < 0)
        return code;
    ttf_pool_run(r->job.pool, 2, alone_tile, &alone);
    if (alone.code < 0 && err)
        *err = alone.err;
    return alone.code;
}

/* ---- the pipeline ---- */

static void compose_part(struct ttf_render *r, int64_t t, unsigned part)
{
    const struct stage *stage = &r->stages[t % 3];
    uint32_t height = r->job.map->height;
    uint32_t y0 = (uint32_t)((uint64_t)height * part / PARTS);
    uint32_t y1 = (uint32_t)((uint64_t)height * (part + 1) / PARTS);

    if (r->narrow)
        ttf_compose_rows8(r->job.map, stage->source, y0, y1, stage->output);
    else
        ttf_compose_rows(r->job.map, stage->source, y0, y1, stage->output);
}

static void round_tile(void *ctx, unsigned tile, unsigned worker)
{
    struct ttf_render *r = ctx;
    int64_t frames = r->job.frames, hand = r->hand;
    const struct stage *done = hand >= r->job.first ? &r->stages[hand % 3] : NULL;

    (void)worker;
    if (tile == 0) {
        if (done)
            r->hand_code = hand_on(r, (uint32_t)hand, done, &r->hand_err);
    } else if (tile == 1) {
        if (done)
            measure(r, (uint32_t)hand, done, true);
    } else if (tile == 2) {
        if (hand + 2 < frames)
            r->read_code =
                read_frame(r, (uint32_t)(hand + 2), r->stages[(hand + 2) % 3].source, &r->read_err);
    } else if (hand + 1 >= r->job.first && hand + 1 < frames) {
        compose_part(r, hand + 1, tile - OTHERS);
    }
}

static int one_round(struct ttf_render *r, struct ttf_err *err)
{
    int64_t next = r->hand + 1;

    ttf_pool_run(r->job.pool, OTHERS + PARTS, round_tile, r);
    if (!r->narrow && next >= r->job.first && next < r->job.frames)
        ttf_compose_layers(r->job.map, r->stages[next % 3].source, r->stages[next % 3].output);
    if (r->hand_code < 0 || r->read_code < 0) {
        if (err)
            *err = r->hand_code < 0 ? r->hand_err : r->read_err;
        return r->hand_code < 0 ? r->hand_code : r->read_code;
    }
    return 0;
}

static void show_progress(const struct ttf_render *r, int64_t done)
{
    const struct ttf_quilt_config *config = r->job.config;
    double from = r->job.progress_from;

    if (config->progress)
        config->progress(config->progress_ctx, from + (1.0 - from) * (double)done / r->job.frames);
}

int ttf_render_all(struct ttf_render *r, struct ttf_err *err)
{
    const struct ttf_quilt_config *config = r->job.config;
    int64_t frames = r->job.frames, start_ns = now_ns(r);
    int code = 0;

    for (r->hand = (int64_t)r->job.first - (r->timed ? 0 : 2); r->hand < frames && code == 0;
         r->hand++) {
        if (ttf_cancelled(config->cancel))
            return ttf_err_set(err, -ECANCELED, NULL, "cancelled");
        code = r->timed ? ttf_render_one(r, (uint32_t)r->hand, err) : one_round(r, err);
        if (r->hand >= r->job.first)
            show_progress(r, r->hand + 1);
    }
    if (!r->timed)
        r->render_ns = now_ns(r) - start_ns;
    return code;
}

void ttf_render_costs(const struct ttf_render *r, struct ttf_quilt_report *report)
{
    report->render_ns += r->render_ns;
    report->sink_ns += r->sink_ns;
    report->metrics_ns += r->metrics_ns;
    report->frame_bytes += r->bytes;
}
