/* SPDX-License-Identifier: Apache-2.0 */
/* Imports and exports that cannot be are refused before anything is made; pictures of odd kinds are read for what they are. */
#include "trade_test.h"

#include <errno.h>
#include <math.h>
#include <spng.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "ttf/dataset/export.h"
#include "ttf/dataset/icc.h"
#include "ttf/dataset/tiff.h"

static const struct ttf_encoding plain = {.scale = 65535};

/* ---- exports ---- */

static void exports_that_cannot_be_are_refused_and_make_nothing(void **state)
{
    static const uint16_t frames[2 * 4 * 3 * 3];
    const struct ttf_export_config good = {.kind = TTF_EXPORT_PNG, .output = in_folder(state, "o")};
    struct ttf_sequence *s = NULL;

    assert_int_equal(ttf_sequence_of_memory(frames, 4, 3, 2, &plain, &s, NULL), 0);
    for (unsigned i = 0; i < 12; i++) {
        struct ttf_export_config c = good;
        struct ttf_err err = {0};

        switch (i) {
        case 0:
            c.kind = TTF_EXPORT_COUNT;
            break;
        case 1:
            c.gaps = (enum ttf_gaps)7;
            break;
        case 2:
            c.start = -1;
            break;
        case 3:
            c.png_bits = 12;
            break;
        case 4:
            c.chroma = 422;
            break;
        case 5:
            c.white = -1;
            break;
        case 6:
            c.white = NAN;
            break;
        case 7:
            c.white = 1e13;
            break;
        case 8:
            c.name = "a/b";
            break;
        case 9:
            c.name = "";
            break;
        case 10:
            c.name = ".hidden";
            break;
        default:
            c.output = "";
            break;
        }
        assert_int_equal(ttf_export(s, ttf_io_posix(), &c, NULL, &err), -EINVAL);
        assert_true(err.what[0] != '\0');
        assert_false(exists(good.output));
    }
    ttf_sequence_destroy(s);
}

static void what_is_there_is_not_written_over_by_a_folder(void **state)
{
    static const uint16_t frames[4 * 3 * 3];
    struct ttf_export_config c = {.kind = TTF_EXPORT_PNG, .output = in_folder(state, "there")};
    struct ttf_sequence *s = NULL;
    struct ttf_io *io = ttf_io_posix();

    assert_int_equal(ttf_sequence_of_memory(frames, 4, 3, 1, &plain, &s, NULL), 0);
    write_bytes(c.output, "x", 1);
    assert_int_equal(ttf_export(s, io, &c, NULL, NULL), -EEXIST); /* a file */
    assert_int_equal(io->ops->unlink(io, c.output), 0);
    assert_int_equal(io->ops->mkdir(io, c.output), 0);
    assert_int_equal(ttf_export(s, io, &c, NULL, NULL), 0); /* an empty folder may be filled */
    assert_int_equal(count_entries(c.output), 2);
    assert_int_equal(ttf_export(s, io, &c, NULL, NULL), -EEXIST); /* one that holds something */
    assert_int_equal(count_entries(c.output), 2);
    c.kind = TTF_EXPORT_NPY;
    assert_int_equal(ttf_export(s, io, &c, NULL, NULL), -EISDIR);
    assert_int_equal(count_entries(c.output), 2);
    ttf_sequence_destroy(s);
}

/* Names of temporary folders can be guessed, and /tmp is everybody's: a link that lies there in wait is removed, not what it leads to. */
static void what_a_link_leads_to_is_not_removed_with_what_was_left(void **state)
{
    static const uint16_t frames[4 * 3 * 3];
    const struct ttf_export_config c = {.kind = TTF_EXPORT_PNG,
                                        .output = in_folder(state, "pictures")};
    const char *left = in_folder(state, ".pictures.part-%ld", (long)getpid());
    const char *mine = in_folder(state, "mine");
    struct ttf_io *io = ttf_io_posix();
    struct ttf_sequence *s = NULL;

    assert_int_equal(io->ops->mkdir(io, mine), 0);
    write_bytes(in_folder(state, "mine/thesis"), "x", 1);
    assert_int_equal(io->ops->mkdir(io, left), 0);
    assert_int_equal(io->ops->mkdir(io, in_folder(state, ".pictures.part-%ld/in", (long)getpid())),
                     0);
    assert_int_equal(symlink(mine, in_folder(state, ".pictures.part-%ld/in/link", (long)getpid())),
                     0);
    assert_int_equal(ttf_sequence_of_memory(frames, 4, 3, 1, &plain, &s, NULL), 0);
    assert_int_equal(ttf_export(s, io, &c, NULL, NULL), 0);
    assert_false(exists(left));
    assert_true(exists(in_folder(state, "mine/thesis")));
    ttf_sequence_destroy(s);
}

