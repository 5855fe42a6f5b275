/* SPDX-License-Identifier: Apache-2.0 */
/* map_file.c: a map out of JSON; see map_file.h. The first wrong field sticks and is named. */
#include "ttf/synth/map_file.h"

#include <errno.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "quilt/map_format.h"
#include "quilt/map_rate.h"
#include "quilt/paste.h"
#include "ttf/dataset/json_parse.h"

#define SIDE_MAX       32768u
#define TIMES_MAX      (1u << 20) /* frames */
#define BLOCK_MIN      4
#define BLOCK_MAX      65535u /* cuts are 16 bits wide */
#define COVERS_AT_MOST 16u    /* blocks overlap by at most half: a pixel lies under few of them */

struct reading {
    struct ttf_err *err;
    int code;
    char at[64]; /* "blocks[3]." */
    struct ttf_quilt_map map;
    uint64_t most_pixels;
    uint8_t *known; /* output pixels that a block so far has covered */
    uint64_t area;  /* of all blocks so far */
    size_t cuts_room;
};

static void wrong(struct reading *r, const char *key, const char *fmt, ...) TTF_PRINTF(3, 4);
static void wrong(struct reading *r, const char *key, const char *fmt, ...)
{
    char where[128], what[160];
    va_list args;

    if (r->code)
        return;
    va_start(args, fmt);
    /* NOLINTNEXTLINE(clang-analyzer-valist.Uninitialized): it is begun above */
    (void)vsnprintf(what, sizeof(what), fmt, args);
    va_end(args);
    (void)snprintf(where, sizeof(where), "%s%s", r->at, key);
    r->code = -EINVAL;
    (void)ttf_err_set(r->err, r->code, where, "%s", what);
}

static void no_memory(struct reading *r)
{
    if (r->code)
        return;
    r->code = -ENOMEM;
    (void)ttf_err_set(r->err, r->code, NULL, "no memory for a map");
}

/* ---- typed fields ---- */

/* A whole number within lo..hi; else it is wrong and lo. */
static int64_t number(struct reading *r, const char *key, const json_t *value, int64_t lo,
                      int64_t hi)
{
    json_int_t n = json_is_integer(value) ? json_integer_value(value) : 0;

    if (json_is_integer(value) && n >= lo && n <= hi)
        return n;
    wrong(r, key, "must be a whole number from %lld to %lld", (long long)lo, (long long)hi);
    return lo;
}

static int64_t field(struct reading *r, const json_t *object, const char *key, int64_t lo,
                     int64_t hi)
{
    return number(r, key, json_object_get(object, key), lo, hi);
}

/* An array of n values; NULL if it is not. */
static const json_t *array(struct reading *r, const json_t *object, const char *key, size_t n)
{
    const json_t *value = json_object_get(object, key);

    if (json_is_array(value) && json_array_size(value) == n)
        return value;
    wrong(r, key, "must be an array of %zu", n);
    return NULL;
}

static void pair(struct reading *r, const json_t *object, const char *key, int64_t lo, int64_t hi,
                 uint32_t *ret_a, uint32_t *ret_b)
{
    const json_t *value = array(r, object, key, 2);

    *ret_a = (uint32_t)number(r, key, json_array_get(value, 0), lo, hi);
    *ret_b = (uint32_t)number(r, key, json_array_get(value, 1), lo, hi);
}

static double real(struct reading *r, const json_t *object, const char *key)
{
    const json_t *value = json_object_get(object, key);
    double number = json_number_value(value);

    if (json_is_number(value) && isfinite(number) && number >= 0.0)
        return number;
    wrong(r, key, "must be a number of at least 0");
    return 0.0;
}

/* ---- the head ---- */

static void read_inputs(struct reading *r, const json_t *root)
{
    const json_t *list = json_object_get(root, "inputs");
    size_t n = json_array_size(list);
    uint64_t pixels = 0;

    if (!json_is_array(list) || n < 1 || n > TTF_QUILT_INPUTS_MAX) {
        wrong(r, "inputs", "must be an array of 1 to %d sizes", TTF_QUILT_INPUTS_MAX);
        return;
    }
    for (size_t i = 0; i < n && !r->code; i++) {
        const json_t *size = json_array_get(list, i);
        struct ttf_quilt_input *input = &r->map.inputs[i];

        if (!json_is_array(size) || json_array_size(size) != 2)
            wrong(r, "inputs", "must be sizes [width, height]");
        input->first = (uint32_t)pixels;
        input->width = (uint32_t)number(r, "inputs", json_array_get(size, 0), 1, INT32_MAX);
        input->height = (uint32_t)number(r, "inputs", json_array_get(size, 1), 1, INT32_MAX);
        pixels += (uint64_t)input->width * input->height;
        if (pixels > INT32_MAX)
            wrong(r, "inputs", "are of more than 2^31 pixels");
    }
    r->map.n_inputs = (unsigned)n;
    r->map.source_pixels = (uint32_t)pixels;
}

