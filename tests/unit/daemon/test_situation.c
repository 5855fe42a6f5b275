/* SPDX-License-Identifier: Apache-2.0 */
/* test_situation.c: the status is what the run and its records say, at every moment. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <jansson.h>
#include <stdio.h>
#include <string.h>

#include "situation.h"
#include "ttf/dataset/json_parse.h"
#include "ttf/hal/clock_backend.h"

struct hand_clock {
    struct ttf_clock base; /* first */
    int64_t now_ns;
};

static int64_t hand_now_ns(struct ttf_clock *clock)
{
    return ((struct hand_clock *)clock)->now_ns;
}

static void hand_utc(struct ttf_clock *clock, struct ttf_utc *ret)
{
    *ret = (struct ttf_utc){.boot_ns = hand_now_ns(clock), .utc_ns = 5, .trust = TTF_TRUST_NTP};
}

static const struct ttf_clock_ops OPS = {.now_ns = hand_now_ns, .utc = hand_utc};

static json_t *status_of(struct situation *s)
{
    struct ttf_json json;
    json_t *object = NULL;
    const char *text;
    size_t bytes;

    ttf_json_init(&json, false);
    ttf_json_object(&json);
    situation_status(s, &json);
    ttf_json_object_end(&json);
    assert_int_equal(ttf_json_finish(&json, &text, &bytes), 0);
    assert_int_equal(ttf_json_parse(text, bytes, &object, NULL), 0);
    ttf_json_free(&json);
    return object;
}

/* A number by its path, "run.next.index"; -1: it is not there. */
static int64_t number(json_t *object, const char *path)
{
    char name[64];

    while (object && *path) {
        size_t n = strcspn(path, ".");

        (void)snprintf(name, sizeof name, "%.*s", (int)n, path);
        object = json_object_get(object, name);
        path += n + (path[n] == '.');
    }
    return json_is_integer(object) ? json_integer_value(object) : -1;
}

static const char *word(json_t *object, const char *name)
{
    const char *text = json_string_value(json_object_get(object, name));

    return text ? text : "";
}

static struct letter letter_of(enum ttf_progress_kind kind, int64_t index, int result)
{
    return (struct letter){.kind = kind,
                           .index = index,
                           .total = 10,
                           .result = result,
                           .error_ns = 1000,
                           .wakeup_ns = TTF_NS_UNKNOWN};
}

static void a_run_is_followed_from_arming_to_its_end(void **state)
{
    struct hand_clock clock = {.base = {.ops = &OPS}, .now_ns = 100 * TTF_NS_PER_S};
    struct situation *s = situation_create(&clock.base);
    const struct order order = {.state = ORDER_RUN, .by_request = true, .dataset = "grass"};
    const struct ttf_segment segment = {.origin_ns = 100 * TTF_NS_PER_S,
                                        .interval_ns = 5 * TTF_NS_PER_S,
                                        .origin_utc_ns = 1000,
                                        .trust = "ntp"};
    struct ttf_slot_record record = {.index = 0, .result = TTF_RESULT_CAPTURED};
    struct letter letter = letter_of(TTF_PROGRESS_ARMED, 0, 0);
    json_t *status;

    (void)state;
    if (!s) {
        fail();
        return;
    }
    (void)situation_run(s, &order, NULL);
    assert_true(situation_set(s, DOING_ARMING, NULL, TTF_NS_UNKNOWN));
    status = status_of(s);
    assert_string_equal(word(status, "state"), "arming");
    assert_int_equal(number(status, "run.next.index"), -1);
    assert_int_equal(number(status, "run.reserve_bytes"), -1);
    json_decref(status);
    situation_storage(s, 1000, 5000);
    situation_segment(s, "grass", COURSE_FIRST, &segment);
    assert_true(situation_letter(s, &letter));
    situation_record(s, "grass", COURSE_FIRST, &record,
                     "{\"index\":0,\"lamps\":[],\"sensors\":[]}");
    letter = letter_of(TTF_PROGRESS_SLOT, 0, TTF_RESULT_CAPTURED);
    assert_false(situation_letter(s, &letter));
    clock.now_ns += 2 * TTF_NS_PER_S;
    status = status_of(s);
    assert_string_equal(word(status, "state"), "capturing");
    assert_int_equal(number(status, "run.slots"), 10);
    assert_int_equal(number(status, "run.slot_bytes"), 1000);
    assert_int_equal(number(status, "run.reserve_bytes"), 5000);
    assert_int_equal(number(status, "run.done"), 1);
    assert_int_equal(number(status, "run.results.captured"), 1);
    assert_int_equal(number(status, "run.next.index"), 1);
    assert_true(number(status, "run.next.in_ns") == 3 * TTF_NS_PER_S);
    assert_true(number(status, "run.next.due_utc_ns") == 1000 + 5 * TTF_NS_PER_S);
    assert_true(number(status, "run.ends_in_ns") == 43 * TTF_NS_PER_S);
    assert_int_equal(number(status, "readings.index"), 0);
    json_decref(status);
    letter = letter_of(TTF_PROGRESS_EVENT, 1, 0);
    assert_false(situation_letter(s, &letter));
    letter.total = 7; /* its clock was corrected, in a wait of hours */
    assert_true(situation_letter(s, &letter));
    status = status_of(s);
    assert_int_equal(number(status, "run.slots"), 7);
    assert_true(number(status, "run.ends_in_ns") == 28 * TTF_NS_PER_S);
    assert_int_equal(number(status, "run.next.index"), 1);
    json_decref(status);
    letter = letter_of(TTF_PROGRESS_SLOT, 1, TTF_RESULT_PAUSED);
    assert_true(situation_letter(s, &letter));
    assert_int_equal(situation_doing(s), DOING_PAUSED);
    letter = letter_of(TTF_PROGRESS_ALARM, 1, 0);
    (void)snprintf(letter.text, sizeof letter.text, "the disk is full");
    (void)situation_letter(s, &letter);
    assert_true(situation_set(s, DOING_STOPPED, "by a person", TTF_NS_UNKNOWN));
    status = status_of(s);
    assert_string_equal(word(status, "state"), "stopped");
    assert_string_equal(word(status, "why"), "by a person");
    assert_int_equal(number(status, "run.next.index"), -1);
    assert_string_equal(word(json_array_get(json_object_get(status, "alarms"), 0), "text"),
                        "the disk is full");
    json_decref(status);
    situation_destroy(s);
}

