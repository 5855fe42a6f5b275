/* SPDX-License-Identifier: Apache-2.0 */
#include "exposure.h"

#include <math.h>

/* Between waking to submit a set and the camera having it: scheduling noise of a loaded board. */
#define SUBMIT_MARGIN_NS (20 * TTF_NS_PER_MS)

int64_t ttf_exposure_snap(int64_t exposure_ns, double mains_hz, int64_t max_ns)
{
    double half_ns = mains_hz > 0 ? 1e9 / (2 * mains_hz) : 0;
    double n;

    if (mains_hz <= 0)
        return max_ns > 0 && exposure_ns > max_ns ? max_ns : exposure_ns;
    n = floor((double)exposure_ns / half_ns + 0.5);
    if (n < 1)
        n = 1;
    if (max_ns > 0 && n * half_ns > (double)max_ns + 0.5)
        n = floor(((double)max_ns + 0.5) / half_ns);
    return llround(n * half_ns);
}

unsigned ttf_shot_images(const struct ttf_plan_shot *shot)
{
    return shot->n_brackets > 1 ? shot->n_brackets : 1;
}

struct ttf_exposure ttf_shot_exposure(const struct ttf_plan_shot *shot, unsigned image,
                                      double mains_hz, int64_t max_ns)
{
    struct ttf_exposure e = shot->exposure;
    double relative = shot->n_brackets > 1 ? shot->brackets[image] : 1;

    e.exposure_ns = ttf_exposure_snap(e.exposure_ns, mains_hz, max_ns);
    if (relative != 1)
        e.exposure_ns =
            ttf_exposure_snap(llround((double)e.exposure_ns * relative), mains_hz, max_ns);
    return e;
}

int64_t ttf_exposures_span_ns(const struct ttf_camera_caps *caps, int64_t exposure_ns, unsigned n)
{
    int64_t each = exposure_ns > caps->frame_period_ns ? exposure_ns : caps->frame_period_ns;

    /* Readout is at most a frame period; a frame that was just missed is another. */
    return (int64_t)n * each + 2 * each;
}

int64_t ttf_exposure_lead_ns(const struct ttf_camera_caps *caps, int64_t exposure_ns)
{
    int64_t half = exposure_ns / 2 + caps->frame_period_ns;
    int64_t longer = exposure_ns - caps->frame_period_ns;
    int64_t lead = caps->lead_ns + (longer > 0 ? longer * caps->long_frames : 0);

    /* A long exposure under way must end first; the frame's own half comes before its middle. */
    if (lead < half)
        lead = half;
    return lead + exposure_ns + SUBMIT_MARGIN_NS;
}
