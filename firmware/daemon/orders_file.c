/* SPDX-License-Identifier: Apache-2.0 */
#include "orders_file.h"

#include <errno.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ttf/dataset/json_parse.h"
#include "ttf/dataset/json_writer.h"

#define FILE_MAX      ((size_t)1 << 20)
#define RESERVE_BYTES ((int64_t)64 << 10) /* beyond what was decided last */

static const char *const STATES[] = {"none", "running", "stopped", "done"};

void orders_file_name(struct orders_file *ret, struct ttf_io *io, const char *folder,
                      const char *plan, const char *dataset)
{
    ret->io = io;
    (void)snprintf(ret->folder, sizeof ret->folder, "%s", folder);
    (void)snprintf(ret->path, sizeof ret->path, "%s/run.json", ret->folder);
    (void)snprintf(ret->configuration, sizeof ret->configuration, "%s into %s", plan, dataset);
}

static void copy(char *ret, size_t size, const json_t *object, const char *key)
{
    const char *text = json_string_value(json_object_get(object, key));

    (void)snprintf(ret, size, "%s", text ? text : "");
}

static int read_order(const struct orders_file *file, const json_t *object, struct order *ret)
{
    const char *state = json_string_value(json_object_get(object, "state"));
    const char *yaml = json_string_value(json_object_get(object, "plan_yaml"));
    const char *under = json_string_value(json_object_get(object, "configuration"));
    bool same = under && strcmp(under, file->configuration) == 0;
    struct order order = {.by_request = yaml != NULL};

    for (unsigned i = ORDER_RUN; i <= ORDER_DONE; i++)
        if (state && strcmp(state, STATES[i]) == 0)
            order.state = (enum order_state)i;
    copy(order.dataset, sizeof order.dataset, object, "dataset");
    copy(order.plan, sizeof order.plan, object, "plan");
    copy(order.why, sizeof order.why, object, "why");
    if (state && strcmp(state, STATES[ORDER_NONE]) == 0)
        return 0; /* nobody had decided anything */
    if (order.state == ORDER_NONE || (!*order.dataset && order.state != ORDER_STOPPED))
        return -EINVAL;
    /* What the configuration names now, and did not then, nobody has stopped. */
    if (!same && (!order.by_request || order.state != ORDER_RUN))
        return 0;
    if (yaml && !(order.yaml = strdup(yaml)))
        return -ENOMEM;
    *ret = order;
    return 1;
}

static void name_aside(const struct orders_file *file, char *ret, size_t size)
{
    (void)snprintf(ret, size, "%s.unreadable", file->path);
}

/* A file was put aside, and power went before what follows from that was written. */
static bool is_aside(const struct orders_file *file)
{
    char aside[sizeof file->path + 16];
    struct ttf_io_stat st;

    name_aside(file, aside, sizeof aside);
    return file->io->ops->stat(file->io, aside, &st) == 0;
}

int orders_file_read(const struct orders_file *file, struct order *ret, struct ttf_err *err)
{
    char *text = NULL;
    json_t *object;
    size_t bytes;
    int r = ttf_io_slurp(file->io, file->path, FILE_MAX, &text, &bytes, err);

    if (r == 0)
        r = ttf_json_parse(text, bytes, &object, NULL);
    free(text);
    if (r == 0) {
        r = read_order(file, object, ret);
        json_decref(object);
    }
    if (r == -ENOMEM)
        return ttf_err_set(err, r, file->path, "no memory");
    if (r == -EINVAL || r == -EFBIG || (r == -ENOENT && is_aside(file)))
        r = ttf_err_set(err, -EINVAL, file->path, "does not say what was to run");
    return r;
}

static void name_reserve(const struct orders_file *file, char *ret, size_t size)
{
    (void)snprintf(ret, size, "%s.reserve", file->path);
}

/* What stands there stays until the new one is whole, so a full disk has to have room for both: the reserve's. */
static int write_text(const struct orders_file *file, const char *text, size_t bytes,
                      struct ttf_err *err)
{
    char reserve[sizeof file->path + 16];
    int r = ttf_io_write_file(file->io, file->path, text, bytes, err);

    name_reserve(file, reserve, sizeof reserve);
    if ((r != -ENOSPC && r != -EDQUOT) || file->io->ops->unlink(file->io, reserve) < 0)
        return r;
    (void)file->io->ops->sync_dir(file->io, file->folder); /* some disks have the room then only */
    return ttf_io_write_file(file->io, file->path, text, bytes, err);
}

/* Nothing that a disk which compresses would make small. */
static void fill(unsigned char *to, size_t n)
{
    uint32_t x = 1;

    for (size_t i = 0; i < n; i++) {
        x = x * 1664525u + 1013904223u;
        to[i] = (unsigned char)(x >> 24);
    }
}

void orders_file_reserve(const struct orders_file *file)
{
    const struct ttf_io_ops *ops = file->io->ops;
    char reserve[sizeof file->path + 16];
    int64_t needs = RESERVE_BYTES;
    struct ttf_io_space space;
    struct ttf_io_stat st;
    unsigned char *bytes;

    name_reserve(file, reserve, sizeof reserve);
    if (ops->stat(file->io, file->path, &st) == 0)
        needs += st.bytes;
    if ((ops->stat(file->io, reserve, &st) == 0 && st.bytes >= needs) ||
        ops->stat(file->io, file->folder, &st) < 0 || /* not made yet, or its disk comes late */
        ops->space(file->io, file->folder, &space) < 0 || space.free_bytes < needs)
        return;
    bytes = malloc((size_t)needs);
    if (!bytes)
        return;
    fill(bytes, (size_t)needs);
    (void)!ttf_io_write_file(file->io, reserve, bytes, (size_t)needs, NULL);
    free(bytes);
}

int orders_file_write(const struct orders_file *file, const struct order *order,
                      struct ttf_err *err)
{
    /* The configuration's run is looked at anew at each boot: a longer plan goes on. */
    bool anew = order->state == ORDER_DONE && !order->by_request;
    struct ttf_json json;
    const char *text;
    size_t bytes;
    int r;

    ttf_json_init(&json, true);
    ttf_json_object(&json);
    ttf_json_kstring(&json, "state", STATES[anew ? ORDER_RUN : order->state]);
    ttf_json_kstring(&json, "dataset", order->dataset);
    ttf_json_kstring(&json, "configuration", file->configuration);
    if (*order->why)
        ttf_json_kstring(&json, "why", order->why);
    if (order->by_request) {
        ttf_json_kstring(&json, "plan", order->plan);
        ttf_json_kstring(&json, "plan_yaml", order->yaml);
    }
    ttf_json_object_end(&json);
    r = ttf_json_finish(&json, &text, &bytes);
    if (r < 0)
        ttf_err_set(err, r, file->path, "no memory");
    else
        r = ttf_io_mkdirs(file->io, file->folder, err);
    if (r == 0)
        r = write_text(file, text, bytes, err);
    ttf_json_free(&json);
    return r;
}

int orders_file_put_aside(const struct orders_file *file)
{
    char aside[sizeof file->path + 16];
    int r;

    name_aside(file, aside, sizeof aside);
    r = file->io->ops->rename(file->io, file->path, aside);
    if (r == -ENOENT && is_aside(file))
        r = 0; /* it is there already */
    return r < 0 ? r : file->io->ops->sync_dir(file->io, file->folder);
}
