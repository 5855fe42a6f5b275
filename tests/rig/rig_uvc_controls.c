/* SPDX-License-Identifier: Apache-2.0 */
/* rig_uvc_controls.c: the webcam's controls, as the class's specification has them, and its faults. */
#include <linux/usb/video.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "rig_uvc.h"
#include "ttf/base/attr.h"

#define TERMINAL 1 /* as usb_f_uvc numbers them */
#define UNIT     2

#define AE_MANUAL   1
#define AE_APERTURE 8

/* Of UVC_VC_REQUEST_ERROR_CODE_CONTROL. */
#define ERROR_STATE   2
#define ERROR_CONTROL 6

static const struct rig_uvc_control AT_POWER_ON[RIG_UVC_CONTROLS] = {
    {.name = "mode",
     .unit = TERMINAL,
     .selector = UVC_CT_AE_MODE_CONTROL,
     .size = 1,
     .max = 255,
     .res = AE_MANUAL | AE_APERTURE,
     .def = AE_APERTURE},
    {.name = "priority",
     .unit = TERMINAL,
     .selector = UVC_CT_AE_PRIORITY_CONTROL,
     .size = 1,
     .max = 1,
     .res = 1,
     .def = 1},
    {.name = "exposure",
     .unit = TERMINAL,
     .selector = UVC_CT_EXPOSURE_TIME_ABSOLUTE_CONTROL,
     .size = 4,
     .min = 5,
     .max = 5000,
     .res = 5,
     .def = 250,
     .automatic = "mode"},
    {.name = "focus",
     .unit = TERMINAL,
     .selector = UVC_CT_FOCUS_ABSOLUTE_CONTROL,
     .size = 2,
     .max = 250,
     .res = 5,
     .def = 20,
     .automatic = "autofocus"},
    {.name = "autofocus",
     .unit = TERMINAL,
     .selector = UVC_CT_FOCUS_AUTO_CONTROL,
     .size = 1,
     .max = 1,
     .res = 1,
     .def = 1},
    {.name = "brightness",
     .unit = UNIT,
     .selector = UVC_PU_BRIGHTNESS_CONTROL,
     .size = 2,
     .min = -64,
     .max = 64,
     .res = 1},
    {.name = "gain",
     .unit = UNIT,
     .selector = UVC_PU_GAIN_CONTROL,
     .size = 2,
     .min = 16,
     .max = 255,
     .res = 1,
     .def = 32},
    {.name = "flicker",
     .unit = UNIT,
     .selector = UVC_PU_POWER_LINE_FREQUENCY_CONTROL,
     .size = 1,
     .max = 2,
     .res = 1,
     .def = 2},
    {.name = "kelvin",
     .unit = UNIT,
     .selector = UVC_PU_WHITE_BALANCE_TEMPERATURE_CONTROL,
     .size = 2,
     .min = 2800,
     .max = 6500,
     .res = 10,
     .def = 4600,
     .automatic = "autowhite"},
    {.name = "autowhite",
     .unit = UNIT,
     .selector = UVC_PU_WHITE_BALANCE_TEMPERATURE_AUTO_CONTROL,
     .size = 1,
     .max = 1,
     .res = 1,
     .def = 1},
};

static struct rig_uvc_control *named(struct rig_uvc_controls *c, const char *name)
{
    for (unsigned i = 0; i < RIG_UVC_CONTROLS; i++)
        if (strcmp(c->control[i].name, name) == 0)
            return &c->control[i];
    return NULL;
}

static bool is_automatic(struct rig_uvc_controls *c, const struct rig_uvc_control *of)
{
    const struct rig_uvc_control *by = of->automatic ? named(c, of->automatic) : NULL;

    return by && (strcmp(by->name, "mode") == 0 ? by->cur != AE_MANUAL : by->cur != 0);
}

static void power_on(struct rig_uvc_controls *c)
{
    memcpy(c->control, AT_POWER_ON, sizeof(c->control));
    for (unsigned i = 0; i < RIG_UVC_CONTROLS; i++)
        c->control[i].cur = c->control[i].def;
}

void rig_uvc_controls_reset(struct rig_uvc_controls *c, bool silent)
{
    *c = (struct rig_uvc_controls){
        .silent = silent, .grants_permille = 1000, .rounds = 1, .hides_permille = 1000};
    power_on(c);
}

/* ---- requests ---- */

static void put(struct uvc_request_data *ret, int value, unsigned size)
{
    ret->length = (int)size;
    for (unsigned i = 0; i < size; i++)
        ret->data[i] = (uint8_t)((uint32_t)value >> (8 * i));
}

static void stall(struct rig_uvc_controls *c, uint8_t error, struct uvc_request_data *ret)
{
    c->error = error;
    ret->length = -1;
}

static struct rig_uvc_control *meant(struct rig_uvc_controls *c,
                                     const struct usb_ctrlrequest *asked)
{
    for (unsigned i = 0; i < RIG_UVC_CONTROLS; i++)
        if (c->control[i].unit == asked->wIndex >> 8 &&
            c->control[i].selector == asked->wValue >> 8)
            return &c->control[i];
    return NULL;
}

/* A setting may be asked for while the automatic is on, and is refused: as cameras do. */
static void answer_set(struct rig_uvc_controls *c, struct rig_uvc_control *control,
                       const struct usb_ctrlrequest *asked, struct uvc_request_data *ret)
{
    if (control->stalls > 0) {
        control->stalls--;
        printf("stalled %s\n", control->name);
        stall(c, c->stall_error, ret);
    } else if (is_automatic(c, control)) {
        stall(c, ERROR_STATE, ret);
    } else {
        ret->length = asked->wLength;
    }
}

