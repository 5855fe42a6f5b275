/* SPDX-License-Identifier: Apache-2.0 */
/*
 * boundary_cut.h: the minimum-error boundary cut (Efros & Freeman 2001, section
 * 2.1), on errors that are summed over all frames already, so that one seam
 * serves all frames.
 */
#ifndef TTF_SYNTH_SEAM_BOUNDARY_CUT_H
#define TTF_SYNTH_SEAM_BOUNDARY_CUT_H

#include <stdint.h>

#include "ttf/base/attr.h"

/*
 * error: steps x width, one row per step along the cut. Writes the cut's position
 * 0..width-1 at each step into cut: successive positions differ by at most 1, the
 * sum of errors on the cut is the smallest possible; of equal ones the lowest
 * index, from the last step backwards. total: the sum; may be NULL. -ENOMEM.
 */
TTF_MUST_USE int ttf_boundary_cut(const uint64_t *error, uint32_t steps, uint32_t width,
                                  uint32_t *cut, uint64_t *ret_total);

#endif
