/* SPDX-License-Identifier: Apache-2.0 */
/* Samples: what was named stays named, what others wrote stays as they wrote it, and nothing is written that no reader takes. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "meddled.h"
#include "store_ios.h"
#include "store_test.h"
#include "ttf/base/time.h"
#include "ttf/dataset/notes.h"
#include "ttf/dataset/samples.h"
#include "ttf/dataset/verify.h"

static const struct ttf_sample_rect corner = {0, 0, 2, 2}, whole = {0, 0, 4, 3};

static void begin(struct meddled *n, void **state)
{
    meddled_begin(n, state, ".samples-new");
}

static int name(struct meddled *n, const char *id, const char *title,
                const struct ttf_sample_rect *region)
{
    const struct ttf_sample_change change = {.id = id, .title = title, .region = region};

    return ttf_samples_change(n->io, n->path, &change, 1, NULL);
}

static void put(struct meddled *n, const char *text)
{
    write_text(in(n->path, "samples.json"), text, strlen(text));
}

/* What a reader says: "id x,y,wxh title treatment; ..." */
static void expect(struct meddled *n, const char *wanted)
{
    struct ttf_sample_region *samples;
    char text[1024] = "";
    size_t used = 0;
    unsigned count;

    assert_int_equal(ttf_samples_read(n->io, n->path, &samples, &count, NULL), 0);
    for (unsigned i = 0; i < count; i++)
        used +=
            (size_t)snprintf(text + used, sizeof(text) - used, "%s%s %d,%d,%dx%d %s %s",
                             i ? "; " : "", samples[i].id, (int)samples[i].region.x,
                             (int)samples[i].region.y, (int)samples[i].region.width,
                             (int)samples[i].region.height, samples[i].title, samples[i].treatment);
    free(samples);
    assert_string_equal(text, wanted);
    meddled_expect_no_new_file(n);
}

static void expect_clean(const struct meddled *n, unsigned notes)
{
    const struct ttf_verify_options options = {0};
    struct ttf_verify_report report;

    assert_int_equal(ttf_verify(n->io, n->path, &options, &report, NULL), 0);
    assert_int_equal(report.n_findings, notes);
    for (unsigned i = 0; i < notes; i++)
        assert_string_equal(report.findings[i].file, "samples.json");
    ttf_verify_report_free(&report);
}

static void what_is_named_is_on_the_disk_before_it_takes_its_name(void **state)
{
    struct meddled n;

    begin(&n, state);
    assert_int_equal(name(&n, "A1", "Lolium", &corner), 0);
    meddled_forget_log(&n);
    assert_int_equal(name(&n, "A2", "Poa", &whole), 0);
    assert_string_equal(n.log, "open .samples-new\nappend .samples-new\nsync .samples-new\nrename "
                               "samples.json\nsync_dir d\n");
    expect(&n, "A1 0,0,2x2 Lolium ; A2 0,0,4x3 Poa ");
    expect_clean(&n, 0);
    meddled_end(&n);
}

static void only_what_is_said_of_a_sample_is_changed(void **state)
{
    const struct ttf_sample_change changes[] = {
        {.id = "A2", .treatment = "dry since 4"},
        {.id = "A1", .title = "", .region = &whole},
        {.id = "A3", .region = &corner},
    };
    struct meddled n;

    begin(&n, state);
    assert_int_equal(name(&n, "A1", "Lolium", &corner), 0);
    assert_int_equal(name(&n, "A2", "Poa", &corner), 0);
    assert_int_equal(ttf_samples_change(n.io, n.path, changes, 3, NULL), 0);
    expect(&n, "A1 0,0,4x3  ; A2 0,0,2x2 Poa dry since 4; A3 0,0,2x2  ");
    meddled_end(&n);
}

static void a_sample_is_taken_out_again(void **state)
{
    const struct ttf_sample_change out = {.id = "A1", .remove = true};
    struct meddled n;

    begin(&n, state);
    assert_int_equal(name(&n, "A1", "Lolium", &corner), 0);
    assert_int_equal(name(&n, "A2", "Poa", &corner), 0);
    assert_int_equal(ttf_samples_change(n.io, n.path, &out, 1, NULL), 0);
    assert_int_equal(ttf_samples_change(n.io, n.path, &out, 1, NULL), -ENOENT);
    expect(&n, "A2 0,0,2x2 Poa ");
    meddled_end(&n);
}

