/* SPDX-License-Identifier: Apache-2.0 */
/* registration.h: by how much one picture is moved against another. Private to preparation. */
#ifndef TTF_SYNTH_PREPARE_REGISTRATION_H
#define TTF_SYNTH_PREPARE_REGISTRATION_H

#include <stdint.h>

#include "ttf/base/attr.h"
#include "ttf/base/err.h"
#include "ttf/dataset/sequence.h"

#define REGISTRATION_LEVELS     6u
/* Sides that pictures must have at least. */
#define REGISTRATION_LEAST_SIDE 16u

/* The gradient of smoothed luminance, on a pyramid. */
struct gradients {
    uint32_t shrink; /* input pixels to one of level 0 */
    uint32_t levels; /* each half the size of the one before */
    uint32_t width[REGISTRATION_LEVELS], height[REGISTRATION_LEVELS];
    float *x[REGISTRATION_LEVELS], *y[REGISTRATION_LEVELS]; /* the planes of each level */
    float *planes;                                          /* owns all of them */
};

struct shift {
    double x, y; /* input pixels: what is at p in the one is at p + shift in the other */
};

/* Reads frame t in strips; pictures beyond 2048 pixels are taken at half their size, or less. */
TTF_MUST_USE int ttf_gradients_load(struct ttf_sequence *input, uint32_t t, struct gradients *ret,
                                    struct ttf_err *err);
void ttf_gradients_free(struct gradients *gradients);

/*
 * Finds where `moved` lies against `still`, within radius_px of `centre`; among equals
 * the one nearest to `likely`. Returns the correlation of the gradients there, 0..1;
 * 0 if there are none, and then *ret is `likely`.
 */
double ttf_registration_find(const struct gradients *still, const struct gradients *moved,
                             struct shift centre, double radius_px, struct shift likely,
                             struct shift *ret);

#endif
