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
 * G is a Gaussian of sigma_px (> 0; ours: half the larger block side) over one frame, or
 * over TTF_GRADIENT_MEAN; at the borders the kernel's weights that lie inside are
 * normalised. A channel without light has a g of 1. -EINVAL (sigma or frame), -ENOMEM, the
 * sequence's. To free: ttf_gradient_free (NULL and zeroed ones allowed).
 */
TTF_MUST_USE int ttf_gradient_find(struct ttf_sequence *input, double sigma_px, uint32_t frame,
                                   struct ttf_gradient *ret, struct ttf_err *err);
void ttf_gradient_free(struct ttf_gradient *gradient);

/* Largest and smallest g of all channels: what the report says. */
void ttf_gradient_range(const struct ttf_gradient *gradient, float *ret_least, float *ret_most);

/* p' = p / g, rounded, clipped to the codes' range. Borrows the gradient too. -EINVAL if sizes differ. */
TTF_MUST_USE int ttf_flatten_create(struct ttf_sequence *input, const struct ttf_gradient *gradient,
                                    struct ttf_sequence **ret, struct ttf_err *err);

/*
 * The same gradient resampled (bilinear, pixel centres) to another size: for an output that is
 * to have it again. -EINVAL (a side of 0), -ENOMEM.
 */
TTF_MUST_USE int ttf_gradient_resample(const struct ttf_gradient *gradient, uint32_t width,
                                       uint32_t height, struct ttf_gradient *ret,
                                       struct ttf_err *err);

/* Multiplies a frame (height x width x 3 codes, of the gradient's size) by g in place, rounded, clipped. */
void ttf_gradient_apply(const struct ttf_gradient *gradient, const struct ttf_encoding *encoding,
                        struct ttf_pool *pool, uint16_t *codes);

/* ---- global flicker ---- */

struct ttf_deflicker_figures {
    double largest_gain, smallest_gain; /* of all frames */
    /*
     * Mean |second difference in time| of the log level, per frame: of the input, and as aimed
     * at. Where bright codes clip, a gain above 1 reaches less.
     */
    double before, after;
};

/*
 * Each frame times one gain, so that its level (the mean luminance, without the darkest and
 * the brightest tenth of its pixels) follows the levels' own running median (about their
 * trend) and then mean, of logarithms, over `window` frames (odd, >= 3, else -EINVAL); at both
 * ends, a line through the last whole window. The samples' slow evolution stays, what jumps
 * from frame to frame goes. Reads the whole input once. A frame without light (a level below a
 * thousandth of value 1) keeps a gain of 1. Fewer than 3 frames: gains of 1. ret_figures may
 * be NULL.
 */
TTF_MUST_USE int ttf_deflicker_create(struct ttf_sequence *input, uint32_t window,
                                      struct ttf_sequence **ret,
                                      struct ttf_deflicker_figures *ret_figures,
                                      struct ttf_err *err);

/* ---- camera nudges ---- */

struct ttf_stabilise_figures {
    double largest_shift_px; /* of all frames, against the reference */
    uint32_t moved;          /* frames that were moved: by a tenth of a pixel or more */
    uint32_t unlike;         /* like their neighbour at no shift, or plain: moved as it was */
    uint32_t crop_x, crop_y; /* pixels cut off at each side, so that every frame is full */
};

/*
 * Each frame moved by a translation found against a reference frame (the middle one): by
 * subpixel registration of luminance gradients, so that slow changes of what is seen do not
 * matter; where a frame has become too unlike the reference, through frames in between, as
 * moved. Bilinear. The result is smaller by the crop on each side. A shift beyond limit_px
 * is -ERANGE with a hint; limit_px 0 stands for a 16th of the smaller side, a quarter of it is
 * the most (-EINVAL; so are pictures of less than 16 pixels). Frames that differ from the
 * reference by less than 0.1 pixel are left alone, so that an unmoved sequence comes out bit
 * for bit. Reads the whole input once (the middle frame twice). ret_figures may be NULL.
 */
TTF_MUST_USE int ttf_stabilise_create(struct ttf_sequence *input, double limit_px,
                                      struct ttf_sequence **ret,
                                      struct ttf_stabilise_figures *ret_figures,
                                      struct ttf_err *err);

/* ---- less of it: previews ---- */

/*
 * Every step-th frame (from 0), each averaged over shrink x shrink pixels (what is left at the
 * edges is dropped). shrink, step >= 1; -EINVAL if nothing would be left.
 * index and time_ns are those of the frames kept. 1 and 1 change nothing and are allowed.
 */
TTF_MUST_USE int ttf_reduce_create(struct ttf_sequence *input, uint32_t shrink, uint32_t step,
                                   struct ttf_sequence **ret, struct ttf_err *err);

/* ---- feature size ---- */

/*
 * How large what is seen is, at late times (the last tenth of the frames, at most 8 of
 * them, evenly): the lag at which the mean autocorrelation of display luminance (a plane
 * fitted and taken off) along x, and along y, falls to 1/e; and a block size from it.
 * Lags up to half a side are looked at: 1/e is reached at no more than that.
 */
struct ttf_feature_size {
    double correlation_x_px, correlation_y_px;
    uint32_t block_width, block_height; /* suggestion: see ttf_feature_size_find */
    /* Of the strongest later peak above 0.3 (the first that is nine tenths as strong); 0: none. */
    double period_x_px, period_y_px;
};

/*
 * block = 8 correlation lengths (or 1.5 periods, if larger), as multiples of 8, from 24 to
 * a third of the input's side; where a third is less than 24: 24, or the side if that is less.
 * Constant pictures: lengths and periods of 0, and the least block. -ENOMEM, the sequence's.
 */
TTF_MUST_USE int ttf_feature_size_find(struct ttf_sequence *input, struct ttf_feature_size *ret,
                                       struct ttf_err *err);

#endif
