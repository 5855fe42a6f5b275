/* SPDX-License-Identifier: Apache-2.0 */
/* quilt_control.h: the pace of ageing from --rate-map, --light or --curvature. */
#ifndef CLI_QUILT_CONTROL_H
#define CLI_QUILT_CONTROL_H

#include "cli.h"
#include "ttf/synth/rate_map.h"

/* *ret stays empty (m NULL) if there is no such option. Errors name the option. */
TTF_MUST_USE int quilt_control_make(struct cli *cli, uint32_t width, uint32_t height,
                                    struct ttf_rate_map *ret);

/* x,y lines of a file as a spline, and the x of its ends. What is wrong is named by file and line. */
TTF_MUST_USE int quilt_curve_read(struct cli *cli, const char *path, struct ttf_spline **ret,
                                  double *ret_from, double *ret_to);

#endif
