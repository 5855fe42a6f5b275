/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The world of the simulated box, brought up to date by whoever looks. Between
 * changes everything has a closed form, so time that nobody looks at costs nothing:
 * the guardian's lease and temperature readings are told to it in bulk, except
 * where a lamp could come near its temperature limit.
 */
#include <errno.h>
#include <math.h>
#include <string.h>

#include "box_private.h"
#include "ttf/base/time.h"

int64_t sim_box_elapsed(const struct sim_box *box, int64_t boot_ns)
{
    return boot_ns + box->elapsed_offset_ns;
}

bool sim_box_dead(struct sim_box *box)
{
    return ttf_clock_now_ns(box->clock) >= box->cut_ns;
}

void sim_panel_event(struct sim_box *box, enum ttf_panel_event_kind kind, int64_t at_ns)
{
    if (box->n_events == SIM_EVENTS_MAX) {
        box->n_events--;
        memmove(&box->events[0], &box->events[1], box->n_events * sizeof(box->events[0]));
    }
    box->events[box->n_events].kind = kind;
    box->events[box->n_events].at_ns = at_ns;
    box->n_events++;
}

/* The light as it is driven at instant t (boot), faults of lamps included. */
static void sync_light(struct sim_box *box, int64_t t)
{
    struct sim_light_state state = {.door_open = box->door_open};
    bool dead[TTF_LAMPS_MAX] = {false};
    bool stuck[TTF_LAMPS_MAX] = {false};
    const struct sim_light_state *last = sim_light_now(&box->light);
    int64_t elapsed = sim_box_elapsed(box, t);

    for (unsigned k = 0; k < box->faults.n; k++) {
        enum ttf_fault_kind kind = box->faults.fault[k].kind;

        if (kind != TTF_FAULT_LAMP_DEAD && kind != TTF_FAULT_LAMP_STUCK)
            continue;
        if (sim_fault_active(&box->faults, k, elapsed))
            (kind == TTF_FAULT_LAMP_DEAD ? dead : stuck)[box->faults.target[k]] = true;
    }
    for (unsigned i = 0; i < box->config.n_lamps; i++) {
        if (stuck[i] && !box->stuck[i])
            box->stuck_permille[i] = last->level[i];
        box->stuck[i] = stuck[i];
        state.level[i] = dead[i]    ? 0
                         : stuck[i] ? box->stuck_permille[i]
                                    : box->guardian.lamp[i].actual_permille;
    }
    if (memcmp(state.level, last->level, sizeof(state.level)) != 0 ||
        state.door_open != last->door_open)
        sim_light_switch(&box->light, elapsed, &state);
}

void sim_world_sync(struct sim_box *box)
{
    sync_light(box, box->world_ns);
}

static void sync_door(struct sim_box *box, int64_t t)
{
    bool open = box->door_pushed_open;

    for (unsigned k = 0; k < box->faults.n; k++)
        if (box->faults.fault[k].kind == TTF_FAULT_DOOR_OPEN)
            open |= sim_fault_active(&box->faults, k, sim_box_elapsed(box, t));
    if (open == box->door_open)
        return;
    box->door_open = open;
    if (box->config.door_switch) {
        ttf_guardian_door(&box->guardian, t, open);
        sim_panel_event(box, open ? TTF_PANEL_DOOR_OPENED : TTF_PANEL_DOOR_CLOSED, t);
    }
}

void sim_world_push_door(struct sim_box *box, bool open)
{
    box->door_pushed_open = open;
    sync_door(box, box->world_ns);
    sync_light(box, box->world_ns);
}

/* The guardian through time, each of its limits becoming light at its own instant. */
static void guard_to(struct sim_box *box, int64_t t)
{
    for (;;) {
        int64_t next = ttf_guardian_next_ns(&box->guardian);

        if (next > t)
            break;
        ttf_guardian_advance(&box->guardian, next);
        sync_light(box, next);
    }
    ttf_guardian_advance(&box->guardian, t);
}

static bool temp_sensor_gone(const struct sim_box *box, int64_t t)
{
    for (unsigned k = 0; k < box->faults.n; k++)
        if (box->faults.fault[k].kind == TTF_FAULT_SENSOR_GONE &&
            box->faults.target[k] == (unsigned)box->temp_sensor &&
            sim_fault_active(&box->faults, k, sim_box_elapsed(box, t)))
            return true;
    return false;
}

