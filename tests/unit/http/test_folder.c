/* SPDX-License-Identifier: Apache-2.0 */
/* test_folder.c: files of datasets, and nothing else. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include "described.h"
#include "folder.h"
#include "scratch.h"

#define TEXT(path, text) scratch_file(path, text, strlen(text))

static void make(struct folder *folder)
{
    TEXT("data/grass/dataset.json", "{}");
    TEXT("data/grass/frames/main/000000.tif", "II");
    TEXT("data/no-dataset/file", "x");
    TEXT("data/.hidden/dataset.json", "{}");
    TEXT("secret", "s");
    assert_int_equal(folder_open("data", folder, NULL), 0);
}

static int opens(const struct folder *folder, const char *dataset, const char *path)
{
    int fd = folder_file(folder, dataset, path, NULL);

    if (fd < 0)
        return fd;
    (void)close(fd);
    return 0;
}

static void files_are_found_by_their_paths(void **state)
{
    struct folder folder;

    (void)state;
    make(&folder);
    assert_int_equal(opens(&folder, "grass", "dataset.json"), 0);
    assert_int_equal(opens(&folder, "grass", "frames/main/000000.tif"), 0);
    assert_int_equal(opens(&folder, "grass", "frames/main/000001.tif"), -ENOENT);
    assert_int_equal(opens(&folder, "grass", "frames/main"), -ENOENT);
    assert_int_equal(opens(&folder, "grass", "dataset.json/x"), -ENOENT);
    folder_close(&folder);
}

static void no_name_leads_out(void **state)
{
    static const char *const PATHS[] = {"../../secret",
                                        "../secret",
                                        "..",
                                        ".",
                                        "",
                                        "/etc/passwd",
                                        "frames/../dataset.json",
                                        "./dataset.json",
                                        "frames//main",
                                        "frames/",
                                        ".hidden",
                                        "a b",
                                        "a\\b",
                                        "a\n",
                                        NULL};
    static const char *const NAMES[] = {"..", ".",       "",       "grass/../grass",
                                        "/",  ".hidden", "gr ass", NULL};
    struct folder folder;
    char dots[200] = "";

    (void)state;
    make(&folder);
    for (unsigned i = 0; PATHS[i]; i++)
        if (opens(&folder, "grass", PATHS[i]) != -ENOENT)
            fail_msg("'%s' opens", PATHS[i]);
    for (unsigned i = 0; NAMES[i]; i++)
        if (opens(&folder, NAMES[i], "dataset.json") != -ENOENT)
            fail_msg("'%s' opens", NAMES[i]);
    memset(dots, 'x', 192);
    assert_false(folder_is_path(dots));
    folder_close(&folder);
}

static void links_and_pipes_are_not_files(void **state)
{
    struct folder folder;

    (void)state;
    make(&folder);
    assert_int_equal(symlink("../../secret", "data/grass/link"), 0);
    assert_int_equal(symlink("/", "data/grass/root"), 0);
    assert_int_equal(symlink("grass", "data/alias"), 0);
    assert_int_equal(mkfifo("data/grass/pipe", 0644), 0);
    assert_int_equal(opens(&folder, "grass", "link"), -ENOENT);
    assert_int_equal(opens(&folder, "grass", "root/etc/passwd"), -ENOENT);
    assert_int_equal(opens(&folder, "alias", "dataset.json"), -ENOENT);
    assert_int_equal(opens(&folder, "grass", "pipe"), -ENOENT);
    folder_close(&folder);
}

static void the_list_has_datasets_alone_in_their_order(void **state)
{
    char(*names)[65] = NULL;
    struct folder folder;

    (void)state;
    make(&folder);
    TEXT("data/banana/dataset.json", "{}");
    TEXT("data/Zinc/dataset.json", "{}");
    assert_int_equal(folder_list(&folder, &names), 3);
    assert_string_equal(names[0], "Zinc");
    assert_string_equal(names[1], "banana");
    assert_string_equal(names[2], "grass");
    free(names);
    folder_close(&folder);
}

/* Whoever cannot look says so: a list without them would be taken for all there is. */
static void without_free_descriptors_the_list_fails_and_hides_nothing(void **state)
{
    struct rlimit before, few;
    char(*names)[65] = NULL;
    struct folder folder;
    int64_t n;
    int next;

    (void)state;
    make(&folder);
    next = dup(folder.fd);
    assert_true(next >= 0);
    (void)close(next);
    assert_int_equal(getrlimit(RLIMIT_NOFILE, &before), 0);
    few = (struct rlimit){(rlim_t)next + 1, before.rlim_max}; /* for the folder itself */
    assert_int_equal(setrlimit(RLIMIT_NOFILE, &few), 0);
    n = folder_list(&folder, &names);
    assert_int_equal(setrlimit(RLIMIT_NOFILE, &before), 0);
    assert_int_equal(n, -EMFILE);
    assert_int_equal(folder_list(&folder, &names), 1);
    free(names);
    folder_close(&folder);
}

