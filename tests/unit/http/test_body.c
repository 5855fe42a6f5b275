/* SPDX-License-Identifier: Apache-2.0 */
/* test_body.c: what requests say in JSON and in a query, and which picture is the newest. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <errno.h>
#include <string.h>

#include "body.h"
#include "newest.h"
#include "ttf/base/time.h"

#define N(text) text, strlen(text)

static void a_run_is_asked_for_by_names(void **state)
{
    static const char *const WRONG[] = {"",
                                        "[]",
                                        "{\"plan\":1}",
                                        "{\"plan\":\"../x\"}",
                                        "{\"dataset\":\".hidden\"}",
                                        "{\"plan\":\"a\",\"plam\":\"b\"}",
                                        "{\"plan\":\"a\",\"plan\":\"b\"}",
                                        "{\"plan\":\"a\"} x",
                                        "{\"plan\":\"a\\u0000b\"}",
                                        NULL};
    char plan[65], dataset[65];
    struct ttf_err err;

    (void)state;
    assert_int_equal(body_start(N("{\"plan\":\"grass\"}"), plan, dataset, &err), 0);
    assert_string_equal(plan, "grass");
    assert_string_equal(dataset, "");
    assert_int_equal(body_start(N("{}"), plan, dataset, &err), 0);
    for (unsigned i = 0; WRONG[i]; i++)
        if (body_start(N(WRONG[i]), plan, dataset, &err) != -EINVAL)
            fail_msg("taken: %s", WRONG[i]);
}

static void a_step_of_a_calibration_says_what_it_needs(void **state)
{
    static const char *const WRONG[] = {"{}",
                                        "{\"part\":\"tea\"}",
                                        "{\"part\":\"dark\",\"frames\":0}",
                                        "{\"part\":\"dark\",\"frames\":1001}",
                                        "{\"part\":\"dark\",\"exposure_ns\":1.5}",
                                        "{\"part\":\"dark\",\"plan\":\"../x\"}",
                                        "{\"part\":\"dark\",\"name\":\"x\"}",
                                        "{\"part\":\"flat\",\"reflectance\":1.5}",
                                        "{\"part\":\"geometry\"}",
                                        "{\"part\":\"geometry\",\"pitch_mm\":0}",
                                        "{\"part\":\"chart\"}",
                                        "{\"part\":\"chart\",\"corners\":[[0,0],[9,0],[9,9]]}",
                                        "{\"part\":\"chart\",\"corners\":[[0,0],[9,0],[9,9],[0]]}",
                                        NULL};
    struct ttf_http_calibrate what;
    struct ttf_err err;
    char name[65];

    (void)state;
    for (unsigned i = 0; WRONG[i]; i++)
        if (body_calibrate(N(WRONG[i]), &what, &err) != -EINVAL)
            fail_msg("taken: %s", WRONG[i]);
    assert_int_equal(body_calibrate(N("{\"part\":\"flat\",\"plan\":\"week\",\"reflectance\":0.9,"
                                      "\"frames\":8,\"exposure_ns\":20000000}"),
                                    &what, &err),
                     0);
    assert_int_equal(what.part, TTF_CALIBRATION_FLAT);
    assert_string_equal(what.plan, "week");
    assert_true(what.reflectance == 0.9 && what.frames == 8 && what.exposure_ns == 20000000);
    assert_int_equal(
        body_calibrate(N("{\"part\":\"chart\",\"corners\":[[1,2.5],[9,0],[9,9],[0,9]]}"), &what,
                       &err),
        0);
    assert_true(what.corners[0][1] == 2.5 && what.corners[3][1] == 9);
    assert_int_equal(body_name(N("{\"name\":\"cal\"}"), name, &err), 0);
    assert_string_equal(name, "cal");
    assert_int_equal(body_name(N("{\"name\":\"a/b\"}"), name, &err), -EINVAL);
}

static void one_change_at_a_time(void **state)
{
    struct ttf_http_ask ask;
    struct ttf_err err;

    (void)state;
    assert_int_equal(body_change(N("{\"count\":12}"), &ask, &err), 0);
    assert_int_equal(ask.kind, TTF_HTTP_ASK_COUNT);
    assert_true(ask.value == 12);
    assert_int_equal(body_change(N("{\"until_utc_ns\":1800000000000000001}"), &ask, &err), 0);
    assert_int_equal(ask.kind, TTF_HTTP_ASK_UNTIL);
    assert_true(ask.value == INT64_C(1800000000000000001));
    assert_int_equal(body_change(N("{\"interval_ns\":1000000000}"), &ask, &err), 0);
    assert_int_equal(ask.kind, TTF_HTTP_ASK_INTERVAL);
    assert_int_equal(body_change(N("{}"), &ask, &err), -EINVAL);
    assert_int_equal(body_change(N("{\"count\":1,\"interval_ns\":1}"), &ask, &err), -EINVAL);
    assert_int_equal(body_change(N("{\"count\":0}"), &ask, &err), -EINVAL);
    assert_int_equal(body_change(N("{\"count\":1.5}"), &ask, &err), -EINVAL);
    assert_int_equal(body_pause("", 0, &ask, &err), 0);
    assert_string_equal(ask.reason, "");
    assert_int_equal(body_pause(N("{\"reason\":\"watering\"}"), &ask, &err), 0);
    assert_string_equal(ask.reason, "watering");
}

static void a_note_has_its_slots_and_tags(void **state)
{
    static const char *const WRONG[] = {"{}",
                                        "{\"text\":\"x\",\"slots\":[[5,3]]}",
                                        "{\"text\":\"x\",\"slots\":[[1]]}",
                                        "{\"text\":\"x\",\"slots\":[[-1,3]]}",
                                        "{\"text\":\"x\",\"slots\":3}",
                                        "{\"text\":\"x\",\"tags\":[\"\"]}",
                                        "{\"text\":\"x\",\"tags\":[1]}",
                                        NULL};
    struct ttf_note note;
    struct ttf_err err;

    (void)state;
    assert_int_equal(body_note(N("{\"text\":\"mould\",\"author\":\"me\",\"slots\":[[3,5],[9,9]],"
                                 "\"tags\":[\"exclude\"]}"),
                               &note, &err),
                     0);
    assert_string_equal(note.text, "mould");
    assert_string_equal(note.author, "me");
    assert_int_equal(note.n_slots, 2);
    assert_true(note.slots[0][0] == 3 && note.slots[0][1] == 5 && note.slots[1][1] == 9);
    assert_string_equal(note.tags[0], "exclude");
    assert_true(note.utc_ns == TTF_NS_UNKNOWN);
    for (unsigned i = 0; WRONG[i]; i++)
        if (body_note(N(WRONG[i]), &note, &err) != -EINVAL)
            fail_msg("taken: %s", WRONG[i]);
}

static void a_view_has_its_lamps_and_region(void **state)
{
    const struct body_view said = {.camera = "top",
                                   .exposure_ns = "20000000",
                                   .lamps = "left:500,right",
                                   .region = "1,2,30,40"};
    static const struct body_view WRONG[] = {
        {.exposure_ns = "-1"},
        {.exposure_ns = "99999999999999999999"},
        {.gain_milli = ""},
        {.lamps = ","},
        {.lamps = "left:"},
        {.lamps = "left:1001"},
        {.lamps = "a,b,c,d,e,f,g,h,i"},
        {.region = "1,2,3"},
        {.region = "1,2,3,0"},
        {.region = "1,2,3,4,5"},
        {.region = "1,2,3,70000"},
    };
    struct ttf_http_view view;
    struct ttf_err err;

    (void)state;
    assert_int_equal(body_view(&said, &view, &err), 0);
    assert_string_equal(view.camera, "top");
    assert_true(view.exposure_ns == 20000000);
    assert_int_equal(view.n_lamps, 2);
    assert_string_equal(view.lamps[0].name, "left");
    assert_int_equal(view.lamps[0].level_permille, 500);
    assert_int_equal(view.lamps[1].level_permille, 1000);
    assert_int_equal(view.height, 40);
    for (unsigned i = 0; i < sizeof WRONG / sizeof *WRONG; i++)
        if (body_view(&WRONG[i], &view, &err) != -EINVAL)
            fail_msg("the %u-th is taken", i);
}

static void the_newest_picture_is_the_developed_file(void **state)
{
    struct newest n;

    (void)state;
    assert_int_equal(
        newest_of_line(
            N("{\"type\":\"slot\",\"index\":7,\"images\":[{\"stream\":\"ir\",\"files\":[]},"
              "{\"stream\":\"main\",\"files\":[{\"role\":\"raw\",\"path\":\"raw/main/"
              "7.dng\",\"sha256\":\"aa\"},"
              "{\"role\":\"developed\",\"path\":\"frames/main/7.tif\",\"sha256\":\"bb\"}]}]}"),
            &n),
        0);
    assert_true(n.index == 7);
    assert_string_equal(n.stream, "main");
    assert_string_equal(n.path, "frames/main/7.tif");
    assert_string_equal(n.sha256, "bb");
    assert_int_equal(newest_of_line(N("{\"type\":\"slot\",\"index\":8,\"result\":\"missed\"}"), &n),
                     -ENOENT);
    assert_int_equal(newest_of_line(N("{\"type\":\"end\"}"), &n), -ENOENT);
    assert_int_equal(newest_of_line(N("{\"type\":\"sl"), &n), -ENOENT);
    /* A record that was tampered with leads nowhere else. */
    assert_int_equal(
        newest_of_line(N("{\"type\":\"slot\",\"index\":1,\"images\":[{\"files\":[{\"role\":"
                         "\"raw\",\"path\":\"../../etc/passwd\"}]}]}"),
                       &n),
        -ENOENT);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_run_is_asked_for_by_names),
        cmocka_unit_test(one_change_at_a_time),
        cmocka_unit_test(a_step_of_a_calibration_says_what_it_needs),
        cmocka_unit_test(a_note_has_its_slots_and_tags),
        cmocka_unit_test(a_view_has_its_lamps_and_region),
        cmocka_unit_test(the_newest_picture_is_the_developed_file),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
