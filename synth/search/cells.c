/* SPDX-License-Identifier: Apache-2.0 */
#include "search/cells.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "search/eigen.h"
#include "search/factor_kernels.h"
#include "search/hash.h"

#define SAMPLES  768u
#define ROUNDS   4
#define DIMS_MAX (TTF_CELL_SIDE_MAX * TTF_CELL_SIDE_MAX * TTF_CELL_NUMBERS)

_Static_assert(TTF_CELL_NUMBERS_FINE <= TTF_COEF_LANES,
               "a pixel has no fewer numbers than are read");
_Static_assert(TTF_CELL_SIDE_FINE *TTF_CELL_SIDE_FINE *TTF_CELL_NUMBERS_FINE <= DIMS_MAX,
               "a fine cell fits");

uint32_t ttf_cells_side(unsigned level, uint32_t overlap)
{
    uint32_t best = overlap < 3 ? overlap : 3;

    if (level > 0)
        return overlap < TTF_CELL_SIDE_FINE ? 1 : TTF_CELL_SIDE_FINE;
    /* of equal waste the larger side: fewer cells say as much */
    for (uint32_t side = 4; side <= TTF_CELL_SIDE_MAX && side <= overlap; side++) {
        if (overlap % side <= overlap % best)
            best = side;
    }
    return best;
}

static void gather(const struct ttf_cells *cells,
                   const int16_t *(*pixel)(const void *ctx, unsigned which, uint32_t i),
                   const void *ctx, unsigned which, float *ret)
{
    for (uint32_t i = 0; i < cells->side * cells->side; i++) {
        const int16_t *numbers = pixel(ctx, which, i);

        for (uint32_t k = 0; k < cells->numbers; k++)
            *ret++ = numbers[k];
    }
}

static int16_t stored(float value, float scale)
{
    float scaled = value * scale;

    scaled = scaled > TTF_CELL_MAX ? TTF_CELL_MAX : scaled < -TTF_CELL_MAX ? -TTF_CELL_MAX : scaled;
    return (int16_t)((scaled + 12582912.0f) - 12582912.0f); /* rounds */
}

void ttf_cells_project(const struct ttf_cells *cells,
                       const int16_t *(*pixel)(const void *ctx, unsigned which, uint32_t i),
                       const void *ctx, int16_t *ret)
{
    float in[4][DIMS_MAX], out[4 * TTF_CELL_DIMS];

    for (unsigned which = 0; which < 4; which++)
        gather(cells, pixel, ctx, which, in[which]);
    ttf_rank_kernels_best()->rotate4(cells->basis, cells->dims, TTF_CELL_DIMS, in[0], DIMS_MAX,
                                     out);
    for (int i = 0; i < 4 * TTF_CELL_DIMS; i++)
        ret[i] = stored(out[i], (float)cells->scale);
}

/* ---- the directions ---- */

struct picture {
    const int16_t *coefs;
    uint32_t width;
    size_t stride, corner;
    uint32_t side;
};

static const int16_t *picture_pixel(const void *ctx, unsigned which, uint32_t i)
{
    const struct picture *p = ctx;

    (void)which;
    return p->coefs + (p->corner + (size_t)(i / p->side) * p->width + i % p->side) * p->stride;
}

