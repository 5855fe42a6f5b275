/* SPDX-License-Identifier: Apache-2.0 */
#include "library.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "check.h"
#include "ttf/config/plan_file.h"
#include "ttf/dataset/reader.h"

#define PLANS_MAX  256
#define BOARDS_MAX 128
#define TEXT_MAX   ((size_t)256 * 1024)
#define SUFFIX     ".yaml"

struct names {
    char (*name)[65];
    unsigned n, max;
    bool folders; /* else files that end in SUFFIX, without it */
};

static int by_name(const void *a, const void *b)
{
    return strcmp(a, b);
}

static bool is_name(const char *name)
{
    return *name != '.' && *name &&
           strspn(name, "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789._-") ==
               strlen(name);
}

static int take(void *ctx, const char *name, bool is_dir)
{
    struct names *names = ctx;
    size_t n = strlen(name), end = sizeof SUFFIX - 1;
    char text[65];

    if (is_dir != names->folders || names->n == names->max)
        return 0;
    if (!names->folders) {
        if (n <= end || strcmp(name + n - end, SUFFIX) != 0 || strcmp(name, "board.yaml") == 0)
            return 0;
        n -= end;
    }
    if (n >= sizeof text)
        return 0;
    memcpy(text, name, n);
    text[n] = '\0';
    if (is_name(text))
        memcpy(names->name[names->n++], text, sizeof text);
    return 0;
}

/* Names in a folder, in order; of one that is not there: none. */
static int list(struct ttf_io *io, const char *folder, unsigned max, bool folders,
                struct names *ret)
{
    int r;

    *ret = (struct names){.name = calloc(max, sizeof *ret->name), .max = max, .folders = folders};
    if (!ret->name)
        return -ENOMEM;
    r = io->ops->list(io, folder, take, ret);
    if (r == -ENOENT)
        r = 0;
    qsort(ret->name, ret->n, sizeof *ret->name, by_name);
    return r;
}

static int finish(struct ttf_json *json, int r, char **ret, struct ttf_err *err)
{
    if (r == 0)
        return daemon_give(json, ret, err);
    ttf_json_free(json);
    return ttf_err_set(err, r, NULL, "%s", strerrordesc_np(-r));
}

/* ---- plans ---- */

/* The configuration's own plan, by its file's name. */
static const char *configured_name(const struct daemon *d, char ret[65])
{
    const char *slash = strrchr(d->config.plan, '/');
    const char *name = slash ? slash + 1 : d->config.plan;
    size_t n = strlen(name), end = sizeof SUFFIX - 1;

    if (n > end && strcmp(name + n - end, SUFFIX) == 0)
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
        (void)snprintf(ret, 640, "%s/plans/%s" SUFFIX, d->config.state, name);
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
    struct names names;
    struct ttf_json json;
    int r;

    (void)snprintf(folder, sizeof folder, "%s/plans", d->config.state);
    r = list(d->io, folder, PLANS_MAX, false, &names);
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
    return finish(&json, r, ret_json, err);
}

static int read_text(struct daemon *d, const char *path, const char *what, char **ret,
                     struct ttf_err *err)
{
    size_t bytes;
    int r = ttf_io_slurp(d->io, path, TEXT_MAX, ret, &bytes, err);

    return r == -ENOENT ? ttf_err_set(err, r, NULL, "there is no %s of this name", what) : r;
}

int library_plan(struct daemon *d, const char *name, char **ret_yaml, struct ttf_err *err)
{
    char path[640];

    return read_text(d, path_of(d, name, path), "plan", ret_yaml, err);
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
        if (read_text(d, path, "plan", &text, NULL) == 0)
            same = strcmp(text, yaml) == 0;
        free(text);
    }
    return same;
}

int library_may_start(struct daemon *d, const char *dataset, const char *yaml, struct ttf_err *err)
{
    struct ttf_reader *reader = NULL;
    struct ttf_io_stat st;
    char folder[600], path[640], digest[65];
    int r;

    (void)snprintf(folder, sizeof folder, "%s/%s", d->config.data, dataset);
    (void)snprintf(path, sizeof path, "%s/dataset.json", folder);
    if (d->io->ops->stat(d->io, path, &st) < 0)
        return check_clock(d, "plan", yaml, err);
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
    ttf_err_set(err, -EPERM, NULL, "this is the plan of the box's configuration");
    ttf_err_hint(err, "take another name");
    return -EPERM;
}

