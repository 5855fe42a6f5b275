/* SPDX-License-Identifier: Apache-2.0 */
/* sim_target.h: what a simulated camera looks at, as a target of a calibration. */
#ifndef BOX_SIM_TARGET_H
#define BOX_SIM_TARGET_H

#include "ttf/base/attr.h"
#include "ttf/base/err.h"
#include "ttf/hal/box.h"

/* Of a simulated target the reflectance is known. -EINVAL: one that is not even is no target. */
TTF_MUST_USE int sim_target_reflectance(const struct ttf_box *box, double *ret,
                                        struct ttf_err *err);

#endif
