/* SPDX-License-Identifier: Apache-2.0 */
/* The low-frequency gradient of a sequence: Enrique et al. 2005, section 5.3. */
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "prepare/derived.h"
#include "ttf/base/checked.h"
#include "ttf/synth/prepare.h"

#define MEAN_FRAMES 16u
#define REACH       3.0 /* sigmas, where a Gaussian's weight is a hundredth of its peak's */
#define APPLY_ROWS  16u /* of a tile */

/* Of a Gaussian: weight[i] at distance i, i = 0..reach. */
struct kernel {
    uint32_t reach;
    float *weight;
};

static bool samples_of(uint32_t width, uint32_t height, size_t *ret)
{
    size_t pixels, bytes;

    return ttf_mul_size(width, height, &pixels) && ttf_mul_size(pixels, 3, ret) &&
           ttf_mul_size(*ret, sizeof(float), &bytes);
}

static int gradient_create(uint32_t width, uint32_t height, struct ttf_gradient *ret,
                           struct ttf_err *err)
{
    size_t samples;
    float *g = samples_of(width, height, &samples) ? calloc(samples, sizeof(*g)) : NULL;

    if (!g)
        return ttf_err_set(err, -ENOMEM, "gradient", "no memory for a gradient of %u x %u", width,
                           height);
    *ret = (struct ttf_gradient){.width = width, .height = height, .g = g};
    return 0;
}

void ttf_gradient_free(struct ttf_gradient *gradient)
{
    if (!gradient)
        return;
    free(gradient->g);
    *gradient = (struct ttf_gradient){0};
}

/* Adds frame t, less the pedestal. Of an unchanging pixel 16 codes add up exactly. */
static int add_frame(struct ttf_sequence *input, uint32_t t, uint16_t *codes, float *sum,
                     struct ttf_err *err)
{
    size_t row = (size_t)input->width * 3;
    float pedestal = (float)input->encoding.pedestal;

    for (uint32_t y = 0; y < input->height; y += STRIP_ROWS) {
        uint32_t rows = strip_rows(input->height, y);
        float *to = sum + y * row;
        int code = ttf_sequence_read_rows(input, t, y, rows, codes, err);

        if (code)
            return code;
        for (size_t i = 0; i < rows * row; i++)
            to[i] += (float)codes[i] - pedestal;
    }
    return 0;
}

/* The representative picture, times the number of its frames: g does not depend on the scale. */
static int representative(struct ttf_sequence *input, uint32_t frame, float *sum,
                          struct ttf_err *err)
{
    uint32_t taken = input->n < MEAN_FRAMES ? input->n : MEAN_FRAMES;
    uint16_t *codes = malloc((size_t)input->width * 3 * STRIP_ROWS * sizeof(*codes));
    int code = 0;

    if (!codes)
        return ttf_err_set(err, -ENOMEM, "gradient", "no memory for rows of %u pixels",
                           input->width);
    if (frame != TTF_GRADIENT_MEAN) {
        code = add_frame(input, frame, codes, sum, err);
    } else {
        for (uint32_t i = 0; i < taken && !code; i++) {
            uint64_t last = input->n - 1;
            uint32_t t = taken == 1 ? 0 : (uint32_t)(i * last / (taken - 1));

            code = add_frame(input, t, codes, sum, err);
        }
    }
    free(codes);
    return code;
}

static int kernel_create(double sigma_px, uint32_t side, struct kernel *ret, struct ttf_err *err)
{
    double reach = ceil(REACH * sigma_px);

    ret->reach = reach < side - 1 ? (uint32_t)reach : side - 1;
    ret->weight = malloc(((size_t)ret->reach + 1) * sizeof(*ret->weight));
    if (!ret->weight)
        return ttf_err_set(err, -ENOMEM, "gradient", "no memory for a filter of %u pixels",
                           ret->reach);
    for (uint32_t i = 0; i <= ret->reach; i++)
        ret->weight[i] = (float)exp(-0.5 * (i / sigma_px) * (i / sigma_px));
    return 0;
}

static float weight_inside(const struct kernel *kernel, uint32_t x, uint32_t side)
{
    float sum = 0.0f;

    for (uint32_t i = 0; i <= kernel->reach; i++) {
        sum += i <= x ? kernel->weight[i] : 0.0f;
        sum += i > 0 && x + i < side ? kernel->weight[i] : 0.0f;
    }
    return sum;
}

