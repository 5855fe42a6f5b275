/* SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "quilts.h"

void quilt_plan_ok(const struct ttf_quilt_config *config, struct ttf_sequence *input,
                   struct ttf_pool *pool, struct ttf_quilt_map *ret)
{
    struct ttf_err err = {0};

    if (ttf_quilt_plan(config, input, pool, ret, &err) < 0)
        fail_msg("%s", err.what);
}

static int drop(void *ctx, uint32_t t, const uint16_t *codes, struct ttf_err *err)
{
    (void)ctx;
    (void)t;
    (void)codes;
    (void)err;
    return 0;
}

void quilt_refused(const struct ttf_quilt_config *config, struct ttf_sequence *input, int code,
                   const char *where)
{
    const struct ttf_quilt_sink sink = {.frame = drop};
    struct ttf_err err = {0};

    assert_int_equal(ttf_quilt_run(config, input, NULL, &sink, NULL, NULL, &err), code);
    assert_int_equal(err.code, code);
    assert_string_equal(err.where, where);
    assert_true(err.what[0] != '\0');
}

/* ---- blocks against the map ---- */

uint32_t quilt_block_shows(const struct ttf_quilt_map *map, const struct ttf_quilt_block *block,
                           uint32_t x, uint32_t y)
{
    const struct ttf_quilt_input *input = &map->inputs[block->input];
    uint32_t across = block->turn & 4 ? input->height : input->width;
    uint32_t down = block->turn & 4 ? input->width : input->height;
    uint32_t u = block->src_x + x, v = block->src_y + y;

    assert_true(u < across && v < down);
    u = block->turn & 1 ? across - 1 - u : u;
    v = block->turn & 2 ? down - 1 - v : v;
    return input->first + (block->turn & 4 ? u * input->width + v : v * input->width + u);
}

/* Two neighbours of one block were neighbours in the source, turned like the block. */
static void stay_neighbours(const struct ttf_quilt_map *map, size_t a, size_t b, int dx, int dy)
{
    unsigned turn = map->blocks[map->owner[a]].turn;
    uint32_t next;

    if (map->owner[a] != map->owner[b])
        return;
    assert_true(ttf_quilt_neighbour(map, map->source[a], turn, dx, dy, &next));
    assert_int_equal(next, map->source[b]);
}

void quilt_blocks_are_what_is_shown(const struct ttf_quilt_map *map)
{
    for (uint32_t y = 0; y < map->height; y++) {
        for (uint32_t x = 0; x < map->width; x++) {
            size_t at = (size_t)y * map->width + x;
            const struct ttf_quilt_block *block;

            assert_true(map->owner[at] < map->n_blocks);
            block = &map->blocks[map->owner[at]];
            assert_int_equal(map->source[at],
                             quilt_block_shows(map, block,
                                               (x + map->width - block->out_x) % map->width,
                                               (y + map->height - block->out_y) % map->height));
            if (x > block->out_x)
                stay_neighbours(map, at - 1, at, 1, 0);
            if (y > block->out_y)
                stay_neighbours(map, at - map->width, at, 0, 1);
        }
    }
}

/* ---- runs ---- */

static int take(struct quilt_taker *taker, uint32_t t, void *to, const void *from, size_t bytes,
                struct ttf_err *err)
{
    if (t != taker->next || t >= taker->room)
        taker->out_of_order = true;
    taker->next++;
    if (t == taker->fail_at)
        return ttf_err_set(err, -ENOSPC, "disk", "is full");
    if (t == taker->cancel_at)
        taker->cancel = 1;
    if (t < taker->room)
        memcpy((uint8_t *)to + t * bytes, from, bytes);
    return 0;
}

static int take16(void *ctx, uint32_t t, const uint16_t *codes, struct ttf_err *err)
{
    struct quilt_taker *taker = ctx;

    return take(taker, t, taker->codes, codes, taker->frame * sizeof(*codes), err);
}

/* From several threads at once. */
static int take_rows8(void *ctx, uint32_t t, uint32_t y0, uint32_t y1, const uint8_t *codes,
                      struct ttf_err *err)
{
    struct quilt_taker *taker = ctx;
    size_t row = taker->frame / taker->height;