static void a_run_waits_for_its_plans_start_and_captures_from_its_first_slot_on(void **state)
{
    struct hand_clock clock = {.base = {.ops = &OPS}, .now_ns = 100 * TTF_NS_PER_S};
    struct situation *s = situation_create(&clock.base);
    const struct order order = {.state = ORDER_RUN, .by_request = true, .dataset = "grass"};
    const struct ttf_segment segment = {.origin_ns = 500 * TTF_NS_PER_S,
                                        .interval_ns = 5 * TTF_NS_PER_S,
                                        .origin_utc_ns = 1000,
                                        .trust = "ntp"};
    struct letter letter = letter_of(TTF_PROGRESS_ARMED, 0, 0);
    json_t *status;

    (void)state;
    if (!s) {
        fail();
        return;
    }
    letter.waits = true;
    letter.lit_ns = 200 * TTF_NS_PER_S;
    letter.settled_ns = 490 * TTF_NS_PER_S;
    (void)situation_run(s, &order, NULL);
    (void)situation_set(s, DOING_ARMING, NULL, TTF_NS_UNKNOWN);
    situation_segment(s, "grass", COURSE_FIRST, &segment);
    assert_true(situation_letter(s, &letter));
    status = status_of(s);
    assert_string_equal(word(status, "state"), "waiting");
    assert_string_equal(word(status, "why"), "");
    assert_int_equal(number(status, "run.next.index"), 0);
    assert_true(number(status, "run.next.in_ns") == 400 * TTF_NS_PER_S);
    assert_int_equal(number(status, "run.settled_in_ns"), -1); /* not lit yet */
    json_decref(status);
    clock.now_ns = 200 * TTF_NS_PER_S;
    situation_forget(s, "grass"); /* its records are read anew */
    situation_segment(s, "grass", COURSE_FIRST, &segment);
    status = status_of(s);
    assert_true(number(status, "run.settled_in_ns") == 290 * TTF_NS_PER_S);
    json_decref(status);
    clock.now_ns = 490 * TTF_NS_PER_S;
    status = status_of(s);
    assert_int_equal(number(status, "run.settled_in_ns"), -1);
    json_decref(status);
    letter = letter_of(TTF_PROGRESS_SLOT, 0, TTF_RESULT_CAPTURED);
    assert_true(situation_letter(s, &letter));
    assert_int_equal(situation_doing(s), DOING_CAPTURING);
    /* What waits for a file has no slots to tell of, whatever ran before it. */
    (void)situation_set(s, DOING_WAITING, "for the plan's file", TTF_NS_UNKNOWN);
    status = status_of(s);
    assert_string_equal(word(status, "state"), "waiting");
    assert_int_equal(number(status, "run.next.index"), -1);
    json_decref(status);
    letter = letter_of(TTF_PROGRESS_SLOT, 1, TTF_RESULT_CAPTURED);
    assert_false(situation_letter(s, &letter));
    situation_destroy(s);
}

