/* SPDX-License-Identifier: Apache-2.0 */
/* Quantities with units: exact, bounded, and refused with what was meant. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "ttf/base/attr.h"
#include "ttf/base/time.h"
#include "ttf/config/plan_file.h"
#include "ttf/config/units.h"

struct good {
    enum ttf_unit_kind kind;
    const char *text;
    int64_t value;
};

static void quantities_are_read_exactly(void **state)
{
    static const struct good GOOD[] = {
        {TTF_UNIT_TIME, "10min", INT64_C(600000000000)},
        {TTF_UNIT_TIME, "250ms", 250000000},
        {TTF_UNIT_TIME, "7d", INT64_C(604800000000000)},
        {TTF_UNIT_TIME, "20 ms", 20000000},
        {TTF_UNIT_TIME, "0.1s", 100000000},
        {TTF_UNIT_TIME, "1.5h", INT64_C(5400000000000)},
        {TTF_UNIT_TIME, "0.000000001s", 1},
        {TTF_UNIT_TIME, "1.000000000000s", TTF_NS_PER_S},
        {TTF_UNIT_TIME, "0.05min", INT64_C(3000000000)},
        {TTF_UNIT_TIME, "-5ms", -5000000},
        {TTF_UNIT_TIME, "0s", 0},
        {TTF_UNIT_TIME, "0.0min", 0},
        {TTF_UNIT_TIME, "9223372036854775807ns", INT64_MAX},
        {TTF_UNIT_BYTES, "2GiB", INT64_C(2147483648)},
        {TTF_UNIT_BYTES, "1.5KiB", 1536},
        {TTF_UNIT_BYTES, "3GB", INT64_C(3000000000)},
        {TTF_UNIT_FREQUENCY, "50Hz", 50000},
        {TTF_UNIT_FREQUENCY, "59.94Hz", 59940},
        {TTF_UNIT_SHARE, "80%", 800000},
        {TTF_UNIT_SHARE, "400permille", 400000},
        {TTF_UNIT_SHARE, "100ppm", 100},
        {TTF_UNIT_SHARE, "0.05%", 500},
        {TTF_UNIT_TEMPERATURE, "45degC", 45000},
        {TTF_UNIT_TEMPERATURE, "-2.5degC", -2500},
        {TTF_UNIT_LENS, "2.5dpt", 2500},
    };

    (void)state;
    for (unsigned i = 0; i < TTF_COUNT_OF(GOOD); i++) {
        struct ttf_err err = {0};
        int64_t value = -1;

        if (ttf_unit_parse(GOOD[i].kind, GOOD[i].text, &value, &err) != 0)
            fail_msg("%s: %s", GOOD[i].text, err.what);
        if (value != GOOD[i].value)
            fail_msg("%s is %" PRId64, GOOD[i].text, value);
    }
}

static void what_is_no_quantity_is_refused_with_what_was_meant(void **state)
{
    static const struct {
        const char *text;
        int code;
        const char *what, *hint;
    } BAD[] = {
        {"10", -EINVAL, "has no unit", "10s"},
        {"", -EINVAL, "no value", "10min"},
        {"min", -EINVAL, "not a time", "10min"},
        {"10 parsecs", -EINVAL, "no unit of", "ns, us, ms, s, min, h, d"},
        {"10minutes", -EINVAL, "no unit of", "min"},
        {"10m", -EINVAL, "no unit of", "min"},
        {"10Min", -EINVAL, "no unit of", "min"},
        {"1h30min", -EINVAL, "", ""},
        {"1e3s", -EINVAL, "", ""},
        {"0x10s", -EINVAL, "", ""},
        {"nan", -EINVAL, "not a time", ""},
        {"inf", -EINVAL, "not a time", ""},
        {"-inf", -EINVAL, "not a time", ""},
        {"nan s", -EINVAL, "not a time", ""},
        {"1.2.3s", -EINVAL, "", ""},
        {"1,5s", -EINVAL, "", ""},
        {" 5s", -EINVAL, "", ""},
        {"5s ", -EINVAL, "", ""},
        {"5  s", -EINVAL, "", ""},
        {"0.5ns", -EINVAL, "finer", ""},
        {"0.0000000001s", -EINVAL, "finer", ""},
        {"9223372036854775808ns", -ERANGE, "too large", ""},
        {"99999999999999999999999999999999s", -ERANGE, "too large", ""},
        {"106752d", -ERANGE, "too large", ""},
    };

    (void)state;
    for (unsigned i = 0; i < TTF_COUNT_OF(BAD); i++) {
        struct ttf_err err = {0};
        int64_t value = 42;
        int r = ttf_unit_parse(TTF_UNIT_TIME, BAD[i].text, &value, &err);

        if (r != BAD[i].code)
            fail_msg("'%s' gave %d", BAD[i].text, r);
        if (!strstr(err.what, BAD[i].what) || !strstr(err.hint, BAD[i].hint))
            fail_msg("'%s': %s; %s", BAD[i].text, err.what, err.hint);
        assert_int_equal(value, 42);
        assert_true(*err.what && *err.hint);
    }
}

/* A small generator of our own: the test needs the same numbers everywhere. */
static uint64_t next(uint64_t *state)
{
    *state ^= *state << 13;
    *state ^= *state >> 7;
    *state ^= *state << 17;
    return *state;
}

