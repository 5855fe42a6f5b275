/* SPDX-License-Identifier: Apache-2.0 */
/* A program that is called ffmpeg and says or does something else: it is told, nothing is left, nobody waits for ever. */
#include "trade_test.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "ttf/dataset/export.h"
#include "ttf/dataset/import.h"

#define FILM    "printf 'pix_fmt=yuv420p\\nr_frame_rate=25/1\\navg_frame_rate=25/1\\n'"
#define ONE     "printf 'P6\\n2 1\\n255\\nabcdef'"
#define NOTHING "true"

static const char *script(void **state, const char *name, const char *body)
{
    const char *path = in_folder(state, "%s", name);
    char text[600];

    snprintf(text, sizeof(text), "#!/bin/sh\n%s\n", body);
    write_bytes(path, text, strlen(text));
    assert_int_equal(chmod(path, 0755), 0);
    return path;
}

static int import(void **state, const char *probe, const char *film, struct ttf_import_result *ret,
                  struct ttf_err *err)
{
    const char *const inputs[] = {in_folder(state, "film")};
    struct ttf_import_config config = {.inputs = inputs,
                                       .n_inputs = 1,
                                       .output = in_folder(state, "dataset"),
                                       .ffprobe = script(state, "ffprobe", probe),
                                       .ffmpeg = script(state, "ffmpeg", film)};

    write_bytes(inputs[0], "no film", 7);
    return ttf_import(ttf_io_posix(), &config, ret, err);
}

static void what_is_no_film_is_refused_and_leaves_nothing(void **state)
{
    static const struct {
        const char *probe, *film, *says;
        int code;
    } cases[] = {
        {NOTHING, ONE, "no moving picture", -ENOTSUP},
        {"echo broken >&2; exit 1", ONE, "neither a picture nor a video", -ENOTSUP},
        {FILM, NOTHING, "no frame in it", -EINVAL},
        {FILM, "printf 'P5\\n2 1\\n255\\nab'", "not understood", -EPROTO},
        {FILM, "printf 'P6'", "not understood", -EPROTO},
        {FILM, "printf 'P6\\nx 1\\n255\\nabcdef'", "not understood", -EPROTO},
        {FILM, "printf 'P6\\n2,1\\n255\\nabcdef'", "not understood", -EPROTO},
        {FILM, "printf 'P6\\n123456789 1\\n255\\n'", "not understood", -EPROTO},
        {FILM, "printf 'P6\\n0 1\\n255\\n'", "not understood", -EPROTO},
        {FILM, "printf 'P6\\n2 0\\n255\\n'", "not understood", -EPROTO},
        {FILM, "printf 'P6\\n2 1\\n254\\nabcdef'", "not understood", -EPROTO},
        {FILM, "printf 'P6\\n2 1\\n255\\nabc'", "in the middle of a frame", -EPROTO},
        {FILM, "printf 'P6\\n99999 99999\\n255\\n'", "", -EFBIG},
        {FILM, ONE "; echo the tape tore >&2; exit 3", "the tape tore", -EPROTO},
        {FILM, ONE "; kill -9 $$", "signal 9", -EPROTO},
        /* More than is kept of what it says: its end is told. */
        {FILM,
         ONE "; i=0; while [ $i -lt 400 ]; do echo 'a line of complaint' >&2; i=$((i+1)); "
             "done; echo the last word >&2; exit 1",
         "the last word", -EPROTO},
    };

    for (unsigned i = 0; i < TTF_COUNT_OF(cases); i++) {
        struct ttf_import_result result;
        struct ttf_err err = {0};
        int code = import(state, cases[i].probe, cases[i].film, &result, &err);

        if (code != cases[i].code || !strstr(err.what, cases[i].says))
            fail_msg("case %u: %d: %s", i, code, err.what);
        assert_false(exists(in_folder(state, "dataset")));
    }
}

static void a_program_that_is_not_there_is_named(void **state)
{
    const char *const inputs[] = {in_folder(state, "film")};
    struct ttf_import_config config = {.inputs = inputs,
                                       .n_inputs = 1,
                                       .output = in_folder(state, "dataset"),
                                       .ffprobe = in_folder(state, "nowhere")};
    struct ttf_import_result result;
    struct ttf_err err = {0};

    write_bytes(inputs[0], "no film", 7);
    assert_true(ttf_import(ttf_io_posix(), &config, &result, &err) < 0);
    assert_non_null(strstr(err.where[0] ? err.where : err.what, "nowhere"));
    assert_false(exists(config.output));
}

static void frames_come_in_8_and_16_bits_and_at_the_films_rate(void **state)
{
    struct ttf_import_result result;
    struct ttf_err err = {0};

    if (import(state, FILM, ONE "; " ONE, &result, &err) != 0)
        fail_msg("%s: %s", err.where, err.what);
    assert_int_equal(result.frames, 2);
    assert_true(result.width == 2 && result.height == 1);
    assert_int_equal(result.interval_ns, 40 * TTF_NS_PER_MS);
    assert_int_equal(
        run_program((const char *const[]){"rm", "-rf", in_folder(state, "dataset"), NULL},
                    (char[8]){0}, 8),
        0);
    if (import(state, "printf 'pix_fmt=yuv420p10le\\nr_frame_rate=10/1\\nno such\\n'",
               "printf 'P6\\n2 1\\n65535\\nabcdefabcdef'", &result, &err) != 0)
        fail_msg("%s: %s", err.where, err.what);
    assert_int_equal(result.frames, 1);
    assert_int_equal(result.interval_ns, 100 * TTF_NS_PER_MS);
}