/* Second moments of sampled cells (numbers are shifted to a mean of 0 already); returns of how many. */
static size_t sample_moments(const struct ttf_cells *cells, struct picture *picture,
                             uint32_t columns, uint32_t rows, double *moments)
{
    size_t dims = cells->dims, positions = (size_t)columns * rows;
    size_t samples = positions < SAMPLES ? positions : SAMPLES;
    float cell[DIMS_MAX] = {0};
    double wide[4][DIMS_MAX];

    for (size_t s = 0; s < samples; s++) {
        size_t from = positions * s / samples, to = positions * (s + 1) / samples;
        size_t at = from + ttf_pick(ttf_random64(0, TTF_PURPOSE_CELLS, s), (uint32_t)(to - from));

        picture->corner = at / columns * picture->width + at % columns;
        gather(cells, picture_pixel, picture, 0, cell);
        for (size_t i = 0; i < dims; i++)
            wide[s % 4][i] = cell[i];
        if (s % 4 < 3 && s + 1 < samples)
            continue;
        for (size_t k = s % 4 + 1; k < 4; k++)
            memset(wide[k], 0, sizeof(wide[k])); /* adds nothing */
        ttf_factor_kernels_best()->add_gram4(wide[0], DIMS_MAX, dims, moments);
    }
    for (size_t i = 0; i < dims; i++) {
        for (size_t j = i + 1; j < dims; j++)
            moments[i * dims + j] = moments[j * dims + i];
    }
    return samples;
}

static void find_directions(struct ttf_cells *cells, const double *moments, double *vectors)
{
    size_t dims = cells->dims, n = TTF_CELL_DIMS < dims ? TTF_CELL_DIMS : dims;

    for (size_t k = 0; k < n; k++) {
        for (size_t i = 0; i < dims; i++) {
            uint64_t random = ttf_random64(1, TTF_PURPOSE_CELLS, k * dims + i);

            vectors[k * dims + i] = (double)(random >> 11) / (double)(1ull << 52) - 1.0;
        }
    }
    ttf_eigen_iterate(moments, dims, vectors, n, ROUNDS, vectors + n * dims);
    for (size_t i = 0; i < dims; i++) {
        for (size_t k = 0; k < n; k++)
            cells->basis[i * TTF_CELL_DIMS + k] = (float)vectors[k * dims + i];
    }
}

/*
 * Four times the deviation along the strongest direction is the largest that can be stored. What is
 * larger is clipped, which brings two numbers only closer together: the bound still holds.
 */
static double scale_for(const struct ttf_cells *cells, const double *moments, const double *vectors,
                        size_t samples)
{
    double variance = 0.0;

    for (size_t i = 0; i < cells->dims && samples > 0; i++) {
        for (size_t j = 0; j < cells->dims; j++)
            variance += vectors[i] * vectors[j] * moments[i * cells->dims + j];
    }
    if (samples > 0)
        variance /= (double)samples;
    return variance > 1.0 ? TTF_CELL_MAX / (4.0 * sqrt(variance)) : TTF_CELL_MAX / 4.0;
}

static uint32_t numbers_of(uint32_t side)
{
    return side <= TTF_CELL_SIDE_FINE ? TTF_CELL_NUMBERS_FINE : TTF_CELL_NUMBERS;
}

int ttf_cells_find(const int16_t *coefs, uint32_t width, uint32_t height, size_t stride,
                   uint32_t side, struct ttf_cells *ret)
{
    struct ttf_cells cells = {.side = side, .numbers = numbers_of(side)};
    struct picture picture = {coefs, width, stride, 0, side};
    double *moments, *vectors;
    size_t samples = 0;

    cells.dims = (size_t)side * side * cells.numbers;
    moments = calloc(cells.dims * cells.dims, sizeof(*moments));
    vectors = calloc(2 * TTF_CELL_DIMS * cells.dims, sizeof(*vectors));
    cells.basis = calloc(cells.dims * TTF_CELL_DIMS, sizeof(*cells.basis));
    if (!moments || !vectors || !cells.basis) {
        free(moments);
        free(vectors);
        ttf_cells_free(&cells);
        return -ENOMEM;
    }
    if (width >= side && height >= side) {
        samples = sample_moments(&cells, &picture, width - side + 1, height - side + 1, moments);
        find_directions(&cells, moments, vectors);
    }
    cells.scale = scale_for(&cells, moments, vectors, samples);
    free(moments);
    free(vectors);
    *ret = cells;
    return 0;
}

void ttf_cells_free(struct ttf_cells *cells)
{
    free(cells->basis);
    memset(cells, 0, sizeof(*cells));
}
