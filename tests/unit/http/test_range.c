/* SPDX-License-Identifier: Apache-2.0 */
/* test_range.c: what a Range header asks for. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "range.h"

static void asks(const char *text, int64_t total, enum range_kind kind, int64_t first,
                 int64_t bytes)
{
    struct range r = range_read(text, total);

    if (r.kind != kind || (kind != RANGE_OUTSIDE && (r.first != first || r.bytes != bytes)))
        fail_msg("'%s' of %lld: kind %d, %lld bytes from %lld", text ? text : "(none)",
                 (long long)total, (int)r.kind, (long long)r.bytes, (long long)r.first);
}

static void a_part_is_given_within_what_there_is(void **state)
{
    (void)state;
    asks("bytes=0-0", 10, RANGE_PART, 0, 1);
    asks("bytes=3-6", 10, RANGE_PART, 3, 4);
    asks("bytes=3-", 10, RANGE_PART, 3, 7);
    asks("bytes=3-99", 10, RANGE_PART, 3, 7);
    asks("bytes=-4", 10, RANGE_PART, 6, 4);
    asks("bytes=-99", 10, RANGE_PART, 0, 10);
    asks("bytes=-99", 0, RANGE_WHOLE, 0, 0);
    asks("bytes=9-99999999999999999999999", 10, RANGE_PART, 9, 1);
}

static void a_cursor_at_the_end_is_outside(void **state)
{
    (void)state;
    asks("bytes=10-", 10, RANGE_OUTSIDE, 0, 0);
    asks("bytes=99999999999999999999999-", 10, RANGE_OUTSIDE, 0, 0);
    asks("bytes=0-", 0, RANGE_OUTSIDE, 0, 0);
    asks("bytes=-0", 10, RANGE_OUTSIDE, 0, 0);
}

static void what_makes_no_sense_is_passed_over(void **state)
{
    static const char *const TEXTS[] = {"",           "bytes=",        "bytes=-",   "bytes=5-4",
                                        "bytes=a-b",  "bytes=1-2,4-5", "lines=1-2", "bytes=+1-",
                                        "bytes= 1-2", "bytes=1-2 ",    "bytes=--1", "bytes=0x1-2",
                                        NULL};

    (void)state;
    for (unsigned i = 0; TEXTS[i]; i++)
        asks(TEXTS[i], 10, RANGE_WHOLE, 0, 10);
    asks(NULL, 10, RANGE_WHOLE, 0, 10);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_part_is_given_within_what_there_is),
        cmocka_unit_test(a_cursor_at_the_end_is_outside),
        cmocka_unit_test(what_makes_no_sense_is_passed_over),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
