/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Whatever a client, the sensors and the door do, and however rarely anybody
 * looks: no lamp is on beyond any of its limits. The judge below knows nothing of
 * the guardian's inside: it keeps every instant at which a level changed, finds
 * these by asking the guardian's state at its own next instants, and checks the
 * log by brute force.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <stdlib.h>
#include <string.h>

#include "ttf/base/time.h"
#include "ttf/hal/guardian.h"

#define S         TTF_NS_PER_S
#define MS        TTF_NS_PER_MS
#define STRETCHES 4096
#define EVENTS    900
#define SCHEDULES 150
#define LAMPS     2
#define PENDING   6

/* mdegC */
#define LIMIT      50000
#define HYSTERESIS 2000

struct stretch {
    int64_t from, to;
};

/* A reading that was made and has not come yet. */
struct reading {
    int64_t at;
    int32_t temp;
};

struct judge {
    struct ttf_guardian g;
    uint64_t random;
    int64_t now;
    int64_t renewed, temp_at, open_since; /* what the judge itself did; TTF_NS_NEVER: not */
    bool busy;                            /* a client that does nothing but switch */
    bool bulk; /* renewals and readings are told ahead, as the simulated box does */
    bool late; /* readings come any time after they were made, in any order */
    bool leased, hot, open;
    int32_t temp;              /* of the newest reading that came; it was made at temp_at */
    bool must_cool[LAMPS];     /* went dark for its temperature, or nothing was known of that yet */
    unsigned n_pending;        /* late */
    unsigned n_old, n_delayed; /* came when they said nothing any more; late, and in time */
    struct reading pending[PENDING];
    unsigned n[LAMPS];
    struct stretch log[LAMPS][STRETCHES];
    bool lit[LAMPS];
};

static uint64_t rnd(struct judge *j, uint64_t below)
{
    j->random = j->random * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
    return (j->random >> 33) % below;
}

/* Writes what the lamps do from `at` on into the log. */
static void note(struct judge *j, int64_t at)
{
    for (unsigned i = 0; i < j->g.n; i++) {
        bool lit = j->g.lamp[i].actual_permille > 0;

        if (lit && !j->lit[i]) {
            assert_true(j->n[i] < STRETCHES);
            j->log[i][j->n[i]++] = (struct stretch){at, TTF_NS_NEVER};
        } else if (!lit && j->lit[i]) {
            j->log[i][j->n[i] - 1].to = at;
            j->must_cool[i] |=
                j->g.lamp[i].trip == TTF_TRIP_TEMP || j->g.lamp[i].trip == TTF_TRIP_TEMP_MISSING;
        }
        j->lit[i] = lit;
        assert_int_equal(lit, j->g.lamp[i].on_since_ns != TTF_NS_UNKNOWN);
    }
}

/* Rules of the moment: held at every instant at which the lamps were looked at. */
static void check_moment(const struct judge *j, int64_t at)
{
    for (unsigned i = 0; i < j->g.n; i++) {
        const struct ttf_lamp_info *info = &j->g.info[i];

        if (j->g.lamp[i].actual_permille == 0)
            continue;
        assert_true(j->leased && at < j->renewed + TTF_LEASE_LAPSE_NS);
        assert_false(info->interlock_door && j->open);
        if (info->max_temp_mdegc != 0) {
            assert_true(at < j->temp_at + TTF_TEMP_MISSING_NS);
            assert_false(j->hot && j->temp > info->max_temp_mdegc);
            assert_false(j->must_cool[i]);
        }
    }
}

/* Sometimes stops at each of the guardian's own instants, sometimes looks only at the end. */
static void pass(struct judge *j, int64_t to)
{
    struct ttf_guardian sleeper = j->g;

    for (;;) {
        int64_t next = ttf_guardian_next_ns(&j->g);

        if (next > to)
            break;
        ttf_guardian_advance(&j->g, next);
        note(j, next);
        check_moment(j, next);
    }
    ttf_guardian_advance(&j->g, to);
    note(j, to);
    check_moment(j, to);
    /* Whoever looks only at the end must find the same. */
    ttf_guardian_advance(&sleeper, to);
    assert_memory_equal(&sleeper, &j->g, sizeof(sleeper));
    j->now = to;
}

