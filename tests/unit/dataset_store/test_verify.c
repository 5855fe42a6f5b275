/* SPDX-License-Identifier: Apache-2.0 */
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
#include <unistd.h>

#include "store_ios.h"
#include "store_test.h"
#include "ttf/dataset/hash.h"
#include "ttf/dataset/verify.h"

static struct ttf_verify_report verified(const char *path)
{
    struct ttf_verify_options options = {.deep = true};
    struct ttf_verify_report report;
    struct ttf_err err = {0};

    if (ttf_verify(ttf_io_posix(), path, &options, &report, &err) != 0)
        fail_msg("%s: %s", err.where, err.what);
    return report;
}

/* Is there such a finding? */
static bool found(const struct ttf_verify_report *report, enum ttf_severity severity,
                  const char *file, int64_t slot, const char *text)
{
    unsigned i;

    for (i = 0; i < report->n_findings; i++)
        if (report->findings[i].severity == severity &&
            strcmp(report->findings[i].file, file) == 0 && report->findings[i].slot == slot &&
            strstr(report->findings[i].text, text))
            return true;
    return false;
}

static const char *sealed_dataset(void **state)
{
    const char *path = in(*state, "d");
    struct ttf_writer *writer = small_create(ttf_io_posix(), path);
    int64_t i;

    for (i = 0; i < 3; i++)
        assert_int_equal(small_slot(writer, i), 0);
    assert_int_equal(ttf_writer_event(writer, "door", 1, 2, "opened", NULL, NULL), 0);
    assert_int_equal(ttf_writer_seal(writer, "count", NULL, NULL), 0);
    ttf_writer_close(writer);
    return path;
}

static const char *running_dataset(void **state)
{
    const char *path = in(*state, "d");
    struct ttf_writer *writer = small_create(ttf_io_posix(), path);
    int64_t i;

    for (i = 0; i < 3; i++)
        assert_int_equal(small_slot(writer, i), 0);
    ttf_writer_close(writer);
    return path;
}

static void a_whole_dataset_has_no_findings(void **state)
{
    struct ttf_verify_report report = verified(sealed_dataset(state));

    assert_false(report.damaged);
    assert_int_equal(report.n_findings, 0);
    assert_true(report.sealed && strlen(report.digest) == 64);
    assert_int_equal(report.slots, 3);
    assert_int_equal(report.lines, 7);
    ttf_verify_report_free(&report);
}

static void the_changed_file_and_its_slot_are_named(void **state)
{
    const char *path = sealed_dataset(state);
    struct ttf_verify_report report;

    write_text(in(path, "frames/main/000001.tif"), "changed", 7);
    assert_int_equal(unlink(in(path, "frames/main/000002.tif")), 0);
    write_text(in(path, "frames/main/000009.tif"), "added", 5);
    write_text(in(path, "README.txt"), "mine", 4);
    report = verified(path);
    assert_true(report.damaged);
    assert_true(found(&report, TTF_FINDING_DAMAGE, "frames/main/000001.tif", 1, "7 bytes long"));
    assert_true(found(&report, TTF_FINDING_DAMAGE, "frames/main/000002.tif", 2, "missing"));
    assert_true(found(&report, TTF_FINDING_DAMAGE, "frames/main/000009.tif", -1, "not covered"));
    assert_true(found(&report, TTF_FINDING_NOTE, "README.txt", -1, "does not belong"));
    assert_int_equal(report.n_of[TTF_FINDING_DAMAGE], 3);
    ttf_verify_report_free(&report);
}

/* In place: faster than writing the file anew. */
static void flip(const char *path, size_t at)
{
    int file = open(path, O_RDWR | O_CLOEXEC);
    char c;

    assert_true(file >= 0);
    assert_int_equal(pread(file, &c, 1, (off_t)at), 1);
    c = (char)(c ^ (1 << (at % 8)));
    assert_int_equal(pwrite(file, &c, 1, (off_t)at), 1);
    close(file);
}

