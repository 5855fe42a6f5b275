/* SPDX-License-Identifier: Apache-2.0 */
/* Where blocks lie and where they are taken from: tileable outputs, avoided repetition. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "quilt/placement.h"
#include "quilts.h"
#include "ttf/synth/metrics.h"

static struct ttf_quilt_config small_config(void)
{
    struct ttf_quilt_config config;

    ttf_quilt_defaults(&config);
    config.width = 83;
    config.height = 67;
    config.block_width = config.block_height = 18;
    config.tileable = true;
    return config;
}

/* ---- places ---- */

static bool in_an_arm(const struct ttf_quilt_block *b, uint32_t x, uint32_t y)
{
    return x < b->left || y < b->top || x + b->right >= b->width || y + b->bottom >= b->height;
}

/* A block's arms are what lies there already, all of it and nothing else: so that every seam is cut. */
static void arms_are_what_is_known(const struct ttf_quilt_config *config)
{
    size_t pixels = (size_t)config->width * config->height, covered = 0;
    uint8_t *known = calloc(pixels, 1);
    struct ttf_placement placement;

    assert_non_null(known);
    ttf_placement_make(config, &placement);
    for (unsigned i = 0; i < placement.columns * placement.rows; i++) {
        struct ttf_quilt_block b = {0};

        ttf_placement_block(&placement, config, i, &b);
        assert_true(b.left <= b.width && b.right <= b.width);
        assert_true(b.top <= b.height && b.bottom <= b.height);
        for (uint32_t y = 0; y < b.height; y++) {
            for (uint32_t x = 0; x < b.width; x++) {
                size_t at = (size_t)((b.out_y + y) % config->height) * config->width +
                            (b.out_x + x) % config->width;

                if (in_an_arm(&b, x, y) != known[at])
                    fail_msg("output %u x %u, block %u x %u, overlap %u x %u: block %u at %u, %u",
                             config->width, config->height, config->block_width,
                             config->block_height, config->overlap_x, config->overlap_y, i, x, y);
            }
        }
        for (uint32_t y = 0; y < b.height; y++) {
            for (uint32_t x = 0; x < b.width; x++)
                known[(size_t)((b.out_y + y) % config->height) * config->width +
                      (b.out_x + x) % config->width] = 1;
        }
    }
    for (size_t i = 0; i < pixels; i++)
        covered += known[i];
    assert_int_equal(covered, pixels);
    free(known);
}

static void blocks_know_all_that_lies_there_at_any_size_and_overlap(void **state)
{
    struct ttf_quilt_config config = small_config();

    (void)state;
    for (int tileable = 0; tileable < 2; tileable++) {
        config.tileable = tileable;
        for (uint32_t block = 4; block <= 21; block += block < 8 ? 1 : 4) {
            for (uint32_t overlap = 1; overlap <= block / 2; overlap++) {
                config.block_width = config.block_height = block;
                config.overlap_x = overlap;
                config.overlap_y = overlap > 1 ? overlap - 1 : 1;
                for (uint32_t size = block; size < 4 * block; size++) {
                    config.width = size;
                    config.height = 5 * block - size;
                    arms_are_what_is_known(&config);
                }
            }
        }
    }
}

static void the_overlap_that_is_told_is_the_least_there_is(void **state)
{
    struct ttf_quilt_config config = small_config();

    (void)state;
    for (config.width = 18; config.width < 60; config.width++) {
        uint32_t least = UINT32_MAX;
        struct ttf_placement placement;

        ttf_placement_make(&config, &placement);
        for (unsigned i = 0; i < placement.columns; i++) {
            struct ttf_quilt_block b = {0};

            ttf_placement_block(&placement, &config, i, &b);
            least = i > 0 && b.left < least ? b.left : least;
            least = b.right > 0 && b.right < least ? b.right : least;
        }
        assert_int_equal(placement.overlap_x, least);
        assert_true(least >= 3); /* a sixth */
    }
}

/* ---- tileable outputs ---- */

/* Mean over time and channels of the absolute step from output pixel a to b, codes. */
static double step(const struct ttf_quilt_map *map, const struct ttf_sequence *input,
                   const uint16_t *codes, size_t a, size_t b)
{
    size_t frame = (size_t)input->width * input->height * 3;
    double sum = 0.0;

    for (uint32_t t = 0; t < input->n; t++) {
        const uint16_t *p = codes + t * frame + map->source[a] * 3ul;
        const uint16_t *q = codes + t * frame + map->source[b] * 3ul;

        for (int c = 0; c < 3; c++)
            sum += p[c] > q[c] ? p[c] - q[c] : q[c] - p[c];
    }
    return sum / (3.0 * input->n);
}

