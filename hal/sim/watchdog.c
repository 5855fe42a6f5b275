/* SPDX-License-Identifier: Apache-2.0 */
/* The simulated watchdog bites without hurting: it counts how often it would have. */
#include <errno.h>
#include <stdlib.h>

#include "box_private.h"
#include "ttf/base/time.h"

struct sim_watchdog {
    struct ttf_watchdog base;
    struct sim_box *box;
};

/* World locked. A lapse is one bite, however long it lasts: a real one resets the box. */
static void look(struct sim_box *box)
{
    if (!box->dog_armed || box->world_ns - box->dog_fed_ns <= box->dog_timeout_ns)
        return;
    box->dog_bites++;
    box->dog_armed = false;
}

static int watchdog_arm(struct ttf_watchdog *base, int64_t timeout_ns)
{
    struct sim_box *box = ((struct sim_watchdog *)base)->box;

    if (sim_world_enter(box) < 0)
        return -ENODEV;
    look(box);
    box->dog_armed = true;
    box->dog_timeout_ns = timeout_ns;
    box->dog_fed_ns = box->world_ns;
    sim_world_leave(box);
    return 0;
}

static int watchdog_feed(struct ttf_watchdog *base)
{
    struct sim_box *box = ((struct sim_watchdog *)base)->box;
    bool armed;

    if (sim_world_enter(box) < 0)
        return -ENODEV;
    armed = box->dog_armed;
    look(box);
    /* Fed late: it has bitten, and would be armed again after the reset. */
    box->dog_armed = armed;
    box->dog_fed_ns = box->world_ns;
    sim_world_leave(box);
    return armed ? 0 : -EPIPE;
}

static void watchdog_disarm(struct ttf_watchdog *base)
{
    struct sim_box *box = ((struct sim_watchdog *)base)->box;

    if (sim_world_enter(box) < 0)
        return;
    look(box);
    box->dog_armed = false;
    sim_world_leave(box);
}

static void watchdog_destroy(struct ttf_watchdog *base)
{
    free(base);
}

static const struct ttf_watchdog_ops sim_watchdog_ops = {.name = "sim",
                                                         .arm = watchdog_arm,
                                                         .feed = watchdog_feed,
                                                         .disarm = watchdog_disarm,
                                                         .destroy = watchdog_destroy};

struct ttf_watchdog *sim_watchdog_create(struct sim_box *box)
{
    struct sim_watchdog *watchdog = calloc(1, sizeof(*watchdog));

    if (!watchdog)
        return NULL;
    watchdog->base.ops = &sim_watchdog_ops;
    watchdog->box = box;
    return &watchdog->base;
}

unsigned sim_watchdog_bites(struct sim_box *box)
{
    unsigned bites;

    if (sim_world_enter(box) < 0)
        pthread_mutex_lock(&box->lock); /* no power: as it stood */
    bites =
        box->dog_bites + (box->dog_armed && box->world_ns - box->dog_fed_ns > box->dog_timeout_ns);
    sim_world_leave(box);
    return bites;
}
