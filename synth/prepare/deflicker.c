/* SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "prepare/derived.h"
#include "prepare/levels.h"
#include "ttf/synth/prepare.h"

#define TRIM \
    10 /* of the pixels in order of luminance, one part in so many is left out at each end */
#define LEAST_VALUE 0.001 /* a frame below it has no light */
#define HISTOGRAM   65536u

struct deflicker {
    struct derived derived; /* first: downcast by address */
    float *gain;            /* n */
};

/* Rec.709 luminance in whole codes, so that the level is an exact sum whatever the machine. */
static void count_rows(const uint16_t *codes, size_t pixels, uint64_t *histogram)
{
    for (size_t i = 0; i < pixels; i++, codes += 3)
        histogram[(2126u * codes[0] + 7152u * codes[1] + 722u * codes[2] + 5000u) / 10000u]++;
}

/* The mean code of the ranks that are not trimmed. */
static double trimmed_mean(const uint64_t *histogram, uint64_t pixels)
{
    uint64_t first = pixels / TRIM, end = pixels - first, rank = 0;
    double sum = 0.0;

    for (uint32_t code = 0; code < HISTOGRAM; code++) {
        uint64_t from = rank > first ? rank : first;
        uint64_t to = rank + histogram[code] < end ? rank + histogram[code] : end;

        sum += to > from ? (double)code * (double)(to - from) : 0.0;
        rank += histogram[code];
    }
    return sum / (double)(end - first);
}

/* The log of frame t's level, NAN without light. */
static int frame_level(struct ttf_sequence *input, uint32_t t, uint16_t *codes, uint64_t *histogram,
                       double *ret, struct ttf_err *err)
{
    double value;

    memset(histogram, 0, HISTOGRAM * sizeof(*histogram));
    for (uint32_t y = 0; y < input->height; y += STRIP_ROWS) {
        uint32_t rows = strip_rows(input->height, y);
        int code = ttf_sequence_read_rows(input, t, y, rows, codes, err);

        if (code)
            return code;
        count_rows(codes, (size_t)rows * input->width, histogram);
    }
    value = (trimmed_mean(histogram, (uint64_t)input->width * input->height) -
             input->encoding.pedestal) /
            input->encoding.scale;
    *ret = value >= LEAST_VALUE ? log(value) : (double)NAN;
    return 0;
}

static int all_levels(struct ttf_sequence *input, double *level, struct ttf_err *err)
{
    uint16_t *codes = malloc((size_t)input->width * 3 * STRIP_ROWS * sizeof(*codes));
    uint64_t *histogram = malloc(HISTOGRAM * sizeof(*histogram));
    int code = 0;

    if (!codes || !histogram) {
        code =
            ttf_err_set(err, -ENOMEM, "deflicker", "no memory for rows of %u pixels", input->width);
        goto out;
    }
    for (uint32_t t = 0; t < input->n && !code; t++)
        code = frame_level(input, t, codes, histogram, &level[t], err);
out:
    free(codes);
    free(histogram);
    return code;
}

/* Frames without light are left out of it. */
static double mean_second_difference(const double *level, uint32_t n)
{
    double sum = 0.0;
    uint32_t counted = 0;

    for (uint32_t t = 1; t + 1 < n; t++) {
        double second = level[t - 1] - 2.0 * level[t] + level[t + 1];

        if (isnan(second))
            continue;
        sum += fabs(second);
        counted++;
    }
    return counted > 0 ? sum / counted : 0.0;
}

