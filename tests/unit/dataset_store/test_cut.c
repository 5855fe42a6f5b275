/* SPDX-License-Identifier: Apache-2.0 */
/* What a power cut leaves where the disk had other bytes before: told from rot, and put right. */
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

#include "lines.h"
#include "lines_cut.h"
#include "store_ios.h"
#include "store_test.h"
#include "ttf/dataset/hash.h"
#include "ttf/dataset/reader.h"
#include "ttf/dataset/verify.h"

#define OLD_LINE "{\"type\":\"slot\",\"seq\":70000,\"index\":69990,\"crc\":\"03377955\"}"

/* The end of an old line, a whole one of another file, the beginning of one. */
static const char old_block[] =
    "00,\"ok\":true}],\"crc\":\"4b825dc6\"}\n" OLD_LINE "\n{\"type\":\"slot\",\"seq\":70001,\"in";

/* Three slots, closed, not sealed: its path, which stays. */
static const char *three_slots(void **state)
{
    const char *path = in(*state, "d");
    struct ttf_writer *writer = small_create(quick_io(), path);
    char *kept = *state;

    for (int64_t i = 0; i < 3; i++)
        assert_int_equal(small_slot(writer, i), 0);
    assert_int_equal(ttf_writer_event(writer, "disk", 0, 0, "something", NULL, NULL), 0);
    ttf_writer_close(writer);
    return kept;
}

static void append(const char *path, const void *bytes, size_t n)
{
    FILE *file = fopen(path, "ab");

    assert_non_null(file);
    assert_int_equal(fwrite(bytes, 1, n, file), n);
    assert_int_equal(fclose(file), 0);
}

static int64_t found(const char *path, enum ttf_severity severity)
{
    const struct ttf_verify_options options = {.deep = true};
    struct ttf_verify_report report;
    int64_t n;

    assert_int_equal(ttf_verify(quick_io(), path, &options, &report, NULL), 0);
    n = report.n_of[severity];
    ttf_verify_report_free(&report);
    return n;
}

/* Opened as after a cut: three slots are there, the end is set aside, a fourth comes, nothing is left over. */
static void assert_goes_on(const char *path, unsigned repaired)
{
    struct ttf_reader *reader;
    struct ttf_writer *writer;
    struct ttf_err err = {0};

    assert_int_equal(found(path, TTF_FINDING_DAMAGE), 0);
    assert_true(found(path, TTF_FINDING_LEFTOVER) > 0);
    assert_int_equal(ttf_reader_open(quick_io(), path, &reader, NULL), 0);
    assert_int_equal(ttf_reader_summary(reader)->slots, 3);
    ttf_reader_close(reader);
    if (ttf_writer_open(quick_io(), path, &writer, &err) != 0)
        fail_msg("%s: %s", err.where, err.what);
    assert_int_equal(ttf_writer_state(writer)->repaired, repaired);
    assert_int_equal(small_slot(writer, 3), 0);
    ttf_writer_close(writer);
    assert_int_equal(small_check(quick_io(), path), 4);
    assert_int_equal(found(path, TTF_FINDING_DAMAGE), 0);
    assert_int_equal(found(path, TTF_FINDING_LEFTOVER), 0);
}

static void an_old_log_at_the_end_of_the_records_is_set_aside(void **state)
{
    char path[300];
    char *events;

    snprintf(path, sizeof(path), "%s/d", three_slots(state));
    append(in(path, "records.jsonl"), old_block, sizeof(old_block) - 1);
    assert_goes_on(path, 1);
    events = file_text(in(path, "events.jsonl"), NULL);
    assert_non_null(strstr(events, "no whole line: set aside here"));
    free(events);
}

static void an_old_log_at_the_end_of_the_events_is_set_aside(void **state)
{
    char path[300];

    snprintf(path, sizeof(path), "%s/d", three_slots(state));
    append(in(path, "events.jsonl"), old_block, sizeof(old_block) - 1);
    assert_goes_on(path, 1);
}

/* Nor did the last line's newline get there: the line counts all the same. */
static void an_old_log_in_the_place_of_a_newline_spares_the_line(void **state)
{
    char path[300];

    snprintf(path, sizeof(path), "%s/d", three_slots(state));
    assert_int_equal(truncate(in(path, "records.jsonl"), size_of(in(path, "records.jsonl")) - 1),
                     0);
    append(in(path, "records.jsonl"), old_block, sizeof(old_block) - 1);
    assert_goes_on(path, 2);
}

/* What the next line's first sector holds is its own. */
static void an_old_log_behind_the_beginning_of_a_line_is_set_aside(void **state)
{
    static const char begun[] =
        "{\"type\":\"slot\",\"seq\":5,\"index\":3,\"segment\":0,\"due_ns\":";
    char path[300];

    snprintf(path, sizeof(path), "%s/d", three_slots(state));
    append(in(path, "records.jsonl"), begun, sizeof(begun) - 1);
    append(in(path, "records.jsonl"), old_block, sizeof(old_block) - 1);
    assert_goes_on(path, 1);
}

