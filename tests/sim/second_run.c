/* SPDX-License-Identifier: Apache-2.0 */
#include "second_run.h"

#include "cmocka_includes.h"

#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

void second_run_make(struct sim_run *run)
{
    char path[96];

    snprintf(path, sizeof(path), "%s/second", run->folder);
    assert_int_equal(mkdir(path, 0755), 0);
    snprintf(run->plan.second_storage, sizeof(run->plan.second_storage), "%s", path);
}

void second_run_init(struct sim_run *run)
{
    sim_run_init(run);
    second_run_make(run);
}

struct sim_run second_run_of(const struct sim_run *run)
{
    struct sim_run second = *run;

    snprintf(second.path, sizeof(second.path), "%s/second/dataset", run->folder);
    return second;
}

bool second_run_holds(const char *path)
{
    return strstr(path, "/second") != NULL;
}

void second_run_results(const struct sim_run *run, char ret[32])
{
    struct ttf_reader *reader;

    memset(ret, '-', 31);
    ret[31] = '\0';
    if (ttf_reader_open(ttf_io_posix(), run->path, &reader, NULL) < 0)
        return;
    for (int64_t i = 0; i < ttf_reader_summary(reader)->slots; i++) {
        struct ttf_slot_record record;

        assert_int_equal(ttf_reader_slot(reader, i, &record, NULL), 0);
        assert_in_range(record.index, 0, 30);
        ret[record.index] = "cpmfzw"[record.result];
        ttf_slot_record_free(&record);
    }
    ttf_reader_close(reader);
}

void second_run_expect_both(const struct sim_run *run, const char *letters)
{
    struct sim_run second = second_run_of(run);
    char first[32], other[32], all[32];

    second_run_results(run, first);
    second_run_results(&second, other);
    for (int i = 0; i < 31; i++) {
        assert_true(first[i] == '-' || other[i] == '-');
        all[i] = first[i] == '-' ? other[i] : first[i];
    }
    all[31] = '\0';
    all[strcspn(all, "-")] = '\0';
    assert_string_equal(all, letters);
}
