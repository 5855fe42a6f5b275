/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Grass growing, seen from above at a slant: soil, then blades that sprout one by one,
 * lengthen, bend over and hide and shade what lies behind them. Drawn from far (top) to near.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "noise.h"
#include "scene_blade.h"
#include "scene_field.h"
#include "scene_kind.h"

#define BLADES     3600
#define ROOT_TOP   (-0.02f)
#define ROOT_DEPTH 1.06f /* roots reach below the frame, so that the near edge is covered too */
#define TUFTS      90

/* Cells of the map of how much foliage stands around. */
#define MAP_W 24
#define MAP_H 24

struct grass_blade {
    float x, y;       /* root */
    float birth;      /* phase at which it breaks the soil */
    float duration;   /* phase it needs to grow up */
    float length;     /* grown up */
    float half;       /* half width, grown up */
    float lean, bend; /* angle at the root from straight up; added over the length when grown up */
    float sway, sway_rate, sway_phase;
    float tint, dryness, light;
};

struct grass {
    uint32_t seed;
    struct grass_blade blade[BLADES];
};

static int by_distance(const void *a, const void *b)
{
    const struct grass_blade *p = a, *q = b;

    if (p->y != q->y)
        return p->y < q->y ? -1 : 1;
    return p->x < q->x ? -1 : p->x > q->x;
}

static float draw(uint64_t stream, uint64_t *count)
{
    return noise_uniform(stream, (*count)++);
}

static void plant(struct grass_blade *b, uint64_t s, const float (*tuft)[2])
{
    uint64_t n = 0;
    const float pick = draw(s, &n);
    float near, spread;

    b->x = -0.06f + 1.12f * draw(s, &n);
    b->y = ROOT_TOP + ROOT_DEPTH * draw(s, &n);
    if (pick < 0.45f) {
        const unsigned t = (unsigned)(draw(s, &n) * TUFTS);
        const float r = 0.035f * sqrtf(draw(s, &n)), a = 6.2831853f * draw(s, &n);

        b->x = tuft[t][0] + r * cosf(a);
        b->y = tuft[t][1] + r * sinf(a);
    }
    near = 0.72f + 0.38f * (b->y - ROOT_TOP);
    b->birth = 0.03f + 0.72f * powf(draw(s, &n), 1.15f);
    b->duration = 0.30f + 0.40f * draw(s, &n);
    b->length = near * (0.10f + 0.15f * draw(s, &n));
    b->half = near * (0.0018f + 0.0022f * draw(s, &n));
    spread = draw(s, &n) + draw(s, &n) + draw(s, &n) - 1.5f;
    b->lean = 0.55f * spread;
    b->bend = (spread < 0.0f ? -1.0f : 1.0f) * (0.1f + 1.5f * powf(draw(s, &n), 1.6f));
    if (draw(s, &n) < 0.15f)
        b->bend = -b->bend;
    b->sway = 0.015f + 0.03f * draw(s, &n);
    b->sway_rate = 6.2831853f * (4.0f + 7.0f * draw(s, &n));
    b->sway_phase = 6.2831853f * draw(s, &n);
    b->tint = draw(s, &n);
    b->dryness = draw(s, &n) < 0.06f ? 0.5f + 0.5f * draw(s, &n) : 0.0f;
    b->light = 0.8f + 0.4f * draw(s, &n);
}

static void *grass_create(uint64_t seed)
{
    const uint64_t stream = noise_stream(seed, NOISE_SCENE, 1);
    struct grass *g = malloc(sizeof(*g));
    float tuft[TUFTS][2];

    if (!g)
        return NULL;
    g->seed = (uint32_t)noise_draw(stream, 0);
    for (unsigned t = 0; t < TUFTS; t++) {
        tuft[t][0] = noise_uniform(stream, 2 * t + 1);
        tuft[t][1] = ROOT_TOP + ROOT_DEPTH * noise_uniform(stream, 2 * t + 2);
    }
    for (unsigned i = 0; i < BLADES; i++)
        plant(&g->blade[i], noise_stream(seed, NOISE_SCENE, 1000 + i), tuft);
    qsort(g->blade, BLADES, sizeof(g->blade[0]), by_distance);
    return g;
}

/* Crumbs of soil: rounded lumps of three sizes on uneven ground. */
static float soil_height(const struct grass *g, const struct scene_canvas *c, float x, float y)
{
    float h = 0.02f * field_fractal(g->seed + 11, x * 7.0f, y * 9.0f, 3, 0.5f);
    float size = 28.0f, weight = 0.020f;

    for (uint32_t k = 0; k < 3 && c->sx / size > 3.0f; k++) {
        uint32_t id;
        const float wx = 0.35f * field_noise(g->seed + 70 + k, x * size, y * size);
        const float d = field_cells(g->seed + 20 + k, x * size + wx, y * size * 1.25f, &id);
        const float lump = 1.0f - d * d * 1.6f;

        if (lump > 0.0f)
            h += weight * sqrtf(lump) * (0.35f + 0.65f * (float)(id & 0xffu) / 255.0f);
        size *= 2.1f;
        weight *= 0.5f;
    }
    return h + 0.0022f * field_fractal(g->seed + 31, x * 130.0f, y * 150.0f,
                                       field_octaves(c, 1.0f / 130.0f, 3), 0.8f);
}

