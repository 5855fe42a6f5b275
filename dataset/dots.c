/* SPDX-License-Identifier: Apache-2.0 */
#include "dots.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define DARK       0.75 /* of the mean around: below it a pixel belongs to a dot */
#define AROUND     6 /* the mean is over so manyth parts of the picture's shorter side to each side */
#define AREA_LEAST 9    /* pixels */
#define SIZES      2.5  /* a dot is as much larger or smaller than the middle one at most */
#define STRETCH    2.0  /* of its box */
#define FILLED     0.5  /* of its box; a disc fills 0.785 */
#define ASTRAY     0.25 /* of the pitch: farther from where a neighbour says, it is no neighbour */
#define ACROSS     0.5  /* cosine: between rows and columns at most */

/* ---- dots ---- */

struct finder {
    const float *light;
    uint32_t width, height;
    double *sums;    /* (height + 1) x (width + 1): of all pixels above and to the left */
    uint8_t *dark;   /* 1: of a dot not yet looked at */
    uint32_t *stack; /* of pixels */
    struct dot *dots;
    size_t n;
};

struct box {
    uint32_t x0, y0, x1, y1; /* inclusive */
    uint32_t area;
};

static double mean_around(const struct finder *f, uint32_t x, uint32_t y)
{
    uint32_t side = (f->width < f->height ? f->width : f->height) / AROUND + 4;
    uint32_t x0 = x > side ? x - side : 0, y0 = y > side ? y - side : 0;
    uint32_t x1 = x + side + 1 < f->width ? x + side + 1 : f->width;
    uint32_t y1 = y + side + 1 < f->height ? y + side + 1 : f->height;
    size_t row = (size_t)f->width + 1;

    return (f->sums[y1 * row + x1] - f->sums[y0 * row + x1] - f->sums[y1 * row + x0] +
            f->sums[y0 * row + x0]) /
           ((double)(x1 - x0) * (y1 - y0));
}

static void mark_dark(struct finder *f)
{
    size_t row = (size_t)f->width + 1;

    for (uint32_t y = 0; y < f->height; y++) {
        double sum = 0;

        for (uint32_t x = 0; x < f->width; x++) {
            sum += (double)f->light[(size_t)y * f->width + x];
            f->sums[(y + 1) * row + x + 1] = f->sums[y * row + x + 1] + sum;
        }
    }
    for (uint32_t y = 0; y < f->height; y++) {
        for (uint32_t x = 0; x < f->width; x++) {
            size_t at = (size_t)y * f->width + x;

            f->dark[at] = (double)f->light[at] < DARK * mean_around(f, x, y);
        }
    }
}

/* All dark pixels that hang together with this one. */
static struct box take_blob(struct finder *f, uint32_t x, uint32_t y)
{
    struct box box = {x, y, x, y, 0};
    size_t n = 1;

    f->stack[0] = y * f->width + x;
    f->dark[f->stack[0]] = 0;
    while (n > 0) {
        uint32_t at = f->stack[--n], px = at % f->width, py = at / f->width;
        const struct {
            bool is;
            uint32_t at;
        } next[4] = {{px > 0, at - 1},
                     {px + 1 < f->width, at + 1},
                     {py > 0, at - f->width},
                     {py + 1 < f->height, at + f->width}};

        box.area++;
        box.x0 = px < box.x0 ? px : box.x0;
        box.x1 = px > box.x1 ? px : box.x1;
        box.y0 = py < box.y0 ? py : box.y0;
        box.y1 = py > box.y1 ? py : box.y1;
        for (int i = 0; i < 4; i++) {
            if (next[i].is && f->dark[next[i].at]) {
                f->dark[next[i].at] =
                    0; /* once on the stack: it never holds more than all pixels */
                f->stack[n++] = next[i].at;
            }
        }
    }
    return box;
}

static bool is_round(const struct finder *f, const struct box *box)
{
    double wide = box->x1 - box->x0 + 1.0, high = box->y1 - box->y0 + 1.0;

    return box->area >= AREA_LEAST && box->x0 > 0 && box->y0 > 0 && box->x1 + 1 < f->width &&
           box->y1 + 1 < f->height && wide < STRETCH * high && high < STRETCH * wide &&
           box->area >= FILLED * wide * high;
}

