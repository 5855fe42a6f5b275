/* SPDX-License-Identifier: Apache-2.0 */
/* plan_figures.h: what a plan comes to on a box: times, bytes, memory, lamp hours. Pure. */
#ifndef TTF_CAPTURE_PRIVATE_PLAN_FIGURES_H
#define TTF_CAPTURE_PRIVATE_PLAN_FIGURES_H

#include "ttf/capture/plan.h"

/* Frames of a camera are larger than this: keep only raw by default. */
#define TTF_KEEP_RAW_ABOVE_PIXELS 4000000

/* The camera of that name, or NULL. */
struct ttf_camera *ttf_box_camera_find(const struct ttf_box *box, const char *name);

/* What is kept of frames of that format. */
enum ttf_keep ttf_plan_keep(const struct ttf_plan *plan, const struct ttf_frame_format *format);

/* The region of a frame of that format that is developed. */
struct ttf_region ttf_plan_region(const struct ttf_plan *plan,
                                  const struct ttf_frame_format *format);

/*
 * Lamps that burn from start to end, alike for all shots, settle once: that long
 * before the first slot's lead they are lit. 0 where lamps settle in every slot.
 */
int64_t ttf_first_settle_ns(const struct ttf_plan *plan, const struct ttf_box *box);

/*
 * A shot, from its lamps' command to its last exposure's end; lead is part of it,
 * and settling where it is not done once for all.
 */
int64_t ttf_shot_busy_ns(const struct ttf_plan *plan, const struct ttf_plan_shot *shot,
                         const struct ttf_box *box);

/*
 * From the first lamp command of a slot to the instant it is due. That much
 * before a slot's due time the loop must be free.
 */
int64_t ttf_slot_lead_ns(const struct ttf_plan *plan, const struct ttf_box *box);

/* All figures. box may be NULL: what needs it stays 0. The plan has been checked. */
void ttf_plan_figures_fill(const struct ttf_plan *plan, const struct ttf_box *box,
                           struct ttf_plan_figures *ret);

#endif
