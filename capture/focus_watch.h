/* SPDX-License-Identifier: Apache-2.0 */
/*
 * focus_watch.h: whether pictures of one shot lose sharpness: a lens that creeps, fogs or was touched.
 *
 * The sample itself changes, so nothing is compared with the first picture: the figure's median over a few
 * pictures is held against the best it has been since the last word. Each further fall of a tenth is told once.
 */
#ifndef TTF_CAPTURE_PRIVATE_FOCUS_WATCH_H
#define TTF_CAPTURE_PRIVATE_FOCUS_WATCH_H

#include <stdbool.h>

#define TTF_FOCUS_MEDIAN 5    /* pictures: one that somebody walked through is not told */
#define TTF_FOCUS_FALL   0.10 /* of the best */

/* Zeroed at the beginning. */
struct ttf_focus_watch {
    double recent[TTF_FOCUS_MEDIAN];
    unsigned n;  /* pictures so far */
    double best; /* median since the last word; 0: none yet */
};

/*
 * One more picture's figure (ttf_image_figures.sharpness; NaN and what is not above 0 are passed over). True if it
 * is to be told: *ret_fall is by how much of the best the median has fallen.
 */
bool ttf_focus_watch_look(struct ttf_focus_watch *watch, double sharpness, double *ret_fall);

#endif
