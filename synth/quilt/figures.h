/* SPDX-License-Identifier: Apache-2.0 */
/* figures.h: what is measured while frames go by: temporal activity, seams, colours, synchrony. */
#ifndef TTF_SYNTH_QUILT_FIGURES_H
#define TTF_SYNTH_QUILT_FIGURES_H

#include "search/sources.h"
#include "ttf/base/attr.h"
#include "ttf/dataset/pool.h"
#include "ttf/synth/quilt.h"
#include "ttf/synth/report.h"

struct ttf_figures;

/* config and sources must outlive it. frames: of the output. -ENOMEM. */
TTF_MUST_USE int ttf_figures_create(const struct ttf_quilt_config *config,
                                    const struct ttf_sources *sources, uint32_t frames,
                                    struct ttf_figures **ret);
void ttf_figures_destroy(struct ttf_figures *figures); /* NULL allowed */

/* The map of the frames to come; it must live until the next one's or the end. -ENOMEM. */
TTF_MUST_USE int ttf_figures_map(struct ttf_figures *figures, const struct ttf_quilt_map *map);

/*
 * Output frame t. source: the sources' frame t (pixels x 3 codes), NULL if there is none (a slowed
 * output is longer than its input). pool: may be NULL.
 */
void ttf_figures_add(struct ttf_figures *figures, uint32_t t, const uint16_t *source,
                     const uint16_t *output, struct ttf_pool *pool);

/* All of it into the report; map: the one that is reported on. -ENOMEM. */
TTF_MUST_USE int ttf_figures_finish(struct ttf_figures *figures, const struct ttf_quilt_map *map,
                                    struct ttf_quilt_report *report);

/* Bytes it holds. */
size_t ttf_figures_bytes(const struct ttf_figures *figures);

#endif
