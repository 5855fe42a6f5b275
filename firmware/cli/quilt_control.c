/* SPDX-License-Identifier: Apache-2.0 */
/* quilt_control.c: see quilt_control.h. */
#include "quilt_control.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ttf/config/units.h"
#include "ttf/dataset/image_file.h"

#define CURVE_FILE_MAX ((size_t)16 << 20)
#define SMOOTH_PX      2.0 /* heights of 8 bits are terraces (rate_map.h) */

static int read_picture(struct cli *cli, const char *option, const char *path,
                        struct ttf_pixbuf *ret)
{
    return cli_by_option(cli, ttf_image_read(cli->io, path, 0, ret, NULL, &cli->err), option, path);
}

static int of_picture(struct cli *cli, uint32_t width, uint32_t height, struct ttf_rate_map *ret)
{
    const struct cli_options *o = &cli->opt;
    struct ttf_pixbuf picture = {0};
    int r = read_picture(cli, "--rate-map", o->rate_map, &picture);

    if (r == 0)
        r = cli_by_option(cli,
                          ttf_rate_map_of_picture(&picture, width, height, o->rate_offset,
                                                  o->rate_gain, ret, &cli->err),
                          "--rate-map", NULL);
    ttf_pixbuf_free(&picture);
    return r;
}

static int of_light(struct cli *cli, uint32_t width, uint32_t height, struct ttf_rate_map *ret)
{
    const struct cli_options *o = &cli->opt;
    struct ttf_pixbuf surface = {0};
    struct ttf_light light = {.x = o->light[0],
                              .y = o->light[1],
                              .z = o->light[2],
                              .offset = o->rate_offset,
                              .gain = o->rate_gain,
                              .height_scale = o->height_scale};
    int r = 0;

    if (o->normals)
        r = read_picture(cli, "--normals", o->normals, &surface);
    else if (o->heights)
        r = read_picture(cli, "--heights", o->heights, &surface);
    light.normals = o->normals ? &surface : NULL;
    light.heights = o->heights ? &surface : NULL;
    if (r == 0)
        r = cli_by_option(cli, ttf_rate_map_of_light(&light, width, height, ret, &cli->err),
                          "--light", NULL);
    ttf_pixbuf_free(&surface);
    return r;
}

/* ---- curves ---- */

struct points {
    double *xs, *ys;
    unsigned n, room;
};

static int add_point(struct points *p, double x, double y)
{
    if (p->n == p->room) {
        unsigned room = p->room ? 2 * p->room : 64;
        double *xs = realloc(p->xs, room * sizeof *xs);
        double *ys;

        if (!xs)
            return -ENOMEM;
        p->xs = xs;
        ys = realloc(p->ys, room * sizeof *ys);
        if (!ys)
            return -ENOMEM;
        p->ys = ys;
        p->room = room;
    }
    p->xs[p->n] = x;
    p->ys[p->n++] = y;
    return 0;
}

static char *trimmed(char *text)
{
    size_t n;

    text += strspn(text, " \t\r");
    for (n = strlen(text); n > 0 && strchr(" \t\r", text[n - 1]); n--)
        text[n - 1] = '\0';
    return text;
}

/* "x,y"; empty lines and those that begin with # say nothing. */
static int take_line(struct cli *cli, const char *path, unsigned number, char *line,
                     struct points *points)
{
    char where[300];
    char *text = trimmed(line), *comma = strchr(text, ',');
    double x = 0, y = 0;
    int r;

