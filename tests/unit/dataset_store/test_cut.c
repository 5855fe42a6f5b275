/* SPDX-License-Identifier: Apache-2.0 */
/* What a power cut leaves in SHA256SUMS where the disk had other bytes before; and what looks like it in a log, but is rot. */
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

#include "store_ios.h"
#include "store_test.h"
#include "ttf/dataset/reader.h"
#include "ttf/dataset/verify.h"

#define OLD_LINE "{\"type\":\"slot\",\"seq\":70000,\"index\":69990,\"crc\":\"03377955\"}"

/* Of an old log: the end of a line, a whole one, the beginning of one. */
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

/* ---- bad sectors: what was acknowledged is never set aside for a cut's ---- */

static void assert_refused(const char *path)
{
    struct ttf_writer *writer;
    struct ttf_err err = {0};

    assert_true(found(path, TTF_FINDING_DAMAGE) > 0);
    assert_int_equal(ttf_writer_open(quick_io(), path, &writer, &err), -TTF_EDAMAGED);
}

/* The last n bytes of a log, as another file had them in that sector; it is put right again. */
static void try_a_bad_end(const char *path, const char *log, size_t n)
{
    char file[400];
    char *text, *bad;
    size_t size, i;

    snprintf(file, sizeof(file), "%s/%s", path, log);
    text = file_text(file, &size);
    bad = malloc(size);
    assert_non_null(bad);
    memcpy(bad, text, size);
    n = n < size ? n : size;
    for (i = 0; i < n; i++)
        bad[size - n + i] = old_block[i % (sizeof(old_block) - 1)];
    write_text(file, bad, size);
    assert_refused(path);
    write_text(file, text, size);
    assert_int_equal(found(path, TTF_FINDING_DAMAGE), 0);
    free(bad);
    free(text);
}

static void a_bad_sector_at_the_end_of_a_log_is_damage(void **state)
{
    static const size_t sectors[] = {100, 512, 4096};
    char path[300];

    snprintf(path, sizeof(path), "%s/d", three_slots(state));
    for (size_t i = 0; i < sizeof(sectors) / sizeof(sectors[0]); i++) {
        try_a_bad_end(path, "records.jsonl", sectors[i]);
        try_a_bad_end(path, "events.jsonl", sectors[i]);
    }
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
        T(a_bad_sector_at_the_end_of_a_log_is_damage),
        T(noise_in_the_sums_is_what_a_cut_left),
        T(every_flipped_bit_of_the_running_sums_is_damage),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
