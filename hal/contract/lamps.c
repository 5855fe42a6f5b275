/* SPDX-License-Identifier: Apache-2.0 */
/* The lamps' contract: names, look-ups, levels rounded to what a lamp can do. */
#include <errno.h>
#include <stddef.h>
#include <string.h>

#include "ttf/hal/lamps_backend.h"

const char *ttf_lamp_trip_name(enum ttf_lamp_trip trip)
{
    static const char *const names[TTF_TRIP_COUNT] = {
        "none", "lease", "max-on", "max-duty", "temperature", "temperature-missing", "door"};

    return (unsigned)trip < TTF_TRIP_COUNT ? names[trip] : "none";
}

unsigned ttf_lamp_round(const struct ttf_lamp_info *info, unsigned permille)
{
    unsigned step;

    if (permille > TTF_LAMP_FULL)
        permille = TTF_LAMP_FULL;
    switch (info->kind) {
    case TTF_LAMP_SWITCH:
        return permille >= TTF_LAMP_FULL / 2 ? TTF_LAMP_FULL : 0;
    case TTF_LAMP_STEPS:
        if (info->steps == 0)
            return 0;
        step = (unsigned)(((uint64_t)permille * info->steps + TTF_LAMP_FULL / 2) / TTF_LAMP_FULL);
        return (unsigned)(((uint64_t)step * TTF_LAMP_FULL + info->steps / 2) / info->steps);
    default:
        return permille;
    }
}

unsigned ttf_lamps_count(const struct ttf_lamps *lamps)
{
    return lamps->n;
}

const struct ttf_lamp_info *ttf_lamps_info(const struct ttf_lamps *lamps, unsigned i)
{
    return i < lamps->n ? &lamps->info[i] : NULL;
}

int ttf_lamps_find(const struct ttf_lamps *lamps, const char *name)
{
    for (unsigned i = 0; i < lamps->n; i++)
        if (strcmp(lamps->info[i].name, name) == 0)
            return (int)i;
    return -ENOENT;
}

int ttf_lamps_acquire(struct ttf_lamps *lamps, int64_t alive_until_ns, struct ttf_err *err)
{
    return lamps->ops->acquire(lamps, alive_until_ns, err);
}

int ttf_lamps_alive(struct ttf_lamps *lamps, int64_t alive_until_ns, struct ttf_err *err)
{
    return lamps->ops->alive(lamps, alive_until_ns, err);
}

int ttf_lamps_set(struct ttf_lamps *lamps, unsigned i, unsigned permille, struct ttf_err *err)
{
    if (i >= lamps->n)
        return ttf_err_set(err, -EINVAL, lamps->ops->name, "no lamp %u: there are %u", i, lamps->n);
    if (permille > TTF_LAMP_FULL)
        return ttf_err_set(err, -EINVAL, lamps->info[i].name,
                           "a level is 0 to 1000 permille, not %u", permille);
    return lamps->ops->set(lamps, i, ttf_lamp_round(&lamps->info[i], permille), err);
}

int ttf_lamps_state(struct ttf_lamps *lamps, unsigned i, struct ttf_lamp_state *ret)
{
    return i < lamps->n ? lamps->ops->state(lamps, i, ret) : -EINVAL;
}

int ttf_lamps_clear(struct ttf_lamps *lamps, unsigned i, struct ttf_err *err)
{
    if (i >= lamps->n)
        return ttf_err_set(err, -EINVAL, lamps->ops->name, "no lamp %u: there are %u", i, lamps->n);
    return lamps->ops->clear(lamps, i, err);
}

void ttf_lamps_release(struct ttf_lamps *lamps)
{
    lamps->ops->release(lamps);
}

void ttf_lamps_destroy(struct ttf_lamps *lamps)
{
    if (!lamps)
        return;
    lamps->ops->release(lamps);
    lamps->ops->destroy(lamps);
}
