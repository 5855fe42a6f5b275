/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The lamp guardian: see guardian.h for the rules. Every entry point first lets
 * time pass to its instant, so that a limit that fell in between strikes at its
 * own instant, and not when somebody next looks.
 */
#include "ttf/hal/guardian.h"

#include <errno.h>
#include <string.h>

#include "duty.h"
#include "ttf/base/time.h"
#include "ttf/hal/lamps_backend.h"

static int64_t later(int64_t t, int64_t by)
{
    return t > TTF_NS_NEVER - by ? TTF_NS_NEVER : t + by;
}

static bool watched(const struct ttf_lamp_info *info)
{
    return info->max_temp_mdegc != 0;
}

void ttf_guardian_init(struct ttf_guardian *g, const struct ttf_lamp_info *info, unsigned n,
                       int64_t now_ns)
{
    memset(g, 0, sizeof(*g));
    g->n = n < TTF_LAMPS_MAX ? n : TTF_LAMPS_MAX;
    for (unsigned i = 0; i < g->n; i++) {
        g->info[i] = info[i];
        g->lamp[i].on_since_ns = TTF_NS_UNKNOWN;
        /* What was before is not known: it may have been switched off for being hot. */
        if (watched(&info[i]))
            g->lamp[i].heat = TTF_TRIP_TEMP_MISSING;
    }
    g->now_ns = now_ns;
    g->lease_until_ns = now_ns;
    g->temp_at_ns = now_ns;
}

void ttf_guardian_assume_used(struct ttf_guardian *g)
{
    for (unsigned i = 0; i < g->n; i++)
        duty_record(&g->info[i], &g->lamp[i], g->now_ns - duty_limit_ns(&g->info[i]), g->now_ns);
}

static void turn_off(struct ttf_guardian *g, unsigned i)
{
    struct ttf_guardian_lamp *lamp = &g->lamp[i];

    if (lamp->on_since_ns != TTF_NS_UNKNOWN) {
        int64_t from = lamp->on_since_ns;

        lamp->on_since_ns = TTF_NS_UNKNOWN;
        duty_record(&g->info[i], lamp, from, g->now_ns);
    }
    lamp->actual_permille = 0;
}

/* Whatever else keeps it dark in the meantime, it has to cool first. */
static void note_heat(struct ttf_guardian *g, unsigned i, enum ttf_lamp_trip why)
{
    if (why == TTF_TRIP_TEMP || why == TTF_TRIP_TEMP_MISSING)
        g->lamp[i].heat = why;
}

static void trip(struct ttf_guardian *g, unsigned i, enum ttf_lamp_trip why)
{
    turn_off(g, i);
    g->lamp[i].trip = why;
    note_heat(g, i, why);
}

/* The next instant at which a limit of this lit lamp strikes; the lease apart. */
static int64_t lamp_next(const struct ttf_guardian *g, unsigned i, enum ttf_lamp_trip *ret_why)
{
    const struct ttf_lamp_info *info = &g->info[i];
    const struct ttf_guardian_lamp *lamp = &g->lamp[i];
    int64_t next = TTF_NS_NEVER, t;

    *ret_why = TTF_TRIP_NONE;
    if (lamp->on_since_ns == TTF_NS_UNKNOWN)
        return next;
    if (info->max_on_ns > 0) {
        next = later(lamp->on_since_ns, info->max_on_ns);
        *ret_why = TTF_TRIP_MAX_ON;
    }
    if (duty_limited(info)) {
        t = duty_exhausted_ns(info, lamp, g->now_ns);
        if (t < next) {
            next = t;
            *ret_why = TTF_TRIP_MAX_DUTY;
        }
    }
    if (watched(info)) {
        t = later(g->temp_at_ns, TTF_TEMP_MISSING_NS);
        if (t < next) {
            next = t;
            *ret_why = TTF_TRIP_TEMP_MISSING;
        }
    }
    return next;
}

int64_t ttf_guardian_next_ns(const struct ttf_guardian *g)
{
    int64_t next = g->leased ? g->lease_until_ns : TTF_NS_NEVER;

    for (unsigned i = 0; i < g->n; i++) {
        enum ttf_lamp_trip why;
        int64_t t = lamp_next(g, i, &why);

        if (t < next)
            next = t;
    }
    return next;
}

