/* SPDX-License-Identifier: Apache-2.0 */
/* When a picture was taken and how it is turned, out of EXIF blocks of every kind, in either byte order. */
#include "trade_test.h"

#include <spng.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define NOON (INT64_C(1767268800) * TTF_NS_PER_S) /* 2026-01-01 12:00:00 */

/* A block with one folder and, behind it, the EXIF folder. */
struct exif {
    bool big;
    uint8_t bytes[1024];
    size_t n, entries; /* where the next text goes; where the folder's next entry goes */
};

static void put(struct exif *e, size_t at, uint32_t value, unsigned bytes)
{
    for (unsigned i = 0; i < bytes; i++)
        e->bytes[at + i] = (uint8_t)(value >> 8 * (e->big ? bytes - 1 - i : i));
}

static void begin(struct exif *e, bool big)
{
    *e = (struct exif){.big = big, .n = 512, .entries = 10};
    memcpy(e->bytes, big ? "MM\0*" : "II*\0", 4);
    put(e, 4, 8, 4);
}

static void entry(struct exif *e, uint32_t tag, uint32_t type, uint32_t n, uint32_t value)
{
    put(e, e->entries, tag, 2);
    put(e, e->entries + 2, type, 2);
    put(e, e->entries + 4, n, 4);
    put(e, e->entries + 8, value, type == 3 ? 2 : 4);
    e->entries += 12;
    put(e, 8, (uint32_t)(e->entries - 10) / 12, 2);
}

static void text(struct exif *e, uint32_t tag, const char *value)
{
    uint32_t n = (uint32_t)strlen(value) + 1;

    entry(e, tag, 2, n, (uint32_t)e->n);
    if (n <= 4)
        memcpy(e->bytes + e->entries - 4, value, n);
    memcpy(e->bytes + e->n, value, n);
    e->n += n;
}

/* Where the chunk of this type begins, in a file that has one. */
static size_t chunk_at(const uint8_t *file, const char *type, size_t *ret_bytes)
{
    size_t at = 8, n;

    for (;; at += n) {
        n = 12 + ((size_t)file[at + 2] << 8 | file[at + 3]);
        if (memcmp(file + at + 4, type, 4) == 0)
            break;
    }
    *ret_bytes = n;
    return at;
}

/* Takes the EXIF block from before the pixels to behind them, where a PNG may have it as well. */
static void move_behind_pixels(uint8_t *file)
{
    size_t exif_bytes, end_bytes, exif = chunk_at(file, "eXIf", &exif_bytes);
    size_t end = chunk_at(file, "IEND", &end_bytes);
    uint8_t *block = malloc(exif_bytes);

    assert_non_null(block);
    memcpy(block, file + exif, exif_bytes);
    memmove(file + exif, file + exif + exif_bytes, end - exif - exif_bytes);
    memcpy(file + end - exif_bytes, block, exif_bytes);
    free(block);
}

static struct ttf_image_info look(void **state, const struct exif *e)
{
    static const uint8_t pixels[2 * 3] = {1, 2, 3, 4, 5, 6};
    const char *path = in_folder(state, "exif.png");
    struct spng_ihdr header = {
        .width = 1, .height = 2, .bit_depth = 8, .color_type = SPNG_COLOR_TYPE_TRUECOLOR};
    struct spng_exif exif = {.data = (char *)e->bytes, .length = e->n};
    spng_ctx *ctx = spng_ctx_new(SPNG_CTX_ENCODER);
    struct ttf_image_info info, behind;
    size_t bytes = 0;
    void *file;
    int error = 0;

    assert_non_null(ctx);
    spng_set_option(ctx, SPNG_ENCODE_TO_BUFFER, 1);
    assert_int_equal(spng_set_ihdr(ctx, &header), 0);
    assert_int_equal(spng_set_exif(ctx, &exif), 0);
    assert_int_equal(spng_encode_image(ctx, pixels, 6, SPNG_FMT_PNG, SPNG_ENCODE_FINALIZE), 0);
    file = spng_get_png_buffer(ctx, &bytes, &error);
    assert_non_null(file);
    write_bytes(path, file, bytes);
    assert_int_equal(ttf_image_probe(ttf_io_posix(), path, &info, NULL), 0);
    move_behind_pixels(file);
    write_bytes(path, file, bytes);
    free(file);
    spng_ctx_free(ctx);
    assert_int_equal(ttf_image_probe(ttf_io_posix(), path, &behind, NULL), 0);
    assert_true(behind.taken_utc_ns == info.taken_utc_ns && behind.zone_known == info.zone_known);
    assert_true(behind.orientation == info.orientation && behind.width == info.width);
    return info;
}