static unsigned alarms_after(struct situation *s, enum ttf_progress_kind kind, int64_t run,
                             const char *text)
{
    struct letter letter = letter_of(kind, 1, 0);
    json_t *status;
    size_t n;

    letter.run = run;
    (void)snprintf(letter.text, sizeof letter.text, "%s", text);
    (void)situation_letter(s, &letter);
    status = status_of(s);
    n = json_array_size(json_object_get(status, "alarms"));
    json_decref(status);
    return (unsigned)n;
}

static void an_alarm_that_is_over_is_taken_back_also_by_another_run(void **state)
{
    struct hand_clock clock = {.base = {.ops = &OPS}, .now_ns = TTF_NS_PER_S};
    struct situation *s = situation_create(&clock.base);
    const struct order order = {.state = ORDER_RUN, .dataset = "grass"};
    struct letter over = letter_of(TTF_PROGRESS_ALARM_OVER, 1, 0);
    int64_t run;

    (void)state;
    if (!s) {
        fail();
        return;
    }
    run = situation_run(s, &order, NULL);
    assert_int_equal(alarms_after(s, TTF_PROGRESS_ALARM_OVER, run, "no room"), 0);
    assert_int_equal(alarms_after(s, TTF_PROGRESS_ALARM, run, "no room"), 1);
    assert_int_equal(alarms_after(s, TTF_PROGRESS_ALARM, run, "the storage is broken"), 2);
    assert_int_equal(alarms_after(s, TTF_PROGRESS_ALARM, run + 1, "no room"), 2); /* it stands */
    over.run = run + 1;
    (void)snprintf(over.text, sizeof over.text, "no room");
    assert_true(situation_letter(s, &over)); /* whoever listens is told */
    assert_false(situation_letter(s, &over));
    assert_int_equal(alarms_after(s, TTF_PROGRESS_ALARM_OVER, run, "no room"), 1);
    situation_destroy(s);
}

static unsigned alarms_until(struct situation *s, enum ttf_alarm_until until, int64_t run,
                             const char *text)
{
    struct letter letter = letter_of(TTF_PROGRESS_ALARM, 1, 0);
    json_t *status;
    size_t n;

    letter.run = run;
    letter.until = until;
    (void)snprintf(letter.text, sizeof letter.text, "%s", text);
    (void)situation_letter(s, &letter);
    status = status_of(s);
    n = json_array_size(json_object_get(status, "alarms"));
    json_decref(status);
    return (unsigned)n;
}

/* A full disk ended it; there was room again, and it went on: the box says no more that a person is needed. */
static void what_ended_a_run_is_over_when_one_is_armed_again(void **state)
{
    struct hand_clock clock = {.base = {.ops = &OPS}, .now_ns = TTF_NS_PER_S};
    struct situation *s = situation_create(&clock.base);
    struct order order = {.state = ORDER_RUN, .dataset = "grass"};
    int64_t run;

    (void)state;
    if (!s) {
        fail();
        return;
    }
    run = situation_run(s, &order, NULL);
    assert_int_equal(alarms_until(s, TTF_ALARM_UNTIL_ARMED, run, "disk full: the run ends"), 1);
    assert_int_equal(alarms_until(s, TTF_ALARM_UNTIL_OVER, run, "no room"), 2);
    assert_int_equal(alarms_until(s, TTF_ALARM_UNTIL_NEW, run, "goes on elsewhere"), 3);
    assert_int_equal(alarms_after(s, TTF_PROGRESS_ARMED, run, ""), 2); /* of the same run */
    strcpy(order.dataset, "moss");
    run = situation_run(s, &order, NULL);
    assert_int_equal(alarms_after(s, TTF_PROGRESS_ARMED, run, ""), 1); /* of another */
    assert_int_equal(alarms_after(s, TTF_PROGRESS_ALARM_OVER, run, "no room"), 0);
    situation_destroy(s);
}

static void what_kept_a_run_from_its_end_is_over_when_it_is_done(void **state)
{
    struct hand_clock clock = {.base = {.ops = &OPS}, .now_ns = TTF_NS_PER_S};
    struct situation *s = situation_create(&clock.base);
    const struct order order = {.state = ORDER_RUN, .dataset = "grass"};
    int64_t run;

    (void)state;
    if (!s) {
        fail();
        return;
    }
    run = situation_run(s, &order, NULL);
    assert_int_equal(alarms_until(s, TTF_ALARM_UNTIL_ARMED, run, "cannot be sealed"), 1);
    situation_sealed(s);
    assert_int_equal(alarms_after(s, TTF_PROGRESS_ALARM_OVER, run, ""), 0);
    situation_destroy(s);
}

