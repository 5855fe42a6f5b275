/* SPDX-License-Identifier: Apache-2.0 */
#include "cmocka_includes.h"

#include "utc_watch.h"

static struct ttf_utc_watch begun(enum ttf_trust trust)
{
    struct ttf_utc utc = {.boot_ns = 1000, .utc_ns = 5000 * TTF_NS_PER_S + 1000, .trust = trust};
    struct ttf_utc_watch w;

    ttf_utc_watch_init(&w, &utc);
    return w;
}

static void slewing_is_no_step(void **state)
{
    struct ttf_utc_watch w = begun(TTF_TRUST_NTP);
    struct ttf_utc_news news;
    struct ttf_utc utc = {.boot_ns = 2000,
                          .utc_ns = 5000 * TTF_NS_PER_S + 2000 + 50 * TTF_NS_PER_MS,
                          .trust = TTF_TRUST_NTP};

    (void)state;
    assert_false(ttf_utc_watch_look(&w, &utc, &news));
}

static void a_step_is_noticed_once(void **state)
{
    struct ttf_utc_watch w = begun(TTF_TRUST_NTP);
    struct ttf_utc_news news;
    struct ttf_utc utc = {
        .boot_ns = 2000, .utc_ns = 4000 * TTF_NS_PER_S + 2000, .trust = TTF_TRUST_NTP};

    (void)state;
    assert_true(ttf_utc_watch_look(&w, &utc, &news));
    assert_true(news.stepped);
    assert_int_equal(news.step_ns, -1000 * TTF_NS_PER_S);
    assert_false(ttf_utc_watch_look(&w, &utc, &news));
}

static void trust_that_rises_is_news(void **state)
{
    struct ttf_utc_watch w = begun(TTF_TRUST_NONE);
    struct ttf_utc_news news;
    struct ttf_utc utc = {
        .boot_ns = 2000, .utc_ns = 5000 * TTF_NS_PER_S + 2000, .trust = TTF_TRUST_NTP};

    (void)state;
    assert_int_equal(ttf_utc_watch_at(&w, 7), TTF_NS_UNKNOWN);
    assert_true(ttf_utc_watch_look(&w, &utc, &news));
    assert_true(news.more_trusted);
    assert_false(news.stepped);
    assert_int_equal(ttf_utc_watch_at(&w, 7), 5000 * TTF_NS_PER_S + 7);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(slewing_is_no_step),
        cmocka_unit_test(a_step_is_noticed_once),
        cmocka_unit_test(trust_that_rises_is_news),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