static void check_log(const struct judge *j, unsigned i)
{
    const struct ttf_lamp_info *info = &j->g.info[i];
    int64_t limit = info->duty_window_ns / 1000 * info->max_duty_permille;

    for (unsigned a = 0; a < j->n[i]; a++) {
        int64_t end = j->log[i][a].to < j->now ? j->log[i][a].to : j->now, used = 0;

        if (info->max_on_ns > 0)
            assert_true(end - j->log[i][a].from <= info->max_on_ns);
        if (info->max_duty_permille == TTF_LAMP_FULL)
            continue;
        /* The worst windows end with a stretch. */
        for (unsigned b = 0; b <= a; b++) {
            int64_t from = j->log[i][b].from, to = b == a ? end : j->log[i][b].to;

            if (from < end - info->duty_window_ns)
                from = end - info->duty_window_ns;
            if (to > from)
                used += to - from;
        }
        assert_true(used <= limit);
    }
}

/* A reading has come that was made at `at`: whatever was made before the newest is as if it had not come. */
static void came(struct judge *j, int64_t at, int32_t temp)
{
    bool old = j->now - at >= TTF_TEMP_MISSING_NS;

    j->n_old += old;
    j->n_delayed += !old && at < j->now;
    if (at < j->temp_at && at < j->now)
        return;
    j->temp_at = at;
    j->temp = temp;
    j->hot = true;
    for (unsigned i = 0; i < j->g.n && !old; i++)
        if (temp < j->g.info[i].max_temp_mdegc - j->g.info[i].hysteresis_mdegc)
            j->must_cool[i] = false;
}

/* One is made, or one of those that were made comes. */
static void read_late(struct judge *j, int32_t temp)
{
    struct reading *any;

    if (j->n_pending == 0 || (j->n_pending < PENDING && rnd(j, 2))) {
        j->pending[j->n_pending++] = (struct reading){j->now, temp};
        return;
    }
    any = &j->pending[rnd(j, j->n_pending)];
    ttf_guardian_temp_late(&j->g, j->now, any->at, any->temp);
    came(j, any->at, any->temp);
    *any = j->pending[--j->n_pending];
}

static void read_temp(struct judge *j)
{
    /* Any; or one that heats nothing and has cooled nothing. */
    int32_t temp = (int32_t)(rnd(j, 3) ? rnd(j, 60000) : LIMIT - rnd(j, HYSTERESIS + 1));
    int64_t until = j->now + (j->bulk ? (int64_t)rnd(j, 4000) * MS : 0);

    if (j->late) {
        read_late(j, temp);
        return;
    }
    if (j->bulk)
        ttf_guardian_temp_through(&j->g, j->now, until, temp);
    else
        ttf_guardian_temp(&j->g, j->now, temp);
    came(j, until, temp);
}

/* Told ahead, the last renewal is the last of those 100 ms apart that is not behind the instant. */
static void renew(struct judge *j)
{
    int64_t until = j->now + (j->bulk ? (int64_t)rnd(j, 2000) * MS + (int64_t)rnd(j, MS) : 0);
    int r = j->bulk ? ttf_guardian_renew_through(&j->g, j->now, until)
                    : ttf_guardian_renew(&j->g, j->now);

    if (r == 0)
        j->renewed = j->now + (until - j->now) / TTF_LEASE_RENEW_NS * TTF_LEASE_RENEW_NS;
}