static void a_clock_that_nobody_vouches_for_gives_no_utc(void **state)
{
    struct hand_clock clock = {.base = {.ops = &OPS}, .now_ns = TTF_NS_PER_S};
    struct situation *s = situation_create(&clock.base);
    const struct order order = {.state = ORDER_RUN, .dataset = "grass"};
    struct ttf_segment segment = {.interval_ns = TTF_NS_PER_S, .origin_utc_ns = 7, .trust = "none"};
    struct letter letter = letter_of(TTF_PROGRESS_ARMED, 0, 0);
    json_t *status;

    (void)state;
    if (!s) {
        fail();
        return;
    }
    (void)situation_run(s, &order, NULL);
    (void)situation_set(s, DOING_ARMING, NULL, TTF_NS_UNKNOWN);
    segment.segment = 1;
    segment.first_index = 4;
    situation_segment(s, "grass", COURSE_FIRST, &segment);
    (void)situation_letter(s, &letter);
    segment.segment = 0; /* a correction of what is over */
    segment.first_index = 0;
    situation_segment(s, "grass", COURSE_FIRST, &segment);
    status = status_of(s);
    assert_int_equal(number(status, "run.next.index"), 4);
    assert_int_equal(number(status, "run.next.due_boot_ns"), 0);
    assert_int_equal(number(status, "run.next.due_utc_ns"), -1);
    json_decref(status);
    situation_destroy(s);
}

static void records_and_letters_of_the_run_before_are_not_counted_into_this_one(void **state)
{
    struct hand_clock clock = {.base = {.ops = &OPS}, .now_ns = TTF_NS_PER_S};
    struct situation *s = situation_create(&clock.base);
    struct order order = {.state = ORDER_RUN, .dataset = "grass"};
    struct ttf_slot_record record = {.index = 0, .result = TTF_RESULT_CAPTURED};
    struct letter letter = letter_of(TTF_PROGRESS_SLOT, 6, TTF_RESULT_CAPTURED);
    json_t *status;

    (void)state;
    if (!s) {
        fail();
        return;
    }
    letter.run = situation_run(s, &order, NULL);
    situation_record(s, "grass", COURSE_FIRST, &record, NULL);
    memcpy(order.dataset, "moss", 5);
    assert_true(situation_run(s, &order, NULL) != letter.run);
    (void)situation_set(s, DOING_CAPTURING, NULL, TTF_NS_UNKNOWN);
    record.index = 1;
    situation_record(s, "grass", COURSE_FIRST, &record, "{}");
    assert_false(situation_letter(s, &letter));
    status = status_of(s);
    assert_int_equal(number(status, "run.done"), 0);
    assert_null(json_object_get(json_object_get(status, "run"), "last"));
    assert_null(json_object_get(status, "readings"));
    json_decref(status);
    situation_destroy(s);
}

static void a_run_is_about_one_second_storage_at_a_time(void **state)
{
    struct hand_clock clock = {.base = {.ops = &OPS}, .now_ns = TTF_NS_PER_S};
    struct situation *s = situation_create(&clock.base);
    const struct order order = {.state = ORDER_RUN, .dataset = "grass"};
    const struct ttf_slot_record record = {.index = 3, .result = TTF_RESULT_CAPTURED};
    char dataset[65], second[512];
    json_t *status;

    (void)state;
    if (!s) {
        fail();
        return;
    }
    (void)situation_run(s, &order, "/mnt/usb");
    situation_record(s, "grass", COURSE_SECOND, &record, NULL);
    (void)situation_run(s, &order, NULL); /* a plan that cannot be read says nothing else */
    situation_records(s, dataset, second);
    assert_string_equal(second, "/mnt/usb");
    status = status_of(s);
    assert_int_equal(number(status, "run.done"), 1);
    json_decref(status);
    (void)situation_run(s, &order, "/mnt/other");
    status = status_of(s);
    assert_int_equal(number(status, "run.done"), 0);
    json_decref(status);
    situation_destroy(s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_run_is_followed_from_arming_to_its_end),
        cmocka_unit_test(a_run_waits_for_its_plans_start_and_captures_from_its_first_slot_on),
        cmocka_unit_test(an_alarm_that_is_over_is_taken_back_also_by_another_run),
        cmocka_unit_test(what_ended_a_run_is_over_when_one_is_armed_again),
        cmocka_unit_test(what_kept_a_run_from_its_end_is_over_when_it_is_done),
        cmocka_unit_test(a_clock_that_nobody_vouches_for_gives_no_utc),
        cmocka_unit_test(records_and_letters_of_the_run_before_are_not_counted_into_this_one),
        cmocka_unit_test(a_run_is_about_one_second_storage_at_a_time),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
