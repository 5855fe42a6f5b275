/* SPDX-License-Identifier: Apache-2.0 */
#include "cmocka_includes.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

#include "ledger.h"
#include "ttf/base/time.h"

static void every_slot_has_exactly_one_record(void **state)
{
    struct ttf_ledger ledger = {.next_index = 3};
    struct ttf_slot_record record;

    (void)state;
    ttf_slot_record_init(&record);
    record.index = 3;
    record.result = TTF_RESULT_MISSED;
    assert_int_equal(ttf_ledger_add(&ledger, &record), 0);
    assert_int_equal(ttf_ledger_add(&ledger, &record), -EEXIST);
    record.index = 5;
    assert_int_equal(ttf_ledger_add(&ledger, &record), -ERANGE);
    assert_int_equal(ledger.counts[TTF_RESULT_MISSED], 1);
}

static void judge(const char *first, const char *second, enum ttf_result want, const char *reason)
{
    struct ttf_slot_record record;

    ttf_slot_record_init(&record);
    assert_int_equal(ttf_slot_record_images(&record, 2), 0);
    snprintf(record.images[0].lacking, sizeof(record.images[0].lacking), "%s", first);
    snprintf(record.images[1].lacking, sizeof(record.images[1].lacking), "%s", second);
    ttf_ledger_judge(&record);
    assert_int_equal(record.result, want);
    assert_string_equal(record.reason, reason);
    ttf_slot_record_free(&record);
}

static void a_slot_is_judged_by_what_it_lacks(void **state)
{
    (void)state;
    judge("", "", TTF_RESULT_CAPTURED, "");
    judge("", "corrupt", TTF_RESULT_PARTIAL, "corrupt");
    judge("missing", "corrupt", TTF_RESULT_FAILED, "missing");
}

static void a_missed_slot_stays_missed(void **state)
{
    struct ttf_slot_record record;

    (void)state;
    ttf_slot_record_init(&record);
    record.result = TTF_RESULT_POWER;
    strcpy(record.reason, TTF_REASON_NO_POWER);
    ttf_ledger_judge(&record);
    assert_int_equal(record.result, TTF_RESULT_POWER);
}

static void quantiles_are_tight_upper_bounds(void **state)
{
    static struct ttf_quantile q;

    (void)state;
    assert_int_equal(ttf_quantile_ns(&q, 0.99), 0);
    for (int64_t i = 1; i <= 1000; i++)
        ttf_quantile_add(&q, i % 2 ? i * 1000 : -i * 1000);
    assert_int_equal(q.max_ns, 1000000);
    assert_in_range(ttf_quantile_ns(&q, 0.99), 990000, 990000 + 990000 / 64 + 1);
    assert_in_range(ttf_quantile_ns(&q, 0.5), 500000, 500000 + 500000 / 64 + 1);
    assert_int_equal(ttf_quantile_ns(&q, 1), 1000000);
}

static void quantiles_take_any_duration(void **state)
{
    static struct ttf_quantile q;

    (void)state;
    ttf_quantile_add(&q, INT64_MAX);
    ttf_quantile_add(&q, 0);
    assert_int_equal(ttf_quantile_ns(&q, 0.5), 0);
    assert_true(ttf_quantile_ns(&q, 1) == INT64_MAX);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_slot_has_exactly_one_record),
        cmocka_unit_test(a_slot_is_judged_by_what_it_lacks),
        cmocka_unit_test(a_missed_slot_stays_missed),
        cmocka_unit_test(quantiles_are_tight_upper_bounds),
        cmocka_unit_test(quantiles_take_any_duration),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
