/* SPDX-License-Identifier: Apache-2.0 */
#include "calibrate.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "library.h"
#include "log.h"
#include "sim_target.h"
#include "ttf/capture/guided_calibration.h"
#include "ttf/config/plan_file.h"
#include "view.h"

#define FRAMES      64
#define REFLECTANCE 0.9
#define FRAME_NS    (500 * TTF_NS_PER_MS) /* that a frame may take beside its exposures */
#define BESIDE_NS   (2 * TTF_NS_PER_MIN)  /* what is neither settling nor frames */

struct step {
    struct daemon *d;
    struct ttf_http_calibrate what;
    struct ttf_plan plan; /* whose first shot it is for; a plain one without */
    struct ttf_plan_shot shot;
    struct ttf_calibration calibration;
    char folder[CALIBRATION_PATH];
};

static int choose_shot(struct step *s, struct ttf_err *err)
{
    const struct ttf_http_calibrate *what = &s->what;
    struct ttf_plan_file *file = NULL;
    char *yaml = NULL;
    int r = 0;

    ttf_plan_defaults(&s->plan);
    ttf_guided_plain_shot(&s->d->view, &s->plan.shots[0]);
    if (*what->plan) {
        r = library_plan(s->d, what->plan, &yaml, err);
        if (r == 0)
            r = ttf_plan_file_parse(what->plan, yaml, strlen(yaml), &file, err);
        if (r == 0) {
            s->plan = *ttf_plan_file_plan(file);
            ttf_plan_file_free(file);
        }
        free(yaml);
    }
    s->shot = s->plan.shots[0];
    if (what->exposure_ns > 0)
        s->shot.exposure.exposure_ns = what->exposure_ns;
    if (what->gain_milli > 0)
        s->shot.exposure.gain_milli = (uint32_t)what->gain_milli;
    return r;
}

static int open_calibration(struct step *s, struct ttf_err *err)
{
    char path[CALIBRATION_PATH + 32];
    struct ttf_io_stat st;
    int r;

    calibrations_path(s->d->calibrations, s->what.name, s->folder);
    (void)snprintf(path, sizeof path, "%s/calibration.json", s->folder);
    r = s->d->io->ops->stat(s->d->io, path, &st);
    if (r == -ENOENT) /* a new one */
        return ttf_calibration_may_take(&s->calibration, s->what.part, err);
    if (r < 0)
        return ttf_err_set(err, r, path, "cannot be read: %s", strerrordesc_np(-r));
    r = ttf_calibration_load(s->d->io, s->folder, &s->calibration, err);
    if (r < 0)
        return r;
    /* It was not there when it was asked for, but may be since. */
    return ttf_calibration_has(&s->calibration, s->what.part)
               ? calibrations_refuse_twice(s->what.name, s->what.part, err)
               : ttf_calibration_may_take(&s->calibration, s->what.part, err);
}

static int take_flat(struct step *s, struct ttf_guided_config *config, struct ttf_err *err)
{
    double reflectance = config->reflectance;
    int r = s->d->view.simulated ? sim_target_reflectance(&s->d->view, &reflectance, err) : 0;

    config->reflectance = s->what.reflectance > 0 ? s->what.reflectance : reflectance;
    return r < 0 ? r : ttf_guided_flat(config, &s->calibration, err);
}

static int take_chart(struct step *s, const struct ttf_guided_config *config, struct ttf_err *err)
{
    struct ttf_chart_view view;
    struct ttf_chart chart;

    memcpy(view.corners, s->what.corners, sizeof view.corners);
    ttf_chart_classic(&chart);
    return ttf_guided_chart(config, &view, &chart, &s->calibration, err);
}

static int take(struct step *s, struct ttf_guided_config *config, struct ttf_err *err)
{
    switch (s->what.part) {
    case TTF_CALIBRATION_DARK:
        return ttf_guided_dark(config, &s->calibration, err);
    case TTF_CALIBRATION_FLAT:
        return take_flat(s, config, err);
    case TTF_CALIBRATION_CHART:
        return take_chart(s, config, err);
    case TTF_CALIBRATION_GEOMETRY:
        return ttf_guided_geometry(config, s->what.pitch_mm, &s->calibration, err);
    case TTF_CALIBRATION_FLICKER:
        break;
    }
    return ttf_guided_flicker(config, &s->calibration, err);
}

