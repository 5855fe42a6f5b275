/* SPDX-License-Identifier: Apache-2.0 */
#include "camera_timing.h"

int64_t camera_timing_frame_ns(const struct camera_timing *t, int64_t exposure_ns)
{
    /* A few lines of blanking follow a long exposure. */
    int64_t needed = exposure_ns + 4 * t->line_ns;

    return needed > t->period_ns ? needed : t->period_ns;
}

int64_t camera_timing_middle_ns(const struct camera_timing *t, int64_t exposure_ns)
{
    return (t->readout_ns - exposure_ns) / 2;
}

static int64_t floor_div(int64_t a, int64_t b)
{
    return a >= 0 ? a / b : -((-a + b - 1) / b);
}

/* The first instant of the grid phase + k * period at or after `at`. */
static int64_t grid_from(int64_t phase, int64_t period, int64_t at)
{
    return phase - floor_div(phase - at, period) * period;
}

/*
 * The duration nearest to `wanted` (>= frame) that whole frames can add up to:
 * the set's own first frame and some before it, each between the period and its
 * longest.
 */
static int64_t reachable(const struct camera_timing *t, int64_t frame, int64_t wanted)
{
    int64_t before = (wanted - frame) / t->period_ns;
    int64_t longest =
        (frame > t->period_max_ns ? frame : t->period_max_ns) + before * t->period_max_ns;
    int64_t one_more = frame + (before + 1) * t->period_ns;

    if (wanted > longest)
        return wanted - longest < one_more - wanted ? longest : one_more;
    return wanted;
}

/* To the nearest whole line, so that where a frame falls depends on nothing but where it was wanted. */
static int64_t on_grid(const struct camera_timing *t, int64_t read)
{
    int64_t at = read + t->grid_ns + t->line_ns / 2;

    return floor_div(at, t->line_ns) * t->line_ns - t->grid_ns;
}

int64_t camera_timing_first_ns(const struct camera_timing *t, int64_t phase_ns, int64_t now_ns,
                               int64_t exposure_ns, int64_t middle_ns)
{
    int64_t lead = (int64_t)(t->delay_frames > 0 ? t->delay_frames - 1 : 0) * t->period_ns;
    int64_t frame = camera_timing_frame_ns(t, exposure_ns);
    int64_t begin = grid_from(phase_ns, t->period_ns, now_ns + lead);
    int64_t wanted = middle_ns > 0 ? middle_ns - camera_timing_middle_ns(t, exposure_ns) : 0;

    if (wanted <= begin + frame)
        return begin + frame;
    if (t->steerable)
        return on_grid(t, begin + reachable(t, frame, wanted - begin));
    return begin + frame +
           (wanted - begin - frame + t->period_ns / 2) / t->period_ns * t->period_ns;
}

int64_t camera_timing_bound_ns(const struct camera_timing *t)
{
    int64_t gap = 2 * t->period_ns - t->period_max_ns;

    if (!t->steerable)
        return t->period_ns / 2 + 1;
    return t->line_ns / 2 + 1 + (gap > 0 ? gap / 2 : 0);
}

int64_t camera_quantise(int64_t value, int64_t min, int64_t max, int64_t step)
{
    if (value <= min)
        return min;
    if (value > max)
        value = max;
    value = min + (value - min + step / 2) / step * step;
    return value > max ? value - step : value;
}