static void the_time_of_the_picture_goes_before_that_of_the_file(void **state)
{
    for (int big = 0; big < 2; big++) {
        struct ttf_image_info info;
        struct exif e;

        begin(&e, big);
        text(&e, 0x132, "2026:01:01 12:00:00");
        info = look(state, &e);
        assert_true(info.taken_utc_ns == NOON);
        assert_false(info.zone_known);
        text(&e, 0x9003, "2026:01:01 12:00:01 and more than there is room for");
        text(&e, 0x9291, "25");
        text(&e, 0x9010, "+01:00");
        info = look(state, &e);
        assert_true(info.taken_utc_ns == NOON + 1250 * TTF_NS_PER_MS - 3600 * TTF_NS_PER_S);
        assert_true(info.zone_known);
        assert_int_equal(info.zone_offset_s, 3600);
        text(&e, 0x9011, "-0330"); /* the original's own goes before */
        info = look(state, &e);
        assert_int_equal(info.zone_offset_s, -12600);
    }
}

static void zones_are_read_as_far_as_they_are_zones(void **state)
{
    static const struct {
        const char *text;
        bool known;
        int offset_s;
    } zones[] = {
        {"Z", true, 0},       {"+14:00", true, 50400}, {"-00:30", true, -1800},
        {"+15:00", false, 0}, {"+01:60", false, 0},    {"01:00", false, 0},
        {"+x1:00", false, 0}, {"+01:x", false, 0},     {"", false, 0},
    };

    for (unsigned i = 0; i < TTF_COUNT_OF(zones); i++) {
        struct ttf_image_info info;
        struct exif e;

        begin(&e, i % 2);
        text(&e, 0x9003, "2026:01:01 12:00:00");
        text(&e, 0x9011, zones[i].text);
        info = look(state, &e);
        assert_int_equal(info.zone_known, zones[i].known);
        if (zones[i].known)
            assert_int_equal(info.zone_offset_s, zones[i].offset_s);
        assert_true(info.taken_utc_ns == NOON - zones[i].offset_s * TTF_NS_PER_S);
    }
}

static void times_that_are_none_are_not_known(void **state)
{
    static const char *const times[] = {"",
                                        "    :  :     :  :  ",
                                        "2026:13:01 12:00:00",
                                        "2026:00:01 12:00:00",
                                        "2026:02:29 12:00:00",
                                        "2026:01:00 12:00:00",
                                        "1899:01:01 12:00:00",
                                        "2200:01:01 12:00:00",
                                        "2026:01:01 24:00:00",
                                        "2026:01:01 12:60:00",
                                        "2026:01:01 12:00:61",
                                        "2026:01:01 12:00:000",
                                        "2026:01:01",
                                        "no time"};

    for (unsigned i = 0; i < TTF_COUNT_OF(times); i++) {
        struct exif e;

        begin(&e, false);
        text(&e, 0x132, times[i]);
        assert_true(look(state, &e).taken_utc_ns == TTF_NS_UNKNOWN);
    }
}

static void a_time_of_the_picture_that_is_none_gives_way_to_the_files(void **state)
{
    static const char *const blank[] = {"", "    :  :     :  :  ", "0000:00:00 00:00:00",
                                        "          "};

    for (unsigned i = 0; i < TTF_COUNT_OF(blank); i++) {
        struct ttf_image_info info;
        struct exif e;

        begin(&e, i % 2);
        text(&e, 0x132, "2026:01:01 12:00:00");
        text(&e, 0x9003, blank[i]);
        text(&e, 0x9291, "25"); /* of a second that is not told */
        text(&e, 0x9010, "+02:00");
        info = look(state, &e);
        assert_true(info.taken_utc_ns == NOON - 7200 * TTF_NS_PER_S);
        assert_true(info.zone_known);
    }
}

