/* SPDX-License-Identifier: Apache-2.0 */
/*
 * render.h: frames through a map into a sink, streamed. While one thread hands on a
 * frame, the others measure it, put together the next one and read the one after it.
 */
#ifndef TTF_SYNTH_QUILT_RENDER_H
#define TTF_SYNTH_QUILT_RENDER_H

#include "quilt/figures.h"
#include "search/sources.h"
#include "ttf/base/attr.h"
#include "ttf/base/err.h"
#include "ttf/dataset/pool.h"
#include "ttf/synth/run.h"

/* All borrowed. map: filled before the first frame. */
struct ttf_render_job {
    const struct ttf_quilt_config *config;
    const struct ttf_sources *sources;
    const struct ttf_quilt_map *map;
    struct ttf_figures *figures; /* NULL: none */
    const struct ttf_quilt_sink *sink;
    struct ttf_pool *pool;
    uint32_t first,
        frames;           /* the first to be rendered (others were handed on before), and the end */
    double progress_from; /* the bar's place at the first frame */
};

struct ttf_render;

TTF_MUST_USE int ttf_render_create(const struct ttf_render_job *job, struct ttf_render **ret);
void ttf_render_destroy(struct ttf_render *render); /* NULL allowed */

/* Frame t alone, now. */
TTF_MUST_USE int ttf_render_one(struct ttf_render *render, uint32_t t, struct ttf_err *err);

/* All frames. -ECANCELED, the sources' and the sink's errors. */
TTF_MUST_USE int ttf_render_all(struct ttf_render *render, struct ttf_err *err);

/* Adds times and memory to the report. */
void ttf_render_costs(const struct ttf_render *render, struct ttf_quilt_report *report);

#endif
