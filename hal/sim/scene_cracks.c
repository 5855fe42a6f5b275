/* SPDX-License-Identifier: Apache-2.0 */
#include "scene_cracks.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "noise.h"
#include "scene_kind.h"

/* The layer reaches a border beyond the plane, so that no crack starts at the picture's edge. */
#define BORDER   0.05f
#define GRID_W   440
#define GRID_H   340
#define CELL     0.0025f /* side of a grid cell, units */
#define STEP     0.0032f /* a tip advances by this */
#define ROUNDS   900     /* steps of time from FIRST to 1 */
#define FIRST    0.06f
#define TIPS_MAX 512
#define PIECES   24000

struct tip {
    float x, y, angle, wander;
    float width;
    int crack, parent; /* parent: the crack it left, which does not stop its first steps */
    int steps;
    int alive;
};

struct growth {
    uint64_t stream, draws;
    int16_t grid[GRID_H][GRID_W]; /* crack that passes here, -1: none */
    struct tip tip[TIPS_MAX];
    unsigned tips;
    int cracks;
    struct crack_net *net;
};

static float draw(struct growth *g)
{
    return noise_uniform(g->stream, g->draws++);
}

static int16_t *cell(struct growth *g, float x, float y)
{
    const int ix = (int)((x + BORDER) / CELL), iy = (int)((y + BORDER) / CELL);

    if (x < -BORDER || y < -BORDER || ix >= GRID_W || iy >= GRID_H)
        return NULL;
    return &g->grid[iy][ix];
}

/* A crack other than a and b in the cells around, or -1. */
static int met(struct growth *g, float x, float y, int a, int b)
{
    for (int j = -1; j <= 1; j++) {
        for (int i = -1; i <= 1; i++) {
            const int16_t *at = cell(g, x + (float)i * CELL, y + (float)j * CELL);

            if (at && *at >= 0 && *at != a && *at != b)
                return *at;
        }
    }
    return -1;
}

/* Is any crack within r of this place? If so, one of the nearest cells' middle. */
static int relieved(struct growth *g, float x, float y, float r, float *ret_x, float *ret_y,
                    int *ret_crack)
{
    const int n = (int)(r / CELL);
    int best = n * n + 1;

    for (int j = -n; j <= n; j++) {
        for (int i = -n; i <= n; i++) {
            const int16_t *at = cell(g, x + (float)i * CELL, y + (float)j * CELL);

            if (at && *at >= 0 && i * i + j * j < best) {
                best = i * i + j * j;
                *ret_x = x + (float)i * CELL;
                *ret_y = y + (float)j * CELL;
                *ret_crack = *at;
            }
        }
    }
    return best <= n * n;
}

static void add_tip(struct growth *g, float x, float y, float angle, float width, int crack,
                    int parent)
{
    struct tip *t;

    if (g->tips == TIPS_MAX)
        return;
    t = &g->tip[g->tips++];
    t->x = x;
    t->y = y;
    t->angle = angle;
    t->wander = 0.0f;
    t->width = width;
    t->crack = crack;
    t->parent = parent;
    t->steps = 0;
    t->alive = 1;
}

static void nucleate(struct growth *g, float phase)
{
    /* Tension is relieved this far from a crack; the layer gets more brittle with time. */
    const float apart = 0.10f * (1.0f - phase) * (1.0f - phase) + 0.024f;
    const float x = -BORDER + draw(g) * (1.0f + 2.0f * BORDER);
    const float y = -BORDER + draw(g) * (SCENE_ASPECT + 2.0f * BORDER);
    const float turn = 3.14159265f * draw(g), start = draw(g);
    const float width = (0.0042f * (1.0f - phase) + 0.0012f) * (0.7f + 0.6f * draw(g));
    float cx = x, cy = y;
    int from = -1;

    if (relieved(g, x, y, apart, &cx, &cy, &from))
        return;
    if (start < 0.7f && relieved(g, x, y, 2.2f * apart, &cx, &cy, &from)) {
        /* Tension points along the nearest crack, so the new one leaves it at a right angle. */
        add_tip(g, cx, cy, atan2f(y - cy, x - cx), width, g->cracks++, from);
        return;
    }
    add_tip(g, x, y, turn, width, g->cracks, -1);
    add_tip(g, x, y, turn + 3.14159265f, width, g->cracks++, -1);
}

static void advance(struct growth *g, struct tip *t, float phase, float step_phase)
{
    float nx, ny;
    int16_t *at;
    int other;

    /* A straight course, wandered about; now and then a flaw in the layer gives it a kink. */
    t->wander = 0.80f * t->wander + 0.42f * (draw(g) - 0.5f);
    if (draw(g) < 0.035f)
        t->angle += 0.9f * (draw(g) - 0.5f);
    nx = t->x + STEP * cosf(t->angle + t->wander);
    ny = t->y + STEP * sinf(t->angle + t->wander);
    at = cell(g, nx, ny);
    other = met(g, nx, ny, t->crack, t->steps < 6 ? t->parent : -1);
    if (g->net->n < PIECES) {
        const struct crack_piece p = {t->x, t->y, nx, ny, phase, phase + step_phase, t->width};

        g->net->piece[g->net->n++] = p;
    }
    t->x = nx;
    t->y = ny;
    t->steps++;
    if (!at || other >= 0) {
        t->alive = 0;
        return;
    }
    if (*at < 0)
        *at = (int16_t)t->crack;
}

static void drop_dead(struct growth *g)
{
    unsigned kept = 0;

    for (unsigned i = 0; i < g->tips; i++) {
        if (g->tip[i].alive)
            g->tip[kept++] = g->tip[i];
    }
    g->tips = kept;
}

int cracks_grow(uint64_t stream, struct crack_net *ret)
{
    struct growth *g = malloc(sizeof(*g));
    const float step_phase = (1.0f - FIRST) / ROUNDS;

    ret->piece = malloc(PIECES * sizeof(*ret->piece));
    ret->n = 0;
    if (!g || !ret->piece) {
        free(g);
        cracks_finish(ret);
        return -ENOMEM;
    }
    memset(g, 0, sizeof(*g));
    memset(g->grid, -1, sizeof(g->grid));
    g->stream = stream;
    g->net = ret;
    for (int round = 0; round < ROUNDS; round++) {
        const float phase = FIRST + step_phase * (float)round;

        /* More tries as tension rises; most land where it is already relieved. */
        const float tries = 0.10f + 7.0f * phase * phase;
        const int whole = (int)tries;

        for (int n = draw(g) < tries - (float)whole ? -1 : 0; n < whole; n++)
            nucleate(g, phase);
        for (unsigned i = 0; i < g->tips; i++)
            advance(g, &g->tip[i], phase, step_phase);
        drop_dead(g);
    }
    free(g);
    return 0;
}

void cracks_finish(struct crack_net *net)
{
    free(net->piece);
    net->piece = NULL;
    net->n = 0;
}