static void leap_years_and_years_before_1970_have_their_days(void **state)
{
    static const struct {
        const char *text;
        int64_t seconds;
    } times[] = {{"2024:02:29 00:00:00", 1709164800},
                 {"2000:02:29 00:00:00", 951782400},
                 {"1900:03:01 00:00:00", -2203891200},
                 {"1969:12:31 23:59:59", -1},
                 {"2100:03:01 00:00:00", 4107542400}};

    for (unsigned i = 0; i < TTF_COUNT_OF(times); i++) {
        struct exif e;

        begin(&e, true);
        text(&e, 0x9003, times[i].text);
        assert_true(look(state, &e).taken_utc_ns == times[i].seconds * TTF_NS_PER_S);
    }
}

static void a_broken_block_tells_nothing_and_harms_nothing(void **state)
{
    struct exif e;

    begin(&e, false);
    put(&e, 4, 100000, 4); /* the folder lies outside */
    assert_true(look(state, &e).taken_utc_ns == TTF_NS_UNKNOWN);
    begin(&e, false);
    entry(&e, 0x132, 2, 20, 100000); /* the text does */
    entry(&e, 0x8769, 4, 1, 100000); /* the EXIF folder does */
    entry(&e, 0x132, 7, 20, 512);    /* of another type */
    entry(&e, 0x9003, 2, 0xfffffff0u, 512);
    assert_true(look(state, &e).taken_utc_ns == TTF_NS_UNKNOWN);
    begin(&e, false);
    put(&e, 8, 65535, 2); /* more entries than there are bytes */
    assert_true(look(state, &e).taken_utc_ns == TTF_NS_UNKNOWN);
}

/* Cut short, of another length, or of a wrong checksum: the pixels are whole, and nothing else is told. */
static void a_broken_block_behind_the_pixels_harms_nothing(void **state)
{
    const char *path = in_folder(state, "exif.png");
    struct exif e;
    size_t n, at, bytes;
    uint8_t *file;

    begin(&e, false);
    text(&e, 0x132, "2026:01:01 12:00:00");
    assert_true(look(state, &e).taken_utc_ns == NOON);
    file = slurp(path, &n);
    at = chunk_at(file, "eXIf", &bytes);
    for (unsigned i = 0; i < 4; i++) {
        struct ttf_image_info info;
        size_t where = i == 0 ? at + 12 : i == 1 ? at : at + 3, end = i == 3 ? at + bytes - 1 : n;
        struct ttf_pixbuf pixels;

        file[where] ^= i < 3 ? 0x81 : 0;
        write_bytes(path, file, end);
        file[where] ^= i < 3 ? 0x81 : 0;
        assert_int_equal(ttf_image_read(ttf_io_posix(), path, 0, &pixels, &info, NULL), 0);
        assert_true(info.taken_utc_ns == TTF_NS_UNKNOWN);
        ttf_pixbuf_free(&pixels);
    }
    free(file);
}

static void pictures_are_turned_upright(void **state)
{
    for (uint32_t turn = 0; turn < 10; turn++) {
        bool valid = turn >= 1 && turn <= 8, lies = turn >= 5 && turn <= 8;
        struct ttf_image_info info;
        struct exif e;

        begin(&e, turn % 2);
        entry(&e, 0x112, 3, 1, turn);
        info = look(state, &e);
        assert_int_equal(info.orientation, valid ? turn : 1);
        assert_int_equal(info.width, lies ? 2 : 1);
        assert_int_equal(info.height, lies ? 1 : 2);
    }
}

#define T(test) cmocka_unit_test_setup_teardown(test, folder_setup, folder_teardown)

int main(void)
{
    const struct CMUnitTest tests[] = {
        T(the_time_of_the_picture_goes_before_that_of_the_file),
        T(zones_are_read_as_far_as_they_are_zones),
        T(times_that_are_none_are_not_known),
        T(a_time_of_the_picture_that_is_none_gives_way_to_the_files),
        T(leap_years_and_years_before_1970_have_their_days),
        T(a_broken_block_tells_nothing_and_harms_nothing),
        T(a_broken_block_behind_the_pixels_harms_nothing),
        T(pictures_are_turned_upright),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
