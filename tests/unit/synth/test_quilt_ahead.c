/* SPDX-License-Identifier: Apache-2.0 */
/* What is handed on while blocks are looked for: which piece comes next. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "quilt/ahead.h"

#define SIDE   16u
#define FRAMES 3u

struct bed {
    uint8_t codes[SIDE * SIDE * 3 * FRAMES + TTF_KEPT_SLACK];
    uint32_t source[SIDE * SIDE];
    struct ttf_kept kept;
    struct ttf_quilt_config config;
    struct ttf_quilt_map map;
    unsigned asked, parts; /* of the room */
    bool full;
    uint32_t rows; /* of all frames, that came */
};

static int reserve(void *ctx, unsigned part, unsigned parts, struct ttf_err *err)
{
    struct bed *bed = ctx;

    assert_int_equal(part, bed->asked++);
    bed->parts = parts;
    return bed->full ? ttf_err_set(err, -ENOSPC, "disk", "is full") : 0;
}

static int take_rows(void *ctx, uint32_t t, uint32_t y0, uint32_t y1, const uint8_t *codes,
                     struct ttf_err *err)
{
    struct bed *bed = ctx;

    (void)err;
    assert_memory_equal(codes, bed->codes + (t * SIDE + y0) * SIDE * 3, (y1 - y0) * SIDE * 3);
    bed->rows += y1 - y0;
    return 0;
}

static struct ttf_ahead *make(struct bed *bed, bool with_room)
{
    const struct ttf_quilt_sink sink = {
        .rows8 = take_rows, .reserve = with_room ? reserve : NULL, .ctx = bed};
    struct ttf_ahead *ahead;

    memset(bed, 0, sizeof(*bed));
    for (size_t i = 0; i < sizeof(bed->codes); i++)
        bed->codes[i] = (uint8_t)(i * 7 + i / 256);
    for (uint32_t i = 0; i < SIDE * SIDE; i++)
        bed->source[i] = i;
    bed->kept = (struct ttf_kept){.frames = FRAMES, .frame = SIDE * SIDE * 3, .codes = bed->codes};
    ttf_quilt_defaults(&bed->config);
    bed->config.width = bed->config.height = SIDE;
    bed->map = (struct ttf_quilt_map){
        .width = SIDE, .height = SIDE, .source_pixels = SIDE * SIDE, .source = bed->source};
    assert_int_equal(ttf_ahead_create(&bed->config, &bed->kept, &sink, 2, &ahead), 0);
    return ahead;
}

/* What summing it up left. */
static void free_map(const struct bed *bed)
{
    free(bed->map.runs);
    free(bed->map.row_runs);
}

static int run(struct ttf_ahead *ahead, const struct ttf_ahead_piece *piece)
{
    int r = ttf_ahead_run(ahead, piece, 0, NULL);

    ttf_ahead_done(ahead, piece);
    return r;
}

static void room_is_asked_for_while_there_is_nothing_to_write(void **state)
{
    struct bed bed;
    struct ttf_ahead *ahead = make(&bed, true);
    struct ttf_ahead_piece room, other;

    (void)state;
    assert_int_equal(ttf_ahead_take(ahead, &bed.map, 0, true, &room), 1);
    assert_int_equal(room.kind, TTF_AHEAD_ROOM);
    /* one thread is at it already */
    assert_int_equal(ttf_ahead_take(ahead, &bed.map, 0, true, &other), 0);
    assert_int_equal(run(ahead, &room), 0);
    assert_true(bed.asked > 0 && bed.asked < bed.parts);
    /* rows go first (behind the map, which is whole here), and while they are written nobody asks */
    assert_int_equal(ttf_ahead_take(ahead, &bed.map, SIDE, true, &other), 1);
    assert_int_equal(run(ahead, &other), 0);
    assert_int_equal(ttf_ahead_take(ahead, &bed.map, SIDE, true, &other), 1);
    assert_int_equal(other.kind, TTF_AHEAD_ROWS);
    assert_int_equal(ttf_ahead_take(ahead, &bed.map, SIDE, true, &room), 0);
    assert_int_equal(run(ahead, &other), 0);
    assert_int_equal(bed.rows, FRAMES * SIDE);
    free_map(&bed);
    ttf_ahead_destroy(ahead);
}

