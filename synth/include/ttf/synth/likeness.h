/* SPDX-License-Identifier: Apache-2.0 */
/*
 * likeness.h: how like its input a result looks, at each time; and how much of it
 * happens at the same moment. Pure figures on display-encoded values, 0..255;
 * directions and samples are hashes, so a figure is the same for any threads.
 * What is good and bad: synth/metrics/README.md.
 */
#ifndef TTF_SYNTH_LIKENESS_H
#define TTF_SYNTH_LIKENESS_H

#include <stddef.h>
#include <stdint.h>

#include "ttf/base/attr.h"
#include "ttf/dataset/colour.h"
#include "ttf/dataset/pool.h"

/* ---- colours, per time ---- */

/*
 * Sliced Wasserstein-1 distance between the RGB distributions of two pictures of any
 * sizes: mean over 32 hashed directions (unit vectors) of the 1-D distance, in display
 * codes. 1-D distances are those of histograms of the projections (bins of a quarter
 * code). A picture of more than 65,536 pixels is represented by so many hashed ones,
 * one of each of 65,536 runs of neighbouring pixels, the same at all times.
 */
struct ttf_colour_distance;

/* NULL: no memory. Holds about half a megabyte. */
struct ttf_colour_distance *ttf_colour_distance_create(const struct ttf_encoding *encoding);
void ttf_colour_distance_destroy(struct ttf_colour_distance *distance);

/*
 * The next time: input and output frames as RGB codes, at least 1 and below 2^32 pixels
 * each; returns this time's distance. pool: may be NULL.
 */
double ttf_colour_distance_add(struct ttf_colour_distance *distance, struct ttf_pool *pool,
                               const uint16_t *input, size_t input_pixels, const uint16_t *output,
                               size_t output_pixels);

struct ttf_colour_figures {
    uint32_t frames;
    double mean, largest; /* over times; 0 without frames */
    uint32_t largest_at;  /* frame, the first of equals */
};
void ttf_colour_distance_figures(const struct ttf_colour_distance *distance,
                                 struct ttf_colour_figures *ret);

/* ---- synchrony ---- */

/*
 * Paste the same block twice and the same event happens twice at once (section 5.3). Of
 * sampled pairs of output pixels copied from one source pixel: the correlation in time of their
 * frame-to-frame changes (sum over channels of absolute differences of display codes), averaged
 * over pairs, weighted by their activity (the sum of both pixels' changes). 1: all at once.
 * Jitter lowers it.
 *
 * A pair is an output pixel and a hashed one of the earlier output pixels that show the
 * same. Where only one of a pair's pixels changes unevenly its correlation counts as 0;
 * where neither does, the pair does not count.
 */
struct ttf_synchrony;

/*
 * source: of each output pixel, the source pixel it shows (any numbers, used only here; below 2^32
 * pixels); at most `pairs_max` pairs are taken. NULL: no memory (8 bytes a pixel, until it returns).
 */
struct ttf_synchrony *ttf_synchrony_create(const uint32_t *source, size_t pixels,
                                           unsigned pairs_max, uint64_t seed,
                                           const struct ttf_encoding *encoding);
void ttf_synchrony_destroy(struct ttf_synchrony *synchrony);

/* The next output frame, RGB codes. Exact up to two million frames. */
void ttf_synchrony_add(struct ttf_synchrony *synchrony, const uint16_t *output);

struct ttf_synchrony_figures {
    unsigned
        pairs; /* that count; 0: nothing is repeated or nothing moves, and there is no figure */
    double synchrony; /* -1..1 */
};
void ttf_synchrony_figures(const struct ttf_synchrony *synchrony,
                           struct ttf_synchrony_figures *ret);

/* ---- patches of one picture against another's ---- */

struct ttf_patch_figures {
    /*
     * Sliced Wasserstein-1 over 7 x 7 patches (147 numbers), full, half and quarter size, codes.
     * Directions are unit vectors, so this is of the size of the root mean square difference per
     * number (0.8 of it where every patch is displaced by the same vector of hashed direction).
     */
    double sliced[3];
    double to_input;   /* mean over output patches of the distance to the nearest input patch (RMS
                          per number, codes): what in the output is unlike all of the input */
    double from_input; /* mean over input patches of the distance to the nearest output patch: what
                          of the input is missing from the output */
};

/*
 * 8-bit display RGB pictures. Sliced: 64 hashed directions over all patches of both; smaller
 * sizes are means of 2 x 2 codes. Nearest: exact, of up to `samples` hashed patches each way
 * (all patches of the other picture); 0 samples: both are left at 0. pool: may be NULL.
 * -EINVAL if a side is smaller than 28 pixels, -ENOMEM.
 */
TTF_MUST_USE int ttf_patch_compare(const uint8_t *input, uint32_t input_width,
                                   uint32_t input_height, const uint8_t *output,
                                   uint32_t output_width, uint32_t output_height, unsigned samples,
                                   struct ttf_pool *pool, struct ttf_patch_figures *ret);

#endif
