/* SPDX-License-Identifier: Apache-2.0 */
#include "ttf/capture/guided_calibration.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "exposure.h"
#include "lamp_programme.h"
#include "plan_figures.h"
#include "shoot.h"
#include "ttf/capture/disk_budget.h"
#include "ttf/dataset/flicker.h"

#define PHASE_FRAMES   8                      /* after so many the stream begins anew */
#define PHASE_SHIFT_NS (3700 * TTF_NS_PER_US) /* no simple part of a half-period of 50 or 60 Hz */

#define DARK_BYTES (int64_t)sizeof(float) /* of a pixel, CALIBRATION.md */
#define FLAT_BYTES (int64_t)sizeof(uint16_t)
#define TEXT_BYTES (INT64_C(1) << 20) /* calibration.json, hot pixels and all, and folders */

struct light {
    bool lit;    /* under the shot's lamps; else all are off */
    bool strict; /* a calibration is fitted: it must be what was asked for */
};

/* Everything that taking frames needs, without a dataset. */
struct guide {
    struct light light;
    int64_t settled_ns;              /* a lamp that is lit for less has not settled */
    int64_t give_up_ns;              /* a set of frames is not begun anew after this */
    struct ttf_flicker_frames *each; /* frames go there one by one instead of into a sum; or NULL */
    struct ttf_queue queue;          /* events go here and no further */
    struct ttf_events events;
    struct ttf_lamp_driver lamps;
    struct ttf_pulse pulse;
    struct ttf_shooter camera;
    struct ttf_shot shots[TTF_SHOOT_TRIES * TTF_CAMERA_SET_MAX]; /* of one set */
};

void ttf_guided_plain_shot(const struct ttf_box *box, struct ttf_plan_shot *shot)
{
    snprintf(shot->camera, sizeof(shot->camera), "%s", box->cameras[0].name);
    shot->n_levels = 0;
    for (unsigned i = 0; box->lamps && i < ttf_lamps_count(box->lamps); i++) {
        struct ttf_lamp_level *level = &shot->levels[shot->n_levels++];

        memcpy(level->lamp, ttf_lamps_info(box->lamps, i)->name, sizeof(level->lamp));
        level->permille = TTF_LAMP_FULL;
    }
}

static int check(const struct ttf_guided_config *config, struct ttf_err *err)
{
    if (config->frames < 1 || config->frames > 1000)
        return ttf_err_set(err, -EINVAL, "frames", "1 to 1000 frames can be averaged");
    if (config->shot->exposure.exposure_ns <= 0)
        return ttf_err_set(err, -EINVAL, "exposure", "an exposure must be more than 0");
    return 0;
}

/* The shot's levels, on this box. */
static int levels_of(const struct ttf_guided_config *config, unsigned ret[TTF_LAMPS_MAX],
                     int64_t *ret_settle_ns, struct ttf_err *err)
{
    struct ttf_lamp_programme programme;
    struct ttf_plan plan;
    int r;

    ttf_plan_defaults(&plan);
    plan.lamps = TTF_LAMPS_CAPTURE_ONLY;
    plan.settle_ns = config->settle_ns;
    plan.shots[0] = *config->shot;
    r = ttf_lamp_programme_init(&programme, &plan, config->box->lamps, 0, err);
    if (r < 0)
        return r;
    memcpy(ret, programme.shot[0], sizeof(programme.shot[0]));
    *ret_settle_ns = ttf_lamp_settle_ns(&plan, &plan.shots[0], config->box->lamps);
    return 0;
}

/* Frames in another light are in no average: what is fitted from them looks right and is not. */
static int check_light(const struct guide *g, const char *flags, struct ttf_err *err)
{
    static const struct {
        const char *flag, *what;
        bool lit; /* of frames under lamps alone */
    } WRONG[] = {
        {"door-open", "the door was open", false},
        {"lamp-tripped", "a lamp was off that was to be lit", true},
        {"lamp-unsettled", "a lamp went off and had not settled again", true},
        {"lamp-unknown", "nobody says what a lamp did", true},
    };

    for (unsigned i = 0; g->light.strict && i < sizeof(WRONG) / sizeof(*WRONG); i++)
        if ((g->light.lit || !WRONG[i].lit) && strstr(flags, WRONG[i].flag))
            return ttf_err_set(err, -EIO, g->camera.name, "%s while frames were taken",
                               WRONG[i].what);
    return 0;
}

