/* SPDX-License-Identifier: Apache-2.0 */
#include <stdlib.h>
#include <string.h>

#include "metrics/colour_distance.h"
#include "metrics/samples.h"
#include "metrics/sliced.h"
#include "ttf/synth/likeness.h"

#define SAMPLES_MAX 65536u /* pixels of one picture */
#define GATHER_TILE 4096u
#define CHUNK       256u
/* |x| + |y| + |z| <= sqrt(3) of a unit vector, by 255 codes of four bins; and the rounding */
#define BINS        1792u

struct samples {
    const uint16_t *frame; /* of the running add */
    uint64_t pixels;
    uint32_t n;
    uint8_t codes[3][SAMPLES_MAX]; /* display codes, a plane for each channel */
};

struct ttf_colour_distance {
    int16_t directions[TTF_COLOUR_DIRECTIONS][3];
    double distances[TTF_COLOUR_DIRECTIONS]; /* of the running add */
    uint32_t frames;
    double sum, largest;
    uint32_t largest_at;
    uint8_t table[65536];
    struct samples pictures[2]; /* input, output */
};

void ttf_colour_direction(unsigned which, int16_t ret[3])
{
    ttf_sliced_direction(TTF_PURPOSE_COLOUR_DIRECTION, which, 3, ret);
}

struct ttf_colour_distance *ttf_colour_distance_create(const struct ttf_encoding *encoding)
{
    struct ttf_colour_distance *distance = calloc(1, sizeof(*distance));

    if (!distance)
        return NULL;
    for (unsigned i = 0; i < TTF_COLOUR_DIRECTIONS; i++)
        ttf_colour_direction(i, distance->directions[i]);
    ttf_display8_table(encoding, distance->table);
    return distance;
}

void ttf_colour_distance_destroy(struct ttf_colour_distance *distance)
{
    free(distance);
}

static void gather(struct samples *picture, const uint8_t *table, uint32_t from)
{
    uint32_t to = from + GATHER_TILE < picture->n ? from + GATHER_TILE : picture->n;

    for (uint32_t i = from; i < to; i++) {
        /* n is SAMPLES_MAX wherever not all pixels are taken: written out, it divides by shifting */
        uint64_t pixel = picture->n == picture->pixels ? i
                                                       : ttf_stratum(0, TTF_PURPOSE_COLOUR_PIXEL, i,
                                                                     picture->pixels, SAMPLES_MAX);
        const uint16_t *rgb = picture->frame + pixel * 3;

        for (unsigned c = 0; c < 3; c++)
            picture->codes[c][i] = table[rgb[c]];
    }
}

static void gather_tile(void *ctx, unsigned tile, unsigned worker)
{
    struct ttf_colour_distance *distance = ctx;

    gather(&distance->pictures[tile & 1], distance->table, (tile >> 1) * GATHER_TILE);
}

static void project(const struct samples *picture, const int16_t direction[3], int32_t offset,
                    uint32_t *histogram)
{
    const int32_t r = direction[0], g = direction[1], b = direction[2];
    uint16_t bins[CHUNK];

    for (uint32_t from = 0; from < picture->n; from += CHUNK) {
        uint32_t n = picture->n - from < CHUNK ? picture->n - from : CHUNK;
        const uint8_t *red = picture->codes[0] + from, *green = picture->codes[1] + from,
                      *blue = picture->codes[2] + from;

        /* always a whole chunk, what is behind the last pixel too: the compiler makes vectors of it */
        for (uint32_t i = 0; i < CHUNK; i++)
            bins[i] =
                (uint16_t)((r * red[i] + g * green[i] + b * blue[i] + offset) >> TTF_SLICED_SHIFT);
        for (uint32_t i = 0; i < n; i++)
            histogram[bins[i]]++;
    }
}

/* One direction: its histograms fit the nearest cache, and nothing is left to add up over tiles. */
static void direction_tile(void *ctx, unsigned which, unsigned worker)
{
    struct ttf_colour_distance *distance = ctx;
    const int16_t *direction = distance->directions[which];
    const int32_t offset = ttf_sliced_offset(direction, 3);
    uint32_t histograms[2][BINS];

    memset(histograms, 0, sizeof(histograms));
    for (unsigned p = 0; p < 2; p++)
        project(&distance->pictures[p], direction, offset, histograms[p]);
    distance->distances[which] =
        ttf_sliced_distance(histograms[0], distance->pictures[0].n, histograms[1],
                            distance->pictures[1].n, ttf_sliced_bins(direction, 3));
}

static void take(struct samples *picture, const uint16_t *frame, size_t pixels)
{
    picture->frame = frame;
    picture->pixels = pixels;
    picture->n = pixels < SAMPLES_MAX ? (uint32_t)pixels : SAMPLES_MAX;
}

double ttf_colour_distance_add(struct ttf_colour_distance *distance, struct ttf_pool *pool,
                               const uint16_t *input, size_t input_pixels, const uint16_t *output,
                               size_t output_pixels)
{
    double mean = 0.0;

    take(&distance->pictures[0], input, input_pixels);
    take(&distance->pictures[1], output, output_pixels);
    ttf_pool_run(pool, 2 * (SAMPLES_MAX / GATHER_TILE), gather_tile, distance);
    ttf_pool_run(pool, TTF_COLOUR_DIRECTIONS, direction_tile, distance);
    for (unsigned i = 0; i < TTF_COLOUR_DIRECTIONS; i++)
        mean += distance->distances[i];
    mean /= TTF_COLOUR_DIRECTIONS;
    if (distance->frames == 0 || mean > distance->largest) {
        distance->largest = mean;
        distance->largest_at = distance->frames;
    }
    distance->sum += mean;
    distance->frames++;
    return mean;
}

void ttf_colour_distance_figures(const struct ttf_colour_distance *distance,
                                 struct ttf_colour_figures *ret)
{
    *ret = (struct ttf_colour_figures){
        .frames = distance->frames,
        .mean = distance->frames ? distance->sum / distance->frames : 0.0,
        .largest = distance->largest,
        .largest_at = distance->largest_at,
    };
}
