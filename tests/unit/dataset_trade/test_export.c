/* SPDX-License-Identifier: Apache-2.0 */
#include "exported.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#define W 31 /* odd, as 4:2:0 does not like it */
#define H 18

/* A sequence with holes: frames of noise at given slots. */
struct holes {
    struct ttf_sequence base;
    struct ttf_sequence *memory;
};

static int holes_rows(struct ttf_sequence *s, uint32_t t, uint32_t y0, uint32_t rows, uint16_t *dst,
                      struct ttf_err *err)
{
    return ttf_sequence_read_rows(((struct holes *)s)->memory, t, y0, rows, dst, err);
}

static void holes_destroy(struct ttf_sequence *s)
{
    ttf_sequence_destroy(((struct holes *)s)->memory);
}

static const struct ttf_sequence_ops holes_ops = {.read_rows = holes_rows,
                                                  .destroy = holes_destroy};

static struct ttf_sequence *with_holes(struct holes *holes, const uint16_t *frames, uint32_t n,
                                       const int64_t *index, const struct ttf_encoding *encoding)
{
    assert_int_equal(ttf_sequence_of_memory(frames, W, H, n, encoding, &holes->memory, NULL), 0);
    holes->base = *holes->memory;
    holes->base.ops = &holes_ops;
    if (index)
        holes->base.index = index;
    return &holes->base;
}

static struct ttf_pixbuf read_back(const char *path)
{
    struct ttf_pixbuf pixels = {0};
    struct ttf_err err = {0};

    if (ttf_image_read(ttf_io_posix(), path, 0, &pixels, NULL, &err))
        fail_msg("%s: %s", err.where, err.what);
    return pixels;
}

static void png_numbers_are_contiguous_and_held_frames_are_named(void **state)
{
    static const int64_t index[3] = {10, 11, 14};
    uint16_t frames[3 * W * H * 3] = {0};
    struct holes holes;
    struct ttf_sequence *s = with_holes(&holes, frames, 3, index, &plain_light);
    const char *out = in_folder(state, "out");
    struct ttf_export_config config = {.kind = TTF_EXPORT_PNG, .output = out, .name = "leaf"};
    struct ttf_export_result result;
    struct ttf_pixbuf want, got;
    char *text;
    size_t n;

    fill_noise(frames, W, H, 3);
    result = export_ok(s, &config);
    assert_int_equal(result.frames, 5);
    assert_int_equal(result.invented, 2);
    assert_int_equal(count_entries(out), 6);
    want = make_picture(W, H, 3, TTF_SAMPLE_U8, 3);
    got = read_back(in_folder(state, "out/leaf.1005.png"));
    assert_true(same_pixels(&want, &got));
    ttf_pixbuf_free(&want);
    ttf_pixbuf_free(&got);
    assert_true(
        same_files(in_folder(state, "out/leaf.1002.png"), in_folder(state, "out/leaf.1003.png")));
    assert_true(
        same_files(in_folder(state, "out/leaf.1002.png"), in_folder(state, "out/leaf.1004.png")));
    text = (char *)slurp(in_folder(state, "out/leaf.json"), &n);
    assert_non_null(strstr(text, "\"frame\": 1003"));
    assert_non_null(strstr(text, "\"frame\": 1004"));
    assert_null(strstr(text, "\"frame\": 1002"));
    free(text);
    assert_int_equal(count_entries(in_folder(state, ".")), 1);
    ttf_sequence_destroy(s);
}

static void interpolation_mixes_light_and_fail_refuses(void **state)
{
    static const int64_t index[2] = {0, 4};
    uint16_t frames[2 * W * H * 3] = {0};
    struct holes holes;
    struct ttf_sequence *s = with_holes(&holes, frames, 2, index, &plain_light);
    struct ttf_export_config config = {.kind = TTF_EXPORT_TIFF,
                                       .output = in_folder(state, "out"),
                                       .gaps = TTF_GAPS_FAIL,
                                       .start = 7};
    struct ttf_pixbuf got;
    struct ttf_err err = {0};

    fill_noise(frames, W, H, 2);
    assert_int_equal(ttf_export(s, ttf_io_posix(), &config, NULL, &err), -ENODATA);
    assert_non_null(strstr(err.what, "slot 1"));
    assert_int_equal(count_entries(in_folder(state, ".")), 0);
    config.gaps = TTF_GAPS_INTERPOLATE;
    export_ok(s, &config);
    got = read_back(in_folder(state, "out/frame.0008.tif"));
    assert_int_equal(got.format, TTF_SAMPLE_U16);
    for (size_t i = 0; i < (size_t)W * H * 3; i++)
        assert_int_equal(((uint16_t *)got.data)[i],
                         (frames[i] * 3 + frames[W * H * 3 + i] + 2) / 4);
    ttf_pixbuf_free(&got);
    ttf_sequence_destroy(s);
}

