/* SPDX-License-Identifier: Apache-2.0 */
/* test_tar.c: a dataset as an archive: any part of it is the same part of the whole. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "scratch.h"
#include "tar_read.h"

#define TEXT(path, text) scratch_file(path, text, strlen(text))
#define HEX              "0123456789abcdef0123456789abcdef0123456789abcdef0123456789abcdef"

static void make(struct folder *folder)
{
    static unsigned char picture[1500];

    for (size_t i = 0; i < sizeof picture; i++)
        picture[i] = (unsigned char)(i * 7);
    TEXT("data/grass/dataset.json", "{}");
    TEXT("data/grass/records.jsonl", "{}\n{\"half\"");
    scratch_file("data/grass/frames/main/000000.tif", picture, sizeof picture);
    scratch_file("data/grass/frames/main/000001.tif", picture, 512);
    TEXT("data/grass/frames/main/000002.tif", "");
    TEXT("data/grass/frames/main/000003.tif.tmp", "half");
    TEXT("data/grass/preview/000000.jpg", "x");
    TEXT("data/grass/.events-reserve", "x");
    assert_int_equal(folder_open("data", folder, NULL), 0);
}

static void read_whole(struct tar_reader *reader, unsigned char *ret, int64_t from, int64_t bytes,
                       size_t piece)
{
    int64_t done = 0;

    while (done < bytes) {
        size_t n = bytes - done < (int64_t)piece ? (size_t)(bytes - done) : piece;
        ssize_t got = tar_read(reader, from + done, ret + done, n);

        if (got <= 0)
            fail_msg("reading at %lld gives %zd", (long long)(from + done), got);
        done += got;
    }
}

static void any_part_is_that_part_of_the_whole(void **state)
{
    struct folder folder;
    struct tar_layout layout;
    struct tar_reader *reader;
    static unsigned char whole[16384], part[16384];
    int64_t bytes;

    (void)state;
    make(&folder);
    assert_int_equal(tar_layout_make(&folder, "grass", &layout), 0);
    bytes = layout.bytes;
    reader = tar_reader_create(&folder, &layout);
    assert_in_range(bytes, 1, sizeof whole);
    if (!reader) {
        fail_msg("no memory");
        return;
    }
    read_whole(reader, whole, 0, bytes, 65536);
    for (int64_t from = 0; from < bytes; from += 131) {
        int64_t n = bytes - from < 1777 ? bytes - from : 1777;

        read_whole(reader, part, from, n, 100);
        assert_memory_equal(part, whole + from, (size_t)n);
    }
    assert_int_equal(tar_read(reader, bytes, part, 10), 0);
    tar_reader_destroy(reader);
    folder_close(&folder);
}

static void it_holds_the_dataset_and_no_more(void **state)
{
    static const char *const PATHS[] = {"dataset.json", "frames/main/000000.tif",
                                        "frames/main/000001.tif", "frames/main/000002.tif",
                                        "records.jsonl"};
    struct folder folder;
    struct tar_layout layout;

    (void)state;
    make(&folder);
    assert_int_equal(tar_layout_make(&folder, "grass", &layout), 0);
    assert_int_equal(layout.n, 5);
    for (unsigned i = 0; i < 5; i++)
        assert_string_equal(layout.files[i].path, PATHS[i]);
    assert_int_equal(layout.files[4].bytes, 3); /* whole lines alone */
    assert_false(layout.sealed);
    assert_int_equal(layout.bytes % 512, 0);
    tar_layout_free(&layout);
    assert_int_equal(tar_layout_make(&folder, "nobody", &layout), -ENOENT);
    folder_close(&folder);
}

