/* SPDX-License-Identifier: Apache-2.0 */
#include "controls.h"

#include <errno.h>
#include <linux/videodev2.h>
#include <string.h>

#include "controls_wire.h"
#include "ttf/base/time.h"

/* The unit of V4L2_CID_EXPOSURE_ABSOLUTE. */
#define ABSOLUTE_NS (100 * TTF_NS_PER_US)

/* Automatics, and what an image processor does of its own accord; each is set to `off` where it exists. */
static const struct {
    uint32_t id;
    int32_t off;
} AUTOMATICS[] = {
    {V4L2_CID_EXPOSURE_AUTO_PRIORITY, 0}, /* the frame rate stays */
    {V4L2_CID_AUTOGAIN, 0},
    {V4L2_CID_AUTO_WHITE_BALANCE, 0},
    {V4L2_CID_FOCUS_AUTO, 0},
    {V4L2_CID_AUTOBRIGHTNESS, 0},
    {V4L2_CID_HUE_AUTO, 0},
    {V4L2_CID_CHROMA_AGC, 0},
    {V4L2_CID_BACKLIGHT_COMPENSATION, 0},
    {V4L2_CID_WIDE_DYNAMIC_RANGE, 0},
    {V4L2_CID_IMAGE_STABILIZATION, 0},
    {V4L2_CID_ISO_SENSITIVITY_AUTO, V4L2_ISO_SENSITIVITY_MANUAL},
    {V4L2_CID_SCENE_MODE, V4L2_SCENE_MODE_NONE},
};

static bool is_button(const struct v4l2_query_ext_ctrl *q)
{
    return q->type == V4L2_CTRL_TYPE_BUTTON;
}

static int switch_off(struct v4l2_controls *c, struct ttf_err *err)
{
    for (unsigned i = 0; i < TTF_COUNT_OF(AUTOMATICS); i++) {
        struct v4l2_query_ext_ctrl q;
        int64_t value = 0, off;
        int r = v4l2_control_query(c, AUTOMATICS[i].id, &q);

        if (r == -ENODEV)
            return ttf_err_set(err, r, NULL, "the camera is gone");
        if (r < 0 || (q.flags & V4L2_CTRL_FLAG_READ_ONLY) || is_button(&q))
            continue;
        /* Some cameras know no off of a compensation, only its least. */
        off = q.minimum > AUTOMATICS[i].off ? q.minimum : AUTOMATICS[i].off;
        r = v4l2_control_set(c, q.id, off);
        if (r == 0)
            r = v4l2_control_get(c, q.id, &value);
        if (r < 0 || value != off)
            return ttf_err_set(err, r < 0 ? r : -EIO, q.name,
                               "this automatic cannot be switched off");
        c->automatics_off++;
    }
    return 0;
}

/* Manual, or the mode in which at least the time is ours. */
static int exposure_by_hand(struct v4l2_controls *c, struct ttf_err *err)
{
    static const int32_t MODES[] = {V4L2_EXPOSURE_MANUAL, V4L2_EXPOSURE_SHUTTER_PRIORITY};
    struct v4l2_query_ext_ctrl q;

    if (v4l2_control_query(c, V4L2_CID_EXPOSURE_AUTO, &q) < 0)
        return 0;
    for (unsigned i = 0; i < TTF_COUNT_OF(MODES); i++) {
        int64_t value = -1;

        if (v4l2_control_set(c, q.id, MODES[i]) == 0 && v4l2_control_get(c, q.id, &value) == 0 &&
            value == MODES[i]) {
            c->automatics_off++;
            return 0;
        }
    }
    ttf_err_set(err, -ENOTSUP, q.name, "the camera's exposure is automatic and cannot be locked");
    ttf_err_hint(err, "pictures whose exposure wanders cannot be compared: take another camera");
    return -ENOTSUP;
}

static void find_dial(struct v4l2_controls *c, uint32_t id, struct v4l2_dial *dial)
{
    struct v4l2_query_ext_ctrl q;

    memset(dial, 0, sizeof(*dial));
    if (v4l2_control_query(c, id, &q) < 0 || (q.flags & V4L2_CTRL_FLAG_READ_ONLY) ||
        q.minimum < INT32_MIN || q.maximum > INT32_MAX || q.maximum < q.minimum)
        return;
    dial->id = id;
    dial->min = (int32_t)q.minimum;
    dial->max = (int32_t)q.maximum;
    dial->step = q.step > 0 && q.step < INT32_MAX ? (int32_t)q.step : 1;
}

