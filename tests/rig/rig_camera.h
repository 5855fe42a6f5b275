/* SPDX-License-Identifier: Apache-2.0 */
/* rig_camera.h: a V4L2 camera on the kernel's test driver (vivid), with a hand on its own descriptor. */
#ifndef TTF_TESTS_RIG_CAMERA_H
#define TTF_TESTS_RIG_CAMERA_H

#include "sys.h"

/* Controls of drivers/media/test-drivers/vivid/vivid-ctrls.c. */
#define VIVID_DROPPED    0x00f0f040u /* of 100 buffers */
#define VIVID_DISCONNECT 0x00f0f041u
#define VIVID_ERROR_FLAG 0x00f0f042u
#define VIVID_REQBUFS    0x00f0f043u
#define VIVID_QBUF       0x00f0f044u
#define VIVID_STREAMON   0x00f0f045u
#define VIVID_FATAL      0x00f0f046u

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

/* One of vivid's faults set in another process; its number, and when, in ns of the boot clock, are read from standard input. 0: set. */
int rig_inject(const char *name);

/* So many slots, and what they leave behind. */
int rig_soak(unsigned slots);

#endif
