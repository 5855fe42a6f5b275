/* SPDX-License-Identifier: Apache-2.0 */
#include "search/features.h"

#include <errno.h>
#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

/* Up to this many bytes per pixel the exact comparison is as cheap as 16 floats. */
#define PIXEL_LEVEL_DIMS 96

struct project {
    const struct ttf_trajectories *trajectories;
    struct ttf_features *features;
};

static bool has_pixel_level(size_t dims)
{
    return dims > PIXEL_LEVEL_DIMS;
}

size_t ttf_features_bytes_per_pixel(uint32_t frames)
{
    size_t numbers = TTF_CELL_PLANES + (has_pixel_level((size_t)3 * frames) ? TTF_PIXEL_COEFS : 0);

    return numbers * sizeof(float);
}

static double squared_length(const uint8_t *trajectory, size_t dims)
{
    uint64_t sum = 0;

    for (size_t i = 0; i < dims; i++)
        sum += (uint32_t)trajectory[i] * trajectory[i];
    return (double)sum;
}

/* The first n coefficients and the length of the rest, as floats. */
static float rest_after(const double *coefs, unsigned n, double length2)
{
    for (unsigned k = 0; k < n; k++)
        length2 -= coefs[k] * coefs[k];
    return length2 > 0.0 ? (float)sqrt(length2) : 0.0f;
}

void ttf_features_of_pixel(const struct ttf_features *features,
                           const struct ttf_trajectories *trajectories, size_t pixel,
                           float cell[TTF_CELL_PLANES], float *coefs)
{
    const uint8_t *trajectory = ttf_trajectory(trajectories, pixel);
    double length2 = squared_length(trajectory, trajectories->dims);
    double all[TTF_PIXEL_COEFS];

    ttf_basis_project(&features->basis, trajectory, all);
    for (unsigned k = 0; k + 1 < TTF_CELL_PLANES; k++)
        cell[k] = (float)all[k];
    cell[TTF_CELL_PLANES - 1] = rest_after(all, TTF_CELL_PLANES - 1, length2);
    if (!coefs)
        return;
    for (unsigned k = 0; k + 1 < TTF_PIXEL_COEFS; k++)
        coefs[k] = (float)all[k];
    coefs[TTF_PIXEL_COEFS - 1] = rest_after(all, TTF_PIXEL_COEFS - 1, length2);
}

static void project_row(void *ctx, unsigned y, unsigned worker)
{
    const struct project *project = ctx;
    struct ttf_features *features = project->features;
    size_t row = (size_t)y * features->width;

    (void)worker;
    for (size_t p = row; p < row + features->width; p++) {
        float *coefs = features->pixels ? features->pixels + p * TTF_PIXEL_COEFS : NULL;
        float cell[TTF_CELL_PLANES];

        ttf_features_of_pixel(features, project->trajectories, p, cell, coefs);
        for (unsigned k = 0; k < TTF_CELL_PLANES; k++)
            features->cells[k][p] = cell[k];
    }
}

/*
 * Sums over cells in place, divided by the side: each pass reads only at or
 * behind where it writes. Sums that would reach over the edge are left partial;
 * nobody asks for them.
 */
static void sum_plane(void *ctx, unsigned plane_index, unsigned worker)
{
    const struct ttf_features *features = ctx;
    float *plane = features->cells[plane_index];
    size_t width = features->width, height = features->height, cell = features->cell;

    (void)worker;
    for (size_t y = 0; y < height; y++) {
        for (size_t x = 0; x < width; x++) {
            float *at = plane + y * width + x;

            for (size_t i = 1; i < cell && x + i < width; i++)
                at[0] += at[i];
        }
    }
    for (size_t y = 0; y < height; y++) {
        for (size_t x = 0; x < width; x++) {
            float *at = plane + y * width + x;

            for (size_t i = 1; i < cell && y + i < height; i++)
                at[0] += at[i * width];
            at[0] /= (float)cell;
        }
    }
}

int ttf_features_build(const struct ttf_trajectories *trajectories, uint32_t cell,
                       struct ttf_pool *pool, struct ttf_features *ret)
{
    struct ttf_features out = {
        .width = trajectories->width, .height = trajectories->height, .cell = cell};
    size_t pixels = (size_t)out.width * out.height;
    unsigned rank = has_pixel_level(trajectories->dims) ? TTF_PIXEL_COEFS - 1 : TTF_CELL_PLANES - 1;
    struct project project = {trajectories, &out};
    double largest;
    int r = -ENOMEM;

    for (unsigned i = 0; i < TTF_CELL_PLANES; i++) {
        out.cells[i] = malloc(pixels * sizeof(float));
        if (!out.cells[i])
            goto out;
    }
    if (has_pixel_level(trajectories->dims)) {
        out.pixels = malloc(pixels * TTF_PIXEL_COEFS * sizeof(float));
        if (!out.pixels)
            goto out;
    }
    r = ttf_basis_find(trajectories, rank, TTF_PIXEL_COEFS, &out.basis);
    if (r < 0)
        goto out;
    ttf_pool_run(pool, out.height, project_row, &project);
    ttf_pool_run(pool, TTF_CELL_PLANES, sum_plane, &out);
    /*
     * A number is at most the longest trajectory, times the cell's side; rounding
     * it and the few sums before it loses less than 16 units in the last place.
     */
    largest = 255.0 * sqrt((double)trajectories->dims) * cell;
    out.slack = 16.0 * largest * (double)FLT_EPSILON;
    *ret = out;
    memset(&out, 0, sizeof(out));
out:
    ttf_features_free(&out);
    return r;
}

void ttf_features_free(struct ttf_features *features)
{
    for (unsigned i = 0; i < TTF_CELL_PLANES; i++)
        free(features->cells[i]);
    free(features->pixels);
    ttf_basis_free(&features->basis);
    memset(features, 0, sizeof(*features));
}