#define IN_16_BITS "case \"$*\" in *rgb48be*) ;; *) echo asked for 8 bits >&2; exit 1 ;; esac; " ONE
#define IN_8_BITS  "case \"$*\" in *rgb24*) ;; *) echo asked for 16 bits >&2; exit 1 ;; esac; " ONE

static void samples_of_more_than_8_bits_are_asked_for_in_16(void **state)
{
    static const char *const deep[] = {"yuv420p10le", "yuv444p9be", "gray9le",   "gray12le",
                                       "gbrp14le",    "rgb48le",    "rgba64be",  "p010le",
                                       "x2rgb10le",   "gbrpf32le",  "grayf32be", "gbrapf32le"};
    static const char *const shallow[] = {"yuv420p", "yuv410p", "nv12", "nv16", "gray", "rgb24"};

    for (unsigned i = 0; i < TTF_COUNT_OF(deep) + TTF_COUNT_OF(shallow); i++) {
        bool is_deep = i < TTF_COUNT_OF(deep);
        const char *format = is_deep ? deep[i] : shallow[i - TTF_COUNT_OF(deep)];
        struct ttf_import_result result;
        struct ttf_err err = {0};
        char probe[100];

        snprintf(probe, sizeof(probe), "printf 'pix_fmt=%s\\nr_frame_rate=25/1\\n'", format);
        if (import(state, probe, is_deep ? IN_16_BITS : IN_8_BITS, &result, &err) != 0)
            fail_msg("%s: %s", format, err.what);
        assert_int_equal(
            run_program((const char *const[]){"rm", "-rf", in_folder(state, "dataset"), NULL},
                        (char[8]){0}, 8),
            0);
    }
}

/* Of uneven frames the average is a large fraction, and the other rate the unit that their times are told in. */
static void the_average_rate_is_a_films_however_large_its_numbers(void **state)
{
    static const struct {
        const char *rates;
        int64_t interval_ns;
    } films[] = {
        {"r_frame_rate=90000/1\\navg_frame_rate=8100000/2984813", 368495432},
        {"r_frame_rate=1000000/1\\navg_frame_rate=2147483640/2147483647", 1000000003},
        {"r_frame_rate=90000/1\\navg_frame_rate=1/2000000000", 2000000000 * TTF_NS_PER_S},
        {"r_frame_rate=24000/1001\\navg_frame_rate=0/0", 41708333},
    };

    for (unsigned i = 0; i < TTF_COUNT_OF(films); i++) {
        struct ttf_import_result result;
        struct ttf_err err = {0};
        char probe[200];

        snprintf(probe, sizeof(probe), "printf 'pix_fmt=yuv420p\\n%s\\n'", films[i].rates);
        if (import(state, probe, ONE "; " ONE, &result, &err) != 0)
            fail_msg("%s: %s: %s", films[i].rates, err.where, err.what);
        assert_int_equal(result.interval_ns, films[i].interval_ns);
        assert_int_equal(
            run_program((const char *const[]){"rm", "-rf", in_folder(state, "dataset"), NULL},
                        (char[8]){0}, 8),
            0);
    }
}

static void a_film_of_no_rate_needs_an_interval(void **state)
{
    static const char *const rates[] = {"0/0", "25", "x", "-1/1", "25/0", "99999999/1"};
    struct ttf_import_result result;

    for (unsigned i = 0; i < TTF_COUNT_OF(rates); i++) {
        char probe[100];

        snprintf(probe, sizeof(probe), "printf 'pix_fmt=nv12\\nr_frame_rate=%s\\n'", rates[i]);
        assert_int_equal(import(state, probe, ONE, &result, NULL), -EINVAL);
        assert_false(exists(in_folder(state, "dataset")));
    }
}

static void an_export_whose_program_fails_leaves_nothing(void **state)
{
    static const char *const bodies[] = {
        "exit 1",                                /* at once: nobody reads the frames */
        "cat >/dev/null; echo full >&2; exit 1", /* after them */
        "cat >/dev/null",                        /* says that it went well, and made nothing */
        "kill -9 $$",
    };
    static const uint16_t frames[3 * 40 * 30 * 3];
    const struct ttf_encoding plain = {.scale = 65535};
    struct ttf_sequence *s = NULL;

    assert_int_equal(ttf_sequence_of_memory(frames, 40, 30, 3, &plain, &s, NULL), 0);
    for (unsigned i = 0; i < 2 * TTF_COUNT_OF(bodies); i++) {
        struct ttf_export_config config = {.kind = i % 2 ? TTF_EXPORT_GIF : TTF_EXPORT_MP4,
                                           .output = in_folder(state, "film.out"),
                                           .ffmpeg = script(state, "ffmpeg", bodies[i / 2])};
        int before = count_entries(in_folder(state, ".")), code;
        struct ttf_err err = {0};

        code = ttf_export(s, ttf_io_posix(), &config, NULL, &err);
        if (code >= 0 || err.what[0] == '\0')
            fail_msg("%s: %d: %s", bodies[i / 2], code, err.what);
        assert_false(exists(config.output));
        assert_int_equal(count_entries(in_folder(state, ".")), before);
    }
    ttf_sequence_destroy(s);
}

#define T(test) cmocka_unit_test_setup_teardown(test, folder_setup, folder_teardown)

int main(void)
{
    const struct CMUnitTest tests[] = {
        T(what_is_no_film_is_refused_and_leaves_nothing),
        T(a_program_that_is_not_there_is_named),
        T(frames_come_in_8_and_16_bits_and_at_the_films_rate),
        T(samples_of_more_than_8_bits_are_asked_for_in_16),
        T(the_average_rate_is_a_films_however_large_its_numbers),
        T(a_film_of_no_rate_needs_an_interval),
        T(an_export_whose_program_fails_leaves_nothing),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
