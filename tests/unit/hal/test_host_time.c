/* SPDX-License-Identifier: Apache-2.0 */
/* test_host_time.c: a PC's time stands in for a clock that nobody vouches for, and for nothing better. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <errno.h>

#include "ttf/hal/clock_backend.h"
#include "ttf/hal/host_time.h"

#define NOW_NS (INT64_C(1790000000) * TTF_NS_PER_S) /* 2026 */

struct box_clock {
    struct ttf_clock base; /* first */
    struct ttf_host_time *host;
    int64_t boot_ns;
    int64_t
        own_ns; /* its UTC of boot 0: 1970, as a board without a battery has it, or one that was set */
    enum ttf_trust own;
};

static void own_utc(struct ttf_clock *base, struct ttf_utc *ret)
{
    struct box_clock *clock = (struct box_clock *)base;

    *ret = (struct ttf_utc){.boot_ns = clock->boot_ns,
                            .utc_ns = clock->boot_ns + clock->own_ns,
                            .uncertainty_ns = TTF_NS_UNKNOWN,
                            .trust = clock->own};
    if (clock->host)
        ttf_host_time_apply(clock->host, ret);
}

static void trust_host(struct ttf_clock *base, struct ttf_host_time *host)
{
    ((struct box_clock *)base)->host = host;
}

static const struct ttf_clock_ops OPS = {.utc = own_utc, .trust_host = trust_host};
static const struct ttf_clock_ops DEAF = {.utc = own_utc};

static struct ttf_utc utc_of(struct box_clock *clock)
{
    struct ttf_utc utc;

    ttf_clock_utc(&clock->base, &utc);
    return utc;
}

static void a_pc_s_time_is_taken_where_there_is_none_and_goes_on_by_the_boot_clock(void **state)
{
    struct box_clock clock = {.base.ops = &OPS, .boot_ns = 100 * TTF_NS_PER_S};
    struct ttf_host_time *host = ttf_host_time_create();

    (void)state;
    if (!host) {
        fail();
        return;
    }
    ttf_clock_trust_host(&clock.base, host);
    assert_int_equal(utc_of(&clock).trust, TTF_TRUST_NONE);
    assert_int_equal(ttf_host_time_offer(host, &clock.base, NOW_NS, NULL), 0);
    clock.boot_ns += TTF_NS_PER_H;
    assert_int_equal(utc_of(&clock).trust, TTF_TRUST_HOST);
    assert_true(utc_of(&clock).utc_ns == NOW_NS + TTF_NS_PER_H);
    assert_true(utc_of(&clock).uncertainty_ns > 2 * TTF_NS_PER_S &&
                utc_of(&clock).uncertainty_ns < 3 * TTF_NS_PER_S);
    ttf_host_time_destroy(host);
}

static void a_better_clock_is_kept_and_takes_over_when_it_comes(void **state)
{
    struct box_clock clock = {
        .base.ops = &OPS, .own = TTF_TRUST_RTC, .own_ns = NOW_NS - TTF_NS_PER_H};
    struct ttf_host_time *host = ttf_host_time_create();

    (void)state;
    if (!host) {
        fail();
        return;
    }
    ttf_clock_trust_host(&clock.base, host);
    assert_int_equal(ttf_host_time_offer(host, &clock.base, NOW_NS, NULL), -EALREADY);
    assert_true(utc_of(&clock).utc_ns == clock.boot_ns + clock.own_ns);
    clock.own = TTF_TRUST_NONE;
    assert_int_equal(ttf_host_time_offer(host, &clock.base, NOW_NS, NULL), 0);
    assert_int_equal(utc_of(&clock).trust, TTF_TRUST_HOST);
    clock.own = TTF_TRUST_NTP;
    assert_int_equal(utc_of(&clock).trust, TTF_TRUST_NTP);
    assert_true(utc_of(&clock).utc_ns == clock.boot_ns + clock.own_ns);
    ttf_host_time_destroy(host);
}

static void two_pcs_do_not_pull_at_it_by_turns(void **state)
{
    struct box_clock clock = {.base.ops = &OPS};
    struct ttf_host_time *host = ttf_host_time_create();

    (void)state;
    if (!host) {
        fail();
        return;
    }
    ttf_clock_trust_host(&clock.base, host);
    assert_int_equal(ttf_host_time_offer(host, &clock.base, NOW_NS, NULL), 0);
    clock.boot_ns += TTF_HOST_TIME_LASTS_NS - 1;
    assert_int_equal(ttf_host_time_offer(host, &clock.base, NOW_NS, NULL), -EALREADY);
    clock.boot_ns += 1;
    assert_int_equal(ttf_host_time_offer(host, &clock.base, NOW_NS, NULL), 0);
    assert_true(utc_of(&clock).utc_ns == NOW_NS);
    ttf_host_time_destroy(host);
}

static void a_pc_that_was_never_set_is_not_believed(void **state)
{
    struct box_clock clock = {.base.ops = &OPS};
    struct ttf_host_time *host = ttf_host_time_create();

    (void)state;
    if (!host) {
        fail();
        return;
    }
    assert_int_equal(ttf_host_time_offer(host, &clock.base, TTF_NS_PER_S, NULL), -EINVAL);
    assert_int_equal(ttf_host_time_offer(host, &clock.base, INT64_MAX, NULL), -EINVAL);
    clock.base.ops = &DEAF; /* as simulated time is */
    ttf_clock_trust_host(&clock.base, host);
    assert_null(clock.host);
    ttf_host_time_destroy(host);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_pc_s_time_is_taken_where_there_is_none_and_goes_on_by_the_boot_clock),
        cmocka_unit_test(a_better_clock_is_kept_and_takes_over_when_it_comes),
        cmocka_unit_test(two_pcs_do_not_pull_at_it_by_turns),
        cmocka_unit_test(a_pc_that_was_never_set_is_not_believed),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
