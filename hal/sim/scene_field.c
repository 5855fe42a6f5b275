/* SPDX-License-Identifier: Apache-2.0 */
#include "scene_field.h"

#include <math.h>

static int floor_int(float x)
{
    const int i = (int)x;

    return (float)i > x ? i - 1 : i;
}

static float corner(uint32_t seed, int ix, int iy, float dx, float dy)
{
    /* Eight directions of equal length are enough at the scale of a few cells. */
    static const float gx[8] = {1.0f,  0.70710678f,  0.0f, -0.70710678f,
                                -1.0f, -0.70710678f, 0.0f, 0.70710678f};
    static const float gy[8] = {0.0f, 0.70710678f,  1.0f,  0.70710678f,
                                0.0f, -0.70710678f, -1.0f, -0.70710678f};
    const uint32_t k = field_hash(seed, (uint32_t)ix, (uint32_t)iy) >> 29;

    return gx[k] * dx + gy[k] * dy;
}

static float fade(float t)
{
    return t * t * t * (t * (t * 6.0f - 15.0f) + 10.0f);
}

float field_noise(uint32_t seed, float x, float y)
{
    const int ix = floor_int(x), iy = floor_int(y);
    const float fx = x - (float)ix, fy = y - (float)iy;
    const float u = fade(fx), v = fade(fy);
    const float a = corner(seed, ix, iy, fx, fy);
    const float b = corner(seed, ix + 1, iy, fx - 1.0f, fy);
    const float c = corner(seed, ix, iy + 1, fx, fy - 1.0f);
    const float d = corner(seed, ix + 1, iy + 1, fx - 1.0f, fy - 1.0f);

    return field_mix(field_mix(a, b, u), field_mix(c, d, u), v);
}

float field_fractal(uint32_t seed, float x, float y, unsigned octaves, float roughness)
{
    float sum = 0.0f, strength = 1.0f, total = 0.0f;

    for (unsigned i = 0; i < octaves; i++) {
        sum += strength * field_noise(seed + i * 0x3c6ef372u, x, y);
        total += strength * strength;
        strength *= roughness;
        /* Turned by an angle of no simple ratio, so the lattices never line up. */
        const float t = 1.6f * x + 1.2f * y;

        y = 1.6f * y - 1.2f * x;
        x = t;
    }
    return sum * 1.7f / sqrtf(total);
}

float field_cells(uint32_t seed, float x, float y, uint32_t *ret_id)
{
    const int ix = floor_int(x), iy = floor_int(y);
    float best = 9.0f;

    for (int j = iy - 1; j <= iy + 1; j++) {
        for (int i = ix - 1; i <= ix + 1; i++) {
            const uint32_t h = field_hash(seed, (uint32_t)i, (uint32_t)j);
            const float px = (float)i + (float)(h & 0xffffu) * (1.0f / 65536.0f) - x;
            const float py = (float)j + (float)(h >> 16) * (1.0f / 65536.0f) - y;
            const float d2 = px * px + py * py;

            if (d2 < best) {
                best = d2;
                *ret_id = h;
            }
        }
    }
    return sqrtf(best);
}

unsigned field_octaves(const struct scene_canvas *c, float coarsest, unsigned most)
{
    float pixels = coarsest * (c->sx < c->sy ? c->sx : c->sy);
    unsigned n = 1;

    while (n < most && pixels > 4.0f) {
        pixels *= 0.5f;
        n++;
    }
    return n;
}
