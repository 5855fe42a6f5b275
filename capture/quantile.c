/* SPDX-License-Identifier: Apache-2.0 */
#include "quantile.h"

#include <math.h>

#define SUB 64 /* bins per octave */

static unsigned bin_of(uint64_t v)
{
    unsigned shift = 0;

    if (v < SUB)
        return (unsigned)v;
    while (v >> shift >= 2 * SUB)
        shift++;
    return SUB + shift * SUB + (unsigned)(v >> shift) - SUB;
}

/* The largest value that falls into a bin. */
static int64_t bin_top(unsigned bin)
{
    unsigned shift;
    uint64_t base;

    if (bin < SUB)
        return bin;
    shift = (bin - SUB) / SUB;
    base = SUB + (bin - SUB) % SUB;
    return (int64_t)(((base + 1) << shift) - 1);
}

void ttf_quantile_add(struct ttf_quantile *q, int64_t ns)
{
    int64_t v = ns < 0 ? -ns : ns;
    unsigned bin = bin_of((uint64_t)v);

    if (bin >= TTF_QUANTILE_BINS)
        bin = TTF_QUANTILE_BINS - 1;
    q->bins[bin]++;
    q->n++;
    if (v > q->max_ns)
        q->max_ns = v;
}

int64_t ttf_quantile_ns(const struct ttf_quantile *q, double quantile)
{
    int64_t rank = (int64_t)ceil(quantile * (double)q->n);
    int64_t seen = 0;

    if (q->n == 0)
        return 0;
    if (rank < 1)
        rank = 1;
    for (unsigned i = 0; i < TTF_QUANTILE_BINS; i++) {
        seen += q->bins[i];
        if (seen >= rank)
            return bin_top(i) < q->max_ns ? bin_top(i) : q->max_ns;
    }
    return q->max_ns;
}
