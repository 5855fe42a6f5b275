/* SPDX-License-Identifier: Apache-2.0 */
/*
 * exposure.h: snapping exposures to the mains, and the settings of every image of
 * a plan. Pure; locking them on a camera is shoot.h's.
 */
#ifndef TTF_CAPTURE_PRIVATE_EXPOSURE_H
#define TTF_CAPTURE_PRIVATE_EXPOSURE_H

#include "ttf/capture/plan.h"

/*
 * The whole number of mains half-periods nearest to exposure_ns: at least one,
 * and no more than max_ns holds (0: no limit). mains_hz 0: exposure_ns as it is.
 * 0 if not even one half-period fits under max_ns.
 */
int64_t ttf_exposure_snap(int64_t exposure_ns, double mains_hz, int64_t max_ns);

/* Images of a shot: one, or one per bracket. */
unsigned ttf_shot_images(const struct ttf_plan_shot *shot);

/* The settings to ask for image `image` of a shot, snapped. */
struct ttf_exposure ttf_shot_exposure(const struct ttf_plan_shot *shot, unsigned image,
                                      double mains_hz, int64_t max_ns);

/* Time from the first to the last row of n exposures taken one after another. */
int64_t ttf_exposures_span_ns(const struct ttf_camera_caps *caps, int64_t exposure_ns, unsigned n);

/* How long before the middle of its first exposure a set must be submitted. */
int64_t ttf_exposure_lead_ns(const struct ttf_camera_caps *caps, int64_t exposure_ns);

#endif