static void files_are_numbered_from_zero_if_that_is_asked_for(void **state)
{
    uint16_t frames[2 * W * H * 3] = {0};
    struct holes holes;
    struct ttf_sequence *s = with_holes(&holes, frames, 2, NULL, &plain_light);
    struct ttf_export_config config = {
        .kind = TTF_EXPORT_PNG, .output = in_folder(state, "out"), .from_zero = true};

    export_ok(s, &config);
    assert_true(exists(in_folder(state, "out/frame.0000.png")));
    assert_true(exists(in_folder(state, "out/frame.0001.png")));
    assert_int_equal(count_entries(config.output), 3);
    ttf_sequence_destroy(s);
}

static void every_kth_slot_and_a_size_limit_are_kept(void **state)
{
    uint16_t frames[9 * W * H * 3] = {0};
    struct holes holes;
    struct ttf_sequence *s = with_holes(&holes, frames, 9, NULL, &plain_light);
    struct ttf_export_config config = {.kind = TTF_EXPORT_PNG,
                                       .output = in_folder(state, "out"),
                                       .every = 4,
                                       .width_max = 16,
                                       .png_bits = 16};
    struct ttf_export_result result;
    struct ttf_pixbuf got;

    fill_noise(frames, W, H, 9);
    result = export_ok(s, &config);
    assert_int_equal(result.frames, 3);
    assert_int_equal(result.width, 16);
    assert_int_equal(result.height, 9);
    got = read_back(in_folder(state, "out/frame.1003.png"));
    assert_int_equal(got.format, TTF_SAMPLE_U16);
    assert_int_equal(got.width, 16);
    ttf_pixbuf_free(&got);
    ttf_sequence_destroy(s);
}

/* As small a reader of NumPy's format as does. */
static const uint8_t *check_npy(const uint8_t *data, size_t n, const char *shape)
{
    size_t header = (size_t)data[8] | (size_t)data[9] << 8;
    char text[256] = "";

    assert_memory_equal(data, "\x93NUMPY\x01\x00", 8);
    assert_true(header < sizeof(text) && 10 + header <= n);
    assert_int_equal((10 + header) % 64, 0);
    memcpy(text, data + 10, header);
    assert_int_equal(text[header - 1], '\n');
    assert_non_null(strstr(text, "'descr': '<u2'"));
    assert_non_null(strstr(text, "'fortran_order': False"));
    assert_non_null(strstr(text, shape));
    return data + 10 + header;
}

static void npy_holds_light_as_uint16(void **state)
{
    uint16_t frames[2 * W * H * 3] = {0};
    struct holes holes;
    struct ttf_sequence *s = with_holes(&holes, frames, 2, NULL, &plain_light);
    struct ttf_export_config config = {.kind = TTF_EXPORT_NPY, .output = in_folder(state, "a.npy")};
    const uint8_t *body;
    uint8_t *data;
    size_t n;

    fill_noise(frames, W, H, 2);
    export_ok(s, &config);
    data = slurp(in_folder(state, "a.npy"), &n);
    body = check_npy(data, n, "'shape': (2, 18, 31, 3)");
    assert_int_equal(n - (size_t)(body - data), sizeof(frames));
    for (size_t i = 0; i < sizeof(frames) / 2; i++)
        assert_int_equal(body[2 * i] | body[2 * i + 1] << 8, frames[i]);
    free(data);
    assert_true(exists(in_folder(state, "a.npy.json")));
    ttf_sequence_destroy(s);
}

