/* SPDX-License-Identifier: Apache-2.0 */
/* One block: the candidates within tolerance, a pick by hash of (seed, block), the cuts. */
#include <errno.h>

#include "quilt/avoid.h"
#include "quilt/paste.h"
#include "quilt/plan_private.h"
#include "seam/boundary_cut.h"
#include "search/hash.h"

static int64_t now_ns(const struct ttf_quilt_config *config)
{
    return config->now_ns ? config->now_ns(config->now_ctx) : 0;
}

/* The ids under the block, as far as they are known; returns how many. */
static uint32_t gather_known(const struct ttf_plan *plan, const struct ttf_quilt_block *block,
                             uint32_t *known)
{
    uint32_t n = 0;

    for (uint32_t y = 0; y < block->height; y++) {
        for (uint32_t x = 0; x < block->width; x++) {
            bool is = x < block->left || y < block->top || x + block->right >= block->width ||
                      y + block->bottom >= block->height;

            *known++ =
                is ? plan->map.source[ttf_block_pixel(&plan->map, block, x, y)] : TTF_UNKNOWN_ID;
            n += is;
        }
    }
    return n;
}

static unsigned view_of(const struct ttf_plan *plan, const struct ttf_quilt_block *block)
{
    unsigned i = 0;

    while (plan->views.list[i].input != block->input || plan->views.list[i].turn != block->turn)
        i++;
    return i;
}

/* Where the block would go on as its left or upper neighbour does. */
static unsigned find_hints(const struct ttf_plan *plan, unsigned i, struct ttf_rank_position *ret)
{
    const struct ttf_quilt_block *block = &plan->map.blocks[i];
    uint32_t columns = plan->placement.columns;
    const struct ttf_quilt_block *from[2] = {block->left > 0 ? block - 1 : NULL,
                                             block->top > 0 ? block - columns : NULL};
    unsigned n = 0;

    for (int k = 0; k < 2; k++) {
        if (from[k])
            ret[n++] = (struct ttf_rank_position){view_of(plan, from[k]),
                                                  from[k]->src_x + block->out_x - from[k]->out_x,
                                                  from[k]->src_y + block->out_y - from[k]->out_y};
    }
    return n;
}

static void take(const struct ttf_plan *plan, struct ttf_quilt_block *block,
                 const struct ttf_rank_position *at)
{
    const struct ttf_view *view = &plan->views.list[at->view];

    block->src_x = at->x;
    block->src_y = at->y;
    block->input = (uint8_t)view->input;
    block->turn = (uint8_t)view->turn;
}

/* The first block: any position of any view. */
static void choose_first(const struct ttf_plan *plan, struct ttf_quilt_block *block,
                         uint64_t random)
{
    uint32_t all = 0, pick;

    for (unsigned i = 0; i < plan->views.n; i++) {
        const struct ttf_view *view = &plan->views.list[i];

        if (view->width >= block->width && view->height >= block->height)
            all += (view->width - block->width + 1) * (view->height - block->height + 1);
    }
    pick = ttf_pick(random, all);
    block->candidates = all;
    for (unsigned i = 0; i < plan->views.n; i++) {
        const struct ttf_view *view = &plan->views.list[i];
        uint32_t columns, own;

        if (view->width < block->width || view->height < block->height)
            continue;
        columns = view->width - block->width + 1;
        own = columns * (view->height - block->height + 1);
        if (pick < own) {
            take(plan, block, &(struct ttf_rank_position){i, pick % columns, pick / columns});
            return;
        }
        pick -= own;
    }
}

static int choose_in_rank(struct ttf_plan *plan, struct ttf_place_room *room, unsigned i,
                          uint64_t random)
{
    struct ttf_quilt_block *block = &plan->map.blocks[i];
    double unit = plan->matching.scale * plan->matching.scale;
    struct ttf_rank_position hints[2];
    struct ttf_rank_query query = {.width = block->width,
                                   .height = block->height,
                                   .known = room->known,
                                   .excluded = room->excluded,
                                   .hints = hints};
    const struct ttf_rank_candidate *candidate;
    struct ttf_rank_result result;
    int r;

    query.n_hints = find_hints(plan, i, hints);
    query.n_excluded = ttf_avoid_find(plan, i, room->excluded);
    r = ttf_rank_search_run(&plan->rank, room->search, &query, &result);
    if (r < 0)
        return r;
    candidate = &result.list[ttf_pick(random, result.n)];
    take(plan, block, &candidate->position);
    block->candidates = result.n;
    block->error = (double)candidate->error / unit;
    block->best_error = (double)result.best / unit;
    return 0;
}

