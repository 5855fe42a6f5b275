/* SPDX-License-Identifier: Apache-2.0 */
/* test_shelf.c: the data folder is opened again when its path leads to another one, and who reads keeps what he has. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <errno.h>
#include <stdio.h>
#include <unistd.h>

#include "scratch.h"
#include "shelf.h"

static bool has(const struct shelf *shelf, const char *dataset)
{
    int fd = folder_file(&shelf->folder, dataset, "dataset.json", NULL);

    if (fd >= 0)
        (void)close(fd);
    return fd >= 0;
}

static void who_has_one_keeps_it_while_another_is_opened(void **state)
{
    struct shelves *shelves;
    struct shelf *before, *same, *after;

    (void)state;
    scratch_file("data/grass/dataset.json", "{}", 2);
    assert_int_equal(shelves_create("data", &shelves, NULL), 0);
    before = shelves_take(shelves);
    same = shelves_take(shelves);
    assert_ptr_equal(before, same);
    shelves_give(shelves, same);
    assert_int_equal(rename("data", "disk"), 0);
    assert_false(shelves_other(shelves, before)); /* none is no other one */
    scratch_file("data/moss/dataset.json", "{}", 2);
    assert_true(shelves_other(shelves, before));
    after = shelves_take(shelves);
    assert_ptr_not_equal(after, before);
    assert_ptr_not_equal(after->summaries,
                         before->summaries); /* nothing is remembered of another's names */
    assert_ptr_not_equal(after->derived, before->derived);
    assert_false(shelves_other(shelves, after));
    assert_true(has(after, "moss") && !has(after, "grass"));
    assert_true(has(before, "grass") && !has(before, "moss"));
    shelves_give(shelves, before);
    shelves_give(shelves, after);
    after = shelves_take(shelves);
    assert_true(has(after, "moss"));
    shelves_give(shelves, after);
    shelves_destroy(shelves);
}

static void without_a_folder_there_are_none(void **state)
{
    struct shelves *shelves = NULL;
    struct ttf_err err;

    (void)state;
    assert_int_equal(shelves_create("none", &shelves, &err), -ENOENT);
    assert_int_equal(err.code, -ENOENT);
    assert_null(shelves);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(who_has_one_keeps_it_while_another_is_opened, scratch_make,
                                        scratch_remove),
        cmocka_unit_test_setup_teardown(without_a_folder_there_are_none, scratch_make,
                                        scratch_remove),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
