/* SPDX-License-Identifier: Apache-2.0 */
#include "calibrations.h"

#include <errno.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "calibration_folder.h"
#include "ttf/dataset/json_parse.h"
#include "ttf/dataset/json_writer.h"

#define MOST     64                        /* that are listed */
#define TEXT_MAX ((size_t)8 * 1024 * 1024) /* of one's JSON: hot pixels are many */
#define USED     "calibration-in-use"

enum step {
    STEP_NONE = 0,
    STEP_WAITING,
    STEP_UNDER_WAY,
    STEP_DONE,
    STEP_REFUSED
};

struct calibrations {
    struct ttf_io *io;
    struct ttf_clock *clock;
    const char *state, *configured;
    pthread_mutex_t lock; /* over all below, and which one is chosen */
    bool open;            /* nothing runs, nor is anything to run: steps are done */
    enum step step;
    struct ttf_http_calibrate what;
    int64_t begun_ns, ended_ns, at_most_ns;
    struct ttf_err err;
    char held[65]; /* by the run under way, which may bring it to its second storage; "": none */
};

struct calibrations *calibrations_create(struct ttf_io *io, struct ttf_clock *clock,
                                         const char *state, const char *configured)
{
    struct calibrations *c = calloc(1, sizeof *c);
    char above[CALIBRATION_PATH];

    if (!c)
        return NULL;
    c->io = io;
    c->clock = clock;
    c->state = state;
    c->configured = configured;
    (void)pthread_mutex_init(&c->lock, NULL);
    calibrations_path(c, "", above);
    (void)!calibration_folder_sweep(io, above,
                                    NULL); /* what a cut left: also at the next removal */
    return c;
}

void calibrations_destroy(struct calibrations *c)
{
    if (!c)
        return;
    (void)pthread_mutex_destroy(&c->lock);
    free(c);
}

void calibrations_path(const struct calibrations *c, const char *name, char ret[CALIBRATION_PATH])
{
    (void)snprintf(ret, CALIBRATION_PATH, "%s/calibrations/%s", c->state, name);
}

/* ---- what lies on the disk ---- */

static int read_json(struct calibrations *c, const char *folder, json_t **ret)
{
    char path[CALIBRATION_PATH + 32], *text = NULL;
    size_t bytes;
    int r;

    (void)snprintf(path, sizeof path, "%s/calibration.json", folder);
    r = ttf_io_slurp(c->io, path, TEXT_MAX, &text, &bytes, NULL);
    if (r == 0)
        r = ttf_json_parse(text, bytes, ret, NULL);
    free(text);
    return r;
}

/* 0: it is; -ENOENT; other errors of the disk. */
static int is_there(struct calibrations *c, const char *folder)
{
    char path[CALIBRATION_PATH + 32];
    struct ttf_io_stat st;

    (void)snprintf(path, sizeof path, "%s/calibration.json", folder);
    return c->io->ops->stat(c->io, path, &st);
}

/* The name of the one that a person chose: 1; 0: none. */
static int chosen(struct calibrations *c, char ret[65], struct ttf_err *err)
{
    char path[CALIBRATION_PATH], *text = NULL;
    size_t bytes;
    int r;

    (void)snprintf(path, sizeof path, "%s/" USED, c->state);
    r = ttf_io_slurp(c->io, path, 128, &text, &bytes, err);
    if (r == 0) {
        (void)snprintf(ret, 65, "%.*s", (int)strcspn(text, "\n/"), text);
        r = *ret && *ret != '.' ? 1 : ttf_err_set(err, -EINVAL, path, "names no calibration");
    }
    free(text);
    return r == -ENOENT ? 0 : r;
}

static int use(struct calibrations *c, const char *name, struct ttf_err *err)
{
    char path[CALIBRATION_PATH], folder[CALIBRATION_PATH], text[80];
    int r;

    (void)snprintf(path, sizeof path, "%s/" USED, c->state);
    if (!*name) {
        r = c->io->ops->unlink(c->io, path);
        if (r == 0)
            r = c->io->ops->sync_dir(c->io, c->state);
        return r == 0 || r == -ENOENT ? 0 : ttf_err_set(err, r, NULL, "%s", strerrordesc_np(-r));
    }
    calibrations_path(c, name, folder);
    r = is_there(c, folder);
    if (r < 0)
        return ttf_err_set(err, r, "name", "%s",
                           r == -ENOENT ? "there is no calibration of this name"
                                        : strerrordesc_np(-r));
    (void)snprintf(text, sizeof text, "%s\n", name);
    return ttf_io_write_file(c->io, path, text, strlen(text), err);
}