static void a_sealed_one_has_the_same_tag_until_something_changes(void **state)
{
    struct folder folder;
    struct tar_layout layout;
    char tag[65];

    (void)state;
    make(&folder);
    TEXT("data/grass/SHA256SUMS", HEX "  records.jsonl\n");
    assert_int_equal(tar_layout_make(&folder, "grass", &layout), 0);
    assert_true(layout.sealed);
    assert_int_equal(layout.files[5].bytes, 10); /* nothing grows behind a seal */
    memcpy(tag, layout.etag, sizeof tag);
    tar_layout_free(&layout);
    assert_int_equal(tar_layout_make(&folder, "grass", &layout), 0);
    assert_string_equal(layout.etag, tag);
    tar_layout_free(&layout);
    TEXT("data/grass/notes.jsonl", "{}\n");
    assert_int_equal(tar_layout_make(&folder, "grass", &layout), 0);
    assert_string_not_equal(layout.etag, tag);
    tar_layout_free(&layout);
    folder_close(&folder);
}

static void a_file_that_shrank_meanwhile_ends_it_with_an_error(void **state)
{
    struct folder folder;
    struct tar_layout layout;
    struct tar_reader *reader;
    unsigned char buf[4096];
    int64_t at;

    (void)state;
    make(&folder);
    assert_int_equal(tar_layout_make(&folder, "grass", &layout), 0);
    at = layout.files[1].offset + 512 + 1000;
    reader = tar_reader_create(&folder, &layout);
    if (!reader) {
        fail_msg("no memory");
        return;
    }
    assert_int_equal(truncate("data/grass/frames/main/000000.tif", 900), 0);
    assert_int_equal(tar_read(reader, at, buf, sizeof buf), -EIO);
    assert_int_equal(unlink("data/grass/frames/main/000001.tif"), 0);
    assert_int_equal(tar_read(reader, tar_reader_layout(reader)->files[2].offset + 512, buf, 8),
                     -EIO);
    tar_reader_destroy(reader);
    folder_close(&folder);
}

static void large_sizes_and_long_names_fit_a_header(void **state)
{
    static char long_path[192];
    struct tar_layout layout = {.dataset = "grass"};
    struct tar_file file = {.path = long_path, .bytes = INT64_C(20000000000), .mtime_s = 1};
    unsigned char header[TAR_BLOCK];

    (void)state;
    memset(long_path, 'a', 191);
    long_path[60] = long_path[120] = '/';
    assert_true(tar_header(&layout, &file, header));
    assert_int_equal(header[124], 0x80); /* base 256 */
    assert_int_equal(header[135], 20000000000 & 255);
    assert_memory_equal(header + 345, "grass/aaaa", 10);
    assert_int_equal(strlen((char *)header), 70); /* behind the last slash */
    assert_int_equal(header[345 + 126], 0);
}

static void a_path_that_no_tar_can_have_is_refused(void **state)
{
    static char long_path[192];
    struct tar_layout layout;
    struct tar_file file = {.path = long_path};
    unsigned char header[TAR_BLOCK];
    struct folder folder;
    char whole[400];

    (void)state;
    memset(&layout, 0, sizeof layout);
    memset(layout.dataset, 'd', 64);
    memset(long_path, 'a', 191);
    long_path[64] = long_path[129] = '/';
    assert_false(tar_header(&layout, &file, header));
    make(&folder);
    (void)snprintf(whole, sizeof whole, "data/%s/%s", layout.dataset, long_path);
    TEXT(whole, "x");
    (void)snprintf(whole, sizeof whole, "data/%s/dataset.json", layout.dataset);
    TEXT(whole, "{}");
    (void)snprintf(whole, sizeof whole, "%s", layout.dataset);
    assert_int_equal(tar_layout_make(&folder, whole, &layout), -ENAMETOOLONG);
    folder_close(&folder);
}

#define IN_A_FOLDER(test) cmocka_unit_test_setup_teardown(test, scratch_make, scratch_remove)

int main(void)
{
    const struct CMUnitTest tests[] = {
        IN_A_FOLDER(any_part_is_that_part_of_the_whole),
        IN_A_FOLDER(it_holds_the_dataset_and_no_more),
        IN_A_FOLDER(a_sealed_one_has_the_same_tag_until_something_changes),
        IN_A_FOLDER(a_file_that_shrank_meanwhile_ends_it_with_an_error),
        IN_A_FOLDER(a_path_that_no_tar_can_have_is_refused),
        cmocka_unit_test(large_sizes_and_long_names_fit_a_header),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
