/* SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <errno.h>
#include <pthread.h>
#include <stdlib.h>

#include "conformance.h"

#define MS TTF_NS_PER_MS

static const struct ttf_camera_mode native = {0};

static struct ttf_camera *camera_of(void **state)
{
    return ((struct ttf_box *)*state)->cameras[0].camera;
}

static struct ttf_clock *clock_of(void **state)
{
    return ((struct ttf_box *)*state)->clock;
}

static struct ttf_camera *streaming(void **state)
{
    struct ttf_camera *camera = camera_of(state);

    assert_int_equal(ttf_camera_configure(camera, &native, NULL, NULL), 0);
    assert_int_equal(ttf_camera_start(camera, NULL), 0);
    return camera;
}

static struct ttf_exposure of_ms(int64_t ms)
{
    return (struct ttf_exposure){
        .exposure_ns = ms * MS, .gain_milli = 1000, .wb_r_milli = 1000, .wb_b_milli = 1000};
}

static int submit(struct ttf_camera *camera, int64_t ms, unsigned n, int64_t middle_ns)
{
    struct ttf_exposure settings[TTF_CAMERA_SET_MAX];
    struct ttf_camera_set set = {.settings = settings, .n = n, .middle_ns = middle_ns};

    for (unsigned i = 0; i < n && i < TTF_CAMERA_SET_MAX; i++)
        settings[i] = of_ms(ms + i);
    return ttf_camera_submit(camera, &set, NULL);
}

static int64_t soon(void **state)
{
    return ttf_clock_now_ns(clock_of(state)) + 10 * TTF_NS_PER_S;
}

static void nothing_is_granted_before_configure(void **state)
{
    struct ttf_camera *camera = camera_of(state);

    assert_null(ttf_camera_format(camera));
    assert_int_equal(ttf_camera_start(camera, NULL), -EINVAL);
    assert_int_equal(submit(camera, 10, 1, 0), -EPIPE);
}

static void the_granted_format_is_possible(void **state)
{
    struct ttf_camera *camera = camera_of(state);
    struct ttf_frame_format f;
    const struct ttf_camera_caps *caps;

    assert_int_equal(ttf_camera_configure(camera, &native, &f, NULL), 0);
    assert_true(f.width > 0 && f.height > 0 && f.stride >= f.width);
    assert_true(f.packing > TTF_PACKING_NONE && f.packing < TTF_PACKING_COUNT);
    assert_true(f.bits >= 1 && f.bits <= 16 && f.white_level > f.black_level);
    caps = ttf_camera_caps(camera);
    if (caps->exposure_max_ns == 0) /* no such control */
        assert_true(caps->exposure_min_ns == 0);
    else
        assert_true(caps->exposure_min_ns > 0 && caps->exposure_max_ns >= caps->exposure_min_ns);
    assert_true(caps->buffers >= 2 && caps->frame_period_ns > 0 && caps->timing_bound_ns > 0);
    assert_true(caps->model[0] != '\0');
}

static void states_are_kept_apart(void **state)
{
    struct ttf_camera *camera = streaming(state);

    assert_int_equal(ttf_camera_configure(camera, &native, NULL, NULL), -EBUSY);
    assert_int_equal(ttf_camera_start(camera, NULL), -EALREADY);
    ttf_camera_stop(camera);
    ttf_camera_stop(camera);
    assert_int_equal(submit(camera, 10, 1, 0), -EPIPE);
    assert_int_equal(ttf_camera_start(camera, NULL), 0);
}

static void wrong_sets_are_refused(void **state)
{
    struct ttf_camera *camera = streaming(state);

    assert_int_equal(submit(camera, 10, 0, 0), -EINVAL);
    assert_int_equal(submit(camera, 10, TTF_CAMERA_SET_MAX + 1, 0), -EINVAL);
    if (ttf_camera_caps(camera)->exposure_max_ns > 0)
        assert_int_equal(submit(camera, 0, 1, 0), -EINVAL);
    assert_int_equal(submit(camera, -5, 1, 0), -EINVAL);
    assert_int_equal(submit(camera, 10, 1, TTF_NS_NEVER - 1), -EINVAL);
}

