/* SPDX-License-Identifier: Apache-2.0 */
#include "imported.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>

#include "ttf/dataset/export.h"

#define W 24
#define H 17

/* Does frame t show the 8-bit sRGB picture that `seed` makes? */
static bool shows(struct ttf_sequence *s, uint32_t t, unsigned seed)
{
    struct ttf_pixbuf want = make_picture(s->width, s->height, 3, TTF_SAMPLE_U8, seed);
    uint16_t *frame = read_frame(s, t);
    bool same = true;

    for (size_t i = 0; i < (size_t)s->width * s->height * 3; i++)
        same &= ttf_linear16_to_srgb8(frame[i]) == ((uint8_t *)want.data)[i];
    free(frame);
    ttf_pixbuf_free(&want);
    return same;
}

static void names_sort_as_people_count(void **state)
{
    assert_true(ttf_natural_compare("frame2.png", "frame10.png") < 0);
    assert_true(ttf_natural_compare("frame10.png", "frame9.png") > 0);
    assert_true(ttf_natural_compare("frame002.png", "frame10.png") < 0);
    assert_true(ttf_natural_compare("a", "b") < 0);
    assert_true(ttf_natural_compare("frame2", "frame2") == 0);
    assert_true(ttf_natural_compare("frame02", "frame2") != 0);
    assert_true(ttf_natural_compare("day3_1", "day2_10") > 0);
    assert_true(ttf_natural_compare("a9/x1", "a10/x0") < 0);
    assert_true(ttf_natural_compare("1"
                                    "00000000000000000000000000",
                                    "99999999999999999999") > 0);
}

static void pictures_come_back_to_the_bit_in_natural_order(void **state)
{
    const char *const inputs[] = {in_folder(state, "f10.png"), in_folder(state, "f2.png"),
                                  in_folder(state, "f1.png")};
    struct ttf_import_config config = {.inputs = inputs,
                                       .n_inputs = 3,
                                       .output = in_folder(state, "data"),
                                       .interval_ns = TTF_NS_PER_MIN};
    struct ttf_export_config out = {.kind = TTF_EXPORT_PNG, .output = in_folder(state, "out")};
    struct ttf_import_result result;
    struct ttf_reader_summary summary;
    struct opened opened;

    picture_file(inputs[0], W, H, 10);
    picture_file(inputs[1], W, H, 2);
    picture_file(inputs[2], W, H, 1);
    result = import_ok(ttf_io_posix(), &config);
    assert_int_equal(result.frames, 3);
    assert_int_equal(result.missed, 0);
    assert_int_equal(strlen(result.digest), 64);
    opened = open_dataset(config.output);
    summary = *ttf_reader_summary(opened.reader);
    assert_true(summary.sealed && summary.ended);
    assert_int_equal(summary.n_plans, 0);
    assert_string_equal(ttf_reader_manifest(opened.reader)->source, "f1.png to f10.png, 3 files");
    assert_int_equal(opened.sequence->n, 3);
    assert_true(opened.sequence->time_ns[2] == 2 * TTF_NS_PER_MIN);
    assert_true(shows(opened.sequence, 0, 1));
    assert_true(shows(opened.sequence, 1, 2));
    assert_true(shows(opened.sequence, 2, 10));
    assert_int_equal(ttf_export(opened.sequence, ttf_io_posix(), &out, NULL, NULL), 0);
    for (unsigned i = 0; i < 3; i++) {
        struct ttf_pixbuf a, b;

        assert_int_equal(ttf_image_read(ttf_io_posix(), inputs[2 - i], 0, &a, NULL, NULL), 0);
        assert_int_equal(ttf_image_read(ttf_io_posix(),
                                        in_folder(state, "out/frame.%u.png", 1001 + i), 0, &b, NULL,
                                        NULL),
                         0);
        assert_true(same_pixels(&a, &b));
        ttf_pixbuf_free(&a);
        ttf_pixbuf_free(&b);
    }
    close_dataset(&opened);
}

