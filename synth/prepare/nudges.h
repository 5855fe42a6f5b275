/* SPDX-License-Identifier: Apache-2.0 */
/* nudges.h: where each frame of a sequence lies. Private to preparation. */
#ifndef TTF_SYNTH_PREPARE_NUDGES_H
#define TTF_SYNTH_PREPARE_NUDGES_H

#include "prepare/registration.h"

/*
 * ret[t]: where frame t lies against the middle frame. Frames that are like their
 * neighbour nowhere are taken to lie where it does, and counted. -ERANGE: beyond the limit.
 */
TTF_MUST_USE int ttf_nudges_find(struct ttf_sequence *input, double limit_px, struct shift *ret,
                                 uint32_t *ret_unlike, struct ttf_err *err);

#endif
