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

/* Positions that wait for others to be compared with. */
struct abreast {
    struct ttf_rank_position at[TTF_RANK_ABREAST];
    uint32_t bounds[TTF_RANK_ABREAST];
    unsigned n;
};

/* The first n pixels of up to four positions of one view, side by side. */
static void sums_abreast(const struct ttf_rank_workspace *w, const struct abreast *list, size_t n,
                         uint64_t limit, uint64_t ret[TTF_RANK_ABREAST])
{
    const struct ttf_view *view = &w->search->views->list[list->at[0].view];
    size_t stride = w->search->matching->stride, each = stride / TTF_COEF_LANES;
    const int16_t *from[TTF_RANK_ABREAST];

    for (unsigned i = 0; i < TTF_RANK_ABREAST; i++) {
        const struct ttf_rank_position *at = &list->at[i < list->n ? i : 0];

        from[i] = view->coefs + ((size_t)at->y * view->width + at->x) * stride;
    }
    w->search->kernels->ssd_at4(from, w->at + list->at[0].view * w->template.n_pixels * each,
                                w->template.coefs, n * each, limit, ret);
}

static uint64_t whole(double limit)
{
    return limit < 0.0 ? 0 : limit < (double)UINT64_MAX ? (uint64_t)limit : UINT64_MAX;
}

/* Leaves out what the pixels that no fine cell holds exclude, together with what the cells have at least. */
static void exclude_by_rest(const struct ttf_rank_workspace *w, struct abreast *list)
{
    uint64_t rest[TTF_RANK_ABREAST];
    double left[TTF_RANK_ABREAST], most = -1.0;
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
                           uint64_t ret[TTF_RANK_ABREAST])
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
    uint64_t errors[TTF_RANK_ABREAST];

    errors_abreast(w, list, errors);
    for (unsigned i = 0; i < list->n; i++)
        tighten(w, errors[i]);
    list->n = 0;
}

void ttf_rank_look_at(struct ttf_rank_workspace *w, const struct ttf_rank_position *list,
                      unsigned n)
{
    struct abreast abreast = {.n = 0};

    for (unsigned i = 0; i < n; i++) {
        if (abreast.n == TTF_RANK_ABREAST || (abreast.n > 0 && list[i].view != abreast.at[0].view))
            look_abreast(w, &abreast);
        abreast.at[abreast.n++] = list[i];
    }
    look_abreast(w, &abreast);
}

static int compare_abreast(struct ttf_rank_workspace *w, struct abreast *list)
{
    uint64_t errors[TTF_RANK_ABREAST];
    int r = 0;

    errors_abreast(w, list, errors);
    for (unsigned i = 0; i < list->n && r == 0; i++) {
        if ((double)errors[i] > w->limit)
            continue;
        tighten(w, errors[i]);
        r = add_found(w, &list->at[i], errors[i]);
    }
    list->n = 0;
    return r;
}

/* What passed by its bound: by the rest, then in full, four at a time. */
struct funnel {
    struct abreast first, second;
};

static int drain(struct ttf_rank_workspace *w, struct funnel *funnel)
{
    int r = 0;

    exclude_by_rest(w, &funnel->first);
    for (unsigned i = 0; i < funnel->first.n && r == 0; i++) {
        funnel->second.at[funnel->second.n++] = funnel->first.at[i];
        if (funnel->second.n == TTF_RANK_ABREAST)
            r = compare_abreast(w, &funnel->second);
    }
    funnel->first.n = 0;
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
        struct abreast *first = &funnel.first;

        if (bounds[at] > limit)
            continue;
        first->bounds[first->n] = bounds[at];
        first->at[first->n++] =
            (struct ttf_rank_position){index, (uint32_t)(at % columns), (uint32_t)(at / columns)};
        if (first->n < TTF_RANK_ABREAST)
            continue;
        r = drain(w, &funnel);
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