/* The middle of what is darker than the mean around, one pixel beyond the box: the rim counts by its share. */
static struct dot dot_of(const struct finder *f, const struct box *box)
{
    double mean = mean_around(f, (box->x0 + box->x1) / 2, (box->y0 + box->y1) / 2);
    double sum = 0, sum_x = 0, sum_y = 0;

    for (uint32_t y = box->y0 - 1; y <= box->y1 + 1; y++) {
        for (uint32_t x = box->x0 - 1; x <= box->x1 + 1; x++) {
            double weight = fmax(0.0, mean - (double)f->light[(size_t)y * f->width + x]);

            sum += weight;
            sum_x += weight * (x + 0.5);
            sum_y += weight * (y + 0.5);
        }
    }
    return (struct dot){.x = sum_x / sum, .y = sum_y / sum, .area_px = box->area};
}

static int take_dots(struct finder *f)
{
    for (uint32_t y = 0; y < f->height; y++) {
        for (uint32_t x = 0; x < f->width; x++) {
            struct box box;

            if (!f->dark[(size_t)y * f->width + x])
                continue;
            box = take_blob(f, x, y);
            if (!is_round(f, &box))
                continue;
            if (f->n == DOTS_MAX)
                return -E2BIG;
            f->dots[f->n++] = dot_of(f, &box);
        }
    }
    return 0;
}

static int by_area(const void *a, const void *b)
{
    uint32_t own = *(const uint32_t *)a, other = *(const uint32_t *)b;

    return own < other ? -1 : own > other;
}

/* Of another size than most: dirt, letters beside the grid. */
static int drop_odd_sizes(struct finder *f)
{
    uint32_t *areas = malloc((f->n + 1) * sizeof(*areas));
    size_t kept = 0;
    double middle;

    if (!areas)
        return -ENOMEM;
    for (size_t i = 0; i < f->n; i++)
        areas[i] = f->dots[i].area_px;
    qsort(areas, f->n, sizeof(*areas), by_area);
    middle = f->n ? areas[f->n / 2] : 0;
    free(areas);
    for (size_t i = 0; i < f->n; i++) {
        if (f->dots[i].area_px < SIZES * middle && middle < SIZES * f->dots[i].area_px)
            f->dots[kept++] = f->dots[i];
    }
    f->n = kept;
    return 0;
}

int dots_find(const float *light, uint32_t width, uint32_t height, struct dot **ret, size_t *ret_n)
{
    struct finder f = {.light = light, .width = width, .height = height};
    size_t pixels = (size_t)width * height;
    int r = -ENOMEM;

    f.sums = calloc(((size_t)width + 1) * ((size_t)height + 1), sizeof(*f.sums));
    f.dark = malloc(pixels);
    f.stack = malloc(pixels * sizeof(*f.stack));
    f.dots = malloc(DOTS_MAX * sizeof(*f.dots));
    if (f.sums && f.dark && f.stack && f.dots) {
        mark_dark(&f);
        r = take_dots(&f);
    }
    if (r == 0)
        r = drop_odd_sizes(&f);
    free(f.sums);
    free(f.dark);
    free(f.stack);
    if (r < 0) {
        free(f.dots);
        return r;
    }
    *ret = f.dots;
    *ret_n = f.n;
    return 0;
}

/* ---- the grid ---- */

struct vector {
    double x, y;
};

/* The steps to the next column and to the next row, as they are around a dot. */
struct steps {
    struct vector column, row;
};

struct walk {
    struct dot *dots;
    struct steps *steps; /* of each dot on the grid */
    size_t *queue, n, taken;
};

static struct vector between(const struct dot *from, const struct dot *to)
{
    return (struct vector){to->x - from->x, to->y - from->y};
}

static double length(struct vector v)
{
    return hypot(v.x, v.y);
}

/* The dot nearest to a point that is not on the grid yet; n where there is none. */
static size_t nearest(const struct walk *w, double x, double y, size_t but)
{
    size_t found = w->n;
    double least = INFINITY;

    for (size_t i = 0; i < w->n; i++) {
        double dx = w->dots[i].x - x, dy = w->dots[i].y - y, off = dx * dx + dy * dy;

        if (off < least && i != but && !w->dots[i].on_grid) {
            least = off;
            found = i;
        }
    }
    return found;
}

