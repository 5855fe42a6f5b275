/* SPDX-License-Identifier: Apache-2.0 */
/* Datasets that tests/datasets/make.py makes from FORMAT.md alone: read, verified, gone on with. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "lines.h"
#include "store_test.h"
#include "ttf/dataset/reader.h"
#include "ttf/dataset/verify.h"

static int made_setup(void **state)
{
    if (folder_setup(state) != 0)
        return -1;
    return run("python3 '%s/tests/datasets/make.py' '%s/made'", STORE_SOURCES, (char *)*state);
}

static struct ttf_reader *opened(void **state, const char *name)
{
    struct ttf_reader *reader = NULL;
    struct ttf_err err = {0};

    if (ttf_reader_open(ttf_io_posix(), in(*state, "made/%s", name), &reader, &err) != 0)
        fail_msg("%s: %s: %s", name, err.where, err.what);
    return reader;
}

static struct ttf_slot_record slot(struct ttf_reader *reader, int64_t i)
{
    struct ttf_slot_record record;
    struct ttf_err err = {0};

    if (ttf_reader_slot(reader, i, &record, &err) != 0)
        fail_msg("slot %lld: %s", (long long)i, err.what);
    return record;
}

static void verify_accepts_every_one(void **state)
{
    static const struct {
        const char *name;
        int slots, files, notes;
        bool sealed;
    } cases[] = {
        {"example", 1, 3, 0, true},
        {"bracket", 3, 11, 0, true},
        {"two-channels", 4, 9, 0, true},
        {"two-cameras", 2, 6, 0, true},
        {"average-of-8", 2, 4, 0, true},
        {"three-segments", 9, 7, 0, false},
        {"changed-calibration", 4, 8, 0, true},
        {"sagging-supply", 3, 5, 0, true},
        {"future-minor", 2, 9, 2, true},
    };
    struct ttf_verify_options options = {.deep = true};
    struct ttf_verify_report report;
    struct ttf_err err = {0};
    size_t i;

    for (i = 0; i < TTF_COUNT_OF(cases); i++) {
        const char *path = in(*state, "made/%s", cases[i].name);

        assert_int_equal(ttf_verify(ttf_io_posix(), path, &options, &report, &err), 0);
        if (report.damaged || report.n_of[TTF_FINDING_LEFTOVER] > 0)
            fail_msg("%s: %s: %s", cases[i].name, report.findings[0].file, report.findings[0].text);
        assert_int_equal(report.n_of[TTF_FINDING_NOTE], cases[i].notes);
        assert_int_equal(report.slots, cases[i].slots);
        assert_int_equal(report.sealed, cases[i].sealed);
        assert_true(report.files >= cases[i].files);
        assert_true(report.hashed_bytes > 0);
        assert_int_equal(sha256sum_check(path), 0);
        ttf_verify_report_free(&report);
    }
}

static void a_bracket_has_an_image_for_each_exposure(void **state)
{
    static const double relative[] = {0.25, 1, 4};
    struct ttf_reader *reader = opened(state, "bracket");
    struct ttf_slot_record r;
    unsigned b;
    char path[64];
    int64_t i;

    assert_int_equal(ttf_reader_summary(reader)->slots, 3);
    for (i = 0; i < 3; i++) {
        r = slot(reader, i);
        assert_int_equal(r.n_images, 3);
        for (b = 0; b < 3; b++) {
            assert_int_equal(r.images[b].bracket, b);
            assert_true(r.images[b].relative_exposure == relative[b]);
            snprintf(path, sizeof(path), "frames/main/%06d.b%u.tif", (int)i, b);
            assert_string_equal(r.images[b].files[0].path, path);
        }
        ttf_slot_record_free(&r);
    }
    ttf_reader_close(reader);
}

static void two_channels_are_two_streams(void **state)
{
    struct ttf_reader *reader = opened(state, "two-channels");
    const struct ttf_manifest *m = ttf_reader_manifest(reader);
    struct ttf_slot_record r = slot(reader, 3);

    assert_int_equal(m->n_streams, 2);
    assert_string_equal(ttf_manifest_primary(m)->id, "white");
    assert_string_equal(m->streams[1].channel, "raking-left");
    assert_string_equal(m->channels[1].title, "from the left");
    assert_int_equal(r.result, TTF_RESULT_PARTIAL);
    assert_string_equal(r.reason, "lamp left tripped");
    assert_string_equal(r.images[1].lacking, "lamp tripped");
    assert_int_equal(r.images[1].n_files, 0);
    assert_int_equal(ttf_reader_summary(reader)->counts[TTF_RESULT_PARTIAL], 1);
    ttf_slot_record_free(&r);
    ttf_reader_close(reader);
}

static void two_cameras_may_differ_in_size(void **state)
{
    struct ttf_reader *reader = opened(state, "two-cameras");
    const struct ttf_manifest *m = ttf_reader_manifest(reader);

    assert_int_equal(m->n_cameras, 2);
    assert_string_equal(m->cameras[0].cfa, "RGGB");
    assert_int_equal(m->cameras[0].raw_bits, 12);
    assert_int_equal(m->cameras[1].raw_width, 0);
    assert_string_equal(ttf_manifest_stream(m, "side")->camera, "side");
    assert_int_equal(ttf_manifest_stream(m, "side")->width, 2);
    assert_string_equal(m->group_member, "both");
    ttf_reader_close(reader);
}

static void an_average_names_all_its_shots(void **state)
{
    struct ttf_reader *reader = opened(state, "average-of-8");
    struct ttf_slot_record r = slot(reader, 1);
    const struct ttf_image *image = &r.images[0];
    unsigned i, refused = 0;

    assert_int_equal(image->n_averaged, 8);
    assert_int_equal(image->n_shots, 9);
    for (i = 0; i < 9; i++)
        refused += image->shots[i].refused[0] != '\0';
    assert_int_equal(refused, 1);
    assert_string_equal(image->shots[4].refused, "corrupt");
    assert_int_equal(image->shots[0].start_ns, INT64_C(15000000000));
    assert_int_equal(image->shots[8].granted.lens_mdpt, 3000);
    ttf_slot_record_free(&r);
    ttf_reader_close(reader);
}

static void segments_map_slots_to_time_as_corrected_last(void **state)
{
    static const int64_t utc0 = INT64_C(1790000000000000000);
    struct ttf_reader *reader = opened(state, "three-segments");
    const struct ttf_reader_summary *sum = ttf_reader_summary(reader);
    struct ttf_segment s;
    struct ttf_slot_record r;

    assert_int_equal(sum->n_segments, 3);
    assert_int_equal(sum->n_plans, 1);
    assert_int_equal(sum->counts[TTF_RESULT_POWER], 2);
    assert_int_equal(sum->counts[TTF_RESULT_MISSED], 1);
    assert_false(sum->ended || sum->sealed);
    assert_int_equal(ttf_reader_segment(reader, 1, &s), 0);
    assert_int_equal(s.gap_ns, 20 * TTF_NS_PER_S);
    assert_int_equal(ttf_reader_segment(reader, 2, &s), 0);
    assert_true(s.corrects);
    assert_string_equal(s.trust, "ntp");
    assert_int_equal(s.gap_ns, 3590 * TTF_NS_PER_S);
    assert_int_equal(ttf_reader_segment(reader, 3, &s), -ENOENT);
    r = slot(reader, ttf_reader_find(reader, 5));
    assert_int_equal(ttf_reader_due_utc_ns(reader, &r), utc0 + 50 * TTF_NS_PER_S);
    ttf_slot_record_free(&r);
    r = slot(reader, ttf_reader_find(reader, 6)); /* written before anybody knew the time */
    assert_int_equal(ttf_reader_due_utc_ns(reader, &r), utc0 + 3660 * TTF_NS_PER_S);
    ttf_slot_record_free(&r);
    assert_int_equal(ttf_reader_find(reader, 9), -ENOENT);
    ttf_reader_close(reader);
}