/* Fills the sum up to so many frames in all; when the first of the new ones was exposed. */
static int take_set(struct guide *g, const struct ttf_locked *locked, unsigned up_to,
                    struct ttf_raw_sum *sum, int64_t *ret_start_ns, struct ttf_err *err)
{
    struct ttf_image image = {.shots = g->shots};
    struct ttf_take take = {
        .locked = locked,
        .settle_ns = g->settled_ns,
        .give_up_ns = g->give_up_ns,
        .raw = sum,
        .image = &image,
        .shots_room = TTF_SHOOT_TRIES * TTF_CAMERA_SET_MAX,
        .average = up_to,
    };
    unsigned before = sum->n;
    int r;

    if (ttf_pulse_stop_wanted(&g->pulse))
        return ttf_err_set(err, -ECANCELED, g->camera.name, "no picture is wanted any more");
    r = ttf_shoot(&g->camera, &take);
    if (r < 0)
        return r;
    if (sum->n == before)
        return ttf_err_set(err, -EIO, g->camera.name, "the camera gives no good frame: %s",
                           image.lacking);
    if (strstr(image.flags, "wrong-settings"))
        return ttf_err_set(err, -EIO, g->camera.name, "the camera does not keep its exposure");
    *ret_start_ns = take.start_ns;
    return check_light(g, image.flags, err);
}

/* Averages the frames, a set at a time. */
static int accumulate(struct guide *g, const struct ttf_locked *locked,
                      const struct ttf_guided_config *config, struct ttf_raw_sum *sum,
                      struct ttf_err *err)
{
    while (sum->n < config->frames) {
        unsigned left = config->frames - sum->n;
        int64_t start_ns;
        int r =
            take_set(g, locked, sum->n + (left < TTF_CAMERA_SET_MAX ? left : TTF_CAMERA_SET_MAX),
                     sum, &start_ns, err);

        if (r < 0)
            return r;
    }
    return 0;
}

/*
 * The stream anew, at another moment of the mains: a camera of 25 frames a second sees 100 Hz at the same phase in each of them,
 * and slots that are minutes apart do not.
 */
static int shift_phase(struct guide *g, struct ttf_locked *locked, struct ttf_err *err)
{
    struct ttf_camera *camera = g->camera.camera;
    const struct ttf_exposure asked = locked->asked;
    int r;

    ttf_camera_stop(camera);
    r = ttf_pulse_wait(&g->pulse, ttf_clock_now_ns(g->events.clock) + PHASE_SHIFT_NS, true);
    if (r == 0)
        r = ttf_camera_start(camera, err);
    return r < 0 ? r : ttf_shooter_lock(&g->camera, &asked, locked, err);
}

/* The frames one by one. */
static int take_each(struct guide *g, struct ttf_locked *locked, unsigned frames,
                     struct ttf_raw_sum *sum, struct ttf_err *err)
{
    int r = ttf_flicker_init(g->each, &g->camera.format, frames, err);

    while (r == 0 && g->each->n < frames) {
        int64_t start_ns = 0;

        if (g->each->n > 0 && g->each->n % PHASE_FRAMES == 0)
            r = shift_phase(g, locked, err);
        if (r < 0)
            break;
        ttf_raw_sum_reset(sum);
        r = take_set(g, locked, 1, sum, &start_ns, err);
        if (r == 0)
            r = ttf_flicker_add(g->each, sum, start_ns);
    }
    return r;
}

/* Levels set and settled, exposure locked, frames taken. */
static int acquire(struct guide *g, const struct ttf_guided_config *config, struct ttf_raw_sum *sum,
                   struct ttf_err *err)
{
    const struct ttf_camera_caps *caps = ttf_camera_caps(g->camera.camera);
    struct ttf_exposure asked =
        ttf_shot_exposure(config->shot, 0, config->mains_hz, caps->exposure_max_ns);
    unsigned levels[TTF_LAMPS_MAX] = {0};
    struct ttf_locked locked;
    int64_t settle = 0;
    int r = g->light.lit ? levels_of(config, levels, &settle, err) : 0;