/* Sensors expose in lines, whose time follows from the pixel clock and what is blanked of a line. */
int64_t v4l2_controls_line_ns(const struct v4l2_controls *c, uint32_t width)
{
    int64_t rate = 0, blank = 0;

    if (v4l2_control_get(c, V4L2_CID_PIXEL_RATE, &rate) < 0 || rate <= 0 ||
        v4l2_control_get(c, V4L2_CID_HBLANK, &blank) < 0 || blank < 0 || blank > 1000000)
        return 0;
    return ((int64_t)width + blank) * TTF_NS_PER_S / rate;
}

/* A camera that keeps its rate exposes no longer than a frame, whatever its control takes and reads back. */
static void keep_within(struct v4l2_controls *c, int64_t period_ns)
{
    struct v4l2_query_ext_ctrl q;
    int64_t most = c->exposure_unit_ns > 0 ? period_ns / c->exposure_unit_ns : 0;

    if (v4l2_control_query(c, V4L2_CID_EXPOSURE_AUTO_PRIORITY, &q) == 0 && most < c->exposure.max &&
        most >= c->exposure.min)
        c->exposure.max = (int32_t)most;
}

static void find_exposure(struct v4l2_controls *c, uint32_t width, int64_t period_ns)
{
    find_dial(c, V4L2_CID_EXPOSURE_ABSOLUTE, &c->exposure);
    c->exposure_unit_ns = ABSOLUTE_NS;
    if (!c->exposure.id) {
        find_dial(c, V4L2_CID_EXPOSURE, &c->exposure);
        c->exposure_unit_ns = c->exposure.id ? v4l2_controls_line_ns(c, width) : 0;
    }
    /* An exposure in units that nobody tells is none that can be asked for. */
    if (c->exposure_unit_ns <= 0 || c->exposure.max <= 0)
        memset(&c->exposure, 0, sizeof(c->exposure));
    if (c->exposure.id && c->exposure.min < 1)
        c->exposure.min = 1;
    if (c->exposure.id) {
        keep_within(c, period_ns);
        c->has |= TTF_V4L2_EXPOSURE;
        c->mapped |= TTF_V4L2_EXPOSURE;
    }
}

/* A dial that no unit makes a capability of stays where it is: at its driver's default, or at its least. */
static int fix(struct v4l2_controls *c, struct v4l2_dial *dial, bool least, struct ttf_err *err)
{
    struct v4l2_query_ext_ctrl q;
    int r = v4l2_control_query(c, dial->id, &q);

    if (r == 0)
        r = v4l2_control_set(c, dial->id, least ? q.minimum : q.default_value);
    memset(dial, 0, sizeof(*dial));
    return r < 0 ? ttf_err_set(err, r, q.name, "this control cannot be fixed") : 0;
}

static int find_gain(struct v4l2_controls *c, struct ttf_err *err)
{
    find_dial(c, V4L2_CID_ANALOGUE_GAIN, &c->gain);
    if (!c->gain.id)
        find_dial(c, V4L2_CID_GAIN, &c->gain);
    if (!c->gain.id)
        return 0;
    c->has |= TTF_V4L2_GAIN;
    if (c->gain_unity == 0)
        return fix(c, &c->gain, true, err);
    c->mapped |= TTF_V4L2_GAIN;
    return 0;
}

static int find_balance(struct v4l2_controls *c, const struct ttf_v4l2_config *config,
                        struct ttf_err *err)
{
    struct v4l2_dial kelvin;
    int r = 0;

    find_dial(c, V4L2_CID_RED_BALANCE, &c->red);
    find_dial(c, V4L2_CID_BLUE_BALANCE, &c->blue);
    find_dial(c, V4L2_CID_WHITE_BALANCE_TEMPERATURE, &kelvin);
    if (c->red.id && c->blue.id)
        c->has |= TTF_V4L2_BALANCE;
    if (kelvin.id)
        c->has |= TTF_V4L2_TEMPERATURE;
    if (config->white_balance_kelvin > 0) {
        r = v4l2_control_fix(c, "white_balance_temperature", V4L2_CID_WHITE_BALANCE_TEMPERATURE,
                             config->white_balance_kelvin, err);
    } else if (kelvin.id) {
        r = fix(c, &kelvin, false, err);
    }
    if (r == 0 && c->red.id && c->blue.id && c->balance_unity > 0) {
        c->mapped |= TTF_V4L2_BALANCE;
        return 0;
    }
    if (r == 0 && c->red.id)
        r = fix(c, &c->red, false, err);
    if (r == 0 && c->blue.id)
        r = fix(c, &c->blue, false, err);
    return r;
}

