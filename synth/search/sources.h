/* SPDX-License-Identifier: Apache-2.0 */
/*
 * sources.h: one or several sequences of one material as one list of pixels: pixel ids
 * run through the first input row by row, then through the second, and so on.
 */
#ifndef TTF_SYNTH_SEARCH_SOURCES_H
#define TTF_SYNTH_SEARCH_SOURCES_H

#include <stddef.h>
#include <stdint.h>

#include "ttf/base/attr.h"
#include "ttf/base/err.h"
#include "ttf/dataset/sequence.h"
#include "ttf/synth/quilt.h"

struct ttf_sources {
    unsigned n;
    struct ttf_sequence *list[TTF_QUILT_INPUTS_MAX];
    uint32_t first[TTF_QUILT_INPUTS_MAX]; /* id of an input's first pixel */
    uint32_t pixels;                      /* of all */
    uint32_t frames;
};

/*
 * config->more behind `input`. -EINVAL if an input's number of frames or encoding is not that of
 * the first, or there are too many pixels (2^31).
 */
TTF_MUST_USE int ttf_sources_of(const struct ttf_quilt_config *config, struct ttf_sequence *input,
                                struct ttf_sources *ret, struct ttf_err *err);

/* Frame t of all inputs: pixels x 3 codes. Any thread. */
TTF_MUST_USE int ttf_sources_read(const struct ttf_sources *sources, uint32_t t, uint16_t *dst,
                                  struct ttf_err *err);

/* The same as 8-bit codes by a table of 65,536; scratch: room for TTF_SOURCES_PIECE 16-bit codes. */
#define TTF_SOURCES_PIECE ((size_t)3 << 16)
TTF_MUST_USE int ttf_sources_read_codes(const struct ttf_sources *sources, uint32_t t,
                                        const uint8_t *table, uint16_t *scratch, uint8_t *dst,
                                        struct ttf_err *err);

#endif
