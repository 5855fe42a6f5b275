/* SPDX-License-Identifier: Apache-2.0 */
#include <stdlib.h>
#include <string.h>

#include "prepare/derived.h"
#include "ttf/base/checked.h"
#include "ttf/synth/prepare.h"

struct reduce {
    struct derived derived; /* first: downcast by address */
    uint32_t shrink, step;
    int64_t *numbers; /* index, then time_ns: n entries each */
};

/* `sums` holds one row of the result; rows of the input are read one by one, and each is added to it. */
static int add_rows(const struct reduce *reduce, uint32_t t, uint32_t y, uint16_t *codes,
                    uint64_t *sums, struct ttf_err *err)
{
    uint32_t width = reduce->derived.base.width, shrink = reduce->shrink;

    memset(sums, 0, (size_t)width * 3 * sizeof(*sums));
    for (uint32_t i = 0; i < shrink; i++) {
        const uint16_t *from = codes;
        int code = ttf_sequence_read_rows(reduce->derived.input, t * reduce->step, y * shrink + i,
                                          1, codes, err);

        if (code)
            return code;
        for (size_t x = 0; x < width; x++) {
            for (uint32_t k = 0; k < shrink; k++, from += 3) {
                for (size_t c = 0; c < 3; c++)
                    sums[3 * x + c] += from[c];
            }
        }
    }
    return 0;
}

static int reduce_read_rows(struct ttf_sequence *sequence, uint32_t t, uint32_t y0, uint32_t rows,
                            uint16_t *dst, struct ttf_err *err)
{
    const struct reduce *reduce = (const struct reduce *)sequence;
    uint64_t area = (uint64_t)reduce->shrink * reduce->shrink;
    size_t row = (size_t)sequence->width * 3;
    uint16_t *codes;
    uint64_t *sums;
    int code = derived_check_rows(sequence, t, y0, rows, err);

    if (code)
        return code;
    if (reduce->shrink <= 1)
        return ttf_sequence_read_rows(reduce->derived.input, t * reduce->step, y0, rows, dst, err);
    codes = malloc((size_t)reduce->derived.input->width * 3 * sizeof(*codes));
    sums = calloc(row, sizeof(*sums));
    if (!codes || !sums) {
        code = ttf_err_set(err, -ENOMEM, NULL, "no memory for rows of %u pixels",
                           reduce->derived.input->width);
        goto out;
    }
    for (uint32_t y = y0; y < y0 + rows; y++, dst += row) {
        code = add_rows(reduce, t, y, codes, sums, err);
        if (code)
            break;
        for (size_t i = 0; i < row; i++)
            dst[i] = (uint16_t)((sums[i] + area / 2) / area);
    }
out:
    free(codes);
    free(sums);
    return code;
}

static void reduce_destroy(struct ttf_sequence *sequence)
{
    struct reduce *reduce = (struct reduce *)sequence;

    free(reduce->numbers);
    free(reduce);
}

static const struct ttf_sequence_ops reduce_ops = {
    .read_rows = reduce_read_rows,
    .destroy = reduce_destroy,
};

static int check(const struct ttf_sequence *input, uint32_t shrink, uint32_t step,
                 struct ttf_err *err)
{
    uint32_t side = input->width < input->height ? input->width : input->height;

    if (step == 0)
        return ttf_err_set(err, -EINVAL, "step", "every 0th frame is none: step must be 1 or more");
    if (shrink == 0)
        return ttf_err_set(err, -EINVAL, "shrink", "pictures cannot be shrunk by 0");
    if (shrink > side) {
        ttf_err_set(err, -EINVAL, "shrink", "nothing is left of %u x %u pixels shrunk by %u",
                    input->width, input->height, shrink);
        ttf_err_hint(err, "shrink by %u at most", side);
        return -EINVAL;
    }
    return 0;
}

int ttf_reduce_create(struct ttf_sequence *input, uint32_t shrink, uint32_t step,
                      struct ttf_sequence **ret, struct ttf_err *err)
{
    int code = check(input, shrink, step, err);
    struct reduce *reduce;
    uint32_t n;

    if (code)
        return code;
    n = (input->n - 1) / step + 1;
    reduce = malloc(sizeof(*reduce));
    if (reduce)
        reduce->numbers = calloc(n, 2 * sizeof(*reduce->numbers));
    if (!reduce || !reduce->numbers) {
        free(reduce);
        return ttf_err_set(err, -ENOMEM, NULL, "no memory for a sequence of %u frames", n);
    }
    for (uint32_t t = 0; t < n; t++) {
        reduce->numbers[t] = input->index[(size_t)t * step];
        reduce->numbers[n + t] = input->time_ns[(size_t)t * step];
    }
    reduce->derived = derived_from(input, &reduce_ops);
    reduce->shrink = shrink;
    reduce->step = step;
    reduce->derived.base.width = input->width / shrink;
    reduce->derived.base.height = input->height / shrink;
    reduce->derived.base.n = n;
    reduce->derived.base.index = reduce->numbers;
    reduce->derived.base.time_ns = reduce->numbers + n;
    *ret = &reduce->derived.base;
    return 0;
}
