/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Copper growing its patina: bright brushed metal; brown tarnish spreads from spots behind an
 * iridescent front; black follows; then crusts of verdigris nucleate, run down and thicken.
 */
#include <math.h>
#include <stdlib.h>

#include "noise.h"
#include "scene_field.h"
#include "scene_kind.h"
#include "scene_sites.h"

#define TARNISH_SITES 70
#define BLACK_SITES   60
#define GREEN_SITES   90

struct copper {
    uint32_t seed;
    struct site tarnish[TARNISH_SITES];
    struct site black[BLACK_SITES];
    struct site green[GREEN_SITES];
};

/* The fields kept. */
enum {
    METAL,
    TARNISH,
    BLACK,
    GREEN,
    GRAIN,
    CRUST
};

static void scatter(struct site *site, unsigned n, uint64_t stream, float first, float last,
                    float pace, float curve, float stretch)
{
    for (unsigned i = 0; i < n; i++) {
        const uint64_t k = 6 * (uint64_t)i;
        /* Squared: a few early, fast ones and many late ones. */
        const float u = noise_uniform(stream, k + 2), v = noise_uniform(stream, k + 3);

        site[i].x = -0.05f + 1.1f * noise_uniform(stream, k);
        site[i].y = (-0.05f + 1.1f * noise_uniform(stream, k + 1)) * SCENE_ASPECT;
        site[i].birth = first + (last - first) * sqrtf(u);
        site[i].pace = pace * (0.5f + 1.5f * v);
        site[i].curve = curve * (0.4f + 2.0f * v * v);
        site[i].stretch = 1.0f + (stretch - 1.0f) * noise_uniform(stream, k + 4);
    }
}

static void *copper_create(uint64_t seed)
{
    struct copper *f = malloc(sizeof(*f));

    if (!f)
        return NULL;
    f->seed = (uint32_t)noise_stream(seed, NOISE_SCENE, 2);
    scatter(f->tarnish, TARNISH_SITES, noise_stream(seed, NOISE_SCENE, 3), 0.0f, 0.40f, 2.2f, 4.0f,
            1.3f);
    scatter(f->black, BLACK_SITES, noise_stream(seed, NOISE_SCENE, 4), 0.16f, 0.85f, 3.2f, 22.0f,
            1.6f);
    scatter(f->green, GREEN_SITES, noise_stream(seed, NOISE_SCENE, 5), 0.22f, 1.00f, 4.2f, 60.0f,
            3.2f);
    return f;
}

/* Brushed: fine grooves along x; each octave fades out where the pixels cannot show it. */
static float brushed(uint32_t seed, const struct scene_canvas *c, float x, float y)
{
    float sum = 0.10f * field_fractal(seed, x * 1.5f, y * 3.0f, 2, 0.5f);
    float along = 2.5f, across = 60.0f, strength = 0.05f;

    for (uint32_t k = 1; k < 5 && across * 2.0f < c->sy; k++) {
        sum += strength * field_noise(seed + k, x * along, y * across);
        along *= 1.9f;
        across *= 2.0f;
        strength *= 1.15f;
    }
    return 0.88f + sum;
}

/* Specks of verdigris: one in some cells of a lattice, each with its own birth. */
static float specks(uint32_t seed, float cells, float x, float y)
{
    const float here = field_noise(seed + 9, x * 5.0f, y * 5.0f);
    uint32_t id = 0;
    const float d = field_cells(seed, x * cells, y * cells, &id);
    const float u = (float)(id >> 8 & 0xffffu) * (1.0f / 65536.0f);

    if ((float)(id & 0xffu) > 55.0f + 420.0f * here)
        return 9.0f;
    return 0.14f + 0.75f * u + 3.5f * d * d;
}

