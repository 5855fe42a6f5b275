/* SPDX-License-Identifier: Apache-2.0 */
#include "focus_watch.h"

static double median(const double recent[TTF_FOCUS_MEDIAN])
{
    double sorted[TTF_FOCUS_MEDIAN];

    for (unsigned i = 0; i < TTF_FOCUS_MEDIAN; i++) {
        unsigned at = i;

        for (; at > 0 && sorted[at - 1] > recent[i]; at--)
            sorted[at] = sorted[at - 1];
        sorted[at] = recent[i];
    }
    return sorted[TTF_FOCUS_MEDIAN / 2];
}

bool ttf_focus_watch_look(struct ttf_focus_watch *watch, double sharpness, double *ret_fall)
{
    double now;

    if (!(sharpness > 0))
        return false;
    watch->recent[watch->n++ % TTF_FOCUS_MEDIAN] = sharpness;
    if (watch->n < TTF_FOCUS_MEDIAN)
        return false;
    if (watch->n >= 2 * TTF_FOCUS_MEDIAN) /* only "enough" and the place in the ring matter */
        watch->n -= TTF_FOCUS_MEDIAN;
    now = median(watch->recent);
    if (now >= watch->best * (1 - TTF_FOCUS_FALL)) {
        watch->best = now > watch->best ? now : watch->best;
        return false;
    }
    *ret_fall = 1 - now / watch->best;
    watch->best = now;
    return true;
}