static void pass(struct ttf_guardian *g, int64_t to_ns)
{
    if (to_ns <= g->now_ns)
        return;
    for (unsigned i = 0; i < g->n; i++)
        if (g->lamp[i].on_since_ns != TTF_NS_UNKNOWN)
            g->lamp[i].on_total_ns += to_ns - g->now_ns;
    g->now_ns = to_ns;
}

/* Applies whatever has struck by now. */
static void strike(struct ttf_guardian *g)
{
    for (unsigned i = 0; i < g->n; i++) {
        enum ttf_lamp_trip why;

        if (lamp_next(g, i, &why) <= g->now_ns)
            trip(g, i, why);
    }
    if (g->leased && g->lease_until_ns <= g->now_ns) {
        g->leased = false;
        for (unsigned i = 0; i < g->n; i++)
            if (g->lamp[i].actual_permille > 0)
                trip(g, i, TTF_TRIP_LEASE);
    }
}

void ttf_guardian_advance(struct ttf_guardian *g, int64_t now_ns)
{
    for (;;) {
        int64_t next = ttf_guardian_next_ns(g);

        if (next == TTF_NS_NEVER || (next > now_ns && next > g->now_ns))
            break;
        pass(g, next);
        strike(g);
    }
    pass(g, now_ns);
}

static int64_t lease_end(int64_t from_ns, int64_t until_ns)
{
    int64_t renewals = until_ns > from_ns ? (until_ns - from_ns) / TTF_LEASE_RENEW_NS : 0;

    return later(from_ns + renewals * TTF_LEASE_RENEW_NS, TTF_LEASE_LAPSE_NS);
}

int ttf_guardian_acquire(struct ttf_guardian *g, int64_t now_ns)
{
    ttf_guardian_advance(g, now_ns);
    if (g->leased)
        return -EBUSY;
    g->leased = true;
    g->lease_until_ns = lease_end(g->now_ns, g->now_ns);
    for (unsigned i = 0; i < g->n; i++) {
        g->lamp[i].commanded_permille = 0;
        if (g->lamp[i].trip == TTF_TRIP_LEASE)
            g->lamp[i].trip = TTF_TRIP_NONE;
    }
    return 0;
}

int ttf_guardian_renew_through(struct ttf_guardian *g, int64_t now_ns, int64_t until_ns)
{
    ttf_guardian_advance(g, now_ns);
    if (!g->leased)
        return -ESTALE;
    g->lease_until_ns = lease_end(g->now_ns, until_ns);
    return 0;
}

int ttf_guardian_renew(struct ttf_guardian *g, int64_t now_ns)
{
    return ttf_guardian_renew_through(g, now_ns, now_ns);
}

void ttf_guardian_release(struct ttf_guardian *g, int64_t now_ns)
{
    ttf_guardian_advance(g, now_ns);
    g->leased = false;
    for (unsigned i = 0; i < g->n; i++) {
        turn_off(g, i);
        g->lamp[i].commanded_permille = 0;
        if (g->lamp[i].trip == TTF_TRIP_LEASE)
            g->lamp[i].trip = TTF_TRIP_NONE;
    }
}

/* What would keep lamp i dark now; a trip that takes a person apart. */
static enum ttf_lamp_trip obstacle(const struct ttf_guardian *g, unsigned i)
{
    const struct ttf_lamp_info *info = &g->info[i];

    if (info->interlock_door && g->door_open)
        return TTF_TRIP_DOOR;
    if (watched(info)) {
        int64_t limit = info->max_temp_mdegc;

        if (later(g->temp_at_ns, TTF_TEMP_MISSING_NS) <= g->now_ns)
            return TTF_TRIP_TEMP_MISSING;
        if (g->temp_known && g->temp_mdegc > limit)
            return TTF_TRIP_TEMP;
        if (g->lamp[i].heat != TTF_TRIP_NONE)
            return g->lamp[i].heat;
    }
    if (duty_limited(info) && duty_used_ns(info, &g->lamp[i], g->now_ns) >= duty_limit_ns(info))
        return TTF_TRIP_MAX_DUTY;
    return TTF_TRIP_NONE;
}

