/* SPDX-License-Identifier: Apache-2.0 */
/* Real time-lapses, if they are there: TTFBOX_TEST_DATA, else ../shared/data. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "ttf/dataset/image_file.h"
#include "ttf/synth/run.h"

#define N       24u /* frames taken, every third one, behind copper's nudges */
#define PICTURE 256u
#define SIDE    128u /* of the crop, from the middle: a few seconds even under the thread sanitizer */

static const struct ttf_encoding encoding = {0.0, 65535.0};

static const char *data_root(void)
{
    /* NOLINTNEXTLINE(concurrency-mt-unsafe): read before there are threads */
    const char *set = getenv("TTFBOX_TEST_DATA");

    return set && *set ? set : TTF_SOURCE_DIR "/../shared/data";
}

static uint16_t *load(const char *name)
{
    const uint32_t corner = (PICTURE - SIDE) / 2;
    size_t samples = (size_t)SIDE * SIDE * 3;
    uint16_t *codes = malloc(N * samples * sizeof(*codes));
    char path[4096];

    assert_non_null(codes);
    for (uint32_t t = 0; t < N; t++) {
        struct ttf_pixbuf picture = {0};
        struct ttf_err err = {0};

        snprintf(path, sizeof(path), "%s/timelapse/%s/%03u.png", data_root(), name, 4 + 3 * t);
        if (t == 0 && access(path, R_OK) != 0) {
            printf("SKIPPED: %s is not there (set TTFBOX_TEST_DATA)\n", path);
            free(codes);
            return NULL;
        }
        if (ttf_image_read_linear(ttf_io_posix(), path, &picture, NULL, &err) < 0)
            fail_msg("%s: %s", err.where, err.what);
        assert_true(picture.width == PICTURE && picture.height == PICTURE);
        for (uint32_t y = 0; y < SIDE; y++)
            memcpy(codes + t * samples + (size_t)y * SIDE * 3,
                   (const uint16_t *)ttf_pixbuf_row(&picture, y + corner) + (size_t)corner * 3,
                   SIDE * 3 * sizeof(*codes));
        ttf_pixbuf_free(&picture);
    }
    return codes;
}

struct taker {
    uint16_t *codes;
    size_t frame;
};

static int take(void *ctx, uint32_t t, const uint16_t *codes, struct ttf_err *err)
{
    struct taker *taker = ctx;

    (void)err;
    memcpy(taker->codes + t * taker->frame, codes, taker->frame * sizeof(*codes));
    return 0;
}

static void quilt(struct ttf_sequence *input, bool per_frame, struct ttf_quilt_report *report,
                  struct ttf_quilt_check *check)
{
    struct ttf_quilt_config config;
    struct ttf_pool *pool = ttf_pool_create(0);
    struct ttf_sequence *output = NULL;
    struct ttf_err err = {0};
    struct taker taker;

    ttf_quilt_defaults(&config);
    config.width = config.height = 160;
    config.block_width = config.block_height = 40;
    config.per_frame = per_frame;
    taker.frame = (size_t)config.width * config.height * 3;
    taker.codes = malloc(input->n * taker.frame * sizeof(*taker.codes));
    assert_non_null(taker.codes);
    if (ttf_quilt_run(&config, input, pool, &(struct ttf_quilt_sink){.frame = take, .ctx = &taker},
                      report, NULL, &err) < 0)
        fail_msg("%s", err.what);
    assert_int_equal(ttf_sequence_of_memory(taker.codes, config.width, config.height, input->n,
                                            &encoding, &output, NULL),
                     0);
    assert_int_equal(
        ttf_quilt_verify(&(struct ttf_quilt_config){0}, input, output, NULL, check, NULL), 0);
    ttf_sequence_destroy(output);
    ttf_pool_destroy(pool);
    free(taker.codes);
}

static void real_timelapse(const char *name)
{
    uint16_t *codes = load(name);
    struct ttf_sequence *input = NULL, *start = NULL;
    struct ttf_quilt_report report;
    struct ttf_quilt_check check;

    if (!codes)
        skip();
    assert_int_equal(ttf_sequence_of_memory(codes, SIDE, SIDE, N, &encoding, &input, NULL), 0);
    quilt(input, false, &report, &check);
    assert_int_equal(check.unmatched, 0);
    assert_true(report.coherence_copied == 1.0);
    assert_true(report.coherence > 0.6 && report.coherence < 1.6);
    ttf_sequence_destroy(input);

    /* a few frames are enough to see the baseline fail */
    assert_int_equal(ttf_sequence_of_memory(codes, SIDE, SIDE, 6, &encoding, &start, NULL), 0);
    quilt(start, true, &report, &check);
    assert_true(check.unmatched > check.pixels / 2);
    assert_true(report.coherence > 2.0);
    ttf_sequence_destroy(start);
    free(codes);
}

static void copper_is_copied_whole_and_flickers_if_quilted_frame_by_frame(void **state)
{
    (void)state;
    real_timelapse("copper");
}

static void clay_is_copied_whole_and_flickers_if_quilted_frame_by_frame(void **state)
{
    (void)state;
    real_timelapse("clay");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(copper_is_copied_whole_and_flickers_if_quilted_frame_by_frame),
        cmocka_unit_test(clay_is_copied_whole_and_flickers_if_quilted_frame_by_frame),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
