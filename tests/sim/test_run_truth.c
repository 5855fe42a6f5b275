/* SPDX-License-Identifier: Apache-2.0 */
/* What a capture yields against what was there, and twice the same from the same seed. */
#include "cmocka_includes.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "sim_run.h"
#include "ttf/capture/guided_calibration.h"
#include "ttf/dataset/sequence.h"

static void sharp_and_straight(struct sim_run *run)
{
    run->config.width = 512;
    run->config.height = 384;
    run->config.perspective = 0;
    run->config.blur_px = 0;
    run->plan.lamps = TTF_LAMPS_CONTINUOUS;
    run->plan.settle_ns = 0; /* as long as the lamps say: five minutes */
    run->plan.interval_ns = 20 * TTF_NS_PER_MIN;
    run->plan.count = 3;
    run->plan.shots[0].n_levels = 2;
    strcpy(run->plan.shots[0].levels[1].lamp, "right");
    run->plan.shots[0].levels[1].permille = 1000;
}

/* Dark and flat of this box, taken with its plan's shot, saved beside the dataset. */
static void calibrate(struct sim_run *run, char *folder, size_t size)
{
    struct ttf_sim_config even = run->config;
    struct ttf_calibration calibration;
    struct ttf_scene white;
    struct ttf_box box;
    struct ttf_guided_config config = {
        .box = &box, .shot = &run->plan.shots[0], .mains_hz = 50, .frames = 64, .reflectance = 0.9};
    struct ttf_err err = {0};
    int r;

    /* The target fills the frame. */
    even.margin_reflectance = 0.9;
    ttf_calibration_init(&calibration);
    assert_int_equal(ttf_scene_procedural("white", 1, TTF_NS_PER_DAY, &white, NULL), 0);
    assert_int_equal(ttf_sim_box_create(&even, &white, &box, NULL), 0);
    r = ttf_guided_dark(&config, &calibration, &err);
    if (r == 0)
        r = ttf_guided_flat(&config, &calibration, &err);
    if (r < 0)
        print_error("calibration: %s: %s\n", err.where, err.what);
    assert_int_equal(r, 0);
    assert_true(calibration.simulated);
    assert_int_equal(calibration.dark_frames, 64);
    assert_int_equal(calibration.flat_frames, 64);
    ttf_box_destroy(&box);
    snprintf(folder, size, "%s/calibration", run->folder);
    assert_int_equal(ttf_calibration_save(&calibration, ttf_io_posix(), folder, &err), 0);
    ttf_calibration_free(&calibration);
}

/* The sample's rectangle in the frame. */
static struct ttf_region sample_of(const struct ttf_box *box)
{
    double corners[4][2];

    assert_int_equal(ttf_sim_corners(box, corners), 0);
    return (struct ttf_region){(uint32_t)lround(corners[0][0]), (uint32_t)lround(corners[0][1]),
                               (uint32_t)lround(corners[2][0] - corners[0][0]),
                               (uint32_t)lround(corners[2][1] - corners[0][1])};
}

/* Mean absolute difference of one developed frame and the truth behind it, over the sample. */
static double error_of(const struct ttf_box *box, struct ttf_sequence *seq, uint32_t t,
                       int64_t middle_ns)
{
    struct ttf_region s = sample_of(box);
    float *truth = malloc((size_t)s.width * s.height * 3 * sizeof(*truth));
    uint16_t *codes = malloc((size_t)seq->width * seq->height * 3 * sizeof(*codes));
    double sum = 0;

    assert_non_null(truth);
    assert_non_null(codes);
    assert_int_equal(ttf_sim_truth(box, middle_ns, s.width, s.height, truth, NULL), 0);
    assert_int_equal(ttf_sequence_read_rows(seq, t, 0, seq->height, codes, NULL), 0);
    for (uint32_t y = 0; y < s.height; y++) {
        for (uint32_t x = 0; x < s.width * 3; x++) {
            size_t at = ((size_t)(s.y + y) * seq->width + s.x) * 3 + x;
            double value = (codes[at] - seq->encoding.pedestal) / seq->encoding.scale;

            sum += fabs(value - (double)truth[(size_t)y * s.width * 3 + x]);
        }
    }
    free(truth);
    free(codes);
    return sum / ((double)s.width * s.height * 3);
}

