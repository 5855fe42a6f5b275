/* SPDX-License-Identifier: Apache-2.0 */
/* test_growth.c: what came to a dataset's records since one looked last. */
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

#include "store_test.h"
#include "ttf/dataset/growth.h"

struct seen {
    int64_t slots, last_index, segments, others;
    int64_t interval_ns;
    int stop_at; /* slots after which it is enough; 0: never */
};

static int take(void *ctx, const struct ttf_growth_line *line, struct ttf_err *err)
{
    struct seen *seen = ctx;
    struct ttf_slot_record record;
    struct ttf_segment segment;
    int r;

    if (strcmp(line->type, "slot") == 0) {
        if (seen->stop_at && seen->slots == seen->stop_at)
            return -ECANCELED;
        r = ttf_growth_slot(line, &record, err);
        if (r == 0) {
            seen->slots++;
            seen->last_index = record.index;
            ttf_slot_record_free(&record);
        }
        return r;
    }
    if (strcmp(line->type, "segment") == 0) {
        r = ttf_growth_segment(line, &segment, err);
        seen->segments += r == 0;
        seen->interval_ns = segment.interval_ns;
        return r;
    }
    seen->others++;
    return 0;
}

static int look(const char *path, struct ttf_growth *growth, struct seen *seen)
{
    return ttf_growth_read(ttf_io_posix(), path, growth, 0, take, seen, NULL);
}

static void slots(struct ttf_writer *writer, int64_t from, int64_t to)
{
    for (int64_t i = from; i < to; i++)
        assert_int_equal(small_slot(writer, i), 0);
}

static void only_what_is_new_is_given(void **state)
{
    const char *path = in(*state, "grass"), *records = in(*state, "grass/records.jsonl");
    struct ttf_writer *writer = small_create(ttf_io_posix(), path);
    struct ttf_growth growth = {0};
    struct seen seen = {0};
    int64_t others;

    slots(writer, 0, 3);
    assert_int_equal(look(records, &growth, &seen), 0);
    assert_int_equal(seen.slots, 3);
    assert_int_equal(seen.segments, 1);
    assert_int_equal(seen.interval_ns, 10 * TTF_NS_PER_S);
    others = seen.others;
    assert_int_equal(growth.bytes, size_of(records));
    assert_int_equal(look(records, &growth, &seen), 0);
    assert_int_equal(seen.slots, 3);
    slots(writer, 3, 5);
    assert_int_equal(look(records, &growth, &seen), 0);
    assert_int_equal(seen.slots, 5);
    assert_int_equal(seen.last_index, 4);
    assert_int_equal(seen.segments, 1);
    assert_int_equal(seen.others, others);
    ttf_writer_close(writer);
}

static void a_long_file_is_given_by_parts(void **state)
{
    const char *path = in(*state, "grass"), *records = in(*state, "grass/records.jsonl");
    struct ttf_writer *writer = small_create(ttf_io_posix(), path);
    struct ttf_growth growth = {0};
    struct seen seen = {0};
    int parts = 1;

    slots(writer, 0, 20);
    while (ttf_growth_read(ttf_io_posix(), records, &growth, 1000, take, &seen, NULL) == 1)
        parts++;
    assert_true(parts > 3);
    assert_int_equal(seen.slots, 20);
    ttf_writer_close(writer);
}

static void a_line_that_is_not_whole_waits(void **state)
{
    const char *path = in(*state, "grass"), *records = in(*state, "grass/records.jsonl");
    const char *cut = in(*state, "cut.jsonl");
    struct ttf_writer *writer = small_create(ttf_io_posix(), path);
    struct ttf_growth growth = {0};
    struct seen seen = {0};
    size_t n;
    char *text;

    slots(writer, 0, 2);
    ttf_writer_close(writer);
    text = file_text(records, &n);
    if (!text)
        return;
    write_text(cut, text, n - 10);
    assert_int_equal(look(cut, &growth, &seen), 0);
    assert_int_equal(seen.slots, 1);
    free(text);
}

static void what_is_refused_comes_again(void **state)
{
    const char *path = in(*state, "grass"), *records = in(*state, "grass/records.jsonl");
    struct ttf_writer *writer = small_create(ttf_io_posix(), path);
    struct ttf_growth growth = {0};
    struct seen seen = {.stop_at = 2};

    slots(writer, 0, 4);
    assert_int_equal(look(records, &growth, &seen), -ECANCELED);
    assert_int_equal(seen.slots, 2);
    seen.stop_at = 0;
    assert_int_equal(look(records, &growth, &seen), 0);
    assert_int_equal(seen.slots, 4);
    ttf_writer_close(writer);
}

static void damage_is_passed_over_and_counted(void **state)
{
    const char *path = in(*state, "grass"), *records = in(*state, "grass/records.jsonl");
    struct ttf_writer *writer = small_create(ttf_io_posix(), path);
    struct ttf_growth growth = {0};
    struct seen seen = {0};
    char *text, *at;
    size_t n;

    slots(writer, 0, 3);
    ttf_writer_close(writer);
    text = file_text(records, &n);
    if (!text)
        return;
    at = strstr(text, "\"index\":1");
    if (!at) {
        fail_msg("no slot 1");
        return;
    }
    at[8] = '7';
    write_text(records, text, n);
    free(text);
    assert_int_equal(look(records, &growth, &seen), 0);
    assert_int_equal(seen.slots, 2);
    assert_int_equal(growth.damaged, 1);
}

