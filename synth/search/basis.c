/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Orthogonal iteration on T^T T, never formed: V <- orth(T^T (T V)) over sampled
 * pixels. Few rounds are enough, as only bounds depend on it.
 */
#include "search/basis.h"

#include <errno.h>
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "search/hash.h"

#define SAMPLES 1024u
#define ROUNDS  3

void ttf_basis_project(const struct ttf_basis *basis, const uint8_t *trajectory, double *ret)
{
    unsigned stride = basis->stride;

    for (unsigned k = 0; k < stride; k++)
        ret[k] = 0.0;
    for (size_t i = 0; i < basis->dims; i++) {
        const double *v = basis->v + i * stride;
        double code = trajectory[i];

        for (unsigned k = 0; k < stride; k++)
            ret[k] += code * v[k];
    }
}

static double column_dot(const struct ttf_basis *basis, unsigned a, unsigned b)
{
    double sum = 0.0;

    for (size_t i = 0; i < basis->dims; i++)
        sum += basis->v[i * basis->stride + a] * basis->v[i * basis->stride + b];
    return sum;
}

/* Takes the earlier columns out of column k, twice (once loses digits), and makes its length 1. */
static bool orthonormalize_column(struct ttf_basis *basis, unsigned k)
{
    double before = sqrt(column_dot(basis, k, k));
    double after;

    for (unsigned j = 0; j < 2 * k; j++) {
        unsigned other = j % k;
        double dot = column_dot(basis, k, other);

        for (size_t i = 0; i < basis->dims; i++)
            basis->v[i * basis->stride + k] -= dot * basis->v[i * basis->stride + other];
    }
    after = sqrt(column_dot(basis, k, k));
    if (!(after > 1e-6 * before) || !(after > 0.0))
        return false;
    for (size_t i = 0; i < basis->dims; i++)
        basis->v[i * basis->stride + k] /= after;
    return true;
}

/* A column that carries nothing of its own (the data's rank is used up) becomes 0: still a valid bound. */
static void orthonormalize(struct ttf_basis *basis)
{
    for (unsigned k = 0; k < basis->rank; k++) {
        if (orthonormalize_column(basis, k))
            continue;
        for (size_t i = 0; i < basis->dims; i++)
            basis->v[i * basis->stride + k] = 0.0;
    }
}

static void iterate(struct ttf_basis *basis, const struct ttf_trajectories *trajectories,
                    double *next, double *coefs)
{
    size_t pixels = (size_t)trajectories->width * trajectories->height;
    size_t samples = pixels < SAMPLES ? pixels : SAMPLES;
    unsigned stride = basis->stride;

    memset(next, 0, basis->dims * stride * sizeof(*next));
    for (size_t s = 0; s < samples; s++) {
        size_t from = pixels * s / samples, to = pixels * (s + 1) / samples;
        uint64_t random = ttf_random64(0, TTF_PURPOSE_BASIS, s);
        size_t pixel = from + ttf_pick(random, (uint32_t)(to - from));
        const uint8_t *trajectory = ttf_trajectory(trajectories, pixel);

        ttf_basis_project(basis, trajectory, coefs);
        for (size_t i = 0; i < basis->dims; i++) {
            for (unsigned k = 0; k < stride; k++)
                next[i * stride + k] += trajectory[i] * coefs[k];
        }
    }
    memcpy(basis->v, next, basis->dims * stride * sizeof(*next));
    orthonormalize(basis);
}

int ttf_basis_find(const struct ttf_trajectories *trajectories, unsigned rank, unsigned stride,
                   struct ttf_basis *ret)
{
    struct ttf_basis basis = {.dims = trajectories->dims, .stride = stride};
    double *next = NULL, *coefs = NULL;
    int r = -ENOMEM;

    basis.rank = basis.dims < rank ? (unsigned)basis.dims : rank;
    basis.v = calloc(basis.dims * stride, sizeof(*basis.v));
    next = malloc(basis.dims * stride * sizeof(*next));
    coefs = malloc(stride * sizeof(*coefs));
    if (!basis.v || !next || !coefs)
        goto out;
    for (size_t i = 0; i < basis.dims; i++) {
        for (unsigned k = 0; k < basis.rank; k++) {
            uint64_t random = ttf_random64(1, TTF_PURPOSE_BASIS, i * stride + k);

            basis.v[i * stride + k] =
                basis.dims <= rank ? (i == k) : (double)(random >> 11) / (double)(1ull << 52) - 1.0;
        }
    }
    if (basis.dims > rank) {
        orthonormalize(&basis);
        for (int round = 0; round < ROUNDS; round++)
            iterate(&basis, trajectories, next, coefs);
    }
    *ret = basis;
    basis.v = NULL;
    r = 0;
out:
    free(coefs);
    free(next);
    free(basis.v);
    return r;
}

void ttf_basis_free(struct ttf_basis *basis)
{
    free(basis->v);
    memset(basis, 0, sizeof(*basis));
}
