/* SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
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

/* Is an output pixel's neighbour (right, or down) not what its own block has there? */
static bool is_seam(const struct ttf_quilt_map *map, size_t at, size_t other, bool down)
{
    unsigned turn = map->blocks[map->owner[at]].turn;
    uint32_t next;

    return !ttf_quilt_neighbour(map, map->source[at], turn, !down, down, &next) ||
           map->source[other] != next;
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
                seams->pairs += is_seam(map, at, at + 1, false);
            if (y + 1 < map->height)
                seams->pairs += is_seam(map, at, at + map->width, true);
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

/* The step that an output pixel made in the source to the neighbour it lost. */
static void add_lost(struct ttf_seams *seams, const uint16_t *source, size_t at, int dx, int dy)
{
    const struct ttf_quilt_map *map = seams->map;
    uint32_t id = map->source[at], lost;

    if (!ttf_quilt_neighbour(map, id, map->blocks[map->owner[at]].turn, dx, dy, &lost))
        return;
    seams->source += step_between(seams, source + 3 * (size_t)id, source + 3 * (size_t)lost);
    seams->n_source++;
}

/* The step across one seam, and those of its two pixels. */
static void add_pair(struct ttf_seams *seams, const uint16_t *source, const uint16_t *output,
                     size_t at, bool down)
{
    size_t other = at + (down ? seams->map->width : 1);

    if (!is_seam(seams->map, at, other, down))
        return;
    seams->seam += step_between(seams, output + 3 * at, output + 3 * other);
    seams->n_seam++;
    add_lost(seams, source, at, !down, down);
    add_lost(seams, source, other, -!down, -down);
}

static void add_input(struct ttf_seams *seams, const struct ttf_quilt_input *input,
                      const uint16_t *source)
{
    size_t width = input->width, height = input->height;

    source += (size_t)input->first * 3;
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
    for (unsigned i = 0; i < map->n_inputs; i++)
        add_input(seams, &map->inputs[i], source);
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
    /* a step in what is flat is no excess of anything, and surely not 0 */
    ret->excess = ret->input_excess = (double)NAN;
    if (ret->source_gradient > 0.0 && seams->n_seam > 0)
        ret->excess = ret->seam_gradient / ret->source_gradient - 1.0;
    if (ret->input_gradient > 0.0 && seams->n_seam > 0)
        ret->input_excess = ret->seam_gradient / ret->input_gradient - 1.0;
}