static void a_dataset_satisfies_sha256sum(void **state)
{
    const char *const inputs[] = {in_folder(state, "a.png"), in_folder(state, "b.png")};
    struct ttf_import_config config = {.inputs = inputs,
                                       .n_inputs = 2,
                                       .output = in_folder(state, "data"),
                                       .interval_ns = TTF_NS_PER_MIN};
    char text[4096];
    char command[600];

    picture_file(inputs[0], W, H, 10);
    picture_file(inputs[1], W, H, 2);
    import_ok(ttf_io_posix(), &config);
    snprintf(command, sizeof(command), "cd %s && sha256sum --strict -c SHA256SUMS", config.output);
    if (run_program((const char *const[]){"sh", "-c", command, NULL}, text, sizeof(text)))
        fail_msg("%s", text);
    assert_non_null(strstr(text, "dataset.json: OK"));
    assert_int_equal(count_entries(in_folder(state, ".")), 3);
}

static void times_in_names_put_pictures_on_the_grid_with_missed_slots(void **state)
{
    const char *const inputs[] = {in_folder(state, "b_2020-05-30_18-00_R.png"),
                                  in_folder(state, "a_2020-05-28_18-20_U.png"),
                                  in_folder(state, "c_2020-06-01_08-30_R.png")};
    struct ttf_import_config config = {.inputs = inputs,
                                       .n_inputs = 3,
                                       .output = in_folder(state, "data"),
                                       .order = TTF_IMPORT_NAME_TIME,
                                       .zone_offset_s = -6 * 3600,
                                       .interval_ns = TTF_NS_PER_DAY};
    struct ttf_import_result result;
    struct ttf_slot_record record;
    struct ttf_segment segment;
    struct opened opened;

    for (unsigned i = 0; i < 3; i++)
        picture_file(inputs[i], W, H, i);
    result = import_ok(ttf_io_posix(), &config);
    assert_int_equal(result.frames, 3);
    assert_int_equal(result.missed, 2);
    opened = open_dataset(config.output);
    assert_int_equal(ttf_reader_summary(opened.reader)->slots, 5);
    assert_true(shows(opened.sequence, 0, 1));
    assert_int_equal(opened.sequence->index[1], 2);
    assert_int_equal(opened.sequence->index[2], 4);
    assert_int_equal(ttf_reader_slot(opened.reader, 3, &record, NULL), 0);
    assert_int_equal(record.result, TTF_RESULT_MISSED);
    assert_string_equal(record.reason, "no image in the source");
    ttf_slot_record_free(&record);
    assert_int_equal(ttf_reader_segment(opened.reader, 0, &segment), 0);
    /* 18:20 six hours west is 00:20 UTC on the next day */
    assert_true(segment.origin_utc_ns == INT64_C(1590690000) * TTF_NS_PER_S + 6 * TTF_NS_PER_H);
    assert_int_equal(ttf_reader_slot(opened.reader, 2, &record, NULL), 0);
    assert_true(record.middle_ns == 2 * TTF_NS_PER_DAY - 20 * TTF_NS_PER_MIN);
    ttf_slot_record_free(&record);
    close_dataset(&opened);
}

static void without_an_interval_timed_pictures_are_numbered_one_by_one(void **state)
{
    const char *const inputs[] = {
        in_folder(state, "050504_181349.png"), in_folder(state, "050504_181449.png"),
        in_folder(state, "050504_181549.png"), in_folder(state, "050504_191549.png")};
    struct ttf_import_config config = {.inputs = inputs,
                                       .n_inputs = 4,
                                       .output = in_folder(state, "data"),
                                       .order = TTF_IMPORT_NAME_TIME};
    struct ttf_import_result result;

    for (unsigned i = 0; i < 4; i++)
        picture_file(inputs[i], W, H, i);
    result = import_ok(ttf_io_posix(), &config);
    assert_int_equal(result.missed, 0);
    assert_true(result.interval_ns == TTF_NS_PER_MIN);
}

static void refused(void **state, struct ttf_import_config *config, int code, const char *where,
                    const char *what)
{
    struct ttf_err err = {0};
    int before = count_entries(in_folder(state, "."));

    assert_int_equal(ttf_import(ttf_io_posix(), config, NULL, &err), code);
    if (where)
        assert_string_equal(err.where, where);
    if (!strstr(err.what, what))
        fail_msg("'%s' does not say '%s'", err.what, what);
    assert_int_equal(count_entries(in_folder(state, ".")), before);
}

