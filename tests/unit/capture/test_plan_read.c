/* SPDX-License-Identifier: Apache-2.0 */
/* plans/N.json read back: what somebody edited by hand, or a disk spoilt, is refused and the field named. */
#include "cmocka_includes.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ttf/base/time.h"
#include "ttf/capture/plan.h"

static void light(struct ttf_lamp_level *level, const char *lamp, unsigned permille)
{
    snprintf(level->lamp, sizeof(level->lamp), "%s", lamp);
    level->permille = permille;
}

/* A plan with everything that a plan can have. */
static void full_plan(struct ttf_plan *plan)
{
    ttf_plan_defaults(plan);
    strcpy(plan->title, "grass");
    plan->interval_ns = 10 * TTF_NS_PER_MIN;
    plan->count = 1008;
    plan->start_utc_ns = 1000;
    strcpy(plan->zone, "Europe/Berlin");
    plan->zone_offset_s = 7200;
    plan->lamps = TTF_LAMPS_PHOTOPERIOD;
    plan->day_ns = 16 * TTF_NS_PER_H;
    plan->period_ns = 24 * TTF_NS_PER_H;
    plan->photoperiod_local = true;
    plan->day_start_s = 6 * 3600;
    plan->n_day_levels = 1;
    light(&plan->day_levels[0], "growth", 700);
    plan->shots[0].n_levels = 1;
    light(&plan->shots[0].levels[0], "left", 900);
    plan->shots[0].n_brackets = 2;
    plan->shots[0].brackets[0] = 0.5;
    plan->shots[0].brackets[1] = 1;
    plan->region = (struct ttf_region){8, 8, 16, 16};
    plan->reference = (struct ttf_region){1, 2, 3, 4};
    plan->mm_per_px = 0.05;
    strcpy(plan->second_storage, "/media/second");
    strcpy(plan->group, "grass");
}

static void a_plan_with_everything_comes_back_as_it_was(void **state)
{
    struct ttf_plan plan;
    struct ttf_plan back;
    char *text = NULL;

    (void)state;
    full_plan(&plan);
    assert_int_equal(ttf_plan_json(&plan, &text, NULL), 0);
    assert_int_equal(ttf_plan_read(text, strlen(text), "plan", &back, NULL), 0);
    assert_true(ttf_plan_same(&plan, &back));
    assert_int_equal(back.day_start_s, 6 * 3600);
    assert_int_equal(back.day_levels[0].permille, 700);
    assert_string_equal(back.second_storage, "/media/second");
    assert_string_equal(back.group, "grass");
    assert_true(back.shots[0].brackets[0] == 0.5);
    free(text);
}

/* Without what is between its words, so that parts of it can be written down in a line. */
static void squeeze(char *text)
{
    bool quoted = false;
    char *to = text;

    for (const char *from = text; *from; from++) {
        quoted ^= *from == '"';
        if (quoted || (*from != ' ' && *from != '\n'))
            *to++ = *from;
    }
    *to = '\0';
}

/* The plan's text with one part replaced. */
static char *edited(const char *text, const char *part, const char *by)
{
    const char *at = strstr(text, part);
    size_t size = strlen(text) + strlen(by) + 1;
    char *out = malloc(size);

    if (!at)
        print_error("'%s' is not in %s\n", part, text);
    assert_non_null(at);
    assert_non_null(out);
    if (at && out)
        snprintf(out, size, "%.*s%s%s", (int)(at - text), text, by, at + strlen(part));
    return out;
}