/* Rows go as nearly as can be to the right, columns down. */
static struct steps in_order(struct vector a, struct vector b)
{
    struct steps steps = fabs(a.x) >= fabs(b.x) ? (struct steps){a, b} : (struct steps){b, a};

    if (steps.column.x < 0)
        steps.column = (struct vector){-steps.column.x, -steps.column.y};
    if (steps.row.y < 0)
        steps.row = (struct vector){-steps.row.x, -steps.row.y};
    return steps;
}

/* The first dot's steps: to its nearest neighbour, and to the nearest one across that way. */
static bool first_steps(const struct walk *w, size_t first, struct steps *ret)
{
    const struct dot *own = &w->dots[first];
    size_t next = nearest(w, own->x, own->y, first), across = w->n;
    struct vector a;

    if (next == w->n)
        return false;
    a = between(own, &w->dots[next]);
    for (size_t i = 0; i < w->n; i++) {
        struct vector b = between(own, &w->dots[i]);

        if (i == first || fabs(a.x * b.x + a.y * b.y) > ACROSS * length(a) * length(b))
            continue;
        if (across == w->n || length(b) < length(between(own, &w->dots[across])))
            across = i;
    }
    if (across == w->n || length(between(own, &w->dots[across])) > 2 * length(a))
        return false;
    *ret = in_order(a, between(own, &w->dots[across]));
    return true;
}

static bool is_taken(const struct walk *w, int32_t column, int32_t row)
{
    for (size_t i = 0; i < w->taken; i++) {
        const struct dot *dot = &w->dots[w->queue[i]];

        if (dot->column == column && dot->row == row)
            return true;
    }
    return false;
}

static void take(struct walk *w, size_t i, int32_t column, int32_t row, struct steps steps)
{
    w->dots[i].on_grid = true;
    w->dots[i].column = column;
    w->dots[i].row = row;
    w->steps[i] = steps;
    w->queue[w->taken++] = i;
}

/* From a dot of the grid to one beside it: where its own step says that it is, give or take. */
static void step_from(struct walk *w, size_t from, int columns, int rows)
{
    const struct dot *own = &w->dots[from];
    struct steps steps = w->steps[from];
    struct vector *step = columns ? &steps.column : &steps.row;
    int sign = columns + rows;
    size_t next = nearest(w, own->x + sign * step->x, own->y + sign * step->y, from);
    struct vector found;

    if (next == w->n || is_taken(w, own->column + columns, own->row + rows))
        return;
    found = between(own, &w->dots[next]);
    found = (struct vector){sign * found.x, sign * found.y};
    if (hypot(found.x - step->x, found.y - step->y) > ASTRAY * length(*step))
        return;
    /* half of what is new: a lens bends steps slowly, and one dot may be a little off */
    *step = (struct vector){(step->x + found.x) / 2, (step->y + found.y) / 2};
    take(w, next, own->column + columns, own->row + rows, steps);
}

int dots_number(struct dot *dots, size_t n, uint32_t width, uint32_t height, size_t *ret)
{
    struct walk w = {.dots = dots, .n = n};
    struct steps steps;
    size_t first;
    bool has_room;

    for (size_t i = 0; i < n; i++)
        dots[i].on_grid = false;
    w.steps = malloc((n + 1) * sizeof(*w.steps));
    w.queue = malloc((n + 1) * sizeof(*w.queue));
    has_room = w.steps && w.queue;
    first = nearest(&w, width / 2.0, height / 2.0, n);
    if (has_room && first < n && first_steps(&w, first, &steps)) {
        take(&w, first, 0, 0, steps);
        for (size_t i = 0; i < w.taken; i++) {
            step_from(&w, w.queue[i], 1, 0);
            step_from(&w, w.queue[i], -1, 0);
            step_from(&w, w.queue[i], 0, 1);
            step_from(&w, w.queue[i], 0, -1);
        }
    }
    free(w.steps);
    free(w.queue);
    *ret = w.taken;
    return has_room ? 0 : -ENOMEM;
}