struct steps {
    double inner,
        border; /* means over pairs that are no neighbours in the source; border: over all */
    double inner_most, border_most;
};

static bool are_neighbours(const struct ttf_quilt_map *map, size_t a, size_t b, bool down)
{
    unsigned turn = map->blocks[map->owner[a]].turn;
    uint32_t next;

    return turn == map->blocks[map->owner[b]].turn &&
           ttf_quilt_neighbour(map, map->source[a], turn, !down, down, &next) &&
           next == map->source[b];
}

static struct steps steps_of(const struct ttf_quilt_map *map, const struct texture_sequence *input)
{
    struct steps sums = {0};
    size_t inner = 0, border = 0;

    for (uint32_t y = 0; y < map->height; y++) {
        for (uint32_t x = 0; x < map->width; x++) {
            size_t at = (size_t)y * map->width + x;

            for (int down = 0; down < 2; down++) {
                uint32_t nx = down ? x : (x + 1) % map->width;
                uint32_t ny = down ? (y + 1) % map->height : y;
                bool over = down ? ny == 0 : nx == 0;
                size_t next = (size_t)ny * map->width + nx;
                double own = step(map, input->sequence, input->codes, at, next);

                if (over) {
                    sums.border += own;
                    sums.border_most = own > sums.border_most ? own : sums.border_most;
                    border++;
                } else if (!are_neighbours(map, at, next, down)) {
                    sums.inner += own;
                    sums.inner_most = own > sums.inner_most ? own : sums.inner_most;
                    inner++;
                }
            }
        }
    }
    sums.inner /= (double)inner;
    sums.border /= (double)border;
    return sums;
}

static void a_tileable_output_goes_on_over_its_borders(void **state)
{
    struct texture_sequence input = texture_make(TEXTURE_SPOTS, 60, 56, 6);
    struct ttf_quilt_config config = small_config();

    (void)state;
    for (config.seed = 1; config.seed <= 4; config.seed++) {
        struct ttf_quilt_map tile, plain;
        struct steps closed, open;

        config.tileable = true;
        quilt_plan_ok(&config, input.sequence, NULL, &tile);
        assert_true(tile.tileable);
        quilt_blocks_are_what_is_shown(&tile);
        config.tileable = false;
        quilt_plan_ok(&config, input.sequence, NULL, &plain);
        closed = steps_of(&tile, &input);
        open = steps_of(&plain, &input);
        assert_true(closed.border <= closed.inner);
        assert_true(closed.border_most <= closed.inner_most);
        assert_true(open.border > 2.0 * closed.border);
        ttf_quilt_map_free(&tile);
        ttf_quilt_map_free(&plain);
    }
    texture_free(&input);
}

static void tileable_outputs_of_any_size_are_whole(void **state)
{
    static const uint32_t sizes[][4] = {{18, 18, 3, 3}, {19, 18, 9, 9}, {33, 47, 9, 2},
                                        {95, 40, 9, 9}, {36, 36, 1, 1}, {18, 100, 0, 0}};
    struct texture_sequence input = texture_make(TEXTURE_SPOTS, 40, 36, 4);
    struct ttf_quilt_config config = small_config();

    (void)state;
    config.flips = config.rotations = true;
    for (size_t i = 0; i < sizeof(sizes) / sizeof(sizes[0]); i++) {
        struct ttf_quilt_map map;

        config.width = sizes[i][0];
        config.height = sizes[i][1];
        config.overlap_x = sizes[i][2];
        config.overlap_y = sizes[i][3];
        quilt_plan_ok(&config, input.sequence, NULL, &map);
        quilt_blocks_are_what_is_shown(&map);
        ttf_quilt_map_free(&map);
    }
    config.width = 17;
    quilt_refused(&config, input.sequence, -EINVAL, "tileable");
    texture_free(&input);
}

/* ---- avoided repetition ---- */

static uint32_t apart(uint32_t a, uint32_t b)
{
    return a > b ? a - b : b - a;
}

/* Distance in blocks; of a tileable output also around its border. */
static uint32_t blocks_apart(uint32_t a, uint32_t b, uint32_t n, bool around)
{
    uint32_t d = apart(a, b);

    return around && n - d < d ? n - d : d;
}

