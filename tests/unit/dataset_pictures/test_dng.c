/* SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <tiffio.h>

#include "scratch.h"
#include "ttf/dataset/dng.h"
#include "ttf/dataset/tiff.h"

#define W 203
#define H 151

/* 2026-06-01T12:00:00.25Z */
#define START_UTC_NS INT64_C(1780315200250000000)

static void make_raw(struct ttf_raw_sum *raw, enum ttf_cfa cfa, unsigned n)
{
    static uint16_t codes[W * H];
    struct ttf_frame frame = {.format = {.width = W,
                                         .height = H,
                                         .stride = (size_t)W * 2,
                                         .packing = TTF_PACKING_RAW16,
                                         .cfa = cfa,
                                         .bits = 12,
                                         .black_level = 256,
                                         .white_level = 4095},
                              .data = codes,
                              .bytes = sizeof(codes),
                              .settings = {9998765, 1500, 1000, 1000, 42}};
    uint32_t seed = 99;

    assert_int_equal(ttf_raw_sum_init(raw, &frame.format), 0);
    for (unsigned k = 0; k < n; k++) {
        for (int i = 0; i < W * H; i++)
            codes[i] = (uint16_t)(scratch_random(&seed) % 4096);
        assert_int_equal(ttf_raw_sum_add(raw, &frame), 0);
    }
}

static struct ttf_dng_info make_info(bool simulated)
{
    return (struct ttf_dng_info){
        .model = "box camera",
        .serial = "0042",
        .software = "ttfbox 0.1.0",
        .times = {.start_utc_ns = START_UTC_NS, .zone_offset_s = 7200, .exposure_ns = 9998765},
        .neutral = {0.5, 1.0, 0.625},
        .simulated = simulated};
}

static void write_dng(void **state, const char *name, const struct ttf_raw_sum *raw,
                      const struct ttf_dng_info *info)
{
    struct ttf_io *io = ttf_io_posix();
    int file = scratch_create(state, name);
    struct ttf_err err = {0};

    if (ttf_dng_write(raw, info, io, file, &err) < 0)
        fail_msg("%s", err.what);
    assert_int_equal(io->ops->close(io, file), 0);
}

static void read_dng(void **state, const char *name, struct ttf_raw_sum *ret,
                     struct ttf_dng_info *ret_info)
{
    struct ttf_err err = {0};

    if (ttf_dng_read(ttf_io_posix(), scratch_path(state, name), ret, ret_info, &err) < 0)
        fail_msg("%s", err.what);
}

static void a_frame_comes_back_with_all_that_was_said_of_it(void **state)
{
    for (int cfa = TTF_CFA_NONE; cfa < TTF_CFA_COUNT; cfa++) {
        struct ttf_dng_info info = make_info(true), back_info;
        struct ttf_raw_sum raw, back;

        make_raw(&raw, (enum ttf_cfa)cfa, 1);
        write_dng(state, "a.dng", &raw, &info);
        read_dng(state, "a.dng", &back, &back_info);
        assert_int_equal(back.n, 1);
        assert_int_equal(back.format.width, W);
        assert_int_equal(back.format.height, H);
        assert_int_equal(back.format.cfa, cfa);
        assert_int_equal(back.format.bits, 12);
        assert_int_equal(back.format.black_level, 256);
        assert_int_equal(back.format.white_level, 4095);
        assert_memory_equal(raw.sum, back.sum, sizeof(uint32_t) * W * H);
        assert_memory_equal(&raw.settings, &back.settings, sizeof(raw.settings));
        assert_string_equal(back_info.model, "box camera");
        assert_string_equal(back_info.serial, "0042");
        assert_string_equal(back_info.software, "ttfbox 0.1.0");
        assert_true(back_info.simulated);
        assert_int_equal(back_info.times.start_utc_ns, START_UTC_NS);
        assert_int_equal(back_info.times.zone_offset_s, 7200);
        assert_int_equal(back_info.times.exposure_ns, 9998765);
        if (cfa != TTF_CFA_NONE)
            assert_float_equal(back_info.neutral[2], 0.625, 1e-6);
        ttf_raw_sum_free(&raw);
        ttf_raw_sum_free(&back);
    }
}

