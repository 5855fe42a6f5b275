/* SPDX-License-Identifier: Apache-2.0 */
/*
 * rank_curve.h: what a rank of the compression misses of a sequence (Enrique et al. 2005,
 * figure 5): factors alone, nothing is synthesized.
 */
#ifndef TTF_SYNTH_RANK_CURVE_H
#define TTF_SYNTH_RANK_CURVE_H

#include <stdint.h>

#include "ttf/base/attr.h"
#include "ttf/base/err.h"
#include "ttf/dataset/pool.h"
#include "ttf/synth/quilt.h"

struct ttf_quilt_rank_curve {
    unsigned n;                            /* ranks 0 .. n - 1 */
    double errors[TTF_QUILT_RANK_MAX + 1]; /* e_k = sqrt(sum_{i>k} s_i^2 / sum s_i^2) */
    double rms[TTF_QUILT_RANK_MAX + 1];    /* of the reconstruction, over full scale */
};

/*
 * Of config: rank (1..64, the last of the curve), per_channel, metric, more, cancel. Memory: about
 * 4 (rank + 8) bytes per pixel (three times that per channel), for any number of
 * frames. -EINVAL (a rank of none), -ENOMEM, -ECANCELED, the sequence's errors.
 */
TTF_MUST_USE int ttf_quilt_rank_curve(const struct ttf_quilt_config *config,
                                      struct ttf_sequence *input, struct ttf_pool *pool,
                                      struct ttf_quilt_rank_curve *ret, struct ttf_err *err);

#endif
