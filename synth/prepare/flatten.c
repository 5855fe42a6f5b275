/* SPDX-License-Identifier: Apache-2.0 */
#include <stdlib.h>

#include "prepare/derived.h"
#include "ttf/synth/prepare.h"

struct flatten {
    struct derived derived;              /* first: downcast by address */
    const struct ttf_gradient *gradient; /* borrowed */
};

static int flatten_read_rows(struct ttf_sequence *sequence, uint32_t t, uint32_t y0, uint32_t rows,
                             uint16_t *dst, struct ttf_err *err)
{
    const struct flatten *flatten = (const struct flatten *)sequence;
    size_t row = (size_t)sequence->width * 3;
    float pedestal = (float)sequence->encoding.pedestal;
    const float *g;
    int code = derived_check_rows(sequence, t, y0, rows, err);

    if (!code)
        code = ttf_sequence_read_rows(flatten->derived.input, t, y0, rows, dst, err);
    if (code)
        return code;
    g = flatten->gradient->g + y0 * row;
    for (size_t i = 0; i < rows * row; i++)
        dst[i] = code_of(((float)dst[i] - pedestal) / g[i] + pedestal);
    return 0;
}

static void flatten_destroy(struct ttf_sequence *sequence)
{
    free(sequence);
}

static const struct ttf_sequence_ops flatten_ops = {
    .read_rows = flatten_read_rows,
    .destroy = flatten_destroy,
};

int ttf_flatten_create(struct ttf_sequence *input, const struct ttf_gradient *gradient,
                       struct ttf_sequence **ret, struct ttf_err *err)
{
    struct flatten *flatten;

    if (gradient->width != input->width || gradient->height != input->height) {
        ttf_err_set(err, -EINVAL, "gradient",
                    "a gradient of %u x %u does not fit a sequence of %u x %u", gradient->width,
                    gradient->height, input->width, input->height);
        ttf_err_hint(err, "find it on this sequence, or resample it to its size");
        return -EINVAL;
    }
    flatten = malloc(sizeof(*flatten));
    if (!flatten)
        return ttf_err_set(err, -ENOMEM, "gradient", "no memory for a sequence");
    flatten->derived = derived_from(input, &flatten_ops);
    flatten->gradient = gradient;
    *ret = &flatten->derived.base;
    return 0;
}