    if (!*text || *text == '#')
        return 0;
    (void)snprintf(where, sizeof where, "%s:%u", path, number);
    if (!comma)
        return ttf_err_set(&cli->err, -EINVAL, where, "'%.40s' is no point: write x,y", text);
    *comma = '\0';
    r = ttf_number_parse(trimmed(text), &x, &cli->err);
    if (r == 0)
        r = ttf_number_parse(trimmed(comma + 1), &y, &cli->err);
    if (r < 0) {
        (void)snprintf(cli->err.where, sizeof cli->err.where, "%.255s", where);
        return -EINVAL;
    }
    if (points->n && !(x > points->xs[points->n - 1]))
        return ttf_err_set(&cli->err, -EINVAL, where, "%g does not follow %g: x must ascend", x,
                           points->xs[points->n - 1]);
    r = add_point(points, x, y);
    return r < 0 ? ttf_err_set(&cli->err, r, NULL, "no memory") : 0;
}

int quilt_curve_read(struct cli *cli, const char *path, struct ttf_spline **ret, double *ret_from,
                     double *ret_to)
{
    struct points points = {0};
    char *text = NULL, *next;
    size_t bytes = 0;
    unsigned number = 1;
    int r = ttf_io_slurp(cli->io, path, CURVE_FILE_MAX, &text, &bytes, &cli->err);

    for (char *line = text; line && r == 0; line = next, number++) {
        next = strchr(line, '\n');
        if (next)
            *next++ = '\0';
        r = take_line(cli, path, number, line, &points);
    }
    if (r == 0 && (points.n < 3 || !points.xs)) {
        r = -EINVAL;
        ttf_err_set(&cli->err, r, path, "a curve needs 3 points or more, here are %u", points.n);
    }
    if (r == 0)
        r = ttf_spline_create(points.xs, points.ys, points.n, ret, &cli->err);
    if (r == 0) {
        *ret_from = points.xs[0];
        *ret_to = points.xs[points.n - 1];
    }
    free(points.xs);
    free(points.ys);
    free(text);
    return r;
}

static bool ends_in(const char *text, const char *end)
{
    size_t n = strlen(text), m = strlen(end);

    return n >= m && strcmp(text + n - m, end) == 0;
}

static int of_heights(struct cli *cli, uint32_t width, uint32_t height, struct ttf_rate_map *ret)
{
    const struct cli_options *o = &cli->opt;
    struct ttf_pixbuf heights = {0};
    int r = read_picture(cli, "--curvature", o->curvature, &heights);

    if (r == 0)
        r = cli_by_option(cli,
                          ttf_rate_map_of_heights(&heights, o->height_scale, SMOOTH_PX, width,
                                                  height, o->rate_offset, o->rate_gain, ret,
                                                  &cli->err),
                          "--curvature", NULL);
    ttf_pixbuf_free(&heights);
    return r;
}

static int of_curvature(struct cli *cli, uint32_t width, uint32_t height, struct ttf_rate_map *ret)
{
    const struct cli_options *o = &cli->opt;
    struct ttf_curve curve = {.from = -8, .to = 8}; /* the paper's sigmoid */
    struct ttf_spline *spline = NULL;
    int r = 0;

    if (strcmp(o->curvature, "sigmoid") != 0 && !ends_in(o->curvature, ".csv"))
        return of_heights(cli, width, height, ret);
    if (strcmp(o->curvature, "sigmoid") != 0) {
        r = quilt_curve_read(cli, o->curvature, &spline, &curve.from, &curve.to);
        curve.y = ttf_spline_at;
        curve.ctx = spline;
    }
    if (r == 0)
        r = ttf_rate_map_of_curve(&curve, width, height, o->rate_offset, o->rate_gain, ret,
                                  &cli->err);
    ttf_spline_destroy(spline);
    return cli_by_option(cli, r, "--curvature", o->curvature);
}

int quilt_control_make(struct cli *cli, uint32_t width, uint32_t height, struct ttf_rate_map *ret)
{
    const struct cli_options *o = &cli->opt;

    if (o->rate_map)
        return of_picture(cli, width, height, ret);
    if (cli_given(o, OPT_LIGHT))
        return of_light(cli, width, height, ret);
    return o->curvature ? of_curvature(cli, width, height, ret) : 0;
}