static void without_a_set_nothing_comes(void **state)
{
    struct ttf_camera *camera = streaming(state);
    struct ttf_frame *frame = NULL;

    assert_int_equal(ttf_camera_next(camera, soon(state), &frame, NULL), -ENODATA);
    assert_null(frame);
}

static void a_set_comes_in_its_order_and_then_no_more(void **state)
{
    struct ttf_camera *camera = streaming(state);
    struct ttf_frame *frame;
    int64_t last_start = 0;
    uint32_t last_sequence = 0;

    assert_int_equal(submit(camera, 10, 5, 0), 0);
    for (unsigned i = 0; i < 5; i++) {
        assert_int_equal(ttf_camera_next(camera, soon(state), &frame, NULL), 0);
        assert_int_equal(frame->set_index, i);
        assert_true(frame->start_ns > last_start && frame->end_ns > frame->start_ns);
        assert_true(frame->end_ns <= ttf_clock_now_ns(clock_of(state)) + MS);
        if (i > 0)
            assert_true(frame->sequence > last_sequence);
        last_start = frame->start_ns;
        last_sequence = frame->sequence;
        assert_true(frame->bytes >= frame->format.stride * frame->format.height);
        assert_int_equal(frame->flags & (TTF_FRAME_ERROR | TTF_FRAME_SHORT), 0);
        ttf_camera_release(camera, frame);
    }
    assert_int_equal(ttf_camera_next(camera, soon(state), &frame, NULL), -ENODATA);
}

static void what_is_read_back_is_granted_again(void **state)
{
    struct ttf_camera *camera = streaming(state);
    struct ttf_exposure asked = of_ms(0), granted;
    struct ttf_camera_set set = {.settings = &asked, .n = 1};
    struct ttf_frame *frame;

    asked.exposure_ns = 12345678;
    asked.gain_milli = 1390;
    assert_int_equal(ttf_camera_submit(camera, &set, NULL), 0);
    assert_int_equal(ttf_camera_next(camera, soon(state), &frame, NULL), 0);
    granted = frame->settings;
    ttf_camera_release(camera, frame);
    if (ttf_camera_caps(camera)->exposure_max_ns > 0)
        assert_true(llabs(granted.exposure_ns - asked.exposure_ns) < 2 * MS);
    else
        assert_true(granted.exposure_ns == 0); /* what cannot be set is read back 0 */
    set.settings = &granted;
    assert_int_equal(ttf_camera_submit(camera, &set, NULL), 0);
    assert_int_equal(ttf_camera_next(camera, soon(state), &frame, NULL), 0);
    assert_memory_equal(&frame->settings, &granted, sizeof(granted));
    ttf_camera_release(camera, frame);
}

/* How far from where it was asked the middle of an exposure fell: the i-th of some lengths and phases. */
static int64_t off_by(void **state, int i)
{
    struct ttf_camera *camera = camera_of(state);
    const struct ttf_camera_caps *caps = ttf_camera_caps(camera);
    int64_t longer = (1 + 3 * i) * MS - caps->frame_period_ns;
    int64_t lead = caps->lead_ns + (longer > 0 ? longer * caps->long_frames : 0);
    int64_t middle = ttf_clock_now_ns(clock_of(state)) + lead + (i * 7 + 1) * MS;
    struct ttf_frame *frame;
    int64_t off;

    assert_int_equal(submit(camera, 1 + 3 * i, 1, middle), 0);
    assert_int_equal(ttf_camera_next(camera, soon(state), &frame, NULL), 0);
    off = llabs((frame->start_ns + frame->end_ns) / 2 - middle);
    ttf_camera_release(camera, frame);
    return off;
}