/* The nearest code that the dial takes. */
static int32_t code_of(const struct v4l2_dial *dial, int64_t wanted)
{
    int64_t steps;

    if (wanted <= dial->min)
        return dial->min;
    if (wanted > dial->max)
        wanted = dial->max;
    steps = (wanted - dial->min + dial->step / 2) / dial->step;
    if (dial->min + steps * dial->step > dial->max)
        steps--;
    return (int32_t)(dial->min + steps * dial->step);
}

/*
 * Without a unit it is left where a person put it; but a camera that was unplugged comes back with the lens where its
 * maker wants it, and a run whose picture changes so is spoilt.
 */
static int put_lens_back(struct v4l2_controls *c, struct ttf_err *err)
{
    struct v4l2_dial lens;

    if (!c->keep_lens || !c->lens_held)
        return 0;
    find_dial(c, V4L2_CID_FOCUS_ABSOLUTE, &lens);
    if (!lens.id)
        return ttf_err_set(err, -EIO, "focus_absolute", "the camera came back without its lens");
    /* Where a person put it may lie between two that the driver takes. */
    return v4l2_control_fix(c, "focus_absolute", lens.id, code_of(&lens, c->lens_code), err);
}

/* After all that is fixed: a board may name focus_absolute. */
static void note_lens(struct v4l2_controls *c)
{
    c->lens_held = (c->has & TTF_V4L2_FOCUS) && !(c->mapped & TTF_V4L2_FOCUS) &&
                   v4l2_control_get(c, V4L2_CID_FOCUS_ABSOLUTE, &c->lens_code) == 0;
}

static void find_focus(struct v4l2_controls *c)
{
    find_dial(c, V4L2_CID_FOCUS_ABSOLUTE, &c->focus);
    if (!c->focus.id)
        return;
    c->has |= TTF_V4L2_FOCUS;
    if (c->focus_per_dioptre > 0)
        c->mapped |= TTF_V4L2_FOCUS;
    else
        memset(&c->focus, 0, sizeof(c->focus));
}

static int fix_flicker(struct v4l2_controls *c, enum ttf_v4l2_flicker flicker, struct ttf_err *err)
{
    static const int32_t CODES[] = {V4L2_CID_POWER_LINE_FREQUENCY_DISABLED,
                                    V4L2_CID_POWER_LINE_FREQUENCY_50HZ,
                                    V4L2_CID_POWER_LINE_FREQUENCY_60HZ};
    struct v4l2_query_ext_ctrl q;
    int r;

    if (v4l2_control_query(c, V4L2_CID_POWER_LINE_FREQUENCY, &q) < 0)
        return flicker == TTF_V4L2_FLICKER_OFF
                   ? 0
                   : ttf_err_set(err, -EINVAL, "flicker", "the camera has no such control");
    c->has |= TTF_V4L2_FLICKER;
    r = v4l2_control_fix(c, q.name, q.id, CODES[flicker], err);
    /* Some have no "disabled": then the mains' own, whose half-periods exposures are to be whole ones of anyway. */
    if ((r == -EINVAL || r == -ERANGE) && flicker == TTF_V4L2_FLICKER_OFF)
        ttf_err_hint(err, "its anti-flicker cannot be off: write 'flicker: 50Hz' (or 60Hz, "
                          "whichever the mains has) at the camera in the board's file");
    return r;
}

int v4l2_controls_set_up(struct v4l2_controls *c, const struct ttf_v4l2_config *config,
                         uint32_t width, int64_t period_ns, struct ttf_err *err)
{
    int r;

    c->has = c->mapped = c->automatics_off = 0;
    c->gain_unity = config->gain_unity;
    c->balance_unity = config->balance_unity;
    c->focus_per_dioptre = config->focus_per_dioptre;
    r = exposure_by_hand(c, err);
    if (r == 0)
        r = switch_off(c, err);
    if (r == 0)
        r = fix_flicker(c, config->flicker, err);
    if (r < 0)
        return r;
    find_exposure(c, width, period_ns);
    r = find_gain(c, err);
    if (r == 0)
        r = find_balance(c, config, err);
    find_focus(c);
    if (r == 0)
        r = put_lens_back(c, err);
    for (unsigned i = 0; i < config->n_controls && r == 0; i++)
        r = v4l2_control_fix_named(c, &config->controls[i], err);
    if (r == 0)
        note_lens(c);
    return r;
}

/* ---- settings ---- */

static uint32_t milli_of(int64_t code, uint32_t unity)
{
    return code <= 0 ? 0 : (uint32_t)((code * 1000 + unity / 2) / unity);
}