static void every_field_that_is_not_as_it_must_be_is_named(void **state)
{
    static const char many[] =
        "\"a\":1,\"b\":1,\"c\":1,\"d\":1,\"e\":1,\"f\":1,\"g\":1,\"h\":1,\"i\":1";
    static const struct {
        const char *part, *by, *named;
    } edits[] = {
        {"\"title\":\"grass\"", "\"title\":7", "title"},
        {"\"grass\"",
         "\"a title of more than its hundred and twenty-seven bytes, so that it would not fit, and "
         "whoever cut it would change what people wrote......\"",
         "title"},
        {"\"interval_ns\":600000000000", "\"interval_ns\":0", "interval_ns"},
        {"\"interval_ns\":600000000000", "\"interval_ns\":\"10min\"", "interval_ns"},
        {"\"interval_ns\":600000000000", "\"interval\":1", "interval_ns"},
        {"\"count\":1008", "\"count\":1.5", "count"},
        {"\"start_utc_ns\":1000", "\"start_utc_ns\":\"now\"", "start_utc_ns"},
        {"\"zone\":\"Europe/Berlin\"", "\"zone\":null", "zone"},
        {"\"zone_offset_s\":7200", "\"zone_offset_s\":86401", "zone_offset_s"},
        {"\"mode\":\"photoperiod\"", "\"mode\":\"disco\"", "mode"},
        {"\"mode\":\"photoperiod\"", "\"mode\":1", "mode"},
        {"\"day_ns\":", "\"day\":", "day_ns"},
        {"\"period_ns\":", "\"period\":", "period_ns"},
        {"\"day_start_s\":21600", "\"day_start_s\":86401", "day_start_s"},
        {"{\"growth\":700}", "700", "day_levels_permille"},
        {"{\"growth\":700}", "{\"growth\":\"70%\"}", "day_levels_permille"},
        {"\"growth\"", "\"a-lamp-with-a-name-that-no-board-could-give-it\"", "day_levels_permille"},
        {"\"growth\":700", many, "day_levels_permille"},
        {"\"stream\":\"main\"", "\"stream\":[]", "stream"},
        {"\"left\":900", many, "lamps_permille"},
        {"\"exposure_ns\":", "\"exposure\":", "exposure_ns"},
        {"\"gain_milli\":", "\"gain_milli\":-", "gain_milli"},
        {"\"brackets\":[", "\"brackets\":[1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,", "brackets"},
        {"\"brackets\":[", "\"brackets\":[\"half\",", "brackets"},
        {"\"average\":1", "\"average\":0", "average"},
        {"\"shots\":[", "\"shots\":[],\"of_before\":[", "shots"},
        {"\"shots\":[", "\"shots\":{},\"of_before\":[", "shots"},
        {"\"mains_hz\":", "\"mains_hz\":\"50 Hz\",\"mains\":", "mains_hz"},
        {"\"height\":16", "\"height\":0", "height"},
        {"\"keep\":\"default\"", "\"keep\":\"nothing\"", "keep"},
        {"\"mm_per_px\":0.05", "\"mm_per_px\":\"wide\"", "mm_per_px"},
        {"\"reserve_bytes\":", "\"reserve\":", "reserve_bytes"},
        {"\"second\":\"/media/second\"", "\"third\":\"/media/third\"", "second"},
    };
    struct ttf_plan plan;
    char *text = NULL;

    (void)state;
    full_plan(&plan);
    assert_int_equal(ttf_plan_json(&plan, &text, NULL), 0);
    squeeze(text);
    for (unsigned i = 0; i < sizeof(edits) / sizeof(edits[0]); i++) {
        struct ttf_plan back = {.count = 7};
        struct ttf_err err = {0};
        char want[64];
        char *wrong = edited(text, edits[i].part, edits[i].by);

        if (ttf_plan_read(wrong, strlen(wrong), "plans/0.json", &back, &err) != -EINVAL)
            print_error("taken: %s\n", edits[i].by);
        assert_int_equal(err.code, -EINVAL);
        assert_string_equal(err.where, "plans/0.json");
        snprintf(want, sizeof(want), "'%s'", edits[i].named);
        if (!strstr(err.what, want))
            print_error("%s instead of %s\n", err.what, want);
        assert_non_null(strstr(err.what, want));
        assert_int_equal(back.count, 7); /* untouched */
        free(wrong);
    }
    free(text);
}

static void what_is_no_object_is_no_plan(void **state)
{
    static const char *const texts[] = {"", "[]", "7", "{\"title\":", "{\"count\":1,\"count\":2}"};

    (void)state;
    for (unsigned i = 0; i < sizeof(texts) / sizeof(texts[0]); i++) {
        struct ttf_plan back;
        struct ttf_err err = {0};

        assert_int_equal(ttf_plan_read(texts[i], strlen(texts[i]), "plan", &back, &err), -EINVAL);
        assert_non_null(strstr(err.what, "no plan"));
    }
}

/* Several are wrong: the first is the one to look at. */
static void the_first_wrong_field_is_the_one_that_is_named(void **state)
{
    static const char text[] = "{\"title\":7}";
    struct ttf_plan back;
    struct ttf_err err = {0};

    (void)state;
    assert_int_equal(ttf_plan_read(text, strlen(text), "plan", &back, &err), -EINVAL);
    assert_non_null(strstr(err.what, "'title'"));
}

