/* SPDX-License-Identifier: Apache-2.0 */
/* manifest_of_plan.h: what dataset.json says of a capture; whether a dataset takes a plan. Pure. */
#ifndef TTF_CAPTURE_PRIVATE_MANIFEST_OF_PLAN_H
#define TTF_CAPTURE_PRIVATE_MANIFEST_OF_PLAN_H

#include "ttf/capture/plan.h"
#include "ttf/dataset/calibration.h"
#include "ttf/dataset/manifest.h"

/* Whether a run of the plan develops that camera's frames with the calibration, which is one camera's: others go without. */
bool ttf_plan_calibrates(const struct ttf_plan *plan, const struct ttf_calibration *calibration,
                         const char *camera);

/*
 * The plan has been checked on the box. calibration: that of the run, NULL for none: images developed with a flat are
 * reflectances, others radiances; its geometry gives the scale of its own camera's pixels where the plan gives none.
 */
TTF_MUST_USE int ttf_manifest_of_plan(const struct ttf_plan *plan, const struct ttf_box *box,
                                      const struct ttf_calibration *calibration,
                                      struct ttf_manifest *ret, struct ttf_err *err);

/* Whether the plan's images fit the streams of a dataset that is there: 0 or -EINVAL. */
TTF_MUST_USE int ttf_manifest_takes_plan(const struct ttf_manifest *manifest,
                                         const struct ttf_manifest *wanted, struct ttf_err *err);

#endif
