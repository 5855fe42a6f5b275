/* SPDX-License-Identifier: Apache-2.0 */
#include "ttf/synth/rank_curve.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>

#include "search/learner.h"
#include "search/sources.h"
#include "search/trajectories.h"

/* Columns beyond the last rank asked for, so that its own error is of what was really seen. */
#define SPARE 8u

static void fill(const struct ttf_learner *learner, unsigned rank, struct ttf_quilt_rank_curve *ret)
{
    double energy = 0.0, samples = 0.0;

    for (unsigned i = 0; i < learner->n_factors; i++) {
        const struct ttf_factors *f = &learner->factors[i];

        energy += ttf_factors_energy(f);
        samples += (double)f->pixels * f->frames * (f->channel < 0 ? 3.0 : 1.0);
    }
    ret->n = rank + 1;
    for (unsigned k = 0; k <= rank; k++) {
        double missed = 0.0;

        for (unsigned i = 0; i < learner->n_factors; i++)
            missed += ttf_factors_missed(&learner->factors[i], k);
        ret->errors[k] = energy > 0.0 ? sqrt(missed / energy) : 0.0;
        ret->rms[k] = sqrt(missed / samples) / 255.0;
    }
}

int ttf_quilt_rank_curve(const struct ttf_quilt_config *config, struct ttf_sequence *input,
                         struct ttf_pool *pool, struct ttf_quilt_rank_curve *ret,
                         struct ttf_err *err)
{
    struct ttf_learner learner = {0};
    struct ttf_sources sources;
    uint8_t *table;
    int r;

    if (config->rank < 1 || config->rank > TTF_QUILT_RANK_MAX)
        return ttf_err_set(err, -EINVAL, "rank", "%u is not within 1 and %d", config->rank,
                           TTF_QUILT_RANK_MAX);
    r = ttf_sources_of(config, input, &sources, err);
    if (r < 0)
        return r;
    table = malloc(65536);
    if (!table || ttf_learner_create(sources.pixels, (config->rank + SPARE + 7) / 8 * 8,
                                     config->per_channel, &learner) < 0) {
        free(table);
        return ttf_err_set(err, -ENOMEM, NULL, "no memory for the factors of %u pixels",
                           sources.pixels);
    }
    ttf_metric_table(config->metric, &sources.list[0]->encoding, table);
    r = ttf_learner_add(&learner, &sources, 0, sources.frames, table, NULL, config->cancel, pool,
                        err);
    if (r == 0)
        fill(&learner, config->rank, ret);
    ttf_learner_free(&learner);
    free(table);
    return r;
}
