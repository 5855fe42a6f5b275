/* SPDX-License-Identifier: Apache-2.0 */
/*
 * derived.h: what sequences over another sequence have in common, and the rounding
 * of linear values back to codes. Private to preparation.
 */
#ifndef TTF_SYNTH_PREPARE_DERIVED_H
#define TTF_SYNTH_PREPARE_DERIVED_H

#include <errno.h>
#include <stddef.h>
#include <stdint.h>

#include "ttf/base/attr.h"
#include "ttf/base/err.h"
#include "ttf/dataset/sequence.h"

/* Rows read at a time by what goes through whole frames. */
#define STRIP_ROWS 64u

struct derived {
    struct ttf_sequence base;   /* first: downcast by address */
    struct ttf_sequence *input; /* borrowed */
};

/* A derived sequence starts as its input in all but its operations. */
static inline struct derived derived_from(struct ttf_sequence *input,
                                          const struct ttf_sequence_ops *ops)
{
    struct derived made = {.base = *input, .input = input};

    made.base.ops = ops;
    return made;
}

TTF_MUST_USE static inline int derived_check_rows(const struct ttf_sequence *sequence, uint32_t t,
                                                  uint32_t y0, uint32_t rows, struct ttf_err *err)
{
    if (t >= sequence->n || y0 > sequence->height || rows > sequence->height - y0)
        return ttf_err_set(err, -EINVAL, NULL, "rows %u+%u of frame %u are outside of the sequence",
                           y0, rows, t);
    return 0;
}

/* Codes have 16 bits, which a float holds exactly with 8 to spare. */
static inline uint16_t code_of(float value)
{
    return value <= 0.0f ? 0 : value >= 65535.0f ? 65535 : (uint16_t)(value + 0.5f);
}

static inline uint32_t strip_rows(uint32_t height, uint32_t y)
{
    return height - y < STRIP_ROWS ? height - y : STRIP_ROWS;
}

#endif