static void each_image_names_its_own_calibration(void **state)
{
    struct ttf_reader *reader = opened(state, "changed-calibration");
    struct ttf_slot_record before = slot(reader, 1), after = slot(reader, 2);

    assert_int_equal(ttf_reader_summary(reader)->n_calibrations, 2);
    assert_string_equal(before.images[0].calibration, "cal-a");
    assert_string_equal(after.images[0].calibration, "cal-b");
    ttf_slot_record_free(&before);
    ttf_slot_record_free(&after);
    ttf_reader_close(reader);
}

static void a_sagging_supply_is_read_as_a_sensor_and_as_a_flag(void **state)
{
    struct ttf_reader *reader = opened(state, "sagging-supply");

    for (int64_t i = 0; i < 3; i++) {
        struct ttf_slot_record r = slot(reader, i);

        assert_string_equal(r.sensors[0].kind, "undervoltage");
        assert_int_equal(r.sensors[0].value, i == 1);
        assert_string_equal(r.images[0].flags, i == 1 ? "late,under-voltage" : "");
        ttf_slot_record_free(&r);
    }
    ttf_reader_close(reader);
}

static void what_a_later_version_adds_is_passed_over(void **state)
{
    struct ttf_reader *reader = opened(state, "future-minor");
    const struct ttf_manifest *m = ttf_reader_manifest(reader);
    struct ttf_slot_record r = slot(reader, 1);

    assert_int_equal(m->n_streams, 1); /* samples of "u32" are unknown */
    assert_string_equal(ttf_manifest_primary(m)->id, "main");
    assert_int_equal(ttf_reader_summary(reader)->slots, 2);
    assert_true(ttf_reader_summary(reader)->ended);
    assert_int_equal(r.images[0].n_files, 1);
    assert_string_equal(r.images[0].files[0].role, "developed");
    assert_string_equal(r.images[0].flags, "moonlit,saturated");
    assert_string_equal(r.sensors[0].kind, "smell_milli");
    ttf_slot_record_free(&r);
    ttf_reader_close(reader);
}

