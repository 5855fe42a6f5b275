/* SPDX-License-Identifier: Apache-2.0 */
/* test_view.c: a texture as one file: how large, how bright, and what stays when it fails. */
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

#include "ttf/view/view.h"

#define WIDTH  160
#define HEIGHT 120
#define FRAMES 24

/* The name that a page has until it is whole. */
static const char *part_of(const char *output)
{
    static char name[80];

    (void)snprintf(name, sizeof name, ".%s.part-%ld", output, (long)getpid());
    return name;
}

static const struct ttf_encoding PLAIN = {.pedestal = 0, .scale = 65535};

struct made {
    uint16_t *codes;
    struct ttf_sequence *sequence;
    struct ttf_view_texture texture;
};

/* Noise up to `most`; every picture is as hard to compress as any can be. */
static int make(struct made *made, uint32_t frames, unsigned most)
{
    size_t n = (size_t)frames * WIDTH * HEIGHT * 3;
    uint32_t state = 1;

    *made = (struct made){0};
    made->codes = malloc(n * sizeof(*made->codes));
    if (!made->codes)
        return -ENOMEM;
    for (size_t i = 0; i < n; i++) {
        state = state * 1664525u + 1013904223u;
        made->codes[i] = (uint16_t)((state >> 16) * (uint64_t)most / 65535);
    }
    made->texture = (struct ttf_view_texture){.role = "texture", .title = "noise"};
    if (ttf_sequence_of_memory(made->codes, WIDTH, HEIGHT, frames, &PLAIN, &made->sequence, NULL))
        return -ENOMEM;
    made->texture.sequence = made->sequence;
    return 0;
}

static void unmake(struct made *made)
{
    ttf_sequence_destroy(made->sequence);
    free(made->codes);
}

static int64_t size_of(const char *path)
{
    struct ttf_io_stat st;

    return ttf_io_posix()->ops->stat(ttf_io_posix(), path, &st) == 0 ? st.bytes : -1;
}

/* A number behind "key": in the file. */
static double said(const char *path, const char *key)
{
    char *text = NULL, *at;
    size_t bytes;
    double value = -1;

    if (ttf_io_slurp(ttf_io_posix(), path, 64 << 20, &text, &bytes, NULL))
        return -1;
    at = strstr(text, key);
    if (at)
        value = strtod(at + strlen(key), NULL);
    free(text);
    return value;
}

static void what_does_not_fit_is_made_smaller_as_far_as_it_must(void **state)
{
    struct ttf_view_config config = {.output = "fit.html", .bytes_max = 1000000};
    struct ttf_view_result result = {0};
    struct made made;

    (void)state;
    assert_int_equal(make(&made, FRAMES, 65535), 0);
    assert_int_equal(ttf_view_write(&made.texture, 1, ttf_io_posix(), &config, &result, NULL), 0);
    unmake(&made);
    assert_int_equal(result.bytes, size_of("fit.html"));
    assert_true(result.bytes <= 1000000);
    assert_true(result.bytes > 700000); /* no smaller than it must be */
    assert_int_equal(result.panel[0].frames, FRAMES);
    assert_false(result.panel[0].exact);
    assert_true(result.panel[0].width < WIDTH);
    assert_int_equal(access(part_of("fit.html"), F_OK), -1);
}

static void what_fits_is_exact_and_says_what_its_brightest_code_means(void **state)
{
    struct ttf_view_config config = {.output = "dark.html"};
    struct ttf_view_result result = {0};
    struct made made;
    double white;

    (void)state;
    assert_int_equal(make(&made, 4, 13107), 0); /* nothing is brighter than a fifth */
    assert_int_equal(ttf_view_write(&made.texture, 1, ttf_io_posix(), &config, &result, NULL), 0);
    unmake(&made);
    assert_true(result.panel[0].exact);
    assert_int_equal(result.panel[0].width, WIDTH);
    white = said("dark.html", "\"white\":");
    assert_true(white > 0.199 && white <= 0.2);
}

static void threads_change_no_byte(void **state)
{
    struct ttf_view_config config = {.output = "one.html", .bytes_max = 900000, .threads = 1};
    struct made made;
    char *one = NULL, *five = NULL;
    size_t n_one = 0, n_five = 0;

    (void)state;
    assert_int_equal(make(&made, FRAMES, 65535), 0);
    assert_int_equal(ttf_view_write(&made.texture, 1, ttf_io_posix(), &config, NULL, NULL), 0);
    config.output = "five.html";
    config.threads = 5;
    assert_int_equal(ttf_view_write(&made.texture, 1, ttf_io_posix(), &config, NULL, NULL), 0);
    unmake(&made);
    assert_int_equal(ttf_io_slurp(ttf_io_posix(), "one.html", 1 << 20, &one, &n_one, NULL), 0);
    assert_int_equal(ttf_io_slurp(ttf_io_posix(), "five.html", 1 << 20, &five, &n_five, NULL), 0);
    if (!one || !five)
        fail();
    assert_int_equal(n_one, n_five);
    assert_memory_equal(one, five, n_one);
    free(one);
    free(five);
}