static void an_average_keeps_four_more_bits(void **state)
{
    struct ttf_dng_info info = make_info(false), back_info;
    struct ttf_raw_sum raw, back;

    make_raw(&raw, TTF_CFA_RGGB, 8);
    write_dng(state, "a.dng", &raw, &info);
    read_dng(state, "a.dng", &back, &back_info);
    assert_false(back_info.simulated);
    assert_int_equal(back.format.black_level, 256 * 16);
    assert_int_equal(back.format.white_level, 4095 * 16);
    for (int i = 0; i < W * H; i++)
        assert_int_equal(back.sum[i], (raw.sum[i] * 16 + 4) / 8);
    ttf_raw_sum_free(&raw);
    ttf_raw_sum_free(&back);
}

static void the_same_frame_gives_the_same_bytes_and_says_simulated(void **state)
{
    struct ttf_dng_info info = make_info(true);
    struct ttf_raw_sum raw;
    uint8_t *a, *b;
    size_t n_a, n_b;

    make_raw(&raw, TTF_CFA_RGGB, 1);
    write_dng(state, "a.dng", &raw, &info);
    write_dng(state, "b.dng", &raw, &info);
    a = scratch_read(state, "a.dng", &n_a);
    b = scratch_read(state, "b.dng", &n_b);
    assert_int_equal(n_a, n_b);
    assert_memory_equal(a, b, n_a);
    assert_true(n_a < sizeof(uint16_t) * W * H + 4096);
    assert_non_null(memmem(a, n_a, "box camera SIMULATED", 20));
    free(a);
    free(b);
    ttf_raw_sum_free(&raw);
}

static int complaints;

static void on_complaint(const char *module, const char *fmt, va_list args) TTF_PRINTF(2, 0);
static void on_complaint(const char *module, const char *fmt, va_list args)
{
    complaints++;
    (void)vfprintf(stderr, fmt, args);
    (void)fputc('\n', stderr);
}

static void libtiff_reads_it_without_a_warning(void **state)
{
    struct ttf_dng_info info = make_info(true);
    struct ttf_raw_sum raw;
    uint64_t exif = 0;
    TIFF *tiff;

    make_raw(&raw, TTF_CFA_RGGB, 1);
    write_dng(state, "a.dng", &raw, &info);
    ttf_raw_sum_free(&raw);
    complaints = 0;
    TIFFSetWarningHandler(on_complaint);
    TIFFSetErrorHandler(on_complaint);
    tiff = TIFFOpen(scratch_path(state, "a.dng"), "r");
    assert_non_null(tiff);
    assert_int_equal(TIFFGetField(tiff, TIFFTAG_EXIFIFD, &exif), 1);
    assert_int_equal(TIFFReadEXIFDirectory(tiff, exif), 1);
    TIFFClose(tiff);
    assert_int_equal(complaints, 0);
}

/* ---- others' programs as judges ---- */

static bool have(const char *program)
{
    char command[128];

    snprintf(command, sizeof(command), "command -v %s >/dev/null 2>&1", program);
    return system(command) == 0; /* NOLINT(cert-env33-c, concurrency-mt-unsafe): a fixed text */
}

/* Output of a command, zero-terminated, to be freed. */
static char *output_of(const char *command)
{
    FILE *pipe = popen(command, "r"); /* NOLINT(cert-env33-c): programs of fixed name */
    char *text = calloc(1, 65536);

    assert_non_null(pipe);
    assert_non_null(text);
    assert_true(fread(text, 1, 65535, pipe) < 65535);
    pclose(pipe);
    return text;
}