static void what_is_written_is_read_back_for_any_value(void **state)
{
    uint64_t random = 88172645463325252u;

    (void)state;
    for (unsigned i = 0; i < 20000; i++) {
        enum ttf_unit_kind kind = (enum ttf_unit_kind)(next(&random) % TTF_UNIT_KIND_COUNT);
        int64_t value = (int64_t)(next(&random) >> (1 + next(&random) % 62));
        int64_t back = -1;
        char text[64];

        if (next(&random) & 1)
            value = -value;
        ttf_unit_format(kind, value, text, sizeof text);
        if (ttf_unit_parse(kind, text, &back, NULL) != 0 || back != value)
            fail_msg("%" PRId64 " -> %s -> %" PRId64, value, text, back);
    }
}

static void noise_never_passes_as_a_number_with_rest(void **state)
{
    static const char LETTERS[] = "0123456789.-+eE nsmhdinfax%";
    uint64_t random = 1234567;

    (void)state;
    for (unsigned i = 0; i < 20000; i++) {
        char text[16], again[64];
        size_t n = next(&random) % (sizeof text - 1);
        int64_t value, back;

        for (size_t k = 0; k < n; k++)
            text[k] = LETTERS[next(&random) % (sizeof LETTERS - 1)];
        text[n] = '\0';
        if (ttf_unit_parse(TTF_UNIT_TIME, text, &value, NULL) == 0) {
            ttf_unit_format(TTF_UNIT_TIME, value, again, sizeof again);
            assert_int_equal(ttf_unit_parse(TTF_UNIT_TIME, again, &back, NULL), 0);
            assert_int_equal(value, back);
        }
    }
}

static void plain_numbers_are_finite_and_decimal(void **state)
{
    static const char *const BAD[] = {"nan", "inf", "-inf", "infinity", "0x1p3", "",     "1e",
                                      "e5",  ".",   "1..2", "1 ",       "--1",   "1e999"};
    double value = 7;
    int64_t whole = 7;

    (void)state;
    assert_int_equal(ttf_number_parse("-2.5e-3", &value, NULL), 0);
    assert_true(value == -0.0025);
    for (unsigned i = 0; i < TTF_COUNT_OF(BAD); i++)
        if (ttf_number_parse(BAD[i], &value, NULL) == 0)
            fail_msg("'%s' passed", BAD[i]);
    assert_int_equal(ttf_integer_parse("1008", &whole, NULL), 0);
    assert_int_equal(whole, 1008);
    assert_int_equal(ttf_integer_parse("10.0", &whole, NULL), -EINVAL);
    assert_int_equal(ttf_integer_parse("1e3", &whole, NULL), -EINVAL);
    assert_int_equal(ttf_integer_parse("9223372036854775808", &whole, NULL), -ERANGE);
}

