/* SPDX-License-Identifier: Apache-2.0 */
#include "check.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ttf/capture/disk_budget.h"
#include "ttf/config/plan_file.h"

struct checked {
    struct daemon *d;
    struct ttf_plan_file *file;
    struct ttf_plan_figures figures;
    struct ttf_disk_figures disk;
    bool has_figures;
};

/* The devices' answer is waited for where nobody has asked them yet. */
static int know_devices(struct daemon *d, shadow_fn *fn, void *ctx, struct ttf_err *err)
{
    struct workshop_job job = {0};
    int r = shadow_with(d->shadow, fn, ctx, err);

    if (r != -EAGAIN)
        return r;
    r = workshop_ask(d->workshop, &job, err);
    if (r == -EBUSY) /* a run is making them */
        r = ttf_err_set(err, -EAGAIN, NULL, "the box's devices are being prepared: ask again");
    return r < 0 ? r : shadow_with(d->shadow, fn, ctx, err);
}

static int against_box(void *ctx, const struct ttf_box *box, struct ttf_err *err)
{
    struct checked *c = ctx;

    return ttf_plan_check(ttf_plan_file_plan(c->file), box, &c->figures, err);
}

static int against_disk(struct checked *c, struct ttf_err *err)
{
    const struct ttf_plan *plan = ttf_plan_file_plan(c->file);
    char path[600];
    int r;

    (void)snprintf(path, sizeof path, "%s/x", c->d->config.data);
    /* Its speed is measured when a run begins: not beside one. */
    r = ttf_disk_budget_check(c->d->io, path, NULL, plan, &c->figures, &c->disk, err);
    if (r == -ENOSPC) {
        (void)snprintf(err->where, sizeof err->where, "count");
        r = -EINVAL;
    }
    /* A look alone: whoever checks a plan writes nothing anywhere, and nothing beside a run. */
    if (r == 0 && ttf_second_storage_look(c->d->io, path, plan, NULL, err) < 0)
        r = -EINVAL;
    return r;
}

static int check(struct checked *c, const char *name, const char *yaml, size_t bytes,
                 struct ttf_err *err)
{
    struct ttf_utc utc;
    int r = ttf_plan_file_parse(name, yaml, bytes, &c->file, err);

    if (r < 0) {
        c->file = NULL;
        return r;
    }
    ttf_plan_file_default_zone(c->file, c->d->config.zone);
    ttf_clock_utc(c->d->clock, &utc);
    r = ttf_plan_file_resolve(c->file, utc.utc_ns, err);
    if (r == 0)
        r = ttf_plan_file_check_start(c->file, &utc, err);
    if (r == 0)
        r = know_devices(c->d, against_box, c, err);
    c->has_figures = r == 0;
    if (r == 0)
        r = against_disk(c, err);
    if (r < 0)
        ttf_plan_file_place(c->file, err);
    return r;
}

/* ---- in words ---- */

void check_put_finding(struct ttf_json *j, const char *level, const struct ttf_err *err)
{
    ttf_json_object(j);
    ttf_json_kstring(j, "level", level);
    ttf_json_kstring(j, "text", err->what);
    if (*err->where)
        ttf_json_kstring(j, "where", err->where);
    if (*err->hint)
        ttf_json_kstring(j, "hint", err->hint);
    ttf_json_object_end(j);
}

static void put_warnings(struct ttf_json *j, const struct checked *c)
{
    const struct ttf_plan *plan = ttf_plan_file_plan(c->file);
    struct ttf_err err;

    for (unsigned i = 0; i < plan->n_shots; i++) {
        if (c->figures.flicker_ppm[i] < TTF_FLICKER_SHOWS_PPM)
            continue;
        memset(&err, 0, sizeof err);
        ttf_err_set(&err, -ERANGE, plan->shots[i].stream,
                    "a dimmed lamp's pulses show as bands of %.1f %%",
                    (double)c->figures.flicker_ppm[i] / 1e4);
        ttf_err_hint(&err, "expose longer, or light the lamp fully");
        check_put_finding(j, "warning", &err);
    }
}

static int put_lamp_figures(void *ctx, const struct ttf_box *box, struct ttf_err *err)
{
    struct ttf_json *j = ((void **)ctx)[0];
    const struct checked *c = ((void **)ctx)[1];

    (void)err;
    for (unsigned i = 0; box->lamps && i < ttf_lamps_count(box->lamps); i++) {
        ttf_json_object(j);
        ttf_json_kstring(j, "name", ttf_lamps_info(box->lamps, i)->name);
        ttf_json_kint(j, "on_ns", c->figures.lamp_on_ns[i]);
        ttf_json_kint(j, "switchings", c->figures.lamp_switchings[i]);
        ttf_json_kint(j, "duty_permille", c->figures.lamp_duty_permille[i]);
        ttf_json_kint(j, "duty_window_ns", ttf_lamps_info(box->lamps, i)->duty_window_ns);
        ttf_json_object_end(j);
    }
    return 0;
}

/* It may have been set by the time that it is to begin. */
static void put_clock_warning(struct ttf_json *j, const struct checked *c)
{
    struct ttf_err err = {0};
    struct ttf_utc utc;

    ttf_clock_utc(c->d->clock, &utc);
    if (ttf_plan_file_check_clock(c->file, &utc, &err) < 0)
        check_put_finding(j, "warning", &err);
}