int calibrations_use(struct calibrations *c, const char *name, struct ttf_err *err)
{
    int r;

    (void)pthread_mutex_lock(&c->lock);
    r = use(c, name, err);
    (void)pthread_mutex_unlock(&c->lock);
    return r;
}

int calibrations_in_use(struct calibrations *c, char ret[CALIBRATION_PATH], struct ttf_err *err)
{
    char name[65];
    int r;

    (void)pthread_mutex_lock(&c->lock);
    r = chosen(c, name, err);
    if (r == 1)
        memcpy(c->held, name, sizeof c->held);
    (void)pthread_mutex_unlock(&c->lock);

    if (r == 0) {
        (void)snprintf(ret, CALIBRATION_PATH, "%s", c->configured);
        return *ret != '\0';
    }
    if (r < 0)
        return r;
    calibrations_path(c, name, ret);
    r = is_there(c, ret);
    if (r == 0)
        return 1;
    ttf_err_set(err, r, name, "the calibration that was chosen cannot be read: %s",
                strerrordesc_np(-r));
    ttf_err_hint(err, "choose another one, or none");
    return r;
}

void calibrations_let_go(struct calibrations *c)
{
    (void)pthread_mutex_lock(&c->lock);
    c->held[0] = '\0';
    (void)pthread_mutex_unlock(&c->lock);
}

/* ---- taken away ---- */

/* Is this path the same folder as that of the calibration? Also by another name for it. */
static bool is_configured(struct calibrations *c, const char *folder)
{
    struct ttf_io_stat own, st;

    return *c->configured && c->io->ops->stat(c->io, c->configured, &own) == 0 &&
           c->io->ops->stat(c->io, folder, &st) == 0 && own.inode == st.inode &&
           own.device == st.device;
}

/* The lock is held. 0: nothing needs it. */
static int refuse_needed(struct calibrations *c, const char *name, struct ttf_err *err)
{
    bool busy = c->step == STEP_WAITING || c->step == STEP_UNDER_WAY;
    char folder[CALIBRATION_PATH], used[65];
    int r = chosen(c, used, err);

    if (r < 0 && r != -EINVAL) /* nobody knows */
        return r;
    calibrations_path(c, name, folder);
    if (busy && strcmp(c->what.name, name) == 0)
        return ttf_err_set(err, -EBUSY, name, "is being made: a step of it is under way");
    if (strcmp(c->held, name) == 0)
        return ttf_err_set(err, -EBUSY, name, "a run under way is developed with it");
    if (r == 1 && strcmp(used, name) == 0) {
        ttf_err_set(err, -EBUSY, name, "is in use: the next run is developed with it");
        ttf_err_hint(err, "use another one, or none, first");
        return -EBUSY;
    }
    return is_configured(c, folder)
               ? ttf_err_set(err, -EBUSY, name, "is the one that the box's configuration names")
               : 0;
}

int calibrations_remove(struct calibrations *c, const char *name, struct ttf_err *err)
{
    char above[CALIBRATION_PATH];
    int r;

    calibrations_path(c, "", above);
    (void)pthread_mutex_lock(&c->lock);
    r = refuse_needed(c, name, err);
    if (r == 0)
        r = calibration_folder_put_aside(c->io, above, name, err);
    if (r == 0 && c->step != STEP_NONE && strcmp(c->what.name, name) == 0)
        c->step = STEP_NONE; /* what became of it is of no more use */
    (void)pthread_mutex_unlock(&c->lock);
    return r < 0 ? r : calibration_folder_sweep(c->io, above, err);
}

/* ---- a step ---- */

