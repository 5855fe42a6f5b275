/* SPDX-License-Identifier: Apache-2.0 */
/* pictures.h: sequences in memory from formulas of light, for tests of preparation. */
#ifndef TTF_TESTS_SYNTH_PREPARE_PICTURES_H
#define TTF_TESTS_SYNTH_PREPARE_PICTURES_H

#include <stdint.h>

#include "ttf/dataset/sequence.h"

/* Linear value of channel c at a place, which need not be a pixel's, at frame t. */
typedef double value_fn(const void *ctx, double x, double y, uint32_t t, int c);

struct pictures {
    uint16_t *codes;
    struct ttf_sequence *sequence;
};

extern const struct ttf_encoding imported; /* pedestal 0 */
extern const struct ttf_encoding captured; /* with a pedestal and a stop of headroom */

struct pictures pictures_make(uint32_t width, uint32_t height, uint32_t n,
                              const struct ttf_encoding *encoding, value_fn *value,
                              const void *ctx);
void pictures_free(struct pictures *pictures);

/* A whole frame of any sequence, to be freed. */
uint16_t *frame_of(struct ttf_sequence *sequence, uint32_t t);

/* Mean value (linear) of a frame, or of a rectangle of it. */
double mean_value(struct ttf_sequence *sequence, uint32_t t);
double mean_of(struct ttf_sequence *sequence, uint32_t t, uint32_t x0, uint32_t y0, uint32_t width,
               uint32_t height, int c);

/* Smooth ground, about 0..1, without period and with features of about 6 pixels; key: another one. */
double ground(double x, double y, unsigned key);

/* 0..1, of three numbers. */
double chance(uint32_t a, uint32_t b, uint32_t c);

/* Every frame of both is the same, bit for bit, read whole or by a few rows at a time. */
void assert_same_frames(struct ttf_sequence *a, struct ttf_sequence *b);
/* Reading a row at a time, or from somewhere, is no different from reading whole frames. */
void assert_reads_by_rows(struct ttf_sequence *sequence);

/* A sequence of n frames of 40 x 36 whose frames from `broken` on cannot be read: -EIO. */
struct ttf_sequence unreadable_from(uint32_t broken, uint32_t n);

#endif