static int stop_at_once(void *ctx, int64_t done, int64_t total)
{
    return 1;
}

static void narrow_pictures_keep_a_pixel(void **state)
{
    static const uint16_t frames[300 * 3];
    struct ttf_export_config c = {
        .kind = TTF_EXPORT_PNG, .output = in_folder(state, "narrow"), .height_max = 10};
    struct ttf_export_result result;
    struct ttf_sequence *s = NULL;

    assert_int_equal(ttf_sequence_of_memory(frames, 1, 300, 1, &plain, &s, NULL), 0);
    assert_int_equal(ttf_export(s, ttf_io_posix(), &c, &result, NULL), 0);
    assert_int_equal(result.width, 1);
    assert_int_equal(result.height, 10);
    ttf_sequence_destroy(s);
    assert_int_equal(ttf_sequence_of_memory(frames, 300, 1, 1, &plain, &s, NULL), 0);
    c.output = in_folder(state, "flat");
    c.height_max = 0;
    c.width_max = 10;
    assert_int_equal(ttf_export(s, ttf_io_posix(), &c, &result, NULL), 0);
    assert_int_equal(result.width, 10);
    assert_int_equal(result.height, 1);
    c.output = in_folder(state, "stopped");
    c.progress = stop_at_once;
    assert_int_equal(ttf_export(s, ttf_io_posix(), &c, &result, NULL), -ECANCELED);
    assert_false(exists(c.output));
    ttf_sequence_destroy(s);
}

/* ---- imports ---- */

static void imports_that_cannot_be_are_refused_and_make_nothing(void **state)
{
    const char *const inputs[] = {in_folder(state, "a.png"), in_folder(state, "b.png")};
    const struct ttf_import_config good = {.inputs = inputs,
                                           .n_inputs = 2,
                                           .output = in_folder(state, "o"),
                                           .interval_ns = TTF_NS_PER_S};
    struct ttf_import_result result;

    picture_file(inputs[0], 8, 6, 1);
    picture_file(inputs[1], 8, 6, 2);
    for (unsigned i = 0; i < 14; i++) {
        static const struct ttf_region OUTSIDE[5] = {
            {4, 0, 5, 1}, {0, 2, 1, 5}, {8, 0, 1, 1}, {0, 6, 1, 1}, {0, 0, 1, 0}};
        struct ttf_import_config c = good;
        struct ttf_err err = {0};

        switch (i) {
        case 0:
            c.n_inputs = 0;
            break;
        case 1:
            c.order = TTF_IMPORT_ORDER_COUNT;
            break;
        case 2:
            c.interval_ns = -1;
            break;
        case 3:
            c.interval_ns = 0;
            break; /* nothing says it */
        case 4:
            c.output = in_folder(state, "a b");
            break;
        case 5:
            c.output = NULL;
            break;
        case 6:
            c.order = TTF_IMPORT_EXIF_TIME;
            break; /* none has one */
        case 7:
            c.order = TTF_IMPORT_NAME_TIME;
            break;
        case 8: /* 65 characters, of which each would do */
            c.output = in_folder(
                state, "a123456789a123456789a123456789a123456789a123456789a123456789a1234");
            break;
        default:
            c.region = OUTSIDE[i - 9];
            break;
        }
        assert_int_equal(ttf_import(ttf_io_posix(), &c, &result, &err), -EINVAL);
        assert_true(err.what[0] != '\0');
        assert_false(exists(good.output));
    }
    assert_int_equal(ttf_import(ttf_io_posix(), &good, &result, NULL), 0);
    assert_int_equal(result.frames, 2);
}

static void save_tiff(const char *path, const struct ttf_pixbuf *pixels)
{
    const struct ttf_tiff_spec spec = {.times = {.start_utc_ns = TTF_NS_UNKNOWN}};
    struct ttf_io *io = ttf_io_posix();
    int file;

    (void)io->ops->unlink(io, path);
    file = io->ops->open(io, path, TTF_IO_CREATE_NEW);
    assert_true(file >= 0);
    assert_int_equal(ttf_tiff_write(io, file, pixels, &spec, NULL), 0);
    assert_int_equal(io->ops->close(io, file), 0);
}

