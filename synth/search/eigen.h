/* SPDX-License-Identifier: Apache-2.0 */
/*
 * eigen.h: the leading directions of a small symmetric matrix. Doubles in a fixed
 * order, no libm but sqrt: the same bits on every machine.
 */
#ifndef TTF_SYNTH_SEARCH_EIGEN_H
#define TTF_SYNTH_SEARCH_EIGEN_H

#include <stddef.h>

/*
 * Orthogonal iteration. a: dims x dims, symmetric, positive semi-definite. v: n rows of dims
 * numbers: holds a first guess, then n orthonormal directions (a direction that carries
 * nothing becomes 0) that span the n leading ones. work: n x dims.
 */
void ttf_eigen_iterate(const double *a, size_t dims, double *v, size_t n, unsigned rounds,
                       double *work);

/*
 * All eigenvectors of a small symmetric matrix (Jacobi rotations), strongest first. a: n x n,
 * destroyed. v: n x n, a row per vector. values: n.
 */
void ttf_eigen_all(double *a, size_t n, double *v, double *values);

#endif
