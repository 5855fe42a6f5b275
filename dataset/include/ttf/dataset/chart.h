/* SPDX-License-Identifier: Apache-2.0 */
/*
 * chart.h: a colour chart of 24 patches, what its maker says of them, and how far two colours are apart.
 *
 * Six columns and four rows, patches numbered by rows from the top left; the last row is a grey scale that begins
 * with white. Colours are CIE L*a*b* of illuminant D50, 2 degree observer, as makers of charts publish them. Pure.
 */
#ifndef TTF_DATASET_CHART_H
#define TTF_DATASET_CHART_H

#include "ttf/base/err.h"
#include "ttf/dataset/io.h"

#define TTF_CHART_COLUMNS 6
#define TTF_CHART_ROWS    4
#define TTF_CHART_PATCHES (TTF_CHART_COLUMNS * TTF_CHART_ROWS)
#define TTF_CHART_GREY    18 /* the first patch of the grey scale, counted from 0 */

struct ttf_chart {
    double lab[TTF_CHART_PATCHES][3];
};

/* The ColorChecker Classic as made since November 2014, by its maker's table. */
void ttf_chart_classic(struct ttf_chart *ret);

/* The name that makers give to patch i, "dark skin" to "black". */
const char *ttf_chart_patch_name(unsigned i);

/*
 * A file of values that were measured or came with a chart: 24 lines that end in L*, a* and b*, separated by blanks, tabs,
 * commas or semicolons, by rows from the top left; or, where lines begin with A1 to F4 (letter: column, digit: row),
 * in any order. Lines without three numbers, and those that begin with #, are passed over; of a CGATS file only those between
 * BEGIN_DATA and END_DATA count. -EINVAL with the line that does not fit; errors of reading.
 */
TTF_MUST_USE int ttf_chart_load(struct ttf_io *io, const char *path, struct ttf_chart *ret,
                                struct ttf_err *err);

/*
 * Between L*a*b* of D50 and linear light of sRGB primaries and white D65, adapted by Bradford. A perfect diffuser is
 * (100, 0, 0) and (1, 1, 1). Linear values below 0 or above 1 are colours that sRGB has not: they are kept.
 */
void ttf_lab_to_linear(const double lab[3], double ret_rgb[3]);
void ttf_linear_to_lab(const double rgb[3], double ret_lab[3]);

/* CIEDE2000 with all weights 1 (CIE 142-2001; formulae as in Sharma, Wu and Dalal 2005). */
double ttf_delta_e2000(const double lab_a[3], const double lab_b[3]);

#endif
