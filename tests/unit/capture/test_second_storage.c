/* SPDX-License-Identifier: Apache-2.0 */
/* Which of two datasets a run is gone on with, by what lies in the two storages. */
#include "cmocka_includes.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "datasets/plain_stream.h"
#include "second_left.h"
#include "second_storage.h"
#include "ttf/base/time.h"
#include "ttf/capture/session.h"

static char folder[64];
static char first[96], second[96];
static struct ttf_manifest manifest; /* of the first */

static int set_up(void **state)
{
    (void)state;
    strcpy(folder, "/tmp/ttf-second-XXXXXX");
    if (!mkdtemp(folder))
        return -1;
    snprintf(first, sizeof(first), "%s/first/d", folder);
    snprintf(second, sizeof(second), "%s/second/d", folder);
    memset(&manifest, 0, sizeof(manifest));
    if (ttf_manifest_init(&manifest, NULL) < 0)
        return -1;
    manifest.simulated = true;
    plain_stream(&manifest, "linear-srgb");
    memcpy(manifest.group_uuid, manifest.uuid, sizeof(manifest.group_uuid));
    strcpy(manifest.group_member, TTF_MEMBER_FIRST);
    return 0;
}

static void away(const char *path)
{
    char line[128];

    snprintf(line, sizeof(line), "rm -rf %s", path);
    assert_int_equal(system(line), 0); /* NOLINT(cert-env33-c,concurrency-mt-unsafe): a test's */
}

static int tear_down(void **state)
{
    (void)state;
    away(folder);
    return 0;
}

enum stage {
    MADE,
    BEGUN,
    SEALED
};

static void make(const char *path, const struct ttf_manifest *m, enum stage stage)
{
    struct ttf_segment segment = {.interval_ns = TTF_NS_PER_MIN, .origin_utc_ns = TTF_NS_UNKNOWN};
    struct ttf_writer *writer;
    struct ttf_err err = {0};

    if (ttf_writer_create(ttf_io_posix(), path, m, "# plan\n", "{}", &writer, &err) < 0)
        print_error("%s: %s\n", err.where, err.what);
    assert_int_equal(err.code, 0);
    strcpy(segment.trust, "none");
    if (stage >= BEGUN)
        assert_int_equal(ttf_writer_segment(writer, &segment, NULL), 0);
    if (stage == SEALED)
        assert_int_equal(ttf_writer_seal(writer, "count", NULL, NULL), 0);
    ttf_writer_close(writer);
}

static void make_second(enum stage stage)
{
    struct ttf_manifest m;

    assert_int_equal(ttf_second_manifest(&manifest, &m, NULL), 0);
    make(second, &m, stage);
}

static int find(struct ttf_err *err)
{
    return ttf_second_find(ttf_io_posix(), first, second, err);
}

static void spoil(const char *path, const char *name, const char *text)
{
    char file[128];
    FILE *f;

    snprintf(file, sizeof(file), "%s/%s", path, name);
    f = fopen(file, "w");
    assert_non_null(f);
    if (f) {
        assert_true(fputs(text, f) >= 0);
        assert_int_equal(fclose(f), 0);
    }
}

static void the_second_dataset_has_the_first_one_s_name(void **state)
{
    static char long_name[5000];
    struct ttf_plan plan;
    char path[4096];

    (void)state;
    ttf_plan_defaults(&plan);
    assert_int_equal(ttf_second_path(&plan, "a/d", path, sizeof(path), NULL), 0);
    assert_string_equal(path, "");
    strcpy(plan.second_storage, "/media/two");
    assert_int_equal(ttf_second_path(&plan, "a/d", path, sizeof(path), NULL), 0);
    assert_string_equal(path, "/media/two/d");
    assert_int_equal(ttf_second_path(&plan, "d", path, sizeof(path), NULL), 0);
    assert_string_equal(path, "/media/two/d");
    assert_int_equal(ttf_second_path(&plan, "/a/d//", path, sizeof(path), NULL), 0);
    assert_string_equal(path, "/media/two/d");
    memset(long_name, 'd', sizeof(long_name) - 1);
    assert_int_equal(ttf_second_path(&plan, long_name, path, sizeof(path), NULL), -ENAMETOOLONG);
}

