/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Snow settling on slate: single flakes first, then layer upon layer; it lies unevenly, fills the
 * stone's steps last where the wind sweeps, and is shaded by its own relief.
 *
 * Every flake that ever falls has a place, a size and a moment. Six layers' arrival
 * fields say when each pixel is first hit by that layer; the height of the snow is
 * the sum of the layers that have come, so old relief is buried and new appears.
 */
#include <math.h>
#include <stdlib.h>

#include "noise.h"
#include "scene_field.h"
#include "scene_kind.h"

#define LAYERS 5
#define FLAKES 9000 /* in a layer */

struct flake {
    float x, y, radius, birth;
    float turn; /* of its six arms */
};

struct snow {
    uint32_t seed;
    struct flake flake[LAYERS][FLAKES];
};

/* The fields: a layer's arrival each, then the stone's brightness, its tint, and the drift; then work. */
enum {
    LAYER0,
    STONE = LAYERS,
    DRIFT,
    STEP,
    HEIGHT
};

static void *snow_create(uint64_t seed)
{
    struct snow *f = malloc(sizeof(*f));

    if (!f)
        return NULL;
    f->seed = (uint32_t)noise_stream(seed, NOISE_SCENE, 30);
    for (unsigned l = 0; l < LAYERS; l++) {
        const uint64_t s = noise_stream(seed, NOISE_SCENE, 31 + l);
        const float first = 0.02f + 0.15f * (float)l;

        for (unsigned i = 0; i < FLAKES; i++) {
            struct flake *p = &f->flake[l][i];
            const uint64_t k = 5 * (uint64_t)i;
            const float u = noise_uniform(s, k + 2);

            p->x = -0.02f + 1.04f * noise_uniform(s, k);
            p->y = (-0.02f + 1.04f * noise_uniform(s, k + 1)) * SCENE_ASPECT;
            p->radius = 0.0030f + 0.0070f * u * u;
            /* It begins softly. */
            p->birth =
                first + 0.42f * (l ? noise_uniform(s, k + 3) : sqrtf(noise_uniform(s, k + 3)));
            p->turn = noise_uniform(s, k + 4) * 1.0471976f;
        }
    }
    return f;
}

/* Lets a flake hit its pixels: at once in its middle, a little later at its feathery rim as it settles. */
static void settle(const struct snow *f, const struct flake *p, const struct scene_canvas *c,
                   float *arrival)
{
    const float r = p->radius;
    const int x0 = (int)field_clamp((p->x - r) * c->sx, 0.0f, (float)c->w);
    const int x1 = (int)field_clamp((p->x + r) * c->sx + 1.0f, 0.0f, (float)c->w);
    const int y0 = (int)field_clamp((p->y - r) * c->sy, 0.0f, (float)c->h);
    const int y1 = (int)field_clamp((p->y + r) * c->sy + 1.0f, 0.0f, (float)c->h);
    const float cs = cosf(p->turn), sn = sinf(p->turn);

    for (int y = y0; y < y1; y++) {
        for (int x = x0; x < x1; x++) {
            const float dx = (field_x(c, (uint32_t)x) - p->x) / r;
            const float dy = (field_y(c, (uint32_t)y) - p->y) / r;
            const float u = dx * cs + dy * sn, v = dy * cs - dx * sn;
            const float d2 = u * u + v * v;
            /* cos of six times the angle, without angles: Re((u + iv)^6) / d^6. */
            const float re = u * u - v * v, im = 2.0f * u * v;
            const float six = re * (re * re - 3.0f * im * im) / (d2 * d2 * d2 + 1e-9f);
            const float rim = 0.62f + 0.22f * six;
            const float at = p->birth + 0.05f * field_step(0.5f * rim, rim, sqrtf(d2));
            float *a = &arrival[(size_t)y * c->w + (size_t)x];

            if (d2 < rim * rim && at < *a)
                *a = at;
        }
    }
}

/* Slate: cleaved in plates, each a little lower than the last, with a fine grain. */
static float slate_height(const struct snow *f, const struct scene_canvas *c, float x, float y)
{
    const unsigned fine = field_octaves(c, 0.08f, 5);
    const float wide = field_fractal(f->seed + 1, x * 2.2f, y * 3.4f, 5, 0.55f);
    const float plates = wide * 5.0f, whole = floorf(plates);
    const float edge = field_step(0.80f, 1.0f, plates - whole);

    return 0.030f * (whole + edge) +
           0.006f * field_fractal(f->seed + 2, x / 0.08f, y / 0.05f, fine, 0.65f);
}

