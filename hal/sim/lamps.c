/* SPDX-License-Identifier: Apache-2.0 */
/* The simulated lamps: a client of the guardian that the box itself runs. */
#include <errno.h>
#include <math.h>
#include <stdlib.h>

#include "box_private.h"
#include "ttf/base/time.h"
#include "ttf/hal/lamps_backend.h"

struct sim_lamps {
    struct ttf_lamps base;
    struct sim_box *box;
};

static struct sim_box *box_of(struct ttf_lamps *base)
{
    return ((struct sim_lamps *)base)->box;
}

static int no_power(struct ttf_err *err)
{
    return ttf_err_set(err, -ENODEV, "lamps", "the simulated box has lost power");
}

static int lamps_acquire(struct ttf_lamps *base, int64_t alive_until_ns, struct ttf_err *err)
{
    struct sim_box *box = box_of(base);
    int r;

    if (sim_world_enter(box) < 0)
        return no_power(err);
    r = ttf_guardian_acquire(&box->guardian, box->world_ns);
    if (r == 0)
        r = ttf_guardian_renew_through(&box->guardian, box->world_ns, alive_until_ns);
    sim_world_sync(box);
    sim_world_leave(box);
    return r < 0 ? ttf_err_set(err, r, "lamps", "another client holds the lamps' lease") : 0;
}

static int lamps_alive(struct ttf_lamps *base, int64_t alive_until_ns, struct ttf_err *err)
{
    struct sim_box *box = box_of(base);
    int r;

    if (sim_world_enter(box) < 0)
        return no_power(err);
    r = ttf_guardian_renew_through(&box->guardian, box->world_ns, alive_until_ns);
    sim_world_leave(box);
    return r < 0 ? ttf_err_set(err, r, "lamps", "the lease has lapsed; acquire it again") : 0;
}

static int lamps_set(struct ttf_lamps *base, unsigned i, unsigned permille, struct ttf_err *err)
{
    struct sim_box *box = box_of(base);
    enum ttf_lamp_trip trip;
    int r;

    if (sim_world_enter(box) < 0)
        return no_power(err);
    r = ttf_guardian_set(&box->guardian, box->world_ns, i, permille);
    trip = box->guardian.lamp[i].trip;
    sim_world_sync(box);
    sim_world_leave(box);
    if (r == -EPERM)
        return ttf_err_set(err, r, base->info[i].name, "the guardian keeps the lamp dark: %s",
                           ttf_lamp_trip_name(trip));
    if (r < 0)
        return ttf_err_set(err, r, base->info[i].name, "no lease is held on the lamps");
    return 0;
}

static int lamps_state(struct ttf_lamps *base, unsigned i, struct ttf_lamp_state *ret)
{
    struct sim_box *box = box_of(base);
    const struct ttf_guardian_lamp *lamp = &box->guardian.lamp[i];

    if (sim_world_enter(box) < 0)
        return -ENODEV;
    ret->commanded_permille = lamp->commanded_permille;
    ret->actual_permille = lamp->actual_permille;
    ret->measured_permille =
        (int)lround(1000.0 * sim_light_lamp(&box->light, i, sim_box_elapsed(box, box->world_ns)));
    ret->trip = lamp->trip;
    ret->on_since_ns = lamp->on_since_ns;
    ret->on_total_ns = lamp->on_total_ns;
    sim_world_leave(box);
    return 0;
}

static int lamps_clear(struct ttf_lamps *base, unsigned i, struct ttf_err *err)
{
    struct sim_box *box = box_of(base);
    int r;

    if (sim_world_enter(box) < 0)
        return no_power(err);
    r = ttf_guardian_clear(&box->guardian, box->world_ns, i);
    sim_world_leave(box);
    return r < 0 ? ttf_err_set(err, r, base->info[i].name, "the trip's cause persists") : 0;
}

static void lamps_release(struct ttf_lamps *base)
{
    struct sim_box *box = box_of(base);

    if (sim_world_enter(box) < 0)
        return;
    ttf_guardian_release(&box->guardian, box->world_ns);
    sim_world_sync(box);
    sim_world_leave(box);
}

static void lamps_destroy(struct ttf_lamps *base)
{
    free(base);
}

static const struct ttf_lamps_ops sim_lamps_ops = {
    .name = "sim",
    .acquire = lamps_acquire,
    .alive = lamps_alive,
    .set = lamps_set,
    .state = lamps_state,
    .clear = lamps_clear,
    .release = lamps_release,
    .destroy = lamps_destroy,
};

struct ttf_lamps *sim_lamps_create(struct sim_box *box)
{
    struct sim_lamps *lamps = calloc(1, sizeof(*lamps));

    if (!lamps)
        return NULL;
    lamps->base.ops = &sim_lamps_ops;
    lamps->base.n = box->config.n_lamps;
    for (unsigned i = 0; i < lamps->base.n; i++)
        lamps->base.info[i] = box->config.lamps[i].info;
    lamps->box = box;
    return &lamps->base;
}
