/* SPDX-License-Identifier: Apache-2.0 */
/*
 * develop.h: from raw frames to calibrated linear light.
 *
 * raw mean -> black and dark -> flat field, exposure normalisation -> hot pixels ->
 * demosaic -> colour matrix -> crop -> codes (pedestal, headroom). PICTURES.md has
 * the equations. By strips, no libm, no contraction: the same bits on every machine
 * and for any number of threads. Bayer or linear grey frames (RAW16, RAW8,
 * RAW10P, RAW12P, GREY16); RGB8/YUYV8/NV12/GREY8 are taken as sRGB-encoded.
 */
#ifndef TTF_DATASET_DEVELOP_H
#define TTF_DATASET_DEVELOP_H

#include <stdbool.h>
#include <stdint.h>

#include "ttf/base/err.h"
#include "ttf/base/frame.h"
#include "ttf/dataset/calibration.h"
#include "ttf/dataset/colour.h"
#include "ttf/dataset/io.h"
#include "ttf/dataset/pixbuf.h"
#include "ttf/dataset/pool.h"
#include "ttf/dataset/tiff.h"

struct ttf_develop;

/* The part of the frame that is kept. */
struct ttf_region {
    uint32_t x, y, width, height; /* pixels; width 0: the whole frame */
};

struct ttf_develop_config {
    struct ttf_frame_format format; /* of the raw frames */
    const struct ttf_calibration
        *calibration; /* borrowed for the life of the developer; NULL: none */
    struct ttf_region region;
    struct ttf_encoding encoding; /* TTF_PEDESTAL, TTF_SCALE for captures */
};

/* What an image looks like to a judge; over the developed region. */
struct ttf_image_figures {
    double mean_level; /* of value, mean over R, G, B */
    double sharpness;  /* mean squared gradient of green over its squared mean */
    double saturated;  /* share of raw samples whose mean is at or above white_level */
};

/* -EINVAL (region outside, calibration of another camera or size), -ENOMEM. */
TTF_MUST_USE int ttf_develop_create(const struct ttf_develop_config *config,
                                    struct ttf_develop **ret, struct ttf_err *err);
void ttf_develop_destroy(struct ttf_develop *develop); /* NULL allowed */

/*
 * Memory for runs with a pool of that size, kept until it is destroyed: they then allocate
 * nothing of their own, and only one may be under way at a time. tiff: for ttf_develop_tiff
 * as well. Without it each run has its own. pool may be NULL. -ENOMEM.
 */
TTF_MUST_USE int ttf_develop_reserve(struct ttf_develop *develop, const struct ttf_pool *pool,
                                     bool tiff, struct ttf_err *err);

uint32_t ttf_develop_width(const struct ttf_develop *develop);
uint32_t ttf_develop_height(const struct ttf_develop *develop);

/*
 * Develops into *dst (u16, 3 samples, of the developer's size). Exposure is
 * normalised by raw->settings against the calibration's flat, so that value 1 is
 * a perfect diffuser whatever the exposure. Without a flat, value 1 is full scale
 * (white_level) and exposures are not normalised. A frame whose levels are the
 * calibration's times a power of two (a DNG of an average) fits it as well. pool may be NULL. ret_figures may be NULL.
 */
TTF_MUST_USE int ttf_develop_run(struct ttf_develop *develop, const struct ttf_raw_sum *raw,
                                 struct ttf_pool *pool, struct ttf_pixbuf *dst,
                                 struct ttf_image_figures *ret_figures, struct ttf_err *err);

/*
 * The same into a 16-bit linear TIFF at a file handle, by strips: bounded memory. With a
 * flat it carries the profile of linear sRGB; without, its colours are the camera's: none.
 */
TTF_MUST_USE int ttf_develop_tiff(struct ttf_develop *develop, const struct ttf_raw_sum *raw,
                                  struct ttf_pool *pool, const struct ttf_tiff_times *times,
                                  struct ttf_io *io, int file,
                                  struct ttf_image_figures *ret_figures, struct ttf_err *err);

#endif