static void read_head(struct reading *r, const json_t *root)
{
    struct ttf_quilt_map *map = &r->map;
    const char *format = json_string_value(json_object_get(root, "format"));
    const json_t *tileable = json_object_get(root, "tileable");

    if (!format || strcmp(format, TTF_MAP_FORMAT) != 0)
        wrong(r, "format", "must be \"%s\"", TTF_MAP_FORMAT);
    (void)field(r, root, "version", TTF_MAP_VERSION, TTF_MAP_VERSION);
    pair(r, root, "size", 1, SIDE_MAX, &map->width, &map->height);
    pair(r, root, "overlap", 1, SIDE_MAX, &map->overlap_x, &map->overlap_y);
    map->feather_px = (uint32_t)field(r, root, "feather_px", 0, SIDE_MAX);
    map->n_times = (uint32_t)field(r, root, "times_of_frames", 0, TIMES_MAX);
    if (!json_is_boolean(tileable))
        wrong(r, "tileable", "must be true or false");
    map->tileable = json_is_true(tileable);
    read_inputs(r, root);
    if (!r->code && r->most_pixels > 0 && (uint64_t)map->width * map->height > r->most_pixels)
        r->code = ttf_err_set(r->err, -EFBIG, "size", "an output of %u x %u is too large",
                              map->width, map->height);
}

/* What maps written before do not say. */
static void read_optional(struct reading *r, const json_t *root)
{
    struct ttf_quilt_map *map = &r->map;
    const json_t *rounded = json_object_get(root, "rounded");

    if (json_object_get(root, "block"))
        pair(r, root, "block", BLOCK_MIN, INT32_MAX, &map->block_width, &map->block_height);
    if (json_object_get(root, "frames"))
        map->frames = (uint32_t)field(r, root, "frames", 1, INT32_MAX);
    if (rounded && !json_is_boolean(rounded))
        wrong(r, "rounded", "must be true or false");
    map->rounded = json_is_true(rounded);
}

/* ---- a block ---- */

static void read_place(struct reading *r, const json_t *object, struct ttf_quilt_block *block)
{
    const struct ttf_quilt_map *map = &r->map;
    const struct ttf_quilt_input *input;
    uint32_t width, height;

    pair(r, object, "at", 0, SIDE_MAX - 1, &block->out_x, &block->out_y);
    pair(r, object, "size", 1, BLOCK_MAX, &block->width, &block->height);
    if (block->out_x >= map->width || block->out_y >= map->height)
        wrong(r, "at", "lies outside of the output");
    /* a tileable output's blocks reach around its edges, once */
    if (block->width > map->width || block->height > map->height ||
        (!map->tileable &&
         (block->out_x + block->width > map->width || block->out_y + block->height > map->height)))
        wrong(r, "size", "reaches beyond the output");
    block->input = (uint8_t)field(r, object, "input", 0, (int64_t)map->n_inputs - 1);
    block->turn = (uint8_t)field(r, object, "turn", 0, TTF_TURN_COUNT - 1);
    input = &map->inputs[block->input];
    width = block->turn & 4 ? input->height : input->width;
    height = block->turn & 4 ? input->width : input->height;
    pair(r, object, "from", 0, INT32_MAX, &block->src_x, &block->src_y);
    if ((uint64_t)block->src_x + block->width > width ||
        (uint64_t)block->src_y + block->height > height)
        wrong(r, "from", "the block does not lie in its input");
}

static void read_arms(struct reading *r, const json_t *object, struct ttf_quilt_block *block)
{
    const json_t *arms = array(r, object, "arms", 4);
    uint16_t *to[4] = {&block->left, &block->top, &block->right, &block->bottom};

    for (size_t i = 0; i < 4; i++)
        *to[i] = (uint16_t)number(r, "arms", json_array_get(arms, i), 0,
                                  i % 2 ? block->height : block->width);
}

/* Room for a block's cuts behind all others'. */
static void grow_cuts(struct reading *r, size_t n)
{
    struct ttf_quilt_map *map = &r->map;
    size_t room = r->cuts_room ? r->cuts_room : 1024;
    uint16_t *grown;

    while (room < map->n_cuts + n)
        room *= 2;
    if (room > r->cuts_room) {
        grown = realloc(map->cuts, room * sizeof(*grown));
        if (!grown) {
            no_memory(r);
            return;
        }
        map->cuts = grown;
        r->cuts_room = room;
    }
    memset(map->cuts + map->n_cuts, 0, n * sizeof(*map->cuts));
}

