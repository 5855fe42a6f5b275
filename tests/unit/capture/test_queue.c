/* SPDX-License-Identifier: Apache-2.0 */
/* How many raw sums there are for frames of a size (capture/queue.h). */
#include "cmocka_includes.h"

#include <errno.h>

#include "queue.h"

static void make(struct ttf_queue *queue, struct ttf_clock **ret_clock)
{
    struct ttf_stock_size size = {.n_images = 1, .n_shots = 1, .rooms = 1, .slots = 1};

    *ret_clock = ttf_clock_real_create();
    assert_non_null(*ret_clock);
    assert_int_equal(ttf_queue_init(queue, *ret_clock, &size), 0);
}

static struct ttf_frame_format bayer(uint32_t width, uint32_t height)
{
    return (struct ttf_frame_format){.packing = TTF_PACKING_RAW16,
                                     .bits = 10,
                                     .width = width,
                                     .height = height,
                                     .stride = 2 * width,
                                     .white_level = 1023};
}

static unsigned take_all(struct ttf_queue *queue, const struct ttf_frame_format *format)
{
    struct ttf_raw_sum *raw;
    unsigned n = 0;

    while (ttf_queue_take_raw(queue, format, &raw) == 1)
        n++;
    for (unsigned i = 0; i < n; i++)
        ttf_queue_give_raw(queue, &queue->raw[i]);
    return n;
}

static void small_frames_have_more_raw_sums_and_large_ones_two(void **state)
{
    static const struct {
        uint32_t width, height;
        unsigned n;
    } sizes[] = {{64, 64, 16}, {640, 480, 13}, {1280, 960, 3}, {1920, 1080, 2}, {4056, 3040, 2}};

    (void)state;
    for (size_t i = 0; i < sizeof(sizes) / sizeof(sizes[0]); i++) {
        struct ttf_frame_format format = bayer(sizes[i].width, sizes[i].height);
        struct ttf_clock *clock;
        struct ttf_queue queue;

        make(&queue, &clock);
        assert_int_equal(ttf_queue_reserve_raw(&queue, &format), 0);
        assert_int_equal(take_all(&queue, &format), sizes[i].n);
        ttf_queue_finish(&queue);
        ttf_clock_destroy(clock);
    }
}

/* A second camera's larger frames: all can hold both, and there are as many as of the larger. */
static void of_two_cameras_the_larger_one_counts(void **state)
{
    struct ttf_frame_format small = bayer(64, 64), large = bayer(1920, 1080);
    struct ttf_clock *clock;
    struct ttf_queue queue;

    (void)state;
    make(&queue, &clock);
    assert_int_equal(ttf_queue_reserve_raw(&queue, &small), 0);
    assert_int_equal(ttf_queue_reserve_raw(&queue, &large), 0);
    assert_int_equal(take_all(&queue, &large), 2);
    assert_int_equal(take_all(&queue, &small), 2);
    assert_int_equal(ttf_queue_reserve_raw(&queue, &small), 0);
    assert_int_equal(take_all(&queue, &large), 2);
    ttf_queue_finish(&queue);
    ttf_clock_destroy(clock);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(small_frames_have_more_raw_sums_and_large_ones_two),
        cmocka_unit_test(of_two_cameras_the_larger_one_counts),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
