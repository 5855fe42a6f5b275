/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Red acrylic over wood: a network of cracks nucleates, runs and opens, showing the
 * wood's grain; the islands' edges curl up and catch the light; here and there paint chips off.
 */
#include <math.h>
#include <stdlib.h>

#include "noise.h"
#include "scene_cracks.h"
#include "scene_field.h"
#include "scene_kind.h"

struct paint {
    uint32_t seed;
    struct crack_net net;
};

/* The fields kept, per pixel: of the crack that matters most there, then the two surfaces. */
enum {
    DISTANCE,
    BORN,
    WIDTH,
    FACING,
    STROKES,
    WOOD,
    CHIP
};

#define REACH     0.030f /* a crack is felt this far */
#define NO_CRACK  9.0f   /* born: never */
#define OPENING   0.22f  /* phase in which a crack opens by 63 % */
#define CHIP_PACE 15.0f  /* phase per unit by which chipping proceeds from an edge */

static void *paint_create(uint64_t seed)
{
    struct paint *f = calloc(1, sizeof(*f));

    if (!f)
        return NULL;
    f->seed = (uint32_t)noise_stream(seed, NOISE_SCENE, 10);
    if (cracks_grow(noise_stream(seed, NOISE_SCENE, 11), &f->net) < 0) {
        free(f);
        return NULL;
    }
    return f;
}

static void paint_destroy(void *features)
{
    struct paint *f = features;

    cracks_finish(&f->net);
    free(f);
}

/* Lets one piece claim the pixels it is nearest to, counted from its final edge. */
static void claim(const struct crack_piece *p, const struct scene_canvas *c, float *key)
{
    const float ex = p->x1 - p->x0, ey = p->y1 - p->y0, e2 = ex * ex + ey * ey;
    const int x0 = (int)field_clamp((fminf(p->x0, p->x1) - REACH) * c->sx, 0.0f, (float)c->w);
    const int x1 = (int)field_clamp((fmaxf(p->x0, p->x1) + REACH) * c->sx, 0.0f, (float)c->w);
    const int y0 = (int)field_clamp((fminf(p->y0, p->y1) - REACH) * c->sy, 0.0f, (float)c->h);
    const int y1 = (int)field_clamp((fmaxf(p->y0, p->y1) + REACH) * c->sy, 0.0f, (float)c->h);

    for (int y = y0; y < y1; y++) {
        const float py = field_y(c, (uint32_t)y);

        for (int x = x0; x < x1; x++) {
            const size_t i = (size_t)y * c->w + (size_t)x;
            const float qx = field_x(c, (uint32_t)x) - p->x0, qy = py - p->y0;
            const float t = field_clamp((qx * ex + qy * ey) / e2, 0.0f, 1.0f);
            const float dx = qx - t * ex, dy = qy - t * ey;
            const float d = sqrtf(dx * dx + dy * dy), k = d - p->width;

            if (k >= key[i])
                continue;
            key[i] = k;
            c->plane[DISTANCE][i] = d;
            c->plane[BORN][i] = field_mix(p->t0, p->t1, t);
            c->plane[WIDTH][i] = p->width;
            /* How far away from the crack is towards the light (upper left). */
            c->plane[FACING][i] = -(0.6f * dx + 0.8f * dy) / fmaxf(d, 1e-6f);
        }
    }
}

/* Growth rings cut along: wavy bands with fine pores. */
static float wood_at(const struct paint *f, const struct scene_canvas *c, float x, float y)
{
    const float wave = 0.05f * field_fractal(f->seed + 7, x * 1.6f, y * 5.0f, 3, 0.5f);
    const float ring = (y + wave) * 26.0f;
    const float saw = ring - floorf(ring);
    const float band = saw * saw * (1.0f - field_step(0.86f, 1.0f, saw));
    float pores = 0.0f;

    if (c->sy > 480.0f)
        pores = field_noise(f->seed + 8, x * 14.0f, y * 240.0f);
    return field_clamp(0.85f - 0.75f * band + 0.35f * pores, 0.0f, 1.0f);
}

static float strokes_at(const struct paint *f, const struct scene_canvas *c, float x, float y)
{
    /* Brush strokes run at a slant; the relief is shaded already. */
    const float u = 0.94f * x + 0.34f * y, v = 0.94f * y - 0.34f * x;
    const float bend = 0.02f * field_noise(f->seed + 20, u * 3.0f, v * 3.0f);
    const float coarse = field_noise(f->seed + 21, u * 5.0f, (v + bend) * 60.0f);
    const float fine =
        c->sy > 500.0f ? field_noise(f->seed + 22, u * 12.0f, (v + bend) * 190.0f) : 0.0f;
    const float cloud = field_fractal(f->seed + 23, x * 3.0f, y * 3.0f, 3, 0.5f);

    return 1.0f + 0.16f * coarse + 0.14f * fine + 0.07f * cloud;
}

