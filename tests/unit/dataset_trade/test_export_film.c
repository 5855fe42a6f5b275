/* SPDX-License-Identifier: Apache-2.0 */
/* Films: what players show of them, and what is left where ffmpeg or the disk fails. */
#include "exported.h"

#include <errno.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/wait.h>

#define W 31 /* odd, as 4:2:0 does not like it */
#define H 18

static struct ttf_sequence *film_of(const uint16_t *frames, uint32_t n)
{
    struct ttf_sequence *s;

    assert_int_equal(ttf_sequence_of_memory(frames, W, H, n, &plain_light, &s, NULL), 0);
    return s;
}

/* Frames of a video as 8-bit RGB, by ffmpeg itself. */
static uint8_t *decode(void **state, const char *video, size_t *ret_bytes)
{
    const char *raw = in_folder(state, "decoded.rgb");
    char text[512];

    remove(raw);
    assert_int_equal(
        run_program((const char *const[]){"ffmpeg", "-v", "error", "-i", video, "-pix_fmt", "rgb24",
                                          "-sws_flags", "accurate_rnd+full_chroma_int", "-vsync",
                                          "passthrough", "-f", "rawvideo", raw, NULL},
                    text, sizeof(text)),
        0);
    return slurp(raw, ret_bytes);
}

static void y4m_is_what_ffmpeg_reads_in_right_colours(void **state)
{
    uint16_t frames[3 * W * H * 3] = {0};
    struct ttf_sequence *s = film_of(frames, 3);
    struct ttf_export_config config = {
        .kind = TTF_EXPORT_Y4M, .output = in_folder(state, "a.y4m"), .fps_num = 10};
    char text[512];
    uint8_t *rgb;
    size_t n;

    if (!have_program("ffprobe") || !have_program("ffmpeg"))
        skip();
    fill_noise(frames, W, H, 3);
    export_ok(s, &config);
    assert_int_equal(
        run_program((const char *const[]){"ffprobe", "-v", "error", "-count_frames",
                                          "-show_entries",
                                          "stream=width,height,pix_fmt,r_frame_rate,nb_read_frames",
                                          "-of", "csv=p=0", in_folder(state, "a.y4m"), NULL},
                    text, sizeof(text)),
        0);
    assert_non_null(strstr(text, "31,18,yuv444p,10/1,3"));
    rgb = decode(state, in_folder(state, "a.y4m"), &n);
    assert_int_equal(n, sizeof(frames) / 2);
    for (size_t i = 0; i < n; i++)
        assert_true(abs(rgb[i] - ttf_linear16_to_srgb8(frames[i])) <= 4);
    free(rgb);
    config.chroma = 420;
    export_ok(s, &config); /* over the old one */
    rgb = decode(state, in_folder(state, "a.y4m"), &n);
    assert_int_equal(n, sizeof(frames) / 2);
    free(rgb);
    ttf_sequence_destroy(s);
}

static void mp4_plays_everywhere_and_shows_the_right_colours(void **state)
{
    uint16_t frames[3 * W * H * 3] = {0};
    struct ttf_sequence *s = film_of(frames, 3);
    struct ttf_export_config config = {.kind = TTF_EXPORT_MP4, .output = in_folder(state, "a.mp4")};
    static const uint8_t colour[3] = {180, 90, 40};
    struct ttf_export_result result;
    char text[512];
    uint8_t *rgb;
    size_t n;

    if (!have_program("ffprobe") || !have_program("ffmpeg"))
        skip();
    for (size_t i = 0; i < sizeof(frames) / 2; i++)
        frames[i] = ttf_srgb8_to_linear16(colour[i % 3]);
    result = export_ok(s, &config);
    assert_int_equal(result.frames, 3);
    assert_int_equal(run_program(
                         (const char *const[]){
                             "ffprobe", "-v", "error", "-count_frames", "-show_entries",
                             "stream=codec_name,width,height,pix_fmt,color_space,nb_read_frames",
                             "-of", "csv=p=0", in_folder(state, "a.mp4"), NULL},
                         text, sizeof(text)),
                     0);
    assert_non_null(strstr(text, "h264,32,18,yuv420p,bt709,3"));
    rgb = decode(state, in_folder(state, "a.mp4"), &n);
    assert_int_equal(n, 3 * 32 * 18 * 3);
    for (size_t i = 0; i < n; i++)
        assert_true(abs(rgb[i] - colour[i % 3]) <= 4);
    free(rgb);
    assert_int_equal(waitpid(-1, NULL, WNOHANG), -1); /* no child is left */
    ttf_sequence_destroy(s);
}

static void gif_holds_all_frames_and_leaves_no_palette_behind(void **state)
{
    uint16_t frames[5 * W * H * 3] = {0};
    struct ttf_sequence *s = film_of(frames, 5);
    struct ttf_export_config config = {.kind = TTF_EXPORT_GIF, .output = in_folder(state, "a.gif")};
    char text[512];

    if (!have_program("ffprobe") || !have_program("ffmpeg"))
        skip();
    fill_noise(frames, W, H, 5);
    export_ok(s, &config);
    assert_int_equal(
        run_program((const char *const[]){"ffprobe", "-v", "error", "-count_frames",
                                          "-show_entries",
                                          "stream=codec_name,width,height,nb_read_frames", "-of",
                                          "csv=p=0", in_folder(state, "a.gif"), NULL},
                    text, sizeof(text)),
        0);
    assert_non_null(strstr(text, "gif,31,18,5"));
    assert_int_equal(count_entries(in_folder(state, ".")), 2);
    ttf_sequence_destroy(s);
}