static void the_odd_picture_out_is_named_and_nothing_is_left(void **state)
{
    const char *const inputs[] = {in_folder(state, "1.png"), in_folder(state, "2.png"),
                                  in_folder(state, "3.png")};
    struct ttf_import_config config = {.inputs = inputs,
                                       .n_inputs = 3,
                                       .output = in_folder(state, "data"),
                                       .interval_ns = TTF_NS_PER_MIN};
    uint8_t *data;
    size_t n;

    picture_file(inputs[0], W, H, 1);
    picture_file(inputs[1], W, H, 2);
    picture_file(inputs[2], W + 1, H, 3);
    refused(state, &config, -EINVAL, inputs[2], "25 x 17");
    picture_file(inputs[2], W, H, 3);
    data = slurp(inputs[2], &n);
    write_bytes(inputs[2], data, n / 2);
    free(data);
    refused(state, &config, -TTF_EDAMAGED, inputs[2], "");
    remove(inputs[2]);
    refused(state, &config, -ENOENT, inputs[2], "");
    write_bytes(inputs[2], "text", 4);
    refused(state, &config, -ENOTSUP, inputs[2], "no PNG");
    config.n_inputs = 0;
    refused(state, &config, -EINVAL, NULL, "nothing");
}

static void colour_after_grey_is_refused_but_grey_after_colour_is_widened(void **state)
{
    const char *const inputs[] = {in_folder(state, "1.png"), in_folder(state, "2.png")};
    struct ttf_import_config config = {.inputs = inputs,
                                       .n_inputs = 2,
                                       .output = in_folder(state, "data"),
                                       .interval_ns = TTF_NS_PER_MIN};
    struct ttf_pixbuf grey = make_picture(W, H, 1, TTF_SAMPLE_U8, 1);
    struct opened opened;
    uint16_t *frame;

    save_png(inputs[0], &grey);
    picture_file(inputs[1], W, H, 2);
    refused(state, &config, -EINVAL, inputs[1], "colour");
    picture_file(inputs[0], W, H, 2);
    save_png(inputs[1], &grey);
    import_ok(ttf_io_posix(), &config);
    opened = open_dataset(config.output);
    frame = read_frame(opened.sequence, 1);
    assert_int_equal(frame[4], frame[3]);
    assert_int_equal(ttf_linear16_to_srgb8(frame[3]), ((uint8_t *)grey.data)[1]);
    free(frame);
    close_dataset(&opened);
    ttf_pixbuf_free(&grey);
}

static void missing_times_and_intervals_are_asked_for(void **state)
{
    const char *const inputs[] = {in_folder(state, "1.png"), in_folder(state, "2.png")};
    const char *const same[] = {in_folder(state, "050504_181349.png"),
                                in_folder(state, "050504_181350.png")};
    const char *const at_once[] = {in_folder(state, "a_050504_181349.png"),
                                   in_folder(state, "c_050504_181349.png"),
                                   in_folder(state, "b_050504_181349.png")};
    struct ttf_import_config config = {
        .inputs = inputs, .n_inputs = 2, .output = in_folder(state, "data")};

    for (unsigned i = 0; i < 2; i++) {
        picture_file(inputs[i], W, H, i);
        picture_file(same[i], W, H, i);
    }
    for (unsigned i = 0; i < 3; i++)
        picture_file(at_once[i], W, H, i);
    refused(state, &config, -EINVAL, NULL, "how long");
    config.order = TTF_IMPORT_NAME_TIME;
    config.inputs = at_once;
    config.n_inputs = 3;
    refused(state, &config, -EINVAL, at_once[0], "most pictures have the same time");
    config.inputs = inputs;
    config.n_inputs = 2;
    config.interval_ns = TTF_NS_PER_MIN;
    config.order = TTF_IMPORT_EXIF_TIME;
    refused(state, &config, -EINVAL, inputs[0], "when it was taken");
    config.order = TTF_IMPORT_NAME_TIME;
    refused(state, &config, -EINVAL, inputs[0], "file's name");
    config.inputs = same;
    refused(state, &config, -EINVAL, same[1], "same slot");
    config.interval_ns = 1;
    refused(state, &config, -EINVAL, NULL, "slots");
    config.interval_ns = -1;
    refused(state, &config, -EINVAL, NULL, "negative");
}