/* No lit lamp's limit can be reached from t on, as things are switched now. */
static bool cool(const struct sim_box *box, int64_t t)
{
    double bound = sim_light_temp_bound_degc(&box->light, sim_box_elapsed(box, t)) * 1000.0 + 1.0;

    for (unsigned i = 0; i < box->config.n_lamps; i++) {
        const struct ttf_lamp_info *info = &box->config.lamps[i].info;

        if (info->max_temp_mdegc != 0 && box->guardian.lamp[i].actual_permille > 0 &&
            bound >= info->max_temp_mdegc)
            return false;
    }
    return true;
}

static int32_t temp_mdegc(struct sim_box *box, int64_t t)
{
    return (int32_t)sim_sensor_value(box, (unsigned)box->temp_sensor, t);
}

/* From world_ns to t, no fault changing in between: the guardian's poll of its sensor, each second. */
static void poll_temp(struct sim_box *box, int64_t t)
{
    int64_t poll = (box->world_ns / SIM_TEMP_POLL_NS + 1) * SIM_TEMP_POLL_NS;
    int64_t last = t / SIM_TEMP_POLL_NS * SIM_TEMP_POLL_NS;

    if (box->temp_sensor < 0 || temp_sensor_gone(box, box->world_ns))
        return;
    while (poll <= last) {
        guard_to(box, poll);
        if (cool(box, poll)) {
            ttf_guardian_temp_through(&box->guardian, poll, last, temp_mdegc(box, poll));
            guard_to(box, last);
            poll = last;
        }
        ttf_guardian_temp(&box->guardian, poll, temp_mdegc(box, poll));
        sync_light(box, poll);
        poll += SIM_TEMP_POLL_NS;
    }
}

static int64_t next_fault_change(const struct sim_box *box, int64_t t)
{
    int64_t next = TTF_NS_NEVER, elapsed = sim_box_elapsed(box, t);

    for (unsigned k = 0; k < box->faults.n; k++) {
        enum ttf_fault_kind kind = box->faults.fault[k].kind;
        int64_t change;

        if (kind != TTF_FAULT_LAMP_DEAD && kind != TTF_FAULT_LAMP_STUCK &&
            kind != TTF_FAULT_DOOR_OPEN && kind != TTF_FAULT_SENSOR_GONE)
            continue;
        change = sim_fault_next_change(&box->faults, k, elapsed);
        if (change != TTF_NS_NEVER && change - box->elapsed_offset_ns < next)
            next = change - box->elapsed_offset_ns;
    }
    return next;
}

static void advance(struct sim_box *box, int64_t now)
{
    while (box->world_ns < now) {
        int64_t change = next_fault_change(box, box->world_ns);
        int64_t t = change < now ? change : now;

        poll_temp(box, t);
        guard_to(box, t);
        box->world_ns = t;
        sync_door(box, t);
        sync_light(box, t);
    }
}

void sim_world_init(struct sim_box *box, int64_t now_ns)
{
    struct ttf_lamp_info info[TTF_LAMPS_MAX];

    for (unsigned i = 0; i < box->config.n_lamps; i++)
        info[i] = box->config.lamps[i].info;
    box->temp_sensor = -1;
    for (unsigned i = box->config.n_sensors; i-- > 0;)
        if (box->config.sensors[i].kind == TTF_SENSOR_TEMP_MDEGC)
            box->temp_sensor = (int)i;
    box->world_ns = now_ns;
    sim_light_init(&box->light, &box->config, &box->faults, sim_box_elapsed(box, now_ns));
    ttf_guardian_init(&box->guardian, info, box->config.n_lamps, now_ns);
    if (box->config.power_on_ns > 0)
        ttf_guardian_assume_used(&box->guardian);
    if (box->temp_sensor >= 0 && !temp_sensor_gone(box, now_ns))
        ttf_guardian_temp(&box->guardian, now_ns, temp_mdegc(box, now_ns));
    sync_door(box, now_ns);
    sync_light(box, now_ns);
}

int sim_world_enter(struct sim_box *box)
{
    int64_t now = ttf_clock_now_ns(box->clock);

    if (now >= box->cut_ns)
        return -ENODEV;
    pthread_mutex_lock(&box->lock);
    advance(box, now);
    return 0;
}

void sim_world_leave(struct sim_box *box)
{
    pthread_mutex_unlock(&box->lock);
}