/*
 * The bound is the back-end's and the driver's. A machine that lets the driver's timer
 * wait breaks it now and then for neither's fault, so on a real clock a middle that was
 * missed is asked for again: what is wrong by rule is so each time.
 */
static void the_middle_falls_where_asked_within_the_stated_bound(void **state)
{
    const struct ttf_camera_caps *caps = ttf_camera_caps(streaming(state));
    int tries = ttf_clock_is_virtual(clock_of(state)) ? 1 : 3;

    for (int i = 0; i < 10; i++) {
        int64_t off = off_by(state, i);

        for (int again = 1; off > caps->timing_bound_ns && again < tries; again++)
            off = off_by(state, i);
        assert_true(off <= caps->timing_bound_ns);
    }
}

static void a_middle_that_is_past_is_taken_as_soon_as_possible(void **state)
{
    struct ttf_camera *camera = streaming(state);
    struct ttf_frame *frame;

    assert_int_equal(submit(camera, 10, 1, 1), 0);
    assert_int_equal(ttf_camera_next(camera, soon(state), &frame, NULL), 0);
    ttf_camera_release(camera, frame);
}

static void one_set_at_a_time(void **state)
{
    struct ttf_camera *camera = streaming(state);
    struct ttf_frame *frame;

    assert_int_equal(submit(camera, 10, 2, 0), 0);
    assert_int_equal(submit(camera, 10, 1, 0), -EBUSY);
    ttf_camera_cancel(camera);
    assert_int_equal(ttf_camera_next(camera, soon(state), &frame, NULL), -ENODATA);
    assert_int_equal(submit(camera, 10, 1, 0), 0);
    assert_int_equal(ttf_camera_next(camera, soon(state), &frame, NULL), 0);
    ttf_camera_release(camera, frame);
}

static void a_deadline_that_comes_first_times_out_and_the_frame_still_comes(void **state)
{
    struct ttf_camera *camera = streaming(state);
    int64_t now = ttf_clock_now_ns(clock_of(state));
    struct ttf_frame *frame;

    assert_int_equal(submit(camera, 10, 1, now + 800 * MS), 0);
    assert_int_equal(ttf_camera_next(camera, now + 100 * MS, &frame, NULL), -ETIMEDOUT);
    assert_true(ttf_clock_now_ns(clock_of(state)) >= now + 100 * MS);
    assert_int_equal(ttf_camera_next(camera, soon(state), &frame, NULL), 0);
    ttf_camera_release(camera, frame);
}

static void as_many_frames_can_be_held_as_stated_and_no_more(void **state)
{
    struct ttf_camera *camera = streaming(state);
    unsigned buffers = ttf_camera_caps(camera)->buffers;
    struct ttf_frame *held[TTF_CAMERA_SET_MAX] = {NULL}, *frame;

    assert_true(buffers < TTF_CAMERA_SET_MAX);
    assert_int_equal(submit(camera, 5, buffers + 1, 0), 0);
    for (unsigned i = 0; i < buffers; i++)
        assert_int_equal(ttf_camera_next(camera, soon(state), &held[i], NULL), 0);
    assert_int_equal(
        ttf_camera_next(camera, ttf_clock_now_ns(clock_of(state)) + 300 * MS, &frame, NULL),
        -ETIMEDOUT);
    ttf_camera_release(camera, held[0]);
    assert_int_equal(ttf_camera_next(camera, soon(state), &frame, NULL), 0);
    ttf_camera_release(camera, frame);
    for (unsigned i = 1; i < buffers; i++)
        ttf_camera_release(camera, held[i]);
}

struct releaser {
    struct ttf_clock *clock;
    struct ttf_camera *camera;
    struct ttf_frame *frame;
    int64_t at_ns;
};

