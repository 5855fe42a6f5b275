/* SPDX-License-Identifier: Apache-2.0 */
/* Samples that do not change: a chart of grey steps, colours and edges, a grid of dots, and an even white target. */
#include <math.h>
#include <stddef.h>
#include <stdlib.h>

#include "scene_kind.h"

#define WHITE_REFLECTANCE 0.9f

#define DOT_COLUMNS 16 /* across the plane; as many rows as make a square pitch */

#define COLUMNS 6
#define ROWS    4

/* Linear reflectances; the last row is a grey scale, each step about 0.3 density apart. */
static const float patches[ROWS][COLUMNS][3] = {
    {{0.17f, 0.08f, 0.055f},
     {0.56f, 0.30f, 0.22f},
     {0.11f, 0.20f, 0.34f},
     {0.09f, 0.15f, 0.05f},
     {0.22f, 0.22f, 0.44f},
     {0.12f, 0.51f, 0.42f}},
    {{0.69f, 0.20f, 0.02f},
     {0.06f, 0.10f, 0.38f},
     {0.55f, 0.09f, 0.12f},
     {0.10f, 0.04f, 0.14f},
     {0.35f, 0.50f, 0.04f},
     {0.75f, 0.36f, 0.02f}},
    {{0.02f, 0.05f, 0.29f},
     {0.05f, 0.30f, 0.06f},
     {0.43f, 0.03f, 0.04f},
     {0.81f, 0.57f, 0.01f},
     {0.50f, 0.09f, 0.30f},
     {0.01f, 0.24f, 0.38f}},
    {{0.90f, 0.90f, 0.90f},
     {0.59f, 0.59f, 0.59f},
     {0.36f, 0.36f, 0.36f},
     {0.19f, 0.19f, 0.19f},
     {0.09f, 0.09f, 0.09f},
     {0.031f, 0.031f, 0.031f}},
};

/* A scene without features still needs something to own. */
static void *create_nothing(uint64_t seed)
{
    return malloc(1);
}

static float overlap(float lo, float hi, float a, float b)
{
    return fmaxf(0.0f, fminf(hi, b) - fmaxf(lo, a)) / (hi - lo);
}

/* Share of the pixel [x0,x1] x [y0,y1] (in cells) that patch (column, row) covers; a tenth of a cell is frame. */
static float patch_cover(float x0, float x1, float y0, float y1, int column, int row)
{
    const float gap = 0.07f;

    return overlap(x0, x1, (float)column + gap, (float)(column + 1) - gap) *
           overlap(y0, y1, (float)row + gap, (float)(row + 1) - gap);
}

static void chart_render(const void *features, const struct scene_canvas *c, float phase,
                         float *rgb)
{
    const float ground = 0.045f;

    for (uint32_t y = 0; y < c->h; y++) {
        const float y0 = (float)y * ROWS / (float)c->h, y1 = (float)(y + 1) * ROWS / (float)c->h;

        for (uint32_t x = 0; x < c->w; x++, rgb += 3) {
            const float x0 = (float)x * COLUMNS / (float)c->w;
            const float x1 = (float)(x + 1) * COLUMNS / (float)c->w;

            rgb[0] = rgb[1] = rgb[2] = ground;
            for (int row = (int)y0; row < ROWS && (float)row < y1; row++) {
                for (int col = (int)x0; col < COLUMNS && (float)col < x1; col++) {
                    const float cover = patch_cover(x0, x1, y0, y1, col, row);

                    for (int k = 0; k < 3; k++)
                        rgb[k] += cover * (patches[row][col][k] - ground);
                }
            }
        }
    }
}

static void white_render(const void *features, const struct scene_canvas *c, float phase,
                         float *rgb)
{
    const size_t n = (size_t)c->w * c->h * 3;

    for (size_t i = 0; i < n; i++)
        rgb[i] = WHITE_REFLECTANCE;
}

/* Share of a pixel at (x, y) of the plane that a dot covers: its edge is a pixel wide. */
static float dot_cover(float x, float y, const struct scene_canvas *c)
{
    const float column = (floorf(x * DOT_COLUMNS) + 0.5f) / DOT_COLUMNS;
    const float row = (floorf(y * DOT_COLUMNS) + 0.5f) / DOT_COLUMNS;
    const float dx = x - column, dy = y - row, off = sqrtf(dx * dx + dy * dy);
    const float inside = (0.25f / DOT_COLUMNS - off) * 0.5f * (c->sx + c->sy) + 0.5f;

    return fmaxf(0.0f, fminf(1.0f, inside));
}

static void dots_render(const void *features, const struct scene_canvas *c, float phase, float *rgb)
{
    const float ground = 0.85f, dot = 0.05f;

    for (uint32_t y = 0; y < c->h; y++) {
        for (uint32_t x = 0; x < c->w; x++, rgb += 3) {
            const float cover = dot_cover(((float)x + 0.5f) / c->sx, ((float)y + 0.5f) / c->sy, c);

            rgb[0] = rgb[1] = rgb[2] = ground + cover * (dot - ground);
        }
    }
}

const struct scene_kind scene_chart = {
    .name = "chart", .create = create_nothing, .destroy = free, .render = chart_render};

const struct scene_kind scene_dots = {
    .name = "dots", .create = create_nothing, .destroy = free, .render = dots_render};

const struct scene_kind scene_white = {
    .name = "white", .create = create_nothing, .destroy = free, .render = white_render};