static int64_t settling_ns(const struct step *s)
{
    const struct ttf_lamps *lamps = s->d->view.lamps;
    int64_t longest = 0;

    if (s->what.part == TTF_CALIBRATION_DARK)
        return 0;
    if (s->plan.settle_ns > 0)
        return s->plan.settle_ns;
    for (unsigned i = 0; lamps && i < ttf_lamps_count(lamps); i++)
        if (ttf_lamps_info(lamps, i)->warm_up_ns > longest)
            longest = ttf_lamps_info(lamps, i)->warm_up_ns;
    return longest;
}

static int acquire(struct step *s, struct ttf_watchdog *watchdog, struct ttf_err *err)
{
    unsigned frames = s->what.frames ? s->what.frames : FRAMES;
    struct ttf_guided_config config = {
        .box = &s->d->view,
        .shot = &s->shot,
        .mains_hz = s->plan.mains_hz,
        .settle_ns = s->plan.settle_ns,
        .frames = frames,
        .reflectance = REFLECTANCE,
        .stop = &s->d->view_stop,
        .io = s->d->io,
        .folder = s->folder,
        .patience_ns = frames * (3 * s->shot.exposure.exposure_ns + FRAME_NS),
    };
    int64_t at_most_ns = settling_ns(s) + config.patience_ns + BESIDE_NS;
    int r;

    calibrations_at_most(s->d->calibrations, at_most_ns);
    if (watchdog)
        manager_wait(&s->d->manager, at_most_ns);
    r = take(s, &config, err);
    if (r == 0)
        r = ttf_calibration_name(&s->calibration, err);
    return r < 0 ? r : ttf_calibration_save(&s->calibration, s->d->io, s->folder, err);
}

static int do_step(struct step *s, struct ttf_watchdog *watchdog, struct ttf_err *err)
{
    int r;

    /* Devices that are opened, and pictures of a large sensor that are read. */
    if (watchdog)
        manager_wait(&s->d->manager, BESIDE_NS);
    r = view_open(s->d, err);
    if (r == 0)
        r = open_calibration(s, err);
    if (r == 0)
        r = choose_shot(s, err);
    if (r == 0)
        r = acquire(s, watchdog, err);
    if (r == -ECANCELED)
        r = ttf_err_set(err, r, NULL, "it was ended before it was done: a run wants the devices");
    /* A device that failed is made anew for what comes next. */
    if (r < 0 && r != -EINVAL)
        view_close(s->d, true);
    s->d->viewed_ns = ttf_clock_now_ns(s->d->clock);
    return r;
}

bool calibrate_work(struct daemon *d, struct ttf_watchdog *watchdog)
{
    struct step *s = calloc(1, sizeof *s);
    struct ttf_err err = {0};
    char text[900], quoted[1000];
    int r;

    if (!s || !calibrations_begin(d->calibrations, &s->what)) {
        free(s);
        return false;
    }
    s->d = d;
    ttf_calibration_init(&s->calibration);
    r = do_step(s, watchdog, &err);
    if (watchdog)
        (void)!ttf_watchdog_arm(watchdog, d->manager.watchdog_ns);
    if (r < 0)
        log_line(LOG_LEVEL_WARNING, "calibration", "name=\"%s\" refused=%s why=%s", s->what.name,
                 ttf_calibration_part_name(s->what.part),
                 log_text(ttf_err_text(&err, text, sizeof text), quoted, sizeof quoted));
    else
        log_line(LOG_LEVEL_NOTICE, "calibration", "name=\"%s\" has=%s", s->what.name,
                 ttf_calibration_part_name(s->what.part));
    calibrations_end(d->calibrations, r, &err);
    ttf_calibration_free(&s->calibration);
    free(s);
    return true;
}
