/* SPDX-License-Identifier: Apache-2.0 */
/* textures.h: small time-varying textures in memory, for tests. */
#ifndef TTF_TESTS_SYNTH_TEXTURES_H
#define TTF_TESTS_SYNTH_TEXTURES_H

#include <stdint.h>

#include "ttf/dataset/sequence.h"

enum texture {
    TEXTURE_SPOTS = 0, /* soft spots that grow, each at its own pace, and a little noise */
    TEXTURE_NOISE,     /* every code at random: nothing for bounds to hold on to */
    TEXTURE_CONSTANT,  /* one colour, always */
    TEXTURE_OBJECT,    /* spots in the middle of a plain white ground */
    TEXTURE_STRIPES    /* of period 8 in x, drifting in brightness: exact matches everywhere */
};

struct texture_sequence {
    uint16_t *codes;
    struct ttf_sequence *sequence;
};

/* 8-bit sRGB pictures as linear codes, as an import makes them. Fails the test if there is no memory. */
struct texture_sequence texture_make(enum texture texture, uint32_t width, uint32_t height,
                                     uint32_t n);
void texture_free(struct texture_sequence *texture);

/* What the encoding of these codes is. */
extern const struct ttf_encoding texture_encoding;

/* A hash of three numbers, for tests' own choices. */
uint32_t texture_hash(uint32_t a, uint32_t b, uint32_t c);

#endif
