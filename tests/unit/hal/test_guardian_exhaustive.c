/* SPDX-License-Identifier: Apache-2.0 */
/*
 * All schedules of few kinds of events, tick by tick, limits being a few ticks: each
 * lamp's light is seen just before each tick, at it, and after the tick's event, and is
 * judged by what may be read off that history. A guardian that is asked only when
 * something happens, however late, must have come to the same.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <errno.h>
#include <string.h>

#include "ttf/base/time.h"
#include "ttf/hal/guardian.h"

#define S         TTF_NS_PER_S
#define DEPTH_MAX 16
#define ACTS_MAX  8

#define LIMIT_MDEGC 50000
#define HYST_MDEGC  5000

enum act {
    NOTHING = 0,
    ON,
    OFF,
    CLEAR,
    OPEN,
    CLOSE,
    HOT,  /* above the limit */
    WARM, /* below it, not below the hysteresis */
    COOL,
    ACQUIRE,
    RENEW,
    RELEASE
};

struct tick {
    enum act act;
    int ret;
    bool before; /* lit 1 ns before the tick */
    bool at;     /* lit at the tick, before its event */
    bool after;
};

struct search {
    /* what is searched */
    int64_t tick_ns;
    unsigned depth, n_acts;
    enum act acts[ACTS_MAX];
    struct ttf_lamp_info info;
    bool lease;               /* to be taken and renewed; else it is held for ever */
    int max_on, window, duty; /* ticks; 0: no limit */
    /* how far it has come */
    struct tick history[DEPTH_MAX];
    unsigned long judged, lit, refused, went_off;
};

/* ---- what may be read off a history; k is the newest tick ---- */

static int latest(const struct search *s, int k, enum act a, enum act b, enum act c)
{
    for (; k >= 0; k--)
        if (s->history[k].ret == 0 &&
            (s->history[k].act == a || s->history[k].act == b || s->history[k].act == c))
            return k;
    return -1;
}

static bool was(const struct search *s, int k, enum act act)
{
    return k >= 0 && s->history[k].act == act;
}

/* Ticks since the last renewal of a lease that is held; -1: none is. */
static int lease_age(const struct search *s, int k)
{
    int last = latest(s, k, ACQUIRE, RENEW, RELEASE);

    if (!s->lease)
        return 0;
    return last < 0 || was(s, last, RELEASE) ? -1 : k - last;
}

static bool door_open(const struct search *s, int k)
{
    return s->info.interlock_door && was(s, latest(s, k, OPEN, CLOSE, CLOSE), OPEN);
}

/* A cool reading came one tick before the first. */
static int reading_age(const struct search *s, int k)
{
    return s->info.max_temp_mdegc == 0 ? 0 : k - latest(s, k, HOT, WARM, COOL);
}

static bool hot(const struct search *s, int k)
{
    return s->info.max_temp_mdegc != 0 && was(s, latest(s, k, HOT, WARM, COOL), HOT);
}

/* Ticks lit on end before tick k, however short a dark moment between two. */
static int run_before(const struct search *s, int k)
{
    int n = 0;

    while (k - 1 - n >= 0 && s->history[k - 1 - n].after)
        n++;
    return n;
}

static int used_before(const struct search *s, int k)
{
    int n = 0;

    for (int i = k - 1; i >= 0 && i >= k - s->window; i--)
        n += s->history[i].after;
    return n;
}

static int64_t ns(const struct search *s, int ticks)
{
    return ticks * s->tick_ns;
}

/* Why a lit lamp must have gone off at tick k by itself. */
static bool limit_struck(const struct search *s, int k)
{
    return (s->lease && ns(s, lease_age(s, k - 1) + 1) >= TTF_LEASE_LAPSE_NS) ||
           (s->max_on > 0 && run_before(s, k) >= s->max_on) ||
           (s->window > 0 && used_before(s, k) >= s->duty) ||
           (s->info.max_temp_mdegc != 0 && ns(s, reading_age(s, k - 1) + 1) >= TTF_TEMP_MISSING_NS);
}

/* It burnt for max_on to its end, and nobody has cleared that. */
static bool awaits_a_person(const struct search *s, int k)
{
    for (int i = k; s->max_on > 0 && i >= 0; i--) {
        if (i < k && was(s, i, CLEAR) && s->history[i].ret == 0)
            return false;
        if (!s->history[i].at && run_before(s, i) >= s->max_on)
            return true;
    }
    return false;
}