static void captured_codes_lose_their_pedestal_and_headroom(void **state)
{
    static const struct ttf_encoding captured = {.pedestal = TTF_PEDESTAL, .scale = TTF_SCALE};
    uint16_t frames[W * H * 3] = {0};
    struct holes holes;
    struct ttf_sequence *s = with_holes(&holes, frames, 1, NULL, &captured);
    struct ttf_export_config config = {.kind = TTF_EXPORT_NPY, .output = in_folder(state, "a.npy")};
    uint8_t *data;
    const uint8_t *body;
    size_t n;

    for (size_t i = 0; i < (size_t)W * H * 3; i++)
        frames[i] = TTF_PEDESTAL;
    frames[0] = TTF_PEDESTAL + TTF_SCALE;
    frames[1] = 65535;
    frames[2] = TTF_PEDESTAL + TTF_SCALE / 2;
    frames[3] = 0;
    export_ok(s, &config);
    data = slurp(in_folder(state, "a.npy"), &n);
    body = check_npy(data, n, "(1, 18, 31, 3)");
    assert_int_equal(body[0] | body[1] << 8, 65535);
    assert_int_equal(body[2] | body[3] << 8, 65535);
    assert_int_equal(body[4] | body[5] << 8, 32768);
    assert_int_equal(body[6] | body[7] << 8, 0);
    assert_int_equal(body[8] | body[9] << 8, 0);
    free(data);
    ttf_sequence_destroy(s);
}

static void a_measurement_is_shown_from_its_least_to_its_greatest(void **state)
{
    /* values 100 to 5000: no reflectance */
    static const struct ttf_encoding wide = {.pedestal = -100.0 * 65535.0 / 4900.0,
                                             .scale = 65535.0 / 4900.0};
    uint16_t frames[W * H * 3] = {0};
    struct holes holes;
    struct ttf_sequence *s = with_holes(&holes, frames, 1, NULL, &wide);
    struct ttf_export_config config = {.kind = TTF_EXPORT_NPY, .output = in_folder(state, "a.npy")};
    const uint8_t *body;
    uint8_t *data;
    size_t n;

    fill_noise(frames, W, H, 1);
    export_ok(s, &config);
    data = slurp(in_folder(state, "a.npy"), &n);
    body = check_npy(data, n, "(1, 18, 31, 3)");
    for (size_t i = 0; i < sizeof(frames) / 2; i++)
        assert_int_equal(body[2 * i] | body[2 * i + 1] << 8, frames[i]);
    free(data);
    ttf_sequence_destroy(s);
}

static int stop_at_two(void *ctx, int64_t done, int64_t total)
{
    assert_int_equal(total, *(int64_t *)ctx);
    return done == 2;
}

static void a_stopped_export_leaves_what_was_there_before(void **state)
{
    uint16_t frames[4 * W * H * 3] = {0};
    struct holes holes;
    struct ttf_sequence *s = with_holes(&holes, frames, 4, NULL, &plain_light);
    int64_t total = 4;
    static const enum ttf_export_kind all[] = {TTF_EXPORT_NPY, TTF_EXPORT_Y4M, TTF_EXPORT_MP4,
                                               TTF_EXPORT_SHEET};
    struct ttf_export_config config = {
        .output = in_folder(state, "old"), .progress = stop_at_two, .progress_ctx = &total};
    int files = open_files();

    fill_noise(frames, W, H, 4);
    write_bytes(config.output, "precious", 8);
    for (size_t i = 0; i < sizeof(all) / sizeof(all[0]); i++) {
        uint8_t *data;
        size_t n;

        config.kind = all[i];
        assert_int_equal(ttf_export(s, ttf_io_posix(), &config, NULL, NULL), -ECANCELED);
        data = slurp(config.output, &n);
        assert_memory_equal(data, "precious", 8);
        free(data);
        assert_int_equal(count_entries(in_folder(state, ".")), 1);
    }
    config.kind = TTF_EXPORT_PNG;
    assert_int_equal(ttf_export(s, ttf_io_posix(), &config, NULL, NULL), -EEXIST);
    assert_int_equal(open_files(), files);
    assert_int_equal(waitpid(-1, NULL, WNOHANG), -1);
    ttf_sequence_destroy(s);
}

static int deny_writes(void *ctx, const char *op, const char *path)
{
    int *left = ctx;

    return (strcmp(op, "pwrite") == 0 || strcmp(op, "append") == 0) && (*left)-- <= 0 ? -ENOSPC : 0;
}

