/* SPDX-License-Identifier: Apache-2.0 */
#include "search/template.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

static int make_room(struct ttf_template *template, size_t pixels, size_t runs, size_t cells,
                     size_t dims)
{
    if (pixels <= template->room_pixels && runs <= template->room_runs &&
        cells <= template->room_cells)
        return 0;
    ttf_template_free(template);
    template->runs = malloc(runs * sizeof(*template->runs));
    template->cells = malloc((cells + 1) * sizeof(*template->cells));
    template->others = malloc(pixels * sizeof(*template->others));
    template->codes = malloc(pixels * dims);
    template->coefs = malloc(pixels * TTF_PIXEL_COEFS * sizeof(*template->coefs));
    if (!template->runs || !template->cells || !template->codes || !template->coefs ||
        !template->others) {
        ttf_template_free(template);
        return -ENOMEM;
    }
    template->room_pixels = pixels;
    template->room_runs = runs;
    template->room_cells = cells;
    return 0;
}

static void gather_runs(struct ttf_template *template, const struct ttf_trajectories *trajectories,
                        const struct ttf_features *features, const struct ttf_overlap *overlap)
{
    size_t dims = trajectories->dims;
    size_t at = 0;

    template->n_runs = 0;
    template->longest_run = 0;
    for (uint32_t y = 0; y < overlap->height; y++) {
        uint32_t length = y < overlap->top ? overlap->width : overlap->left;

        if (length == 0)
            continue;
        template->runs[template->n_runs++] =
            (struct ttf_template_run){.dx = 0, .dy = y, .length = length, .first = at};
        if (length > template->longest_run)
            template->longest_run = length;
        for (uint32_t x = 0; x < length; x++, at++) {
            uint32_t pixel = overlap->known[y * overlap->stride + x];

            memcpy(template->codes + at * dims, ttf_trajectory(trajectories, pixel), dims);
            if (features->pixels)
                memcpy(template->coefs + at * TTF_PIXEL_COEFS,
                       features->pixels + (size_t)pixel * TTF_PIXEL_COEFS,
                       TTF_PIXEL_COEFS * sizeof(float));
        }
    }
    template->n_pixels = at;
}

/*
 * The one candidate for a majority, by pairing off pixels that differ, and then
 * how many there really are. Pixels that are not of it, as runs.
 */
static void find_ground(struct ttf_template *template, size_t dims)
{
    const uint8_t *codes = template->codes;
    size_t votes = 0;

    template->ground = template->n_ground = template->n_others = 0;
    for (size_t i = 0; i < template->n_pixels; i++) {
        if (votes == 0)
            template->ground = i;
        votes += memcmp(codes + i * dims, codes + template->ground * dims, dims) == 0 ? 1 : -1;
    }
    for (size_t k = 0; k < template->n_runs; k++) {
        const struct ttf_template_run *run = &template->runs[k];
        struct ttf_template_run *last = NULL;

        for (size_t x = 0; x < run->length; x++) {
            size_t at = run->first + x;

            if (memcmp(codes + at * dims, codes + template->ground * dims, dims) == 0) {
                template->n_ground++;
                last = NULL;
            } else if (last) {
                last->length++;
            } else {
                last = &template->others[template->n_others++];
                *last = (struct ttf_template_run){run->dx + (uint32_t)x, run->dy, 1, at};
            }
        }
    }
}

/* Cells that fit whole into a rectangle of the block; pixels left over at its edges are not used. */
static void gather_cells(struct ttf_template *template, const struct ttf_trajectories *trajectories,
                         const struct ttf_features *features, const struct ttf_overlap *overlap,
                         const uint32_t rect[4])
{
    uint32_t c = features->cell;

    for (uint32_t y = rect[1]; y + c <= rect[3]; y += c) {
        for (uint32_t x = rect[0]; x + c <= rect[2]; x += c) {
            struct ttf_template_cell *cell = &template->cells[template->n_cells++];

            *cell = (struct ttf_template_cell){.dx = x, .dy = y};
            for (uint32_t i = 0; i < c * c; i++) {
                size_t known = (y + i / c) * overlap->stride + x + i % c;
                float own[TTF_CELL_PLANES];

                ttf_features_of_pixel(features, trajectories, overlap->known[known], own, NULL);
                for (unsigned d = 0; d < TTF_CELL_PLANES; d++)
                    cell->target[d] += own[d];
            }
            for (unsigned d = 0; d < TTF_CELL_PLANES; d++)
                cell->target[d] /= (float)c;
        }
    }
}

int ttf_template_gather(struct ttf_template *template, const struct ttf_trajectories *trajectories,
                        const struct ttf_features *features, const struct ttf_overlap *overlap)
{
    const uint32_t top[4] = {0, 0, overlap->width, overlap->top};
    const uint32_t left[4] = {0, overlap->top, overlap->left, overlap->height};
    size_t pixels = (size_t)ttf_overlap_pixels(overlap);
    size_t cells = pixels / ((size_t)features->cell * features->cell);
    int r = make_room(template, pixels, overlap->height, cells, trajectories->dims);

    if (r < 0)
        return r;
    gather_runs(template, trajectories, features, overlap);
    find_ground(template, trajectories->dims);
    template->n_cells = 0;
    gather_cells(template, trajectories, features, overlap, top);
    gather_cells(template, trajectories, features, overlap, left);
    return 0;
}

void ttf_template_free(struct ttf_template *template)
{
    free(template->runs);
    free(template->cells);
    free(template->others);
    free(template->codes);
    free(template->coefs);
    memset(template, 0, sizeof(*template));
}
