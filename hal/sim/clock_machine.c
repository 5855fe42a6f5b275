/* SPDX-License-Identifier: Apache-2.0 */
/*
 * `sim.clock: real`: simulated devices on the machine's clock. Its waits and gates
 * are the machine's own; only UTC can be made to step.
 */
#include <errno.h>
#include <stdlib.h>

#include "clock.h"
#include "ttf/base/time.h"

struct machine_clock {
    struct ttf_clock base;
    struct ttf_clock *real;
    struct sim_utc *utc;
};

static struct ttf_clock *real_of(struct ttf_clock *base)
{
    return ((struct machine_clock *)base)->real;
}

static int64_t machine_now_ns(struct ttf_clock *base)
{
    return ttf_clock_now_ns(real_of(base));
}

static void machine_utc(struct ttf_clock *base, struct ttf_utc *ret)
{
    struct sim_utc *utc = ((struct machine_clock *)base)->utc;
    uint32_t count;

    ttf_clock_utc(real_of(base), ret);
    ret->utc_ns += sim_utc_stepped_ns(utc, ret->boot_ns, true, &count);
    ret->steps += count;
}

static void machine_trust_host(struct ttf_clock *base, struct ttf_host_time *host_time)
{
    ttf_clock_trust_host(real_of(base), host_time);
}

static const char *machine_boot_id(struct ttf_clock *base)
{
    return ttf_clock_boot_id(real_of(base));
}

static void machine_join(struct ttf_clock *base)
{
    ttf_clock_join(real_of(base));
}

static void machine_leave(struct ttf_clock *base)
{
    ttf_clock_leave(real_of(base));
}

static int machine_wait_until(struct ttf_clock *base, int64_t deadline_ns)
{
    return ttf_clock_wait_until(real_of(base), deadline_ns);
}

static void machine_charge(struct ttf_clock *base, enum ttf_work work, unsigned times)
{
    ttf_clock_charge(real_of(base), work, times);
}

/* The gate is the real clock's, and knows it: its other ops never come here. */
static struct ttf_gate *machine_gate_create(struct ttf_clock *base)
{
    return ttf_gate_create(real_of(base));
}

static void machine_destroy(struct ttf_clock *base)
{
    ttf_clock_destroy(real_of(base));
    free(base);
}

static const struct ttf_clock_ops machine_clock_ops = {
    .name = "sim on the machine's clock",
    .is_virtual = false,
    .now_ns = machine_now_ns,
    .utc = machine_utc,
    .trust_host = machine_trust_host,
    .boot_id = machine_boot_id,
    .join = machine_join,
    .leave = machine_leave,
    .wait_until = machine_wait_until,
    .charge = machine_charge,
    .gate_create = machine_gate_create,
    .gate_destroy = ttf_gate_destroy,
    .gate_open = ttf_gate_open,
    .gate_wait = ttf_gate_wait,
    .destroy = machine_destroy,
};

struct ttf_clock *sim_clock_machine_create(struct sim_utc *utc)
{
    struct machine_clock *clock = calloc(1, sizeof(*clock));

    if (!clock) {
        errno = ENOMEM;
        return NULL;
    }
    clock->real = ttf_clock_real_create();
    if (!clock->real) {
        free(clock);
        return NULL;
    }
    clock->base.ops = &machine_clock_ops;
    clock->utc = utc;
    return &clock->base;
}
