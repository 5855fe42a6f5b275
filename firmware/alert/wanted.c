/* SPDX-License-Identifier: Apache-2.0 */
/* wanted.c: what ttfboxd is to do: its own file of what was decided, else the plan that the configuration names. */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "alert.h"
#include "orders_file.h"
#include "ttf/config/plan_file.h"

/* Not there: all zero. */
static struct ttf_io_stat look_at(struct ttf_io *io, const char *path)
{
    struct ttf_io_stat st;

    memset(&st, 0, sizeof st);
    if (!*path || io->ops->stat(io, path, &st) < 0)
        memset(&st, 0, sizeof st);
    return st;
}

static bool same(const struct ttf_io_stat *a, const struct ttf_io_stat *b)
{
    return a->is_regular == b->is_regular && a->inode == b->inode && a->device == b->device &&
           a->bytes == b->bytes && a->mtime_ns == b->mtime_ns;
}

/* A plan that is wrong names none: the daemon says what is the matter with it. */
static void find_second(const struct ttf_alerts_config *config, const struct order *order,
                        struct wanted *ret)
{
    struct ttf_plan_file *file = NULL;
    int r = order->by_request
                ? ttf_plan_file_parse("plan", order->yaml, strlen(order->yaml), &file, NULL)
                : ttf_plan_file_load(config->plan, &file, NULL);

    if (r == 0)
        (void)snprintf(ret->second, sizeof ret->second, "%s",
                       ttf_plan_file_plan(file)->second_storage);
    ttf_plan_file_free(r == 0 ? file : NULL);
}

static void take(const struct ttf_alerts_config *config, const struct order *order,
                 struct wanted *ret)
{
    static const enum wants WANTS[] = {[ORDER_NONE] = WANTS_NOTHING,
                                       [ORDER_RUN] = WANTS_RUN,
                                       [ORDER_STOPPED] = WANTS_REST,
                                       [ORDER_DONE] = WANTS_NOTHING};

    ret->wants = *order->why ? WANTS_PERSON : WANTS[order->state];
    memcpy(ret->dataset, order->dataset, sizeof ret->dataset);
    (void)snprintf(ret->why, sizeof ret->why, "%s", order->why);
    if (ret->wants == WANTS_RUN)
        find_second(config, order, ret);
}

/* Nobody has decided anything: the plan of the configuration runs as soon as there is one. */
static void take_configured(const struct ttf_alerts_config *config, bool has_plan,
                            struct wanted *ret)
{
    struct order order = {.state = has_plan ? ORDER_RUN : ORDER_NONE};

    memcpy(order.dataset, config->dataset, sizeof order.dataset);
    take(config, &order, ret);
}

static void name_file(const struct ttf_alerts_config *config, struct ttf_io *io,
                      struct orders_file *ret)
{
    char dataset[600] = "";

    if (*config->plan)
        (void)snprintf(dataset, sizeof dataset, "%s/%s", config->data, config->dataset);
    orders_file_name(ret, io, config->state, config->plan, dataset);
}

void wanted_look(struct wanted *wanted, const struct ttf_alerts_config *config, struct ttf_io *io)
{
    struct orders_file file;
    struct order order = {0};
    struct wanted now = {.known = true};
    int r;

    name_file(config, io, &file);
    now.seen[0] = look_at(io, file.path);
    now.seen[1] = look_at(io, config->plan);
    if (wanted->known && same(&now.seen[0], &wanted->seen[0]) &&
        same(&now.seen[1], &wanted->seen[1]))
        return;
    r = orders_file_read(&file, &order, NULL);
    if (r < 0 && r != -ENOENT && r != -EINVAL)
        return;
    /* Nobody takes it away: its disk has gone, and what runs on it as well. */
    if (r == -ENOENT && wanted->known && wanted->seen[0].is_regular)
        return;
    if (r > 0) {
        take(config, &order, &now);
    } else if (r == -EINVAL) {
        now.wants = WANTS_PERSON;
        memcpy(now.dataset, config->dataset, sizeof now.dataset);
        (void)snprintf(now.why, sizeof now.why,
                       "what was to run cannot be understood (%.300s): start it, or another one",
                       file.path);
    } else {
        take_configured(config, now.seen[1].is_regular, &now);
    }
    free(order.yaml);
    *wanted = now;
}