/* Heat, or not knowing, turned it off or kept it off, and it has not been cool since. */
static bool awaits_cooling(const struct search *s, int k)
{
    if (s->info.max_temp_mdegc == 0)
        return false;
    for (int i = k; i >= 0; i--) {
        const struct tick *tick = &s->history[i];
        bool missing = ns(s, reading_age(s, i - 1) + 1) >= TTF_TEMP_MISSING_NS;

        if (tick->act == COOL && i < k)
            return false;
        /* It was lit, or was to be lit, just then. */
        if (tick->act == HOT && tick->at)
            return true;
        if (i > 0 && s->history[i - 1].after && !tick->at && missing)
            return true;
        if (i < k && tick->act == ON && tick->ret == -EPERM && (hot(s, i) || missing) &&
            !door_open(s, i) && !awaits_a_person(s, i))
            return true;
    }
    return false;
}

/* Whether a command to light at tick k has to be refused. */
static bool must_refuse(const struct search *s, int k)
{
    int age = lease_age(s, k);

    return (s->lease && (age < 0 || ns(s, age) >= TTF_LEASE_LAPSE_NS)) || door_open(s, k) ||
           hot(s, k) ||
           (s->info.max_temp_mdegc != 0 && ns(s, reading_age(s, k)) >= TTF_TEMP_MISSING_NS) ||
           awaits_cooling(s, k) || awaits_a_person(s, k) ||
           (s->window > 0 && used_before(s, k) >= s->duty);
}

/* ---- what must hold at tick k ---- */

static bool holds(struct search *s, int k)
{
    const struct tick *now = &s->history[k];
    bool burnt = k > 0 && s->history[k - 1].after;

    s->judged++;
    s->lit += now->after;
    s->refused += now->act == ON && now->ret < 0;
    s->went_off += burnt && !now->at;
    /* A limit strikes at its own instant, not before and not after. */
    if (now->before != burnt || (now->at && !burnt))
        return false;
    if (burnt && now->at == limit_struck(s, k))
        return false;
    /* Nothing lights by itself; what is lit goes out for a cause, at once. */
    if (now->after && !now->at && !(now->act == ON && now->ret == 0))
        return false;
    if (now->act == ON && !now->at && (now->ret < 0) != must_refuse(s, k))
        return false;
    if (now->act == ON && now->after != (now->ret == 0))
        return false;
    if (now->after && (door_open(s, k) || hot(s, k) || now->act == OFF || now->act == RELEASE))
        return false;
    return !(now->at && !now->after &&
             !(now->act == OFF || now->act == RELEASE || door_open(s, k) || hot(s, k)));
}

/* ---- the search ---- */

static bool lit(const struct ttf_guardian *g)
{
    return g->lamp[0].actual_permille > 0;
}

static int do_act(struct ttf_guardian *g, int64_t t, enum act act)
{
    switch (act) {
    case ON:
        return ttf_guardian_set(g, t, 0, 1000);
    case OFF:
        return ttf_guardian_set(g, t, 0, 0);
    case CLEAR:
        return ttf_guardian_clear(g, t, 0);
    case OPEN:
    case CLOSE:
        ttf_guardian_door(g, t, act == OPEN);
        return 0;
    case HOT:
        ttf_guardian_temp(g, t, LIMIT_MDEGC + 1);
        return 0;
    case WARM:
        ttf_guardian_temp(g, t, LIMIT_MDEGC - HYST_MDEGC);
        return 0;
    case COOL:
        ttf_guardian_temp(g, t, LIMIT_MDEGC - HYST_MDEGC - 1);
        return 0;
    case ACQUIRE:
        return ttf_guardian_acquire(g, t);
    case RENEW:
        return ttf_guardian_renew(g, t);
    case RELEASE:
        ttf_guardian_release(g, t);
        return 0;
    default:
        return 0;
    }
}

static void fail_at(const struct search *s, unsigned k, const char *what)
{
    static const char *const names[] = {"-",   "on",   "off",  "clear",   "open",  "close",
                                        "hot", "warm", "cool", "acquire", "renew", "release"};

    for (unsigned i = 0; i <= k; i++)
        print_error("tick %u: lit %d %d, %s gives %d, lit %d\n", i, s->history[i].before,
                    s->history[i].at, names[s->history[i].act], s->history[i].ret,
                    s->history[i].after);
    fail_msg("%s", what);
}

/* watched is looked at all the time, asleep only when something happens. */
static void go_on(struct search *s, unsigned k, const struct ttf_guardian *watched,
                  const struct ttf_guardian *asleep, int64_t t)
{
    for (unsigned a = 0; a < s->n_acts; a++) {
        struct ttf_guardian w = *watched;
        struct ttf_guardian z = *asleep;
        struct tick *tick = &s->history[k];

        tick->act = s->acts[a];
        ttf_guardian_advance(&w, t - 1);
        tick->before = lit(&w);
        ttf_guardian_advance(&w, t);
        tick->at = lit(&w);
        tick->ret = do_act(&w, t, tick->act);
        tick->after = lit(&w);
        if (tick->act != NOTHING && do_act(&z, t, tick->act) != tick->ret)
            fail_at(s, k, "asked late, it answered something else");
        if (!holds(s, (int)k))
            fail_at(s, k, "that must not be");
        if (k + 1 < s->depth) {
            go_on(s, k + 1, &w, &z, t + s->tick_ns);
            continue;
        }
        ttf_guardian_advance(&w, t + s->tick_ns);
        ttf_guardian_advance(&z, t + s->tick_ns);
        if (memcmp((const void *)&w, (const void *)&z, sizeof(w)) != 0)
            fail_at(s, k, "looked at late, it is in another state");
    }
}

