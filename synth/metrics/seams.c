/* SPDX-License-Identifier: Apache-2.0 */
#include <stdbool.h>
#include <stdlib.h>

#include "ttf/synth/metrics.h"

struct ttf_seams {
    const struct ttf_quilt_map *map;
    uint8_t table[65536];
    uint64_t pairs;
    uint64_t seam, source, input; /* sums of absolute steps over three channels */
    uint64_t n_seam, n_source, n_input;
    uint32_t frames;
};

/* Are two output pixels, `step` apart in the source if they belong together, on different sides of a seam? */
static bool is_seam(const struct ttf_quilt_map *map, size_t at, size_t other, uint32_t step)
{
    return map->source[other] != map->source[at] + step;
}

struct ttf_seams *ttf_seams_create(const struct ttf_quilt_map *map,
                                   const struct ttf_encoding *encoding)
{
    struct ttf_seams *seams = calloc(1, sizeof(*seams));

    if (!seams)
        return NULL;
    seams->map = map;
    ttf_display8_table(encoding, seams->table);
    for (size_t y = 0; y < map->height; y++) {
        for (size_t x = 0; x < map->width; x++) {
            size_t at = y * map->width + x;

            if (x + 1 < map->width)
                seams->pairs += is_seam(map, at, at + 1, 1);
            if (y + 1 < map->height)
                seams->pairs += is_seam(map, at, at + map->width, map->source_width);
        }
    }
    return seams;
}

void ttf_seams_destroy(struct ttf_seams *seams)
{
    free(seams);
}

static unsigned step_between(const struct ttf_seams *seams, const uint16_t *a, const uint16_t *b)
{
    unsigned sum = 0;

    for (int c = 0; c < 3; c++) {
        int d = seams->table[a[c]] - seams->table[b[c]];

        sum += (unsigned)(d < 0 ? -d : d);
    }
    return sum;
}

/* The step across one seam, and those that its two pixels made in the source to the neighbours they lost. */
static void add_pair(struct ttf_seams *seams, const uint16_t *source, const uint16_t *output,
                     size_t at, bool down)
{
    const struct ttf_quilt_map *map = seams->map;
    size_t other = at + (down ? map->width : 1);
    uint32_t step = down ? map->source_width : 1;
    uint32_t p = map->source[at], q = map->source[other];
    bool p_has = down ? p / map->source_width + 1 < map->source_height
                      : p % map->source_width + 1 < map->source_width;
    bool q_has = down ? q >= map->source_width : q % map->source_width > 0;

    if (!is_seam(map, at, other, step))
        return;
    seams->seam += step_between(seams, output + 3 * at, output + 3 * other);
    seams->n_seam++;
    if (p_has) {
        seams->source +=
            step_between(seams, source + 3 * (size_t)p, source + 3 * (size_t)(p + step));
        seams->n_source++;
    }
    if (q_has) {
        seams->source +=
            step_between(seams, source + 3 * (size_t)q, source + 3 * (size_t)(q - step));
        seams->n_source++;
    }
}

static void add_input(struct ttf_seams *seams, const uint16_t *source)
{
    size_t width = seams->map->source_width, height = seams->map->source_height;

    for (size_t y = 0; y < height; y++) {
        for (size_t x = 0; x < width; x++) {
            const uint16_t *at = source + 3 * (y * width + x);

            if (x + 1 < width) {
                seams->input += step_between(seams, at, at + 3);
                seams->n_input++;
            }
            if (y + 1 < height) {
                seams->input += step_between(seams, at, at + 3 * width);
                seams->n_input++;
            }
        }
    }
}

void ttf_seams_add(struct ttf_seams *seams, const uint16_t *source, const uint16_t *output)
{
    const struct ttf_quilt_map *map = seams->map;

    for (size_t y = 0; y < map->height; y++) {
        for (size_t x = 0; x < map->width; x++) {
            size_t at = y * map->width + x;

            if (x + 1 < map->width)
                add_pair(seams, source, output, at, false);
            if (y + 1 < map->height)
                add_pair(seams, source, output, at, true);
        }
    }
    add_input(seams, source);
    seams->frames++;
}

static double ratio(double a, double b)
{
    return b > 0.0 ? a / b : 0.0;
}

void ttf_seams_figures(const struct ttf_seams *seams, struct ttf_seams_figures *ret)
{
    const struct ttf_quilt_map *map = seams->map;
    double all = 2.0 * map->width * map->height - map->width - map->height;

    *ret = (struct ttf_seams_figures){
        .pairs = seams->pairs,
        .frames = seams->frames,
        .pair_share = ratio((double)seams->pairs, all),
        .seam_gradient = ratio((double)seams->seam, 3.0 * (double)seams->n_seam),
        .source_gradient = ratio((double)seams->source, 3.0 * (double)seams->n_source),
        .input_gradient = ratio((double)seams->input, 3.0 * (double)seams->n_input)};
    if (ret->source_gradient > 0.0 && seams->n_seam > 0)
        ret->excess = ret->seam_gradient / ret->source_gradient - 1.0;
    if (ret->input_gradient > 0.0 && seams->n_seam > 0)
        ret->input_excess = ret->seam_gradient / ret->input_gradient - 1.0;
}
