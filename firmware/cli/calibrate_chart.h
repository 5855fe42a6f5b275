/* SPDX-License-Identifier: Apache-2.0 */
/* calibrate_chart.h: where a colour chart lies in the picture, and what its colours are. */
#ifndef TTFBOX_CALIBRATE_CHART_H
#define TTFBOX_CALIBRATE_CHART_H

#include "cli.h"
#include "ttf/dataset/calibration.h"
#include "ttf/hal/box.h"

/* --corners, or those of the simulated sample; -EINVAL where neither says them. */
TTF_MUST_USE int calibrate_chart_corners(struct cli *cli, const struct ttf_box *box,
                                         struct ttf_chart_view *ret);

/* --values, or the truth of the simulated sample, or the ColorChecker Classic. */
TTF_MUST_USE int calibrate_chart_values(struct cli *cli, const struct ttf_box *box,
                                        struct ttf_chart *ret);

#endif
