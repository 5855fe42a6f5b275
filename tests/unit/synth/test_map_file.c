/* SPDX-License-Identifier: Apache-2.0 */
/* A map as text and back: the same map; and nothing that a text says is believed. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "textures.h"
#include "ttf/synth/map_file.h"

#define W 40u
#define H 32u
#define N 9u

/* The text of a map found with `config`, to be freed; *ret_map: to be freed too. */
static char *text_of(const struct ttf_quilt_config *config, struct ttf_quilt_map *ret_map)
{
    struct texture_sequence texture = texture_make(TEXTURE_SPOTS, W, H, N);
    struct texture_sequence other = texture_make(TEXTURE_NOISE, H, W, N);
    struct ttf_sequence *const more[] = {other.sequence};
    struct ttf_quilt_config own = *config;
    struct ttf_json json;
    const char *text;
    size_t bytes;
    char *copy;

    own.more = more;
    assert_int_equal(ttf_quilt_plan(&own, texture.sequence, NULL, ret_map, NULL), 0);
    ttf_json_init(&json, true);
    ttf_quilt_map_json(ret_map, &json);
    assert_int_equal(ttf_json_finish(&json, &text, &bytes), 0);
    copy = strdup(text);
    assert_non_null(copy);
    ttf_json_free(&json);
    texture_free(&texture);
    texture_free(&other);
    return copy;
}

static struct ttf_quilt_config plain(void)
{
    struct ttf_quilt_config config;

    ttf_quilt_defaults(&config);
    config.width = 61;
    config.height = 50;
    config.block_width = 16;
    config.block_height = 12;
    return config;
}

static void comes_back(const struct ttf_quilt_config *config)
{
    struct ttf_quilt_map map, back;
    char *text = text_of(config, &map);

    assert_int_equal(ttf_quilt_map_parse(text, strlen(text), 0, &back, NULL), 0);
    assert_true(ttf_quilt_map_digest(&map) == ttf_quilt_map_digest(&back));
    assert_memory_equal(map.source, back.source,
                        (size_t)map.width * map.height * sizeof(*map.source));
    assert_memory_equal(map.owner, back.owner, (size_t)map.width * map.height * sizeof(*map.owner));
    assert_int_equal(map.n_blocks, back.n_blocks);
    assert_memory_equal(map.blocks, back.blocks, map.n_blocks * sizeof(*map.blocks));
    assert_int_equal(map.n_cuts, back.n_cuts);
    assert_memory_equal(map.cuts, back.cuts, map.n_cuts * sizeof(*map.cuts));
    assert_int_equal(map.n_layers, back.n_layers);
    assert_int_equal(map.tileable, back.tileable);
    assert_int_equal(map.overlap_x, back.overlap_x);
    assert_int_equal(map.feather_px, back.feather_px);
    assert_int_equal(map.n_times, back.n_times);
    assert_int_equal(map.rounded, back.rounded);
    assert_int_equal(map.frames, N);
    assert_int_equal(back.frames, N);
    assert_int_equal(back.block_width, 16);
    assert_int_equal(back.block_height, 12);
    ttf_quilt_map_free(&map);
    ttf_quilt_map_free(&back);
    free(text);
}

static void a_plain_map_comes_back(void **state)
{
    struct ttf_quilt_config config = plain();

    (void)state;
    comes_back(&config);
}

static void turned_blocks_of_several_inputs_come_back(void **state)
{
    struct ttf_quilt_config config = plain();

    (void)state;
    config.n_more = 1;
    config.flips = config.rotations = true;
    comes_back(&config);
}

static void a_tileable_map_comes_back_with_its_feather_and_times(void **state)
{
    struct ttf_quilt_config config = plain();

    (void)state;
    config.tileable = true;
    config.feather_px = 2;
    config.jitter_frames = 2;
    config.jitter_round = true;
    comes_back(&config);
}

