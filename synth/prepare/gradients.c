/* SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "prepare/derived.h"
#include "prepare/registration.h"
#include "ttf/base/checked.h"
#include "ttf/dataset/colour.h"

#define LARGEST_SIDE 2048u

/* Adds rows of codes into luminance, shrink x shrink pixels each into one. */
static void add_luminance(const struct ttf_sequence *input, const uint16_t *codes, uint32_t y0,
                          uint32_t rows, const struct gradients *to, float *plane)
{
    float pedestal = (float)input->encoding.pedestal;
    float unit = 1.0f / ((float)input->encoding.scale * (float)to->shrink * (float)to->shrink);

    for (uint32_t y = y0; y < y0 + rows; y++) {
        const uint16_t *at = codes + (size_t)(y - y0) * input->width * 3;
        float *row = plane + (size_t)(y / to->shrink) * to->width[0];

        if (y / to->shrink >= to->height[0])
            break;
        for (uint32_t x = 0; x < to->width[0] * to->shrink; x++, at += 3)
            row[x / to->shrink] +=
                (ttf_luminance((float)at[0], (float)at[1], (float)at[2]) - pedestal) * unit;
    }
}

static int load_luminance(struct ttf_sequence *input, uint32_t t, const struct gradients *to,
                          float *plane, struct ttf_err *err)
{
    uint16_t *codes = malloc((size_t)input->width * 3 * STRIP_ROWS * sizeof(*codes));
    int code = 0;

    if (!codes)
        return ttf_err_set(err, -ENOMEM, "stabilise", "no memory for rows of %u pixels",
                           input->width);
    for (uint32_t y = 0; y < input->height && !code; y += STRIP_ROWS) {
        uint32_t rows = strip_rows(input->height, y);

        code = ttf_sequence_read_rows(input, t, y, rows, codes, err);
        if (!code)
            add_luminance(input, codes, y, rows, to, plane);
    }
    free(codes);
    return code;
}

/* Binomial weights 1 4 6 4 1 along one axis, the edge's value beyond it. */
static void smooth_line(float *line, size_t stride, uint32_t n, float *scratch)
{
    for (uint32_t i = 0; i < n + 4; i++)
        scratch[i] = line[stride * (i < 2 ? 0 : i - 2 < n ? i - 2 : n - 1)];
    for (uint32_t i = 0; i < n; i++)
        line[stride * i] = (scratch[i] + scratch[i + 4] + 4 * (scratch[i + 1] + scratch[i + 3]) +
                            6 * scratch[i + 2]) /
                           16;
}

/* Gradients are compared between pixels, so they must be smooth: twice a binomial is a sigma of 1.4 pixels. */
static void smooth(float *plane, uint32_t width, uint32_t height, float *scratch)
{
    for (int pass = 0; pass < 2; pass++) {
        for (uint32_t y = 0; y < height; y++)
            smooth_line(plane + (size_t)y * width, 1, width, scratch);
        for (uint32_t x = 0; x < width; x++)
            smooth_line(plane + x, width, height, scratch);
    }
}

/* Central differences; 0 along the border. */
static void differences(const float *plane, uint32_t width, uint32_t height, float *gx, float *gy)
{
    for (uint32_t y = 1; y + 1 < height; y++) {
        for (uint32_t x = 1; x + 1 < width; x++) {
            size_t i = (size_t)y * width + x;

            gx[i] = 0.5f * (plane[i + 1] - plane[i - 1]);
            gy[i] = 0.5f * (plane[i + width] - plane[i - width]);
        }
    }
}

static void halve(float *plane, uint32_t width, uint32_t half_width, uint32_t half_height)
{
    float *to = plane;

    for (uint32_t y = 0; y < half_height; y++) {
        const float *a = plane + (size_t)2 * y * width, *b = a + width;

        for (uint32_t x = 0; x < half_width; x++, a += 2, b += 2)
            *to++ = 0.25f * (a[0] + a[1] + b[0] + b[1]);
    }
}

static int gradients_create(uint32_t width, uint32_t height, struct gradients *ret,
                            struct ttf_err *err)
{
    struct gradients made = {.shrink = 1};
    size_t room = 0;
    float *at;

    while (width / made.shrink > LARGEST_SIDE || height / made.shrink > LARGEST_SIDE)
        made.shrink *= 2;
    for (uint32_t l = 0; l < REGISTRATION_LEVELS; l++) {
        made.width[l] = (width / made.shrink) >> l;
        made.height[l] = (height / made.shrink) >> l;
        if (made.width[l] < REGISTRATION_LEAST_SIDE || made.height[l] < REGISTRATION_LEAST_SIDE)
            break;
        room += (size_t)made.width[l] * made.height[l] * 2;
        made.levels++;
    }
    if (made.levels == 0)
        return ttf_err_set(err, -EINVAL, "stabilise",
                           "pictures of %u x %u are too small to be held against each other", width,
                           height);
    made.planes = calloc(room, sizeof(*made.planes));
    if (!made.planes)
        return ttf_err_set(err, -ENOMEM, "stabilise", "no memory for pictures of %u x %u", width,
                           height);
    at = made.planes;
    for (uint32_t l = 0; l < made.levels; l++) {
        size_t pixels = (size_t)made.width[l] * made.height[l];

        made.x[l] = at;
        made.y[l] = at + pixels;
        at += 2 * pixels;
    }
    *ret = made;
    return 0;
}

void ttf_gradients_free(struct gradients *gradients)
{
    free(gradients->planes);
    *gradients = (struct gradients){0};
}

/* picture and copy: room for level 0 each; line: for its larger side and 4. */
static void build(const struct gradients *to, float *picture, float *copy, float *line)
{
    size_t pixels = (size_t)to->width[0] * to->height[0];

    /* light spans decades; its root brings dark and bright parts nearer to equal say, as a display does */
    for (size_t i = 0; i < pixels; i++)
        picture[i] = picture[i] > 0.0f ? sqrtf(picture[i]) : 0.0f;
    for (uint32_t l = 0; l < to->levels; l++) {
        memcpy(copy, picture, (size_t)to->width[l] * to->height[l] * sizeof(*copy));
        smooth(copy, to->width[l], to->height[l], line);
        differences(copy, to->width[l], to->height[l], to->x[l], to->y[l]);
        if (l + 1 < to->levels)
            halve(picture, to->width[l], to->width[l + 1], to->height[l + 1]);
    }
}

int ttf_gradients_load(struct ttf_sequence *input, uint32_t t, struct gradients *ret,
                       struct ttf_err *err)
{
    struct gradients made = {.shrink = 1};
    float *scratch = NULL;
    size_t pixels, side;
    int code = gradients_create(input->width, input->height, &made, err);

    if (code)
        return code;
    pixels = (size_t)made.width[0] * made.height[0];
    side = made.width[0] > made.height[0] ? made.width[0] : made.height[0];
    scratch = calloc(2 * pixels + side + 4, sizeof(*scratch));
    if (!scratch)
        code = ttf_err_set(err, -ENOMEM, "stabilise", "no memory for pictures of %u x %u",
                           input->width, input->height);
    if (!code)
        code = load_luminance(input, t, &made, scratch, err);
    if (!code) {
        build(&made, scratch, scratch + pixels, scratch + 2 * pixels);
        *ret = made;
    } else {
        ttf_gradients_free(&made);
    }
    free(scratch);
    return code;
}