static void copper_prepare(const void *features, const struct scene_canvas *c)
{
    const struct copper *f = features;
    const struct site_roughness tarnish = {f->seed + 100, 0.030f, 0.20f, 0.040f, 0.06f};
    const struct site_roughness black = {f->seed + 200, 0.030f, 0.12f, 0.060f, 0.03f};
    const struct site_roughness green = {f->seed + 300, 0.025f, 0.08f, 0.075f, 0.025f};
    const unsigned grains = field_octaves(c, 0.012f, 3);

    sites_arrival(f->tarnish, TARNISH_SITES, &tarnish, 0.62f, c, c->plane[TARNISH]);
    sites_arrival(f->black, BLACK_SITES, &black, 9.0f, c, c->plane[BLACK]);
    sites_arrival(f->green, GREEN_SITES, &green, 9.0f, c, c->plane[GREEN]);
    for (uint32_t y = 0; y < c->h; y++) {
        for (uint32_t x = 0; x < c->w; x++) {
            const size_t i = (size_t)y * c->w + x;
            const float px = field_x(c, x), py = field_y(c, y);
            const float wx = px + 0.004f * field_noise(f->seed + 41, px * 90.0f, py * 90.0f);
            const float wy = py + 0.004f * field_noise(f->seed + 42, px * 90.0f, py * 90.0f);
            const float dots =
                fminf(specks(f->seed + 50, 45.0f, wx, wy), specks(f->seed + 60, 110.0f, wx, wy));

            c->plane[METAL][i] = brushed(f->seed, c, px, py);
            c->plane[GREEN][i] = fminf(c->plane[GREEN][i], dots);
            c->plane[GRAIN][i] =
                0.5f +
                0.38f * field_fractal(f->seed + 400, px / 0.012f, py / 0.012f, grains, 0.8f) +
                0.30f * field_fractal(f->seed + 500, px * 14.0f, py * 8.0f, 3, 0.6f);
        }
    }
}

static void mix_in(float *rgb, float share, float r, float g, float b)
{
    rgb[0] += share * (r - rgb[0]);
    rgb[1] += share * (g - rgb[1]);
    rgb[2] += share * (b - rgb[2]);
}

/* The surface at one pixel: metal, then what has grown over it. slope: of the crust towards the light. */
static void colour(const struct scene_canvas *c, size_t i, float phase, float slope, float *rgb)
{
    const float metal = c->plane[METAL][i], grain = c->plane[GRAIN][i];
    const float tarnish = phase - c->plane[TARNISH][i];
    const float black = phase - c->plane[BLACK][i];
    const float green = phase - c->plane[GREEN][i];
    const float film =
        field_step(0.0f, 0.05f, tarnish) * (1.0f - field_step(0.05f, 0.16f, tarnish));
    const float brown = field_step(0.02f, 0.22f, tarnish);
    const float dark = field_step(0.0f, 0.09f, black) * (0.80f + 0.15f * grain);
    const float rim = field_step(-0.05f, 0.0f, green);
    const float cover = field_step(0.0f, 0.035f, green);
    const float thick = field_step(0.05f, 0.45f, green);
    const float pale = field_clamp(0.25f + 0.9f * (grain - 0.5f) + 0.45f * thick, 0.0f, 1.0f);
    const float light = field_clamp(1.0f + slope, 0.35f, 1.7f);

    rgb[0] = 0.80f * metal;
    rgb[1] = 0.375f * metal;
    rgb[2] = 0.205f * metal;
    mix_in(rgb, 0.65f * film, 0.54f * metal, 0.17f * metal, 0.16f * metal);
    mix_in(rgb, 0.92f * brown, 0.235f * metal, 0.105f * metal, 0.055f * metal);
    mix_in(rgb, dark, 0.050f, 0.038f, 0.034f);
    mix_in(rgb, 0.6f * rim, 0.075f, 0.060f, 0.045f);
    mix_in(rgb, cover * (0.82f + 0.18f * thick), field_mix(0.055f, 0.300f, pale) * light,
           field_mix(0.230f, 0.560f, pale) * light, field_mix(0.205f, 0.480f, pale) * light);
}

static void copper_render(const void *features, const struct scene_canvas *c, float phase,
                          float *rgb)
{
    const size_t n = (size_t)c->w * c->h;
    float *crust = c->plane[CRUST];
    /* Heights in units of the plane; the light stands low in the upper left. */
    const float steep = 1.8f * c->sx;

    for (size_t i = 0; i < n; i++) {
        const float age = field_clamp((phase - c->plane[GREEN][i]) * 4.0f, 0.0f, 1.0f);

        crust[i] = age * (2.0f - age) * (0.0015f + 0.0022f * c->plane[GRAIN][i]);
    }
    for (uint32_t y = 0; y < c->h; y++) {
        for (uint32_t x = 0; x < c->w; x++) {
            const size_t i = (size_t)y * c->w + x;
            const float left = crust[x ? i - 1 : i], up = crust[y ? i - c->w : i];

            colour(c, i, phase, (2.0f * crust[i] - left - up) * steep * 0.22f, rgb + 3 * i);
        }
    }
}

const struct scene_kind scene_copper = {.name = "copper",
                                        .planes = 5,
                                        .scratch = 1,
                                        .create = copper_create,
                                        .destroy = free,
                                        .prepare = copper_prepare,
                                        .render = copper_render};