static void put_le(uint8_t *at, uint32_t value, unsigned bytes)
{
    for (unsigned i = 0; i < bytes; i++)
        at[i] = (uint8_t)(value >> 8 * i);
}

/* A TIFF file of so many grey pages of W x H, as microscopes write them; page k is of the code 20 k + 7. */
static void stack_file(const char *path, unsigned pages)
{
    const uint32_t tags[][3] = {{256, 4, W}, {257, 4, H}, {258, 3, 8}, {259, 3, 1},    {262, 3, 1},
                                {273, 4, 0}, {277, 3, 1}, {278, 4, H}, {279, 4, W * H}};
    const unsigned n_tags = sizeof(tags) / sizeof(*tags), page_bytes = 6 + 12 * n_tags + W * H;
    uint8_t *bytes = calloc(1, 8 + (size_t)pages * page_bytes);

    assert_non_null(bytes);
    memcpy(bytes, "II*", 4);
    put_le(bytes + 4, 8, 4);
    for (unsigned k = 0; k < pages; k++) {
        uint8_t *page = bytes + 8 + (size_t)k * page_bytes;
        uint32_t codes = 8 + k * page_bytes + 6 + 12 * n_tags;

        put_le(page, n_tags, 2);
        for (unsigned i = 0; i < n_tags; i++) {
            uint8_t *entry = page + 2 + 12 * (size_t)i;

            put_le(entry, tags[i][0], 2);
            put_le(entry + 2, tags[i][1], 2);
            put_le(entry + 4, 1, 4);
            put_le(entry + 8, tags[i][0] == 273 ? codes : tags[i][2], 4);
        }
        put_le(page + 2 + 12 * (size_t)n_tags, k + 1 < pages ? 8 + (k + 1) * page_bytes : 0, 4);
        memset(bytes + codes, (int)(20 * k + 7), W * H);
    }
    write_bytes(path, bytes, 8 + (size_t)pages * page_bytes);
    free(bytes);
}

static void pages_of_stacks_come_one_after_the_other(void **state)
{
    const char *const inputs[] = {in_folder(state, "s10.tif"), in_folder(state, "s9.tif")};
    struct ttf_import_config config = {.inputs = inputs,
                                       .n_inputs = 2,
                                       .output = in_folder(state, "data"),
                                       .interval_ns = TTF_NS_PER_S};
    struct ttf_import_result result;
    struct opened opened;

    stack_file(inputs[0], 4);
    stack_file(inputs[1], 2);
    result = import_ok(ttf_io_posix(), &config);
    assert_int_equal(result.frames, 6);
    opened = open_dataset(config.output);
    for (uint32_t t = 0; t < 6; t++) {
        uint16_t *frame = read_frame(opened.sequence, t);

        assert_int_equal(ttf_linear16_to_srgb8(frame[0]), 20 * (t < 2 ? t : t - 2) + 7);
        free(frame);
    }
    close_dataset(&opened);
    config.order = TTF_IMPORT_NAME_TIME;
    config.output = in_folder(state, "other");
    refused(state, &config, -EINVAL, inputs[0], "date");
}

static void times_that_lie_centuries_apart_are_refused_by_name(void **state)
{
    const char *const inputs[] = {in_folder(state, "21990101_000000.png"),
                                  in_folder(state, "19000101_000000.png")};
    struct ttf_import_config config = {.inputs = inputs,
                                       .n_inputs = 2,
                                       .output = in_folder(state, "data"),
                                       .order = TTF_IMPORT_NAME_TIME};

    for (unsigned i = 0; i < 2; i++)
        picture_file(inputs[i], W, H, i);
    refused(state, &config, -EINVAL, inputs[0], "292 years after 19000101_000000.png");
    config.interval_ns = TTF_NS_PER_DAY;
    refused(state, &config, -EINVAL, inputs[0], "292 years after 19000101_000000.png");
}

