/* SPDX-License-Identifier: Apache-2.0 */
#include "scene_blade.h"

#include <math.h>
#include <stddef.h>

#include "scene_field.h"

#define PIECES 8

/* A joint between two pieces of the ribbon, in pixels. */
struct joint {
    float x, y;
    float tx, ty; /* tangent: the line across the ribbon here divides the pieces */
    float half;
    float light; /* brightness here */
    float gloss; /* sky reflected where the blade lies flat */
};

/* Where a*x + b changes sign bounds the span from below (a > 0) or above (a < 0). */
struct span {
    int lo, hi; /* pixels lo..hi-1 */
};

static int first_at_or_above(float x)
{
    /* The first pixel whose middle is at or right of x; far-away values are of no interest. */
    return (int)ceilf(field_clamp(x, -4.0f, 70000.0f) - 0.5f);
}

/* Keeps the pixels (middle x) with a*x + b >= 0, or < 0 if `below`. */
static void cut(struct span *s, float a, float b, int below)
{
    int at;

    if (fabsf(a) < 1e-6f) {
        if ((b >= 0.0f) == (below != 0))
            s->hi = s->lo;
        return;
    }
    at = first_at_or_above(-b / a);
    if ((a > 0.0f) == (below != 0))
        s->hi = at < s->hi ? at : s->hi;
    else
        s->lo = at > s->lo ? at : s->lo;
}

static void place_joints(const struct blade_shape *b, const struct scene_canvas *c,
                         struct joint joint[PIECES + 1])
{
    const float step = b->length / PIECES;
    float x = b->x, y = b->y;

    for (int k = 0; k <= PIECES; k++) {
        const float q = (float)k / PIECES;
        const float angle = b->lean + b->bend * q * sqrtf(q);
        const float sn = sinf(angle), cs = cosf(angle);
        const float up = b->look.root_light;
        struct joint *j = &joint[k];

        j->x = x * c->sx;
        j->y = y * c->sy;
        j->tx = sn;
        j->ty = -cs;
        j->half = b->half * c->sx * (0.72f + 0.28f * fminf(1.0f, q * 4.0f)) * (1.0f - q * q * q) *
                  (k == PIECES ? 0.0f : 1.0f);
        /* Light comes from the upper left: what leans to the right is turned away from it. */
        j->light = field_mix(up, 1.0f, field_step(-0.15f, 0.75f, q)) * (1.0f - 0.22f * sn);
        j->gloss = 0.10f * field_step(0.5f, 1.3f, fabsf(angle)) * q;
        x += step * sn;
        y -= step * cs;
    }
}

/* One row of one piece. d: signed distance right of the ribbon's middle line, pixels. */
static void paint_span(const struct joint *p, const struct joint *q, const struct blade_look *look,
                       const struct span *s, float d, float d_step, float t, float t_step,
                       float shadow_px, float *rgb)
{
    const float shadow_rate = look->shadow / shadow_px;

    for (int x = s->lo; x < s->hi; x++, d += d_step, t += t_step, rgb += 3) {
        const float u = field_clamp(t, 0.0f, 1.0f);
        const float half = field_mix(p->half, q->half, u);
        const float away = fabsf(d);
        float cover = half - away + 0.5f;

        if (cover > 0.0f) {
            const float across = d / (half + 0.5f);
            /* Folded along the middle: the left half faces the light, the rib is pale. */
            const float fold = across < 0.0f ? 1.12f : 0.86f;
            const float rib = away < 0.16f * half ? 1.10f : 1.0f;
            const float light = field_mix(p->light, q->light, u) * fold * rib;
            const float gloss = field_mix(p->gloss, q->gloss, u);

            cover = fminf(fminf(cover, 1.0f), 2.0f * half);
            for (int k = 0; k < 3; k++)
                rgb[k] += cover * (look->colour[k] * light + gloss - rgb[k]);
        } else if (d > 0.0f) {
            const float dark = 1.0f - shadow_rate * fmaxf(0.0f, shadow_px + half - d);

            rgb[0] *= dark;
            rgb[1] *= dark;
            rgb[2] *= dark;
        }
    }
}

static void draw_piece(const struct joint *p, const struct joint *q, const struct blade_look *look,
                       const struct scene_canvas *c, float *rgb)
{
    const float ex = q->x - p->x, ey = q->y - p->y;
    const float length = sqrtf(ex * ex + ey * ey);
    const float shadow_px = look->shadow_width * c->sx;
    const float left = fmaxf(p->half, q->half) + 0.5f, right = left - 0.5f + shadow_px;
    const float reach = fmaxf(left, right) + 1.0f;
    float nx, ny;
    int y0, y1;

    if (length < 1e-4f)
        return;
    nx = -ey / length; /* to the right of the direction of growth */
    ny = ex / length;
    y0 = (int)field_clamp(fminf(p->y, q->y) - reach, 0.0f, (float)c->h);
    y1 = (int)field_clamp(fmaxf(p->y, q->y) + reach + 1.0f, 0.0f, (float)c->h);
    for (int y = y0; y < y1; y++) {
        const float py = (float)y + 0.5f;
        const float off = (py - p->y) * ny - p->x * nx; /* d = nx * x + off */
        struct span s = {0, (int)c->w};
        float px, t;

        cut(&s, nx, off + left, 0);
        cut(&s, nx, off - right, 1);
        cut(&s, p->tx, (py - p->y) * p->ty - p->x * p->tx, 0);
        cut(&s, q->tx, (py - q->y) * q->ty - q->x * q->tx, 1);
        if (s.lo >= s.hi)
            continue;
        px = (float)s.lo + 0.5f;
        t = ((px - p->x) * ex + (py - p->y) * ey) / (length * length);
        paint_span(p, q, look, &s, nx * px + off, nx, t, ex / (length * length), shadow_px,
                   rgb + ((size_t)y * c->w + (size_t)s.lo) * 3);
    }
}

void blade_draw(const struct blade_shape *shape, const struct scene_canvas *c, float *rgb)
{
    const float x = shape->x * c->sx, y = shape->y * c->sy;
    const float reach = shape->length * fmaxf(c->sx, c->sy) + shape->half * c->sx +
                        shape->look.shadow_width * c->sx + 2.0f;
    struct joint joint[PIECES + 1];

    if (x + reach < 0.0f || x - reach > (float)c->w || y + reach < 0.0f || y - reach > (float)c->h)
        return;
    place_joints(shape, c, joint);
    for (int k = 0; k < PIECES; k++)
        draw_piece(&joint[k], &joint[k + 1], &shape->look, c, rgb);
}