static void a_full_disk_leaves_nothing_behind(void **state)
{
    uint16_t frames[2 * W * H * 3] = {0};
    struct holes holes;
    struct ttf_sequence *s = with_holes(&holes, frames, 2, NULL, &plain_light);
    static const enum ttf_export_kind all[] = {TTF_EXPORT_NPY,  TTF_EXPORT_Y4M,   TTF_EXPORT_PNG,
                                               TTF_EXPORT_TIFF, TTF_EXPORT_SHEET, TTF_EXPORT_MP4,
                                               TTF_EXPORT_GIF};
    size_t n = sizeof(all) / sizeof(all[0]) - (have_program("ffmpeg") ? 0 : 2);

    fill_noise(frames, W, H, 2);
    for (size_t i = 0; i < n; i++) {
        int code = -ENOSPC;

        for (int writes = 0; code; writes++) {
            int left = writes;
            struct ttf_io *io = ttf_io_faulty_create(ttf_io_posix(), deny_writes, &left);
            struct ttf_export_config config = {.kind = all[i],
                                               .output = in_folder(state, "%zu", i)};
            struct ttf_err err = {0};

            code = ttf_export(s, io, &config, NULL, &err);
            ttf_io_faulty_destroy(io);
            if (code == 0)
                break; /* what is there stays: the next kind has another name */
            assert_int_equal(code, -ENOSPC);
            assert_false(exists(config.output));
            assert_false(exists(in_folder(state, "%zu.json", i)));
            /* It is told of what the user has named. */
            if (strncmp(err.where, config.output, strlen(config.output)) != 0 ||
                strstr(err.where, ".part-") || strstr(err.what, ".part-"))
                fail_msg("%s: %s", err.where, err.what);
        }
    }
    ttf_sequence_destroy(s);
}

static void a_link_is_followed_and_stays(void **state)
{
    static const enum ttf_export_kind kinds[] = {TTF_EXPORT_PNG, TTF_EXPORT_NPY};
    uint16_t frames[2 * W * H * 3] = {0};
    struct holes holes;
    struct ttf_sequence *s = with_holes(&holes, frames, 2, NULL, &plain_light);
    const char *folder = in_folder(state, "disk/folder"), *file = in_folder(state, "disk/array");
    const char *links[] = {in_folder(state, "a"), in_folder(state, "b")};
    struct ttf_err err = {0};

    assert_int_equal(ttf_io_mkdirs(ttf_io_posix(), folder, NULL), 0);
    write_bytes(file, "old", 3);
    assert_int_equal(symlink("disk/folder", links[0]), 0);
    assert_int_equal(symlink(file, links[1]), 0);
    for (unsigned i = 0; i < 2; i++) {
        struct ttf_export_config config = {.kind = kinds[i], .output = links[i]};
        struct stat st;

        export_ok(s, &config);
        assert_int_equal(lstat(links[i], &st), 0);
        assert_true(S_ISLNK(st.st_mode));
    }
    assert_int_equal(count_entries(folder), 3);
    assert_true(exists(in_folder(state, "disk/array.json")));
    assert_int_equal(count_entries(in_folder(state, "disk")), 3);
    assert_int_equal(count_entries(in_folder(state, ".")), 3);
    assert_int_equal(symlink("nowhere", in_folder(state, "c")), 0);
    assert_int_equal(ttf_export(s, ttf_io_posix(),
                                &(struct ttf_export_config){.kind = TTF_EXPORT_NPY,
                                                            .output = in_folder(state, "c")},
                                NULL, &err),
                     -ENOENT);
    assert_string_equal(err.where, in_folder(state, "c"));
    ttf_sequence_destroy(s);
}

static int deny_a_name(void *ctx, const char *op, const char *path)
{
    const char *ending = ctx, *found = strstr(path, ending);

    return strcmp(op, "rename") == 0 && found && !found[strlen(ending)] ? -EIO : 0;
}

/* The sidecar is the only thing that says of an array that it is simulated: neither is ever there without the other. */
static void an_output_and_its_sidecar_come_together_or_not_at_all(void **state)
{
    char names[][8] = {".npy", ".json"};
    uint16_t frames[2 * W * H * 3] = {0};
    struct holes holes;
    struct ttf_sequence *s = with_holes(&holes, frames, 2, NULL, &plain_light);
    struct ttf_export_config config = {.kind = TTF_EXPORT_NPY, .output = in_folder(state, "a.npy")};
    struct ttf_err err = {0};
    uint8_t *data;
    size_t n;

    fill_noise(frames, W, H, 2);
    for (unsigned i = 0; i < TTF_COUNT_OF(names); i++) {
        /* The table says the path that is renamed, whose name ends so. */
        struct ttf_io *io = ttf_io_faulty_create(ttf_io_posix(), deny_a_name, names[i]);

        assert_int_equal(ttf_export(s, io, &config, NULL, &err), -EIO);
        assert_int_equal(count_entries(in_folder(state, ".")), 0);
        ttf_io_faulty_destroy(io);
    }
    assert_int_equal(ttf_io_mkdirs(ttf_io_posix(), in_folder(state, "a.npy.json"), NULL), 0);
    assert_int_equal(ttf_export(s, ttf_io_posix(), &config, NULL, &err), -EISDIR);
    assert_string_equal(err.where, in_folder(state, "a.npy.json"));
    assert_int_equal(count_entries(in_folder(state, ".")), 1);
    write_bytes(config.output, "precious", 8);
    assert_int_equal(ttf_export(s, ttf_io_posix(), &config, NULL, &err), -EISDIR);
    data = slurp(config.output, &n);
    assert_memory_equal(data, "precious", 8);
    free(data);
    ttf_sequence_destroy(s);
}

