/* SPDX-License-Identifier: Apache-2.0 */
/* controls.c: a camera's controls: all that is automatic off, what has a meaning mapped to settings, the rest fixed. */
#include <errno.h>
#include <math.h>

#include "device.h"
#include "ttf/base/time.h"

/* What a processed stream's digital gain may be off 1. */
#define DIGITAL_GAIN_SLACK 0.005

/* What stands still for the whole run, where there is such a control. */
static const struct fixed {
    enum lc_control control;
    double value;
    const char
        *automatic; /* its name, if it is one: it has to be off, and not as near to it as it goes */
} FIXED[] = {{LC_AUTO_EXPOSURE, 0, "automatic exposure"},
             {LC_AUTO_BALANCE, 0, "automatic white balance"},
             {LC_AUTO_FOCUS, 0, "automatic focus"},
             {LC_NOISE_REDUCTION, 0, "noise reduction"},
             {LC_HDR, 0, "HDR"},
             {LC_FLICKER, 0, "anti-flicker"},
             {LC_SHARPNESS, 0, NULL},
             {LC_BRIGHTNESS, 0, NULL},
             {LC_CONTRAST, 1, NULL},
             {LC_SATURATION, 1, NULL},
             {LC_DIGITAL_GAIN, 1, NULL}};

/* Which control is which ability. */
static const struct ability {
    unsigned bit;
    enum lc_control control;
    double fixed; /* if it is none after all; NAN: the least there is */
} ABILITIES[] = {{TTF_LIBCAMERA_EXPOSURE, LC_EXPOSURE, NAN},
                 {TTF_LIBCAMERA_GAIN, LC_GAIN, NAN},
                 {TTF_LIBCAMERA_BALANCE, LC_COLOUR_GAINS, 1},
                 {TTF_LIBCAMERA_LENS, LC_LENS, NAN},
                 {TTF_LIBCAMERA_PLACING, LC_FRAME_DURATION, NAN}};

static bool has(const struct lc_limits *limits, enum lc_control control)
{
    return limits->has & 1u << control;
}

static void put(struct lc_settings *settings, enum lc_control control, double a, double b)
{
    settings->set |= 1u << control;
    settings->value[control][0] = a;
    settings->value[control][1] = b;
}

static double within(const struct lc_limits *limits, enum lc_control control, double value)
{
    if (value < limits->min[control])
        value = limits->min[control];
    return value > limits->max[control] ? limits->max[control] : value;
}

/* What stands still, into what each request carries. */
static int fix(struct lc_camera *camera, struct ttf_err *err)
{
    struct lc_abilities *can = &camera->can;

    for (unsigned i = 0; i < TTF_COUNT_OF(FIXED); i++) {
        const struct fixed *f = &FIXED[i];
        double value = within(&can->limits, f->control, f->value);

        if (!has(&can->limits, f->control))
            continue;
        if (f->automatic && (value < f->value || value > f->value))
            return ttf_err_set(err, -ENOTSUP, camera->id.id,
                               "the camera's %s cannot be switched off", f->automatic);
        put(&can->fixed, f->control, value, 0);
        can->automatics_off += f->automatic != NULL;
    }
    return 0;
}

int lc_controls_find(struct lc_camera *camera, struct ttf_err *err)
{
    struct lc_abilities *can = &camera->can;
    int r;

    *can = (struct lc_abilities){0};
    r = lc_ops(camera)->limits(camera->handle, &can->limits);
    if (r < 0)
        return ttf_err_set(err, r, camera->id.id, "the camera does not tell its controls");
    r = fix(camera, err);
    if (r < 0)
        return r;
    for (unsigned i = 0; i < TTF_COUNT_OF(ABILITIES); i++)
        if (has(&can->limits, ABILITIES[i].control) &&
            can->limits.max[ABILITIES[i].control] > can->limits.min[ABILITIES[i].control])
            can->has |= ABILITIES[i].bit;
    can->mapped = can->has;
    /* Balance is of what the image processor makes; raw pixels are before it. */
    if (camera->pixels->role == LC_RAW && (can->mapped & TTF_LIBCAMERA_BALANCE))
        lc_controls_unmap(can, TTF_LIBCAMERA_BALANCE);
    if (has(&can->limits, LC_AUTO_EXPOSURE) && !(can->has & TTF_LIBCAMERA_EXPOSURE))
        return ttf_err_set(err, -ENOTSUP, camera->id.id,
                           "the camera exposes by itself and takes no exposure time");
    return 0;
}

void lc_controls_unmap(struct lc_abilities *can, unsigned which)
{
    for (unsigned i = 0; i < TTF_COUNT_OF(ABILITIES); i++) {
        const struct ability *a = &ABILITIES[i];
        double value = isnan(a->fixed) ? can->limits.min[a->control] : a->fixed;

        if (!(a->bit & which))
            continue;
        can->mapped &= ~a->bit;
        if (a->control != LC_FRAME_DURATION)
            put(&can->fixed, a->control, value, value);
    }
}

