/* SPDX-License-Identifier: Apache-2.0 */
#include "lamp_driver.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

/*
 * A measured level this far below its command, or above it, is no longer warm-up
 * or ageing but a lamp that does not do as told.
 */
#define LEVEL_LOW_SHARE  2   /* less than 1/2 of the command */
#define LEVEL_HIGH_ABOVE 150 /* permille above it */

int ttf_lamp_driver_begin(struct ttf_lamp_driver *driver, struct ttf_lamps *lamps,
                          struct ttf_events *events, int64_t alive_until_ns, struct ttf_err *err)
{
    memset(driver, 0, sizeof(*driver));
    driver->events = events;
    if (!lamps)
        return 0;
    driver->n = ttf_lamps_count(lamps);
    driver->lamps = lamps;
    if (driver->n > 0) {
        int r = ttf_lamps_acquire(lamps, alive_until_ns, err);

        if (r < 0) {
            driver->lamps = NULL;
            return r;
        }
    }
    return 0;
}

void ttf_lamp_driver_end(struct ttf_lamp_driver *driver)
{
    if (driver->lamps && driver->n > 0)
        ttf_lamps_release(driver->lamps);
    driver->lamps = NULL;
}

static void command(struct ttf_lamp_driver *driver, unsigned i)
{
    struct ttf_err err = {0};
    int r = ttf_lamps_set(driver->lamps, i, driver->wanted[i], &err);

    /* A trip has been told already. */
    if (r < 0 && !driver->refused[i] && driver->trip[i] == TTF_TRIP_NONE)
        ttf_events_emit(driver->events, "lamp-trip", "lamp %s cannot be set to %u permille: %s",
                        ttf_lamps_info(driver->lamps, i)->name, driver->wanted[i], err.what);
    driver->refused[i] = r < 0;
}

bool ttf_lamp_driver_want(struct ttf_lamp_driver *driver, const unsigned levels[TTF_LAMPS_MAX])
{
    bool changed = false;

    for (unsigned i = 0; driver->lamps && i < driver->n; i++) {
        if (driver->wanted[i] == levels[i])
            continue;
        driver->wanted[i] = levels[i];
        command(driver, i);
        changed = true;
    }
    return changed;
}

/* Whether it is known what the lamp does. */
static bool look(struct ttf_lamp_driver *driver, unsigned i, struct ttf_lamp_state *ret)
{
    bool silent = ttf_lamps_state(driver->lamps, i, ret) < 0;

    if (silent != driver->silent[i])
        ttf_events_emit(driver->events, "lamp-trip",
                        silent ? "what lamp %s does cannot be known" : "lamp %s is heard of again",
                        ttf_lamps_info(driver->lamps, i)->name);
    driver->silent[i] = silent;
    return !silent;
}

static void look_after(struct ttf_lamp_driver *driver, unsigned i)
{
    const char *name = ttf_lamps_info(driver->lamps, i)->name;
    struct ttf_lamp_state state;

    if (!look(driver, i, &state))
        return;
    if (state.trip != driver->trip[i]) {
        if (state.trip != TTF_TRIP_NONE)
            ttf_events_emit(driver->events, "lamp-trip", "lamp %s went off: %s", name,
                            ttf_lamp_trip_name(state.trip));
        else
            ttf_events_emit(driver->events, "lamp-trip", "lamp %s may be lit again", name);
        driver->trip[i] = state.trip;
    }
    /*
     * A trip is kept until the lamp is commanded again: so ask at every tick. The guardian
     * refuses as long as the cause lasts, and always where it takes a person.
     */
    if (driver->wanted[i] > 0 && state.actual_permille == 0)
        command(driver, i);
}

/* A guardian that is away is asked at every tick, and told of once. */
static void take_lease_anew(struct ttf_lamp_driver *driver, int64_t alive_until_ns)
{
    struct ttf_err err = {0};
    bool none = ttf_lamps_acquire(driver->lamps, alive_until_ns, &err) < 0;

    if (!none)
        ttf_events_emit(driver->events, "lamp-trip", "the lamps' lease had lapsed: taken anew");
    else if (!driver->no_lease)
        ttf_events_emit(driver->events, "lamp-trip",
                        "the lamps' lease has lapsed; no new lease on the lamps: %s", err.what);
    driver->no_lease = none;
}

void ttf_lamp_driver_alive(struct ttf_lamp_driver *driver, int64_t alive_until_ns)
{
    if (!driver->lamps || driver->n == 0)
        return;
    if (ttf_lamps_alive(driver->lamps, alive_until_ns, NULL) < 0)
        take_lease_anew(driver, alive_until_ns);
    for (unsigned i = 0; i < driver->n; i++)
        look_after(driver, i);
}

static bool far_off(const struct ttf_lamp_driver *driver, unsigned i,
                    const struct ttf_lamp_state *state)
{
    int wanted = (int)driver->wanted[i];

    return state->measured_permille * LEVEL_LOW_SHARE < wanted ||
           state->measured_permille > wanted + LEVEL_HIGH_ABOVE;
}

/* Lit for less long than it needs, when the exposure began. */
static bool unsettled(const struct ttf_lamp_state *state, int64_t settle_ns, int64_t start_ns)
{
    return state->actual_permille > 0 && state->on_since_ns != TTF_NS_UNKNOWN &&
           start_ns != TTF_NS_UNKNOWN && start_ns - state->on_since_ns < settle_ns;
}

unsigned ttf_lamp_driver_sample(struct ttf_lamp_driver *driver, int64_t settle_ns,
                                struct ttf_shot *shot)
{
    unsigned marks = 0;

    shot->n_lamps = 0;
    for (unsigned i = 0; driver->lamps && i < driver->n && i < TTF_SHOT_LAMPS_MAX; i++) {
        struct ttf_shot_lamp *lamp = &shot->lamps[shot->n_lamps];
        struct ttf_lamp_state state;
        bool off;

        if (!look(driver, i, &state)) {
            marks |= TTF_LAMP_MARK_UNKNOWN;
            continue;
        }
        shot->n_lamps++;
        snprintf(lamp->name, sizeof(lamp->name), "%s", ttf_lamps_info(driver->lamps, i)->name);
        lamp->commanded_permille = (int)driver->wanted[i];
        lamp->measured_permille = state.measured_permille;
        if (driver->wanted[i] > 0 && state.actual_permille == 0)
            marks |= TTF_LAMP_MARK_TRIPPED;
        if (driver->wanted[i] > 0 && unsettled(&state, settle_ns, shot->start_ns))
            marks |= TTF_LAMP_MARK_UNSETTLED;
        if (state.measured_permille < 0 || state.trip != TTF_TRIP_NONE)
            continue; /* nobody measures, or dark on purpose: that tells nothing of the lamp */
        off = far_off(driver, i, &state);
        if (off)
            marks |= TTF_LAMP_MARK_LEVEL;
        if (off != driver->off_level[i])
            ttf_events_emit(driver->events, "lamp-level",
                            off ? "lamp %s: commanded %u permille, measured %d"
                                : "lamp %s does as told again: commanded %u permille, measured %d",
                            lamp->name, driver->wanted[i], state.measured_permille);
        driver->off_level[i] = off;
    }
    return marks;
}