void v4l2_controls_caps(const struct v4l2_controls *c, struct ttf_camera_caps *caps)
{
    caps->exposure_min_ns = c->exposure.id ? c->exposure.min * c->exposure_unit_ns : 0;
    caps->exposure_max_ns = c->exposure.id ? c->exposure.max * c->exposure_unit_ns : 0;
    caps->gain_min_milli = c->gain.id ? milli_of(c->gain.min, c->gain_unity) : 0;
    caps->gain_max_milli = c->gain.id ? milli_of(c->gain.max, c->gain_unity) : 0;
    caps->has_white_balance = c->mapped & TTF_V4L2_BALANCE;
    caps->has_lens = c->mapped & TTF_V4L2_FOCUS;
    caps->lens_held = c->lens_held;
    caps->lens_code = c->lens_held ? c->lens_code : 0;
}

/* The code of what is asked for in thousandths of a unit. */
static int32_t code_of_milli(const struct v4l2_dial *dial, uint32_t milli, uint32_t unity)
{
    return code_of(dial, ((int64_t)milli * unity + 500) / 1000);
}

static int32_t code_of_exposure(const struct v4l2_controls *c, int64_t ns)
{
    return code_of(&c->exposure, (ns + c->exposure_unit_ns / 2) / c->exposure_unit_ns);
}

static int turn(const struct v4l2_controls *c, const struct v4l2_dial *dial, uint32_t milli,
                uint32_t unity)
{
    return v4l2_control_set(c, dial->id, code_of_milli(dial, milli, unity));
}

int v4l2_controls_apply(const struct v4l2_controls *c, const struct ttf_exposure *asked)
{
    int r = 0;

    if (c->exposure.id)
        r = v4l2_control_set(c, c->exposure.id, code_of_exposure(c, asked->exposure_ns));
    if (r == 0 && c->gain.id)
        r = turn(c, &c->gain, asked->gain_milli, c->gain_unity);
    if (r == 0 && (c->mapped & TTF_V4L2_BALANCE))
        r = turn(c, &c->red, asked->wb_r_milli, c->balance_unity);
    if (r == 0 && (c->mapped & TTF_V4L2_BALANCE))
        r = turn(c, &c->blue, asked->wb_b_milli, c->balance_unity);
    if (r == 0 && c->focus.id)
        r = turn(c, &c->focus, asked->lens_mdpt, c->focus_per_dioptre);
    return r;
}

static uint32_t meant_milli(const struct v4l2_dial *dial, uint32_t milli, uint32_t unity)
{
    return milli_of(code_of_milli(dial, milli, unity), unity);
}

void v4l2_controls_meant(const struct v4l2_controls *c, const struct ttf_exposure *asked,
                         struct ttf_exposure *ret)
{
    *ret = (struct ttf_exposure){0};
    if (c->exposure.id)
        ret->exposure_ns = code_of_exposure(c, asked->exposure_ns) * c->exposure_unit_ns;
    if (c->gain.id)
        ret->gain_milli = meant_milli(&c->gain, asked->gain_milli, c->gain_unity);
    if (c->mapped & TTF_V4L2_BALANCE) {
        ret->wb_r_milli = meant_milli(&c->red, asked->wb_r_milli, c->balance_unity);
        ret->wb_b_milli = meant_milli(&c->blue, asked->wb_b_milli, c->balance_unity);
    }
    if (c->focus.id)
        ret->lens_mdpt = meant_milli(&c->focus, asked->lens_mdpt, c->focus_per_dioptre);
}

static int read_milli(const struct v4l2_controls *c, uint32_t id, uint32_t unity, uint32_t *ret)
{
    int64_t value = 0;
    int r = v4l2_control_get(c, id, &value);

    if (r == 0)
        *ret = milli_of(value, unity);
    return r;
}

int v4l2_controls_read(const struct v4l2_controls *c, struct ttf_exposure *ret)
{
    struct ttf_exposure found = {0};
    int64_t value = 0;
    int r = 0;

    if (c->exposure.id) {
        r = v4l2_control_get(c, c->exposure.id, &value);
        found.exposure_ns = value * c->exposure_unit_ns;
    }
    if (r == 0 && c->gain.id)
        r = read_milli(c, c->gain.id, c->gain_unity, &found.gain_milli);
    if (r == 0 && (c->mapped & TTF_V4L2_BALANCE))
        r = read_milli(c, c->red.id, c->balance_unity, &found.wb_r_milli);
    if (r == 0 && (c->mapped & TTF_V4L2_BALANCE))
        r = read_milli(c, c->blue.id, c->balance_unity, &found.wb_b_milli);
    if (r == 0 && c->focus.id)
        r = read_milli(c, c->focus.id, c->focus_per_dioptre, &found.lens_mdpt);
    if (r == 0)
        *ret = found;
    return r;
}