/* The text of `config`'s map at a pace of its own, to be freed; equal rows and unequal ones. */
static char *paced(struct ttf_quilt_config *config, struct ttf_quilt_map *ret)
{
    struct ttf_json json;
    const char *text;
    size_t bytes;
    char *copy;

    config->width = 30;
    config->height = 20;
    free(text_of(config, ret));
    ret->rate = (struct ttf_rate_map){30, 20, malloc(30 * 20 * sizeof(float))};
    assert_non_null(ret->rate.m);
    for (uint32_t i = 0; i < 30 * 20; i++)
        ret->rate.m[i] = (float)(i % 30 + (i < 300 ? 0 : 30)) / 7.0f;
    ttf_json_init(&json, true);
    ttf_quilt_map_json(ret, &json);
    assert_int_equal(ttf_json_finish(&json, &text, &bytes), 0);
    copy = strdup(text);
    assert_non_null(copy);
    ttf_json_free(&json);
    return copy;
}

static void a_pace_comes_back_to_the_bit(void **state)
{
    struct ttf_quilt_config config = plain();
    struct ttf_quilt_map map, back, copy;
    char *text = paced(&config, &map);

    (void)state;
    assert_int_equal(ttf_quilt_map_parse(text, strlen(text), 0, &back, NULL), 0);
    assert_int_equal(ttf_quilt_map_copy(&back, &copy), 0);
    assert_non_null(copy.rate.m);
    assert_ptr_not_equal(copy.rate.m, back.rate.m);
    assert_int_equal(back.rate.width, 30);
    assert_int_equal(back.rate.height, 20);
    assert_memory_equal(map.rate.m, back.rate.m, 30 * 20 * sizeof(float));
    assert_memory_equal(map.rate.m, copy.rate.m, 30 * 20 * sizeof(float));
    assert_true(ttf_quilt_map_digest(&map) == ttf_quilt_map_digest(&copy));
    back.rate.m[599] = 1.0f; /* it is part of what a digest names */
    assert_true(ttf_quilt_map_digest(&map) != ttf_quilt_map_digest(&back));
    ttf_quilt_map_free(&map);
    ttf_quilt_map_free(&back);
    ttf_quilt_map_free(&copy);
    free(text);
}

/* A text with the first `from` behind `after` replaced by `to`. To be freed. */
static char *changed_text(const char *text, const char *after, const char *from, const char *to)
{
    const char *at = strstr(text, after);
    size_t room = strlen(text) + strlen(to) + 1;
    char *changed = malloc(room);

    assert_non_null(changed);
    at = at ? strstr(at, from) : NULL;
    assert_non_null(at);
    snprintf(changed, room, "%.*s%s%s", (int)(at - text), text, to, at + strlen(from));
    return changed;
}

static void what_is_wrong_in_a_pace_is_named(void **state)
{
    static const struct {
        const char *from, *to, *where;
    } CASES[] = {{"[", "[null,", "rate"},
                 {"00000000", "0000000", "rate[0]"},
                 {"00000000", "000000000", "rate[0]"},
                 {"00000000", "0000000g", "rate[0]"},
                 {"00000000", "0000000A", "rate[0]"},
                 {"00000000", "7fc00000", "rate[0]"}, /* no number */
                 {"00000000", "7f800000", "rate[0]"}, /* endless */
                 {"00000000", "bf800000", "rate[0]"}, /* -1 */
                 {"00000000", "49800001", "rate[0]"}, /* above 2^20 */
                 {"null", "0", "rate[1]"},
                 {"null", "\"\"", "rate[1]"},
                 {"[", "", "map"}};
    struct ttf_quilt_config config = plain();
    struct ttf_quilt_map map, back;
    char *text = paced(&config, &map);

    (void)state;
    for (unsigned i = 0; i < sizeof(CASES) / sizeof(*CASES); i++) {
        struct ttf_err err = {0};
        char *changed = changed_text(text, "\"rate\"", CASES[i].from, CASES[i].to);

        if (ttf_quilt_map_parse(changed, strlen(changed), 0, &back, &err) != -EINVAL ||
            strcmp(err.where, CASES[i].where) != 0 || !*err.what)
            fail_msg("%s for %s: %d, %s: %s", CASES[i].to, CASES[i].from, err.code, err.where,
                     err.what);
        free(changed);
    }
    ttf_quilt_map_free(&map);
    free(text);
}

