/* SPDX-License-Identifier: Apache-2.0 */
/* rig_camera.h: a V4L2 camera on the kernel's test driver (vivid), with a hand on its own descriptor. */
#ifndef TTF_TESTS_RIG_CAMERA_H
#define TTF_TESTS_RIG_CAMERA_H

#include "sys.h"

/* The kernel's table, but for open, which remembers the descriptor: vivid's faults are set through it. */
extern const struct v4l2_sys rig_sys;

/* Sets a control of the camera that is open; 0 or a negative errno. */
int rig_set(uint32_t id, int value);

/* The camera for a pixel format, 320 x 180, 25 a second; or the webcam of rig_uvc, 10 a second. */
int rig_camera(const char *pixel_format, struct ttf_clock *clock, struct ttf_camera **ret,
               struct ttf_err *err);

/* What a board's file would say of the webcam of rig_uvc. */
void rig_uvc_config(struct ttf_v4l2_config *config);

/* "EXPOSURE_US:GAIN_MILLI,...": each asked for, one frame taken, a line of what was granted and of the picture's mean. 0: all came. */
int rig_settings(const char *list);

/* Slots, one of which goes wrong in the named way. 0: as promised. */
int rig_case(const char *name);

/* So many slots, and what they leave behind. */
int rig_soak(unsigned slots);

#endif