/* to[i] += weight * from[i]: the one inner loop, over neighbouring samples, so that it becomes vector code. */
static void add_weighted(float *restrict to, const float *restrict from, float weight, size_t n)
{
    for (size_t i = 0; i < n; i++)
        to[i] += weight * from[i];
}

/* A row of `width` pixels along x: shifted copies of it, added. row and ret do not overlap. */
static void smooth_row(const struct kernel *kernel, const float *inside, const float *row,
                       uint32_t width, float *ret)
{
    memset(ret, 0, (size_t)width * 3 * sizeof(*ret));
    add_weighted(ret, row, kernel->weight[0], (size_t)width * 3);
    for (uint32_t i = 1; i <= kernel->reach && i < width; i++) {
        size_t n = (size_t)(width - i) * 3;

        add_weighted(ret, row + (size_t)i * 3, kernel->weight[i], n);
        add_weighted(ret + (size_t)i * 3, row, kernel->weight[i], n);
    }
    for (size_t i = 0; i < (size_t)width * 3; i++)
        ret[i] /= inside[i / 3];
}

static void smooth_across(const struct kernel *kernel, const float *plane, uint32_t y,
                          uint32_t height, size_t row, float *ret)
{
    float inside = weight_inside(kernel, y, height);

    memset(ret, 0, row * sizeof(*ret));
    for (uint32_t i = 0; i <= kernel->reach; i++) {
        if (i <= y)
            add_weighted(ret, plane + (y - i) * row, kernel->weight[i], row);
        if (i > 0 && y + i < height)
            add_weighted(ret, plane + (y + i) * row, kernel->weight[i], row);
    }
    for (size_t x = 0; x < row; x++)
        ret[x] /= inside;
}

/* picture (overwritten) to ret. scratch: 4 floats per pixel of a row. */
static void smooth(const struct kernel *kernel, float *picture, struct ttf_gradient *ret,
                   float *scratch)
{
    size_t row = (size_t)ret->width * 3;
    float *inside = scratch + row;

    for (uint32_t x = 0; x < ret->width; x++)
        inside[x] = weight_inside(kernel, x, ret->width);
    for (uint32_t y = 0; y < ret->height; y++) {
        smooth_row(kernel, inside, picture + y * row, ret->width, scratch);
        memcpy(picture + y * row, scratch, row * sizeof(*scratch));
    }
    for (uint32_t y = 0; y < ret->height; y++)
        smooth_across(kernel, picture, y, ret->height, row, ret->g + y * row);
}

/* g = G / mean(G). A channel without light has no gradient. */
static void normalise(struct ttf_gradient *gradient)
{
    size_t pixels = (size_t)gradient->width * gradient->height;

    for (size_t c = 0; c < 3; c++) {
        double mean = 0.0;

        for (size_t i = 0; i < pixels; i++)
            mean += (double)gradient->g[3 * i + c];
        mean /= (double)pixels;
        for (size_t i = 0; i < pixels; i++) {
            float *g = &gradient->g[3 * i + c];

            *g = mean > 0.0 ? (float)(*g / mean) : 1.0f;
            *g = *g > TTF_GRADIENT_LEAST ? *g : TTF_GRADIENT_LEAST;
        }
    }
}

static int find(struct ttf_sequence *input, double sigma_px, uint32_t frame,
                struct ttf_gradient *ret, struct ttf_err *err)
{
    uint32_t side = input->width > input->height ? input->width : input->height;
    struct kernel kernel = {0};
    struct ttf_gradient picture = {0};
    float *scratch = calloc(input->width, 4 * sizeof(*scratch));
    int code = gradient_create(input->width, input->height, &picture, err);

    if (!code && !scratch)
        code =
            ttf_err_set(err, -ENOMEM, "gradient", "no memory for rows of %u pixels", input->width);
    if (!code)
        code = kernel_create(sigma_px, side, &kernel, err);
    if (!code)
        code = representative(input, frame, picture.g, err);
    if (!code) {
        smooth(&kernel, picture.g, ret, scratch);
        normalise(ret);
    }
    free(kernel.weight);
    free(scratch);
    ttf_gradient_free(&picture);
    return code;
}

