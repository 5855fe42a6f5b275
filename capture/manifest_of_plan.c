/* SPDX-License-Identifier: Apache-2.0 */
#include "manifest_of_plan.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

#include "plan_figures.h"

static const char *const cfa_names[TTF_CFA_COUNT] = {"", "RGGB", "GRBG", "GBRG", "BGGR"};

static void add_camera(struct ttf_manifest *m, const char *name, const struct ttf_camera *camera)
{
    const struct ttf_frame_format *format = ttf_camera_format(camera);
    struct ttf_dataset_camera *c;

    for (unsigned i = 0; i < m->n_cameras; i++) {
        if (strcmp(m->cameras[i].id, name) == 0)
            return;
    }
    c = &m->cameras[m->n_cameras++];
    snprintf(c->id, sizeof(c->id), "%s", name);
    snprintf(c->model, sizeof(c->model), "%s", ttf_camera_caps(camera)->model);
    c->raw_width = format->width;
    c->raw_height = format->height;
    c->raw_bits = format->bits;
    snprintf(c->cfa, sizeof(c->cfa), "%s", cfa_names[format->cfa]);
}

/* "lamp-a 100 %, lamp-b 0 %" or "no lamps" */
static void channel_title(const struct ttf_plan_shot *shot, char *ret, size_t size)
{
    size_t used = 0;

    snprintf(ret, size, "no lamps");
    for (unsigned i = 0; i < shot->n_levels && used < size; i++)
        used += (size_t)snprintf(ret + used, size - used, "%s%s %g %%", i ? ", " : "",
                                 shot->levels[i].lamp, shot->levels[i].permille / 10.0);
}

static void add_channel(struct ttf_manifest *m, const struct ttf_plan_shot *shot)
{
    struct ttf_channel *c;

    for (unsigned i = 0; i < m->n_channels; i++) {
        if (strcmp(m->channels[i].id, shot->channel) == 0)
            return;
    }
    c = &m->channels[m->n_channels++];
    snprintf(c->id, sizeof(c->id), "%s", shot->channel);
    channel_title(shot, c->title, sizeof(c->title));
}

bool ttf_plan_calibrates(const struct ttf_plan *plan, const struct ttf_calibration *calibration,
                         const char *camera)
{
    bool alone = true;

    for (unsigned i = 0; i < plan->n_shots; i++)
        alone = alone && strcmp(plan->shots[i].camera, camera) == 0;
    return calibration &&
           (alone || calibration->camera[0] == '\0' || strcmp(calibration->camera, camera) == 0);
}

/* Developed pixels are the frame's: the region cuts, and scales nothing. */
static double scale_of(const struct ttf_plan *plan, const struct ttf_plan_shot *shot,
                       const struct ttf_frame_format *format,
                       const struct ttf_calibration *calibration)
{
    bool own = calibration && calibration->has_geometry && calibration->width == format->width &&
               calibration->height == format->height &&
               (calibration->camera[0] == '\0' || strcmp(calibration->camera, shot->camera) == 0);

    if (plan->mm_per_px > 0)
        return plan->mm_per_px;
    return own ? calibration->geometry.mm_per_px : 0;
}

static void add_stream(struct ttf_manifest *m, const struct ttf_plan *plan,
                       const struct ttf_plan_shot *shot, const struct ttf_frame_format *format,
                       const struct ttf_calibration *calibration)
{
    const struct ttf_region region = ttf_plan_region(plan, format);
    const bool flat = ttf_plan_calibrates(plan, calibration, shot->camera) && calibration->has_flat;
    struct ttf_stream *st = &m->streams[m->n_streams];

    snprintf(st->id, sizeof(st->id), "%s", shot->stream);
    snprintf(st->camera, sizeof(st->camera), "%s", shot->camera);
    snprintf(st->channel, sizeof(st->channel), "%s", shot->channel);
    snprintf(st->quantity, sizeof(st->quantity), "%s", flat ? "reflectance" : "radiance");
    snprintf(st->unit, sizeof(st->unit), "1");
    st->width = region.width;
    st->height = region.height;
    st->samples = 3;
    st->format = TTF_SAMPLE_U16;
    st->encoding.pedestal = TTF_PEDESTAL;
    st->encoding.scale = TTF_SCALE;
    snprintf(st->colour_space, sizeof(st->colour_space), "%s", flat ? "linear-srgb" : "camera");
    st->mm_per_px = scale_of(plan, shot, format, calibration);
    st->primary = m->n_streams == 0;
    m->n_streams++;
}

int ttf_manifest_of_plan(const struct ttf_plan *plan, const struct ttf_box *box,
                         const struct ttf_calibration *calibration, struct ttf_manifest *ret,
                         struct ttf_err *err)
{
    struct ttf_manifest m;
    int r = ttf_manifest_init(&m, err);

    if (r < 0)
        return r;
    /* In the title as well, so that nobody takes an invention for an observation. */
    snprintf(m.title, sizeof(m.title), "%s%.115s", box->simulated ? "SIMULATED " : "", plan->title);
    snprintf(m.box_serial, sizeof(m.box_serial), "%s", box->serial);
    m.simulated = box->simulated;
    for (unsigned i = 0; i < plan->n_shots; i++) {
        const struct ttf_plan_shot *shot = &plan->shots[i];
        const struct ttf_camera *camera = ttf_box_camera_find(box, shot->camera);

        add_camera(&m, shot->camera, camera);
        add_channel(&m, shot);
        add_stream(&m, plan, shot, ttf_camera_format(camera), calibration);
    }
    *ret = m;
    return 0;
}

int ttf_manifest_takes_plan(const struct ttf_manifest *manifest, const struct ttf_manifest *wanted,
                            struct ttf_err *err)
{
    if (manifest->simulated != wanted->simulated)
        return ttf_err_set(err, -EINVAL, "dataset.json",
                           "a simulated and a real capture cannot share a dataset");
    if (manifest->rehearsal) {
        ttf_err_set(err, -EINVAL, "dataset.json",
                    "this is a rehearsal, not a capture to go on with");
        ttf_err_hint(err, "name another folder for the capture");
        return -EINVAL;
    }
    for (unsigned i = 0; i < wanted->n_streams; i++) {
        const struct ttf_stream *w = &wanted->streams[i];
        const struct ttf_stream *st = ttf_manifest_stream(manifest, w->id);

        if (!st || st->width != w->width || st->height != w->height ||
            strcmp(st->camera, w->camera) != 0 || strcmp(st->quantity, w->quantity) != 0) {
            ttf_err_set(err, -EINVAL, "dataset.json",
                        "the dataset has no stream '%s' of %u x %u pixels from camera '%s' with "
                        "quantity %s",
                        w->id, w->width, w->height, w->camera, w->quantity);
            ttf_err_hint(err, "resume with the plan and calibration it was begun with, or "
                              "begin a new dataset beside it, with 'group: NAME-OF-THIS-ONE' in "
                              "its plan");
            return -EINVAL;
        }
    }
    return 0;
}