static void pictures_of_another_kind_than_the_first_are_refused(void **state)
{
    static const struct {
        uint32_t width, samples;
        enum ttf_sample format;
        const char *says; /* NULL: it may join */
    } others[] = {
        {9, 1, TTF_SAMPLE_U8, "pixels, but"},
        {8, 3, TTF_SAMPLE_U8, "is in colour, but"},
        {8, 1, TTF_SAMPLE_F32, "holds f32 samples, but"},
        {8, 1, TTF_SAMPLE_U16, NULL},
    };
    const char *const inputs[] = {in_folder(state, "a.tif"), in_folder(state, "b.tif")};
    const struct ttf_import_config c = {.inputs = inputs,
                                        .n_inputs = 2,
                                        .output = in_folder(state, "o"),
                                        .interval_ns = TTF_NS_PER_S};
    struct ttf_pixbuf first = make_picture(8, 6, 1, TTF_SAMPLE_U8, 1);
    struct ttf_import_result result;

    save_tiff(inputs[0], &first);
    ttf_pixbuf_free(&first);
    for (unsigned i = 0; i < TTF_COUNT_OF(others); i++) {
        struct ttf_pixbuf other =
            make_picture(others[i].width, 6, others[i].samples, others[i].format, 2);
        struct ttf_err err = {0};

        save_tiff(inputs[1], &other);
        ttf_pixbuf_free(&other);
        assert_int_equal(ttf_import(ttf_io_posix(), &c, &result, &err),
                         others[i].says ? -EINVAL : 0);
        if (others[i].says && !strstr(err.what, others[i].says))
            fail_msg("'%s' does not say '%s'", err.what, others[i].says);
        assert_int_equal(exists(c.output), !others[i].says);
    }
}

static void names_of_kinds_and_orders_lead_there_and_back(void **state)
{
    for (int i = 0; i < TTF_EXPORT_COUNT; i++)
        assert_int_equal(ttf_export_kind_find(ttf_export_kind_name((enum ttf_export_kind)i)), i);
    for (int i = 0; i < TTF_IMPORT_ORDER_COUNT; i++)
        assert_int_equal(ttf_import_order_find(ttf_import_order_name((enum ttf_import_order)i)), i);
    for (int i = 0; i < 3; i++)
        assert_int_equal(ttf_gaps_find(ttf_gaps_name((enum ttf_gaps)i)), i);
    assert_int_equal(ttf_export_kind_find("avi"), -ENOENT);
    assert_int_equal(ttf_import_order_find("by-mood"), -ENOENT);
    assert_int_equal(ttf_gaps_find("leap"), -ENOENT);
    assert_string_equal(ttf_export_kind_name(TTF_EXPORT_COUNT), "?");
    assert_string_equal(ttf_import_order_name(TTF_IMPORT_ORDER_COUNT), "?");
    assert_string_equal(ttf_gaps_name((enum ttf_gaps)9), "?");
}

/* ---- PNG of odd kinds ---- */

enum odd {
    ODD_PALETTE,
    ODD_PALETTE_TRANSPARENT,
    ODD_FOUR_BITS,
    ODD_LINEAR_PROFILE,
    ODD_GREY_ALPHA,
    ODD_COUNT
};

static void write_odd(const char *path, enum odd odd)
{
    static const uint8_t pixels[4] = {0, 1, 2, 3};
    struct spng_ihdr header = {.width = 2, .height = 2, .bit_depth = 8};
    struct spng_plte palette = {.n_entries = 4};
    struct spng_trns transparency = {.n_type3_entries = 1, .type3_alpha = {128}};
    uint8_t wide[24] = {0}, *icc = NULL;
    struct spng_iccp profile = {.profile_name = "linear"};
    spng_ctx *ctx = spng_ctx_new(SPNG_CTX_ENCODER);
    size_t n = 4, bytes = 0;
    const void *data = pixels;
    void *file;
    int error;

    assert_non_null(ctx);
    spng_set_option(ctx, SPNG_ENCODE_TO_BUFFER, 1);
    for (unsigned i = 0; i < 4; i++)
        palette.entries[i] =
            (struct spng_plte_entry){.red = (uint8_t)(60 * i), .green = 1, .blue = 2};
    header.color_type = odd <= ODD_PALETTE_TRANSPARENT ? SPNG_COLOR_TYPE_INDEXED
                        : odd == ODD_FOUR_BITS         ? SPNG_COLOR_TYPE_GRAYSCALE
                        : odd == ODD_GREY_ALPHA        ? SPNG_COLOR_TYPE_GRAYSCALE_ALPHA
                                                       : SPNG_COLOR_TYPE_TRUECOLOR;
    if (odd == ODD_FOUR_BITS) {
        header.bit_depth = 4;
        n = 2; /* a byte a row */
    }
    if (odd == ODD_GREY_ALPHA || odd == ODD_LINEAR_PROFILE) {
        n = odd == ODD_GREY_ALPHA ? 8 : 12;
        data = wide;
    }
    assert_int_equal(spng_set_ihdr(ctx, &header), 0);
    if (odd <= ODD_PALETTE_TRANSPARENT)
        assert_int_equal(spng_set_plte(ctx, &palette), 0);
    if (odd == ODD_PALETTE_TRANSPARENT)
        assert_int_equal(spng_set_trns(ctx, &transparency), 0);
    if (odd == ODD_LINEAR_PROFILE) {
        assert_int_equal(ttf_icc_create(TTF_ICC_LINEAR, 3, &icc, &bytes, NULL), 0);
        profile.profile = (char *)icc;
        profile.profile_len = bytes;
        assert_int_equal(spng_set_iccp(ctx, &profile), 0);
    }
    assert_int_equal(spng_encode_image(ctx, data, n, SPNG_FMT_PNG, SPNG_ENCODE_FINALIZE), 0);
    file = spng_get_png_buffer(ctx, &bytes, &error);
    assert_non_null(file);
    write_bytes(path, file, bytes);
    free(file);
    free(icc);
    spng_ctx_free(ctx);
}

