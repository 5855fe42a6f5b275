/* SPDX-License-Identifier: Apache-2.0 */
/* calibration_private.h: what the files of calibration share. */
#ifndef TTF_DATASET_CALIBRATION_PRIVATE_H
#define TTF_DATASET_CALIBRATION_PRIVATE_H

#include "ttf/dataset/calibration.h"

/* Ids with it are checked against the content on loading. */
#define CALIBRATION_ID_PREFIX "cal-"

#define CALIBRATION_FORMAT "ttf-calibration"
#define CALIBRATION_MAJOR  1
#define CALIBRATION_MINOR  2 /* 1: "chart", "flicker"; 2: "geometry" */

/* "RGGB", ..., "" for none; and back, -ENOENT. */
const char *calibration_cfa_name(enum ttf_cfa cfa);
int calibration_cfa_find(const char *name);

/* The id that the content gives. */
void calibration_id(const struct ttf_calibration *calibration, char ret[64]);

/* Samples per pixel of a sum of such frames, or why there can be none: -EINVAL, -ENOTSUP. */
int calibration_samples(const struct ttf_frame_format *format);

/* Mean code of pixel i, in 1/16, rounded. */
static inline uint32_t calibration_mean_16(const struct ttf_raw_sum *sum, size_t i)
{
    return (uint32_t)(((uint64_t)sum->sum[i] * 16 + sum->n / 2) / sum->n);
}

/* The same above black, and above the calibration's dark where there is one. */
static inline int32_t calibration_signal_16(const struct ttf_calibration *calibration,
                                            const struct ttf_raw_sum *sum, size_t i, uint16_t black)
{
    int32_t signal = (int32_t)calibration_mean_16(sum, i) - 16 * (int32_t)black;

    return calibration->has_dark ? signal - calibration->dark_offset_16[i] : signal;
}

/* How much more light the flat's settings gather than the frame's; a control the camera lacks (0) counts as equal. */
static inline double calibration_exposure_ratio(const struct ttf_exposure *flat,
                                                const struct ttf_exposure *frame)
{
    double ratio = 1.0;

    if (flat->exposure_ns > 0 && frame->exposure_ns > 0)
        ratio *= (double)flat->exposure_ns / (double)frame->exposure_ns;
    if (flat->gain_milli > 0 && frame->gain_milli > 0)
        ratio *= (double)flat->gain_milli / (double)frame->gain_milli;
    return ratio;
}

/* Whether pixel (x, y) is among those not to be believed. */
bool calibration_is_hot(const struct ttf_calibration *calibration, uint32_t x, uint32_t y);

/* Whether frames can be fitted into the calibration. what: "dark", "flat". */
TTF_MUST_USE int calibration_check_sum(const struct ttf_calibration *calibration,
                                       const struct ttf_raw_sum *sum, const char *what,
                                       struct ttf_err *err);
/* Size, mosaic and levels become those of the frames. */
void calibration_take_format(struct ttf_calibration *calibration, const struct ttf_raw_sum *sum);

/* Sorts by y, x and drops what is there twice. */
void calibration_sort_hot(struct ttf_calibration *calibration);

#endif