static void grass_prepare(const void *features, const struct scene_canvas *c)
{
    const struct grass *g = features;
    float *height = c->plane[3];

    for (uint32_t y = 0; y < c->h; y++) {
        for (uint32_t x = 0; x < c->w; x++)
            height[(size_t)y * c->w + x] = soil_height(g, c, field_x(c, x), field_y(c, y));
    }
    for (uint32_t y = 0; y < c->h; y++) {
        for (uint32_t x = 0; x < c->w; x++) {
            const size_t i = (size_t)y * c->w + x;
            const float left = height[x ? i - 1 : i], up = height[y ? i - c->w : i];
            const float slope = (height[i] - left) * c->sx + (height[i] - up) * c->sy;
            const float lit = field_clamp(0.62f + 0.30f * slope, 0.12f, 1.5f);
            const float damp = field_step(
                -0.6f, 0.8f,
                field_fractal(g->seed + 5, field_x(c, x) * 4.0f, field_y(c, y) * 4.0f, 4, 0.6f));

            const float deep = field_clamp(0.55f + 14.0f * height[i], 0.35f, 1.15f);

            c->plane[0][i] = lit * deep * field_mix(0.150f, 0.085f, damp);
            c->plane[1][i] = lit * deep * field_mix(0.100f, 0.055f, damp);
            c->plane[2][i] = lit * deep * field_mix(0.062f, 0.034f, damp);
        }
    }
}

/* Share of its length that a blade has at this phase: quick at first, then slowly to its end. */
static float grown(const struct grass_blade *b, float phase)
{
    const float t = field_clamp((phase - b->birth) / b->duration, 0.0f, 1.0f);

    return t * (1.0f + t * (1.0f - t));
}

static void foliage_map(const struct grass *g, float phase, float map[MAP_H][MAP_W])
{
    memset(map, 0, sizeof(float) * MAP_H * MAP_W);
    for (unsigned i = 0; i < BLADES; i++) {
        const struct grass_blade *b = &g->blade[i];
        const int mx = (int)field_clamp(b->x * MAP_W, 0.0f, MAP_W - 1.0f);
        const int my = (int)field_clamp((b->y - ROOT_TOP) / ROOT_DEPTH * MAP_H, 0.0f, MAP_H - 1.0f);

        map[my][mx] += grown(b, phase) * b->length;
    }
}

/* Foliage around a place: the 3 x 3 cells, 0 (open) .. 1 (dense). */
static float foliage_at(float map[MAP_H][MAP_W], float x, float y)
{
    const float fx = field_clamp(x * MAP_W - 0.5f, 0.0f, MAP_W - 1.001f);
    const float fy = field_clamp((y - ROOT_TOP) / ROOT_DEPTH * MAP_H - 0.5f, 0.0f, MAP_H - 1.001f);
    const int ix = (int)fx, iy = (int)fy;
    const float tx = fx - (float)ix, ty = fy - (float)iy;
    const int jx = ix + 1, jy = iy + 1;
    const float sum = field_mix(field_mix(map[iy][ix], map[iy][jx], tx),
                                field_mix(map[jy][ix], map[jy][jx], tx), ty);

    return field_clamp(sum / 0.9f, 0.0f, 1.0f);
}

/* The soil, darker where foliage keeps the light from it. */
static void lay_soil(const struct scene_canvas *c, float map[MAP_H][MAP_W], float *rgb)
{
    for (uint32_t y = 0; y < c->h; y++) {
        const size_t row = (size_t)y * c->w;

        for (uint32_t x = 0; x < c->w; x++) {
            const float light = 1.0f - 0.55f * foliage_at(map, field_x(c, x), field_y(c, y));

            for (int k = 0; k < 3; k++)
                rgb[3 * (row + x) + k] = light * c->plane[k][row + x];
        }
    }
}

static void colour_blade(const struct grass_blade *b, float share, float crowd,
                         struct blade_look *look)
{
    /* From young, yellowish green to a deeper green; a few dry ones. */
    const float old = share * (0.45f + 0.55f * b->tint);
    const float dry = b->dryness * share;
    const float base[3] = {field_mix(0.200f, 0.070f, old), field_mix(0.370f, 0.190f, old),
                           field_mix(0.060f, 0.030f, old)};
    const float straw[3] = {0.42f, 0.36f, 0.16f};

    for (int k = 0; k < 3; k++)
        look->colour[k] = b->light * field_mix(base[k], straw[k], dry);
    look->root_light = field_mix(0.80f, 0.22f, crowd);
    look->shadow = 0.38f;
    look->shadow_width = 0.25f * b->half + 0.0035f;
}

static void draw_blade(const struct grass_blade *b, float phase, float crowd,
                       const struct scene_canvas *c, float *rgb)
{
    const float share = grown(b, phase);
    const float sway = b->sway * sinf(b->sway_rate * phase + b->sway_phase) * share;
    struct blade_shape shape;

    if (share <= 0.0f)
        return;
    shape.x = b->x;
    shape.y = b->y;
    shape.length = b->length * share;
    shape.half = b->half * (0.45f + 0.55f * share);
    shape.lean = b->lean + 0.4f * sway;
    shape.bend = b->bend * share * share + sway;
    colour_blade(b, share, crowd, &shape.look);
    blade_draw(&shape, c, rgb);
}

static void grass_render(const void *features, const struct scene_canvas *c, float phase,
                         float *rgb)
{
    const struct grass *g = features;
    float map[MAP_H][MAP_W];

    foliage_map(g, phase, map);
    lay_soil(c, map, rgb);
    for (unsigned i = 0; i < BLADES; i++) {
        const struct grass_blade *b = &g->blade[i];

        draw_blade(b, phase, foliage_at(map, b->x, b->y), c, rgb);
    }
}

const struct scene_kind scene_grass = {.name = "grass",
                                       .planes = 3,
                                       .scratch = 1,
                                       .create = grass_create,
                                       .destroy = free,
                                       .prepare = grass_prepare,
                                       .render = grass_render};
