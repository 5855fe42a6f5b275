/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Rates from light (Enrique et al. 2005, eq. 9). A surface of one unit of width lies in
 * z = 0, x to the right and y down from its top left corner, z towards the viewer.
 */
#include <errno.h>
#include <math.h>

#include "control/picture.h"
#include "control/rates.h"
#include "ttf/synth/rate_map.h"

#define NORMAL_LENGTH_LEAST \
    0.05 /* of a stored normal: shorter ones (8-bit mid-grey) have no direction */
#define DISTANCE_LEAST 1e-6 /* of the light from the surface, in its width */

struct vec3 {
    double x, y, z;
};

/* Where the pixels lie and how they are turned. */
struct surface {
    uint32_t width, height;
    const struct ttf_light *light;
    struct ttf_pixbuf normals; /* F32 x 3, or no data */
    struct ttf_pixbuf heights; /* F32 x 1, or no data */
};

static double length(struct vec3 v)
{
    return sqrt(v.x * v.x + v.y * v.y + v.z * v.z);
}

static struct vec3 scaled(struct vec3 v, double by)
{
    return (struct vec3){v.x * by, v.y * by, v.z * by};
}

static double height_at(const struct surface *surface, uint32_t x, uint32_t y)
{
    const float *row;

    if (!surface->heights.data)
        return 0.0;
    row = ttf_pixbuf_row(&surface->heights, y);
    return (double)row[x] * surface->light->height_scale;
}

/* From the pixel's point to the light. */
static struct vec3 to_light(const struct surface *surface, uint32_t x, uint32_t y)
{
    double pixel = 1.0 / (double)surface->width;

    return (struct vec3){surface->light->x - ((double)x + 0.5) * pixel,
                         surface->light->y - ((double)y + 0.5) * pixel,
                         surface->light->z - height_at(surface, x, y)};
}

/* Central differences; one-sided at the border, 0 across a single pixel. */
static struct vec3 normal_of_heights(const struct surface *surface, uint32_t x, uint32_t y)
{
    uint32_t x0 = x > 0 ? x - 1 : x, x1 = x + 1 < surface->width ? x + 1 : x;
    uint32_t y0 = y > 0 ? y - 1 : y, y1 = y + 1 < surface->height ? y + 1 : y;
    double rise_x = height_at(surface, x1, y) - height_at(surface, x0, y);
    double rise_y = height_at(surface, x, y1) - height_at(surface, x, y0);
    double per_x = x1 > x0 ? (double)surface->width / (double)(x1 - x0) : 0.0;
    double per_y = y1 > y0 ? (double)surface->width / (double)(y1 - y0) : 0.0;
    struct vec3 up = {-rise_x * per_x, -rise_y * per_y, 1.0};

    return scaled(up, 1.0 / length(up));
}

/* Green points up the picture, our y down. */
static struct vec3 normal_of_picture(const struct surface *surface, uint32_t x, uint32_t y)
{
    const float *rgb = (const float *)ttf_pixbuf_row(&surface->normals, y) + 3 * (size_t)x;
    struct vec3 n = {2.0 * (double)rgb[0] - 1.0, 1.0 - 2.0 * (double)rgb[1],
                     2.0 * (double)rgb[2] - 1.0};
    double l = length(n);

    return l < NORMAL_LENGTH_LEAST ? (struct vec3){0.0, 0.0, 1.0} : scaled(n, 1.0 / l);
}

static struct vec3 normal_at(const struct surface *surface, uint32_t x, uint32_t y)
{
    if (surface->normals.data)
        return normal_of_picture(surface, x, y);
    if (surface->heights.data)
        return normal_of_heights(surface, x, y);
    return (struct vec3){0.0, 0.0, 1.0};
}

/* (cos q / r^2)^2, r in units of `nearest`. */
static double falloff(const struct surface *surface, uint32_t x, uint32_t y, double nearest)
{
    struct vec3 l = to_light(surface, x, y), n = normal_at(surface, x, y);
    double distance = length(l), r = distance / nearest;
    double cosine = (n.x * l.x + n.y * l.y + n.z * l.z) / distance;
    double intensity = cosine > 0.0 ? cosine / (r * r) : 0.0;

    return intensity * intensity;
}

static int nearest_distance(const struct surface *surface, double *ret, struct ttf_err *err)
{
    double nearest = (double)INFINITY;

    for (uint32_t y = 0; y < surface->height; y++) {
        for (uint32_t x = 0; x < surface->width; x++) {
            double d = length(to_light(surface, x, y));

            nearest = d < nearest ? d : nearest;
        }
    }
    if (nearest < DISTANCE_LEAST) {
        ttf_err_set(err, -EINVAL, "light", "it lies in the surface");
        ttf_err_hint(err, "raise the light's z above the heights");
        return -EINVAL;
    }
    *ret = nearest;
    return 0;
}

static int light_check(const struct ttf_light *light, struct ttf_err *err)
{
    if (!isfinite(light->x) || !isfinite(light->y) || !isfinite(light->z))
        return ttf_err_set(err, -EINVAL, "light", "its position is not of finite numbers");
    if (!(light->z > 0.0))
        return ttf_err_set(err, -EINVAL, "light", "z = %g is not above the plane", light->z);
    if (!isfinite(light->height_scale))
        return ttf_err_set(err, -EINVAL, "height_scale", "is not a finite number");
    if (light->normals && light->heights) {
        ttf_err_set(err, -EINVAL, "light", "both normals and heights are given");
        ttf_err_hint(err, "give one of them: normals are derived from heights");
        return -EINVAL;
    }
    return 0;
}

static int surface_load(const struct ttf_light *light, uint32_t width, uint32_t height,
                        struct surface *ret, struct ttf_err *err)
{
    *ret = (struct surface){.width = width, .height = height, .light = light};
    if (light->normals)
        return ttf_control_colour(light->normals, "normals", width, height, &ret->normals, err);
    if (light->heights)
        return ttf_control_grey(light->heights, "heights", width, height, &ret->heights, err);
    return 0;
}

int ttf_rate_map_of_light(const struct ttf_light *light, uint32_t width, uint32_t height,
                          struct ttf_rate_map *ret, struct ttf_err *err)
{
    struct ttf_rate_scale scale = {light->offset, light->gain};
    struct ttf_rate_map map = {0};
    struct surface surface = {0};
    double nearest = 0.0;
    int r = light_check(light, err);

    if (r == 0)
        r = ttf_rate_scale_check(&scale, err);
    if (r == 0)
        r = ttf_rates_alloc(width, height, &map, err);
    if (r == 0)
        r = surface_load(light, width, height, &surface, err);
    if (r == 0)
        r = nearest_distance(&surface, &nearest, err);
    for (size_t i = 0; r == 0 && i < (size_t)width * height; i++)
        r = ttf_rate_of_value(
            &scale, falloff(&surface, (uint32_t)(i % width), (uint32_t)(i / width), nearest),
            &map.m[i], err);
    ttf_pixbuf_free(&surface.normals);
    ttf_pixbuf_free(&surface.heights);
    if (r < 0) {
        ttf_rate_map_free(&map);
        return r;
    }
    *ret = map;
    return 0;
}