static void a_contact_sheet_shows_first_and_last_in_a_grid(void **state)
{
    uint16_t frames[20 * W * H * 3] = {0};
    struct holes holes;
    struct ttf_sequence *s = with_holes(&holes, frames, 20, NULL, &plain_light);
    struct ttf_export_config config = {.kind = TTF_EXPORT_SHEET,
                                       .output = in_folder(state, "sheet.png"),
                                       .sheet_frames = 6,
                                       .sheet_columns = 3};
    struct ttf_pixbuf sheet, first, last, cell;
    struct ttf_export_result result;

    fill_noise(frames, W, H, 20);
    result = export_ok(s, &config);
    assert_int_equal(result.frames, 6);
    sheet = read_back(in_folder(state, "sheet.png"));
    assert_int_equal(sheet.width, 4 + 3 * (W + 4));
    assert_int_equal(sheet.height, 4 + 2 * (H + 4));
    first = make_picture(W, H, 3, TTF_SAMPLE_U8, 1);
    last = make_picture(W, H, 3, TTF_SAMPLE_U8, 20);
    assert_int_equal(ttf_pixbuf_view(&sheet, 4, 4, W, H, &cell), 0);
    assert_true(same_pixels(&cell, &first));
    assert_int_equal(ttf_pixbuf_view(&sheet, 4 + 2 * (W + 4), 4 + H + 4, W, H, &cell), 0);
    assert_true(same_pixels(&cell, &last));
    ttf_pixbuf_free(&sheet);
    ttf_pixbuf_free(&first);
    ttf_pixbuf_free(&last);
    ttf_sequence_destroy(s);
}

static void wrong_options_are_refused(void **state)
{
    uint16_t frames[W * H * 3] = {0};
    struct holes holes;
    struct ttf_sequence *s = with_holes(&holes, frames, 1, NULL, &plain_light);
    struct ttf_export_config config = {.kind = TTF_EXPORT_PNG, .output = in_folder(state, "out")};

    fill_noise(frames, W, H, 1);
    config.png_bits = 12;
    assert_int_equal(ttf_export(s, ttf_io_posix(), &config, NULL, NULL), -EINVAL);
    config.png_bits = 0;
    config.name = "a/b";
    assert_int_equal(ttf_export(s, ttf_io_posix(), &config, NULL, NULL), -EINVAL);
    config.name = NULL;
    config.start = -1;
    assert_int_equal(ttf_export(s, ttf_io_posix(), &config, NULL, NULL), -EINVAL);
    config.start = 0;
    config.output = "";
    assert_int_equal(ttf_export(s, ttf_io_posix(), &config, NULL, NULL), -EINVAL);
    assert_int_equal(count_entries(in_folder(state, ".")), 0);
    ttf_sequence_destroy(s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
#define IN_FOLDER(f) cmocka_unit_test_setup_teardown(f, folder_setup, folder_teardown)
        IN_FOLDER(png_numbers_are_contiguous_and_held_frames_are_named),
        IN_FOLDER(interpolation_mixes_light_and_fail_refuses),
        IN_FOLDER(files_are_numbered_from_zero_if_that_is_asked_for),
        IN_FOLDER(every_kth_slot_and_a_size_limit_are_kept),
        IN_FOLDER(npy_holds_light_as_uint16),
        IN_FOLDER(captured_codes_lose_their_pedestal_and_headroom),
        IN_FOLDER(a_measurement_is_shown_from_its_least_to_its_greatest),
        IN_FOLDER(a_stopped_export_leaves_what_was_there_before),
        IN_FOLDER(a_full_disk_leaves_nothing_behind),
        IN_FOLDER(a_link_is_followed_and_stays),
        IN_FOLDER(an_output_and_its_sidecar_come_together_or_not_at_all),
        IN_FOLDER(a_contact_sheet_shows_first_and_last_in_a_grid),
        IN_FOLDER(wrong_options_are_refused),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