static void it_is_the_first_until_the_second_is_begun(void **state)
{
    (void)state;
    make(first, &manifest, BEGUN);
    make_second(MADE);
    assert_int_equal(find(NULL), 0);
    away(second);
    make_second(BEGUN);
    assert_int_equal(find(NULL), 1);
    away(second);
    make_second(SEALED);
    assert_int_equal(find(NULL), 1);
}

static void the_second_alone_is_gone_on_with_while_its_run_is_under_way(void **state)
{
    struct ttf_err err;

    (void)state;
    make_second(BEGUN);
    assert_int_equal(find(NULL), 1);
    away(second);
    /* Else it is rather another run by the same name. */
    make_second(MADE);
    assert_int_equal(find(&err), -EEXIST);
    away(second);
    make_second(SEALED);
    assert_int_equal(find(&err), -EEXIST);
    assert_non_null(strstr(err.hint, "another -o"));
}

static void what_lies_there_and_is_not_of_this_run_is_refused(void **state)
{
    struct ttf_manifest other = manifest;
    struct ttf_err err;

    (void)state;
    make(first, &manifest, BEGUN);
    make(second, &other, BEGUN); /* itself a first one */
    assert_int_equal(find(&err), -EEXIST);
    away(second);
    assert_int_equal(ttf_second_manifest(&manifest, &other, NULL), 0);
    memcpy(other.group_uuid, other.uuid, sizeof(other.group_uuid)); /* of another group */
    make(second, &other, BEGUN);
    assert_int_equal(find(&err), -EEXIST);
}

/* Two datasets of the same slots would be worse than none for a while. */
static void what_cannot_be_read_there_is_for_a_person(void **state)
{
    struct ttf_err err;

    (void)state;
    make(first, &manifest, BEGUN);
    make_second(BEGUN);
    spoil(second, "records.jsonl", "{\"type\":\"segment\",\"seq\":0}\n{}\n");
    assert_true(find(&err) < 0);
    spoil(second, "dataset.json", "{");
    assert_true(find(&err) < 0);
    assert_non_null(strstr(err.hint, "second storage"));
}

/* A disk that is not mounted: nobody knows whether the run has moved on to it. */
static void a_second_storage_that_is_away_matters_once_the_run_has_begun(void **state)
{
    struct ttf_manifest lone = manifest;
    struct ttf_err err;
    char parent[96];

    (void)state;
    assert_int_equal(find(NULL), 0); /* nothing is anywhere */
    make(first, &manifest, MADE);
    assert_int_equal(find(NULL), 0);
    away(first);
    make(first, &manifest, BEGUN);
    assert_int_equal(find(&err), -EINVAL);
    assert_non_null(strstr(err.hint, "mount it"));
    snprintf(parent, sizeof(parent), "%s/second", folder);
    assert_int_equal(mkdir(parent, 0755), 0);
    assert_int_equal(find(NULL), 0); /* it is there, and empty */
    away(parent);
    away(first);
    make(first, &manifest, SEALED);
    assert_int_equal(find(NULL), 0);
    away(first);
    lone.group_member[0] = lone.group_uuid[0] = '\0'; /* of a plan without a second storage */
    make(first, &lone, BEGUN);
    assert_int_equal(find(NULL), 0);
    away(first);
    make(first, &manifest, BEGUN);
    spoil(first, "records.jsonl", "{\"type\":\"segment\",\"seq\":0}\n{}\n");
    assert_int_equal(find(NULL), 0); /* opening it will say what is wrong with it */
}

static void tell_left(int n_segments, const char *other_detail)
{
    char detail[TTF_SECOND_LEFT_SIZE];
    struct ttf_writer *writer;

    ttf_second_put_left(n_segments, 7, detail);
    assert_int_equal(ttf_writer_open(ttf_io_posix(), first, &writer, NULL), 0);
    assert_int_equal(
        ttf_writer_event(writer, "storage", TTF_NS_UNKNOWN, TTF_NS_UNKNOWN, "left", detail, NULL),
        0);
    assert_int_equal(ttf_writer_event(writer, "note", TTF_NS_UNKNOWN, TTF_NS_UNKNOWN, "later",
                                      other_detail, NULL),
                     0);
    ttf_writer_close(writer);
}

