/* SPDX-License-Identifier: Apache-2.0 */
/* rank_plot.h: a curve of ranks as text: a table, and a picture that every browser shows. */
#ifndef CLI_RANK_PLOT_H
#define CLI_RANK_PLOT_H

#include <stdio.h>

#include "ttf/synth/rank_curve.h"

/* "rank,error,rms_over_full_scale" and a line for each rank. */
void rank_table(FILE *out, const struct ttf_quilt_rank_curve *curve);

/* SVG: e_k in percent over k, logarithmic upwards where no error is 0. title: plain text. */
void rank_plot(FILE *out, const struct ttf_quilt_rank_curve *curve, const char *title);

#endif