/* What an older program left out. */
static void fields_that_came_later_may_be_absent(void **state)
{
    struct ttf_plan plan;
    struct ttf_plan back;
    char *text = NULL;

    (void)state;
    ttf_plan_defaults(&plan);
    strcpy(plan.title, "plain");
    plan.interval_ns = TTF_NS_PER_MIN;
    plan.count = 2;
    assert_int_equal(ttf_plan_json(&plan, &text, NULL), 0);
    assert_null(strstr(text, "mm_per_px"));
    assert_null(strstr(text, "storage"));
    assert_int_equal(ttf_plan_read(text, strlen(text), "plan", &back, NULL), 0);
    assert_true(back.mm_per_px == 0);
    assert_int_equal(back.region.width, 0);
    assert_string_equal(back.second_storage, "");
    free(text);
}

static void the_zone_s_offset_and_a_local_day_s_phase_are_no_difference(void **state)
{
    struct ttf_plan a;
    struct ttf_plan b;

    (void)state;
    full_plan(&a);
    b = a;
    b.zone_offset_s = 3600;
    b.phase_ns = 5;
    assert_true(ttf_plan_same(&a, &b));
    a.photoperiod_local = b.photoperiod_local = false;
    assert_false(ttf_plan_same(&a, &b)); /* here the phase is what was asked for */
    b.phase_ns = a.phase_ns;
    assert_true(ttf_plan_same(&a, &b));
    b.shots[0].average = 2;
    assert_false(ttf_plan_same(&a, &b));
}

/* As it was stored before: without what ends it. */
static void a_plan_that_does_not_tell_what_ends_it_is_the_one_of_as_many_slots(void **state)
{
    struct ttf_plan until, old, other;
    char *text = NULL;

    (void)state;
    full_plan(&until);
    until.end = TTF_END_LENGTH;
    until.length_ns = 7 * TTF_NS_PER_DAY;
    other = until;
    other.end = TTF_END_UNTOLD;
    assert_int_equal(ttf_plan_json(&other, &text, NULL), 0);
    assert_null(strstr(text, "\"end\""));
    assert_int_equal(ttf_plan_read(text, strlen(text), "plan", &old, NULL), 0);
    free(text);
    assert_int_equal(old.end, TTF_END_UNTOLD);
    assert_true(ttf_plan_same(&old, &until));
    assert_true(ttf_plan_same(&until, &old));
    until.count++;
    assert_false(ttf_plan_same(&old, &until));
    until.count--;
    until.end = TTF_END_COUNT;
    until.length_ns = 0;
    assert_true(ttf_plan_same(&old, &until));
}

/* How many slots it comes to is reckoned anew by each run. */
static void plans_that_end_in_time_are_the_same_if_they_end_then(void **state)
{
    static const enum ttf_plan_end ends[] = {TTF_END_COUNT, TTF_END_UNTIL, TTF_END_LENGTH};

    (void)state;
    for (unsigned i = 0; i < 3; i++) {
        struct ttf_plan a, b;
        char *text = NULL;

        full_plan(&a);
        a.end = ends[i];
        a.until_utc_ns = i == 1 ? INT64_C(1700000000000000001) : 0;
        a.length_ns = i == 2 ? INT64_C(604800000000001) : 0;
        assert_int_equal(ttf_plan_json(&a, &text, NULL), 0);
        assert_int_equal(ttf_plan_read(text, strlen(text), "plan", &b, NULL), 0);
        free(text);
        assert_int_equal(b.end, a.end);
        assert_int_equal(b.until_utc_ns, a.until_utc_ns);
        assert_int_equal(b.length_ns, a.length_ns);
        b.count++;
        assert_int_equal(ttf_plan_same(&a, &b), i > 0);
        b = a;
        b.until_utc_ns += i == 1;
        b.length_ns += i == 2;
        assert_int_equal(ttf_plan_same(&a, &b), i == 0);
        b = a;
        b.end = TTF_END_COUNT;
        assert_int_equal(ttf_plan_same(&a, &b), i == 0);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_plan_with_everything_comes_back_as_it_was),
        cmocka_unit_test(every_field_that_is_not_as_it_must_be_is_named),
        cmocka_unit_test(what_is_no_object_is_no_plan),
        cmocka_unit_test(the_first_wrong_field_is_the_one_that_is_named),
        cmocka_unit_test(fields_that_came_later_may_be_absent),
        cmocka_unit_test(a_plan_that_does_not_tell_what_ends_it_is_the_one_of_as_many_slots),
        cmocka_unit_test(plans_that_end_in_time_are_the_same_if_they_end_then),
        cmocka_unit_test(the_zone_s_offset_and_a_local_day_s_phase_are_no_difference),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