/* ---- what is not taken for that ---- */

static void count_bad(void *ctx, const char *where, const char *text, const char *line, size_t n)
{
    ++*(unsigned *)ctx;
}

/* Wrong lines of a log that holds just this. */
static unsigned wrong_lines(const char *path, const char *text, size_t n)
{
    struct ttf_lines_tail tail;
    unsigned wrong = 0;

    write_text(path, text, n);
    assert_int_equal(ttf_lines_scan(quick_io(), path, NULL, count_bad, &wrong, &tail, NULL), 0);
    return wrong;
}

/* Three lines with their newlines; *ret_last: where the third begins. */
static size_t three_lines(char *text, size_t room, size_t *ret_last)
{
    size_t n = 0;

    for (int i = 0; i < 3; i++) {
        size_t from = n;

        *ret_last = from;
        n += (size_t)snprintf(text + n, room - n,
                              "{\"type\":\"x\",\"seq\":%d,\"text\":\"one JJ of them\"", i);
        n += (size_t)snprintf(text + n, room - n, ",\"crc\":\"%08x\"}\n",
                              ttf_crc32(0, text + from, n - from));
    }
    return n;
}

static void a_flipped_bit_in_a_line_is_damage_whatever_a_cut_left_behind_it(void **state)
{
    const char *path = in(*state, "log");
    char text[1000], end[] = "{\"type\":\"x\",\"se";
    size_t last, n = three_lines(text, sizeof(text), &last), bit;

    memcpy(text + n, end, sizeof(end));
    assert_int_equal(wrong_lines(path, text, n + sizeof(end) - 1), 0);
    for (bit = 8 * last; bit < 8 * (n - 1); bit++) {
        text[bit / 8] ^= (char)(1 << bit % 8);
        if (wrong_lines(path, text, n + sizeof(end) - 1) == 0)
            fail_msg("bit %zu of byte %zu is taken for a cut's", bit % 8, bit / 8);
        text[bit / 8] ^= (char)(1 << bit % 8);
    }
}

/* More than a bit, a whole sector: the lines behind it say that it was one. */
static void a_line_of_rot_before_others_is_damage(void **state)
{
    const char *path = in(*state, "log");
    char text[1000];
    size_t last, n = three_lines(text, sizeof(text), &last);

    memset(text + 5, '\xc3', 30);
    assert_int_equal(wrong_lines(path, text, n - 1), 1); /* the last one has no newline yet */
    text[20] = '\n';
    assert_true(wrong_lines(path, text, n - 1) > 0);
    n = three_lines(text, sizeof(text), &last);
    text[last - 1] =
        '\v'; /* the newline before the last one, and the power went at the next line */
    n += (size_t)snprintf(text + n, sizeof(text) - n, "{\"type\":\"x\",\"se");
    assert_true(wrong_lines(path, text, n) > 0);
}

/* As a committed line ends, so does this: rot and an old block cannot be told apart. */
static void what_ends_in_a_newline_is_damage(void **state)
{
    const char *path = in(*state, "log");
    char text[1000];
    size_t last, n = three_lines(text, sizeof(text), &last);

    memset(text + last + 5, '\xc3', 20);
    assert_int_equal(wrong_lines(path, text, n), 1);
    memset(text + last + 9, '\n', 1);
    assert_int_equal(wrong_lines(path, text, n), 2);
}

static void a_line_that_may_be_the_files_own_is_damage(void **state)
{
    const char *path = in(*state, "log");
    char text[1000], line[80];
    size_t last, n = three_lines(text, sizeof(text), &last), at, k;

    for (int seq = 1; seq < 9; seq++) { /* line 3 is due at the noise, 4 and so on behind it */
        at = n + (size_t)snprintf(text + n, sizeof(text) - n, "\xc3\xc3\xc3\n");
        k = (size_t)snprintf(line, sizeof(line), "{\"type\":\"x\",\"seq\":%d", seq);
        at += (size_t)snprintf(text + at, sizeof(text) - at, "%s,\"crc\":\"%08x\"}\n{\"ty", line,
                               ttf_crc32(0, line, k));
        assert_int_equal(wrong_lines(path, text, at) > 0, seq == 3 || seq == 4);
    }
}

/* A crc that holds is no accident, whatever it is of. */
static void a_whole_line_of_no_json_is_damage(void **state)
{
    const char *path = in(*state, "log");
    char text[1000];
    size_t last, n = three_lines(text, sizeof(text), &last);

    n += (size_t)snprintf(text + n, sizeof(text) - n, "\xc3\n{\"type\":,\"crc\":\"%08x\"}\n{\"t",
                          ttf_crc32(0, "{\"type\":", 8));
    assert_true(wrong_lines(path, text, n) > 0);
}

