/* SPDX-License-Identifier: Apache-2.0 */
/* test_calibration_folder.c: a calibration is there whole, or gone, whichever operation of its removal was the last. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <errno.h>
#include <stdio.h>
#include <string.h>

#include "calibration_folder.h"
#include "unit/dataset_store/store_ios.h"
#include "unit/dataset_store/store_test.h"

static void make(const char *above)
{
    assert_int_equal(run("mkdir -p '%s/grass' '%s/moss' && cd '%s/grass' && echo dark >dark.tif && "
                         "echo flat >flat.tif && echo {} >calibration.json && cp * ../moss",
                         above, above, above),
                     0);
}

/* As far as it comes; 0: to its end. */
static int take_away(struct ttf_io *io, const char *above)
{
    int r = calibration_folder_put_aside(io, above, "grass", NULL);

    return r < 0 ? r : calibration_folder_sweep(io, above, NULL);
}

static void a_removal_that_is_cut_off_leaves_it_whole_or_gone(void **state)
{
    const char *const above = *state; /* nothing else lies in it */
    bool done = false;
    long at;

    for (at = 1; !done; at++) {
        struct cue cue = {.at = at, .error = EIO, .for_ever = true};
        struct ttf_io *io = ttf_io_faulty_create(quick_io(), cue_fault, &cue);

        assert_non_null(io);
        make(above);
        done = take_away(io, above) == 0;
        ttf_io_faulty_destroy(io);
        if (exists(in(above, "grass")))
            assert_int_equal(run("diff -r '%s/grass' '%s/moss'", above, above), 0);
        else
            assert_true(at > 1);
        /* The next start. */
        assert_int_equal(calibration_folder_sweep(quick_io(), above, NULL), 0);
        assert_false(exists(in(above, ".grass.removed")));
        assert_true(exists(in(above, "moss/flat.tif")));
        assert_int_equal(run("rm -rf '%s/grass' '%s/moss'", above, above), 0);
    }
    assert_int_equal(at - 1,
                     8); /* rename, sync, three files, the folder, sync: each was the last */
}

/* The new name of what is away is on the disk before anything in it is lost: a power cut would bring back a folder of half of it. */
static void nothing_is_lost_before_it_is_away_for_good(void **state)
{
    char log[2000] = "";
    struct cue cue = {.log = log, .log_room = sizeof(log)};
    struct ttf_io *io = ttf_io_faulty_create(quick_io(), cue_fault, &cue);
    const char *rename, *sync, *unlink;

    assert_non_null(io);
    make(*state);
    assert_int_equal(take_away(io, *state), 0);
    ttf_io_faulty_destroy(io);
    rename = strstr(log, "rename ");
    sync = strstr(log, "sync_dir ");
    unlink = strstr(log, "unlink ");
    assert_true(rename && sync && unlink && rename < sync && sync < unlink);
}

static void a_name_that_is_none_is_said_so(void **state)
{
    assert_int_equal(calibration_folder_put_aside(quick_io(), *state, "grass", NULL), -ENOENT);
    assert_int_equal(calibration_folder_sweep(quick_io(), in(*state, "none"), NULL), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(a_removal_that_is_cut_off_leaves_it_whole_or_gone,
                                        folder_setup, folder_teardown),
        cmocka_unit_test_setup_teardown(nothing_is_lost_before_it_is_away_for_good, folder_setup,
                                        folder_teardown),
        cmocka_unit_test_setup_teardown(a_name_that_is_none_is_said_so, folder_setup,
                                        folder_teardown),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
