/* SPDX-License-Identifier: Apache-2.0 */
#include "noise.h"

#include <math.h>

double noise_normal_inverse(double p)
{
    const double tail = p < 0.5 ? p : 1.0 - p;
    const double log_tail = log(tail);
    double x;

    if (tail >= 0.5)
        return 0.0;
    /* Newton's method on the logarithm of the lower tail, which is concave: it converges from here. */
    x = tail > 0.2 ? -0.5 : -sqrt(-2.0 * log_tail) + 0.5;
    for (int i = 0; i < 12; i++) {
        const double cdf = 0.5 * erfc(-x * M_SQRT1_2);
        const double pdf = exp(-0.5 * x * x) * 0.3989422804014327;
        const double step = (log(cdf) - log_tail) * cdf / pdf;

        x -= step;
        if (fabs(step) < 1e-12)
            break;
    }
    return p < 0.5 ? x : -x;
}

void noise_normal_init(struct noise_normal *ret)
{
    for (int i = 1; i < NOISE_NORMAL_CELLS; i++)
        ret->at[i] = (float)noise_normal_inverse((double)i / NOISE_NORMAL_CELLS);
    ret->at[0] = ret->at[1]; /* not used: the end cells are exact */
    ret->at[NOISE_NORMAL_CELLS] = ret->at[NOISE_NORMAL_CELLS - 1];
}

/* Below this mean the distribution is summed term by term. */
#define POISSON_EXACT_BELOW 12.0f

float noise_poisson(const struct noise_normal *n, float mean, uint32_t bits)
{
    float z, x;

    if (!(mean > 0.0f))
        return 0.0f;
    if (mean < POISSON_EXACT_BELOW) {
        const float u = ((float)(bits >> 8) + 0.5f) * (1.0f / 16777216.0f);
        float term = expf(-mean), sum = term;
        int k = 0;

        while (u > sum && k < 64) {
            k++;
            term *= mean / (float)k;
            sum += term;
        }
        return (float)k;
    }
    /* The first two terms of Cornish and Fisher's expansion: mean, variance and skewness. */
    z = noise_normal(n, bits);
    x = mean + sqrtf(mean) * z + (z * z - 1.0f) * (1.0f / 6.0f);
    return x > 0.0f ? x : 0.0f;
}