static void every_flipped_bit_of_a_sealed_dataset_is_found(void **state)
{
    static const char *const files[] = {"dataset.json", "records.jsonl", "events.jsonl",
                                        "plans/0.yaml", "plans/0.json",  "frames/main/000001.tif",
                                        "SHA256SUMS"};
    struct ttf_verify_options options = {.deep = true};
    struct ttf_verify_report report;
    const char *path = sealed_dataset(state);
    char full[512];
    size_t i, k, n;
    char *text;
    int r;

    for (i = 0; i < TTF_COUNT_OF(files); i++) {
        snprintf(full, sizeof(full), "%s/%s", path, files[i]);
        text = file_text(full, &n);
        for (k = 0; k < n; k++) {
            flip(full, k);
            r = ttf_verify(ttf_io_posix(), path, &options, &report, NULL);
            flip(full, k);
            if (r == -ENOTSUP)
                continue; /* another version: refused */
            assert_int_equal(r, 0);
            if (!report.damaged)
                fail_msg("%s: bit %zu of byte %zu went unseen", files[i], k % 8, k);
            ttf_verify_report_free(&report);
        }
        free(text);
    }
}

static void a_wrong_line_is_named_and_the_rest_still_checked(void **state)
{
    const char *path = running_dataset(state);
    struct ttf_verify_report report;
    char *text, *slot;
    struct ttf_writer *writer;
    struct ttf_err err = {0};
    size_t n;

    text = file_text(in(path, "records.jsonl"), &n);
    slot = strstr(text, "\"index\":1");
    assert_non_null(slot);
    slot[8] = '7';
    write_text(in(path, "records.jsonl"), text, n);
    free(text);
    write_text(in(path, "frames/main/000002.tif"), "changed", 7);
    report = verified(path);
    assert_true(found(&report, TTF_FINDING_DAMAGE, "records.jsonl:4", 1, "crc"));
    assert_true(found(&report, TTF_FINDING_DAMAGE, "frames/main/000002.tif", 2, "7 bytes"));
    assert_int_equal(report.n_of[TTF_FINDING_DAMAGE], 2);
    ttf_verify_report_free(&report);
    assert_int_equal(ttf_writer_open(ttf_io_posix(), path, &writer, &err), -TTF_EDAMAGED);
    assert_non_null(strstr(err.where, "records.jsonl:4"));
}

static void a_frame_that_the_seal_leaves_out_is_damage(void **state)
{
    const char *path = sealed_dataset(state);
    struct ttf_verify_report report;

    assert_int_equal(run("sed -i /000001.tif/d '%s/SHA256SUMS'", path), 0);
    report = verified(path);
    assert_true(
        found(&report, TTF_FINDING_DAMAGE, "frames/main/000001.tif", 1, "not covered by the seal"));
    ttf_verify_report_free(&report);
}

static void a_frame_that_is_gone_when_sealing_is_missed(void **state)
{
    const char *path = running_dataset(state);
    struct ttf_verify_report report;
    struct ttf_writer *writer;

    assert_int_equal(unlink(in(path, "frames/main/000001.tif")), 0);
    assert_int_equal(ttf_writer_open(ttf_io_posix(), path, &writer, NULL), 0);
    assert_int_equal(ttf_writer_seal(writer, "count", NULL, NULL), 0);
    ttf_writer_close(writer);
    assert_int_not_equal(sha256sum_check(path), 0);
    report = verified(path);
    assert_true(found(&report, TTF_FINDING_DAMAGE, "frames/main/000001.tif", 1, "missing"));
    ttf_verify_report_free(&report);
}

/* A line as a writer would have framed it, whatever it says. Returns its number in the file. */
static void append_line(const char *path, const char *name, int seq, const char *type,
                        const char *fields)
{
    char line[1024], whole[1100];
    size_t n = (size_t)snprintf(line, sizeof line, "{\"type\":\"%s\",\"seq\":%d%s%s", type, seq,
                                fields[0] ? "," : "", fields);
    FILE *file = fopen(in(path, "%s", name), "ab");

    assert_non_null(file);
    n = (size_t)snprintf(whole, sizeof whole, "%s,\"crc\":\"%08x\"}\n", line,
                         ttf_crc32(0, line, n));
    assert_int_equal(fwrite(whole, 1, n, file), n);
    assert_int_equal(fclose(file), 0);
}

