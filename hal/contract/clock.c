/* SPDX-License-Identifier: Apache-2.0 */
/* Dispatch of clock.h to whatever clock there is. */
#include <stddef.h>

#include "ttf/base/attr.h"
#include "ttf/hal/clock_backend.h"

const char *ttf_trust_name(enum ttf_trust trust)
{
    static const char *const names[TTF_TRUST_COUNT] = {"none", "host", "rtc", "ntp"};

    return (unsigned)trust < TTF_TRUST_COUNT ? names[trust] : "none";
}

int64_t ttf_clock_now_ns(struct ttf_clock *clock)
{
    return clock->ops->now_ns(clock);
}

void ttf_clock_trust_host(struct ttf_clock *clock, struct ttf_host_time *host_time)
{
    if (clock->ops->trust_host)
        clock->ops->trust_host(clock, host_time);
}

void ttf_clock_utc(struct ttf_clock *clock, struct ttf_utc *ret)
{
    clock->ops->utc(clock, ret);
    if (ret->utc_ns >= TTF_UTC_EARLIEST_NS)
        return;
    ret->trust = TTF_TRUST_NONE;
    ret->uncertainty_ns = TTF_NS_UNKNOWN;
}

int64_t ttf_clock_monotonic_offset_ns(struct ttf_clock *clock, int64_t *ret_uncertainty_ns)
{
    int64_t uncertainty_ns = 0, offset_ns = 0;

    if (clock->ops->monotonic_offset_ns)
        offset_ns = clock->ops->monotonic_offset_ns(clock, &uncertainty_ns);
    if (ret_uncertainty_ns)
        *ret_uncertainty_ns = uncertainty_ns;
    return offset_ns;
}

const char *ttf_clock_boot_id(struct ttf_clock *clock)
{
    return clock->ops->boot_id(clock);
}

bool ttf_clock_is_virtual(const struct ttf_clock *clock)
{
    return clock->ops->is_virtual;
}

void ttf_clock_join(struct ttf_clock *clock)
{
    clock->ops->join(clock);
}

void ttf_clock_join_for(struct ttf_clock *clock)
{
    clock->ops->join(clock);
}

void ttf_clock_leave(struct ttf_clock *clock)
{
    clock->ops->leave(clock);
}

int ttf_clock_wait_until(struct ttf_clock *clock, int64_t deadline_ns)
{
    return clock->ops->wait_until(clock, deadline_ns);
}

void ttf_clock_charge(struct ttf_clock *clock, enum ttf_work work, unsigned times)
{
    if ((unsigned)work < TTF_WORK_COUNT && times > 0)
        clock->ops->charge(clock, work, times);
}

struct ttf_gate *ttf_gate_create(struct ttf_clock *clock)
{
    return clock->ops->gate_create(clock);
}

void ttf_gate_destroy(struct ttf_gate *gate)
{
    if (gate)
        gate->clock->ops->gate_destroy(gate);
}

void ttf_gate_open(struct ttf_gate *gate)
{
    gate->clock->ops->gate_open(gate);
}

int ttf_gate_wait(struct ttf_gate *gate, int64_t deadline_ns)
{
    return gate->clock->ops->gate_wait(gate, deadline_ns);
}

void ttf_clock_destroy(struct ttf_clock *clock)
{
    if (clock)
        clock->ops->destroy(clock);
}
