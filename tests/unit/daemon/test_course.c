/* SPDX-License-Identifier: Apache-2.0 */
/* test_course.c: slots of a run that lie in two storages are counted each once, in whatever order they are read. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <jansson.h>
#include <string.h>

#include "course.h"
#include "ttf/dataset/json_parse.h"

static const struct ttf_segment FIRST = {
    .segment = 3, .interval_ns = TTF_NS_PER_S, .trust = "none"};
/* Numbered anew, from the slot under way on. */
static const struct ttf_segment SECOND = {
    .first_index = 4, .origin_ns = 40 * TTF_NS_PER_S, .interval_ns = TTF_NS_PER_S, .trust = "none"};

static void read_slots(struct course *c, enum course_part part, int64_t from, int64_t to,
                       enum ttf_result result)
{
    for (struct ttf_slot_record record = {.index = from, .result = result}; record.index < to;
         record.index++)
        course_record(c, part, &record, part == COURSE_FIRST ? "{\"in\":1}" : "{\"in\":2}");
}

static json_t *said(const struct course *c)
{
    const struct letter armed = {.kind = TTF_PROGRESS_ARMED, .total = 20};
    struct course copy = *c;
    struct ttf_json json;
    json_t *object = NULL;
    const char *text;
    size_t bytes;

    course_letter(&copy, &armed);
    ttf_json_init(&json, false);
    ttf_json_object(&json);
    course_put(&copy, true, 0, &json);
    ttf_json_object_end(&json);
    assert_int_equal(ttf_json_finish(&json, &text, &bytes), 0);
    assert_int_equal(ttf_json_parse(text, bytes, &object, NULL), 0);
    ttf_json_free(&json);
    return object;
}

static int64_t number(json_t *object, const char *name)
{
    return json_integer_value(json_object_get(object, name));
}

/* Slots 0 to 3 in the first storage, 4 to 6 in the second; of 4 the first one took a record after all. */
static void assert_moved(const struct course *c)
{
    json_t *object = said(c);
    json_t *results = json_object_get(object, "results");
    json_t *next = json_object_get(object, "next");

    assert_int_equal(number(object, "done"), 7);
    assert_int_equal(number(results, "captured"), 4);
    assert_int_equal(number(results, "missed"), 3);
    assert_int_equal(number(results, "failed"), 0);
    assert_int_equal(number(next, "index"), 7);
    assert_true(number(next, "due_boot_ns") == 43 * TTF_NS_PER_S);
    assert_string_equal(c->readings, "{\"in\":2}");
    json_decref(object);
}

static void a_run_that_moves_on_is_counted_as_it_goes(void **state)
{
    struct course c = {0};

    (void)state;
    course_forget(&c);
    course_segment(&c, COURSE_FIRST, &FIRST);
    read_slots(&c, COURSE_FIRST, 0, 4, TTF_RESULT_CAPTURED);
    read_slots(&c, COURSE_FIRST, 4, 5, TTF_RESULT_FAILED);
    course_segment(&c, COURSE_SECOND, &SECOND);
    read_slots(&c, COURSE_SECOND, 4, 7, TTF_RESULT_MISSED);
    assert_moved(&c);
    course_segment(&c, COURSE_FIRST, &FIRST); /* a correction of what is over changes no grid */
    assert_moved(&c);
    course_forget(&c);
}

static void a_first_storage_that_comes_late_is_counted_too(void **state)
{
    struct course c = {0};

    (void)state;
    course_forget(&c);
    course_segment(&c, COURSE_SECOND, &SECOND);
    read_slots(&c, COURSE_SECOND, 4, 7, TTF_RESULT_MISSED);
    course_segment(&c, COURSE_FIRST, &FIRST);
    read_slots(&c, COURSE_FIRST, 0, 4, TTF_RESULT_CAPTURED);
    read_slots(&c, COURSE_FIRST, 4, 5, TTF_RESULT_FAILED);
    assert_moved(&c);
    course_forget(&c);
}

static void what_is_read_twice_is_counted_once(void **state)
{
    struct course c = {0};

    (void)state;
    course_forget(&c);
    for (int i = 0; i < 2; i++) {
        course_segment(&c, COURSE_SECOND, &SECOND);
        read_slots(&c, COURSE_SECOND, 4, 7, TTF_RESULT_MISSED);
        course_segment(&c, COURSE_FIRST, &FIRST);
        read_slots(&c, COURSE_FIRST, 0, 4, TTF_RESULT_CAPTURED);
    }
    assert_moved(&c);
    course_forget(&c);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_run_that_moves_on_is_counted_as_it_goes),
        cmocka_unit_test(a_first_storage_that_comes_late_is_counted_too),
        cmocka_unit_test(what_is_read_twice_is_counted_once),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
