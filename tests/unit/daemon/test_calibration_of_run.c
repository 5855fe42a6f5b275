/* SPDX-License-Identifier: Apache-2.0 */
/* test_calibration_of_run.c: what a run that is gone on with is developed with. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <errno.h>
#include <stdio.h>
#include <string.h>

#include "calibration_of_run.h"
#include "ttf/dataset/writer.h"
#include "unit/dataset_store/store_test.h"

static struct ttf_writer *begin_of(const char *path, const char *quantity)
{
    struct ttf_manifest manifest;
    struct ttf_writer *writer = NULL;

    small_manifest(&manifest);
    (void)snprintf(manifest.streams[0].quantity, sizeof manifest.streams[0].quantity, "%s",
                   quantity);
    assert_int_equal(
        ttf_writer_create(ttf_io_posix(), path, &manifest, "interval: 10s\n", "{}", &writer, NULL),
        0);
    return writer;
}

static struct ttf_writer *begin(const char *path)
{
    return begin_of(path, "reflectance");
}

static struct calibrations *in_use(void **state, const char *configured)
{
    struct calibrations *c =
        calibrations_create(ttf_io_posix(), NULL, in(*state, "state"), configured);

    assert_non_null(c);
    return c;
}

static void expect(void **state, const char *dataset, bool exists, const char *wanted)
{
    struct calibrations *c = in_use(state, "/somewhere/in-use");
    char got[CALIBRATION_PATH] = "";
    struct ttf_err err = {0};
    int r = calibration_of_run(c, ttf_io_posix(), dataset, exists, got, &err);

    calibrations_destroy(c);
    if (r != (wanted ? 1 : 0))
        fail_msg("%d: %s", r, err.what);
    if (wanted)
        assert_string_equal(got, wanted);
}

/* A folder with what might be a calibration: nothing reads it here. */
static const char *calibration(void **state, const char *name)
{
    const char *folder = in(*state, "%s", name);

    assert_int_equal(ttf_io_mkdirs(ttf_io_posix(), folder, NULL), 0);
    write_text(in(*state, "%s/calibration.json", name), "{}", 2);
    return folder;
}

static void a_new_run_takes_the_one_in_use(void **state)
{
    expect(state, in(*state, "grass"), false, "/somewhere/in-use");
}

static void one_gone_on_with_keeps_its_own(void **state)
{
    const char *grass = in(*state, "grass");
    struct ttf_writer *writer = begin(grass);

    assert_int_equal(ttf_writer_calibration(writer, "first", calibration(state, "a"), NULL), 0);
    ttf_writer_close(writer);
    expect(state, grass, true, in(*state, "grass/calibration/first"));
    assert_int_equal(ttf_writer_open(ttf_io_posix(), grass, &writer, NULL), 0);
    assert_int_equal(ttf_writer_calibration(writer, "second", calibration(state, "b"), NULL), 0);
    ttf_writer_close(writer);
    expect(state, grass, true, in(*state, "grass/calibration/second"));
}

/* The power went while it was copied: files of it lie there, and no line names them. */
static void half_a_calibration_is_none(void **state)
{
    const char *grass = in(*state, "grass");
    struct ttf_writer *writer = begin(grass);

    ttf_writer_close(writer);
    (void)calibration(state, "grass/calibration/half");
    expect(state, grass, true, "/somewhere/in-use");
    assert_int_equal(ttf_writer_open(ttf_io_posix(), grass, &writer, NULL), 0);
    assert_int_equal(ttf_writer_calibration(writer, "whole", calibration(state, "a"), NULL), 0);
    ttf_writer_close(writer);
    expect(state, grass, true, in(*state, "grass/calibration/whole"));
}

/* Of a dataset that was to have none, whatever is in use now. */
static void one_without_goes_on_without(void **state)
{
    const char *grass = in(*state, "grass");

    ttf_writer_close(begin_of(grass, "linear"));
    expect(state, grass, true, NULL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(a_new_run_takes_the_one_in_use, folder_setup,
                                        folder_teardown),
        cmocka_unit_test_setup_teardown(one_gone_on_with_keeps_its_own, folder_setup,
                                        folder_teardown),
        cmocka_unit_test_setup_teardown(half_a_calibration_is_none, folder_setup, folder_teardown),
        cmocka_unit_test_setup_teardown(one_without_goes_on_without, folder_setup, folder_teardown),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
