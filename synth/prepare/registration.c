/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Coarse to fine: every whole shift on the smallest picture, then uphill from level to
 * level, then, between pixels, Gauss-Newton steps (Lucas and Kanade's, with the still
 * picture's derivatives, Baker and Matthews 2004).
 */
#include <limits.h>
#include <math.h>
#include <stdbool.h>
#include <stdint.h>

#include "prepare/registration.h"

#define COARSE_RADIUS 6     /* level pixels that every whole shift is tried within */
#define CLIMB_MOST    16    /* steps on one level */
#define STEPS_MOST    12    /* between pixels */
#define ENOUGH_PX     0.002 /* a step below it is the last */
#define LEAST_ENERGY \
    1e-10 /* of a pixel's gradient, in units of root of value: noise of rounding is above it */
#define NEAR_BONUS 0.02 /* correlation that being near the likely place is worth */
#define DAMPING    1e-3 /* of the larger curvature: holds what stripes leave open */

/* Sums of the products of two gradient fields. */
struct products {
    double ab, aa, bb;
    double pixels;
};

static double correlation(const struct products *p)
{
    double energy = p->aa < p->bb ? p->aa : p->bb;

    return energy > LEAST_ENERGY * p->pixels ? p->ab / sqrt(p->aa * p->bb) : 0.0;
}

static double whole_shift(const struct gradients *a, const struct gradients *b, uint32_t l, int dx,
                          int dy)
{
    int width = (int)a->width[l], height = (int)a->height[l];
    int x0 = dx < 0 ? -dx : 0, x1 = dx > 0 ? width - dx : width;
    int y0 = dy < 0 ? -dy : 0, y1 = dy > 0 ? height - dy : height;
    ptrdiff_t by = (ptrdiff_t)dy * width + dx;
    struct products all = {0};

    for (int y = y0; y < y1; y++) {
        float ab = 0.0f, aa = 0.0f, bb = 0.0f;

        for (ptrdiff_t i = (ptrdiff_t)y * width + x0; i < (ptrdiff_t)y * width + x1; i++) {
            float ax = a->x[l][i], ay = a->y[l][i], bx = b->x[l][i + by], b_y = b->y[l][i + by];

            ab += ax * bx + ay * b_y;
            aa += ax * ax + ay * ay;
            bb += bx * bx + b_y * b_y;
        }
        all.ab += (double)ab;
        all.aa += (double)aa;
        all.bb += (double)bb;
    }
    all.pixels = x1 > x0 && y1 > y0 ? (double)(x1 - x0) * (y1 - y0) : 0.0;
    return correlation(&all);
}

struct place {
    int x, y;
    double score;
};

/* All whole shifts around `centre`, in pixels of level l. */
static struct place try_all(const struct gradients *a, const struct gradients *b, uint32_t l,
                            struct shift centre, double radius)
{
    int reach = (int)ceil(radius), cx = (int)lround(centre.x), cy = (int)lround(centre.y);
    struct place best = {cx, cy, -2.0};

    for (int dy = cy - reach; dy <= cy + reach; dy++) {
        for (int dx = cx - reach; dx <= cx + reach; dx++) {
            double score = whole_shift(a, b, l, dx, dy);

            if (score > best.score)
                best = (struct place){dx, dy, score};
        }
    }
    return best;
}

static struct place climb(const struct gradients *a, const struct gradients *b, uint32_t l,
                          struct place from)
{
    struct place best = {from.x, from.y, whole_shift(a, b, l, from.x, from.y)};

    for (int step = 0; step < CLIMB_MOST; step++) {
        struct place middle = best;

        for (int i = 0; i < 9; i++) {
            int dx = middle.x + i % 3 - 1, dy = middle.y + i / 3 - 1;
            double score = i == 4 ? middle.score : whole_shift(a, b, l, dx, dy);

            if (score > best.score)
                best = (struct place){dx, dy, score};
        }
        if (best.x == middle.x && best.y == middle.y)
            break;
    }
    return best;
}

/* The normal equations of one step, over pixels that stay inside with a margin. */
struct normal {
    double xx, xy, yy;   /* the still picture's curvature */
    double bx, by;       /* its derivatives times the moved one */
    double ax, ay;       /* and times itself */
    struct products all; /* of the fields */
};

/* A field at a place between four pixels, whose weights are the same for the whole picture. */
static float blend(const float *p, uint32_t width, const float weight[4])
{
    return p[0] * weight[0] + p[1] * weight[1] + p[width] * weight[2] + p[width + 1] * weight[3];
}

static void add_pixel(const float *a, const float *b, uint32_t width, const float weight[4],
                      float sums[10])
{
    float dx = 0.5f * (a[1] - a[-1]), dy = 0.5f * (a[width] - *(a - width));
    float other = blend(b, width, weight);

    sums[0] += dx * dx;
    sums[1] += dx * dy;
    sums[2] += dy * dy;
    sums[3] += dx * other;
    sums[4] += dy * other;
    sums[5] += dx * *a;
    sums[6] += dy * *a;
    sums[7] += *a * other;
    sums[8] += *a * *a;
    sums[9] += other * other;
}

static struct normal collect(const struct gradients *a, const struct gradients *b, struct shift d,
                             uint32_t margin)
{
    uint32_t width = a->width[0], height = a->height[0];
    double fx = floor(d.x), fy = floor(d.y);
    float u = (float)(d.x - fx), v = (float)(d.y - fy);
    float weight[4] = {(1 - u) * (1 - v), u * (1 - v), (1 - u) * v, u * v};
    ptrdiff_t by = (ptrdiff_t)fy * (ptrdiff_t)width + (ptrdiff_t)fx;
    double total[10] = {0};

    for (size_t y = margin; y + margin < height; y++) {
        float sums[10] = {0};

        for (size_t x = margin; x + margin < width; x++) {
            ptrdiff_t i = (ptrdiff_t)(y * width + x);

            add_pixel(a->x[0] + i, b->x[0] + i + by, width, weight, sums);
            add_pixel(a->y[0] + i, b->y[0] + i + by, width, weight, sums);
        }
        for (int k = 0; k < 10; k++)
            total[k] += (double)sums[k];
    }
    return (struct normal){.xx = total[0],
                           .xy = total[1],
                           .yy = total[2],
                           .bx = total[3],
                           .by = total[4],
                           .ax = total[5],
                           .ay = total[6],
                           .all = {total[7], total[8], total[9],
                                   ((double)width - 2 * margin) * ((double)height - 2 * margin)}};
}

/* Moves *d by one Gauss-Newton step; the pictures may differ by a gain. Returns the step's length. */
static double step(const struct normal *n, struct shift *d)
{
    double gain = n->all.ab / n->all.bb;
    double damping = DAMPING * (n->xx + n->yy);
    double xx = n->xx + damping, yy = n->yy + damping;
    double rx = gain * n->bx - n->ax, ry = gain * n->by - n->ay;
    double det = xx * yy - n->xy * n->xy;
    double sx = (yy * rx - n->xy * ry) / det, sy = (xx * ry - n->xy * rx) / det;
    double length = hypot(sx, sy);
    double shorter = length > 0.5 ? 0.5 / length : 1.0;

    d->x -= sx * shorter;
    d->y -= sy * shorter;
    return length;
}

static uint32_t margin_of(struct shift d, uint32_t side)
{
    double away = fmax(fabs(d.x), fabs(d.y)) + 4.0;

    return away < side / 2.0 ? (uint32_t)away : (side + 1) / 2;
}

static double refine(const struct gradients *a, const struct gradients *b, struct shift *d)
{
    uint32_t side = a->width[0] < a->height[0] ? a->width[0] : a->height[0];
    uint32_t margin = margin_of(*d, side);
    struct shift start = *d;
    double found = 0.0;

    for (int i = 0; i < STEPS_MOST; i++) {
        struct normal n = collect(a, b, *d, margin);
        double length;

        found = correlation(&n.all);
        if (found <= 0.0)
            break;
        length = step(&n, d);
        /* the whole shift was the best one: away from it there is nothing to find */
        if (hypot(d->x - start.x, d->y - start.y) > 2.0) {
            *d = start;
            break;
        }
        if (length < ENOUGH_PX)
            break;
    }
    return found > 0.0 ? found : 0.0;
}

static struct shift scaled(struct shift s, double by)
{
    return (struct shift){s.x * by, s.y * by};
}

/* From a whole shift on level `from` down to between pixels. */
static double descend(const struct gradients *a, const struct gradients *b, uint32_t from,
                      struct place start, struct place *ret_whole, struct shift *ret)
{
    struct place place = start;

    for (uint32_t l = from; l > 0; l--)
        place = climb(a, b, l - 1, (struct place){2 * place.x, 2 * place.y, 0.0});
    if (place.x != ret_whole->x || place.y != ret_whole->y) {
        *ret_whole = place;
        *ret = (struct shift){place.x, place.y};
        return refine(a, b, ret);
    }
    return -1.0;
}

/*
 * What repeats is like itself a period away, and on a small picture perhaps more like itself
 * there, between its pixels being as it is: so the likely place is tried as well.
 */
double ttf_registration_find(const struct gradients *still, const struct gradients *moved,
                             struct shift centre, double radius_px, struct shift likely,
                             struct shift *ret)
{
    struct shift expected = scaled(likely, 1.0 / still->shrink), best = expected, near = expected;
    struct place whole = {INT_MAX, INT_MAX, 0.0}, start;
    double unit = 1.0 / still->shrink, score, near_score;
    uint32_t top = 0;

    while (top + 1 < still->levels && radius_px * unit > COARSE_RADIUS) {
        top++;
        unit /= 2.0;
    }
    start = try_all(still, moved, top, scaled(centre, unit), radius_px * unit);
    score = descend(still, moved, top, start, &whole, &best);
    start = climb(still, moved, 0,
                  (struct place){(int)lround(expected.x), (int)lround(expected.y), 0.0});
    near_score = descend(still, moved, 0, start, &whole, &near);
    if (near_score > 0.0 && near_score >= score - NEAR_BONUS) {
        score = near_score;
        best = near;
    }
    *ret = score > 0.0 ? scaled(best, still->shrink) : likely;
    return score;
}
