/* SPDX-License-Identifier: Apache-2.0 */
#include <errno.h>
#include <stdlib.h>

#include "search/rank_private.h"

int ttf_rank_place_vectors(struct ttf_rank_workspace *w)
{
    const struct ttf_rank_template *template = &w->template;
    const struct ttf_views *views = w->search->views;
    size_t each = w->search->matching->stride / TTF_COEF_LANES;
    size_t n = template->n_pixels * each;
    uint32_t *to;

    if (n * views->n > w->room_at) {
        free(w->at);
        w->room_at = 0;
        w->at = malloc(n * views->n * sizeof(*w->at));
        if (!w->at)
            return -ENOMEM;
        w->room_at = n * views->n;
    }
    to = w->at;
    for (unsigned v = 0; v < views->n; v++) {
        for (size_t i = 0; i < template->n_runs; i++) {
            const struct ttf_rank_run *run = &template->runs[i];
            size_t from = ((size_t)run->dy * views->list[v].width + run->dx) * each;

            for (size_t k = 0; k < run->length * each; k++)
                *to++ = (uint32_t)(from + k);
        }
    }
    return 0;
}

static int add_found(struct ttf_rank_workspace *w, const struct ttf_rank_position *at,
                     uint64_t error)
{
    if (w->n_found == w->room_found) {
        size_t room = w->room_found ? 2 * w->room_found : 1024;
        struct ttf_rank_candidate *found = realloc(w->found, room * sizeof(*found));

        if (!found)
            return -ENOMEM;
        w->found = found;
        w->room_found = room;
    }
    w->found[w->n_found++] = (struct ttf_rank_candidate){*at, error};
    return 0;
}

/*
 * Positions that wait for others to be compared with: up to four places side by side, each of one position or of two that are neighbours
 * (survivors come in clusters).
 */
struct abreast {
    struct ttf_rank_position at[2 * TTF_RANK_ABREAST];
    uint32_t bounds[2 * TTF_RANK_ABREAST];
    unsigned sum[2 * TTF_RANK_ABREAST]; /* which of the places' sums is whose: two of a place */
    unsigned n, places;
};

/* Neighbours lie one vector apart where a pixel has no more than that. */
static bool has_pairs(const struct ttf_rank_workspace *w)
{
    return w->search->matching->stride == TTF_COEF_LANES;
}

/* Adds a position, if there is a place for it. */
static bool put(const struct ttf_rank_workspace *w, struct abreast *list,
                const struct ttf_rank_position *at, uint32_t bound)
{
    const struct ttf_rank_position *last = list->n > 0 ? &list->at[list->n - 1] : NULL;
    bool follows = last && has_pairs(w) && list->sum[list->n - 1] % 2 == 0 &&
                   at->view == last->view && at->y == last->y && at->x == last->x + 1;

    if (!follows && (list->places == TTF_RANK_ABREAST || (last && at->view != last->view)))
        return false;
    list->places += !follows;
    list->sum[list->n] = 2 * (list->places - 1) + follows;
    list->bounds[list->n] = bound;
    list->at[list->n++] = *at;
    return true;
}

static void clear(struct abreast *list)
{
    list->n = list->places = 0;
}

/* The first n pixels of the positions of one view, side by side. */
static void sums_abreast(const struct ttf_rank_workspace *w, const struct abreast *list, size_t n,
                         uint64_t limit, uint64_t ret[2 * TTF_RANK_ABREAST])
{
    const struct ttf_view *view = &w->search->views->list[list->at[0].view];
    const struct ttf_rank_kernels *kernels = w->search->kernels;
    size_t stride = w->search->matching->stride, each = stride / TTF_COEF_LANES;
    const uint32_t *offsets = w->at + list->at[0].view * w->template.n_pixels * each;
    const int16_t *from[TTF_RANK_ABREAST] = {NULL};
    uint64_t sums[2 * TTF_RANK_ABREAST];

    for (unsigned i = 0, place = 0; i < list->n; i++) {
        const struct ttf_rank_position *at = &list->at[i];

        if (list->sum[i] % 2 == 0)
            from[place++] = view->coefs + ((size_t)at->y * view->width + at->x) * stride;
    }
    for (unsigned place = list->places; place < TTF_RANK_ABREAST; place++)
        from[place] = from[0];
    if (list->n > list->places)
        kernels->ssd_at_pairs(from, offsets, w->template.coefs, n * each, limit, sums);
    else
        kernels->ssd_at4(from, offsets, w->template.coefs, n * each, limit, sums);
    for (unsigned i = 0; i < list->n; i++)
        ret[i] = sums[list->n > list->places ? list->sum[i] : list->sum[i] / 2];
}

static uint64_t whole(double limit)
{
    return limit < 0.0 ? 0 : limit < (double)UINT64_MAX ? (uint64_t)limit : UINT64_MAX;
}