/* Lines whose crc holds and that contradict the others: each is named by its line, with the reason. */
static void lines_that_contradict_others_are_named(void **state)
{
#define SLOT(index) "\"index\":" #index ",\"segment\":0,\"due_ns\":1,"
#define FILES       "\"n_averaged\":1,\"files\":[]"
    static const struct {
        const char *type, *fields, *says;
    } cases[] = {
        {"slot", SLOT(0) "\"result\":\"missed\",\"reason\":\"x\"", "its index does not rise"},
        {"slot", "\"index\":9,\"segment\":4,\"due_ns\":1,\"result\":\"missed\",\"reason\":\"x\"",
         "its segment has no line before it"},
        {"slot", SLOT(9) "\"result\":\"eaten\"", "result"},
        {"slot", SLOT(9) "\"result\":\"captured\",\"images\":[{\"stream\":\"main\"}]",
         "has no files and does not say why"},
        {"slot",
         SLOT(9) "\"result\":\"captured\",\"images\":[{\"stream\":\"main\",\"calibration\":"
                 "\"cal-x\"," FILES "}]",
         "names calibration cal-x, which no line before it brought"},
        {"slot",
         SLOT(9) "\"result\":\"captured\",\"images\":[{\"stream\":\"main\",\"files\":[{\"role\":"
                 "\"developed\",\"path\":\"../../etc/passwd\",\"bytes\":1,\"sha256\":\"0\"}]}]",
         "path"},
        {"segment",
         "\"segment\":5,\"first_index\":9,\"origin_ns\":1,\"trust\":\"none\",\"interval_ns\":1",
         "its number leaves others out"},
        {"segment",
         "\"segment\":1,\"first_index\":9,\"origin_ns\":1,\"trust\":\"none\",\"interval_ns\":1,"
         "\"plan\":7",
         "its plan has no line before it"},
        {"segment", "\"segment\":1,\"first_index\":9", "is missing"},
        {"end", "\"reason\":\"count\"", "slots is missing"},
        {"plan", "\"plan\":1,\"files\":[{\"path\":\"plans/1.yaml\",\"bytes\":1}]", "sha256"},
    };
#undef SLOT
#undef FILES

    for (size_t i = 0; i < TTF_COUNT_OF(cases); i++) {
        const char *path = in(*state, "d%zu", i);
        struct ttf_writer *writer = small_create(quick_io(), path);
        struct ttf_verify_options options = {.deep = true};
        struct ttf_verify_report report;
        bool said = false;

        assert_int_equal(small_slot(writer, 0), 0);
        ttf_writer_close(writer);
        append_line(path, "records.jsonl", 3, cases[i].type, cases[i].fields);
        assert_int_equal(ttf_verify(ttf_io_posix(), path, &options, &report, NULL), 0);
        for (unsigned k = 0; k < report.n_findings; k++)
            said = said || (strcmp(report.findings[k].file, "records.jsonl:4") == 0 &&
                            report.findings[k].severity == TTF_FINDING_DAMAGE &&
                            strstr(report.findings[k].text, cases[i].says));
        if (!said || !report.damaged)
            fail_msg("case %zu: \"%s\" is not said, but %s", i, cases[i].says,
                     report.n_findings ? report.findings[0].text : "nothing");
        ttf_verify_report_free(&report);
    }
}

/* The "end" line counts slots; each count that is not so is damage. */
static void an_end_that_counts_wrong_is_damage(void **state)
{
    static const char *const counts[] = {"\"slots\":2,\"captured\":1",
                                         "\"slots\":1",
                                         "\"slots\":1,\"captured\":1,\"partial\":1",
                                         "\"slots\":1,\"captured\":1,\"missed\":1",
                                         "\"slots\":1,\"captured\":1,\"failed\":1",
                                         "\"slots\":1,\"captured\":1,\"paused\":1",
                                         "\"slots\":1,\"captured\":1,\"power\":1",
                                         "\"slots\":1,\"captured\":1"};

    for (size_t i = 0; i < TTF_COUNT_OF(counts); i++) {
        const char *path = in(*state, "d%zu", i);
        struct ttf_writer *writer = small_create(quick_io(), path);
        struct ttf_verify_options options = {.deep = false};
        struct ttf_verify_report report;
        char fields[200];

        assert_int_equal(small_slot(writer, 0), 0);
        ttf_writer_close(writer);
        (void)snprintf(fields, sizeof fields, "\"reason\":\"count\",%s", counts[i]);
        append_line(path, "records.jsonl", 3, "end", fields);
        assert_int_equal(ttf_verify(ttf_io_posix(), path, &options, &report, NULL), 0);
        if (report.damaged != (i + 1 < TTF_COUNT_OF(counts)))
            fail_msg("%s: damaged %d", counts[i], report.damaged);
        ttf_verify_report_free(&report);
    }
}

static void a_lost_line_is_damage(void **state)
{
    const char *path = running_dataset(state);
    struct ttf_verify_report report;

    assert_int_equal(run("sed -i 4d '%s/records.jsonl'", path), 0);
    report = verified(path);
    assert_true(found(&report, TTF_FINDING_DAMAGE, "records.jsonl:4", -1, "lost"));
    ttf_verify_report_free(&report);
}

