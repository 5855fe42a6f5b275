/* SPDX-License-Identifier: Apache-2.0 */
#include "scene_sites.h"

#include <math.h>
#include <stddef.h>

#include "scene_field.h"

/* Pixels worked on at a time: their displaced places fit the stack. */
#define STRIP 64

struct strip {
    float x[STRIP], y[STRIP];
    float first[STRIP];
};

/* Arrivals later than this are as good as none: phases end at 1, and scenes look ahead by a little. */
#define NEVER 1.5f

struct box {
    float x0, x1, y0, y1;
};

static struct box box_of(const struct strip *p, unsigned n)
{
    struct box b = {p->x[0], p->x[0], p->y[0], p->y[0]};

    for (unsigned i = 1; i < n; i++) {
        b.x0 = fminf(b.x0, p->x[i]);
        b.x1 = fmaxf(b.x1, p->x[i]);
        b.y0 = fminf(b.y0, p->y[i]);
        b.y1 = fmaxf(b.y1, p->y[i]);
    }
    return b;
}

/* Can this site's front come anywhere into the box before NEVER? */
static int comes_into(const struct site *s, const struct box *b)
{
    const float dx = fmaxf(0.0f, fmaxf(b->x0 - s->x, s->x - b->x1));
    const float dy = fmaxf(0.0f, fmaxf(b->y0 - s->y, s->y - b->y1));
    const float far = fmaxf(1.0f, s->stretch);
    const float d2 = dx * dx + dy * dy / (far * far);

    return s->birth + s->pace * sqrtf(d2) + s->curve * d2 < NEVER;
}

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
            const struct box box = box_of(&p, m);
            for (unsigned s = 0; s < n; s++) {
                if (comes_into(&site[s], &box))
                    spread(&site[s], &p, m);
            }
            for (unsigned i = 0; i < m; i++)
                dst[(size_t)y * c->w + x0 + i] =
                    p.first[i] + rough->jitter * field_fractal(rough->seed + 2,
                                                               field_x(c, x0 + i) * j,
                                                               field_y(c, y) * j, fine, 0.7f);
        }
    }
}