static double worst_error;

static void compare_with_truth(struct sim_run *run)
{
    struct ttf_reader *reader;
    struct ttf_sequence *seq;

    worst_error = 0;
    assert_int_equal(ttf_reader_open(ttf_io_posix(), run->path, &reader, NULL), 0);
    assert_int_equal(ttf_sequence_of_dataset(reader, NULL, &seq, NULL), 0);
    assert_int_equal(seq->n, run->plan.count);
    for (uint32_t t = 0; t < seq->n; t++) {
        struct ttf_slot_record record;
        double error;

        sim_run_record(run, t, &record);
        error = error_of(run->box, seq, t, record.middle_ns);
        if (error > worst_error)
            worst_error = error;
        ttf_slot_record_free(&record);
    }
    ttf_sequence_destroy(seq);
    ttf_reader_close(reader);
}

static void a_calibrated_capture_shows_what_was_there(void **state)
{
    /* Not "snow": its flakes are single pixels, which no mosaic sensor can tell apart. */
    static const char *const scenes[] = {"copper", "banana", "paint"};

    (void)state;
    for (unsigned i = 0; i < 3; i++) {
        struct sim_run run;
        char calibration[128];

        sim_run_init(&run);
        sharp_and_straight(&run);
        calibrate(&run, calibration, sizeof(calibration));
        run.calibration = calibration;
        run.scene = scenes[i];
        run.scene_span_ns = TTF_NS_PER_H;
        run.at_end = compare_with_truth;
        assert_int_equal(sim_run_boot(&run), 0);
        print_message("%s: mean absolute error %.4f of full scale\n", scenes[i], worst_error);
        assert_true(worst_error < 0.02);
        assert_true(worst_error > 0); /* noise is there: the comparison is not of nothing */
        sim_run_expect_whole(&run, true);
        sim_run_finish(&run);
    }
}

static void without_calibration_the_same_comparison_fails(void **state)
{
    struct sim_run run;

    (void)state;
    sim_run_init(&run);
    sharp_and_straight(&run);
    run.scene = "copper";
    run.scene_span_ns = TTF_NS_PER_H;
    run.at_end = compare_with_truth;
    assert_int_equal(sim_run_boot(&run), 0);
    assert_true(worst_error > 0.02);
    sim_run_finish(&run);
}

static void a_flat_that_is_saturated_is_refused_with_a_reason(void **state)
{
    struct sim_run run;
    struct ttf_calibration calibration;
    struct ttf_scene white;
    struct ttf_box box;
    struct ttf_guided_config config = {
        .box = &box, .mains_hz = 50, .frames = 4, .reflectance = 0.9};
    struct ttf_err err = {0};

    (void)state;
    sim_run_init(&run);
    run.plan.shots[0].exposure.exposure_ns = TTF_NS_PER_S;
    config.shot = &run.plan.shots[0];
    ttf_calibration_init(&calibration);
    assert_int_equal(ttf_scene_procedural("white", 1, TTF_NS_PER_DAY, &white, NULL), 0);
    assert_int_equal(ttf_sim_box_create(&run.config, &white, &box, NULL), 0);
    assert_true(ttf_guided_flat(&config, &calibration, &err) < 0);
    assert_non_null(strstr(err.what, "saturat"));
    ttf_box_destroy(&box);
    ttf_calibration_free(&calibration);
    sim_run_finish(&run);
}

static int64_t free_bytes;

static void say_room(void *ctx, const char *path, struct ttf_io_space *space)
{
    (void)ctx;
    (void)path;
    space->free_bytes = free_bytes;
}