static void read_cut(struct reading *r, const json_t *cuts, const char *key, uint32_t n,
                     uint16_t arm, uint16_t *to)
{
    char name[16];
    const json_t *list = json_object_get(cuts, key);

    (void)snprintf(name, sizeof(name), "cuts.%s", key);
    if (!to) {
        if (list)
            wrong(r, name, "belongs to no arm");
        return;
    }
    if (!json_is_array(list) || json_array_size(list) != n) {
        wrong(r, name, "must be an array of %u", n);
        return;
    }
    for (uint32_t i = 0; i < n && !r->code; i++)
        to[i] = (uint16_t)number(r, name, json_array_get(list, i), 0, arm - 1);
}

static void read_cuts(struct reading *r, const json_t *object, struct ttf_quilt_block *block)
{
    struct ttf_quilt_map *map = &r->map;
    const json_t *cuts = json_object_get(object, "cuts");
    size_t n = ttf_block_cuts(block);
    struct ttf_block_cut_places to;

    if (!json_is_object(cuts))
        wrong(r, "cuts", "must be an object");
    if (!r->code)
        grow_cuts(r, n);
    if (r->code)
        return;
    block->cuts = (uint32_t)map->n_cuts;
    map->n_cuts += n;
    if (map->n_cuts > UINT32_MAX)
        wrong(r, "cuts", "are too many");
    to = ttf_block_cut_places(map, block);
    read_cut(r, cuts, "left", block->height, block->left, to.left);
    read_cut(r, cuts, "top", block->width, block->top, to.top);
    read_cut(r, cuts, "right", block->height, block->right, to.right);
    read_cut(r, cuts, "bottom", block->width, block->bottom, to.bottom);
}

static void read_times(struct reading *r, const json_t *object, unsigned block)
{
    const json_t *list;
    uint32_t *to;

    if (r->map.n_times == 0) {
        if (json_object_get(object, "times"))
            wrong(r, "times", "are there, but the map is said to have none");
        return;
    }
    list = array(r, object, "times", r->map.n_times);
    to = r->map.times + (size_t)block * r->map.n_times;
    for (uint32_t t = 0; t < r->map.n_times && !r->code; t++)
        to[t] =
            (uint32_t)number(r, "times", json_array_get(list, t), t ? to[t - 1] : 0, UINT32_MAX);
}

/*
 * A block may lay its arms only over pixels that are there already, else a blend would be of
 * nothing.
 */
static void cover(struct reading *r, const struct ttf_quilt_block *b)
{
    r->area += (uint64_t)b->width * b->height;
    if (r->area > (uint64_t)r->map.width * r->map.height * COVERS_AT_MOST)
        wrong(r, "size", "more blocks than an output of this size can have");
    for (uint32_t y = 0; y < b->height && !r->code; y++) {
        for (uint32_t x = 0; x < b->width; x++) {
            bool arm =
                x < b->left || y < b->top || x + b->right >= b->width || y + b->bottom >= b->height;
            size_t at = ttf_block_pixel(&r->map, b, x, y);

            if (arm && !r->known[at]) {
                wrong(r, "arms", "reach over pixels that no earlier block has");
                return;
            }
        }
    }
    for (uint32_t y = 0; y < b->height && !r->code; y++)
        for (uint32_t x = 0; x < b->width; x++)
            r->known[ttf_block_pixel(&r->map, b, x, y)] = 1;
}

static void read_block(struct reading *r, const json_t *object, unsigned i)
{
    struct ttf_quilt_block *block = &r->map.blocks[i];

    (void)snprintf(r->at, sizeof(r->at), "blocks[%u].", i);
    if (!json_is_object(object))
        wrong(r, "", "must be an object");
    read_place(r, object, block);
    read_arms(r, object, block);
    read_cuts(r, object, block);
    block->error = real(r, object, "error");
    block->best_error = real(r, object, "best_error");
    /* the report divides by it, but for the first block */
    block->overlap_pixels =
        (uint32_t)field(r, object, "overlap_pixels", i > 0, (int64_t)BLOCK_MAX * BLOCK_MAX);
    block->candidates = (uint32_t)field(r, object, "candidates", 0, UINT32_MAX);
    if (!r->code)
        cover(r, block);
    if (!r->code)
        read_times(r, object, i);
}

