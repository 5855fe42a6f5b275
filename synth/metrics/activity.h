/* SPDX-License-Identifier: Apache-2.0 */
/* activity.h: activity pixel by pixel, for figures that weigh pixels by how often they were copied. */
#ifndef TTF_SYNTH_METRICS_ACTIVITY_H
#define TTF_SYNTH_METRICS_ACTIVITY_H

#include "ttf/synth/metrics.h"

/* Before the first frame: keep a sum of absolute differences for each pixel. -1: no memory. */
TTF_MUST_USE int ttf_activity_keep_pixels(struct ttf_activity *activity);

/* Per pixel, over channels and time, codes. NULL unless kept. Belongs to the activity. */
const uint32_t *ttf_activity_pixels(const struct ttf_activity *activity);

#endif
