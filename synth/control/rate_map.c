/* SPDX-License-Identifier: Apache-2.0 */
#include "ttf/synth/rate_map.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "control/picture.h"
#include "control/rates.h"

#define FRAMES_MAX (1u << 20)

/*
 * A rate is kept in 24 bits: 0.7f is a little less than 0.7, and 70 / 0.7f a little
 * more than 100. Quotients so near above an integer mean the integer.
 */
#define QUOTIENT_SLACK (1.0 / (1u << 22))

void ttf_rate_map_free(struct ttf_rate_map *map)
{
    if (!map)
        return;
    free(map->m);
    memset(map, 0, sizeof(*map));
}

void ttf_rate_map_range(const struct ttf_rate_map *map, float *ret_least, float *ret_most)
{
    size_t n = (size_t)map->width * map->height;
    float least = map->m[0], most = map->m[0];

    for (size_t i = 1; i < n; i++) {
        least = map->m[i] < least ? map->m[i] : least;
        most = map->m[i] > most ? map->m[i] : most;
    }
    *ret_least = least;
    *ret_most = most;
}

static int too_long(double frames, struct ttf_err *err)
{
    ttf_err_set(err, -ERANGE, "rate map", "%.4g output frames are more than %u", frames,
                FRAMES_MAX);
    ttf_err_hint(err, "the fastest pixel sets the length: raise the gain");
    return -ERANGE;
}

int ttf_rate_map_frames(const struct ttf_rate_map *map, uint32_t n, uint32_t *ret,
                        struct ttf_err *err)
{
    float least, most;
    double quotient, frames = n;

    if (n == 0)
        return ttf_err_set(err, -EINVAL, "input", "a sequence without frames has no length");
    ttf_rate_map_range(map, &least, &most);
    if (most > 0.0f) {
        quotient = (double)(n - 1) / (double)most;
        frames = ceil(quotient * (1.0 - QUOTIENT_SLACK)) + 1.0;
    }
    if (frames > FRAMES_MAX)
        return too_long(frames, err);
    *ret = (uint32_t)frames;
    return 0;
}

int ttf_rate_map_of_picture(const struct ttf_pixbuf *picture, uint32_t width, uint32_t height,
                            double offset, double gain, struct ttf_rate_map *ret,
                            struct ttf_err *err)
{
    struct ttf_rate_scale scale = {offset, gain};
    struct ttf_rate_map map = {0};
    struct ttf_pixbuf grey = {0};
    int r = ttf_rate_scale_check(&scale, err);

    width = width ? width : picture->width;
    height = height ? height : picture->height;
    if (r == 0)
        r = ttf_rates_alloc(width, height, &map, err);
    if (r == 0)
        r = ttf_control_grey(picture, "rate picture", width, height, &grey, err);
    for (uint32_t y = 0; y < height && r == 0; y++) {
        const float *row = ttf_pixbuf_row(&grey, y);

        for (uint32_t x = 0; x < width && r == 0; x++)
            r = ttf_rate_of_value(&scale, (double)row[x], &map.m[(size_t)y * width + x], err);
    }
    ttf_pixbuf_free(&grey);
    if (r < 0) {
        ttf_rate_map_free(&map);
        return r;
    }
    *ret = map;
    return 0;
}