/* ---- the pace ---- */

static void read_rate_row(struct reading *r, const json_t *value, uint32_t y)
{
    struct ttf_rate_map *rate = &r->map.rate;
    float *row = rate->m + (size_t)y * rate->width;
    const char *text = json_string_value(value);
    uint32_t wrong_at;

    (void)snprintf(r->at, sizeof(r->at), "rate[%u]", y);
    if (json_is_null(value) && y > 0) {
        memcpy(row, row - rate->width, rate->width * sizeof(*row));
        return;
    }
    if (!text || json_string_length(value) != (size_t)rate->width * TTF_MAP_RATE_DIGITS) {
        wrong(r, "", "must be %u numbers of %u digits%s", rate->width, TTF_MAP_RATE_DIGITS,
              y > 0 ? ", or null: as the row above" : "");
        return;
    }
    wrong_at = ttf_map_rate_row(text, rate->width, row);
    if (wrong_at < rate->width)
        wrong(r, "", "number %u is no rate: the bits of a float from 0 to 2^20", wrong_at);
}

/* Behind the blocks: they cover the whole output, so its size is no empty claim. */
static void read_rate(struct reading *r, const json_t *root)
{
    struct ttf_quilt_map *map = &r->map;
    const json_t *rows = json_object_get(root, "rate");

    if (!rows || r->code)
        return;
    if (!array(r, root, "rate", map->height))
        return;
    map->rate = (struct ttf_rate_map){map->width, map->height,
                                      malloc((size_t)map->width * map->height * sizeof(float))};
    if (!map->rate.m)
        no_memory(r);
    for (uint32_t y = 0; y < map->height && !r->code; y++)
        read_rate_row(r, json_array_get(rows, y), y);
    r->at[0] = '\0';
}

/* ---- all of it ---- */

static void read_blocks(struct reading *r, const json_t *root)
{
    struct ttf_quilt_map *map = &r->map;
    const json_t *list = json_object_get(root, "blocks");
    size_t n = json_array_size(list), pixels = (size_t)map->width * map->height;

    if (!json_is_array(list) || n < 1 || n > pixels) {
        wrong(r, "blocks", "must be an array of blocks");
        return;
    }
    map->n_blocks = (unsigned)n;
    map->blocks = calloc(n, sizeof(*map->blocks));
    map->source = malloc(pixels * sizeof(*map->source));
    map->owner = calloc(pixels, sizeof(*map->owner));
    r->known = calloc(pixels, 1);
    /* times are allocated only as far as the text could hold them: two characters each */
    map->times = map->n_times ? calloc(n, map->n_times * sizeof(*map->times)) : NULL;
    if (!map->blocks || !map->source || !map->owner || !r->known || (map->n_times && !map->times))
        no_memory(r);
    for (size_t i = 0; i < n && !r->code; i++)
        read_block(r, json_array_get(list, i), (unsigned)i);
    r->at[0] = '\0';
    if (!r->code && memchr(r->known, 0, pixels))
        wrong(r, "blocks", "do not cover the whole output");
}

static void read_map(struct reading *r, const json_t *root, size_t bytes)
{
    read_head(r, root);
    read_optional(r, root);
    if (!r->code &&
        (uint64_t)r->map.n_times * json_array_size(json_object_get(root, "blocks")) > bytes)
        wrong(r, "times_of_frames", "is more than the blocks say");
    if (!r->code)
        read_blocks(r, root);
    read_rate(r, root);
    if (!r->code && !r->map.cuts && !(r->map.cuts = calloc(1, sizeof(*r->map.cuts))))
        no_memory(r);
    if (!r->code && ttf_paste_all(&r->map) < 0)
        no_memory(r);
}

int ttf_quilt_map_parse(const char *text, size_t bytes, uint64_t most_pixels,
                        struct ttf_quilt_map *ret, struct ttf_err *err)
{
    struct reading r = {.err = err, .most_pixels = most_pixels};
    json_error_t error;
    json_t *root;
    int code = ttf_json_parse(text, bytes, &root, &error);

    if (code == -ENOMEM)
        return ttf_err_set(err, code, "map", "no memory");
    if (code)
        return ttf_err_set(err, -EINVAL, "map", "line %d, column %d: %s", error.line, error.column,
                           error.text);
    if (!json_is_object(root))
        wrong(&r, "map", "must be an object");
    else
        read_map(&r, root, bytes);
    json_decref(root);
    free(r.known);
    if (r.code) {
        ttf_quilt_map_free(&r.map);
        return r.code;
    }
    *ret = r.map;
    return 0;
}
