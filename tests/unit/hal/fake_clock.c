/* SPDX-License-Identifier: Apache-2.0 */
/* fake_clock.c: a clock whose monotonic twin lags behind, as after a suspend; all else is the inner one's. */
#include <stdlib.h>

#include "fake_v4l2.h"
#include "ttf/hal/clock_backend.h"

struct lagging {
    struct ttf_clock base;
    struct ttf_clock *inner;
    const int64_t *lag_ns;
};

static struct lagging *of(struct ttf_clock *base)
{
    return (struct lagging *)base;
}

static int64_t lagging_now_ns(struct ttf_clock *base)
{
    return ttf_clock_now_ns(of(base)->inner);
}

static void lagging_utc(struct ttf_clock *base, struct ttf_utc *ret)
{
    ttf_clock_utc(of(base)->inner, ret);
}

static const char *lagging_boot_id(struct ttf_clock *base)
{
    return ttf_clock_boot_id(of(base)->inner);
}

static int64_t lagging_offset_ns(struct ttf_clock *base, int64_t *ret_uncertainty_ns)
{
    *ret_uncertainty_ns = 250;
    return *of(base)->lag_ns;
}

static void lagging_join(struct ttf_clock *base)
{
    ttf_clock_join(of(base)->inner);
}

static void lagging_leave(struct ttf_clock *base)
{
    ttf_clock_leave(of(base)->inner);
}

static int lagging_wait_until(struct ttf_clock *base, int64_t deadline_ns)
{
    return ttf_clock_wait_until(of(base)->inner, deadline_ns);
}

static void lagging_charge(struct ttf_clock *base, enum ttf_work work, unsigned times)
{
    ttf_clock_charge(of(base)->inner, work, times);
}

/* The gate is the inner clock's, and knows it: its other ops never come here. */
static struct ttf_gate *lagging_gate_create(struct ttf_clock *base)
{
    return ttf_gate_create(of(base)->inner);
}

static void lagging_destroy(struct ttf_clock *base)
{
    ttf_clock_destroy(of(base)->inner);
    free(base);
}

static const struct ttf_clock_ops OPS = {
    .name = "lagging",
    .is_virtual = true,
    .now_ns = lagging_now_ns,
    .utc = lagging_utc,
    .boot_id = lagging_boot_id,
    .monotonic_offset_ns = lagging_offset_ns,
    .join = lagging_join,
    .leave = lagging_leave,
    .wait_until = lagging_wait_until,
    .charge = lagging_charge,
    .gate_create = lagging_gate_create,
    .destroy = lagging_destroy,
};

struct ttf_clock *fake_clock_create(struct ttf_clock *inner, const int64_t *lag_ns)
{
    struct lagging *clock = calloc(1, sizeof(*clock));

    if (clock) {
        clock->base.ops = &OPS;
        clock->inner = inner;
        clock->lag_ns = lag_ns;
    }
    return clock ? &clock->base : NULL;
}
