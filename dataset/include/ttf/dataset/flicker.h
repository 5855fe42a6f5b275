/* SPDX-License-Identifier: Apache-2.0 */
/*
 * flicker.h: how much light changes from frame to frame, and within a frame, although nothing moves. Pure.
 *
 * Rows are exposed one after the other: what ripples while a frame is read out shows as bands across it, what is left of a
 * ripple over a whole exposure as frames of different brightness. Both are measured on frames of a still subject
 * that were taken alike, relative to the mean of all; a slow drift (lamps that warm up) is told apart.
 */
#ifndef TTF_DATASET_FLICKER_H
#define TTF_DATASET_FLICKER_H

#include "ttf/base/err.h"
#include "ttf/base/frame.h"
#include "ttf/dataset/calibration.h"

#define TTF_FLICKER_FRAMES_LEAST 8

/* Frames of one kind, remembered by the mean levels of their bands of rows: some kilobytes each. */
struct ttf_flicker_frames {
    struct ttf_frame_format format;
    struct ttf_exposure settings; /* of the first */
    unsigned n, room, bands;
    double *level;     /* room x bands: codes above black */
    int64_t *start_ns; /* room: when each was exposed */
    uint64_t saturated, samples;
};

/* Room for frames of that format. -EINVAL: fewer than TTF_FLICKER_FRAMES_LEAST, or a format that cannot be; -ENOMEM. */
TTF_MUST_USE int ttf_flicker_init(struct ttf_flicker_frames *frames,
                                  const struct ttf_frame_format *format, unsigned room,
                                  struct ttf_err *err);

/* One frame, as a sum of one. -EINVAL: of another format, or not of one; -ENOSPC beyond the room. */
TTF_MUST_USE int ttf_flicker_add(struct ttf_flicker_frames *frames, const struct ttf_raw_sum *frame,
                                 int64_t start_ns);

void ttf_flicker_free(struct ttf_flicker_frames *frames);

/*
 * The figures. Refused with a reason, -EINVAL: too few frames, saturated (more than one sample in 200 at full scale), too dark (mean
 * below 0.3 % of the range).
 */
TTF_MUST_USE int ttf_flicker_measure(const struct ttf_flicker_frames *frames,
                                     struct ttf_flicker *ret, struct ttf_err *err);

#endif
