/* SPDX-License-Identifier: Apache-2.0 */
#include "scene_sites.h"

#include <math.h>
#include <stddef.h>

#include "scene_field.h"

/* Pixels worked on at a time: their displaced places fit the stack. */
#define STRIP 256

struct strip {
    float x[STRIP], y[STRIP];
    float first[STRIP];
};

static void spread(const struct site *s, struct strip *p, unsigned n)
{
    const float below = 1.0f / (s->stretch * s->stretch);

    for (unsigned i = 0; i < n; i++) {
        const float dx = p->x[i] - s->x, dy = p->y[i] - s->y;
        const float d2 = dx * dx + dy * dy * (dy > 0.0f ? below : 1.0f);
        const float at = s->birth + s->pace * sqrtf(d2) + s->curve * d2;

        p->first[i] = at < p->first[i] ? at : p->first[i];
    }
}

void sites_arrival(const struct site *site, unsigned n, const struct site_roughness *rough,
                   float latest, const struct scene_canvas *c, float *dst)
{
    const unsigned coarse = field_octaves(c, rough->shift_scale, 4);
    const unsigned fine = field_octaves(c, rough->jitter_scale, 5);
    const float k = 1.0f / rough->shift_scale, j = 1.0f / rough->jitter_scale;
    struct strip p;

    for (uint32_t y = 0; y < c->h; y++) {
        for (uint32_t x0 = 0; x0 < c->w; x0 += STRIP) {
            const unsigned m = c->w - x0 < STRIP ? c->w - x0 : STRIP;

            for (unsigned i = 0; i < m; i++) {
                const float px = field_x(c, x0 + i), py = field_y(c, y);

                p.x[i] =
                    px + rough->shift * field_fractal(rough->seed, px * k, py * k, coarse, 0.6f);
                p.y[i] = py + rough->shift *
                                  field_fractal(rough->seed + 1, px * k, py * k, coarse, 0.6f);
                p.first[i] = latest;
            }
            for (unsigned s = 0; s < n; s++)
                spread(&site[s], &p, m);
            for (unsigned i = 0; i < m; i++)
                dst[(size_t)y * c->w + x0 + i] =
                    p.first[i] + rough->jitter * field_fractal(rough->seed + 2,
                                                               field_x(c, x0 + i) * j,
                                                               field_y(c, y) * j, fine, 0.7f);
        }
    }
}