static void lost_last_lines_are_damage_because_sha256sums_remembers(void **state)
{
    const char *path = running_dataset(state);
    struct ttf_verify_report report;
    struct ttf_writer *writer;
    struct ttf_err err = {0};

    assert_int_equal(run("sed -i 5d '%s/records.jsonl'", path), 0);
    report = verified(path);
    assert_true(found(&report, TTF_FINDING_DAMAGE, "records.jsonl", 2, "000002.tif"));
    ttf_verify_report_free(&report);
    assert_int_equal(ttf_writer_open(ttf_io_posix(), path, &writer, &err), -TTF_EDAMAGED);
    assert_true(exists(in(path, "frames/main/000002.tif")));
}

static void what_a_crash_leaves_is_no_damage(void **state)
{
    const char *path = running_dataset(state);
    struct ttf_verify_report report;

    write_text(in(path, "frames/main/000003.tif.tmp"), "x", 1);
    write_text(in(path, "frames/main/000003.tif"), "x", 1);
    write_text(in(path, "SHA256SUMS"), "", 0);
    assert_int_equal(run("printf '{\"type\":\"sl' >> '%s/records.jsonl'", path), 0);
    report = verified(path);
    assert_false(report.damaged);
    assert_true(found(&report, TTF_FINDING_LEFTOVER, "frames/main/000003.tif.tmp", 3, "temporary"));
    assert_true(found(&report, TTF_FINDING_LEFTOVER, "frames/main/000003.tif", 3, "no record"));
    assert_true(found(&report, TTF_FINDING_LEFTOVER, "SHA256SUMS", -1, "behind"));
    assert_true(found(&report, TTF_FINDING_LEFTOVER, "records.jsonl", -1, "11 bytes"));
    assert_int_equal(report.n_findings, 4);
    ttf_verify_report_free(&report);
}

static void what_is_no_dataset_is_said_so(void **state)
{
    struct ttf_verify_options options = {.deep = true};
    struct ttf_verify_report report;

    assert_int_equal(ttf_verify(ttf_io_posix(), *state, &options, &report, NULL), -ENOENT);
}

static void threads_find_the_same(void **state)
{
    struct ttf_verify_options options = {.deep = true};
    struct ttf_verify_report one, many;
    char path[512];
    struct ttf_writer *writer;
    int64_t i;

    snprintf(path, sizeof(path), "%s/d", (char *)*state);
    writer = small_create(ttf_io_posix(), path);
    for (i = 0; i < 150; i++)
        assert_int_equal(small_slot(writer, i), 0);
    ttf_writer_close(writer);
    for (i = 0; i < 150; i += 7)
        assert_int_equal(unlink(in(path, "frames/main/%06d.tif", (int)i)), 0);
    assert_int_equal(ttf_verify(ttf_io_posix(), path, &options, &one, NULL), 0);
    options.pool = ttf_pool_create(3);
    assert_int_equal(ttf_verify(ttf_io_posix(), path, &options, &many, NULL), 0);
    ttf_pool_destroy(options.pool);
    assert_int_equal(one.n_findings, 22);
    assert_int_equal(many.n_findings, 22);
    assert_memory_equal(one.findings, many.findings, 22 * sizeof(*one.findings));
    assert_int_equal(many.hashed_bytes, one.hashed_bytes);
    ttf_verify_report_free(&one);
    ttf_verify_report_free(&many);
}

int main(void)
{
#define T(f) cmocka_unit_test_setup_teardown(f, folder_setup, folder_teardown)
    const struct CMUnitTest tests[] = {
        T(a_whole_dataset_has_no_findings),
        T(the_changed_file_and_its_slot_are_named),
        T(every_flipped_bit_of_a_sealed_dataset_is_found),
        T(a_wrong_line_is_named_and_the_rest_still_checked),
        T(a_frame_that_the_seal_leaves_out_is_damage),
        T(a_frame_that_is_gone_when_sealing_is_missed),
        T(lines_that_contradict_others_are_named),
        T(an_end_that_counts_wrong_is_damage),
        T(a_lost_line_is_damage),
        T(lost_last_lines_are_damage_because_sha256sums_remembers),
        T(what_a_crash_leaves_is_no_damage),
        T(what_is_no_dataset_is_said_so),
        T(threads_find_the_same),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
