/* SPDX-License-Identifier: Apache-2.0 */
/* rig_uvc.h: a webcam that the rig's guest is to itself: what it answers, what it photographs. */
#ifndef TTF_TESTS_RIG_UVC_H
#define TTF_TESTS_RIG_UVC_H

#include <linux/types.h>
#include <linux/usb/g_uvc.h>
#include <stdbool.h>
#include <stdint.h>

#define RIG_UVC_CONTROLS 10

/* Codes, in UVC's own units: what a frame is taken with. */
struct rig_uvc_light {
    int exposure; /* 0.1 ms */
    int gain;     /* 64: 1.0 */
    int kelvin;
    int brightness;
};

struct rig_uvc_control {
    const char *name;
    uint8_t unit, selector, size;
    int min, max, res, def;
    const char *automatic; /* the control that must be off for this one to be set */
    int cur;
    unsigned stalls; /* of so many requests to come */
};

struct rig_uvc_controls {
    struct rig_uvc_control control[RIG_UVC_CONTROLS];
    bool silent;         /* does not say that values may change by themselves */
    uint8_t error;       /* why the last request was stalled */
    uint8_t stall_error; /* what stalls say */
    int grants_permille; /* of an exposure that is asked for, it takes and tells this part */
    int rounds;          /* ... of which it makes a multiple of this, 0.1 ms */
    int hides_permille;  /* frames are exposed by this part of what it tells */
    bool sticks;         /* exposure stays automatic, whatever it is told */
    unsigned wander_in;  /* so many frames more, and ... */
    int wander_to;       /* ... the exposure becomes this */
    unsigned frames;
};

/* As after power-on: everything automatic. */
void rig_uvc_controls_reset(struct rig_uvc_controls *c, bool silent);

/* A request to the control interface; ret->length < 0: a stall. A request with data is accepted by its length, and set when they are there. */
void rig_uvc_controls_answer(struct rig_uvc_controls *c, const struct usb_ctrlrequest *asked,
                             struct uvc_request_data *ret);
void rig_uvc_controls_set(struct rig_uvc_controls *c, const struct usb_ctrlrequest *asked,
                          const struct uvc_request_data *data);

/* What the next frame is taken with; automatics move it. */
struct rig_uvc_light rig_uvc_controls_light(struct rig_uvc_controls *c, int frame_100us);

/*
 * A fault, as a line: "grants 900", "rounds 50", "hides 900", "wanders FRAMES TO", "stalls NAME TIMES ERROR", "sticks 1",
 * "hiccups" (all as after power-on). false: there is none of this name.
 */
bool rig_uvc_controls_fault(struct rig_uvc_controls *c, const char *line);

/* A picture of this light, YUYV: a gradient from half to the whole of it, coded as sRGB. */
void rig_uvc_picture(const struct rig_uvc_light *light, unsigned width, unsigned height,
                     uint8_t *ret);

/* The mean of such a picture by light, with that of an exposure of 100 ms at gain 1.0 as 1. */
double rig_uvc_mean(const uint8_t *yuyv, unsigned width, unsigned height, unsigned stride);

#endif