/* Files of before have neither block nor frames, rounded nor rate: they mean what they meant. */
static void an_older_map_is_read_as_before(void **state)
{
    struct ttf_quilt_config config = plain();
    struct ttf_quilt_map map, back;
    char *text = text_of(&config, &map), *without;

    (void)state;
    without = changed_text(text, "{", "  \"block\": [16,12],\n", "");
    free(text);
    text = changed_text(without, "{", "  \"frames\": 9,\n", "");
    assert_null(strstr(text, "rounded"));
    assert_null(strstr(text, "rate"));
    assert_int_equal(ttf_quilt_map_parse(text, strlen(text), 0, &back, NULL), 0);
    assert_true(ttf_quilt_map_digest(&map) == ttf_quilt_map_digest(&back));
    assert_int_equal(back.block_width, 0);
    assert_int_equal(back.frames, 0);
    assert_false(back.rounded);
    assert_null(back.rate.m);
    ttf_quilt_map_free(&map);
    ttf_quilt_map_free(&back);
    free(without);
    free(text);
}

static void a_text_cut_short_anywhere_is_refused(void **state)
{
    struct ttf_quilt_config config = plain();
    struct ttf_quilt_map map, back;
    char *text;
    size_t n;

    (void)state;
    config.width = 30;
    config.height = 20;
    text = text_of(&config, &map);
    n = strlen(text) - 1; /* the last is a line's end */
    for (size_t i = 0; i < n; i++)
        assert_int_equal(ttf_quilt_map_parse(text, i, 0, &back, NULL), -EINVAL);
    ttf_quilt_map_free(&map);
    free(text);
}

/* The text with the first `from` behind `after` replaced by `to`, parsed: refused, naming `where`. */
static void refused(const char *after, const char *from, const char *to, const char *where)
{
    struct ttf_quilt_config config = plain();
    struct ttf_quilt_map map, back;
    struct ttf_err err = {0};
    char *text, *changed;

    config.jitter_frames = 1;
    text = text_of(&config, &map);
    changed = changed_text(text, after, from, to);
    if (ttf_quilt_map_parse(changed, strlen(changed), 0, &back, &err) != -EINVAL ||
        strcmp(err.where, where) != 0 || !*err.what)
        fail_msg("%s for %s: %d, %s: %s", to, from, err.code, err.where, err.what);
    free(changed);
    free(text);
    ttf_quilt_map_free(&map);
}

static void what_is_wrong_is_named(void **state)
{
    (void)state;
    refused("{", "quilt map", "quilt", "format");
    refused("{", "\"version\": 1", "\"version\": 2", "version");
    refused("\"size\"", "61", "0", "size");
    refused("\"size\"", "61", "32769", "size");
    refused("\"size\"", "61", "62", "blocks");
    refused("\"size\"", "61", "60", "blocks[4].size");
    refused("\"inputs\"", "40", "400000000", "inputs");
    refused("\"inputs\"", "40", "-1", "inputs");
    refused("\"inputs\"", "40", "17", "blocks[0].from");
    refused("\"tileable\"", "false", "0", "tileable");
    refused("\"block\"", "16", "3", "block");
    refused("\"block\"", "[16,12]", "16", "block");
    refused("\"frames\"", "9", "0", "frames");
    refused("\"frames\"", "9", "9.5", "frames");
    refused("\"frames\"", "9", "9,\"rounded\":1", "rounded");
    refused("\"frames\"", "9", "9,\"rate\":1", "rate");
    refused("\"times_of_frames\"", "9", "8", "blocks[0].times");
    refused("\"times_of_frames\"", "9", "1048577", "times_of_frames");
    refused("\"times_of_frames\"", "9", "1048576", "times_of_frames");
    refused("\"at\"", "[0,0]", "[1,0]", "blocks[5].arms");
    refused("\"at\"", "[0,0]", "[99,0]", "blocks[0].at");
    refused("\"at\"", "[0,0]", "0", "blocks[0].at");
    refused("\"blocks\"", "\"size\":[16,12]", "\"size\":[0,12]", "blocks[0].size");
    refused("\"arms\"", "[0,0,0,0]", "[0,0,0]", "blocks[0].arms");
    refused("\"arms\"", "[0,0,0,0]", "[17,0,0,0]", "blocks[0].arms");
    refused("\"arms\"", "[0,0,0,0]", "[1,0,0,0]", "blocks[0].cuts.left");
    refused("\"input\":", "0", "1", "blocks[0].input");
    refused("\"turn\":", "0", "8", "blocks[0].turn");
    refused("\"turn\":", "0", "0.5", "blocks[0].turn");
    refused("\"left\":", "[", "[3,", "blocks[1].cuts.left");
    refused("\"left\":", "[", "[[],", "blocks[1].cuts.left");
    refused("\"cuts\":", "{}", "{\"top\":[]}", "blocks[0].cuts.top");
    refused("\"cuts\":", "{}", "[]", "blocks[0].cuts");
    refused("\"error\":", "0", "-1", "blocks[0].error");
    refused("\"times\":", "[0,", "[4000000000,", "blocks[0].times");
    refused("\"times\":", "[0,", "[4294967296,", "blocks[0].times");
}

