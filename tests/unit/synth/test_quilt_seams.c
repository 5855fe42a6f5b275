/* SPDX-License-Identifier: Apache-2.0 */
/* Every seam of a map is the cheapest there was, also of blocks that meet others on all four sides. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <stdlib.h>
#include <string.h>

#include "quilts.h"
#include "search/matching.h"
#include "search/sources.h"

#define BLOCK_MAX 32u

/* A map put together anew from its blocks' places and cuts alone. */
struct again {
    const struct ttf_quilt_map *map;
    const struct ttf_matching *matching;
    uint32_t *source;
};

static size_t place_of(const struct ttf_quilt_map *map, const struct ttf_quilt_block *b, uint32_t x,
                       uint32_t y)
{
    return (size_t)((b->out_y + y) % map->height) * map->width + (b->out_x + x) % map->width;
}

static uint64_t error_of(const struct again *a, const struct ttf_quilt_block *b, uint32_t x,
                         uint32_t y)
{
    const struct ttf_matching *m = a->matching;
    uint32_t known = a->source[place_of(a->map, b, x, y)];
    uint32_t own = quilt_block_shows(a->map, b, x, y);
    uint64_t sum = 0;

    for (unsigned k = 0; k < m->k; k++) {
        int64_t d = m->coefs[(size_t)known * m->stride + k] - m->coefs[(size_t)own * m->stride + k];

        sum += (uint64_t)(d * d);
    }
    return sum;
}

/* The cost of the cheapest path through an arm, and of the one that was taken. */
static void costs_of(const struct again *a, const struct ttf_quilt_block *b, const uint16_t *cut,
                     uint32_t x0, uint32_t y0, uint32_t steps, uint32_t width, bool down)
{
    uint64_t before[BLOCK_MAX] = {0}, cost[BLOCK_MAX], taken = 0, least = UINT64_MAX;

    for (uint32_t s = 0; s < steps; s++) {
        assert_true(cut[s] < width);
        assert_true(s == 0 || abs(cut[s] - cut[s - 1]) <= 1);
        for (uint32_t w = 0; w < width; w++) {
            uint64_t own = error_of(a, b, x0 + (down ? w : s), y0 + (down ? s : w));

            cost[w] = before[w];
            if (s > 0 && w > 0 && before[w - 1] < cost[w])
                cost[w] = before[w - 1];
            if (s > 0 && w + 1 < width && before[w + 1] < cost[w])
                cost[w] = before[w + 1];
            cost[w] += own;
            taken += w == cut[s] ? own : 0;
        }
        memcpy(before, cost, sizeof(before));
    }
    for (uint32_t w = 0; w < width; w++)
        least = before[w] < least ? before[w] : least;
    assert_int_equal(taken, least);
}

struct cuts {
    const uint16_t *left, *right, *top, *bottom;
};

static struct cuts cuts_of(const struct ttf_quilt_map *map, const struct ttf_quilt_block *b)
{
    const uint16_t *at = map->cuts + b->cuts;
    struct cuts cuts;

    cuts.left = at;
    cuts.right = cuts.left + (b->left ? b->height : 0);
    cuts.top = cuts.right + (b->right ? b->height : 0);
    cuts.bottom = cuts.top + (b->top ? b->width : 0);
    return cuts;
}

static void lay(const struct again *a, const struct ttf_quilt_block *b)
{
    struct cuts cuts = cuts_of(a->map, b);
    uint32_t x1 = b->width - b->right, y1 = b->height - b->bottom;

    if (b->left)
        costs_of(a, b, cuts.left, 0, 0, b->height, b->left, true);
    if (b->right)
        costs_of(a, b, cuts.right, x1, 0, b->height, b->right, true);
    if (b->top)
        costs_of(a, b, cuts.top, 0, 0, b->width, b->top, false);
    if (b->bottom)
        costs_of(a, b, cuts.bottom, 0, y1, b->width, b->bottom, false);
    for (uint32_t y = 0; y < b->height; y++) {
        for (uint32_t x = 0; x < b->width; x++) {
            bool old = (x < b->left && x < cuts.left[y]) || (y < b->top && y < cuts.top[x]) ||
                       (x >= x1 && x - x1 > cuts.right[y]) || (y >= y1 && y - y1 > cuts.bottom[x]);

            if (!old)
                a->source[place_of(a->map, b, x, y)] = quilt_block_shows(a->map, b, x, y);
        }
    }
}

static void is_made_of_cheapest_seams(const struct ttf_quilt_config *config,
                                      struct ttf_sequence *input)
{
    size_t pixels = (size_t)config->width * config->height;
    struct ttf_sources sources;
    struct ttf_matching matching;
    struct ttf_quilt_map map;
    struct again again = {&map, &matching, calloc(pixels, sizeof(*again.source))};

    assert_non_null(again.source);
    quilt_plan_ok(config, input, NULL, &map);
    assert_int_equal(ttf_sources_of(config, input, &sources, NULL), 0);
    assert_int_equal(ttf_matching_build(config, &sources, 0, input->n, NULL, NULL, &matching, NULL),
                     0);
    for (unsigned i = 0; i < map.n_blocks; i++)
        lay(&again, &map.blocks[i]);
    assert_memory_equal(again.source, map.source, pixels * sizeof(*map.source));
    free(again.source);
    ttf_matching_free(&matching);
    ttf_quilt_map_free(&map);
}

static void every_seam_is_the_cheapest_there_was(void **state)
{
    static const uint32_t sizes[][4] = {{83, 67, 0, 0}, {95, 40, 9, 9}, {18, 18, 3, 5}};
    struct texture_sequence input = texture_make(TEXTURE_SPOTS, 44, 40, 6);
    struct texture_sequence noise = texture_make(TEXTURE_NOISE, 30, 26, 6);
    struct ttf_quilt_config config;

    (void)state;
    ttf_quilt_defaults(&config);
    config.block_width = config.block_height = 18;
    for (int tileable = 0; tileable < 2; tileable++) {
        config.tileable = tileable;
        for (int i = 0; i < 3; i++) {
            config.width = sizes[i][0];
            config.height = sizes[i][1];
            config.overlap_x = sizes[i][2];
            config.overlap_y = sizes[i][3];
            config.more = &noise.sequence;
            config.n_more = (unsigned)i % 2;
            config.flips = config.rotations = i > 0;
            is_made_of_cheapest_seams(&config, input.sequence);
            is_made_of_cheapest_seams(&config, noise.sequence);
        }
    }
    texture_free(&input);
    texture_free(&noise);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_seam_is_the_cheapest_there_was),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
