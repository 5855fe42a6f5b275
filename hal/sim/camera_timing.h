/* SPDX-License-Identifier: Apache-2.0 */
/*
 * camera_timing.h: when a free-running rolling-shutter sensor exposes. Pure.
 * Private to hal/sim. Boot-clock nanoseconds.
 *
 * A frame is named by the instant B at which its first row is read out. Row r
 * is read at B + r * line and was exposed during the exposure time before. In
 * free running, B follows B at the frame period. Settings written now
 * reach the frame that begins `delay` - 1 periods later.
 */
#ifndef TTF_HAL_SIM_CAMERA_TIMING_H
#define TTF_HAL_SIM_CAMERA_TIMING_H

#include <stdbool.h>
#include <stdint.h>

struct camera_timing {
    int64_t period_ns, period_max_ns, readout_ns, line_ns;
    unsigned delay_frames;
    bool steerable;
    int64_t grid_ns; /* steered readouts B fall on whole lines of B + grid_ns */
};

/* Duration of a frame of this exposure. */
int64_t camera_timing_frame_ns(const struct camera_timing *t, int64_t exposure_ns);

/* From B to the middle of the frame's exposure (may be negative). */
int64_t camera_timing_middle_ns(const struct camera_timing *t, int64_t exposure_ns);

/*
 * B of the first frame of a set that is submitted at now_ns, when free running
 * reads out at phase_ns + k * period; middle_ns: wanted, 0 = as soon as possible.
 */
int64_t camera_timing_first_ns(const struct camera_timing *t, int64_t phase_ns, int64_t now_ns,
                               int64_t exposure_ns, int64_t middle_ns);

/* Bound on abs(middle - wanted), timestamps' jitter apart. */
int64_t camera_timing_bound_ns(const struct camera_timing *t);

/* Nearest multiple of step >= min, within min..max. */
int64_t camera_quantise(int64_t value, int64_t min, int64_t max, int64_t step);

#endif