static void put_figures(struct ttf_json *j, struct checked *c)
{
    const struct ttf_plan *plan = ttf_plan_file_plan(c->file);
    const struct ttf_plan_figures *f = &c->figures;
    void *both[] = {j, c};

    ttf_json_key(j, "figures");
    ttf_json_object(j);
    ttf_plan_figures_put(plan, f, j);
    ttf_json_key(j, "lamps");
    ttf_json_array(j);
    (void)!shadow_with(c->d->shadow, put_lamp_figures, both, NULL);
    ttf_json_array_end(j);
    if (c->disk.free_bytes) {
        ttf_json_kint(j, "disk_free_bytes", c->disk.free_bytes);
        ttf_json_kint(j, "slots_that_fit", c->disk.slots_that_fit);
    }
    ttf_json_object_end(j);
}

int check_clock(struct daemon *d, const char *name, const char *yaml, struct ttf_err *err)
{
    struct ttf_plan_file *file = NULL;
    struct ttf_utc utc;
    int r = ttf_plan_file_parse(name, yaml, strlen(yaml), &file, err);

    if (r < 0)
        return r;
    ttf_clock_utc(d->clock, &utc);
    r = ttf_plan_file_check_clock(file, &utc, err);
    ttf_plan_file_free(file);
    return r;
}

int check_plan(struct daemon *d, const char *name, const char *yaml, size_t bytes, char **ret_json,
               bool *ret_ok, struct ttf_err *err)
{
    struct checked c = {.d = d};
    struct ttf_json j;
    int r = check(&c, name, yaml, bytes, err);

    if (r < 0 && r != -EINVAL && r != -ERANGE && r != -ENOENT && r != -ENOTSUP) {
        ttf_plan_file_free(c.file);
        return r;
    }
    *ret_ok = r == 0;
    ttf_json_init(&j, false);
    ttf_json_object(&j);
    ttf_json_kbool(&j, "ok", r == 0);
    ttf_json_key(&j, "findings");
    ttf_json_array(&j);
    if (r < 0)
        check_put_finding(&j, "error", err);
    if (c.has_figures)
        put_warnings(&j, &c);
    if (c.file)
        put_clock_warning(&j, &c);
    ttf_json_array_end(&j);
    if (c.has_figures)
        put_figures(&j, &c);
    ttf_json_object_end(&j);
    ttf_plan_file_free(c.file);
    return daemon_give(&j, ret_json, err);
}

/* ---- what the box is made of ---- */

static int put_devices(void *ctx, const struct ttf_box *box, struct ttf_err *err)
{
    struct ttf_json *j = ctx;

    (void)err;
    ttf_json_key(j, "cameras");
    ttf_json_array(j);
    for (unsigned i = 0; i < box->n_cameras; i++) {
        const struct ttf_camera_caps *caps = ttf_camera_caps(box->cameras[i].camera);
        const struct ttf_frame_format *format = ttf_camera_format(box->cameras[i].camera);

        ttf_json_object(j);
        ttf_json_kstring(j, "name", box->cameras[i].name);
        if (format) {
            ttf_json_kint(j, "width", format->width);
            ttf_json_kint(j, "height", format->height);
        }
        ttf_json_kint(j, "exposure_min_ns", caps->exposure_min_ns);
        ttf_json_kint(j, "exposure_max_ns", caps->exposure_max_ns);
        ttf_json_kint(j, "gain_min_milli", caps->gain_min_milli);
        ttf_json_kint(j, "gain_max_milli", caps->gain_max_milli);
        ttf_json_object_end(j);
    }
    ttf_json_array_end(j);
    ttf_json_key(j, "lamps");
    ttf_json_array(j);
    for (unsigned i = 0; box->lamps && i < ttf_lamps_count(box->lamps); i++) {
        const struct ttf_lamp_info *info = ttf_lamps_info(box->lamps, i);

        ttf_json_object(j);
        ttf_json_kstring(j, "name", info->name);
        ttf_json_kint(j, "steps", info->steps > 1 ? info->steps : 1);
        ttf_json_kint(j, "warm_up_ns", info->warm_up_ns);
        ttf_json_kint(j, "max_on_ns", info->max_on_ns);
        ttf_json_kint(j, "max_duty_permille", info->max_duty_permille);
        ttf_json_object_end(j);
    }
    ttf_json_array_end(j);
    return 0;
}

int check_devices(struct daemon *d, char **ret_json, struct ttf_err *err)
{
    struct ttf_json j;
    int r;

    ttf_json_init(&j, false);
    ttf_json_object(&j);
    ttf_json_kstring(&j, "board", d->board.name);
    ttf_json_kstring(&j, "serial", d->serial);
    ttf_json_kbool(&j, "simulated", d->board.simulated);
    r = know_devices(d, put_devices, &j, err);
    ttf_json_key(&j, "sensors");
    ttf_json_array(&j);
    for (unsigned i = 0; i < d->board.sim.n_sensors; i++) {
        ttf_json_object(&j);
        ttf_json_kstring(&j, "name", d->board.sim.sensors[i].name);
        ttf_json_kstring(&j, "kind", ttf_sensor_kind_name(d->board.sim.sensors[i].kind));
        ttf_json_object_end(&j);
    }
    ttf_json_array_end(&j);
    ttf_json_object_end(&j);
    if (r < 0) {
        ttf_json_free(&j);
        return r;
    }
    return daemon_give(&j, ret_json, err);
}
