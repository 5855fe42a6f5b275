/* SPDX-License-Identifier: Apache-2.0 */
#include "library.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "check.h"
#include "listing.h"
#include "ttf/config/plan_file.h"
#include "ttf/dataset/reader.h"

/* ---- plans ---- */

/* The configuration's own plan, by its file's name. */
static const char *configured_name(const struct daemon *d, char ret[65])
{
    const char *slash = strrchr(d->config.plan, '/');
    const char *name = slash ? slash + 1 : d->config.plan;
    size_t n = strlen(name), end = sizeof LISTING_SUFFIX - 1;

    if (n > end && strcmp(name + n - end, LISTING_SUFFIX) == 0)
        n -= end;
    (void)snprintf(ret, 65, "%.*s", (int)(n < 64 ? n : 64), name);
    return ret;
}

static bool is_configured(const struct daemon *d, const char *name)
{
    char own[65];

    return *d->config.plan && strcmp(configured_name(d, own), name) == 0;
}

static const char *path_of(const struct daemon *d, const char *name, char ret[640])
{
    if (is_configured(d, name))
        (void)snprintf(ret, 640, "%s", d->config.plan);
    else
        (void)snprintf(ret, 640, "%s/plans/%s" LISTING_SUFFIX, d->config.state, name);
    return ret;
}

static void put_plan(struct daemon *d, const char *name, struct ttf_json *json)
{
    struct ttf_plan_file *file = NULL;
    struct ttf_err err = {0};
    char path[640];

    ttf_json_object(json);
    ttf_json_kstring(json, "name", name);
    ttf_json_kbool(json, "configured", is_configured(d, name));
    if (ttf_plan_file_load(path_of(d, name, path), &file, &err) < 0) {
        ttf_json_kstring(json, "error", err.what);
    } else {
        const struct ttf_plan *plan = ttf_plan_file_plan(file);

        ttf_json_kstring(json, "title", plan->title);
        ttf_json_kint(json, "slots", plan->count);
        ttf_json_kint(json, "interval_ns", plan->interval_ns);
        ttf_plan_file_free(file);
    }
    ttf_json_object_end(json);
}

int library_plans(struct daemon *d, char **ret_json, struct ttf_err *err)
{
    char folder[600], own[65];
    struct listing names;
    struct ttf_json json;
    int r;

    (void)snprintf(folder, sizeof folder, "%s/plans", d->config.state);
    r = listing_read(d->io, folder, LISTING_PLANS_MAX, false, &names);
    ttf_json_init(&json, false);
    ttf_json_object(&json);
    ttf_json_key(&json, "plans");
    ttf_json_array(&json);
    if (*d->config.plan)
        put_plan(d, configured_name(d, own), &json);
    for (unsigned i = 0; r == 0 && i < names.n; i++)
        if (!is_configured(d, names.name[i]))
            put_plan(d, names.name[i], &json);
    ttf_json_array_end(&json);
    ttf_json_object_end(&json);
    free(names.name);
    return listing_give(&json, r, ret_json, err);
}

int library_plan(struct daemon *d, const char *name, char **ret_yaml, struct ttf_err *err)
{
    char path[640];

    return listing_text(d->io, path_of(d, name, path), "plan", ret_yaml, err);
}

/* Is this text one of the plans that were given to the dataset? */
static bool is_of_plan(struct daemon *d, const char *folder, const char *yaml)
{
    bool same = false;

    for (unsigned n = 0; !same; n++) {
        struct ttf_io_stat st;
        char path[700], *text = NULL;

        (void)snprintf(path, sizeof path, "%s/plans/%u.json", folder, n);
        if (d->io->ops->stat(d->io, path, &st) < 0)
            break;
        (void)snprintf(path, sizeof path, "%s/plans/%u.yaml", folder, n);
        if (listing_text(d->io, path, "plan", &text, NULL) == 0)
            same = strcmp(text, yaml) == 0;
        free(text);
    }
    return same;
}

/* One of a group goes on from a dataset that is there; the run itself looks what that is. */
static int check_group(struct daemon *d, const char *yaml, struct ttf_err *err)
{
    struct ttf_plan_file *file = NULL;
    const struct ttf_plan *plan;
    struct ttf_io_stat st;
    char path[700];
    int r = ttf_plan_file_parse("plan", yaml, strlen(yaml), &file, err);

    if (r < 0)
        return r;
    plan = ttf_plan_file_plan(file);
    (void)snprintf(path, sizeof path, "%s/%s/dataset.json", d->config.data, plan->group);
    if (*plan->group && !*plan->second_storage && d->io->ops->stat(d->io, path, &st) < 0) {
        r = ttf_err_set(err, -EINVAL, "group", "there is no dataset '%s' on this box", plan->group);
        ttf_err_hint(err, "group names the dataset that the run goes on from");
    }
    ttf_plan_file_free(file);
    return r;
}

int library_may_start(struct daemon *d, const char *dataset, const char *yaml, struct ttf_err *err)
{
    struct ttf_reader *reader = NULL;
    struct ttf_io_stat st;
    char folder[600], path[640], digest[65];
    int r;

    (void)snprintf(folder, sizeof folder, "%s/%s", d->config.data, dataset);
    (void)snprintf(path, sizeof path, "%s/dataset.json", folder);
    if (d->io->ops->stat(d->io, path, &st) < 0) {
        r = check_clock(d, "plan", yaml, err);
        return r < 0 ? r : check_group(d, yaml, err);
    }
    r = ttf_reader_open(d->io, folder, &reader, err);
    if (r < 0)
        return r;
    if (ttf_reader_digest(reader, digest, NULL) == 0)
        r = ttf_err_set(err, -EEXIST, "dataset", "'%s' is there, done and sealed", dataset);
    else if (!is_of_plan(d, folder, yaml))
        r = ttf_err_set(err, -EEXIST, "dataset", "'%s' is there, and of another plan", dataset);
    if (r < 0)
        ttf_err_hint(err, "give the run a dataset's name that is not taken");
    ttf_reader_close(reader);
    return r;
}

static int own_plan(struct ttf_err *err)
{
    return ttf_err_set(err, -EPERM, NULL, "this is the plan of the box's configuration");
}

int library_put(struct daemon *d, const char *name, const char *yaml, size_t bytes,
                struct ttf_err *err)
{
    char path[640], folder[600];
    int r;

    if (is_configured(d, name)) {
        r = own_plan(err);
        ttf_err_hint(err, "take another name");
        return r;
    }
    (void)snprintf(folder, sizeof folder, "%s/plans", d->config.state);
    (void)pthread_mutex_lock(&d->plans);
    r = ttf_io_mkdirs(d->io, folder, err);
    if (r == 0)
        r = ttf_io_write_file(d->io, path_of(d, name, path), yaml, bytes, err);
    (void)pthread_mutex_unlock(&d->plans);
    return r;
}

int library_delete(struct daemon *d, const char *name, struct ttf_err *err)
{
    char path[640], folder[600];
    int r;

    if (is_configured(d, name))
        return own_plan(err);
    (void)snprintf(folder, sizeof folder, "%s/plans", d->config.state);
    (void)pthread_mutex_lock(&d->plans);
    r = listing_remove(d->io, folder, path_of(d, name, path), "plan", err);
    (void)pthread_mutex_unlock(&d->plans);
    return r;
}