static void png_of_odd_kinds_are_read_for_what_they_are(void **state)
{
    const char *path = in_folder(state, "odd.png");

    for (unsigned odd = 0; odd < ODD_COUNT; odd++) {
        struct ttf_pixbuf got = {0};
        struct ttf_image_info info, probed;
        struct ttf_err err = {0};
        const uint8_t *first;

        write_odd(path, (enum odd)odd);
        if (ttf_image_read(ttf_io_posix(), path, 0, &got, &info, &err) != 0)
            fail_msg("kind %u: %s", odd, err.what);
        assert_int_equal(ttf_image_probe(ttf_io_posix(), path, &probed, NULL), 0);
        assert_int_equal(probed.samples, info.samples);
        assert_int_equal(got.format, TTF_SAMPLE_U8);
        first = got.data;
        switch ((enum odd)odd) {
        case ODD_PALETTE:
            assert_int_equal(info.samples, 3);
            assert_true(first[3] == 60 && first[4] == 1 && first[5] == 2);
            break;
        case ODD_PALETTE_TRANSPARENT:
            assert_int_equal(info.samples, 4);
            assert_true(first[3] == 128 && first[7] == 255);
            break;
        case ODD_FOUR_BITS:
            assert_int_equal(info.samples, 1);
            assert_true(first[0] == 0 && first[1] == 0 && first[3] == 17);
            break;
        case ODD_LINEAR_PROFILE:
            assert_true(info.foreign_profile); /* told, and not applied */
            break;
        default:
            assert_int_equal(info.samples, 2);
            break;
        }
        ttf_pixbuf_free(&got);
    }
}

static void pictures_that_are_none_say_so(void **state)
{
    static const char *const texts[] = {"", "x", "\x89PNG\r\n\x1a\n", "\xff\xd8\xff\xe0 no JPEG",
                                        "II*\0 no TIFF here at all"};
    const char *path = in_folder(state, "none");

    for (unsigned i = 0; i < TTF_COUNT_OF(texts); i++) {
        struct ttf_pixbuf got = {0};
        struct ttf_image_info info;
        struct ttf_err err = {0};

        write_bytes(path, texts[i], i == 4 ? 25 : strlen(texts[i]));
        assert_true(ttf_image_read(ttf_io_posix(), path, 0, &got, &info, &err) < 0);
        assert_true(err.what[0] != '\0');
        assert_true(ttf_image_probe(ttf_io_posix(), path, &info, NULL) < 0);
        assert_null(got.data);
    }
}

#define T(test) cmocka_unit_test_setup_teardown(test, folder_setup, folder_teardown)

int main(void)
{
    const struct CMUnitTest tests[] = {
        T(exports_that_cannot_be_are_refused_and_make_nothing),
        T(what_is_there_is_not_written_over_by_a_folder),
        T(what_a_link_leads_to_is_not_removed_with_what_was_left),
        T(narrow_pictures_keep_a_pixel),
        T(imports_that_cannot_be_are_refused_and_make_nothing),
        T(pictures_of_another_kind_than_the_first_are_refused),
        T(names_of_kinds_and_orders_lead_there_and_back),
        T(png_of_odd_kinds_are_read_for_what_they_are),
        T(pictures_that_are_none_say_so),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