int library_put(struct daemon *d, const char *name, const char *yaml, size_t bytes,
                struct ttf_err *err)
{
    char path[640], folder[600];
    int r;

    if (is_configured(d, name))
        return own_plan(err);
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
    r = d->io->ops->unlink(d->io, path_of(d, name, path));
    if (r == 0)
        r = d->io->ops->sync_dir(d->io, folder);
    (void)pthread_mutex_unlock(&d->plans);
    return r < 0 ? ttf_err_set(err, r, NULL, "%s",
                               r == -ENOENT ? "there is no plan of this name" : strerrordesc_np(-r))
                 : 0;
}

/* ---- boards ---- */

/* The folder of a board of this name; false: there is none. */
static bool find_board(struct daemon *d, const char *name, char ret[600])
{
    char path[640];
    struct ttf_io_stat st;

    if (strcmp(name, d->board.name) == 0) {
        const char *slash = strrchr(d->board.path, '/');

        (void)snprintf(ret, 600, "%.*s", slash ? (int)(slash - d->board.path) : 1,
                       slash ? d->board.path : ".");
        return true;
    }
    for (const char *const *folder = ttf_daemon_board_folders(); *folder; folder++) {
        (void)snprintf(path, sizeof path, "%s/%s/board.yaml", *folder, name);
        if (d->io->ops->stat(d->io, path, &st) < 0 || !st.is_regular)
            continue;
        (void)snprintf(ret, 600, "%s/%s", *folder, name);
        return true;
    }
    return false;
}

int library_board(struct daemon *d, const char *name, const char *plan, char **ret_yaml,
                  struct ttf_err *err)
{
    char folder[600], path[700];

    if (!find_board(d, name, folder))
        return ttf_err_set(err, -ENOENT, NULL, "there is no board of this name");
    if (!plan && strcmp(name, d->board.name) == 0)
        return read_text(d, d->board.path, "board", ret_yaml, err);
    (void)snprintf(path, sizeof path, "%s/%s%s" SUFFIX, folder, plan ? "plans/" : "",
                   plan ? plan : "board");
    return read_text(d, path, plan ? "plan" : "board", ret_yaml, err);
}

/* Does this file read as a plan? */
static bool is_plan(const char *folder, const char *name)
{
    struct ttf_plan_file *file = NULL;
    char path[700];
    bool is;

    (void)snprintf(path, sizeof path, "%s/%s" SUFFIX, folder, name);
    is = ttf_plan_file_load(path, &file, NULL) == 0;
    ttf_plan_file_free(file);
    return is;
}

static void put_board(struct daemon *d, const char *name, struct ttf_json *json)
{
    char folder[600], plans[620];
    struct names names = {0};

    if (!find_board(d, name, folder))
        return;
    (void)snprintf(plans, sizeof plans, "%s/plans", folder);
    ttf_json_object(json);
    ttf_json_kstring(json, "name", name);
    ttf_json_key(json, "plans");
    ttf_json_array(json);
    if (list(d->io, plans, PLANS_MAX, false, &names) == 0)
        for (unsigned i = 0; i < names.n; i++)
            if (is_plan(plans, names.name[i]))
                ttf_json_string(json, names.name[i]);
    ttf_json_array_end(json);
    ttf_json_object_end(json);
    free(names.name);
}

int library_boards(struct daemon *d, char **ret_json, struct ttf_err *err)
{
    struct ttf_json json;
    int r = 0;

    ttf_json_init(&json, false);
    ttf_json_object(&json);
    ttf_json_kstring(&json, "own", d->board.name);
    ttf_json_key(&json, "boards");
    ttf_json_array(&json);
    put_board(d, d->board.name, &json);
    for (const char *const *folder = ttf_daemon_board_folders(); *folder && r == 0; folder++) {
        struct names names;

        r = list(d->io, *folder, BOARDS_MAX, true, &names);
        for (unsigned i = 0; r == 0 && i < names.n; i++)
            if (strcmp(names.name[i], d->board.name) != 0)
                put_board(d, names.name[i], &json);
        free(names.name);
    }
    ttf_json_array_end(&json);
    ttf_json_object_end(&json);
    return finish(&json, r, ret_json, err);
}