    if (t == taker->fail_at)
        return ttf_err_set(err, -ENOSPC, "disk", "is full");
    if (t == taker->cancel_at)
        __atomic_store_n(&taker->cancel, 1, __ATOMIC_RELAXED);
    if (t >= taker->room || y0 >= y1 || y1 > taker->height) {
        __atomic_store_n(&taker->out_of_order, true, __ATOMIC_RELAXED);
        return 0;
    }
    for (uint32_t y = y0; y < y1; y++)
        __atomic_add_fetch(&taker->rows[(size_t)t * taker->height + y], 1, __ATOMIC_RELAXED);
    memcpy(taker->codes8 + t * taker->frame + y0 * row, codes, (y1 - y0) * row);
    return 0;
}

bool quilt_taker_has_all_rows(const struct quilt_taker *taker)
{
    for (size_t i = 0; i < (size_t)taker->room * taker->height; i++) {
        if (taker->rows[i] != 1)
            return false;
    }
    return !taker->out_of_order;
}

void quilt_taker_reset(struct quilt_taker *taker)
{
    taker->next = 0;
    taker->out_of_order = false;
    taker->cancel = 0;
    memset(taker->codes8, 0, taker->room * taker->frame);
    memset(taker->rows, 0, (size_t)taker->room * taker->height);
}

struct quilt_taker quilt_taker_make(const struct ttf_quilt_config *config, uint32_t frames)
{
    struct quilt_taker taker = {.frame = (size_t)config->width * config->height * 3,
                                .height = config->height,
                                .room = frames,
                                .fail_at = UINT32_MAX,
                                .cancel_at = UINT32_MAX};

    taker.codes = calloc(frames * taker.frame, sizeof(*taker.codes));
    taker.codes8 = calloc(frames * taker.frame, sizeof(*taker.codes8));
    taker.rows = calloc(frames, config->height);
    assert_true(taker.codes && taker.codes8 && taker.rows);
    return taker;
}

void quilt_taker_free(struct quilt_taker *taker)
{
    free(taker->codes);
    free(taker->codes8);
    free(taker->rows);
}

struct ttf_quilt_sink quilt_sink(struct quilt_taker *taker, bool narrow)
{
    return (struct ttf_quilt_sink){
        .frame = take16, .rows8 = narrow ? take_rows8 : NULL, .ctx = taker};
}

void quilt_run_ok(const struct ttf_quilt_config *config, struct ttf_sequence *input,
                  struct ttf_pool *pool, struct quilt_taker *taker, struct ttf_quilt_report *report,
                  struct ttf_quilt_map *map)
{
    const struct ttf_quilt_sink sink = quilt_sink(taker, false);
    struct ttf_err err = {0};

    taker->next = 0;
    if (ttf_quilt_run(config, input, pool, &sink, report, map, &err) < 0)
        fail_msg("%s", err.what);
    assert_false(taker->out_of_order);
    assert_int_equal(taker->next, taker->room);
}

struct ttf_sequence *quilt_taken(const struct quilt_taker *taker,
                                 const struct ttf_quilt_config *config)
{
    struct ttf_sequence *output;

    assert_int_equal(ttf_sequence_of_memory(taker->codes, config->width, config->height,
                                            taker->room, &texture_encoding, &output, NULL),
                     0);
    return output;
}

struct texture_sequence texture_crop(const struct texture_sequence *from, uint32_t x, uint32_t y,
                                     uint32_t width, uint32_t height)
{
    const struct ttf_sequence *whole = from->sequence;
    size_t row = (size_t)width * 3;
    struct texture_sequence made = {0};

    assert_true(x + width <= whole->width && y + height <= whole->height);
    made.codes = malloc(whole->n * height * row * sizeof(*made.codes));
    assert_non_null(made.codes);
    for (size_t t = 0; t < whole->n; t++) {
        for (size_t j = 0; j < height; j++)
            memcpy(made.codes + (t * height + j) * row,
                   from->codes + (((t * whole->height) + y + j) * whole->width + x) * 3,
                   row * sizeof(*made.codes));
    }
    /* NOLINTNEXTLINE(clang-analyzer-unix.Malloc): texture_free frees it; a failed assertion ends the test */
    assert_int_equal(ttf_sequence_of_memory(made.codes, width, height, whole->n, &texture_encoding,
                                            &made.sequence, NULL),
                     0);
    return made;
}