int calibrations_refuse_twice(const char *name, enum ttf_calibration_part part, struct ttf_err *err)
{
    int r = ttf_err_set(err, -EEXIST, name, "holds a %s already", ttf_calibration_part_name(part));

    ttf_err_hint(err, "nothing is overwritten: begin a calibration of another name");
    return r;
}

/* Which parts calibration.json has (NULL: none), and nothing else of it. */
static void read_parts(const json_t *json, struct ttf_calibration *ret)
{
    ttf_calibration_init(ret);
    ret->has_dark = json_object_get(json, "dark");
    ret->has_flat = json_object_get(json, "flat");
}

/* A part that is there already, or one that another must be made before. */
static int refuse_part(struct calibrations *c, const struct ttf_http_calibrate *what,
                       struct ttf_err *err)
{
    char folder[CALIBRATION_PATH];
    struct ttf_calibration parts;
    json_t *json = NULL;
    int r = 0;

    calibrations_path(c, what->name, folder);
    if (read_json(c, folder, &json) == 0 &&
        json_object_get(json, ttf_calibration_part_name(what->part))) {
        r = calibrations_refuse_twice(what->name, what->part, err);
    } else {
        read_parts(json, &parts);
        r = ttf_calibration_may_take(&parts, what->part, err);
    }
    json_decref(json);
    return r;
}

int calibrations_ask(struct calibrations *c, const struct ttf_http_calibrate *what,
                     struct ttf_err *err)
{
    int r = refuse_part(c, what, err);

    if (r < 0)
        return r;
    (void)pthread_mutex_lock(&c->lock);
    if (!c->open) {
        r = ttf_err_set(err, -EBUSY, NULL, "a run has the devices, or is to have them");
        ttf_err_hint(err, "calibrate before a run, or when it is stopped");
    } else if (c->step == STEP_WAITING || c->step == STEP_UNDER_WAY) {
        r = ttf_err_set(err, -EBUSY, NULL, "a step of a calibration is under way");
    } else {
        c->step = STEP_WAITING;
        c->what = *what;
        c->begun_ns = ttf_clock_now_ns(c->clock);
        c->at_most_ns = 0;
    }
    (void)pthread_mutex_unlock(&c->lock);
    return r;
}

bool calibrations_begin(struct calibrations *c, struct ttf_http_calibrate *ret)
{
    bool waits;

    (void)pthread_mutex_lock(&c->lock);
    waits = c->step == STEP_WAITING;
    if (waits) {
        c->step = STEP_UNDER_WAY;
        c->begun_ns = ttf_clock_now_ns(c->clock);
        *ret = c->what;
    }
    (void)pthread_mutex_unlock(&c->lock);
    return waits;
}

void calibrations_at_most(struct calibrations *c, int64_t ns)
{
    (void)pthread_mutex_lock(&c->lock);
    c->at_most_ns = ns;
    (void)pthread_mutex_unlock(&c->lock);
}

static void end(struct calibrations *c, int r, const struct ttf_err *err)
{
    c->step = r < 0 ? STEP_REFUSED : STEP_DONE;
    c->ended_ns = ttf_clock_now_ns(c->clock);
    memset(&c->err, 0, sizeof c->err);
    if (r < 0 && err)
        c->err = *err;
}

void calibrations_end(struct calibrations *c, int r, const struct ttf_err *err)
{
    (void)pthread_mutex_lock(&c->lock);
    end(c, r, err);
    (void)pthread_mutex_unlock(&c->lock);
}

void calibrations_open(struct calibrations *c)
{
    (void)pthread_mutex_lock(&c->lock);
    c->open = true;
    (void)pthread_mutex_unlock(&c->lock);
}

void calibrations_give_up(struct calibrations *c)
{
    struct ttf_err err = {0};

    ttf_err_set(&err, -EBUSY, NULL, "a run took the devices before it was begun");
    (void)pthread_mutex_lock(&c->lock);
    c->open = false;
    if (c->step == STEP_WAITING)
        end(c, -EBUSY, &err);
    (void)pthread_mutex_unlock(&c->lock);
}

/* ---- in words ---- */

