/* SPDX-License-Identifier: Apache-2.0 */
/*
 * second_differences.h: the noise of one sample, from second differences in time of sampled
 * pixels, frame by frame.
 */
#ifndef TTF_SYNTH_SEARCH_SECOND_DIFFERENCES_H
#define TTF_SYNTH_SEARCH_SECOND_DIFFERENCES_H

#include <stddef.h>
#include <stdint.h>

#define TTF_SECOND_MAX     510 /* of |a - 2 b + c| with 8-bit codes: 2 x 255 */
#define TTF_SECOND_SAMPLES 2048u

/* Zero-initialise. */
struct ttf_second_differences {
    uint32_t frames;
    uint64_t counts[TTF_SECOND_MAX + 1];
    uint8_t last[2][TTF_SECOND_SAMPLES][3]; /* [0]: of the last frame */
};

/* The next frame: pixels x 3 codes. */
void ttf_second_differences_add(struct ttf_second_differences *seconds, const uint8_t *codes,
                                size_t pixels);

/* Does the last frame look like this one, where it was sampled? */
int ttf_second_differences_is_last(const struct ttf_second_differences *seconds,
                                   const uint8_t *codes, size_t pixels);

/*
 * Variance of the noise of one sample, codes squared, at least 1/12 (rounding to 8 bits): second
 * differences have six times the noise's variance where the texture itself changes slowly; those
 * beyond five times their median are taken for real events and left out. Fewer than three frames
 * tell nothing: 1/12. A ratio of integers: the same on every machine.
 */
double ttf_second_differences_noise(const uint64_t counts[TTF_SECOND_MAX + 1]);

#endif