static int choose_in_full(struct ttf_plan *plan, const struct ttf_place_room *room, unsigned i,
                          uint64_t random)
{
    struct ttf_quilt_block *block = &plan->map.blocks[i];
    const struct ttf_overlap overlap = {block->width, block->height, block->left,
                                        block->top,   room->known,   block->width};
    struct ttf_candidates candidates;
    uint32_t position, pick;
    int r = ttf_search_run(plan->full, &overlap, &candidates);

    if (r < 0)
        return r;
    pick = ttf_pick(random, candidates.n);
    position = candidates.positions[pick];
    block->src_x = position % candidates.columns;
    block->src_y = position / candidates.columns;
    block->candidates = candidates.n;
    block->error = (double)candidates.errors[pick];
    block->best_error = (double)candidates.best;
    return 0;
}

/* What the cut sees at one pixel: squared differences summed over channels and all frames. */
static uint64_t pixel_error(const struct ttf_plan *plan, uint32_t known, uint32_t fresh)
{
    const struct ttf_matching *m = &plan->matching;

    if (plan->full)
        return ttf_kernels_best()->ssd_u8(ttf_trajectory(&plan->trajectories, known),
                                          ttf_trajectory(&plan->trajectories, fresh),
                                          plan->trajectories.dims);
    return plan->rank.kernels->ssd_i16(m->coefs + (size_t)known * m->stride,
                                       m->coefs + (size_t)fresh * m->stride, m->stride);
}

/* One arm: `steps` along the cut, `width` across it; (x0, y0) its corner in the block, `down` its direction. */
struct arm {
    uint32_t x0, y0, steps, width;
    bool down;
};

static int cut_arm(const struct ttf_plan *plan, struct ttf_place_room *room,
                   const struct ttf_quilt_block *block, const struct arm *arm, uint16_t *cuts)
{
    const struct ttf_quilt_input *input = &plan->map.inputs[block->input];
    struct ttf_view view;
    int r;

    ttf_view_geometry(input->width, input->height, input->first, block->turn, &view);
    for (uint32_t s = 0; s < arm->steps; s++) {
        for (uint32_t w = 0; w < arm->width; w++) {
            uint32_t x = arm->x0 + (arm->down ? w : s), y = arm->y0 + (arm->down ? s : w);

            room->error[(size_t)s * arm->width + w] =
                pixel_error(plan, room->known[(size_t)y * block->width + x],
                            ttf_view_id(&view, block->src_x + x, block->src_y + y));
        }
    }
    r = ttf_boundary_cut(room->error, arm->steps, arm->width, room->cut, NULL);
    for (uint32_t s = 0; s < arm->steps && r == 0; s++)
        cuts[s] = (uint16_t)room->cut[s];
    return r;
}

static int find_cuts(struct ttf_plan *plan, struct ttf_place_room *room,
                     const struct ttf_quilt_block *b)
{
    struct ttf_block_cut_places cuts = ttf_block_cut_places(&plan->map, b);
    const struct arm arms[4] = {{0, 0, b->height, b->left, true},
                                {b->width - b->right, 0, b->height, b->right, true},
                                {0, 0, b->width, b->top, false},
                                {0, b->height - b->bottom, b->width, b->bottom, false}};
    uint16_t *to[4] = {cuts.left, cuts.right, cuts.top, cuts.bottom};
    int r = 0;

    for (int i = 0; i < 4 && r == 0; i++) {
        if (arms[i].width > 0)
            r = cut_arm(plan, room, b, &arms[i], to[i]);
    }
    return r;
}

int ttf_place_block(struct ttf_plan *plan, struct ttf_place_room *room, unsigned i)
{
    struct ttf_quilt_block *block = &plan->map.blocks[i];
    uint64_t random = ttf_random64(plan->seed, TTF_PURPOSE_BLOCK, i);
    int64_t start_ns = now_ns(plan->config), chosen_ns;
    int r = 0;

    block->overlap_pixels = gather_known(plan, block, room->known);
    if (block->overlap_pixels == 0)
        choose_first(plan, block, random);
    else if (plan->full)
        r = choose_in_full(plan, room, i, random);
    else
        r = choose_in_rank(plan, room, i, random);
    chosen_ns = now_ns(plan->config);
    if (r == 0)
        r = find_cuts(plan, room, block);
    if (r == 0)
        r = ttf_paste_block(&plan->map, i, NULL);
    room->search_ns += chosen_ns - start_ns;
    room->cut_ns += now_ns(plan->config) - chosen_ns;
    return r;
}