static void an_existing_dataset_is_left_alone(void **state)
{
    const char *const inputs[] = {in_folder(state, "1.png")};
    struct ttf_import_config config = {.inputs = inputs,
                                       .n_inputs = 1,
                                       .output = in_folder(state, "data"),
                                       .interval_ns = TTF_NS_PER_MIN};

    picture_file(inputs[0], W, H, 1);
    import_ok(ttf_io_posix(), &config);
    refused(state, &config, -EEXIST, config.output, "not empty");
}

static void an_origin_that_is_given_is_the_first_slots(void **state)
{
    const char *const inputs[] = {in_folder(state, "1.png")};
    const struct ttf_import_config config = {.inputs = inputs,
                                             .n_inputs = 1,
                                             .output = in_folder(state, "data"),
                                             .interval_ns = TTF_NS_PER_MIN,
                                             .origin_utc_ns = 1700000000 * TTF_NS_PER_S};
    struct ttf_segment segment;
    struct opened opened;

    picture_file(inputs[0], W, H, 1);
    import_ok(ttf_io_posix(), &config);
    opened = open_dataset(config.output);
    assert_int_equal(ttf_reader_segment(opened.reader, 0, &segment), 0);
    assert_true(segment.origin_utc_ns == config.origin_utc_ns);
    close_dataset(&opened);
}

static void a_region_is_cut_out(void **state)
{
    const char *const inputs[] = {in_folder(state, "1.png")};
    struct ttf_import_config config = {.inputs = inputs,
                                       .n_inputs = 1,
                                       .output = in_folder(state, "data"),
                                       .interval_ns = TTF_NS_PER_MIN,
                                       .region = {3, 2, 8, 5}};
    struct ttf_pixbuf want = make_picture(W, H, 3, TTF_SAMPLE_U8, 1);
    struct opened opened;
    uint16_t *frame;

    picture_file(inputs[0], W, H, 1);
    import_ok(ttf_io_posix(), &config);
    opened = open_dataset(config.output);
    assert_int_equal(opened.sequence->width, 8);
    assert_int_equal(opened.sequence->height, 5);
    frame = read_frame(opened.sequence, 0);
    assert_int_equal(ttf_linear16_to_srgb8(frame[1]),
                     ((uint8_t *)ttf_pixbuf_row(&want, 2))[3 * 3 + 1]);
    free(frame);
    close_dataset(&opened);
    config.output = in_folder(state, "other");
    config.region.width = W;
    refused(state, &config, -EINVAL, inputs[0], "region");
    ttf_pixbuf_free(&want);
}

static void a_video_comes_in_through_ffmpeg(void **state)
{
    const char *const inputs[] = {in_folder(state, "v.mkv")};
    struct ttf_import_config config = {
        .inputs = inputs, .n_inputs = 1, .output = in_folder(state, "data")};
    struct ttf_import_result result;
    struct opened opened;
    char text[512];
    int files;

    if (!have_program("ffprobe"))
        skip();
    for (unsigned i = 0; i < 4; i++)
        picture_file(in_folder(state, "v%u.png", i), W, H, i);
    assert_int_equal(run_program((const char *const[]){"ffmpeg", "-v", "error", "-framerate", "5",
                                                       "-i", in_folder(state, "v%%d.png"), "-c:v",
                                                       "ffv1", "-pix_fmt", "bgr0", inputs[0], NULL},
                                 text, sizeof(text)),
                     0);
    files = open_files();
    result = import_ok(ttf_io_posix(), &config);
    assert_int_equal(result.frames, 4);
    assert_true(result.interval_ns == TTF_NS_PER_S / 5);
    opened = open_dataset(config.output);
    for (unsigned t = 0; t < 4; t++)
        assert_true(shows(opened.sequence, t, t));
    close_dataset(&opened);
    assert_int_equal(open_files(), files);
    assert_int_equal(waitpid(-1, NULL, WNOHANG), -1);
    config.output = in_folder(state, "other");
    config.ffmpeg = "no-such-program-at-all";
    refused(state, &config, -ENOENT, "no-such-program-at-all", "started");
    config.ffmpeg = "false";
    refused(state, &config, -EPROTO, NULL, "exit code 1");
    config.ffmpeg = NULL;
    write_bytes(inputs[0], "this is not a film at all", 25);
    refused(state, &config, -ENOTSUP, inputs[0], "neither a picture nor a video");
    assert_int_equal(open_files(), files);
    assert_int_equal(waitpid(-1, NULL, WNOHANG), -1);
}

