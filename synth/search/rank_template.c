/* SPDX-License-Identifier: Apache-2.0 */
#include "search/rank_template.h"

#include <errno.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "search/lanes.h"

static int make_room(struct ttf_rank_template *template, size_t pixels, size_t stride)
{
    if (pixels <= template->room_pixels)
        return 0;
    ttf_rank_template_free(template);
    template->runs = malloc(pixels * sizeof(*template->runs));
    for (int level = 0; level < TTF_CELL_LEVELS; level++)
        template->cells[level] = malloc(pixels * sizeof(*template->cells[level]));
    template->coefs = ttf_lanes_alloc(pixels * stride);
    template->taken = malloc(pixels);
    template->fine = ttf_lanes_alloc(pixels * TTF_CELL_DIMS);
    if (!template->runs || !template->cells[0] || !template->cells[1] || !template->coefs ||
        !template->taken || !template->fine) {
        ttf_rank_template_free(template);
        return -ENOMEM;
    }
    template->room_pixels = pixels;
    return 0;
}

/* Appends the known pixels that lie in a cell, or those that do not, as runs. */
static void gather_runs(struct ttf_rank_template *template, const struct ttf_matching *matching,
                        const struct ttf_rank_query *query, bool taken)
{
    size_t stride = matching->stride;

    for (uint32_t y = 0; y < query->height; y++) {
        struct ttf_rank_run *run = NULL;

        for (uint32_t x = 0; x < query->width; x++) {
            size_t at = (size_t)y * query->width + x;
            uint32_t id = query->known[at];

            if (id == TTF_UNKNOWN_ID || (template->taken[at] != 0) != taken) {
                run = NULL;
                continue;
            }
            if (!run) {
                run = &template->runs[template->n_runs++];
                *run = (struct ttf_rank_run){x, y, 0, template->n_pixels};
            }
            memcpy(template->coefs + template->n_pixels * stride, matching->coefs + id * stride,
                   stride * sizeof(*template->coefs));
            template->n_pixels++;
            run->length++;
        }
    }
}

/* Are all pixels of the cell at (x, y) known, and in no other cell? */
static bool is_free(const struct ttf_rank_template *template, const struct ttf_rank_query *query,
                    uint32_t cell, uint32_t x, uint32_t y)
{
    for (uint32_t i = 0; i < cell * cell; i++) {
        size_t at = (size_t)(y + i / cell) * query->width + x + i % cell;

        if (query->known[at] == TTF_UNKNOWN_ID || template->taken[at])
            return false;
    }
    return true;
}

static void take_pixels(struct ttf_rank_template *template, const struct ttf_rank_query *query,
                        uint32_t cell, uint32_t x, uint32_t y)
{
    for (uint32_t i = 0; i < cell * cell; i++)
        template->taken[(size_t)(y + i / cell) * query->width + x + i % cell] = 1;
}

struct four_cells {
    const struct ttf_matching *matching;
    const struct ttf_rank_query *query;
    uint32_t side;
    const struct ttf_rank_cell *cells[4];
};

static const int16_t *known_pixel(const void *ctx, unsigned which, uint32_t i)
{
    const struct four_cells *four = ctx;
    size_t x = four->cells[which]->dx + i % four->side;
    size_t y = four->cells[which]->dy + i / four->side;

    return four->matching->coefs +
           (size_t)four->query->known[y * four->query->width + x] * four->matching->stride;
}

static void project_cells(struct ttf_rank_template *template, const struct ttf_rank_search *search,
                          const struct ttf_rank_query *query, unsigned level)
{
    const struct ttf_cells *cells = &search->views->levels[level];
    struct ttf_rank_cell *list = template->cells[level];
    struct four_cells four = {search->matching, query, cells->side, {NULL}};
    int16_t values[4 * TTF_CELL_DIMS];
    size_t n = template->n_cells[level];

    for (size_t i = 0; i < n; i += 4) {
        for (size_t k = 0; k < 4; k++)
            four.cells[k] = &list[i + k < n ? i + k : n - 1];
        ttf_cells_project(cells, known_pixel, &four, values);
        for (size_t k = 0; k < 4 && i + k < n; k++)
            memcpy(list[i + k].target.value, values + k * TTF_CELL_DIMS,
                   TTF_CELL_DIMS * sizeof(*values));
    }
}

/* Evenly fewer of very many: fewer cells bound less, never wrongly. The pixels of those that are left out are in none. */
static void thin_out(struct ttf_rank_template *template, const struct ttf_rank_query *query,
                     unsigned level, uint32_t cell)
{
    struct ttf_rank_cell *list = template->cells[level];
    size_t n = template->n_cells[level];

    if (n <= TTF_CELLS_MAX)
        return;
    memset(template->taken, 0, (size_t)query->width * query->height);
    for (size_t i = 0; i < TTF_CELLS_MAX; i++) {
        list[i] = list[i * n / TTF_CELLS_MAX];
        take_pixels(template, query, cell, list[i].dx, list[i].dy);
    }
    template->n_cells[level] = TTF_CELLS_MAX;
}

static void gather_cells(struct ttf_rank_template *template, const struct ttf_rank_search *search,
                         const struct ttf_rank_query *query, unsigned level)
{
    uint32_t cell = search->views->levels[level].side;

    memset(template->taken, 0, (size_t)query->width * query->height);
    template->n_cells[level] = 0;
    for (uint32_t y = 0; y + cell <= query->height; y++) {
        for (uint32_t x = 0; x + cell <= query->width; x++) {
            if (!is_free(template, query, cell, x, y))
                continue;
            template->cells[level][template->n_cells[level]++] =
                (struct ttf_rank_cell){.dx = x, .dy = y};
            take_pixels(template, query, cell, x, y);
        }
    }
    thin_out(template, query, level, cell);
    project_cells(template, search, query, level);
}

int ttf_rank_template_gather(struct ttf_rank_template *template,
                             const struct ttf_rank_search *search,
                             const struct ttf_rank_query *query)
{
    size_t pixels = (size_t)query->width * query->height;
    int r = make_room(template, pixels, search->matching->stride);

    if (r < 0)
        return r;
    memset(template->taken, 0, pixels);
    template->n_runs = template->n_pixels = template->n_rest = 0;
    gather_runs(template, search->matching, query, false);
    gather_cells(template, search, query, 0);
    return 0;
}

void ttf_rank_template_refine(struct ttf_rank_template *template,
                              const struct ttf_rank_search *search,
                              const struct ttf_rank_query *query)
{
    gather_cells(template, search, query, 1);
    for (size_t i = 0; i < template->n_cells[1]; i++)
        memcpy(template->fine + i * TTF_CELL_DIMS, template->cells[1][i].target.value,
               sizeof(template->cells[1][i].target.value));
    template->n_runs = template->n_pixels = 0;
    gather_runs(template, search->matching, query, false);
    template->n_rest = template->n_pixels;
    gather_runs(template, search->matching, query, true);
}

void ttf_rank_template_free(struct ttf_rank_template *template)
{
    free(template->runs);
    for (int level = 0; level < TTF_CELL_LEVELS; level++)
        free(template->cells[level]);
    ttf_lanes_free(template->coefs);
    free(template->taken);
    ttf_lanes_free(template->fine);
    memset(template, 0, sizeof(*template));
}