static void libraw_finds_the_very_codes_that_were_written(void **state)
{
    struct ttf_dng_info info = make_info(true);
    struct ttf_raw_sum raw;
    struct ttf_pixbuf seen;
    char command[1200], *text;

    if (!have("unprocessed_raw") || !have("raw-identify")) {
        print_message("unprocessed_raw or raw-identify (libraw-bin) is not installed\n");
        skip();
    }
    for (int cfa = TTF_CFA_RGGB; cfa < TTF_CFA_COUNT; cfa++) {
        static const char *const patterns[] = {
            "", "Filter pattern: RGGBRGGB", "Filter pattern: GRBGGRBG", "Filter pattern: GBRGGBRG",
            "Filter pattern: BGGRBGGR"};

        make_raw(&raw, (enum ttf_cfa)cfa, 1);
        write_dng(state, "a.dng", &raw, &info);
        snprintf(command, sizeof(command), "cd %s && unprocessed_raw -T a.dng >/dev/null 2>&1",
                 (const char *)*state);
        assert_int_equal(system(command), 0); /* NOLINT(cert-env33-c, concurrency-mt-unsafe) */
        assert_int_equal(
            ttf_tiff_read(ttf_io_posix(), scratch_path(state, "a.dng.tiff"), 0, &seen, NULL), 0);
        assert_int_equal(seen.width, W);
        assert_int_equal(seen.height, H);
        assert_int_equal(seen.format, TTF_SAMPLE_U16);
        for (uint32_t i = 0; i < W * H; i++)
            assert_int_equal(((uint16_t *)seen.data)[i], raw.sum[i]);
        ttf_pixbuf_free(&seen);
        ttf_raw_sum_free(&raw);

        snprintf(command, sizeof(command), "raw-identify -v %s 2>&1", scratch_path(state, "a.dng"));
        text = output_of(command);
        assert_non_null(strstr(text, "SIMULATED"));
        if (!strstr(text, patterns[cfa]))
            fail_msg("no '%s' in: %s", patterns[cfa], text);
        assert_non_null(strstr(text, "black: 256"));
        free(text);
    }
}

static void exiftool_agrees_on_times_and_levels(void **state)
{
    struct ttf_dng_info info = make_info(true);
    struct ttf_raw_sum raw;
    char command[1200], *text;

    if (!have("exiftool")) {
        print_message("exiftool is not installed\n");
        skip();
    }
    make_raw(&raw, TTF_CFA_GBRG, 1);
    write_dng(state, "a.dng", &raw, &info);
    ttf_raw_sum_free(&raw);
    snprintf(command, sizeof(command), "exiftool -s -n -a -validate -warning %s",
             scratch_path(state, "a.dng"));
    text = output_of(command);
    if (strstr(text, "Warning"))
        fail_msg("%s", text);
    free(text);
    snprintf(command, sizeof(command), "exiftool -s -n %s", scratch_path(state, "a.dng"));
    text = output_of(command);
    assert_non_null(strstr(text, "2026:06:01 14:00:00.250000000+02:00"));
    assert_non_null(strstr(text, "ExposureTime                    : 0.00999876"));
    assert_non_null(strstr(text, "BlackLevel                      : 256"));
    assert_non_null(strstr(text, "WhiteLevel                      : 4095"));
    assert_non_null(strstr(text, "ISO                             : 150"));
    assert_non_null(strstr(text, "box camera SIMULATED"));
    assert_non_null(strstr(text, "DNGVersion                      : 1 4 0 0"));
    free(text);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(a_frame_comes_back_with_all_that_was_said_of_it,
                                        scratch_make, scratch_remove),
        cmocka_unit_test_setup_teardown(an_average_keeps_four_more_bits, scratch_make,
                                        scratch_remove),
        cmocka_unit_test_setup_teardown(the_same_frame_gives_the_same_bytes_and_says_simulated,
                                        scratch_make, scratch_remove),
        cmocka_unit_test_setup_teardown(libtiff_reads_it_without_a_warning, scratch_make,
                                        scratch_remove),
        cmocka_unit_test_setup_teardown(libraw_finds_the_very_codes_that_were_written, scratch_make,
                                        scratch_remove),
        cmocka_unit_test_setup_teardown(exiftool_agrees_on_times_and_levels, scratch_make,
                                        scratch_remove),
    };

    return cmocka_run_group_tests_name("dng", tests, NULL, NULL);
}