/* A cut position beyond its arm would be read from beyond the block. */
static void cuts_stay_within_their_arms(void **state)
{
    struct ttf_quilt_config config = plain();
    struct ttf_quilt_map map, back;
    struct ttf_err err = {0};
    struct ttf_json json;
    const char *text;
    size_t bytes;

    (void)state;
    free(text_of(&config, &map));
    map.cuts[map.blocks[1].cuts + 2] = map.blocks[1].left;
    ttf_json_init(&json, false);
    ttf_quilt_map_json(&map, &json);
    assert_int_equal(ttf_json_finish(&json, &text, &bytes), 0);
    assert_int_equal(ttf_quilt_map_parse(text, bytes, 0, &back, &err), -EINVAL);
    assert_string_equal(err.where, "blocks[1].cuts.left");
    ttf_json_free(&json);
    ttf_quilt_map_free(&map);
}

static void more_pixels_than_asked_for_are_too_many(void **state)
{
    struct ttf_quilt_config config = plain();
    struct ttf_quilt_map map, back;
    char *text = text_of(&config, &map);

    (void)state;
    assert_int_equal(ttf_quilt_map_parse(text, strlen(text), 61 * 50 - 1, &back, NULL), -EFBIG);
    assert_int_equal(ttf_quilt_map_parse(text, strlen(text), 61 * 50, &back, NULL), 0);
    ttf_quilt_map_free(&back);
    ttf_quilt_map_free(&map);
    free(text);
}

static void garbage_is_refused(void **state)
{
    static const char *const GARBAGE[] = {"",         "x",
                                          "[]",       "{}",
                                          "null",     "{\"blocks\":[{}]}",
                                          "\xff\xfe", "{\"size\":[1,1],\"size\":[1,1]}"};
    struct ttf_quilt_map back;
    struct ttf_err err;

    (void)state;
    for (unsigned i = 0; i < sizeof(GARBAGE) / sizeof(*GARBAGE); i++) {
        assert_int_equal(ttf_quilt_map_parse(GARBAGE[i], strlen(GARBAGE[i]), 0, &back, &err),
                         -EINVAL);
        assert_true(*err.what);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_plain_map_comes_back),
        cmocka_unit_test(turned_blocks_of_several_inputs_come_back),
        cmocka_unit_test(a_tileable_map_comes_back_with_its_feather_and_times),
        cmocka_unit_test(a_pace_comes_back_to_the_bit),
        cmocka_unit_test(what_is_wrong_in_a_pace_is_named),
        cmocka_unit_test(an_older_map_is_read_as_before),
        cmocka_unit_test(a_text_cut_short_anywhere_is_refused),
        cmocka_unit_test(what_is_wrong_is_named),
        cmocka_unit_test(cuts_stay_within_their_arms),
        cmocka_unit_test(more_pixels_than_asked_for_are_too_many),
        cmocka_unit_test(garbage_is_refused),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