/* Its mount point is a folder like any other: the first dataset knows better. */
static void a_first_that_was_left_waits_for_a_second_storage_that_is_empty(void **state)
{
    struct ttf_manifest lone = manifest;
    struct ttf_err err;

    (void)state;
    make(first, &manifest, BEGUN);
    tell_left(1, NULL);
    assert_int_equal(find(&err), -ENODEV); /* nor is its folder there */
    make_second(MADE);                     /* by another attempt, beneath the mount point */
    assert_int_equal(find(&err), -ENODEV);
    assert_string_equal(err.where, "storage.second");
    assert_non_null(strstr(err.what, second));
    assert_non_null(strstr(err.what, "from slot 7 on"));
    assert_non_null(strstr(err.hint, "without storage.second"));
    away(second); /* its folder stays */
    assert_int_equal(find(NULL), -ENODEV);
    make_second(BEGUN);
    assert_int_equal(find(NULL), 1);
    away(second);
    away(first);
    lone.group_member[0] = lone.group_uuid[0] = '\0'; /* the plan named it later */
    make(first, &lone, BEGUN);
    tell_left(1, NULL);
    assert_int_equal(find(NULL), -ENODEV);
}

static void a_first_that_was_gone_on_with_after_all_is_left_no_more(void **state)
{
    char parent[96];

    (void)state;
    snprintf(parent, sizeof(parent), "%s/second", folder);
    assert_int_equal(mkdir(parent, 0755), 0);
    make(first, &manifest, BEGUN);
    tell_left(
        0,
        "{\"left_from\":\"7\",\"segments\":1}"); /* a segment has come since; and words are no numbers */
    assert_int_equal(find(NULL), 0);
    tell_left(1, "{\"left_from\":7}"); /* another's detail takes nothing back */
    assert_int_equal(find(NULL), -ENODEV);
    away(first);
    make(first, &manifest, SEALED);
    assert_int_equal(find(NULL), 0);
}

static void whoever_asks_hears_which_of_the_two_it_is(void **state)
{
    struct ttf_plan plan;
    char path[96];
    struct ttf_err err;

    (void)state;
    ttf_plan_defaults(&plan);
    snprintf(plan.second_storage, sizeof(plan.second_storage), "%s/second", folder);
    make(first, &manifest, BEGUN);
    make_second(BEGUN);
    assert_int_equal(ttf_session_find(ttf_io_posix(), first, &plan, path, sizeof(path), NULL), 0);
    assert_string_equal(path, second);
    assert_int_equal(ttf_session_find(ttf_io_posix(), first, &plan, path, 4, &err), -ENAMETOOLONG);
    plan.second_storage[0] = '\0';
    assert_int_equal(ttf_session_find(ttf_io_posix(), first, &plan, path, sizeof(path), NULL), 0);
    assert_string_equal(path, first);
}

static void commit(struct ttf_writer *writer, int64_t index, enum ttf_result result,
                   const char *reason)
{
    struct ttf_slot_record record;

    ttf_slot_record_init(&record);
    record.index = index;
    record.result = result;
    snprintf(record.reason, sizeof(record.reason), "%s", reason);
    assert_int_equal(ttf_writer_commit(writer, &record, NULL), 0);
    ttf_slot_record_free(&record);
}