/* As long as the longest line, and no longer, a cut's leftovers may be. */
static void an_end_longer_than_any_line_is_damage(void **state)
{
    const char *path = in(*state, "log");
    size_t last, n, room = TTF_LINE_MAX + 1000;
    char *text = calloc(1, room);

    assert_non_null(text);
    n = three_lines(text, 1000, &last);
    memset(text + n, '\xc3', room - n);
    text[n + 9] = '\n';
    text[n + 300000] = '\n';
    assert_int_equal(wrong_lines(path, text, n + TTF_LINE_MAX + 1), 0);
    assert_true(wrong_lines(path, text, n + TTF_LINE_MAX + 2) > 0);
    free(text);
}

/* A disk of which only so many pieces can be read. */
struct few_reads {
    struct ttf_io base;
    int left;
};

static int64_t read_few(struct ttf_io *io, int file, void *buf, size_t n, int64_t offset)
{
    struct few_reads *few = (struct few_reads *)io;

    return few->left-- > 0 ? quick_io()->ops->pread(quick_io(), file, buf, n, offset) : -EIO;
}

static void an_end_that_cannot_be_read_is_no_damage(void **state)
{
    const char *path = in(*state, "log");
    struct ttf_io_ops ops = *quick_io()->ops;
    struct few_reads io = {.base.ops = &ops};
    struct ttf_lines_tail tail;
    char text[1000];
    size_t last, n = three_lines(text, sizeof(text), &last);
    int reads = 0, r;

    write_text(path, text, n + (size_t)snprintf(text + n, sizeof(text) - n, "\xc3\n{\"type"));
    ops.pread = read_few;
    do {
        io.left = reads;
        r = ttf_lines_scan(&io.base, path, NULL, NULL, NULL, &tail, NULL);
        assert_true(r == 0 || r == -EIO);
    } while (r != 0 && reads++ < 20);
    assert_int_equal(r, 0);
    assert_true(reads > 1);
    assert_int_equal(tail.good_bytes, n);
}

/* ---- SHA256SUMS ---- */

static void noise_in_the_sums_is_what_a_cut_left(void **state)
{
    char path[300];
    char *sums;
    size_t n;

    snprintf(path, sizeof(path), "%s/d", three_slots(state));
    sums = file_text(in(path, "SHA256SUMS"), &n);
    memset(sums + n - 40, '\xc3', 40); /* the end of the last line */
    write_text(in(path, "SHA256SUMS"), sums, n);
    assert_goes_on(path, 1);
    assert_int_equal(sha256sum_check(path), 0);
    memset(sums + n / 3 - 30, '\x91', 60); /* from one line into the next */
    write_text(in(path, "SHA256SUMS"), sums, n);
    assert_int_equal(found(path, TTF_FINDING_DAMAGE), 0);
    free(sums);
}

static void every_flipped_bit_of_the_running_sums_is_damage(void **state)
{
    char path[300];
    char *sums;
    size_t n, bit;

    snprintf(path, sizeof(path), "%s/d", three_slots(state));
    sums = file_text(in(path, "SHA256SUMS"), &n);
    for (bit = 0; bit < 8 * (n - 1); bit++) {
        sums[bit / 8] ^= (char)(1 << bit % 8);
        write_text(in(path, "SHA256SUMS"), sums, n);
        if (found(path, TTF_FINDING_DAMAGE) == 0 && bit / 8 % 512 != 511 && bit / 8 % 512 != 0)
            fail_msg("bit %zu of byte %zu is not found", bit % 8, bit / 8);
        sums[bit / 8] ^= (char)(1 << bit % 8);
    }
    free(sums);
}

#define T(f) cmocka_unit_test_setup_teardown(f, folder_setup, folder_teardown)

int main(void)
{
    const struct CMUnitTest tests[] = {
        T(an_old_log_at_the_end_of_the_records_is_set_aside),
        T(an_old_log_at_the_end_of_the_events_is_set_aside),
        T(an_old_log_in_the_place_of_a_newline_spares_the_line),
        T(an_old_log_behind_the_beginning_of_a_line_is_set_aside),
        T(a_flipped_bit_in_a_line_is_damage_whatever_a_cut_left_behind_it),
        T(a_line_of_rot_before_others_is_damage),
        T(what_ends_in_a_newline_is_damage),
        T(a_line_that_may_be_the_files_own_is_damage),
        T(a_whole_line_of_no_json_is_damage),
        T(an_end_longer_than_any_line_is_damage),
        T(an_end_that_cannot_be_read_is_no_damage),
        T(noise_in_the_sums_is_what_a_cut_left),
        T(every_flipped_bit_of_the_running_sums_is_damage),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