static int stop_at_two(void *ctx, int64_t done, int64_t total)
{
    assert_int_equal(total, 3);
    return done == 2;
}

static void a_stopped_import_leaves_nothing(void **state)
{
    const char *const inputs[] = {in_folder(state, "1.png"), in_folder(state, "2.png"),
                                  in_folder(state, "3.png")};
    struct ttf_import_config config = {.inputs = inputs,
                                       .n_inputs = 3,
                                       .output = in_folder(state, "data"),
                                       .interval_ns = TTF_NS_PER_MIN,
                                       .progress = stop_at_two};

    for (unsigned i = 0; i < 3; i++)
        picture_file(inputs[i], W, H, i);
    refused(state, &config, -ECANCELED, NULL, "stopped");
}

static int deny_some(void *ctx, const char *op, const char *path)
{
    int *left = ctx;

    if (strcmp(op, "unlink") == 0)
        return 0; /* clearing up is possible on a full disk */
    return (*left)-- <= 0 ? -ENOSPC : 0;
}

static void a_disk_that_fills_up_at_any_moment_leaves_nothing(void **state)
{
    const char *const inputs[] = {in_folder(state, "1.png"), in_folder(state, "2.png")};
    struct ttf_import_config config = {.inputs = inputs,
                                       .n_inputs = 2,
                                       .output = in_folder(state, "data"),
                                       .interval_ns = TTF_NS_PER_MIN};
    int code = -ENOSPC;

    for (unsigned i = 0; i < 2; i++)
        picture_file(inputs[i], W, H, i);
    for (int ops = 0; code && ops < 1000; ops++) {
        int left = ops;
        struct ttf_io *io = ttf_io_faulty_create(ttf_io_posix(), deny_some, &left);

        code = ttf_import(io, &config, NULL, NULL);
        ttf_io_faulty_destroy(io);
        /* Of the last steps it may be that all is in place and only the folder's sync failed. */
        if (code && exists(config.output)) {
            struct opened opened = open_dataset(config.output);

            assert_int_equal(opened.sequence->n, 2);
            close_dataset(&opened);
            break;
        }
        assert_int_equal(count_entries(in_folder(state, ".")), code ? 2 : 3);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
#define IN_FOLDER(f) cmocka_unit_test_setup_teardown(f, folder_setup, folder_teardown)
        cmocka_unit_test(names_sort_as_people_count),
        IN_FOLDER(pictures_come_back_to_the_bit_in_natural_order),
        IN_FOLDER(a_dataset_satisfies_sha256sum),
        IN_FOLDER(times_in_names_put_pictures_on_the_grid_with_missed_slots),
        IN_FOLDER(without_an_interval_timed_pictures_are_numbered_one_by_one),
        IN_FOLDER(the_odd_picture_out_is_named_and_nothing_is_left),
        IN_FOLDER(colour_after_grey_is_refused_but_grey_after_colour_is_widened),
        IN_FOLDER(missing_times_and_intervals_are_asked_for),
        IN_FOLDER(pages_of_stacks_come_one_after_the_other),
        IN_FOLDER(times_that_lie_centuries_apart_are_refused_by_name),
        IN_FOLDER(an_existing_dataset_is_left_alone),
        IN_FOLDER(an_origin_that_is_given_is_the_first_slots),
        IN_FOLDER(a_region_is_cut_out),
        IN_FOLDER(a_video_comes_in_through_ffmpeg),
        IN_FOLDER(a_stopped_import_leaves_nothing),
        IN_FOLDER(a_disk_that_fills_up_at_any_moment_leaves_nothing),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