/* Its corner in the input as it is, of a square block. */
static void corner_of(const struct ttf_quilt_map *map, const struct ttf_quilt_block *block,
                      uint32_t *ret_x, uint32_t *ret_y)
{
    const struct ttf_quilt_input *input = &map->inputs[block->input];
    bool swapped = block->turn & 4;
    uint32_t across = swapped ? input->height : input->width;
    uint32_t down = swapped ? input->width : input->height;
    uint32_t x = block->turn & 1 ? across - block->width - block->src_x : block->src_x;
    uint32_t y = block->turn & 2 ? down - block->height - block->src_y : block->src_y;

    *ret_x = swapped ? y : x;
    *ret_y = swapped ? x : y;
}

static bool same_place(const struct ttf_quilt_map *map, const struct ttf_quilt_block *a,
                       const struct ttf_quilt_block *b, uint32_t avoid)
{
    uint32_t ax, ay, bx, by;

    if (a->turn != 0 || b->turn != 0) {
        corner_of(map, a, &ax, &ay);
        corner_of(map, b, &bx, &by);
        return apart(ax, bx) <= avoid && apart(ay, by) <= avoid;
    }
    return apart(a->src_x, b->src_x) <= avoid && apart(a->src_y, b->src_y) <= avoid;
}

static unsigned count_repeated(const struct ttf_quilt_map *map, uint32_t columns, uint32_t avoid)
{
    uint32_t rows = map->n_blocks / columns;
    unsigned repeated = 0;

    for (unsigned i = 0; i < map->n_blocks; i++) {
        for (unsigned j = 0; j < i; j++) {
            const struct ttf_quilt_block *a = &map->blocks[i], *b = &map->blocks[j];

            repeated += a->input == b->input &&
                        blocks_apart(i % columns, j % columns, columns, map->tileable) <= 3 &&
                        blocks_apart(i / columns, j / columns, rows, map->tileable) <= 3 &&
                        same_place(map, a, b, avoid);
        }
    }
    return repeated;
}

static void blocks_nearby_are_never_taken_from_nearby(void **state)
{
    struct texture_sequence input = texture_make(TEXTURE_STRIPES, 64, 60, 4);
    struct ttf_quilt_config config = small_config();
    struct ttf_pool *pool = ttf_pool_create(3);
    uint32_t columns;

    (void)state;
    config.width = 130;
    config.height = 110;
    config.block_width = config.block_height = 12;
    for (int tileable = 0; tileable < 2; tileable++) {
        for (config.seed = 1; config.seed <= 3; config.seed++) {
            struct ttf_placement placement;
            struct ttf_quilt_map map;

            config.tileable = tileable;
            config.avoid_px = 0;
            ttf_placement_make(&config, &placement);
            columns = placement.columns;
            quilt_plan_ok(&config, input.sequence, pool, &map);
            assert_true(count_repeated(&map, columns, 3) > 0);
            ttf_quilt_map_free(&map);
            config.avoid_px = 3;
            quilt_plan_ok(&config, input.sequence, pool, &map);
            assert_int_equal(count_repeated(&map, columns, 3), 0);
            quilt_blocks_are_what_is_shown(&map);
            ttf_quilt_map_free(&map);
        }
    }
    ttf_pool_destroy(pool);
    texture_free(&input);
}

/* A block beside its own mirror image makes a pattern that the eye finds at once. */
static void a_place_mirrored_or_turned_is_the_same_place(void **state)
{
    struct texture_sequence input = texture_make(TEXTURE_SPOTS, 64, 60, 4);
    struct ttf_quilt_config config = small_config();
    unsigned plain = 0, turns_used = 0;

    (void)state;
    config.tileable = true; /* all blocks of one size */
    config.width = 130;
    config.height = 110;
    config.block_width = config.block_height = 12;
    config.flips = config.rotations = true;
    for (config.seed = 1; config.seed <= 3; config.seed++) {
        struct ttf_placement placement;
        struct ttf_quilt_map map;

        ttf_placement_make(&config, &placement);
        config.avoid_px = 0;
        quilt_plan_ok(&config, input.sequence, NULL, &map);
        plain += count_repeated(&map, placement.columns, 2);
        ttf_quilt_map_free(&map);
        config.avoid_px = 2;
        quilt_plan_ok(&config, input.sequence, NULL, &map);
        assert_int_equal(count_repeated(&map, placement.columns, 2), 0);
        for (unsigned i = 0; i < map.n_blocks; i++)
            turns_used |= 1u << map.blocks[i].turn;
        ttf_quilt_map_free(&map);
    }
    assert_true(plain > 0);
    assert_int_equal(turns_used, 255);
    texture_free(&input);
}

