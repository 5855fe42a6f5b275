/* SPDX-License-Identifier: Apache-2.0 */
/* test_listed.c: the hashes that a dataset gives for its files, found without reading the list each time. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "described.h"
#include "listed.h"
#include "scratch.h"

#define SUMS "data/grass/SHA256SUMS"

static char *lines(int from, int to, char mark)
{
    size_t room = (size_t)(to - from) * 100 + 1, n = 0;
    char *text = malloc(room);

    if (text)
        text[0] = '\0';
    for (int i = from; text && i < to; i++)
        n += (size_t)snprintf(text + n, room - n, "%063d%c  frames/main/%06d.tif\n", i, mark, i);
    return text;
}

static void write_lines(int from, int to, char mark, const char *more)
{
    char *text = lines(from, to, mark), *whole = NULL;

    if (!text || asprintf(&whole, "%s%s", text, more) < 0) {
        free(text);
        fail_msg("no memory");
        return;
    }
    scratch_file(SUMS, whole, strlen(whole));
    free(whole);
    free(text);
}

static void append(const char *text)
{
    FILE *file = fopen(SUMS, "ae");

    if (!file) {
        fail_msg("no " SUMS);
        return;
    }
    (void)fputs(text, file);
    (void)fclose(file);
}

struct server {
    struct folder folder;
    struct listed *listed;
};

static struct server begin(int n)
{
    struct server s = {.listed = listed_create()};

    scratch_file("data/grass/dataset.json", "{}", 2);
    write_lines(0, n, 'a', "");
    assert_int_equal(folder_open("data", &s.folder, NULL), 0);
    return s;
}

static void end(struct server *s)
{
    listed_destroy(s->listed);
    folder_close(&s->folder);
}

static int look(struct server *s, int i, char ret[65])
{
    char path[64];

    (void)snprintf(path, sizeof path, "frames/main/%06d.tif", i);
    return listed_sha256(s->listed, &s->folder, "grass", path, ret);
}

static void each_path_of_ten_thousand_is_found_as_reading_all_finds_it(void **state)
{
    struct server s = begin(10000);
    char hex[65], read[65], path[64];

    (void)state;
    for (int i = 0; i < 10000; i += 7) {
        (void)snprintf(path, sizeof path, "frames/main/%06d.tif", i);
        assert_int_equal(look(&s, i, hex), 0);
        if (i % 700 == 0) {
            assert_int_equal(described_sha256(&s.folder, "grass", path, read), 0);
            assert_string_equal(hex, read);
        }
    }
    assert_int_equal(look(&s, 10000, hex), -ENODATA);
    assert_int_equal(listed_sha256(s.listed, &s.folder, "grass", "main/000001.tif", hex), -ENODATA);
    assert_int_equal(listed_sha256(s.listed, &s.folder, "none", "x", hex), -ENODATA);
    assert_false(listed_sealed(s.listed, &s.folder, "grass"));
    end(&s);
}

static void a_list_that_grows_is_followed_line_by_line(void **state)
{
    struct server s = begin(10);
    char hex[65], *more = lines(10, 12, 'b');

    (void)state;
    if (!more)
        return;
    assert_int_equal(look(&s, 10, hex), -ENODATA);
    append(more);
    free(more);
    assert_int_equal(look(&s, 11, hex), 0);
    assert_int_equal(hex[63], 'b');
    append("00000000000000000000000000000000000000000000000000000000000000");
    assert_int_equal(look(&s, 11, hex), 0);
    append("12  frames/main/000012.tif\n");
    assert_int_equal(look(&s, 12, hex), 0);
    end(&s);
}

static void lines_that_come_within_one_tick_of_the_disk_s_clock_are_seen(void **state)
{
    struct server s = begin(10);
    char hex[65], *more = lines(10, 12, 'b');
    struct timespec times[2];
    struct stat st;

    (void)state;
    if (!more)
        return;
    assert_int_equal(look(&s, 10, hex), -ENODATA);
    assert_int_equal(stat(SUMS, &st), 0);
    append(more);
    free(more);
    times[0] = times[1] = st.st_mtim;
    assert_int_equal(utimensat(AT_FDCWD, SUMS, times, 0), 0);
    assert_int_equal(look(&s, 11, hex), 0);
    end(&s);
}

static void a_list_that_was_put_in_its_place_is_another(void **state)
{
    struct server s = begin(100);
    char hex[65];

    (void)state;
    assert_int_equal(look(&s, 50, hex), 0);
    assert_int_equal(hex[63], 'a');
    assert_int_equal(unlink(SUMS), 0);
    write_lines(
        0, 100, 'c',
        "0000000000000000000000000000000000000000000000000000000000000001  records.jsonl\n");
    assert_int_equal(look(&s, 50, hex), 0);
    assert_int_equal(hex[63], 'c');
    assert_true(listed_sealed(s.listed, &s.folder, "grass"));
    /* The same file, written over in place: what is answered is what it says. */
    write_lines(0, 100, 'd', "");
    assert_int_equal(look(&s, 50, hex), 0);
    assert_int_equal(hex[63], 'd');
    assert_false(listed_sealed(s.listed, &s.folder, "grass"));
    assert_int_equal(unlink(SUMS), 0);
    assert_int_equal(look(&s, 50, hex), -ENODATA);
    end(&s);
}

static void what_is_no_line_is_passed_over(void **state)
{
    struct server s = begin(1);
    char hex[65];

    (void)state;
    append("junk\n\n");
    append("zz00000000000000000000000000000000000000000000000000000000000000  "
           "frames/main/000007.tif\n");
    append("0000000000000000000000000000000000000000000000000000000000000003  "
           "frames/main/000003.tif\n");
    assert_int_equal(look(&s, 3, hex), 0);
    assert_int_equal(look(&s, 7, hex), -ENODATA);
    end(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(each_path_of_ten_thousand_is_found_as_reading_all_finds_it,
                                        scratch_make, scratch_remove),
        cmocka_unit_test_setup_teardown(a_list_that_grows_is_followed_line_by_line, scratch_make,
                                        scratch_remove),
        cmocka_unit_test_setup_teardown(
            lines_that_come_within_one_tick_of_the_disk_s_clock_are_seen, scratch_make,
            scratch_remove),
        cmocka_unit_test_setup_teardown(a_list_that_was_put_in_its_place_is_another, scratch_make,
                                        scratch_remove),
        cmocka_unit_test_setup_teardown(what_is_no_line_is_passed_over, scratch_make,
                                        scratch_remove),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
