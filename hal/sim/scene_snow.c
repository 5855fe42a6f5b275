/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Snow settling on slate: single flakes first, then layer upon layer; it lies unevenly, softens the
 * stone's steps, stays thin where the wind sweeps, and is shaded by its own relief.
 *
 * Every flake that ever falls has a place, a size and a moment. Five layers' arrival
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
    float turn, arms; /* of its six arms: their angle, and how far they stand out */
};

struct snow {
    uint32_t seed;
    struct flake flake[LAYERS][FLAKES];
};

/* The fields: a layer's arrival each, then the stone's brightness, the drift, the stone's height, the swell; then work. */
enum {
    LAYER0,
    STONE = LAYERS,
    DRIFT,
    STEP,
    SWELL,
    HEIGHT,
    COVER
};

static void *snow_create(uint64_t seed)
{
    struct snow *f = malloc(sizeof(*f));

    if (!f)
        return NULL;
    f->seed = (uint32_t)noise_stream(seed, NOISE_SCENE, 30);
    for (unsigned l = 0; l < LAYERS; l++) {
        const uint64_t s = noise_stream(seed, NOISE_SCENE, 31 + l);
        /* The layers follow one another, each well begun before the last one is complete. */
        const float first = l ? 0.14f + 0.15f * (float)l : 0.02f, lasts = l ? 0.38f : 0.60f;

        for (unsigned i = 0; i < FLAKES; i++) {
            struct flake *p = &f->flake[l][i];
            const uint64_t k = 5 * (uint64_t)i;
            const float u = noise_uniform(s, k + 2);

            p->x = -0.02f + 1.04f * noise_uniform(s, k);
            p->y = (-0.02f + 1.04f * noise_uniform(s, k + 1)) * SCENE_ASPECT;
            p->radius = 0.0035f + 0.0070f * u * u;
            /* Later they fall in clumps. */
            if (l > 0)
                p->radius *= 1.5f;
            p->arms = l > 0 ? 0.10f : 0.24f;
            /* It begins softly. */
            p->birth = first + lasts * sqrtf(noise_uniform(s, k + 3));
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
            const float rim = 0.98f - p->arms * (1.6f - six);
            const float at = p->birth + 0.05f * field_step(0.5f * rim, rim, sqrtf(d2));
            float *a = &arrival[(size_t)y * c->w + (size_t)x];

            if (d2 < rim * rim && at < *a)
                *a = at;
        }
    }
}

/*
 * Slate chippings: slabs of random height and tilt, the nearest of a lattice's points deciding which,
 * with a fine grain. Returns the height, and the slab's own brightness.
 */
static float slate_at(const struct snow *f, const struct scene_canvas *c, float x, float y,
                      float *ret_tone)
{
    const unsigned fine = field_octaves(c, 0.05f, 4);
    const float wx = x + 0.02f * field_fractal(f->seed + 5, x * 9.0f, y * 9.0f, 2, 0.5f);
    const float wy = y + 0.02f * field_fractal(f->seed + 6, x * 9.0f, y * 9.0f, 2, 0.5f);
    const float grain = field_fractal(f->seed + 2, x / 0.05f, y / 0.03f, fine, 0.7f);
    uint32_t big = 0, small = 0;
    const float d_big = field_cells(f->seed + 7, wx * 7.0f, wy * 11.0f, &big);
    const float d_small = field_cells(f->seed + 8, wx * 23.0f, wy * 34.0f, &small);
    /* Small chips lie on some of the slabs. */
    const int chips = (big & 3u) == 0;
    const uint32_t id = chips ? small : big;
    const float level = (float)(id >> 8 & 0xffu) * (1.0f / 255.0f);
    const float d = chips ? d_small * 0.5f : d_big;

    *ret_tone = 0.70f + 0.55f * (float)(id >> 16 & 0xffu) * (1.0f / 255.0f);
    return 0.016f * level - 0.010f * d * d + 0.0022f * grain;
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

            c->plane[HEIGHT][i] = slate_at(f, c, px, py, &c->plane[STONE][i]);
            /* The wind's doing: more here, less there. */
            c->plane[DRIFT][i] =
                field_clamp(1.0f + 0.8f * field_fractal(f->seed + 3, px * 3.0f, py * 4.0f, 3, 0.5f),
                            0.35f, 2.0f);
            c->plane[SWELL][i] = field_fractal(f->seed + 9, px * 7.0f, py * 9.0f, 3, 0.45f);
        }
    }
    for (uint32_t y = 0; y < c->h; y++) {
        for (uint32_t x = 0; x < c->w; x++) {
            const size_t i = (size_t)y * c->w + x;
            const float *h = c->plane[HEIGHT];
            const float left = h[x ? i - 1 : i], up = h[y ? i - c->w : i];
            const float slope = (h[i] - left) * c->sx + (h[i] - up) * c->sy;
            c->plane[STEP][i] = h[i];
            c->plane[STONE][i] *= field_clamp(0.085f * (1.0f + 0.55f * slope), 0.010f, 0.20f);
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
    float *height = c->plane[HEIGHT], *cover = c->plane[COVER];
    /* The deeper the snow, the less of the stone's steps it shows. */
    const float bare = 1.0f - phase, show = 0.9f * bare * bare;
    /* Thick snow rolls in soft swells of its own. */
    const float rolls = 0.030f * phase * phase * phase;

    for (size_t i = 0; i < n; i++) {
        const float snow = snow_height(c, i, phase);

        height[i] = snow + show * c->plane[STEP][i] + rolls * c->plane[SWELL][i];
        cover[i] = field_clamp(snow * 900.0f, 0.0f, 1.0f);
    }
    for (uint32_t y = 0; y < c->h; y++) {
        for (uint32_t x = 0; x < c->w; x++, rgb += 3) {
            const size_t i = (size_t)y * c->w + x;
            const float left = height[x ? i - 1 : i], up = height[y ? i - c->w : i];
            const float slope = (height[i] - left) * c->sx + (height[i] - up) * c->sy;
            const float lit = field_clamp(0.82f + 0.13f * slope, 0.30f, 0.95f);
            const float stone = c->plane[STONE][i];
            /* Shadow on snow is blue: only the sky lights it. */
            const float blue = 0.10f * (0.95f - lit);

            rgb[0] = field_mix(stone * 0.95f, lit - blue, cover[i]);
            rgb[1] = field_mix(stone * 1.00f, lit, cover[i]);
            rgb[2] = field_mix(stone * 1.12f, fminf(lit + blue, 0.97f), cover[i]);
        }
    }
}

const struct scene_kind scene_snow = {.name = "snow",
                                      .planes = LAYERS + 4,
                                      .scratch = 2,
                                      .create = snow_create,
                                      .destroy = free,
                                      .prepare = snow_prepare,
                                      .render = snow_render};
