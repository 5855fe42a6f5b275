/* SPDX-License-Identifier: Apache-2.0 */
/* manifest_of_plan.h: what dataset.json says of a capture; whether a dataset takes a plan. Pure. */
#ifndef TTF_CAPTURE_PRIVATE_MANIFEST_OF_PLAN_H
#define TTF_CAPTURE_PRIVATE_MANIFEST_OF_PLAN_H

#include <stdbool.h>

#include "ttf/capture/plan.h"
#include "ttf/dataset/manifest.h"

/* The plan has been checked on the box. flat: images are calibrated reflectances, else radiances. */
TTF_MUST_USE int ttf_manifest_of_plan(const struct ttf_plan *plan, const struct ttf_box *box,
                                      bool flat, struct ttf_manifest *ret, struct ttf_err *err);

/* Whether the plan's images fit the streams of a dataset that is there: 0 or -EINVAL. */
TTF_MUST_USE int ttf_manifest_takes_plan(const struct ttf_manifest *manifest,
                                         const struct ttf_manifest *wanted, struct ttf_err *err);

#endif