static void *release_later(void *arg)
{
    struct releaser *r = arg;

    ttf_clock_wait_until(r->clock, r->at_ns);
    ttf_camera_release(r->camera, r->frame);
    ttf_clock_leave(r->clock);
    return NULL;
}

static void a_release_from_another_thread_lets_the_next_frame_come(void **state)
{
    struct ttf_camera *camera = streaming(state);
    struct ttf_clock *clock = clock_of(state);
    unsigned buffers = ttf_camera_caps(camera)->buffers;
    struct ttf_frame *held[TTF_CAMERA_SET_MAX] = {NULL}, *frame;
    struct releaser r = {.clock = clock, .camera = camera};
    pthread_t thread;

    ttf_clock_join(clock);
    assert_int_equal(submit(camera, 5, buffers + 1, 0), 0);
    for (unsigned i = 0; i < buffers; i++)
        assert_int_equal(ttf_camera_next(camera, soon(state), &held[i], NULL), 0);
    r.frame = held[0];
    r.at_ns = ttf_clock_now_ns(clock) + 200 * MS;
    ttf_clock_join_for(clock);
    assert_int_equal(pthread_create(&thread, NULL, release_later, &r), 0);
    assert_int_equal(ttf_camera_next(camera, soon(state), &frame, NULL), 0);
    assert_true(ttf_clock_now_ns(clock) >= r.at_ns);
    ttf_clock_leave(clock);
    pthread_join(thread, NULL);
    ttf_camera_release(camera, frame);
    for (unsigned i = 1; i < buffers; i++)
        ttf_camera_release(camera, held[i]);
}

static void each_step_of_recovery_gives_a_camera_that_delivers(void **state)
{
    struct ttf_camera *camera = streaming(state);
    struct ttf_frame *frame;

    for (int step = 0; step < TTF_CAMERA_RECOVERY_COUNT; step++) {
        int r;

        assert_int_equal(submit(camera, 10, 2, 0), 0);
        r = ttf_camera_recover(camera, (enum ttf_camera_recovery)step, NULL);
        if (r == -ENOTSUP)
            continue;
        assert_int_equal(r, 0);
        assert_int_equal(submit(camera, 10, 1, 0), 0);
        assert_int_equal(ttf_camera_next(camera, soon(state), &frame, NULL), 0);
        ttf_camera_release(camera, frame);
    }
    assert_int_equal(ttf_camera_recover(camera, TTF_CAMERA_RECOVERY_COUNT, NULL), -EINVAL);
}

int conformance_camera(const struct conformance_factory *factory)
{
    const struct CMUnitTest tests[] = {
        CONFORMANCE_TEST(nothing_is_granted_before_configure, factory),
        CONFORMANCE_TEST(the_granted_format_is_possible, factory),
        CONFORMANCE_TEST(states_are_kept_apart, factory),
        CONFORMANCE_TEST(wrong_sets_are_refused, factory),
        CONFORMANCE_TEST(without_a_set_nothing_comes, factory),
        CONFORMANCE_TEST(a_set_comes_in_its_order_and_then_no_more, factory),
        CONFORMANCE_TEST(what_is_read_back_is_granted_again, factory),
        CONFORMANCE_TEST(the_middle_falls_where_asked_within_the_stated_bound, factory),
        CONFORMANCE_TEST(a_middle_that_is_past_is_taken_as_soon_as_possible, factory),
        CONFORMANCE_TEST(one_set_at_a_time, factory),
        CONFORMANCE_TEST(a_deadline_that_comes_first_times_out_and_the_frame_still_comes, factory),
        CONFORMANCE_TEST(as_many_frames_can_be_held_as_stated_and_no_more, factory),
        CONFORMANCE_TEST(a_release_from_another_thread_lets_the_next_frame_come, factory),
        CONFORMANCE_TEST(each_step_of_recovery_gives_a_camera_that_delivers, factory),
    };

    return _cmocka_run_group_tests(factory->name, tests, TTF_COUNT_OF(tests), NULL, NULL);
}