/* The disk is full at the n-th write, or the last sync or the rename fails. */
static int failing(void *ctx, const char *op, const char *path)
{
    int *left = ctx;

    /* Of removing what is not there nothing depends. */
    return strcmp(op, "unlink") != 0 && strstr(path, "kept.html") && --*left == 0 ? ENOSPC : 0;
}

static void on_a_full_disk_what_was_there_stays_and_nothing_else(void **state)
{
    struct ttf_view_config config = {.output = "kept.html"};
    struct made made;
    int left, failures = 0, code = -1;

    (void)state;
    assert_int_equal(ttf_io_write_file(ttf_io_posix(), "kept.html", "old", 3, NULL), 0);
    assert_int_equal(make(&made, 2, 65535), 0);
    for (int at = 1; code != 0 && at < 60; at++) {
        struct ttf_io *io = ttf_io_faulty_create(ttf_io_posix(), failing, &left);

        if (!io)
            fail();
        left = at;
        code = ttf_view_write(&made.texture, 1, io, &config, NULL, NULL);
        ttf_io_faulty_destroy(io);
        if (code) {
            failures++;
            assert_int_equal(code, -ENOSPC);
            assert_int_equal(size_of("kept.html"), 3);
            assert_int_equal(access(part_of("kept.html"), F_OK), -1);
        }
    }
    unmake(&made);
    assert_int_equal(code, 0);
    assert_true(failures >= 4); /* opening, writing, syncing, naming */
    assert_true(size_of("kept.html") > 3);
}

static int stop_at_two(void *ctx, int64_t done, int64_t total)
{
    (void)ctx;
    return done >= 2 && total == FRAMES;
}

static void one_that_is_stopped_leaves_nothing(void **state)
{
    struct ttf_view_config config = {
        .output = "stopped.html", .threads = 1, .progress = stop_at_two};
    struct made made;

    (void)state;
    assert_int_equal(make(&made, FRAMES, 65535), 0);
    assert_int_equal(ttf_view_write(&made.texture, 1, ttf_io_posix(), &config, NULL, NULL),
                     -ECANCELED);
    unmake(&made);
    assert_int_equal(access("stopped.html", F_OK), -1);
    assert_int_equal(access(part_of("stopped.html"), F_OK), -1);
}

static void what_cannot_be_made_is_refused(void **state)
{
    struct ttf_view_config config = {.output = "never.html", .frames_max = 257};
    struct made made;

    (void)state;
    assert_int_equal(make(&made, 2, 65535), 0);
    assert_int_equal(ttf_view_write(&made.texture, 1, ttf_io_posix(), &config, NULL, NULL),
                     -EINVAL);
    config.frames_max = 0;
    config.bytes_max = TTF_VIEW_BYTES_MAX + 1;
    assert_int_equal(ttf_view_write(&made.texture, 1, ttf_io_posix(), &config, NULL, NULL),
                     -EINVAL);
    config.bytes_max = 0;
    config.output = "no/folder/never.html";
    assert_int_equal(ttf_view_write(&made.texture, 1, ttf_io_posix(), &config, NULL, NULL),
                     -ENOENT);
    config.output = ".";
    assert_int_equal(ttf_view_write(&made.texture, 1, ttf_io_posix(), &config, NULL, NULL),
                     -EISDIR);
    unmake(&made);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_does_not_fit_is_made_smaller_as_far_as_it_must),
        cmocka_unit_test(what_fits_is_exact_and_says_what_its_brightest_code_means),
        cmocka_unit_test(threads_change_no_byte),
        cmocka_unit_test(on_a_full_disk_what_was_there_stays_and_nothing_else),
        cmocka_unit_test(one_that_is_stopped_leaves_nothing),
        cmocka_unit_test(what_cannot_be_made_is_refused),
    };
    char folder[] = "/tmp/ttf-view.XXXXXX";
    int failed;

    if (!mkdtemp(folder) || chdir(folder))
        return 1;
    failed = cmocka_run_group_tests(tests, NULL, NULL);
    for (const char *const *name = (const char *const[]){"fit.html", "dark.html", "one.html",
                                                         "five.html", "kept.html", NULL};
         *name; name++)
        (void)unlink(*name);
    (void)rmdir(folder);
    return failed;
}