static void put_step(struct calibrations *c, struct ttf_json *j)
{
    static const char *const NAMES[] = {"none", "waiting", "under-way", "done", "refused"};

    (void)pthread_mutex_lock(&c->lock);
    if (c->step != STEP_NONE) {
        bool over = c->step == STEP_DONE || c->step == STEP_REFUSED;

        ttf_json_key(j, "step");
        ttf_json_object(j);
        ttf_json_kstring(j, "calibration", c->what.name);
        ttf_json_kstring(j, "part", ttf_calibration_part_name(c->what.part));
        ttf_json_kstring(j, "state", NAMES[c->step]);
        ttf_json_kint(j, "for_ns", (over ? c->ended_ns : ttf_clock_now_ns(c->clock)) - c->begun_ns);
        if (c->at_most_ns > 0)
            ttf_json_kint(j, "at_most_ns", c->at_most_ns);
        if (c->step == STEP_REFUSED) {
            ttf_json_kstring(j, "error", c->err.what);
            if (*c->err.where)
                ttf_json_kstring(j, "where", c->err.where);
            if (*c->err.hint)
                ttf_json_kstring(j, "hint", c->err.hint);
        }
        ttf_json_object_end(j);
    }
    (void)pthread_mutex_unlock(&c->lock);
}

/* What calibration.json says, but for the files' names and each hot pixel's place. */
static void put_one(struct calibrations *c, const char *name, struct ttf_json *j)
{
    static const char *const KEYS[] = {"id",   "camera", "simulated", "width",    "height",
                                       "dark", "flat",   "chart",     "geometry", "flicker"};
    char folder[CALIBRATION_PATH];
    json_t *json = NULL;

    calibrations_path(c, name, folder);
    if (read_json(c, folder, &json) < 0)
        return;
    ttf_json_object(j);
    ttf_json_kstring(j, "name", name);
    ttf_json_kint(j, "hot_pixels", (int64_t)json_array_size(json_object_get(json, "hot")) / 2);
    for (unsigned i = 0; i < TTF_COUNT_OF(KEYS); i++) {
        json_t *value = json_object_get(json, KEYS[i]);
        char *text = value ? json_dumps(value, JSON_COMPACT | JSON_ENCODE_ANY) : NULL;

        if (text) {
            ttf_json_key(j, KEYS[i]);
            ttf_json_raw(j, text);
        }
        free(text);
    }
    ttf_json_object_end(j);
    json_decref(json);
}

struct names {
    char name[MOST][65];
    unsigned n;
};

static int take_name(void *ctx, const char *name, bool is_dir)
{
    struct names *names = ctx;

    if (is_dir && *name != '.' && strlen(name) < sizeof names->name[0] && names->n < MOST)
        memcpy(names->name[names->n++], name, strlen(name) + 1);
    return 0;
}

static int by_name(const void *a, const void *b)
{
    return strcmp(a, b);
}

int calibrations_show(struct calibrations *c, char **ret_json, struct ttf_err *err)
{
    struct names *names = calloc(1, sizeof *names);
    char folder[CALIBRATION_PATH], name[65];
    struct ttf_json j;
    int r;

    if (!names)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory");
    calibrations_path(c, "", folder);
    r = c->io->ops->list(c->io, folder, take_name, names);
    qsort(names->name, names->n, sizeof names->name[0], by_name);
    ttf_json_init(&j, false);
    ttf_json_object(&j);
    if (*c->configured)
        ttf_json_kstring(&j, "configured", c->configured);
    if (chosen(c, name, NULL) == 1)
        ttf_json_kstring(&j, "used", name);
    put_step(c, &j);
    ttf_json_key(&j, "calibrations");
    ttf_json_array(&j);
    for (unsigned i = 0; i < names->n; i++)
        put_one(c, names->name[i], &j);
    ttf_json_array_end(&j);
    ttf_json_object_end(&j);
    free(names);
    if (r < 0 && r != -ENOENT) {
        ttf_json_free(&j);
        return ttf_err_set(err, r, NULL, "%s", strerrordesc_np(-r));
    }
    r = ttf_json_take(&j, ret_json, NULL);
    return r < 0 ? ttf_err_set(err, r, NULL, "no memory") : 0;
}