/* level: of the input; target: what it is to follow, replaced by what the frames get. */
static void find_gains(const double *level, double *target, uint32_t n, float *gain,
                       struct ttf_deflicker_figures *ret)
{
    *ret = (struct ttf_deflicker_figures){.largest_gain = 1.0, .smallest_gain = 1.0};
    for (uint32_t t = 0; t < n; t++) {
        bool follows = !isnan(level[t]) && !isnan(target[t]);
        double g;

        gain[t] = follows ? (float)exp(target[t] - level[t]) : 1.0f;
        target[t] = follows ? target[t] : level[t];
        g = (double)gain[t];
        ret->largest_gain = t == 0 || g > ret->largest_gain ? g : ret->largest_gain;
        ret->smallest_gain = t == 0 || g < ret->smallest_gain ? g : ret->smallest_gain;
    }
    ret->before = mean_second_difference(level, n);
    ret->after = mean_second_difference(target, n);
}

static int deflicker_read_rows(struct ttf_sequence *sequence, uint32_t t, uint32_t y0,
                               uint32_t rows, uint16_t *dst, struct ttf_err *err)
{
    const struct deflicker *deflicker = (const struct deflicker *)sequence;
    size_t samples = (size_t)sequence->width * 3 * rows;
    float pedestal = (float)sequence->encoding.pedestal, gain;
    int code = derived_check_rows(sequence, t, y0, rows, err);

    if (!code)
        code = ttf_sequence_read_rows(deflicker->derived.input, t, y0, rows, dst, err);
    if (code)
        return code;
    gain = deflicker->gain[t];
    for (size_t i = 0; i < samples && gain != 1.0f; i++)
        dst[i] = code_of(((float)dst[i] - pedestal) * gain + pedestal);
    return 0;
}

static void deflicker_destroy(struct ttf_sequence *sequence)
{
    struct deflicker *deflicker = (struct deflicker *)sequence;

    free(deflicker->gain);
    free(deflicker);
}

static const struct ttf_sequence_ops deflicker_ops = {
    .read_rows = deflicker_read_rows,
    .destroy = deflicker_destroy,
};

/* levels: room for the levels and what they are to follow. */
static int measure(struct deflicker *deflicker, uint32_t window, double *levels,
                   struct ttf_deflicker_figures *ret, struct ttf_err *err)
{
    struct ttf_sequence *input = deflicker->derived.input;
    double *target = levels + input->n;
    int code = all_levels(input, levels, err);

    if (code)
        return code;
    memcpy(target, levels, input->n * sizeof(*target));
    if (input->n >= 3 && ttf_levels_smooth(levels, input->n, window, target) < 0)
        return ttf_err_set(err, -ENOMEM, "deflicker", "no memory for the levels of %u frames",
                           input->n);
    find_gains(levels, target, input->n, deflicker->gain, ret);
    return 0;
}

int ttf_deflicker_create(struct ttf_sequence *input, uint32_t window, struct ttf_sequence **ret,
                         struct ttf_deflicker_figures *ret_figures, struct ttf_err *err)
{
    struct ttf_deflicker_figures figures;
    struct deflicker *deflicker;
    double *levels;
    int code;

    if (window < 3 || window % 2 == 0) {
        ttf_err_set(err, -EINVAL, "window",
                    "flicker is smoothed over an odd number of frames, 3 "
                    "or more, not %u",
                    window);
        ttf_err_hint(err, "take %u", window < 3 ? 3 : window + 1);
        return -EINVAL;
    }
    deflicker = calloc(1, sizeof(*deflicker));
    levels = calloc(input->n, 2 * sizeof(*levels));
    if (deflicker)
        deflicker->gain = calloc(input->n, sizeof(*deflicker->gain));
    if (!deflicker || !levels || !deflicker->gain) {
        code = ttf_err_set(err, -ENOMEM, "deflicker", "no memory for the levels of %u frames",
                           input->n);
        goto out;
    }
    deflicker->derived = derived_from(input, &deflicker_ops);
    code = measure(deflicker, window, levels, &figures, err);
    if (code)
        goto out;
    *ret = &deflicker->derived.base;
    if (ret_figures)
        *ret_figures = figures;
    deflicker = NULL;
out:
    free(levels);
    if (deflicker)
        deflicker_destroy(&deflicker->derived.base);
    return code;
}
