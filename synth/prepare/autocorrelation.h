/* SPDX-License-Identifier: Apache-2.0 */
/* autocorrelation.h: of lines of samples, added up over many of them. Private to preparation. */
#ifndef TTF_SYNTH_PREPARE_AUTOCORRELATION_H
#define TTF_SYNTH_PREPARE_AUTOCORRELATION_H

#include <stdint.h>

#include "ttf/base/attr.h"

struct autocorrelation {
    uint32_t side,
        lags; /* lags 0..lags-1: half a line, and so at least half of it in each product */
    double lines;
    double *product;        /* per lag: of samples that far apart, */
    double *before, *after; /* and the squares of the first ones, and of the second ones */
    float *scratch;
};

/* For lines of `side` samples. 0 or -ENOMEM. */
TTF_MUST_USE int ttf_autocorrelation_create(uint32_t side, struct autocorrelation *ret);
void ttf_autocorrelation_free(struct autocorrelation *ac);

void ttf_autocorrelation_add(struct autocorrelation *ac, const float *line);

/*
 * The lag at which it falls to 1/e (the largest lag if it does not), and the period: the
 * strongest peak after that, if it is above 0.3, of equally strong ones the first; else 0.
 * Lines without variation: 0 and 0.
 */
void ttf_autocorrelation_find(const struct autocorrelation *ac, double *ret_length,
                              double *ret_period);

#endif