/* Of the file, of samples, of regions; also of the one that is changed. */
static void what_other_tools_wrote_is_kept(void **state)
{
    static const char before[] =
        "{\"by\":{\"tool\":[1,2.5,null,true,9007199254740993]},\"samples\":[{\"id\":\"A1\","
        "\"pot\":7,\"region\":{\"x\":1,\"y\":1,\"width\":2,\"height\":2,\"angle\":30}},"
        "{\"id\":\"A2\",\"region\":{\"x\":0,\"y\":0,\"width\":1,\"height\":1},\"sown\":\"May\"}]}";
    char *text;
    struct meddled n;

    begin(&n, state);
    put(&n, before);
    assert_int_equal(name(&n, "A1", "Lolium", &corner), 0);
    expect(&n, "A1 0,0,2x2 Lolium ; A2 0,0,1x1  ");
    text = file_text(in(n.path, "samples.json"), NULL);
    for (char *from = text, *to = text;; from++) {
        if (*from != ' ' && *from != '\n')
            *to++ = *from;
        if (!*from)
            break;
    }
    assert_non_null(strstr(text, "\"by\":{\"tool\":[1,2.5,null,true,9007199254740993]}"));
    assert_non_null(strstr(text, "\"pot\":7"));
    assert_non_null(strstr(text, "\"height\":2,\"angle\":30}"));
    assert_non_null(strstr(text,
                           "{\"id\":\"A2\",\"region\":{\"x\":0,\"y\":0,\"width\":1,\"height\":"
                           "1},\"sown\":\"May\"}"));
    free(text);
    meddled_end(&n);
}

static void nothing_is_written_that_no_reader_takes(void **state)
{
    static const struct ttf_sample_rect beyond[] = {
        {1, 0, 4, 1}, {0, 1, 1, 3}, {-1, 0, 2, 2}, {0, 0, 0, 1}, {INT64_MAX, 0, 1, 1}};
    const struct ttf_sample_change twice[] = {{.id = "A1", .region = &corner},
                                              {.id = "A1", .region = &whole}};
    char longer[200];
    struct ttf_err err = {0};
    struct meddled n;

    begin(&n, state);
    memset(longer, 'x', sizeof(longer));
    longer[sizeof(longer) - 1] = '\0';
    for (unsigned i = 0; i < sizeof(beyond) / sizeof(*beyond); i++)
        assert_int_equal(name(&n, "A1", NULL, &beyond[i]), -EINVAL);
    assert_int_equal(name(&n, "A1", NULL, NULL), -EINVAL);
    assert_int_equal(name(&n, "", NULL, &corner), -EINVAL);
    assert_int_equal(name(&n, longer, NULL, &corner), -EINVAL);
    assert_int_equal(name(&n, "A1", longer, &corner), -EINVAL);
    assert_int_equal(name(&n, "A1", "a\nb", &corner), -EINVAL);
    assert_int_equal(ttf_samples_change(n.io, n.path, twice, 2, &err), -EINVAL);
    assert_non_null(strstr(err.what, "twice"));
    assert_false(exists(in(n.path, "samples.json")));
    assert_int_equal(run("! ls -A '%s' | grep -q samples-new", n.path), 0);
    meddled_end(&n);
}

/* Whoever wrote it may mend it; what was in it is not lost. */
static void what_is_not_understood_is_left_alone(void **state)
{
    static const char *const bad[] = {
        "{\"samples\":[{\"id\":\"A1\"}]}", "{nonsense",
        "{\"samples\":[{\"id\":\"a\",\"region\":{\"x\":0,\"y\":0,\"width\":1,\"height\":1}},"
        "{\"id\":\"a\",\"region\":{\"x\":0,\"y\":0,\"width\":1,\"height\":1}}]}"};

    for (unsigned i = 0; i < sizeof(bad) / sizeof(*bad); i++) {
        struct ttf_err err = {0};
        const struct ttf_sample_change change = {.id = "A1", .region = &corner};
        struct meddled n;
        char *text;

        begin(&n, state);
        put(&n, bad[i]);
        assert_int_equal(ttf_samples_change(n.io, n.path, &change, 1, &err), -EINVAL);
        assert_string_equal(err.where, "samples.json");
        text = file_text(in(n.path, "samples.json"), NULL);
        assert_string_equal(text, bad[i]);
        free(text);
        expect_clean(&n, 1);
        meddled_end(&n);
        assert_int_equal(run("rm -r '%s'", n.path), 0);
    }
}

static void a_region_outside_of_the_picture_is_told_and_no_damage(void **state)
{
    struct meddled n;

    begin(&n, state);
    put(&n,
        "{\"samples\":[{\"id\":\"A1\",\"region\":{\"x\":3,\"y\":0,\"width\":2,\"height\":1}}]}");
    expect_clean(&n, 1);
    meddled_end(&n);
}

