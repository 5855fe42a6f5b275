/* SPDX-License-Identifier: Apache-2.0 */
/* Slot lines that are known by their heads: what they say is what their JSON says, and what is of another hand is parsed. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "record_line.h"
#include "ttf/base/attr.h"

/* A copy without anything behind it, so that a look too far is one that the sanitizers see. */
static bool head_of(const char *line, size_t bytes, int64_t *ret_seq, struct ttf_slot_brief *ret)
{
    char *copy = malloc(bytes ? bytes : 1);
    bool known;

    assert_non_null(copy);
    memcpy(copy, line, bytes);
    known = ttf_slot_head(copy, bytes, ret_seq, ret);
    free(copy);
    return known;
}

static void assert_head_is_its_json(const struct ttf_slot_record *record, int64_t seq)
{
    struct ttf_slot_brief head, brief;
    struct ttf_line line = {.where = "test", .type = "slot"};
    struct ttf_json json;
    int64_t found;

    ttf_line_begin(&json, "slot", seq);
    ttf_slot_put(&json, record);
    assert_int_equal(ttf_line_finish(&json, &line.text, &line.bytes), 0);
    line.json = json_loadb(line.text, line.bytes, 0, NULL);
    assert_non_null(line.json);
    assert_int_equal(ttf_slot_get_brief(&line, &brief, NULL), 0);
    assert_true(head_of(line.text, line.bytes, &found, &head));
    assert_int_equal(found, seq);
    assert_int_equal(head.index, brief.index);
    assert_int_equal(head.segment, brief.segment);
    assert_int_equal(head.due_ns, brief.due_ns);
    assert_int_equal(head.result, brief.result);
    json_decref(line.json);
    ttf_json_free(&json);
}

static void a_head_says_what_the_line_says(void **state)
{
    struct ttf_slot_record record;

    for (int i = 0; i < TTF_RESULT_COUNT; i++) {
        ttf_slot_record_init(&record);
        record.index = i * INT64_C(1234567891);
        record.segment = i;
        record.due_ns = i == 2 ? -5 : INT64_C(1209600000000001) * i;
        record.middle_ns = i % 2 ? record.due_ns + 7 : TTF_NS_UNKNOWN;
        record.result = (enum ttf_result)i;
        (void)snprintf(record.reason, sizeof(record.reason), "%s",
                       i % 3 ? "" : "\"result\":\"captured\"");
        assert_head_is_its_json(&record, i * INT64_C(99999999999));
    }
}

static void what_is_cut_or_of_another_hand_is_parsed(void **state)
{
    static const char whole[] =
        "{\"type\":\"slot\",\"seq\":4,\"index\":2,\"segment\":0,\"due_ns\":-12,\"middle_ns\":5,"
        "\"result\":\"failed\",\"reason\":\"x\",\"crc\":\"01234567\"}";
    static const char *const others[] = {
        "",
        "{\"seq\":4,\"type\":\"slot\",\"index\":2,\"segment\":0,\"due_ns\":1,\"result\":"
        "\"failed\",",
        "{\"type\":\"slot\",\"seq\": "
        "4,\"index\":2,\"segment\":0,\"due_ns\":1,\"result\":\"failed\",",
        "{\"type\":\"slot\",\"seq\":04,\"index\":2,\"segment\":0,\"due_ns\":1,\"result\":"
        "\"failed\",",
        "{\"type\":\"slot\",\"seq\":4,\"index\":-2,\"segment\":0,\"due_ns\":1,\"result\":"
        "\"failed\",",
        "{\"type\":\"slot\",\"seq\":4,\"index\":2.5,\"segment\":0,\"due_ns\":1,\"result\":"
        "\"failed\",",
        "{\"type\":\"slot\",\"seq\":4,\"index\":2e5,\"segment\":0,\"due_ns\":1,\"result\":"
        "\"failed\",",
        "{\"type\":\"slot\",\"seq\":4,\"index\":2,\"segment\":-0,\"due_ns\":1,\"result\":"
        "\"failed\",",
        "{\"type\":\"slot\",\"seq\":4,\"index\":2,\"segment\":2147483648,\"due_ns\":1,\"result\":"
        "\"failed\",",
        "{\"type\":\"slot\",\"seq\":4,\"index\":2,\"segment\":0,\"due_ns\":9223372036854775808,"
        "\"result\":\"failed\",",
        "{\"type\":\"slot\",\"seq\":4,\"index\":2,\"segment\":0,\"due_ns\":1,\"result\":"
        "\"failedly\",",
        "{\"type\":\"slot\",\"seq\":4,\"index\":2,\"segment\":0,\"due_ns\":1,\"middle_ns\":null,"
        "\"result\":\"failed\",",
        "{\"type\":\"slots\",\"seq\":4,\"index\":2,\"segment\":0,\"due_ns\":1,\"result\":"
        "\"failed\",",
    };
    const size_t needed = (size_t)(strstr(whole, "\"reason\"") - whole);
    struct ttf_slot_brief brief;
    int64_t seq;

    for (size_t n = 0; n < sizeof(whole) - 1; n++) {
        if (head_of(whole, n, &seq, &brief) != (n >= needed))
            fail_msg("the first %zu bytes", n);
    }
    assert_int_equal(brief.due_ns, -12);
    assert_int_equal(brief.result, TTF_RESULT_FAILED);
    for (size_t i = 0; i < TTF_COUNT_OF(others); i++) {
        if (head_of(others[i], strlen(others[i]), &seq, &brief))
            fail_msg("%s", others[i]);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_head_says_what_the_line_says),
        cmocka_unit_test(what_is_cut_or_of_another_hand_is_parsed),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