static void search(struct search *s)
{
    struct ttf_guardian g;
    int64_t t = 1000 * s->tick_ns;

    s->info.kind = TTF_LAMP_PWM;
    s->info.max_on_ns = ns(s, s->max_on);
    s->info.duty_window_ns = ns(s, s->window);
    s->info.max_duty_permille =
        s->window > 0 ? (unsigned)(s->duty * TTF_LAMP_FULL / s->window) : TTF_LAMP_FULL;
    ttf_guardian_init(&g, &s->info, 1, t - s->tick_ns);
    if (!s->lease) {
        assert_int_equal(ttf_guardian_acquire(&g, t - s->tick_ns), 0);
        assert_int_equal(ttf_guardian_renew_through(&g, t - s->tick_ns, t + TTF_NS_PER_DAY), 0);
    }
    if (s->info.max_temp_mdegc != 0)
        ttf_guardian_temp(&g, t - s->tick_ns, 20000);
    go_on(s, 0, &g, &g, t);
    print_message("%lu moments judged; lit at %lu, refused at %lu, gone off by itself at %lu\n",
                  s->judged, s->lit, s->refused, s->went_off);
    assert_true(s->lit > 100 && s->refused > 100);
}

static void the_lease(void **state)
{
    struct search s = {.tick_ns = TTF_LEASE_LAPSE_NS / 4,
                       .depth = 7,
                       .n_acts = 6,
                       .acts = {NOTHING, ACQUIRE, RENEW, RELEASE, ON, OFF},
                       .lease = true};

    (void)state;
    search(&s);
    assert_true(s.went_off > 100);
}

static void time_on_at_a_stretch(void **state)
{
    struct search s = {
        .tick_ns = 1, .depth = 9, .n_acts = 4, .acts = {NOTHING, ON, OFF, CLEAR}, .max_on = 3};

    (void)state;
    search(&s);
    assert_true(s.went_off > 100);
}

static void the_share_of_a_window(void **state)
{
    struct search s = {
        .tick_ns = 1, .depth = 12, .n_acts = 3, .acts = {NOTHING, ON, OFF}, .window = 5, .duty = 2};

    (void)state;
    search(&s);
    assert_true(s.went_off > 100);
}

static void a_stretch_and_a_window_together(void **state)
{
    struct search s = {.tick_ns = S,
                       .depth = 9,
                       .n_acts = 4,
                       .acts = {NOTHING, ON, OFF, CLEAR},
                       .max_on = 2,
                       .window = 5,
                       .duty = 3};

    (void)state;
    search(&s);
    assert_true(s.went_off > 100);
}

static void heat_and_not_knowing(void **state)
{
    struct search s = {.tick_ns = TTF_TEMP_MISSING_NS / 4,
                       .depth = 7,
                       .n_acts = 6,
                       .acts = {NOTHING, ON, HOT, WARM, COOL, CLEAR},
                       .info = {.max_temp_mdegc = LIMIT_MDEGC, .hysteresis_mdegc = HYST_MDEGC}};

    (void)state;
    search(&s);
    assert_true(s.went_off > 100);
}

static void the_door(void **state)
{
    struct search s = {.tick_ns = 1,
                       .depth = 7,
                       .n_acts = 6,
                       .acts = {NOTHING, ON, OFF, CLEAR, OPEN, CLOSE},
                       .info = {.interlock_door = true}};

    (void)state;
    search(&s);
}

static void all_that_keeps_a_lamp_dark_at_once(void **state)
{
    struct search s = {.tick_ns = TTF_TEMP_MISSING_NS / 8,
                       .depth = 7,
                       .n_acts = 7,
                       .acts = {ON, CLEAR, OPEN, CLOSE, HOT, WARM, COOL},
                       .info = {.max_temp_mdegc = LIMIT_MDEGC,
                                .hysteresis_mdegc = HYST_MDEGC,
                                .interlock_door = true},
                       .max_on = 2,
                       .window = 6,
                       .duty = 3};

    (void)state;
    search(&s);
    assert_true(s.went_off > 100);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_lease),
        cmocka_unit_test(time_on_at_a_stretch),
        cmocka_unit_test(the_share_of_a_window),
        cmocka_unit_test(a_stretch_and_a_window_together),
        cmocka_unit_test(heat_and_not_knowing),
        cmocka_unit_test(the_door),
        cmocka_unit_test(all_that_keeps_a_lamp_dark_at_once),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