static void sizes_are_two_whole_numbers(void **state)
{
    uint32_t w = 0, h = 0;

    (void)state;
    assert_int_equal(ttf_size_parse("512x384", &w, &h, NULL), 0);
    assert_int_equal(w, 512);
    assert_int_equal(h, 384);
    assert_int_equal(ttf_size_parse("512", &w, &h, NULL), -EINVAL);
    assert_int_equal(ttf_size_parse("512x", &w, &h, NULL), -EINVAL);
    assert_int_equal(ttf_size_parse("0x5", &w, &h, NULL), -EINVAL);
    assert_int_equal(ttf_size_parse("512x384px", &w, &h, NULL), -EINVAL);
    assert_int_equal(ttf_size_parse("70000x1", &w, &h, NULL), -EINVAL);
    assert_int_equal(ttf_size_parse("-5x5", &w, &h, NULL), -EINVAL);
}

static void instants_are_read_with_their_offset_and_written_back(void **state)
{
    int64_t utc = 0, local = 0, back = 0;
    uint64_t random = 99;
    char text[40];

    (void)state;
    assert_int_equal(ttf_utc_parse("1970-01-01T00:00:00Z", &utc, NULL), 0);
    assert_int_equal(utc, 0);
    assert_int_equal(ttf_utc_parse("2026-03-01T08:00:00Z", &utc, NULL), 0);
    assert_true(utc == INT64_C(1772352000) * TTF_NS_PER_S);
    assert_int_equal(ttf_utc_parse("2026-03-01T09:00:00+01:00", &local, NULL), 0);
    assert_true(local == utc);
    assert_int_equal(ttf_utc_parse("2024-02-29T00:00:00Z", &utc, NULL), 0);
    assert_int_equal(ttf_utc_parse("2025-02-29T00:00:00Z", &utc, NULL), -EINVAL);
    assert_int_equal(ttf_utc_parse("2026-13-01T00:00:00Z", &utc, NULL), -EINVAL);
    assert_int_equal(ttf_utc_parse("2026-03-01T08:00:00", &utc, NULL), -EINVAL);
    assert_int_equal(ttf_utc_parse("2026-03-01", &utc, NULL), -EINVAL);
    assert_int_equal(ttf_utc_parse("2026-03-01T08:00:00Zx", &utc, NULL), -EINVAL);
    for (unsigned i = 0; i < 5000; i++) {
        utc = (int64_t)(next(&random) % UINT64_C(7000000000)) * TTF_NS_PER_S;
        ttf_utc_format(utc, text, sizeof text);
        if (ttf_utc_parse(text, &back, NULL) != 0 || back != utc)
            fail_msg("%s", text);
    }
}

static void a_zone_s_offset_is_that_of_the_instant(void **state)
{
    struct ttf_err err = {0};
    int64_t winter = 0, summer = 0;
    int offset = -1;

    (void)state;
    assert_int_equal(ttf_zone_offset("UTC", 0, &offset, NULL), 0);
    assert_int_equal(offset, 0);
    assert_int_equal(ttf_zone_offset("Nowhere/City", 0, &offset, &err), -ENOENT);
    assert_non_null(strstr(err.what, "Nowhere/City"));
    assert_int_equal(ttf_zone_offset("../../etc/passwd", 0, &offset, NULL), -ENOENT);
    if (ttf_zone_offset("Europe/Berlin", 0, &offset, NULL) == -ENOENT) {
        print_message("this machine has no zone files: Europe/Berlin is not looked at\n");
        skip();
    }
    assert_int_equal(ttf_utc_parse("2026-01-15T12:00:00Z", &winter, NULL), 0);
    assert_int_equal(ttf_utc_parse("2026-07-15T12:00:00Z", &summer, NULL), 0);
    assert_int_equal(ttf_zone_offset("Europe/Berlin", winter, &offset, NULL), 0);
    assert_int_equal(offset, 3600);
    assert_int_equal(ttf_zone_offset("Europe/Berlin", summer, &offset, NULL), 0);
    assert_int_equal(offset, 7200);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(quantities_are_read_exactly),
        cmocka_unit_test(what_is_no_quantity_is_refused_with_what_was_meant),
        cmocka_unit_test(what_is_written_is_read_back_for_any_value),
        cmocka_unit_test(noise_never_passes_as_a_number_with_rest),
        cmocka_unit_test(plain_numbers_are_finite_and_decimal),
        cmocka_unit_test(sizes_are_two_whole_numbers),
        cmocka_unit_test(instants_are_read_with_their_offset_and_written_back),
        cmocka_unit_test(a_zone_s_offset_is_that_of_the_instant),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
