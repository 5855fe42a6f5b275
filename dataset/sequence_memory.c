/* SPDX-License-Identifier: Apache-2.0 */
#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "ttf/base/checked.h"
#include "ttf/base/time.h"
#include "ttf/dataset/sequence.h"

struct memory_sequence {
    struct ttf_sequence base; /* first: downcast by address */
    const uint16_t *frames;   /* borrowed */
    int64_t *numbers;         /* index, then time_ns: n entries each */
};

static int memory_read_rows(struct ttf_sequence *sequence, uint32_t t, uint32_t y0, uint32_t rows,
                            uint16_t *dst, struct ttf_err *err)
{
    const struct memory_sequence *memory = (const struct memory_sequence *)sequence;
    size_t row = (size_t)sequence->width * 3;
    size_t first = ((size_t)t * sequence->height + y0) * row;

    if (t >= sequence->n || y0 > sequence->height || rows > sequence->height - y0)
        return ttf_err_set(err, -EINVAL, NULL, "rows %u+%u of frame %u are outside of the sequence",
                           y0, rows, t);
    memcpy(dst, memory->frames + first, row * rows * sizeof(*dst));
    return 0;
}

static void memory_destroy(struct ttf_sequence *sequence)
{
    struct memory_sequence *memory = (struct memory_sequence *)sequence;

    free(memory->numbers);
    free(memory);
}

static const struct ttf_sequence_ops memory_ops = {
    .read_rows = memory_read_rows,
    .destroy = memory_destroy,
};

int ttf_sequence_of_memory(const uint16_t *frames, uint32_t width, uint32_t height, uint32_t n,
                           const struct ttf_encoding *encoding, struct ttf_sequence **ret,
                           struct ttf_err *err)
{
    struct memory_sequence *memory;
    size_t bytes;

    if (!frames || !encoding || width == 0 || height == 0 || n == 0)
        return ttf_err_set(err, -EINVAL, NULL, "a sequence needs at least one frame of one pixel");
    if (!(encoding->scale > 0))
        return ttf_err_set(err, -EINVAL, NULL, "a sequence's scale must be above 0");
    if (!ttf_mul_size((size_t)width * 3 * sizeof(*frames), height, &bytes) ||
        !ttf_mul_size(bytes, n, &bytes))
        return ttf_err_set(err, -EOVERFLOW, NULL, "%u frames of %u x %u do not fit in memory", n,
                           width, height);
    memory = calloc(1, sizeof(*memory));
    if (memory)
        memory->numbers = calloc(n, 2 * sizeof(*memory->numbers));
    if (!memory || !memory->numbers) {
        free(memory);
        return ttf_err_set(err, -ENOMEM, NULL, "no memory for a sequence of %u frames", n);
    }
    for (uint32_t t = 0; t < n; t++) {
        memory->numbers[t] = t;
        memory->numbers[n + t] = (int64_t)t * TTF_NS_PER_S;
    }
    memory->frames = frames;
    memory->base = (struct ttf_sequence){
        .ops = &memory_ops,
        .width = width,
        .height = height,
        .n = n,
        .encoding = *encoding,
        .index = memory->numbers,
        .time_ns = memory->numbers + n,
    };
    *ret = &memory->base;
    return 0;
}