int ttf_gradient_find(struct ttf_sequence *input, double sigma_px, uint32_t frame,
                      struct ttf_gradient *ret, struct ttf_err *err)
{
    struct ttf_gradient made = {0};
    int code;

    if (!(sigma_px > 0.0) || !isfinite(sigma_px))
        return ttf_err_set(err, -EINVAL, "sigma", "a gradient's sigma must be above 0 pixels");
    if (frame >= input->n && frame != TTF_GRADIENT_MEAN) {
        ttf_err_set(err, -EINVAL, "frame", "there is no frame %u among %u frames", frame, input->n);
        ttf_err_hint(err, "take one of 0 to %u, or the mean over time", input->n - 1);
        return -EINVAL;
    }
    code = gradient_create(input->width, input->height, &made, err);
    if (!code)
        code = find(input, sigma_px, frame, &made, err);
    if (code)
        ttf_gradient_free(&made);
    else
        *ret = made;
    return code;
}

void ttf_gradient_range(const struct ttf_gradient *gradient, float *ret_least, float *ret_most)
{
    size_t samples = (size_t)gradient->width * gradient->height * 3;
    float least = gradient->g[0], most = gradient->g[0];

    for (size_t i = 1; i < samples; i++) {
        least = gradient->g[i] < least ? gradient->g[i] : least;
        most = gradient->g[i] > most ? gradient->g[i] : most;
    }
    *ret_least = least;
    *ret_most = most;
}

/* Where the centre of pixel i of `to` lies between the centres of `from`: the pixel before, and how far past it. */
static uint32_t between(uint32_t i, uint32_t to, uint32_t from, float *ret_fraction)
{
    double at = ((double)i + 0.5) * from / to - 0.5;
    uint32_t first;

    at = at < 0.0 ? 0.0 : at > from - 1.0 ? from - 1.0 : at;
    first = (uint32_t)at;
    first = first > 0 && first == from - 1 ? first - 1 : first;
    *ret_fraction = (float)(at - first);
    return first;
}

int ttf_gradient_resample(const struct ttf_gradient *gradient, uint32_t width, uint32_t height,
                          struct ttf_gradient *ret, struct ttf_err *err)
{
    size_t row = (size_t)gradient->width * 3;
    struct ttf_gradient made = {0};
    float *to;
    int code;

    if (width == 0 || height == 0)
        return ttf_err_set(err, -EINVAL, "size", "a gradient of %u x %u pixels is none", width,
                           height);
    code = gradient_create(width, height, &made, err);
    if (code || !made.g)
        return code;
    to = made.g;
    for (uint32_t y = 0; y < height; y++) {
        float v, u;
        const float *above = gradient->g + between(y, height, gradient->height, &v) * row;
        const float *below = gradient->height > 1 ? above + row : above;

        for (uint32_t x = 0; x < width; x++) {
            size_t left = (size_t)between(x, width, gradient->width, &u) * 3;
            size_t right = gradient->width > 1 ? left + 3 : left;

            for (size_t c = 0; c < 3; c++)
                *to++ = (above[left + c] * (1 - u) + above[right + c] * u) * (1 - v) +
                        (below[left + c] * (1 - u) + below[right + c] * u) * v;
        }
    }
    *ret = made;
    return 0;
}

struct application {
    const struct ttf_gradient *gradient;
    float pedestal;
    uint16_t *codes;
};

static void apply_rows(void *ctx, unsigned tile, unsigned worker)
{
    const struct application *job = ctx;
    size_t row = (size_t)job->gradient->width * 3;
    uint32_t left = job->gradient->height - tile * APPLY_ROWS;
    size_t first = (size_t)tile * APPLY_ROWS * row;
    size_t end = first + (left < APPLY_ROWS ? left : APPLY_ROWS) * row;

    (void)worker;
    for (size_t i = first; i < end; i++)
        job->codes[i] =
            code_of(((float)job->codes[i] - job->pedestal) * job->gradient->g[i] + job->pedestal);
}

void ttf_gradient_apply(
    const struct ttf_gradient *gradient, const struct ttf_encoding *encoding, struct ttf_pool *pool,
    uint16_t *codes) /* NOLINT(readability-non-const-parameter): written by tiles */
{
    struct application job = {gradient, (float)encoding->pedestal, codes};

    ttf_pool_run(pool, (gradient->height + APPLY_ROWS - 1) / APPLY_ROWS, apply_rows, &job);
}
