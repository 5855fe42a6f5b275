/* SPDX-License-Identifier: Apache-2.0 */
/* plan_private.h: a plan in the making, shared by plan.c (order) and place.c (one block). */
#ifndef TTF_SYNTH_QUILT_PLAN_PRIVATE_H
#define TTF_SYNTH_QUILT_PLAN_PRIVATE_H

#include "quilt/placement.h"
#include "search/block_search.h"
#include "search/matching.h"
#include "search/rank_search.h"
#include "search/sources.h"
#include "search/views.h"
#include "ttf/base/attr.h"
#include "ttf/synth/quilt.h"

/* What placing one block needs to itself. */
struct ttf_place_room {
    struct ttf_rank_workspace *search;
    uint32_t *known; /* block height x width */
    uint64_t *error; /* of one arm */
    uint32_t *cut;   /* of one arm */
    struct ttf_position_rect *excluded;
    int64_t search_ns, cut_ns;
};

struct ttf_plan {
    const struct ttf_quilt_config *config;
    struct ttf_pool *pool;
    struct ttf_placement placement;
    struct ttf_sources sources;
    uint64_t seed;
    struct ttf_quilt_map map;
    /* in k-space */
    struct ttf_matching matching;
    struct ttf_views views;
    struct ttf_rank_search rank;
    /* over all frames */
    struct ttf_trajectories trajectories;
    struct ttf_search *full; /* NULL: in k-space */
    unsigned n_rooms;
    struct ttf_place_room *rooms; /* one for each worker */
};

/*
 * Chooses, cuts and pastes block i (its place is known). All blocks that it overlaps must
 * have been placed. -ENOMEM.
 */
TTF_MUST_USE int ttf_place_block(struct ttf_plan *plan, struct ttf_place_room *room, unsigned i);

#endif
