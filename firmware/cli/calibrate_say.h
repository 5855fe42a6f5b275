/* SPDX-License-Identifier: Apache-2.0 */
/* calibrate_say.h: what a calibration holds, for people and as JSON. */
#ifndef TTFBOX_CALIBRATE_SAY_H
#define TTFBOX_CALIBRATE_SAY_H

#include "cli.h"
#include "ttf/dataset/calibration.h"

/* All of it. */
void calibrate_say(struct cli *cli, const struct ttf_calibration *calibration, const char *folder);

/* How steady the light was found; nothing where that was not measured. */
void calibrate_say_flicker(struct cli *cli, const struct ttf_calibration *calibration);

/* How large a pixel is; nothing where that was not measured. */
void calibrate_say_geometry(struct cli *cli, const struct ttf_calibration *calibration);

/* What to do about a light that is not steady. mains_hz: of the plan, 0: none. */
void calibrate_advise(struct cli *cli, const struct ttf_flicker *flicker, double mains_hz);

#endif
