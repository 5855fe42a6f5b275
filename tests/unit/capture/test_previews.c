/* SPDX-License-Identifier: Apache-2.0 */
#include "cmocka_includes.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "previews.h"

/* The machine's files; each preview that goes makes a byte of room. */
static struct ttf_io_ops ops;
static struct ttf_io io = {&ops};
static int64_t free_bytes;
static const char *stays; /* a name that cannot be removed; NULL */
static char folder[64];
static unsigned asked;  /* how often room was asked for */
static unsigned listed; /* how often a folder was read */

static int say_space(struct ttf_io *self, const char *path, struct ttf_io_space *ret)
{
    (void)self;
    (void)path;
    asked++;
    *ret = (struct ttf_io_space){.free_bytes = free_bytes, .total_bytes = INT64_C(1) << 40};
    return 0;
}

static int list_one(struct ttf_io *self, const char *path, ttf_io_entry_fn *found, void *ctx)
{
    (void)self;
    listed++;
    return ttf_io_posix()->ops->list(ttf_io_posix(), path, found, ctx);
}

static int unlink_one(struct ttf_io *self, const char *path)
{
    int r;

    (void)self;
    if (stays && strstr(path, stays))
        return -EPERM;
    r = ttf_io_posix()->ops->unlink(ttf_io_posix(), path);
    free_bytes += r == 0;
    return r;
}

static int set_up(void **state)
{
    (void)state;
    ops = *ttf_io_posix()->ops;
    ops.space = say_space;
    ops.unlink = unlink_one;
    ops.list = list_one;
    free_bytes = 0;
    stays = NULL;
    asked = listed = 0;
    strcpy(folder, "/tmp/ttf-previews-XXXXXX");
    return mkdtemp(folder) ? 0 : -1;
}

static void path_of(char *ret, size_t size, const char *name)
{
    snprintf(ret, size, "%s/preview/%s", folder, name);
}

static void make_folder(const char *name)
{
    char path[256];

    path_of(path, sizeof(path), name);
    assert_int_equal(mkdir(path, 0755), 0);
}

static void make(const char *name)
{
    char path[256];
    FILE *f;

    path_of(path, sizeof(path), name);
    f = fopen(path, "w");
    assert_non_null(f);
    if (f)
        assert_int_equal(fclose(f), 0);
}

static bool there(const char *name)
{
    char path[256];

    path_of(path, sizeof(path), name);
    return access(path, F_OK) == 0;
}

static int tear_down(void **state)
{
    char line[96];

    (void)state;
    snprintf(line, sizeof(line), "rm -r %s", folder);
    return system(line); /* NOLINT(cert-env33-c,concurrency-mt-unsafe): a test's own folder */
}

static void two_streams(void)
{
    make_folder("");
    make_folder("main");
    make_folder("side");
    make("main/000002.jpg");
    make("main/000010.jpg");
    make("side/000002.jpg");
    make("side/000001.jpg");
    make("000003.jpg"); /* of one stream, without a folder */
}

static void the_oldest_slot_goes_first_whatever_its_stream(void **state)
{
    (void)state;
    two_streams();
    assert_int_equal(ttf_previews_remove(&io, folder, 1), 1);
    assert_false(there("side/000001.jpg"));
    assert_int_equal(ttf_previews_remove(&io, folder, 3), 2);
    assert_false(there("main/000002.jpg"));
    assert_false(there("side/000002.jpg"));
    assert_true(there("000003.jpg"));
    assert_int_equal(ttf_previews_remove(&io, folder, 4), 1);
    assert_false(there("000003.jpg"));
    assert_true(there("main/000010.jpg"));
}