static void a_missing_or_failing_ffmpeg_is_told_and_leaves_nothing(void **state)
{
    uint16_t frames[9 * W * H * 3] = {0};
    struct ttf_sequence *s = film_of(frames, 9);
    struct ttf_export_config config = {.kind = TTF_EXPORT_MP4,
                                       .output = in_folder(state, "a.mp4"),
                                       .ffmpeg = "no-such-program-at-all"};
    struct ttf_err err = {0};
    int files = open_files();

    fill_noise(frames, W, H, 9);
    assert_int_equal(ttf_export(s, ttf_io_posix(), &config, NULL, &err), -ENOENT);
    assert_non_null(strstr(err.hint, "install ffmpeg"));
    config.ffmpeg = "false"; /* ends at once, reading nothing */
    err = (struct ttf_err){0};
    assert_int_equal(ttf_export(s, ttf_io_posix(), &config, NULL, &err), -EPROTO);
    assert_string_equal(err.where, "false");
    assert_int_equal(count_entries(in_folder(state, ".")), 0);
    assert_int_equal(open_files(), files);
    assert_int_equal(waitpid(-1, NULL, WNOHANG), -1);
    ttf_sequence_destroy(s);
}

static void the_words_of_a_failing_ffmpeg_reach_the_user(void **state)
{
    uint16_t frames[W * H * 3] = {0};
    struct ttf_sequence *s = film_of(frames, 1);
    struct ttf_export_config config = {.kind = TTF_EXPORT_MP4,
                                       .output = in_folder(state, "a.mp4"),
                                       .ffmpeg = in_folder(state, "fake")};
    static const char script[] = "#!/bin/sh\necho one >&2\necho disk of doom >&2\nexit 3\n";
    struct ttf_err err = {0};

    fill_noise(frames, W, H, 1);
    write_bytes(config.ffmpeg, script, sizeof(script) - 1);
    assert_int_equal(
        run_program((const char *const[]){"chmod", "+x", config.ffmpeg, NULL}, err.what, 64), 0);
    assert_int_equal(ttf_export(s, ttf_io_posix(), &config, NULL, &err), -EPROTO);
    assert_non_null(strstr(err.what, "disk of doom"));
    ttf_sequence_destroy(s);
}

static void limit_files(rlim_t bytes)
{
    struct rlimit limit;

    assert_int_equal(getrlimit(RLIMIT_FSIZE, &limit), 0);
    limit.rlim_cur = bytes < limit.rlim_max ? bytes : limit.rlim_max;
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &limit), 0);
}

/* What ffmpeg writes passes through no I/O table of ours: no file may become as large as a whole film, as on FAT. */
static void a_film_that_does_not_fit_leaves_nothing_behind(void **state)
{
    uint16_t frames[6 * W * H * 3] = {0};
    struct ttf_sequence *s = film_of(frames, 6);
    void (*before)(int) = signal(SIGXFSZ, SIG_IGN); /* so that writing says EFBIG, there too */

    if (!have_program("ffmpeg"))
        skip();
    fill_noise(frames, W, H, 6);
    for (int kind = TTF_EXPORT_MP4; kind <= TTF_EXPORT_GIF; kind++) {
        struct ttf_export_config config = {.kind = (enum ttf_export_kind)kind,
                                           .output = in_folder(state, "film")};
        size_t bytes;

        export_ok(s, &config);
        free(slurp(config.output, &bytes));
        remove(config.output);
        remove(in_folder(state, "film.json"));
        for (unsigned part = 1; part <= 2; part++) {
            struct ttf_err err = {0};
            int code;

            limit_files(part == 1 ? bytes / 2 : bytes - 1);
            code = ttf_export(s, ttf_io_posix(), &config, NULL, &err);
            limit_files(RLIM_INFINITY);
            if (code >= 0 || !strstr(err.what, "too large") || strstr(err.what, ".part-"))
                fail_msg("%s, part %u: %d: %s", ttf_export_kind_name(config.kind), part, code,
                         err.what);
            assert_int_equal(count_entries(in_folder(state, ".")), 0);
        }
    }
    signal(SIGXFSZ, before);
    ttf_sequence_destroy(s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
#define IN_FOLDER(f) cmocka_unit_test_setup_teardown(f, folder_setup, folder_teardown)
        IN_FOLDER(y4m_is_what_ffmpeg_reads_in_right_colours),
        IN_FOLDER(mp4_plays_everywhere_and_shows_the_right_colours),
        IN_FOLDER(gif_holds_all_frames_and_leaves_no_palette_behind),
        IN_FOLDER(a_missing_or_failing_ffmpeg_is_told_and_leaves_nothing),
        IN_FOLDER(the_words_of_a_failing_ffmpeg_reach_the_user),
        IN_FOLDER(a_film_that_does_not_fit_leaves_nothing_behind),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