static void what_can_only_be_read_is_known_as_a_writer_would_know_it(void **state)
{
    struct ttf_writer_state as_read;
    struct ttf_manifest of_read;
    struct ttf_writer *writer = NULL;

    (void)state;
    make(first, &manifest, BEGUN);
    assert_int_equal(ttf_writer_open(ttf_io_posix(), first, &writer, NULL), 0);
    for (int64_t k = 0; k < 6; k++) {
        const struct ttf_writer_state *known = ttf_writer_state(writer);

        assert_int_equal(ttf_second_state_of(ttf_io_posix(), first, &as_read, &of_read, NULL), 0);
        assert_string_equal(of_read.uuid, manifest.uuid);
        assert_int_equal(as_read.next_index, known->next_index);
        assert_int_equal(as_read.n_segments, known->n_segments);
        assert_int_equal(as_read.last_segment.interval_ns, known->last_segment.interval_ns);
        assert_int_equal(as_read.lost_at_end, known->lost_at_end);
        assert_int_equal(as_read.n_plans, known->n_plans);
        assert_int_equal(as_read.sealed, known->sealed);
        assert_memory_equal(as_read.counts, known->counts, sizeof(known->counts));
        if (k == 1)
            commit(writer, k, TTF_RESULT_PAUSED, "paused by a person");
        else if (k == 4)
            commit(writer, k, TTF_RESULT_MISSED, "the box was getting ready");
        else
            commit(writer, k, TTF_RESULT_POWER, "the box was without power");
    }
    assert_int_equal(as_read.lost_at_end, 3);
    ttf_writer_close(writer);
}

static void one_that_was_made_and_is_another_s_or_begun_is_not_opened(void **state)
{
    struct ttf_manifest m;
    struct ttf_manifest other;
    const struct ttf_plan_text own = {.json = "{}"};
    const struct ttf_plan_text changed = {.json = "{\"a\":1}"};
    const struct ttf_plan_text given = {.json = "{\"a\":2}"};
    const struct ttf_plan_text other_given = {.json = "{\"a\":3}"};
    struct ttf_writer *writer = NULL;

    (void)state;
    assert_int_equal(ttf_second_manifest(&manifest, &m, NULL), 0);
    other = m;
    memcpy(other.group_uuid, other.uuid, sizeof(other.group_uuid));
    make_second(MADE);
    assert_int_equal(ttf_second_open(ttf_io_posix(), second, &other, NULL, &own, &writer, NULL),
                     -EEXIST);
    /* Its own plan is 0; another one becomes plan 1, and the same again stays 1. */
    assert_int_equal(ttf_second_open(ttf_io_posix(), second, &m, NULL, &own, &writer, NULL), 0);
    ttf_writer_close(writer);
    for (int i = 0; i < 2; i++) {
        assert_int_equal(ttf_second_open(ttf_io_posix(), second, &m, NULL, &changed, &writer, NULL),
                         1);
        ttf_writer_close(writer);
    }
    /* The plan given is not in force: it comes before the one that is, and neither comes twice. */
    for (int i = 0; i < 2; i++) {
        assert_int_equal(ttf_second_open(ttf_io_posix(), second, &m, &given, &own, &writer, NULL),
                         3);
        ttf_writer_close(writer);
    }
    /* Another is given, and the newest there is the one in force: it comes all the same, and that one anew behind it. */
    for (int i = 0; i < 2; i++) {
        assert_int_equal(
            ttf_second_open(ttf_io_posix(), second, &m, &other_given, &own, &writer, NULL), 5);
        ttf_writer_close(writer);
    }
    /* One that is given and is there, further back, does not come again. */
    assert_int_equal(ttf_second_open(ttf_io_posix(), second, &m, &given, &changed, &writer, NULL),
                     6);
    ttf_writer_close(writer);
    away(second);
    make_second(BEGUN);
    assert_int_equal(ttf_second_open(ttf_io_posix(), second, &m, NULL, &own, &writer, NULL),
                     -EEXIST);
}

#define T(f) cmocka_unit_test_setup_teardown(f, set_up, tear_down)

int main(void)
{
    const struct CMUnitTest tests[] = {
        T(the_second_dataset_has_the_first_one_s_name),
        T(it_is_the_first_until_the_second_is_begun),
        T(the_second_alone_is_gone_on_with_while_its_run_is_under_way),
        T(what_lies_there_and_is_not_of_this_run_is_refused),
        T(what_cannot_be_read_there_is_for_a_person),
        T(a_second_storage_that_is_away_matters_once_the_run_has_begun),
        T(a_first_that_was_left_waits_for_a_second_storage_that_is_empty),
        T(a_first_that_was_gone_on_with_after_all_is_left_no_more),
        T(whoever_asks_hears_which_of_the_two_it_is),
        T(what_can_only_be_read_is_known_as_a_writer_would_know_it),
        T(one_that_was_made_and_is_another_s_or_begun_is_not_opened),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