static uint32_t milli(double value)
{
    return value <= 0 ? 0 : (uint32_t)lround(value * 1000);
}

void lc_controls_caps(const struct lc_abilities *can, struct ttf_camera_caps *caps)
{
    const struct lc_limits *l = &can->limits;

    if (can->mapped & TTF_LIBCAMERA_EXPOSURE) {
        caps->exposure_min_ns = llround(fmax(l->min[LC_EXPOSURE], 1)) * TTF_NS_PER_US;
        caps->exposure_max_ns = llround(l->max[LC_EXPOSURE]) * TTF_NS_PER_US;
    }
    if (can->mapped & TTF_LIBCAMERA_GAIN) {
        caps->gain_min_milli = milli(l->min[LC_GAIN]);
        caps->gain_max_milli = milli(l->max[LC_GAIN]);
    }
    caps->has_white_balance = can->mapped & TTF_LIBCAMERA_BALANCE;
    caps->has_lens = can->mapped & TTF_LIBCAMERA_LENS;
}

struct ttf_exposure lc_controls_settable(const struct lc_abilities *can,
                                         const struct ttf_exposure *asked)
{
    struct ttf_exposure settable = {0};

    if (can->mapped & TTF_LIBCAMERA_EXPOSURE)
        settable.exposure_ns = asked->exposure_ns;
    if (can->mapped & TTF_LIBCAMERA_GAIN)
        settable.gain_milli = asked->gain_milli;
    if (can->mapped & TTF_LIBCAMERA_BALANCE) {
        settable.wb_r_milli = asked->wb_r_milli;
        settable.wb_b_milli = asked->wb_b_milli;
    }
    if (can->mapped & TTF_LIBCAMERA_LENS)
        settable.lens_mdpt = asked->lens_mdpt;
    return settable;
}

struct lc_settings lc_controls_request(const struct lc_abilities *can,
                                       const struct ttf_exposure *asked)
{
    struct lc_settings s = can->fixed;
    int64_t us = (asked->exposure_ns + TTF_NS_PER_US / 2) / TTF_NS_PER_US;

    if (can->mapped & TTF_LIBCAMERA_EXPOSURE)
        put(&s, LC_EXPOSURE, within(&can->limits, LC_EXPOSURE, (double)us), 0);
    if (can->mapped & TTF_LIBCAMERA_GAIN)
        put(&s, LC_GAIN, within(&can->limits, LC_GAIN, asked->gain_milli / 1e3), 0);
    if (can->mapped & TTF_LIBCAMERA_BALANCE)
        put(&s, LC_COLOUR_GAINS, within(&can->limits, LC_COLOUR_GAINS, asked->wb_r_milli / 1e3),
            within(&can->limits, LC_COLOUR_GAINS, asked->wb_b_milli / 1e3));
    if (can->mapped & TTF_LIBCAMERA_LENS)
        put(&s, LC_LENS, within(&can->limits, LC_LENS, asked->lens_mdpt / 1e3), 0);
    return s;
}

static bool tells(const struct lc_settings *told, enum lc_control control)
{
    return told->set & 1u << control;
}

bool lc_controls_multiplied(const struct lc_camera *camera, const struct lc_settings *told)
{
    return camera->pixels->role == LC_PROCESSED && tells(told, LC_DIGITAL_GAIN) &&
           fabs(told->value[LC_DIGITAL_GAIN][0] - 1) > DIGITAL_GAIN_SLACK;
}

bool lc_controls_told(const struct lc_abilities *can, const struct lc_settings *told,
                      const struct ttf_exposure *asked, struct ttf_exposure *ret)
{
    struct ttf_exposure found = {0};
    bool all = true;

    if (can->mapped & TTF_LIBCAMERA_EXPOSURE) {
        all &= tells(told, LC_EXPOSURE);
        found.exposure_ns = llround(told->value[LC_EXPOSURE][0] * 1e3);
    }
    if (can->mapped & TTF_LIBCAMERA_GAIN) {
        all &= tells(told, LC_GAIN);
        found.gain_milli = milli(told->value[LC_GAIN][0]);
    }
    if (can->mapped & TTF_LIBCAMERA_BALANCE) {
        all &= tells(told, LC_COLOUR_GAINS);
        found.wb_r_milli = milli(told->value[LC_COLOUR_GAINS][0]);
        found.wb_b_milli = milli(told->value[LC_COLOUR_GAINS][1]);
    }
    if (can->mapped & TTF_LIBCAMERA_LENS) {
        all &= tells(told, LC_LENS) || !can->lens_told;
        found.lens_mdpt = can->lens_told
                              ? milli(told->value[LC_LENS][0])
                              : milli(within(&can->limits, LC_LENS, asked->lens_mdpt / 1e3));
    }
    *ret = found;
    return all;
}
