/* SPDX-License-Identifier: Apache-2.0 */
/* curvature.h: of curves and surfaces, as the numbers they are; the maps scale them. */
#ifndef TTF_SYNTH_CONTROL_CURVATURE_H
#define TTF_SYNTH_CONTROL_CURVATURE_H

#include <stdint.h>

/*
 * k = |y''| / (1 + y'^2)^(3/2) (Enrique et al. 2005, eq. 11, 12) at x, by central
 * differences over x - h, x, x + h; what could be rounding of y counts as 0. NaN where y is
 * not finite.
 */
double ttf_control_curve_curvature(double (*y)(void *ctx, double x), void *ctx, double x, double h);

/*
 * Mean curvature of width x height heights z, `pixel` apart, at each of them; -1/R on a dome of radius R
 * (z up). Central differences; at the border those of the nearest place that has them.
 */
void ttf_control_mean_curvature(const double *z, uint32_t width, uint32_t height, double pixel,
                                double *ret);

#endif
