/* SPDX-License-Identifier: Apache-2.0 */
/*
 * prepare.h: sequences made fit for synthesis, each a sequence over another one:
 * nothing is kept of the frames but what each header says, so an input of any
 * length passes through. All work on linear values (code - pedestal), and are
 * asked for, never on by themselves: what they change, the report says.
 *
 * A sequence made here reads the one it was made of, which must outlive it, and
 * may be read from several threads at once. It has the same n, index, time_ns
 * and encoding unless said otherwise. Destroy with ttf_sequence_destroy.
 */
#ifndef TTF_SYNTH_PREPARE_H
#define TTF_SYNTH_PREPARE_H

#include <stdint.h>

#include "ttf/base/attr.h"
#include "ttf/base/err.h"
#include "ttf/dataset/pool.h"
#include "ttf/dataset/sequence.h"

/* ---- gradient removal (Enrique et al. 2005, section 5.3) ---- */

/* g of a sequence: per channel G / mean(G), at least `TTF_GRADIENT_LEAST`. */
struct ttf_gradient {
    uint32_t width, height;
    float *g; /* height x width x 3 */
};

#define TTF_GRADIENT_LEAST 0.05f

/* The representative picture is the mean of up to 16 frames spread evenly over time. */
#define TTF_GRADIENT_MEAN UINT32_MAX

/*
 * G is a Gaussian of sigma_px (> 0; ours: the larger block side) over one frame, or
 * over TTF_GRADIENT_MEAN; at the borders the kernel's weights that lie inside are
 * normalised. -EINVAL (sigma or frame), -ENOMEM, the sequence's.
 */
TTF_MUST_USE int ttf_gradient_find(struct ttf_sequence *input, double sigma_px, uint32_t frame,
                                   struct ttf_gradient *ret, struct ttf_err *err);
void ttf_gradient_free(struct ttf_gradient *gradient);

/* Largest and smallest g of all channels: what the report says. */
void ttf_gradient_range(const struct ttf_gradient *gradient, float *ret_least, float *ret_most);

/* p' = p / g, rounded, clipped to the codes' range. Borrows the gradient. -EINVAL if sizes differ. */
TTF_MUST_USE int ttf_flatten_create(struct ttf_sequence *input, const struct ttf_gradient *gradient,
                                    struct ttf_sequence **ret, struct ttf_err *err);

/* The same gradient resampled (bilinear, pixel centres) to another size: for an output that is to have it again. */
TTF_MUST_USE int ttf_gradient_resample(const struct ttf_gradient *gradient, uint32_t width,
                                       uint32_t height, struct ttf_gradient *ret,
                                       struct ttf_err *err);

/* Multiplies a frame (height x width x 3 codes, of the gradient's size) by g in place, rounded, clipped. */
void ttf_gradient_apply(const struct ttf_gradient *gradient, const struct ttf_encoding *encoding,
                        struct ttf_pool *pool, uint16_t *codes);

/* ---- global flicker ---- */

struct ttf_deflicker_figures {
    double largest_gain, smallest_gain; /* of all frames */
    double before, after; /* mean |second difference in time| of the log mean level, per frame */
};

/*
 * Each frame times one gain, so that its level (a trimmed mean of luminance) follows
 * the levels' own running median and then mean over `window` frames (odd, >= 3).
 * The samples' slow evolution stays, what jumps from frame to frame goes. Reads the whole
 * input once. A frame without light keeps a gain of 1. Fewer than 3 frames: gains of 1.
 */
TTF_MUST_USE int ttf_deflicker_create(struct ttf_sequence *input, uint32_t window,
                                      struct ttf_sequence **ret,
                                      struct ttf_deflicker_figures *ret_figures,
                                      struct ttf_err *err);

/* ---- camera nudges ---- */

struct ttf_stabilise_figures {
    double largest_shift_px; /* of all frames, against the reference */
    uint32_t moved;          /* frames that were moved by more than a tenth of a pixel */
    uint32_t crop_x, crop_y; /* pixels cut off at each side, so that every frame is full */
};

/*
 * Each frame moved by a translation found against a reference frame (the middle one),
 * through frames in between (each against its neighbour as moved), by subpixel
 * registration of luminance gradients, so that slow changes of what is seen do
 * not matter; bilinear. The result is smaller by the crop on each side; a shift beyond
 * limit_px (default sense: a 16th of the smaller side) is -ERANGE with a hint.
 * Shifts below 0.1 pixel are left alone, so that an unmoved sequence comes out bit for bit.
 * Reads the whole input once.
 */
TTF_MUST_USE int ttf_stabilise_create(struct ttf_sequence *input, double limit_px,
                                      struct ttf_sequence **ret,
                                      struct ttf_stabilise_figures *ret_figures,
                                      struct ttf_err *err);

/* ---- less of it: previews ---- */

/*
 * Every step-th frame (from 0), each averaged over shrink x shrink pixels (what is left at the
 * edges is dropped). shrink, step >= 1; -EINVAL if nothing would be left.
 * index and time_ns are those of the frames kept. ttf_sequence_reduce(.., 1, 1, ..) is allowed.
 */
TTF_MUST_USE int ttf_reduce_create(struct ttf_sequence *input, uint32_t shrink, uint32_t step,
                                   struct ttf_sequence **ret, struct ttf_err *err);

/* ---- feature size ---- */

/*
 * How large what is seen is, at late times (the last tenth of the frames, at most 8 of
 * them, evenly): the lag at which the mean autocorrelation of display luminance (a plane
 * fitted and taken off) along x, and along y, falls to 1/e; and a block size from it.
 */
struct ttf_feature_size {
    double correlation_x_px, correlation_y_px;
    uint32_t block_width, block_height; /* suggestion: see ttf_feature_size_find */
    double period_x_px, period_y_px;    /* of the strongest later peak above 0.3; 0: none */
};

/*
 * block = 8 correlation lengths (or 1.5 periods, if larger), as multiples of 8, within 24
 * and a third of the input's side (and never more than it). Constant pictures: 24 or what fits.
 */
TTF_MUST_USE int ttf_feature_size_find(struct ttf_sequence *input, struct ttf_feature_size *ret,
                                       struct ttf_err *err);

#endif