static void whatever_fails_the_samples_before_are_whole(void **state)
{
    static const int errors[] = {ENOSPC, EIO, EROFS};

    for (unsigned e = 0; e < 3; e++) {
        struct meddled n;
        int r = -1;

        begin(&n, state);
        assert_int_equal(name(&n, "A1", "Lolium", &corner), 0);
        n.cue.error = errors[e];
        for (n.cue.at = 1; r; n.cue.at++) {
            struct ttf_sample_region *samples;
            unsigned count;

            n.cue.n = 0;
            r = name(&n, "A2", "Poa", &whole);
            assert_true(r == 0 || r == -errors[e]);
            assert_int_equal(ttf_samples_read(quick_io(), n.path, &samples, &count, NULL), 0);
            assert_true(count == 2 || (r && count == 1));
            assert_string_equal(samples[0].title, "Lolium");
            free(samples);
        }
        assert_true(n.cue.at > 5);
        n.cue.at = 0;
        expect(&n, "A1 0,0,2x2 Lolium ; A2 0,0,4x3 Poa ");
        meddled_end(&n);
        assert_int_equal(run("rm -r '%s'", n.path), 0);
    }
}

/* By whom notes are added, too: the lock is one. */
static void only_one_names_samples_at_a_time(void **state)
{
    struct ttf_io *io = quick_io();
    struct ttf_writer *writer;
    struct meddled n;
    int file;

    begin(&n, state);
    file = io->ops->open(io, in(n.path, "dataset.json"), TTF_IO_READ);
    assert_true(file >= 0);
    assert_int_equal(io->ops->lock(io, file), 0);
    assert_int_equal(name(&n, "A1", NULL, &corner), -EAGAIN);
    assert_false(exists(in(n.path, "samples.json")));
    io->ops->close(io, file);
    assert_int_equal(ttf_writer_open(io, n.path, &writer, NULL), 0); /* whose lock is another */
    assert_int_equal(name(&n, "A1", NULL, &corner), 0);
    ttf_writer_close(writer);
    expect(&n, "A1 0,0,2x2  ");
    meddled_end(&n);
}

static void what_a_tool_writes_meanwhile_is_not_lost(void **state)
{
    struct meddled n;

    begin(&n, state);
    assert_int_equal(name(&n, "A1", "Lolium", &corner), 0);
    n.meddles = "sed s/Lolium/Festuca/ samples.json > .saved && mv .saved samples.json";
    assert_int_equal(name(&n, "A2", "Poa", &corner), -EAGAIN);
    assert_int_equal(name(&n, "A2", "Poa", &corner), 0);
    expect(&n, "A1 0,0,2x2 Festuca ; A2 0,0,2x2 Poa ");
    meddled_end(&n);
}

static void a_sealed_dataset_keeps_its_seal(void **state)
{
    struct ttf_writer *writer;
    struct meddled n;

    begin(&n, state);
    assert_int_equal(ttf_writer_open(quick_io(), n.path, &writer, NULL), 0);
    assert_int_equal(small_slot(writer, 0), 0);
    assert_int_equal(ttf_writer_seal(writer, "count", NULL, NULL), 0);
    ttf_writer_close(writer);
    assert_int_equal(name(&n, "A1", "Lolium", &corner), 0);
    assert_int_equal(sha256sum_check(n.path), 0);
    expect_clean(&n, 0);
    meddled_end(&n);
}

static void what_was_cut_off_is_removed_by_the_next(void **state)
{
    struct meddled n;

    begin(&n, state);
    write_text(in(n.path, ".samples-new-0123456789abcdef"), "{\"sam", 6);
    write_text(in(n.path, ".notes-new-0123456789abcdef"), "{\"te", 5);
    assert_int_equal(name(&n, "A1", "Lolium", &corner), 0);
    expect(&n, "A1 0,0,2x2 Lolium ");
    assert_true(exists(in(n.path, ".notes-new-0123456789abcdef"))); /* the next note's affair */
    meddled_end(&n);
}

static void a_link_is_not_replaced(void **state)
{
    struct meddled n;

    begin(&n, state);
    assert_int_equal(run("ln -s elsewhere '%s/samples.json'", n.path), 0);
    assert_int_equal(name(&n, "A1", NULL, &corner), -ELOOP);
    assert_int_equal(run("test -L '%s/samples.json'", n.path), 0);
    meddled_end(&n);
}

#define T(test) cmocka_unit_test_setup_teardown(test, folder_setup, folder_teardown)

int main(void)
{
    const struct CMUnitTest tests[] = {
        T(what_is_named_is_on_the_disk_before_it_takes_its_name),
        T(only_what_is_said_of_a_sample_is_changed),
        T(a_sample_is_taken_out_again),
        T(what_other_tools_wrote_is_kept),
        T(nothing_is_written_that_no_reader_takes),
        T(what_is_not_understood_is_left_alone),
        T(a_region_outside_of_the_picture_is_told_and_no_damage),
        T(whatever_fails_the_samples_before_are_whole),
        T(only_one_names_samples_at_a_time),
        T(what_a_tool_writes_meanwhile_is_not_lost),
        T(a_sealed_dataset_keeps_its_seal),
        T(what_was_cut_off_is_removed_by_the_next),
        T(a_link_is_not_replaced),
    };

    return cmocka_run_group_tests_name("samples", tests, NULL, NULL);
}
