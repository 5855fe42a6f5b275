/* SPDX-License-Identifier: Apache-2.0 */
/* rank_plot.c: see rank_plot.h. */
#include "rank_plot.h"

#include <math.h>
#include <stdbool.h>

#define WIDTH  640.0
#define HEIGHT 400.0
#define LEFT   64.0
#define RIGHT  16.0
#define TOP    36.0
#define BOTTOM 48.0

void rank_table(FILE *out, const struct ttf_quilt_rank_curve *curve)
{
    (void)fputs("rank,error,rms_over_full_scale\n", out);
    for (unsigned k = 0; k < curve->n; k++)
        (void)fprintf(out, "%u,%.9g,%.9g\n", k, curve->errors[k], curve->rms[k]);
}

/* The ranks from 1 (rank 0 misses all) and the decades, or the percents, that their errors lie in. */
struct axes {
    unsigned last; /* rank */
    bool log;
    double lo, hi; /* percent, or its logarithm */
};

static struct axes axes_of(const struct ttf_quilt_rank_curve *curve)
{
    struct axes a = {.last = curve->n - 1, .log = true, .lo = 100, .hi = 0};

    for (unsigned k = 1; k < curve->n; k++) {
        double percent = 100 * curve->errors[k];

        a.lo = percent < a.lo ? percent : a.lo;
        a.hi = percent > a.hi ? percent : a.hi;
        a.log = a.log && percent > 1e-9;
    }
    if (a.log) {
        a.lo = floor(log10(a.lo));
        a.hi = ceil(log10(a.hi));
        a.hi = a.hi > a.lo ? a.hi : a.lo + 1;
    } else {
        a.lo = 0;
        a.hi = a.hi > 0 ? ceil(a.hi) : 1;
    }
    return a;
}

static double x_of(const struct axes *a, double rank)
{
    return LEFT + (WIDTH - LEFT - RIGHT) * (a->last > 1 ? (rank - 1) / (a->last - 1) : 0.5);
}

static double y_of(const struct axes *a, double percent)
{
    double value = a->log ? log10(percent) : percent;

    return HEIGHT - BOTTOM - (HEIGHT - TOP - BOTTOM) * (value - a->lo) / (a->hi - a->lo);
}

static void text(FILE *out, double x, double y, const char *anchor, const char *words)
{
    (void)fprintf(out, "<text x=\"%.1f\" y=\"%.1f\" text-anchor=\"%s\">", x, y, anchor);
    for (; *words; words++) {
        if (*words == '&' || *words == '<' || *words == '>')
            (void)fprintf(out, "&#%d;", *words);
        else
            (void)fputc(*words, out);
    }
    (void)fputs("</text>\n", out);
}

static void line(FILE *out, double x0, double y0, double x1, double y1, const char *colour)
{
    (void)fprintf(out, "<path d=\"M%.1f %.1fL%.1f %.1f\" stroke=\"%s\"/>\n", x0, y0, x1, y1,
                  colour);
}

static void y_tick(FILE *out, const struct axes *a, double percent)
{
    char words[32];
    double y = y_of(a, percent);

    (void)snprintf(words, sizeof words, "%g %%", percent);
    line(out, LEFT, y, WIDTH - RIGHT, y, "#ccc");
    text(out, LEFT - 6, y + 4, "end", words);
}

static void ticks(FILE *out, const struct axes *a)
{
    unsigned step = a->last <= 10 ? 1 : a->last <= 20 ? 2 : a->last <= 40 ? 5 : 8;
    char words[16];

    if (a->log) {
        for (int decade = (int)a->lo; decade <= (int)a->hi; decade++)
            y_tick(out, a, pow(10, decade));
    } else {
        for (int i = 0; i <= 5; i++)
            y_tick(out, a, a->hi * i / 5);
    }
    for (unsigned k = step; k <= a->last; k += step) {
        (void)snprintf(words, sizeof words, "%u", k);
        line(out, x_of(a, k), HEIGHT - BOTTOM, x_of(a, k), HEIGHT - BOTTOM + 5, "#000");
        text(out, x_of(a, k), HEIGHT - BOTTOM + 18, "middle", words);
    }
}

void rank_plot(FILE *out, const struct ttf_quilt_rank_curve *curve, const char *title)
{
    struct axes a = axes_of(curve);

    (void)fprintf(out,
                  "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"%.0f\" height=\"%.0f\" "
                  "viewBox=\"0 0 %.0f %.0f\" font-family=\"sans-serif\" font-size=\"12\">\n"
                  "<rect width=\"100%%\" height=\"100%%\" fill=\"#fff\"/>\n",
                  WIDTH, HEIGHT, WIDTH, HEIGHT);
    text(out, WIDTH / 2, 20, "middle", title);
    ticks(out, &a);
    line(out, LEFT, TOP, LEFT, HEIGHT - BOTTOM, "#000");
    line(out, LEFT, HEIGHT - BOTTOM, WIDTH - RIGHT, HEIGHT - BOTTOM, "#000");
    text(out, WIDTH / 2, HEIGHT - 10, "middle", "rank k");
    text(out, LEFT - 56, TOP - 10, "start", "error");
    (void)fputs("<polyline fill=\"none\" stroke=\"#06c\" stroke-width=\"2\" points=\"", out);
    for (unsigned k = 1; k < curve->n; k++)
        (void)fprintf(out, "%s%.2f,%.2f", k > 1 ? " " : "", x_of(&a, k),
                      y_of(&a, 100 * curve->errors[k]));
    (void)fputs("\"/>\n</svg>\n", out);
}