static void what_a_later_version_adds_is_kept_by_writing_on(void **state)
{
    const char *path = in(*state, "made/future-minor");
    struct ttf_writer *writer;
    struct ttf_segment s;
    struct ttf_err err = {0};

    assert_int_equal(ttf_writer_open(ttf_io_posix(), path, &writer, &err), 0);
    s = ttf_writer_state(writer)->last_segment;
    s.segment = 1;
    s.first_index = 2;
    assert_int_equal(ttf_writer_segment(writer, &s, &err), 0);
    assert_int_equal(small_slot(writer, 2), 0);
    assert_int_equal(sha256sum_check(path), 0);
    assert_int_equal(run("grep -q stokes '%s/SHA256SUMS'", path), 0);
    assert_int_equal(ttf_writer_seal(writer, "count", NULL, &err), 0);
    ttf_writer_close(writer);
    assert_int_equal(sha256sum_check(path), 0);
    assert_int_equal(run("grep -q orbits/1.txt '%s/SHA256SUMS'", path), 0);
    assert_int_equal(run("grep -q notes.jsonl '%s/SHA256SUMS'", path), 1);
    assert_int_equal(run("grep -q preview '%s/SHA256SUMS'", path), 1);
    assert_int_equal(run("grep -q prediction '%s/records.jsonl'", path), 0);
}

static void what_would_be_misread_is_refused_by_name(void **state)
{
    struct ttf_verify_options options = {.deep = true};
    struct ttf_verify_report report;
    struct ttf_reader *reader;
    struct ttf_writer *writer;
    struct ttf_err err = {0};
    struct ttf_io *io = ttf_io_posix();
    const char *path = in(*state, "made/required-unknown");

    assert_int_equal(ttf_reader_open(io, path, &reader, &err), -ENOTSUP);
    assert_non_null(strstr(err.what, "time-travel"));
    assert_int_equal(ttf_writer_open(io, path, &writer, &err), -ENOTSUP);
    assert_int_equal(ttf_verify(io, path, &options, &report, &err), -ENOTSUP);
    path = in(*state, "made/major-two");
    assert_int_equal(ttf_reader_open(io, path, &reader, &err), -ENOTSUP);
    assert_non_null(strstr(err.what, "format.major is 2"));
}

static void the_example_of_the_document_is_true(void **state)
{
    char *document = file_text(STORE_SOURCES "/dataset/FORMAT.md", NULL), *made;
    static const char *const files[] = {"dataset.json", "records.jsonl", "SHA256SUMS"};
    size_t i;

    for (i = 0; i < TTF_COUNT_OF(files); i++) {
        made = file_text(in(*state, "made/example/%s", files[i]), NULL);
        if (!strstr(document, made))
            fail_msg("FORMAT.md does not hold the example's %s as make.py makes it", files[i]);
        free(made);
    }
    free(document);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(verify_accepts_every_one),
        cmocka_unit_test(a_bracket_has_an_image_for_each_exposure),
        cmocka_unit_test(two_channels_are_two_streams),
        cmocka_unit_test(two_cameras_may_differ_in_size),
        cmocka_unit_test(an_average_names_all_its_shots),
        cmocka_unit_test(segments_map_slots_to_time_as_corrected_last),
        cmocka_unit_test(each_image_names_its_own_calibration),
        cmocka_unit_test(a_sagging_supply_is_read_as_a_sensor_and_as_a_flag),
        cmocka_unit_test(what_a_later_version_adds_is_passed_over),
        cmocka_unit_test(what_a_later_version_adds_is_kept_by_writing_on),
        cmocka_unit_test(what_would_be_misread_is_refused_by_name),
        cmocka_unit_test(the_example_of_the_document_is_true),
    };

    return cmocka_run_group_tests(tests, made_setup, folder_teardown);
}