static void a_whole_map_is_summed_up_once_beside_the_last_rows(void **state)
{
    struct bed bed;
    struct ttf_ahead *ahead = make(&bed, false);
    struct ttf_ahead_piece map, rows, none;
    struct ttf_repetition_figures repetition;

    (void)state;
    bed.source[SIDE] = 0; /* a pixel that comes twice, and one that does not come */
    memcpy(bed.codes + (size_t)SIDE * 3, bed.codes, 3);
    for (uint32_t t = 1; t < FRAMES; t++)
        memcpy(bed.codes + (size_t)(t * SIDE * SIDE + SIDE) * 3,
               bed.codes + (size_t)(t * SIDE * SIDE) * 3, 3);
    assert_int_equal(ttf_ahead_take(ahead, &bed.map, SIDE, false, &map), 1);
    assert_int_equal(map.kind, TTF_AHEAD_MAP);
    /* meanwhile by another thread */
    assert_int_equal(ttf_ahead_take(ahead, &bed.map, SIDE, false, &rows), 1);
    assert_int_equal(rows.kind, TTF_AHEAD_ROWS);
    assert_int_equal(run(ahead, &rows), 0);
    assert_int_equal(bed.rows, FRAMES * SIDE);
    assert_int_equal(ttf_ahead_take(ahead, &bed.map, SIDE, false, &none), 0);
    assert_false(ttf_ahead_finished(ahead));
    assert_int_equal(run(ahead, &map), 0);
    assert_true(ttf_ahead_finished(ahead));
    assert_true(ttf_ahead_sums(ahead)->digest == ttf_quilt_map_digest(&bed.map));
    assert_int_equal(ttf_repetition_of_map(&bed.map, &repetition), 0);
    assert_int_equal(repetition.max_uses, 2);
    assert_int_equal(ttf_ahead_sums(ahead)->repetition.max_uses, 2);
    assert_true(ttf_ahead_sums(ahead)->repetition.mean_uses == repetition.mean_uses);
    assert_true(ttf_ahead_sums(ahead)->repetition.source_coverage == repetition.source_coverage);
    assert_int_equal(bed.map.row_runs[SIDE], SIDE + 1); /* a row each, and row 1 of two pieces */
    free_map(&bed);
    ttf_ahead_destroy(ahead);
}

static void all_of_the_room_is_asked_for_once(void **state)
{
    const struct ttf_aside *aside;
    struct bed bed;
    struct ttf_ahead *ahead = make(&bed, true);
    struct ttf_ahead_piece piece;

    (void)state;
    /* some while frames are read, the rest later */
    aside = ttf_ahead_aside(ahead);
    for (int i = 0; i < 10; i++)
        assert_int_equal(aside->next(aside->ctx, NULL), 1);
    while (ttf_ahead_take(ahead, &bed.map, 0, true, &piece) > 0)
        assert_int_equal(run(ahead, &piece), 0);
    assert_true(bed.parts > 0);
    assert_int_equal(aside->next(aside->ctx, NULL), 0); /* and no more of it */
    assert_int_equal(bed.asked, bed.parts);
    ttf_ahead_destroy(ahead);
}

static void a_full_disk_ends_it_and_no_sink_need_reserve(void **state)
{
    struct bed bed;
    struct ttf_ahead *ahead = make(&bed, true);
    struct ttf_ahead_piece piece;
    struct ttf_err err = {0};

    (void)state;
    bed.full = true;
    assert_int_equal(ttf_ahead_take(ahead, &bed.map, 0, true, &piece), 1);
    assert_int_equal(ttf_ahead_run(ahead, &piece, 0, &err), -ENOSPC);
    assert_string_equal(err.where, "disk");
    assert_int_equal(bed.asked, 1);
    ttf_ahead_destroy(ahead);
    ahead = make(&bed, false);
    assert_null(ttf_ahead_aside(ahead)->next);
    assert_int_equal(ttf_ahead_take(ahead, &bed.map, 0, true, &piece), 0);
    ttf_ahead_destroy(ahead);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(room_is_asked_for_while_there_is_nothing_to_write),
        cmocka_unit_test(a_whole_map_is_summed_up_once_beside_the_last_rows),
        cmocka_unit_test(all_of_the_room_is_asked_for_once),
        cmocka_unit_test(a_full_disk_ends_it_and_no_sink_need_reserve),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
