/* SPDX-License-Identifier: Apache-2.0 */
#include "living.h"

#include "cmocka_includes.h"

#include <errno.h>
#include <string.h>

void living_init(struct sim_run *run)
{
    sim_run_init(run);
    run->control = ttf_control_create();
    assert_non_null(run->control);
}

void living_finish(struct sim_run *run)
{
    ttf_control_destroy(run->control);
    sim_run_finish(run);
}

int64_t living_ask(struct sim_run *run, const struct ttf_ask *ask)
{
    int64_t number = ttf_control_ask(run->control, ask);

    assert_true(number > 0);
    return number;
}

void living_expect_done(struct sim_run *run, int64_t number)
{
    struct ttf_err err = {0};
    int r = ttf_control_answer(run->control, number, &err);

    if (r < 0)
        print_error("%s: %s\n", err.where, err.what);
    assert_int_equal(r, 0);
}

void living_expect_refused(struct sim_run *run, int64_t number, const char *where, const char *what)
{
    struct ttf_err err = {0};

    assert_int_equal(ttf_control_answer(run->control, number, &err), -EINVAL);
    assert_string_equal(err.where, where);
    if (!strstr(err.what, what))
        print_error("'%s' does not say '%s'\n", err.what, what);
    assert_non_null(strstr(err.what, what));
}
