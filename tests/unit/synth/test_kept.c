/* SPDX-License-Identifier: Apache-2.0 */
/* Memory for frames that are kept: in large pages as long as these are quick. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "search/kept.h"

#define PIXELS ((size_t)1 << 20)
#define FRAMES 4u
#define LARGE  ((size_t)2 << 20)

/* Each look at it takes so long. */
struct slow_clock {
    int64_t now_ns, step_ns;
};

static int64_t look(void *ctx)
{
    struct slow_clock *clock = ctx;

    return clock->now_ns += clock->step_ns;
}

static struct ttf_kept make(void)
{
    struct ttf_kept kept;

    assert_int_equal(ttf_kept_create(PIXELS, FRAMES, 10 * PIXELS * FRAMES, &kept), 0);
    assert_int_equal(kept.frames, FRAMES);
    return kept;
}

/* Does the system say of an address that its memory is to be in small pages? */
static bool is_small(const void *address)
{
    FILE *f = fopen("/proc/self/smaps", "re");
    bool inside = false, small = false;
    char line[512], *end;

    assert_non_null(f);
    while (fgets(line, sizeof(line), f)) {
        uintptr_t from = strtoul(line, &end, 16);

        if (*end == '-') /* of the next mapping: FROM-TO ... */
            inside = (uintptr_t)address >= from && (uintptr_t)address < strtoul(end + 1, NULL, 16);
        else if (inside && strncmp(line, "VmFlags:", 8) == 0)
            small = strstr(line, " nh") != NULL;
    }
    assert_int_equal(fclose(f), 0);
    return small;
}

static void quick_pages_are_large_to_the_end(void **state)
{
    struct slow_clock clock = {.step_ns = 200000};
    struct ttf_kept kept = make();
    size_t first;

    (void)state;
    ttf_kept_touch(&kept, 0, 1, look, &clock);
    first = kept.touched;
    assert_true(first >= kept.frame && first < 2 * kept.frame);
    ttf_kept_touch(&kept, 0, 1, look, &clock);
    assert_int_equal(kept.touched, first);
    ttf_kept_touch(&kept, 1, FRAMES + 7, look, &clock); /* more than there are */
    assert_true(kept.touched >= FRAMES * kept.frame && kept.touched < FRAMES * kept.frame + LARGE);
    assert_false(kept.small);
    assert_false(is_small(kept.codes + FRAMES * kept.frame - 1));
    ttf_kept_free(&kept);
}

static void after_two_slow_ones_the_rest_are_small(void **state)
{
    struct slow_clock clock = {.step_ns = 4400000};
    struct ttf_kept kept = make();

    (void)state;
    ttf_kept_touch(&kept, 0, FRAMES, look, &clock);
    assert_true(kept.small);
    assert_int_equal(kept.touched, 2 * LARGE);
    if (access("/sys/kernel/mm/transparent_hugepage", F_OK) == 0)
        assert_true(is_small(kept.codes + 2 * LARGE));
    clock.step_ns = 1; /* and remain so */
    ttf_kept_touch(&kept, 0, FRAMES, look, &clock);
    assert_int_equal(kept.touched, 2 * LARGE);
    memset(kept.codes, 1, FRAMES * kept.frame + TTF_KEPT_SLACK);
    ttf_kept_free(&kept);
}

/* A frame ends in the middle of a large page: that one is the reader's. */
static void what_is_read_is_left_alone(void **state)
{
    struct slow_clock clock = {.step_ns = 200000};
    struct ttf_kept kept = make();

    (void)state;
    assert_true(kept.frame % LARGE != 0);
    memset(kept.codes, 0x5a, FRAMES * kept.frame);
    ttf_kept_touch(&kept, 1, 2, look, &clock);
    ttf_kept_touch(&kept, 3, FRAMES, look, &clock);
    for (size_t i = 0; i < FRAMES * kept.frame; i++) {
        bool next = i >= kept.frame && i < 2 * kept.frame;

        if (!next && i < 3 * kept.frame)
            assert_int_equal(kept.codes[i], 0x5a);
    }
    assert_int_equal(kept.codes[2 * LARGE], 0); /* the second frame's, of which nothing was read */
    ttf_kept_free(&kept);
}

/* Every fourth look is late: the second one at each second page. */
static int64_t look_late(void *ctx)
{
    struct slow_clock *clock = ctx;

    clock->step_ns += 1;
    return clock->now_ns += clock->step_ns % 4 == 0 ? 4400000 : 1000;
}

static void one_that_is_slow_by_itself_changes_nothing(void **state)
{
    struct slow_clock clock = {.step_ns = 0};
    struct ttf_kept kept = make();

    (void)state;
    ttf_kept_touch(&kept, 0, FRAMES, look_late, &clock); /* each second page */
    assert_true(clock.now_ns > 2 * 4400000);
    assert_false(kept.small);
    assert_true(kept.touched >= FRAMES * kept.frame);
    ttf_kept_free(&kept);
}

static void without_a_clock_nothing_is_asked_for(void **state)
{
    struct ttf_kept kept = make(), none = {0};
    struct slow_clock clock = {.step_ns = 1};

    (void)state;
    ttf_kept_touch(&kept, 0, FRAMES, NULL, NULL);
    assert_int_equal(kept.touched, 0);
    ttf_kept_free(&kept);
    ttf_kept_touch(&none, 0, FRAMES, look, &clock);
    assert_int_equal(none.touched, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(quick_pages_are_large_to_the_end),
        cmocka_unit_test(after_two_slow_ones_the_rest_are_small),
        cmocka_unit_test(what_is_read_is_left_alone),
        cmocka_unit_test(one_that_is_slow_by_itself_changes_nothing),
        cmocka_unit_test(without_a_clock_nothing_is_asked_for),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
