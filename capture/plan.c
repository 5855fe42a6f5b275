/* SPDX-License-Identifier: Apache-2.0 */
#include "ttf/capture/plan.h"

#include <string.h>

#include "ttf/base/time.h"

#define DEFAULT_EXPOSURE_NS   (20 * TTF_NS_PER_MS)
#define DEFAULT_RESERVE_BYTES (INT64_C(256) << 20)

void ttf_plan_defaults(struct ttf_plan *plan)
{
    struct ttf_plan_shot *shot = &plan->shots[0];

    memset(plan, 0, sizeof(*plan));
    plan->lamps = TTF_LAMPS_NONE;
    plan->n_shots = 1;
    plan->mains_hz = 50;
    plan->reserve_bytes = DEFAULT_RESERVE_BYTES;
    strcpy(plan->zone, "UTC");
    strcpy(shot->stream, "main");
    strcpy(shot->camera, "main");
    strcpy(shot->channel, "white");
    shot->exposure.exposure_ns = DEFAULT_EXPOSURE_NS;
    shot->exposure.gain_milli = 1000;
    shot->exposure.wb_r_milli = 1000;
    shot->exposure.wb_b_milli = 1000;
    shot->average = 1;
}