int ttf_guardian_set(struct ttf_guardian *g, int64_t now_ns, unsigned i, unsigned permille)
{
    struct ttf_guardian_lamp *lamp = &g->lamp[i];
    enum ttf_lamp_trip why;

    ttf_guardian_advance(g, now_ns);
    permille = ttf_lamp_round(&g->info[i], permille);
    if (permille == 0) {
        lamp->commanded_permille = 0;
        turn_off(g, i);
        return 0;
    }
    if (!g->leased)
        return -ESTALE;
    lamp->commanded_permille = permille;
    if (lamp->on_since_ns == TTF_NS_UNKNOWN) {
        why = lamp->trip == TTF_TRIP_MAX_ON ? TTF_TRIP_MAX_ON : obstacle(g, i);
        lamp->trip = why;
        note_heat(g, i, why);
        if (why != TTF_TRIP_NONE)
            return -EPERM;
        lamp->on_since_ns = g->now_ns;
    }
    lamp->actual_permille = permille;
    return 0;
}

/* What is known from now on, of at_ns. */
static void take_temp(struct ttf_guardian *g, int64_t at_ns, int32_t temp_mdegc)
{
    g->temp_known = true;
    g->temp_mdegc = temp_mdegc;
    g->temp_at_ns = at_ns;
    for (unsigned i = 0; i < g->n; i++) {
        int64_t limit = g->info[i].max_temp_mdegc;

        if (!watched(&g->info[i]))
            continue;
        if (temp_mdegc < limit - g->info[i].hysteresis_mdegc)
            g->lamp[i].heat = TTF_TRIP_NONE;
        if (g->lamp[i].actual_permille > 0 && temp_mdegc > limit)
            trip(g, i, TTF_TRIP_TEMP);
    }
}

void ttf_guardian_temp_through(struct ttf_guardian *g, int64_t now_ns, int64_t until_ns,
                               int32_t temp_mdegc)
{
    ttf_guardian_advance(g, now_ns);
    take_temp(g, until_ns > g->now_ns ? until_ns : g->now_ns, temp_mdegc);
}

void ttf_guardian_temp(struct ttf_guardian *g, int64_t now_ns, int32_t temp_mdegc)
{
    ttf_guardian_temp_through(g, now_ns, now_ns, temp_mdegc);
}

void ttf_guardian_temp_late(struct ttf_guardian *g, int64_t now_ns, int64_t at_ns,
                            int32_t temp_mdegc)
{
    bool superseded, old;

    ttf_guardian_advance(g, now_ns);
    if (at_ns > g->now_ns)
        at_ns = g->now_ns;
    /* temp_at_ns may be ahead: then what was told ahead is of later than any reading but one of now. */
    superseded = at_ns < g->temp_at_ns && at_ns < g->now_ns;
    old = later(at_ns, TTF_TEMP_MISSING_NS) <= g->now_ns;
    if (!superseded && !old)
        take_temp(g, at_ns, temp_mdegc);
}

void ttf_guardian_door(struct ttf_guardian *g, int64_t now_ns, bool open)
{
    ttf_guardian_advance(g, now_ns);
    g->door_open = open;
    for (unsigned i = 0; open && i < g->n; i++)
        if (g->lamp[i].actual_permille > 0 && g->info[i].interlock_door)
            trip(g, i, TTF_TRIP_DOOR);
}

int ttf_guardian_clear(struct ttf_guardian *g, int64_t now_ns, unsigned i)
{
    ttf_guardian_advance(g, now_ns);
    if (g->lamp[i].trip == TTF_TRIP_NONE)
        return 0;
    if (g->lamp[i].trip == TTF_TRIP_LEASE && !g->leased)
        return -EPERM;
    if (obstacle(g, i) != TTF_TRIP_NONE)
        return -EPERM;
    g->lamp[i].trip = TTF_TRIP_NONE;
    return 0;
}
