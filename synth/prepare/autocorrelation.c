/* SPDX-License-Identifier: Apache-2.0 */
#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "prepare/autocorrelation.h"

#define FALLEN     0.36787944117144233 /* 1/e */
#define PEAK_LEAST 0.3
#define AS_STRONG \
    0.9 /* of the strongest peak: multiples of a period differ by little and by chance */
#define VARIATION_LEAST 0.01 /* mean square of display codes */

int ttf_autocorrelation_create(uint32_t side, struct autocorrelation *ret)
{
    struct autocorrelation ac = {.side = side, .lags = side / 2 + 1};

    ac.product = calloc(ac.lags, 3 * sizeof(*ac.product));
    ac.scratch = calloc(ac.lags, sizeof(*ac.scratch));
    if (!ac.product || !ac.scratch) {
        free(ac.product);
        free(ac.scratch);
        return -ENOMEM;
    }
    ac.before = ac.product + ac.lags;
    ac.after = ac.before + ac.lags;
    *ret = ac;
    return 0;
}

void ttf_autocorrelation_free(struct autocorrelation *ac)
{
    free(ac->product);
    free(ac->scratch);
    *ac = (struct autocorrelation){0};
}

/* All lags of one sample at a time: neighbouring sums take neighbouring samples. */
static void add_sample(float *restrict sums, const float *restrict from, uint32_t lags)
{
    float v = from[0];

    for (uint32_t k = 0; k < lags; k++)
        sums[k] += v * from[k];
}

void ttf_autocorrelation_add(struct autocorrelation *ac, const float *line)
{
    double head = 0.0, all = 0.0, tail = 0.0;

    memset(ac->scratch, 0, ac->lags * sizeof(*ac->scratch));
    for (uint32_t x = 0; x < ac->side; x++) {
        uint32_t left = ac->side - x;

        add_sample(ac->scratch, line + x, left < ac->lags ? left : ac->lags);
        all += (double)line[x] * (double)line[x];
    }
    for (uint32_t k = 0; k < ac->lags; k++) {
        ac->product[k] += (double)ac->scratch[k];
        ac->before[k] += all - tail;
        ac->after[k] += all - head;
        head += (double)line[k] * (double)line[k];
        tail += (double)line[ac->side - 1 - k] * (double)line[ac->side - 1 - k];
    }
    ac->lines += 1.0;
}

static double at(const struct autocorrelation *ac, uint32_t lag)
{
    double energy = sqrt(ac->before[lag] * ac->after[lag]);

    return energy > 0.0 ? ac->product[lag] / energy : 0.0;
}

static int is_peak(const struct autocorrelation *ac, uint32_t lag)
{
    return at(ac, lag) > PEAK_LEAST && at(ac, lag) >= at(ac, lag - 1) &&
           at(ac, lag) > at(ac, lag + 1);
}

/* The top of a parabola through the peak and its neighbours. */
static double top(const struct autocorrelation *ac, uint32_t lag)
{
    double a = at(ac, lag - 1), b = at(ac, lag), c = at(ac, lag + 1);

    return lag + 0.5 * (a - c) / (a - 2.0 * b + c);
}

static double period_after(const struct autocorrelation *ac, uint32_t first)
{
    double strongest = 0.0;

    for (uint32_t lag = first; lag + 1 < ac->lags; lag++) {
        if (is_peak(ac, lag))
            strongest = fmax(strongest, at(ac, lag));
    }
    for (uint32_t lag = first; lag + 1 < ac->lags && strongest > 0.0; lag++) {
        if (is_peak(ac, lag) && at(ac, lag) >= AS_STRONG * strongest)
            return top(ac, lag);
    }
    return 0.0;
}

void ttf_autocorrelation_find(const struct autocorrelation *ac, double *ret_length,
                              double *ret_period)
{
    uint32_t lag = 1;

    *ret_length = *ret_period = 0.0;
    if (ac->before[0] <= VARIATION_LEAST * ac->lines * ac->side)
        return;
    while (lag < ac->lags && at(ac, lag) > FALLEN)
        lag++;
    if (lag == ac->lags) {
        *ret_length = ac->lags - 1;
        return;
    }
    *ret_length = lag - 1 + (at(ac, lag - 1) - FALLEN) / (at(ac, lag - 1) - at(ac, lag));
    *ret_period = period_after(ac, lag);
}