static void event(struct judge *j)
{
    unsigned i = (unsigned)rnd(j, j->g.n);

    switch (j->busy ? rnd(j, 30) * 6 : rnd(j, 12)) {
    case 0:
        if (ttf_guardian_acquire(&j->g, j->now) == 0) {
            j->leased = true;
            j->renewed = j->now;
        }
        break;
    case 1:
        if (rnd(j, 10) == 0) {
            ttf_guardian_release(&j->g, j->now);
            j->leased = false;
        }
        break;
    case 2:
    case 3:
        read_temp(j);
        break;
    case 4:
        j->open = rnd(j, 3) == 0;
        ttf_guardian_door(&j->g, j->now, j->open);
        break;
    case 5:
        (void)ttf_guardian_clear(&j->g, j->now, i);
        break;
    default:
        (void)ttf_guardian_set(&j->g, j->now, i, (unsigned)(rnd(j, j->busy ? 2 : 3) * 500));
        break;
    }
    renew(j);
    note(j, j->now);
    check_moment(j, j->now);
}

static void no_schedule_of_events_leaves_a_lamp_on_beyond_any_limit(void **state)
{
    struct judge *j = malloc(sizeof(*j));
    unsigned lit = 0, full = 0, bulk_trips = 0, old = 0, delayed = 0, trips[TTF_TRIP_COUNT] = {0};

    (void)state;
    assert_non_null(j);
    for (uint64_t seed = 1; seed <= SCHEDULES; seed++) {
        struct ttf_lamp_info info[2] = {{.kind = TTF_LAMP_PWM}, {.kind = TTF_LAMP_PWM}};

        memset(j, 0, sizeof(*j));
        j->busy = seed % 2;
        j->bulk = seed % 4 >= 2;
        j->late = seed % 8 == 0;
        j->random = seed * UINT64_C(0x9e3779b97f4a7c15);
        for (int i = 0; i < 2; i++) {
            /* Every other schedule knows only duty: busy lamps, more stretches than are kept. */
            info[i].max_duty_permille = 300 + (unsigned)rnd(j, 600);
            info[i].duty_window_ns = (int64_t)(rnd(j, 300) + 1) * S;
            if (j->busy)
                continue;
            info[i].max_on_ns = rnd(j, 3) ? (int64_t)(rnd(j, 20) + 1) * S : 0;
            info[i].max_duty_permille = rnd(j, 4) ? (unsigned)rnd(j, 900) + 1 : TTF_LAMP_FULL;
            info[i].max_temp_mdegc = rnd(j, 2) ? LIMIT : 0;
            info[i].hysteresis_mdegc = HYSTERESIS;
            info[i].interlock_door = rnd(j, 2);
            j->must_cool[i] = info[i].max_temp_mdegc != 0;
        }
        j->now = (int64_t)rnd(j, 1000) * S;
        j->temp_at = j->now;
        ttf_guardian_init(&j->g, info, 2, j->now);
        for (int e = 0; e < EVENTS; e++) {
            /* Mostly quick, so that the lease holds; now and then a hang. */
            pass(j, j->now + (int64_t)rnd(j, j->busy || rnd(j, 40) ? 390 : 30000) * MS +
                        (int64_t)rnd(j, MS));
            event(j);
            for (unsigned i = 0; i < 2; i++)
                trips[j->g.lamp[i].trip]++;
            bulk_trips += j->bulk && j->g.lamp[0].trip == TTF_TRIP_LEASE;
            full += j->g.lamp[0].n_spans == TTF_GUARDIAN_SPANS;
        }
        for (unsigned i = 0; i < 2; i++) {
            check_log(j, i);
            lit += j->n[i];
        }
        old += j->n_old;
        delayed += j->n_delayed;
    }
    free(j);
    /* The schedules were not idle: lamps burned, every limit struck, the account was full. */
    assert_true(lit > 1000);
    assert_true(full > 100);
    assert_true(bulk_trips > 0);
    assert_true(old > 100 && delayed > 100);
    for (int trip = 1; trip < TTF_TRIP_COUNT; trip++)
        assert_true(trips[trip] > 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(no_schedule_of_events_leaves_a_lamp_on_beyond_any_limit),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