static void snow_prepare(const void *features, const struct scene_canvas *c)
{
    const struct snow *f = features;
    const size_t n = (size_t)c->w * c->h;

    for (unsigned l = 0; l < LAYERS; l++) {
        float *arrival = c->plane[LAYER0 + l];

        for (size_t i = 0; i < n; i++)
            arrival[i] = 9.0f;
        for (unsigned i = 0; i < FLAKES; i++)
            settle(f, &f->flake[l][i], c, arrival);
    }
    for (uint32_t y = 0; y < c->h; y++) {
        for (uint32_t x = 0; x < c->w; x++) {
            const size_t i = (size_t)y * c->w + x;
            const float px = field_x(c, x), py = field_y(c, y);

            c->plane[HEIGHT][i] = slate_height(f, c, px, py);
            /* The wind's doing: more here, less there. */
            c->plane[DRIFT][i] =
                field_clamp(1.0f + 0.8f * field_fractal(f->seed + 3, px * 3.0f, py * 4.0f, 3, 0.5f),
                            0.25f, 2.0f);
        }
    }
    for (uint32_t y = 0; y < c->h; y++) {
        for (uint32_t x = 0; x < c->w; x++) {
            const size_t i = (size_t)y * c->w + x;
            const float *h = c->plane[HEIGHT];
            const float left = h[x ? i - 1 : i], up = h[y ? i - c->w : i];
            const float slope = (h[i] - left) * c->sx + (h[i] - up) * c->sy;
            const float vein = field_noise(f->seed + 4, field_x(c, x) * 6.0f, field_y(c, y) * 6.0f);

            c->plane[STEP][i] = h[i];
            c->plane[STONE][i] = field_clamp(0.075f + 0.05f * slope + 0.025f * vein, 0.012f, 0.22f);
        }
    }
}

/* Height of the snow alone, in units of the plane. */
static float snow_height(const struct scene_canvas *c, size_t i, float phase)
{
    float h = 0.0f;

    for (unsigned l = 0; l < LAYERS; l++) {
        const float age = field_clamp((phase - c->plane[LAYER0 + l][i]) * 6.0f, 0.0f, 1.0f);

        h += age * (2.0f - age) * 0.0016f;
    }
    return h * c->plane[DRIFT][i];
}

static void snow_render(const void *features, const struct scene_canvas *c, float phase, float *rgb)
{
    const size_t n = (size_t)c->w * c->h;
    float *height = c->plane[HEIGHT];
    /* The deeper the snow, the less of the stone's relief it shows. */
    const float show = 0.55f - 0.30f * phase;

    for (size_t i = 0; i < n; i++)
        height[i] = snow_height(c, i, phase) + show * c->plane[STEP][i];
    for (uint32_t y = 0; y < c->h; y++) {
        for (uint32_t x = 0; x < c->w; x++, rgb += 3) {
            const size_t i = (size_t)y * c->w + x;
            const float left = height[x ? i - 1 : i], up = height[y ? i - c->w : i];
            const float slope = (height[i] - left) * c->sx + (height[i] - up) * c->sy;
            const float lit = field_clamp(0.80f + 0.16f * slope, 0.30f, 0.95f);
            const float deep = height[i] - show * c->plane[STEP][i];
            const float cover = field_clamp(deep * 900.0f, 0.0f, 1.0f);
            const float stone = c->plane[STONE][i];
            /* Shadow on snow is blue: only the sky lights it. */
            const float blue = 0.10f * (0.95f - lit);

            rgb[0] = field_mix(stone * 0.95f, lit - blue, cover);
            rgb[1] = field_mix(stone * 1.00f, lit, cover);
            rgb[2] = field_mix(stone * 1.12f, fminf(lit + blue, 0.97f), cover);
        }
    }
}

const struct scene_kind scene_snow = {.name = "snow",
                                      .planes = LAYERS + 3,
                                      .scratch = 1,
                                      .create = snow_create,
                                      .destroy = free,
                                      .prepare = snow_prepare,
                                      .render = snow_render};