/* The disk is full before it begins: it says so with the figures, and takes no time over it. */
static void a_calibration_without_room_is_not_begun(void **state)
{
    struct sim_run run;
    struct ttf_calibration calibration;
    struct ttf_scene white;
    struct ttf_box box;
    struct ttf_guided_config config = {
        .box = &box, .mains_hz = 50, .frames = 4, .reflectance = 0.9};
    struct ttf_err err = {0};
    char path[300];
    int64_t begun_ns;

    (void)state;
    sim_run_init(&run);
    config.shot = &run.plan.shots[0];
    config.io = ttf_io_faulty_create(ttf_io_posix(), NULL, NULL);
    assert_non_null(config.io);
    ttf_io_faulty_space(config.io, say_room);
    snprintf(path, sizeof(path), "%s/calibrations/new", run.folder);
    config.folder = path;
    ttf_calibration_init(&calibration);
    assert_int_equal(ttf_scene_procedural("white", 1, TTF_NS_PER_DAY, &white, NULL), 0);
    assert_int_equal(ttf_sim_box_create(&run.config, &white, &box, NULL), 0);
    begun_ns = ttf_clock_now_ns(box.clock);
    free_bytes = 100000;
    assert_int_equal(ttf_guided_flat(&config, &calibration, &err), -ENOSPC);
    assert_non_null(strstr(err.what, "0.1 MB are free"));
    assert_false(calibration.has_flat);
    assert_true(ttf_clock_now_ns(box.clock) - begun_ns < TTF_NS_PER_S); /* no lamp was lit */
    free_bytes = 100000000;
    assert_int_equal(ttf_guided_dark(&config, &calibration, &err), 0);
    ttf_box_destroy(&box);
    ttf_calibration_free(&calibration);
    ttf_io_faulty_destroy(config.io);
    sim_run_finish(&run);
}

static void the_same_seed_gives_the_same_frames(void **state)
{
    struct sim_run a;
    struct sim_run b;
    struct sim_run c;

    (void)state;
    sim_run_init(&a);
    sim_run_init(&b);
    sim_run_init(&c);
    /* Faults and retries included. */
    sim_run_fault(&a, TTF_FAULT_FRAME_CORRUPT, 0)->rate_per_million = 200000;
    sim_run_fault(&b, TTF_FAULT_FRAME_CORRUPT, 0)->rate_per_million = 200000;
    a.plan.count = b.plan.count = c.plan.count = 10;
    c.config.seed = 2;
    assert_int_equal(sim_run_boot(&a), 0);
    assert_int_equal(sim_run_boot(&b), 0);
    assert_int_equal(sim_run_boot(&c), 0);
    for (int64_t k = 0; k < 10; k++) {
        struct ttf_slot_record ra;
        struct ttf_slot_record rb;
        struct ttf_slot_record rc;

        sim_run_record(&a, k, &ra);
        sim_run_record(&b, k, &rb);
        sim_run_record(&c, k, &rc);
        assert_int_equal(ra.images[0].n_files, rb.images[0].n_files);
        for (unsigned f = 0; f < ra.images[0].n_files; f++) {
            assert_string_equal(ra.images[0].files[f].sha256, rb.images[0].files[f].sha256);
            assert_string_not_equal(ra.images[0].files[f].sha256, rc.images[0].files[f].sha256);
        }
        assert_true(ra.middle_ns == rb.middle_ns);
        ttf_slot_record_free(&ra);
        ttf_slot_record_free(&rb);
        ttf_slot_record_free(&rc);
    }
    sim_run_finish(&a);
    sim_run_finish(&b);
    sim_run_finish(&c);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_calibrated_capture_shows_what_was_there),
        cmocka_unit_test(without_calibration_the_same_comparison_fails),
        cmocka_unit_test(a_flat_that_is_saturated_is_refused_with_a_reason),
        cmocka_unit_test(a_calibration_without_room_is_not_begun),
        cmocka_unit_test(the_same_seed_gives_the_same_frames),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