/* A line of it, too: a driver that answers from memory does not come here. */
static void tell(const struct rig_uvc_control *control, struct uvc_request_data *ret)
{
    printf("told %s %d\n", control->name, control->cur);
    put(ret, control->cur, control->size);
}

static int info_of(const struct rig_uvc_controls *c, const struct rig_uvc_control *control)
{
    bool may_wander = control->automatic || strcmp(control->name, "gain") == 0;

    return UVC_CONTROL_CAP_GET | UVC_CONTROL_CAP_SET |
           (may_wander && !c->silent ? UVC_CONTROL_CAP_AUTOUPDATE : 0);
}

void rig_uvc_controls_answer(struct rig_uvc_controls *c, const struct usb_ctrlrequest *asked,
                             struct uvc_request_data *ret)
{
    struct rig_uvc_control *control = meant(c, asked);

    memset(ret, 0, sizeof(*ret));
    if (asked->wIndex >> 8 == 0 && asked->wValue >> 8 == UVC_VC_REQUEST_ERROR_CODE_CONTROL) {
        put(ret, asked->bRequest == UVC_GET_INFO ? UVC_CONTROL_CAP_GET : c->error, 1);
        return;
    }
    if (!control) {
        stall(c, ERROR_CONTROL, ret);
        return;
    }
    c->error = 0;
    if (asked->bRequest == UVC_SET_CUR)
        answer_set(c, control, asked, ret);
    else if (asked->bRequest == UVC_GET_CUR)
        tell(control, ret);
    else if (asked->bRequest == UVC_GET_MIN)
        put(ret, control->min, control->size);
    else if (asked->bRequest == UVC_GET_MAX)
        put(ret, control->max, control->size);
    else if (asked->bRequest == UVC_GET_RES)
        put(ret, control->res, control->size);
    else if (asked->bRequest == UVC_GET_DEF)
        put(ret, control->def, control->size);
    else if (asked->bRequest == UVC_GET_LEN)
        put(ret, control->size, 2);
    else if (asked->bRequest == UVC_GET_INFO)
        put(ret, info_of(c, control), 1);
    else
        stall(c, ERROR_CONTROL, ret);
}

void rig_uvc_controls_set(struct rig_uvc_controls *c, const struct usb_ctrlrequest *asked,
                          const struct uvc_request_data *data)
{
    struct rig_uvc_control *control = meant(c, asked);
    uint32_t bits = 0;
    int value;

    if (!control || data->length < control->size)
        return;
    for (unsigned i = 0; i < control->size; i++)
        bits |= (uint32_t)data->data[i] << (8 * i);
    value = control->min < 0 ? (int16_t)bits : (int)bits;
    printf("asked %s %d\n", control->name, value);
    if (strcmp(control->name, "exposure") == 0)
        value = (int)((long long)value * c->grants_permille / 1000) / c->rounds * c->rounds;
    if (strcmp(control->name, "mode") == 0 && c->sticks)
        value = AE_APERTURE;
    control->cur = value;
}

/* ---- light ---- */

struct rig_uvc_light rig_uvc_controls_light(struct rig_uvc_controls *c, int frame_100us)
{
    struct rig_uvc_control *exposure = named(c, "exposure"), *kelvin = named(c, "kelvin");
    struct rig_uvc_light light;

    c->frames++;
    if (c->wander_in > 0 && --c->wander_in == 0)
        exposure->cur = c->wander_to;
    if (is_automatic(c, exposure))
        exposure->cur = 250 + 50 * (int)(c->frames % 3);
    if (is_automatic(c, kelvin))
        kelvin->cur = 4600 + 200 * (int)(c->frames % 3);
    light = (struct rig_uvc_light){
        .exposure = (int)((long long)exposure->cur * c->hides_permille / 1000),
        .gain = named(c, "gain")->cur,
        .kelvin = kelvin->cur,
        .brightness = named(c, "brightness")->cur,
    };
    /* The frame rate stays: no exposure is longer than a frame. */
    if (light.exposure > frame_100us)
        light.exposure = frame_100us;
    return light;
}

/* n numbers, each behind a blank. */
static bool numbers(const char *text, unsigned n, int *ret)
{
    for (unsigned i = 0; i < n; i++) {
        char *rest;

        ret[i] = (int)strtol(text, &rest, 10);
        if (rest == text)
            return false;
        text = rest;
    }
    return true;
}

/* "WORD NUMBER..." */
static bool says(const char *line, const char *word, unsigned n, int *ret)
{
    const size_t length = strlen(word);

    return strncmp(line, word, length) == 0 && numbers(line + length, n, ret);
}

/* "stalls NAME TIMES ERROR" */
static bool stalls(struct rig_uvc_controls *c, const char *line)
{
    struct rig_uvc_control *control;
    char name[16];
    int used = 0, n[2];

    if (sscanf(line, "stalls %15s%n", name, &used) != 1 || !numbers(line + used, 2, n))
        return false;
    control = named(c, name);
    if (!control)
        return false;
    control->stalls = (unsigned)n[0];
    c->stall_error = (uint8_t)n[1];
    return true;
}

bool rig_uvc_controls_fault(struct rig_uvc_controls *c, const char *line)
{
    int n[2];

    if (says(line, "grants", 1, n))
        c->grants_permille = n[0];
    else if (says(line, "rounds", 1, n) && n[0] > 0)
        c->rounds = n[0];
    else if (says(line, "hides", 1, n))
        c->hides_permille = n[0];
    else if (says(line, "sticks", 1, n))
        c->sticks = n[0] != 0;
    else if (strncmp(line, "hiccups", 7) == 0)
        power_on(c);
    else if (says(line, "wanders", 2, n) && n[0] > 0) {
        c->wander_in = (unsigned)n[0];
        c->wander_to = n[1];
    } else
        return stalls(c, line);
    return true;
}