    if (r < 0)
        return r;
    ttf_lamp_driver_want(&g->lamps, levels);
    g->settled_ns =
        settle / 10 * 9; /* a stream's first frame may have begun before the wait ended */
    settle += ttf_clock_now_ns(config->box->clock);
    r = ttf_shooter_lock(&g->camera, &asked, &locked, err);
    if (r == 0)
        r = ttf_pulse_wait(&g->pulse, settle, true);
    if (r < 0)
        return r;
    r = ttf_raw_sum_init(sum, &g->camera.format);
    if (r < 0)
        return r;
    g->give_up_ns = config->patience_ns > 0
                        ? ttf_clock_now_ns(config->box->clock) + config->patience_ns
                        : TTF_NS_NEVER;
    return g->each ? take_each(g, &locked, config->frames, sum, err)
                   : accumulate(g, &locked, config, sum, err);
}

/* Dark and flat of this camera, and their text, are what it takes at the most: what is there is written anew with each part. */
static int check_room(const struct guide *g, const struct ttf_guided_config *config,
                      struct ttf_err *err)
{
    const struct ttf_frame_format *f = &g->camera.format;
    int64_t bytes = (int64_t)f->width * f->height * (DARK_BYTES + FLAT_BYTES) + TEXT_BYTES;

    return config->folder && config->io
               ? ttf_disk_room_check(config->io, config->folder, "a calibration", bytes, err)
               : 0;
}

static int set_up_camera(struct guide *g, const struct ttf_guided_config *config,
                         struct ttf_err *err)
{
    struct ttf_camera_mode native = {0};
    int r;

    g->camera.camera = ttf_box_camera_find(config->box, config->shot->camera);
    if (!g->camera.camera)
        return ttf_err_set(err, -EINVAL, "camera", "the box has no camera '%s'",
                           config->shot->camera);
    snprintf(g->camera.name, sizeof(g->camera.name), "%s", config->shot->camera);
    g->camera.pulse = &g->pulse;
    g->camera.events = &g->events;
    ttf_camera_stop(g->camera.camera);
    r = ttf_camera_configure(g->camera.camera, &native, &g->camera.format, err);
    if (r == 0)
        r = check_room(g, config, err);
    return r < 0 ? r : ttf_camera_start(g->camera.camera, err);
}

/* Everything but the fitting. */
static int with_devices(struct guide *g, const struct ttf_guided_config *config,
                        struct ttf_raw_sum *sum, struct ttf_err *err)
{
    struct ttf_box *box = config->box;
    const struct ttf_stock_size size = {.jobs[TTF_JOB_EVENT] = TTF_QUEUE_EVENTS_MAX};
    int r = ttf_queue_init(&g->queue, box->clock, &size);

    if (r < 0)
        return r;
    g->events.queue = &g->queue;
    g->events.clock = box->clock;
    r = ttf_lamp_driver_begin(&g->lamps, box->lamps, &g->events,
                              ttf_clock_now_ns(box->clock) + TTF_BLOCKING_MAX_NS, err);
    if (r == 0) {
        ttf_pulse_begin(&g->pulse, box, &g->queue, &g->events, &g->lamps, config->stop);
        r = set_up_camera(g, config, err);
        if (r == 0)
            r = acquire(g, config, sum, err);
        ttf_pulse_end(&g->pulse);
    }
    ttf_lamp_driver_end(&g->lamps);
    if (g->camera.camera)
        ttf_camera_stop(g->camera.camera);
    ttf_queue_finish(&g->queue);
    return r;
}

static int guided(const struct ttf_guided_config *config, struct light light,
                  struct ttf_raw_sum *sum, struct ttf_flicker_frames *each, struct ttf_err *err)
{
    struct guide *g;
    int r = check(config, err);

    if (r < 0)
        return r;
    g = calloc(1, sizeof(*g));
    if (!g)
        return ttf_err_set(err, -ENOMEM, config->shot->camera, "no memory to take frames");
    g->light = light;
    g->each = each;
    ttf_clock_join(config->box->clock);
    r = with_devices(g, config, sum, err);
    ttf_clock_leave(config->box->clock);
    free(g);
    if (r < 0 && err && err->code != r)
        ttf_err_set(err, r, config->shot->camera, "frames cannot be taken: %s",
                    strerrordesc_np(-r));
    return r;
}

int ttf_guided_frames(const struct ttf_guided_config *config, bool lit, struct ttf_raw_sum *sum,
                      struct ttf_err *err)
{
    return guided(config, (struct light){.lit = lit}, sum, NULL, err);
}