static void another_file_or_a_shorter_one_is_noticed(void **state)
{
    const char *path = in(*state, "grass"), *records = in(*state, "grass/records.jsonl");
    struct ttf_writer *writer = small_create(ttf_io_posix(), path);
    struct ttf_growth growth = {0}, before;
    struct seen seen = {0};
    char *text, *at;
    size_t n;

    slots(writer, 0, 3);
    ttf_writer_close(writer);
    assert_int_equal(look(records, &growth, &seen), 0);
    before = growth;
    assert_int_equal(truncate(records, (off_t)growth.bytes - 50), 0);
    assert_int_equal(look(records, &growth, &seen), -ESTALE);
    assert_int_equal(seen.slots, 3);
    /* The last line is another, of the same length: the power cut took one, and another came. */
    growth = (struct ttf_growth){0};
    assert_int_equal(look(records, &growth, &seen), 0);
    text = file_text(records, &n);
    if (!text)
        return;
    n = (size_t)growth.bytes;
    at = memrchr(text, '"', n - 4);
    if (at)
        *at = 'x';
    write_text(records, text, n);
    free(text);
    assert_int_equal(look(records, &growth, &seen), -ESTALE);
    assert_int_equal(unlink(records), 0);
    assert_int_equal(look(records, &before, &seen), -ENOENT);
}

static void a_copy_in_its_place_is_another_file(void **state)
{
    struct ttf_io *io = ttf_io_posix();
    const char *records = in(*state, "grass/records.jsonl"), *copy = in(*state, "copy");
    struct ttf_growth growth = {0};
    struct seen seen = {0};
    char *text = NULL;
    size_t n;

    ttf_writer_close(small_create(io, in(*state, "grass")));
    assert_int_equal(look(records, &growth, &seen), 0);
    assert_int_equal(ttf_io_slurp(io, records, 1 << 20, &text, &n, NULL), 0);
    if (!text)
        return;
    write_text(copy, text, n);
    free(text);
    assert_int_equal(rename(copy, records), 0);
    assert_int_equal(look(records, &growth, &seen), -ESTALE);
}

static void written_at(const char *path, time_t s)
{
    const struct timespec times[2] = {{.tv_sec = s}, {.tv_sec = s}};

    assert_int_equal(utimensat(AT_FDCWD, path, times, 0), 0);
}

static void the_dataset_whose_records_came_last_is_found(void **state)
{
    struct ttf_io *io = ttf_io_posix();
    const char *folder = in(*state, ".");
    char name[65] = "";

    assert_int_equal(ttf_growth_newest(io, folder, name), -ENOENT);
    ttf_writer_close(small_create(io, in(*state, "grass")));
    ttf_writer_close(small_create(io, in(*state, "banana")));
    written_at(in(*state, "grass/records.jsonl"), 2000);
    written_at(in(*state, "banana/records.jsonl"), 1000);
    assert_int_equal(ttf_growth_newest(io, folder, name), 0);
    assert_string_equal(name, "grass");
    assert_int_equal(ttf_growth_nth_newest(io, folder, 1, name), 0);
    assert_string_equal(name, "banana");
    assert_int_equal(ttf_growth_nth_newest(io, folder, 2, name), -ENOENT);
    written_at(in(*state, "banana/records.jsonl"), 2000); /* as old: each is found once */
    assert_int_equal(ttf_growth_nth_newest(io, folder, 0, name), 0);
    assert_string_equal(name, "banana");
    assert_int_equal(ttf_growth_nth_newest(io, folder, 1, name), 0);
    assert_string_equal(name, "grass");
    written_at(in(*state, "banana/records.jsonl"), 3000);
    assert_int_equal(ttf_growth_newest(io, folder, name), 0);
    assert_string_equal(name, "banana");
    /* What is hidden is no dataset of anybody's. */
    assert_int_equal(rename(in(*state, "banana"), in(*state, ".banana")), 0);
    assert_int_equal(ttf_growth_newest(io, folder, name), 0);
    assert_string_equal(name, "grass");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(only_what_is_new_is_given, folder_setup, folder_teardown),
        cmocka_unit_test_setup_teardown(a_long_file_is_given_by_parts, folder_setup,
                                        folder_teardown),
        cmocka_unit_test_setup_teardown(a_copy_in_its_place_is_another_file, folder_setup,
                                        folder_teardown),
        cmocka_unit_test_setup_teardown(a_line_that_is_not_whole_waits, folder_setup,
                                        folder_teardown),
        cmocka_unit_test_setup_teardown(what_is_refused_comes_again, folder_setup, folder_teardown),
        cmocka_unit_test_setup_teardown(damage_is_passed_over_and_counted, folder_setup,
                                        folder_teardown),
        cmocka_unit_test_setup_teardown(the_dataset_whose_records_came_last_is_found, folder_setup,
                                        folder_teardown),
        cmocka_unit_test_setup_teardown(another_file_or_a_shorter_one_is_noticed, folder_setup,
                                        folder_teardown),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