static void a_distance_that_leaves_nothing_is_halved(void **state)
{
    struct texture_sequence input = texture_make(TEXTURE_SPOTS, 60, 60, 4);
    struct ttf_quilt_config config = small_config();
    struct ttf_placement placement;
    unsigned repeated[2];

    (void)state;
    config.tileable = false;
    config.width = config.height = 150;
    config.block_width = config.block_height = 12;
    ttf_placement_make(&config, &placement);
    for (int i = 0; i < 2; i++) {
        struct ttf_quilt_map map;

        config.avoid_px = i == 0 ? 0 : 60;
        quilt_plan_ok(&config, input.sequence, NULL, &map);
        repeated[i] = count_repeated(&map, placement.columns, 2);
        ttf_quilt_map_free(&map);
    }
    assert_true(repeated[0] > 0);
    assert_int_equal(repeated[1], 0); /* 60, 30, 15 and 7 may leave nothing, 3 always does */
    texture_free(&input);
}

static void where_nothing_else_is_left_repetition_is_allowed(void **state)
{
    struct texture_sequence input = texture_make(TEXTURE_SPOTS, 24, 22, 4);
    struct ttf_quilt_config config = small_config();
    struct ttf_quilt_map map, most;

    (void)state;
    config.tileable = false;
    config.avoid_px = 40;
    quilt_plan_ok(&config, input.sequence, NULL, &map);
    quilt_blocks_are_what_is_shown(&map);
    config.avoid_px = UINT32_MAX;
    quilt_plan_ok(&config, input.sequence, NULL, &most);
    assert_true(ttf_quilt_map_digest(&map) == ttf_quilt_map_digest(&most));
    ttf_quilt_map_free(&map);
    ttf_quilt_map_free(&most);
    texture_free(&input);
}

/* As a lamp at one side makes it: darker and darker to the right. */
static void darken(struct texture_sequence *input)
{
    uint32_t width = input->sequence->width;
    size_t pixels = (size_t)width * input->sequence->height * input->sequence->n;

    for (size_t i = 0; i < 3 * pixels; i++)
        input->codes[i] =
            (uint16_t)((uint32_t)input->codes[i] * (2 * width - i / 3 % width) / (2 * width));
}

static uint32_t most_uses(const struct ttf_quilt_config *config, struct ttf_sequence *input)
{
    struct ttf_repetition_figures figures;
    struct ttf_quilt_map map;

    quilt_plan_ok(config, input, NULL, &map);
    assert_int_equal(ttf_repetition_of_map(&map, &figures), 0);
    ttf_quilt_map_free(&map);
    return figures.max_uses;
}

static void an_uneven_input_is_repeated_less_where_asked(void **state)
{
    struct texture_sequence input = texture_make(TEXTURE_SPOTS, 72, 64, 6);
    struct ttf_quilt_config config = small_config();
    uint32_t plain = 0, avoided = 0;

    (void)state;
    darken(&input);
    config.tileable = false;
    config.width = config.height = 160;
    for (config.seed = 1; config.seed <= 4; config.seed++) {
        config.avoid_px = 0;
        plain += most_uses(&config, input.sequence);
        config.avoid_px = 8;
        avoided += most_uses(&config, input.sequence);
    }
    assert_true(avoided * 4 < plain * 3);
    texture_free(&input);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(blocks_know_all_that_lies_there_at_any_size_and_overlap),
        cmocka_unit_test(the_overlap_that_is_told_is_the_least_there_is),
        cmocka_unit_test(a_tileable_output_goes_on_over_its_borders),
        cmocka_unit_test(tileable_outputs_of_any_size_are_whole),
        cmocka_unit_test(blocks_nearby_are_never_taken_from_nearby),
        cmocka_unit_test(a_place_mirrored_or_turned_is_the_same_place),
        cmocka_unit_test(a_distance_that_leaves_nothing_is_halved),
        cmocka_unit_test(where_nothing_else_is_left_repetition_is_allowed),
        cmocka_unit_test(an_uneven_input_is_repeated_less_where_asked),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