/* The same for a part of a calibration, which is of one camera. */
static int frames_for(const struct ttf_guided_config *config,
                      const struct ttf_calibration *calibration, bool lit, struct ttf_raw_sum *sum,
                      struct ttf_flicker_frames *each, struct ttf_err *err)
{
    const char *camera = config->shot->camera;

    if (calibration->camera[0] != '\0' && strcmp(calibration->camera, camera) != 0)
        return ttf_err_set(err, -EINVAL, camera, "the calibration is of camera '%s'",
                           calibration->camera);
    return guided(config, (struct light){.lit = lit, .strict = true}, sum, each, err);
}

/* What a calibration says of where it comes from. */
static void sign(const struct ttf_guided_config *config, struct ttf_calibration *calibration)
{
    snprintf(calibration->camera, sizeof(calibration->camera), "%s", config->shot->camera);
    calibration->simulated = config->box->simulated;
}

/* The box's temperature while the dark frames were taken: dark current doubles every few degrees. */
static void note_temperature(const struct ttf_guided_config *config,
                             struct ttf_calibration *calibration)
{
    struct ttf_reading readings[TTF_SENSORS_MAX];
    int n = config->box->sensors ? ttf_sensors_read(config->box->sensors, readings, NULL) : 0;

    for (int i = 0; i < n; i++) {
        if (readings[i].ok && readings[i].kind == TTF_SENSOR_TEMP_MDEGC) {
            calibration->dark_temp_mdegc = (int32_t)readings[i].value;
            return;
        }
    }
}

int ttf_guided_dark(const struct ttf_guided_config *config, struct ttf_calibration *calibration,
                    struct ttf_err *err)
{
    struct ttf_raw_sum sum = {0};
    int r = frames_for(config, calibration, false, &sum, NULL, err);

    if (r == 0)
        r = ttf_calibration_fit_dark(calibration, &sum, err);
    if (r == 0) {
        sign(config, calibration);
        note_temperature(config, calibration);
        r = ttf_calibration_name(calibration, err);
    }
    ttf_raw_sum_free(&sum);
    return r;
}

int ttf_guided_flat(const struct ttf_guided_config *config, struct ttf_calibration *calibration,
                    struct ttf_err *err)
{
    struct ttf_raw_sum sum = {0};
    int r = frames_for(config, calibration, true, &sum, NULL, err);

    if (r == 0)
        r = ttf_calibration_fit_flat(calibration, &sum, config->reflectance, err);
    if (r == 0) {
        sign(config, calibration);
        r = ttf_calibration_name(calibration, err);
    }
    ttf_raw_sum_free(&sum);
    return r;
}

int ttf_guided_chart(const struct ttf_guided_config *config, const struct ttf_chart_view *view,
                     const struct ttf_chart *chart, struct ttf_calibration *calibration,
                     struct ttf_err *err)
{
    struct ttf_raw_sum sum = {0};
    int r = frames_for(config, calibration, true, &sum, NULL, err);

    if (r == 0)
        r = ttf_calibration_fit_chart(calibration, &sum, view, chart, err);
    if (r == 0) {
        sign(config, calibration);
        r = ttf_calibration_name(calibration, err);
    }
    ttf_raw_sum_free(&sum);
    return r;
}

int ttf_guided_geometry(const struct ttf_guided_config *config, double pitch_mm,
                        struct ttf_calibration *calibration, struct ttf_err *err)
{
    struct ttf_raw_sum sum = {0};
    int r = frames_for(config, calibration, true, &sum, NULL, err);

    if (r == 0)
        r = ttf_calibration_fit_geometry(calibration, &sum, pitch_mm, err);
    if (r == 0)
        sign(config, calibration);
    ttf_raw_sum_free(&sum);
    return r;
}

int ttf_guided_flicker(const struct ttf_guided_config *config, struct ttf_calibration *calibration,
                       struct ttf_err *err)
{
    struct ttf_flicker_frames frames = {0};
    struct ttf_raw_sum sum = {0};
    int r = frames_for(config, calibration, true, &sum, &frames, err);

    if (r == 0)
        r = ttf_flicker_measure(&frames, &calibration->flicker, err);
    if (r == 0) {
        sign(config, calibration);
        calibration->has_flicker = true;
    }
    ttf_flicker_free(&frames);
    ttf_raw_sum_free(&sum);
    return r;
}
