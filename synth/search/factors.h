/* SPDX-License-Identifier: Apache-2.0 */
/*
 * factors.h: U_k S_k of the trajectories (Enrique et al. 2005, eq. 4, 5), streamed:
 * T (a row per pixel, a column per frame and channel) is never in memory.
 *
 * Frames are appended in batches. With C the coefficients so far (pixels x room) and D
 * the batch's columns, the new C is [C D] W, where W holds the leading orthonormal
 * directions of the small matrix [C D]^T [C D], estimated from sampled pixels. As
 * W is orthonormal, distances between rows of C never exceed those between trajectories,
 * and what each step drops is measured exactly, over all pixels (`error`).
 * So a dataset that has grown is gone on with, not begun anew (`append` after `finish`).
 *
 * One factorisation of all three channels (a row of 3 n values per pixel), or one of each.
 */
#ifndef TTF_SYNTH_SEARCH_FACTORS_H
#define TTF_SYNTH_SEARCH_FACTORS_H

#include <stddef.h>
#include <stdint.h>

#include "ttf/base/attr.h"
#include "ttf/dataset/pool.h"

#define TTF_FACTORS_BATCH    16 /* frames appended at once, at most */
#define TTF_FACTORS_ROOM_MAX 96

struct ttf_factors {
    size_t pixels;
    unsigned room;         /* columns kept, a multiple of 8 */
    int channel;           /* 0..2: of this one alone; -1: of all three */
    uint32_t frames;       /* appended so far */
    float *coefs;          /* pixels x room: U S */
    uint64_t *tile_energy; /* sums of squared codes, in parts */
    uint64_t *energy;      /* of each pixel: sum of its squared codes */
    double *singular;      /* room values, descending; valid after ttf_factors_finish */
    /* of the running batch */
    size_t dims;    /* room + columns of the batch */
    float *w;       /* dims x room */
    double *gram;   /* dims x dims */
    double *vector; /* room x dims: directions, one per row; and as much again to work in */
    uint32_t *sample;
    size_t n_samples;
};

/* room: 8..TTF_FACTORS_ROOM_MAX, a multiple of 8. pixels >= 1. -ENOMEM. */
TTF_MUST_USE int ttf_factors_create(size_t pixels, unsigned room, int channel,
                                    struct ttf_factors *ret);
void ttf_factors_free(struct ttf_factors *factors); /* a zeroed one is fine */

/*
 * Three steps of appending n <= TTF_FACTORS_BATCH frames of pixels x 3 codes: `learn` finds the
 * directions, alone in its thread; `rotate` turns the pixels of one tile, each once, by any threads;
 * `rotated` ends it. The frames must be the same in all; nothing else may come in between.
 */
void ttf_factors_learn(struct ttf_factors *factors, const uint8_t *const *frames, unsigned n);
void ttf_factors_rotate(struct ttf_factors *factors, const uint8_t *const *frames, unsigned n,
                        unsigned tile);
void ttf_factors_rotated(struct ttf_factors *factors, unsigned n);

/* Turns C to its principal axes, strongest first, and fills `singular`. May be followed by more frames. -ENOMEM. */
TTF_MUST_USE int ttf_factors_finish(struct ttf_factors *factors, struct ttf_pool *pool);

/* Tiles of all pixels: entries of tile_energy. */
unsigned ttf_factors_tiles(const struct ttf_factors *factors);

/* Sum of the squares of all codes that were appended. */
double ttf_factors_energy(const struct ttf_factors *factors);

/* e_k = sqrt(sum_{i>k} s_i^2 / sum s_i^2), of all that was appended. k <= room. After finish. */
double ttf_factors_error(const struct ttf_factors *factors, unsigned k);

/* Sum of squares of what rank k misses, codes^2. */
double ttf_factors_missed(const struct ttf_factors *factors, unsigned k);

#endif