/* Leaves out what the pixels that no fine cell holds exclude, together with what the cells have at least. */
static void exclude_by_rest(const struct ttf_rank_workspace *w, struct abreast *list)
{
    uint64_t rest[2 * TTF_RANK_ABREAST] = {0};
    double left[2 * TTF_RANK_ABREAST] = {0.0}, most = -1.0;
    unsigned kept = 0;

    if (w->template.n_rest == 0 || list->n == 0)
        return;
    for (unsigned i = 0; i < list->n; i++) {
        left[i] = w->limit - ttf_rank_least_of_cells(w, 1, list->bounds[i]);
        most = left[i] > most ? left[i] : most;
    }
    sums_abreast(w, list, w->template.n_rest, whole(most), rest);
    for (unsigned i = 0; i < list->n; i++) {
        if (left[i] >= 0.0 && (double)rest[i] <= left[i])
            list->at[kept++] = list->at[i];
    }
    list->n = kept;
}

/* Errors of the list's positions in full; beyond the limit, any numbers beyond it. */
static void errors_abreast(struct ttf_rank_workspace *w, const struct abreast *list,
                           uint64_t ret[2 * TTF_RANK_ABREAST])
{
    uint64_t limit = whole(w->limit);

    if (list->n > 0 && !w->on_ground)
        sums_abreast(w, list, w->template.n_pixels, limit, ret);
    for (unsigned i = 0; i < list->n; i++) {
        if (w->on_ground)
            ret[i] = ttf_rank_ground_error(&w->ground, w->search, &list->at[i], limit);
        w->counts.exact++;
    }
}

static void tighten(struct ttf_rank_workspace *w, uint64_t error)
{
    if (error >= w->best)
        return;
    w->best = error;
    w->limit = ttf_rank_limit(w->search, w->template.n_pixels, error);
}

static void look_abreast(struct ttf_rank_workspace *w, struct abreast *list)
{
    uint64_t errors[2 * TTF_RANK_ABREAST];

    errors_abreast(w, list, errors);
    for (unsigned i = 0; i < list->n; i++)
        tighten(w, errors[i]);
    clear(list);
}

void ttf_rank_look_at(struct ttf_rank_workspace *w, const struct ttf_rank_position *list,
                      unsigned n)
{
    struct abreast abreast = {.n = 0};

    for (unsigned i = 0; i < n; i++) {
        if (!put(w, &abreast, &list[i], 0)) {
            look_abreast(w, &abreast);
            (void)put(w, &abreast, &list[i], 0);
        }
    }
    look_abreast(w, &abreast);
}

static int compare_abreast(struct ttf_rank_workspace *w, struct abreast *list)
{
    uint64_t errors[2 * TTF_RANK_ABREAST];
    int r = 0;

    errors_abreast(w, list, errors);
    for (unsigned i = 0; i < list->n && r == 0; i++) {
        if ((double)errors[i] > w->limit)
            continue;
        tighten(w, errors[i]);
        r = add_found(w, &list->at[i], errors[i]);
    }
    clear(list);
    return r;
}

/* What passed by its bound: by the rest, then in full, four places at a time. */
struct funnel {
    struct abreast first, second;
};

static int drain(struct ttf_rank_workspace *w, struct funnel *funnel)
{
    int r = 0;

    exclude_by_rest(w, &funnel->first);
    for (unsigned i = 0; i < funnel->first.n && r == 0; i++) {
        if (put(w, &funnel->second, &funnel->first.at[i], 0))
            continue;
        r = compare_abreast(w, &funnel->second);
        (void)put(w, &funnel->second, &funnel->first.at[i], 0);
    }
    clear(&funnel->first);
    return r;
}

static int compare_view(struct ttf_rank_workspace *w, unsigned index, unsigned level,
                        const uint32_t *bounds)
{
    struct funnel funnel = {.first.n = 0};
    uint32_t columns, rows, limit = ttf_rank_cell_limit(w, level);
    double limit_of = w->limit;
    int r = 0;

    ttf_rank_grid(&w->search->views->list[index], w->query, &columns, &rows);
    for (size_t at = 0; at < (size_t)columns * rows && r == 0; at++) {
        struct ttf_rank_position position;

        if (bounds[at] > limit)
            continue;
        position =
            (struct ttf_rank_position){index, (uint32_t)(at % columns), (uint32_t)(at / columns)};
        if (put(w, &funnel.first, &position, bounds[at]))
            continue;
        r = drain(w, &funnel);
        (void)put(w, &funnel.first, &position, bounds[at]);
        if (w->limit != limit_of) {
            limit_of = w->limit;
            limit = ttf_rank_cell_limit(w, level);
        }
    }
    if (r == 0)
        r = drain(w, &funnel);
    return r < 0 ? r : compare_abreast(w, &funnel.second);
}

int ttf_rank_compare_survivors(struct ttf_rank_workspace *w, unsigned level)
{
    const uint32_t *bounds = w->bounds;
    int r = 0;

    w->n_found = 0;
    for (unsigned i = 0; i < w->search->views->n && r == 0; i++) {
        uint32_t columns, rows;

        ttf_rank_grid(&w->search->views->list[i], w->query, &columns, &rows);
        r = compare_view(w, i, level, bounds);
        bounds += (size_t)columns * rows;
    }
    return r;
}