static void of_one_slot_they_go_by_name(void **state)
{
    static const char *const streams[] = {"e", "b", "h", "a", "g", "c", "f", "d"};
    char name[32];

    (void)state;
    make_folder("");
    for (unsigned i = 0; i < 8; i++) {
        make_folder(streams[i]);
        snprintf(name, sizeof(name), "%s/000005.jpg", streams[i]);
        make(name);
    }
    for (int c = 'a'; c <= 'h'; c++) {
        snprintf(name, sizeof(name), "%c/000005.jpg", c);
        assert_true(there(name));
        assert_int_equal(ttf_previews_remove(&io, folder, c - 'a' + 1), 1);
        assert_false(there(name));
    }
}

static void with_room_nothing_is_removed(void **state)
{
    (void)state;
    two_streams();
    free_bytes = 100;
    assert_int_equal(ttf_previews_remove(&io, folder, 100), 0);
    assert_true(there("side/000001.jpg"));
    assert_true(there("000003.jpg"));
    assert_int_equal(listed, 0); /* weeks of them are not read for nothing, slot after slot */
}

static void without_previews_there_is_nothing_to_remove(void **state)
{
    (void)state;
    assert_int_equal(ttf_previews_remove(&io, folder, 100), 0);
}

static void one_that_cannot_be_removed_does_not_keep_the_others(void **state)
{
    (void)state;
    two_streams();
    stays = "side/000001";
    assert_int_equal(ttf_previews_remove(&io, folder, 100), 4);
    assert_true(there("side/000001.jpg"));
    assert_false(there("main/000010.jpg"));
}

static void more_than_are_looked_for_at_a_time_all_go(void **state)
{
    char name[32];

    (void)state;
    make_folder("");
    make_folder("main");
    for (int i = 99; i >= 0; i--) {
        snprintf(name, sizeof(name), "main/%06d.jpg", i);
        make(name);
    }
    assert_int_equal(ttf_previews_remove(&io, folder, 70), 70);
    assert_false(there("main/000069.jpg"));
    assert_true(there("main/000070.jpg"));
}

/* A folder in a stream's folder is nothing that a preview's maker left. */
static void what_lies_deeper_is_left_alone(void **state)
{
    (void)state;
    make_folder("");
    make_folder("main");
    make_folder("main/deeper");
    make("main/deeper/000000.jpg");
    make("main/000005.jpg");
    assert_int_equal(ttf_previews_remove(&io, folder, 10), 1);
    assert_true(there("main/deeper/000000.jpg"));
}

/* Whatever its name: what was found before and what is found after it goes all the same. */
static void a_folder_with_no_stream_s_name_keeps_nothing_else(void **state)
{
    char name[96];

    (void)state;
    two_streams();
    for (int c = 'a'; c < 'a' + 8; c++) {
        memset(name, c, 80);
        name[80] = '\0';
        make_folder(name);
    }
    assert_int_equal(ttf_previews_remove(&io, folder, 100), 5);
}

static void a_path_that_is_too_long_has_no_previews(void **state)
{
    static char path[5000];

    (void)state;
    memset(path, 'a', sizeof(path) - 1);
    assert_int_equal(ttf_previews_remove(&io, path, 10), 0);
    assert_int_equal(asked, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(the_oldest_slot_goes_first_whatever_its_stream, set_up,
                                        tear_down),
        cmocka_unit_test_setup_teardown(of_one_slot_they_go_by_name, set_up, tear_down),
        cmocka_unit_test_setup_teardown(with_room_nothing_is_removed, set_up, tear_down),
        cmocka_unit_test_setup_teardown(without_previews_there_is_nothing_to_remove, set_up,
                                        tear_down),
        cmocka_unit_test_setup_teardown(one_that_cannot_be_removed_does_not_keep_the_others, set_up,
                                        tear_down),
        cmocka_unit_test_setup_teardown(more_than_are_looked_for_at_a_time_all_go, set_up,
                                        tear_down),
        cmocka_unit_test_setup_teardown(what_lies_deeper_is_left_alone, set_up, tear_down),
        cmocka_unit_test_setup_teardown(a_folder_with_no_stream_s_name_keeps_nothing_else, set_up,
                                        tear_down),
        cmocka_unit_test_setup_teardown(a_path_that_is_too_long_has_no_previews, set_up, tear_down),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