static void paint_prepare(const void *features, const struct scene_canvas *c)
{
    const struct paint *f = features;
    const size_t n = (size_t)c->w * c->h;
    float *key = c->plane[CHIP]; /* until the end only */

    for (size_t i = 0; i < n; i++) {
        key[i] = REACH;
        c->plane[DISTANCE][i] = REACH;
        c->plane[BORN][i] = NO_CRACK;
        c->plane[WIDTH][i] = 0.0f;
        c->plane[FACING][i] = 0.0f;
    }
    for (unsigned k = 0; k < f->net.n; k++)
        claim(&f->net.piece[k], c, key);
    for (uint32_t y = 0; y < c->h; y++) {
        for (uint32_t x = 0; x < c->w; x++) {
            const size_t i = (size_t)y * c->w + x;
            const float px = field_x(c, x), py = field_y(c, y);
            const float torn = field_fractal(f->seed + 30, px * 130.0f, py * 130.0f,
                                             field_octaves(c, 1.0f / 130.0f, 3), 0.6f);
            const float weak = field_fractal(f->seed + 31, px * 16.0f, py * 16.0f, 3, 0.5f);

            c->plane[DISTANCE][i] = fmaxf(0.0f, c->plane[DISTANCE][i] + 0.0007f * torn);
            c->plane[STROKES][i] = strokes_at(f, c, px, py);
            c->plane[WOOD][i] = wood_at(f, c, px, py);
            c->plane[CHIP][i] = c->plane[BORN][i] + 0.85f + CHIP_PACE * c->plane[DISTANCE][i] -
                                0.80f * weak + 0.05f * torn;
        }
    }
}

static void colour(const struct scene_canvas *c, size_t i, float phase, float *rgb)
{
    const float age = fmaxf(0.0f, phase - c->plane[BORN][i]);
    const float share = age / (age + OPENING * 0.7f) * (1.0f + OPENING * 0.5f);
    const float half = c->plane[WIDTH][i] * share;
    const float d = c->plane[DISTANCE][i], facing = c->plane[FACING][i];
    const float px = c->sx;
    /* Open where the crack or a chip has come, with a soft edge of one pixel. */
    const float crack = field_clamp((half - d) * px + 0.5f, 0.0f, fminf(1.0f, 2.0f * half * px));
    const float chip = field_clamp((phase - c->plane[CHIP][i]) * px / CHIP_PACE + 0.5f, 0.0f, 1.0f);
    const float open = fmaxf(crack, chip);
    const float outside = fmaxf(0.0f, d - half);
    const float lift = share * (0.35f + 90.0f * c->plane[WIDTH][i]);
    const float curl = lift * expf(-outside * 150.0f);
    const float lip = 0.5f * share * fmaxf(0.0f, 1.0f - outside * px * 0.5f);
    /* The side towards the light casts its shadow into the crack. */
    const float depth = field_clamp(d / (half + 1e-5f), 0.0f, 1.0f);
    const float shade =
        field_clamp(0.62f - 0.45f * facing * depth * (1.0f - chip) + 0.25f * chip, 0.10f, 1.0f);
    const float light = field_clamp(
        c->plane[STROKES][i] + 0.60f * curl * facing + lip * (0.25f + 0.6f * facing), 0.30f, 2.2f);
    const float shine = 0.03f * field_clamp(light - 1.0f, 0.0f, 1.0f);
    const float wood = c->plane[WOOD][i];
    const float red[3] = {0.46f * light + shine, 0.033f * light + shine, 0.026f * light + shine};
    const float bare[3] = {field_mix(0.23f, 0.52f, wood) * shade,
                           field_mix(0.115f, 0.33f, wood) * shade,
                           field_mix(0.050f, 0.165f, wood) * shade};

    for (int k = 0; k < 3; k++)
        rgb[k] = red[k] + open * (bare[k] - red[k]);
}

static void paint_render(const void *features, const struct scene_canvas *c, float phase,
                         float *rgb)
{
    const size_t n = (size_t)c->w * c->h;

    for (size_t i = 0; i < n; i++)
        colour(c, i, phase, rgb + 3 * i);
}

const struct scene_kind scene_paint = {.name = "paint",
                                       .planes = 7,
                                       .create = paint_create,
                                       .destroy = paint_destroy,
                                       .prepare = paint_prepare,
                                       .render = paint_render};