static int64_t whole(const struct folder *folder, const char *text, size_t n)
{
    struct stat st;
    int64_t r;
    int fd;

    scratch_file("data/grass/records.jsonl", text, n);
    fd = folder_file(folder, "grass", "records.jsonl", &st);
    r = folder_whole_lines(fd, st.st_size);
    (void)close(fd);
    return r;
}

static void a_line_being_written_is_not_there_yet(void **state)
{
    static char text[200000];
    struct folder folder;

    (void)state;
    make(&folder);
    assert_int_equal(whole(&folder, "", 0), 0);
    assert_int_equal(whole(&folder, "{}", 2), 0);
    assert_int_equal(whole(&folder, "{}\n", 3), 3);
    assert_int_equal(whole(&folder, "{}\n{\"a\"", 7), 3);
    memset(text, 'x', sizeof text);
    text[9] = '\n';
    assert_int_equal(whole(&folder, text, sizeof text), 10);
    folder_close(&folder);
}

static void a_hash_is_the_list_s_own(void **state)
{
    const char *one = "0123456789abcdef0123456789abcdef0123456789abcdef0123456789abcdef";
    struct folder folder;
    char text[2000], hex[65];

    (void)state;
    make(&folder);
    assert_int_equal(described_sha256(&folder, "grass", "dataset.json", hex), -ENODATA);
    (void)snprintf(text, sizeof text,
                   "%s  frames/main/000000.tif\n%.63sX  bad.tif\n%s  records.jsonl\n%s  cut", one,
                   one, one, one);
    TEXT("data/grass/SHA256SUMS", text);
    assert_int_equal(described_sha256(&folder, "grass", "frames/main/000000.tif", hex), 0);
    assert_string_equal(hex, one);
    assert_int_equal(described_sha256(&folder, "grass", "main/000000.tif", hex), -ENODATA);
    assert_int_equal(described_sha256(&folder, "grass", "bad.tif", hex), -ENODATA);
    assert_int_equal(described_sha256(&folder, "grass", "cut", hex), -ENODATA);
    assert_true(described_sealed(&folder, "grass"));
    folder_close(&folder);
}

/* Longer than what is read at once: the line may lie across two pieces, wherever they meet. */
static void a_hash_is_found_in_a_long_list(void **state)
{
    enum {
        LINES = 3000
    };
    char *text = malloc((size_t)LINES * 100), hex[65], path[32], expected[65];
    struct folder folder;
    size_t n = 0;

    (void)state;
    make(&folder);
    if (!text) {
        fail_msg("no memory");
        return;
    }
    for (unsigned i = 0; i < LINES; i++)
        n += (size_t)snprintf(text + n, 100, "%064x  frames/main/%06u.tif\n", i, i);
    scratch_file("data/grass/SHA256SUMS", text, n);
    free(text);
    for (unsigned i = 0; i < LINES; i += 7) {
        (void)snprintf(path, sizeof path, "frames/main/%06u.tif", i);
        (void)snprintf(expected, sizeof expected, "%064x", i);
        assert_int_equal(described_sha256(&folder, "grass", path, hex), 0);
        assert_string_equal(hex, expected);
    }
    assert_false(described_sealed(&folder, "grass"));
    folder_close(&folder);
}

#define IN_A_FOLDER(test) cmocka_unit_test_setup_teardown(test, scratch_make, scratch_remove)

int main(void)
{
    const struct CMUnitTest tests[] = {
        IN_A_FOLDER(files_are_found_by_their_paths),
        IN_A_FOLDER(no_name_leads_out),
        IN_A_FOLDER(links_and_pipes_are_not_files),
        IN_A_FOLDER(the_list_has_datasets_alone_in_their_order),
        IN_A_FOLDER(without_free_descriptors_the_list_fails_and_hides_nothing),
        IN_A_FOLDER(a_line_being_written_is_not_there_yet),
        IN_A_FOLDER(a_hash_is_the_list_s_own),
        IN_A_FOLDER(a_hash_is_found_in_a_long_list),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
