/* SPDX-License-Identifier: Apache-2.0 */
/*
 * basis.h: a few orthonormal directions of trajectory space that hold most of
 * what the trajectories are: an approximation of V_k of eq. 5, from a sample of
 * the pixels.
 *
 * Any orthonormal set serves the exact search, which only takes bounds from it; a
 * better one makes it faster. The search in k-space (section 5.2) has factors of all
 * pixels instead: factors.h.
 */
#ifndef TTF_SYNTH_SEARCH_BASIS_H
#define TTF_SYNTH_SEARCH_BASIS_H

#include <stddef.h>

#include "search/trajectories.h"
#include "ttf/base/attr.h"

struct ttf_basis {
    size_t dims;
    unsigned rank; /* at most the rank asked for and dims */
    double *v;     /* dims x stride, a column per direction; columns from rank on are 0 */
    unsigned stride;
};

/* rank 1..stride. Where dims <= rank, the unit vectors. -ENOMEM. */
TTF_MUST_USE int ttf_basis_find(const struct ttf_trajectories *trajectories, unsigned rank,
                                unsigned stride, struct ttf_basis *ret);
void ttf_basis_free(struct ttf_basis *basis);

/* ret[0..stride-1] = V^T trajectory. */
void ttf_basis_project(const struct ttf_basis *basis, const uint8_t *trajectory, double *ret);

#endif
