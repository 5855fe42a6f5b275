/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A banana's skin ripening: green gives way to yellow from the ridges and ends, brown spots nucleate,
 * grow to uneven patches and merge, and at last the skin darkens along its ridges.
 */
#include <math.h>
#include <stdlib.h>

#include "noise.h"
#include "scene_field.h"
#include "scene_kind.h"
#include "scene_sites.h"

#define SPOTS   560
#define BRUISES 26

struct banana {
    uint32_t seed;
    float ridge[3]; /* where the skin's edges run, across the plane's height */
    struct site spot[SPOTS];
    struct site bruise[BRUISES];
};

enum {
    LIGHT,
    RIPE,
    SPOT,
    BRUISE,
    FIBRE
};

static void *banana_create(uint64_t seed)
{
    const uint64_t s = noise_stream(seed, NOISE_SCENE, 20);
    struct banana *f = malloc(sizeof(*f));

    if (!f)
        return NULL;
    f->seed = (uint32_t)s;
    for (unsigned i = 0; i < 3; i++)
        f->ridge[i] = (0.08f + 0.36f * (float)i + 0.10f * noise_uniform(s, i)) * SCENE_ASPECT;
    for (unsigned i = 0; i < SPOTS; i++) {
        const uint64_t k = 100 + 8 * (uint64_t)i;
        const float size = noise_uniform(s, k + 3);

        f->spot[i].x = -0.02f + 1.04f * noise_uniform(s, k);
        f->spot[i].y = (-0.02f + 1.04f * noise_uniform(s, k + 1)) * SCENE_ASPECT;
        f->spot[i].birth = 0.28f + 0.62f * sqrtf(noise_uniform(s, k + 2));
        /* Mostly freckles that hardly grow; a few that become patches. */
        f->spot[i].pace = 5.0f + 22.0f * size;
        f->spot[i].curve = 70.0f + 5200.0f * size * size;
        f->spot[i].stretch = 1.0f;
    }
    for (unsigned i = 0; i < BRUISES; i++) {
        const uint64_t k = 9000 + 8 * (uint64_t)i;

        f->bruise[i].x = noise_uniform(s, k);
        f->bruise[i].y = f->ridge[(unsigned)(3.0f * noise_uniform(s, k + 1))] +
                         0.05f * (noise_uniform(s, k + 2) - 0.5f);
        f->bruise[i].birth = 0.50f + 0.40f * noise_uniform(s, k + 3);
        f->bruise[i].pace = 2.2f + 3.0f * noise_uniform(s, k + 4);
        f->bruise[i].curve = 10.0f;
        f->bruise[i].stretch = 0.45f;
    }
    return f;
}

/* Height over the skin's facets: flat between the ridges, folded at them. Returns light, and how near a ridge is. */
static float facet_light(const struct banana *f, float x, float y, float *ret_near)
{
    const float arch = 0.10f * (x - 0.5f) * (x - 0.5f); /* the fruit's curve */
    float light = 1.05f, nearest = 1.0f;

    for (unsigned i = 0; i < 3; i++) {
        const float d = y + arch - 0.02f - f->ridge[i];

        /* Each ridge turns the skin further away from the lamp above. */
        light -= 0.15f * field_step(-0.05f, 0.05f, d);
        light += 0.10f * expf(-d * d * 900.0f);
        nearest = fminf(nearest, fabsf(d));
    }
    *ret_near = expf(-nearest * nearest * 500.0f);
    return light;
}

static void banana_prepare(const void *features, const struct scene_canvas *c)
{
    const struct banana *f = features;
    const struct site_roughness spots = {f->seed + 100, 0.011f, 0.040f, 0.060f, 0.012f};
    const struct site_roughness bruises = {f->seed + 200, 0.035f, 0.10f, 0.070f, 0.020f};

    sites_arrival(f->spot, SPOTS, &spots, 9.0f, c, c->plane[SPOT]);
    sites_arrival(f->bruise, BRUISES, &bruises, 9.0f, c, c->plane[BRUISE]);
    for (uint32_t y = 0; y < c->h; y++) {
        for (uint32_t x = 0; x < c->w; x++) {
            const size_t i = (size_t)y * c->w + x;
            const float px = field_x(c, x), py = field_y(c, y);
            const float slow = field_fractal(f->seed + 1, px * 2.5f, py * 4.0f, 4, 0.5f);
            const float fibre =
                field_fractal(f->seed + 2, px * 9.0f, py * 110.0f, c->sy > 400.0f ? 2 : 1, 0.6f);
            const float pore =
                c->sy > 400.0f ? field_noise(f->seed + 3, px * 210.0f, py * 210.0f) : 0.0f;
            float ridge;

            c->plane[LIGHT][i] = facet_light(f, px, py, &ridge) *
                                 (1.0f + 0.035f * fibre + 0.06f * pore + 0.04f * slow);
            c->plane[FIBRE][i] = fibre;
            /* Ripe first along the middle of the fruit's facets, last at the ridges and the stem (left). */
            c->plane[RIPE][i] =
                0.16f + 0.13f * slow + 0.10f * ridge - 0.14f * (px - 0.5f) + 0.015f * fibre;
        }
    }
}

static void colour(const struct scene_canvas *c, size_t i, float phase, float *rgb)
{
    const float light = c->plane[LIGHT][i], fibre = c->plane[FIBRE][i];
    const float ripe = field_step(-0.14f, 0.14f, phase - c->plane[RIPE][i]);
    const float mellow = field_step(0.35f, 1.0f, phase);
    const float spot = phase - c->plane[SPOT][i], bruise = phase - c->plane[BRUISE][i];
    const float halo = 0.35f * field_step(-0.10f, 0.0f, spot);
    const float core = field_step(0.0f, 0.020f, spot);
    const float dark = field_step(0.02f, 0.30f, spot);
    const float stain = field_step(-0.02f, 0.22f, bruise) * (0.80f + 0.12f * fibre);
    const float black = field_step(0.12f, 0.42f, bruise);
    static const float green[3] = {0.190f, 0.370f, 0.035f};
    static const float yellow[3] = {0.800f, 0.560f, 0.045f};
    static const float ochre[3] = {0.620f, 0.360f, 0.045f};
    static const float brown[3] = {0.270f, 0.115f, 0.030f};
    static const float umber[3] = {0.075f, 0.032f, 0.014f};

    for (int k = 0; k < 3; k++) {
        float v = field_mix(green[k], yellow[k], ripe);

        v = field_mix(v, ochre[k], 0.55f * mellow);
        v = field_mix(v, ochre[k] * 0.8f, halo);
        v = field_mix(v, field_mix(brown[k], umber[k], black), field_clamp(stain, 0.0f, 1.0f));
        v = field_mix(v, field_mix(brown[k], umber[k], dark), core);
        rgb[k] = v * light;
    }
}

static void banana_render(const void *features, const struct scene_canvas *c, float phase,
                          float *rgb)
{
    const size_t n = (size_t)c->w * c->h;

    for (size_t i = 0; i < n; i++)
        colour(c, i, phase, rgb + 3 * i);
}

const struct scene_kind scene_banana = {.name = "banana",
                                        .planes = 5,
                                        .create = banana_create,
                                        .destroy = free,
                                        .prepare = banana_prepare,
                                        .render = banana_render};
