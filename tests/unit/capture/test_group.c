/* SPDX-License-Identifier: Apache-2.0 */
/* Which group a plan's word leads to, and which datasets are none to join. */
#include "cmocka_includes.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "datasets/plain_stream.h"
#include "group.h"
#include "ttf/dataset/writer.h"

/* Two storages: the run would be first/run; its group's name is "other". */
struct place {
    char folder[64], run[96], beside[96], second[96];
    struct ttf_plan plan;
    struct ttf_manifest manifest; /* of the other */
    struct ttf_group group;
};

static int set_up(void **state)
{
    struct place *p = calloc(1, sizeof(*p));

    if (!p)
        return -1;
    *state = p;
    strcpy(p->folder, "/tmp/ttf-group-XXXXXX");
    if (!mkdtemp(p->folder) || ttf_manifest_init(&p->manifest, NULL) < 0)
        return -1;
    snprintf(p->run, sizeof(p->run), "%s/first/run", p->folder);
    snprintf(p->beside, sizeof(p->beside), "%s/first/other", p->folder);
    snprintf(p->second, sizeof(p->second), "%s/second/other", p->folder);
    p->manifest.simulated = true;
    plain_stream(&p->manifest, "linear-srgb");
    strcpy(p->plan.group, "other");
    return 0;
}

static int tear_down(void **state)
{
    struct place *p = *state;
    char line[96];
    int r;

    snprintf(line, sizeof(line), "rm -rf %s", p->folder);
    r = system(line); /* NOLINT(cert-env33-c,concurrency-mt-unsafe): a test's */
    free(p);
    return r;
}

static void make(const struct place *p, const char *path)
{
    struct ttf_writer *writer;

    assert_int_equal(
        ttf_writer_create(ttf_io_posix(), path, &p->manifest, "# plan\n", "{}", &writer, NULL), 0);
    ttf_writer_close(writer);
}

static int look(struct place *p)
{
    return ttf_group_of_plan(ttf_io_posix(), p->run, &p->plan, true, &p->group, NULL);
}

static void assert_refused(struct place *p, bool simulated)
{
    struct ttf_err err = {0};

    assert_int_equal(
        ttf_group_of_plan(ttf_io_posix(), p->run, &p->plan, simulated, &p->group, &err), -EINVAL);
    assert_string_equal(err.where, "group");
    assert_string_equal(p->group.uuid, "");
}

static void a_plan_without_a_group_is_of_none(void **state)
{
    struct place *p = *state;

    p->plan.group[0] = '\0';
    strcpy(p->group.uuid, "something");
    assert_int_equal(look(p), 0);
    assert_string_equal(p->group.uuid, "");
}

static void the_first_of_a_group_gives_it_its_own_uuid(void **state)
{
    struct place *p = *state;

    make(p, p->beside);
    assert_int_equal(look(p), 0);
    assert_string_equal(p->group.uuid, p->manifest.uuid);
    assert_string_equal(p->group.member, "2");
}

static void each_is_one_farther_than_the_one_it_joins(void **state)
{
    static const char *const members[][2] = {
        {"2", "3"}, {"9", "10"}, {"first", "2"}, {"-7", "2"}, {"999999999", "2"}};
    struct place *p = *state;
    char line[160];

    strcpy(p->manifest.group_uuid, "0a0b0c0d-0000-4000-8000-000000000000");
    for (size_t i = 0; i < sizeof(members) / sizeof(*members); i++) {
        snprintf(p->manifest.group_member, sizeof(p->manifest.group_member), "%s", members[i][0]);
        make(p, p->beside);
        assert_int_equal(look(p), 0);
        assert_string_equal(p->group.uuid, p->manifest.group_uuid);
        assert_string_equal(p->group.member, members[i][1]);
        snprintf(line, sizeof(line), "rm -r %s", p->beside);
        assert_int_equal(system(line), 0); /* NOLINT(cert-env33-c,concurrency-mt-unsafe) */
    }
}

static void where_it_is_not_beside_it_is_in_the_second_storage(void **state)
{
    struct place *p = *state;

    snprintf(p->plan.second_storage, sizeof(p->plan.second_storage), "%s/second", p->folder);
    assert_refused(p, true);
    make(p, p->second);
    assert_int_equal(look(p), 0);
    assert_string_equal(p->group.uuid, p->manifest.uuid);
    assert_int_equal(ttf_manifest_init(&p->manifest, NULL), 0); /* another one, beside */
    p->manifest.simulated = true;
    plain_stream(&p->manifest, "linear-srgb");
    make(p, p->beside);
    assert_int_equal(look(p), 0);
    assert_string_equal(p->group.uuid, p->manifest.uuid);
}

static void what_cannot_be_joined_is_refused(void **state)
{
    struct place *p = *state;

    assert_refused(p, true); /* it is not there */
    make(p, p->beside);
    assert_refused(p, false); /* a real run, of a simulated one's group */
    strcpy(p->plan.group, "run");
    assert_refused(p, true); /* itself */
    strcpy(p->plan.group, "tried");
    snprintf(p->beside, sizeof(p->beside), "%s/first/tried", p->folder);
    p->manifest.rehearsal = true;
    make(p, p->beside);
    assert_refused(p, true);
}

static void a_dataset_that_cannot_be_read_is_no_absent_one(void **state)
{
    struct place *p = *state;
    char path[128];
    FILE *file;

    make(p, p->beside);
    make(p, p->second);
    snprintf(p->plan.second_storage, sizeof(p->plan.second_storage), "%s/second", p->folder);
    snprintf(path, sizeof(path), "%s/dataset.json", p->beside);
    file = fopen(path, "w");
    assert_non_null(file);
    assert_int_equal(fclose(file), 0);
    assert_true(look(p) < 0);
    assert_string_equal(p->group.uuid, "");
}

#define T(f) cmocka_unit_test_setup_teardown(f, set_up, tear_down)

int main(void)
{
    const struct CMUnitTest tests[] = {
        T(a_plan_without_a_group_is_of_none),
        T(the_first_of_a_group_gives_it_its_own_uuid),
        T(each_is_one_farther_than_the_one_it_joins),
        T(where_it_is_not_beside_it_is_in_the_second_storage),
        T(what_cannot_be_joined_is_refused),
        T(a_dataset_that_cannot_be_read_is_no_absent_one),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
