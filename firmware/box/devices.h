/* SPDX-License-Identifier: Apache-2.0 */
/* devices.h: real devices by their back-end's name. Each gives its device, or an error in words for whoever built the box. */
#ifndef FIRMWARE_BOX_DEVICES_H
#define FIRMWARE_BOX_DEVICES_H

#include "box.h"

TTF_MUST_USE int box_make_camera(const struct ttf_board_camera *camera, struct ttf_clock *clock,
                                 struct ttf_camera **ret, struct ttf_err *err);
TTF_MUST_USE int box_make_lamps(const struct ttf_board *board, struct ttf_clock *clock,
                                struct ttf_lamps **ret, struct ttf_err *err);
TTF_MUST_USE int box_make_sensors(const struct ttf_board *board, const struct box_host *host,
                                  struct ttf_clock *clock, struct ttf_sensors **ret,
                                  struct ttf_err *err);
/* lamps: NULL allowed; the door is their guardian's. */
TTF_MUST_USE int box_make_panel(const struct ttf_board *board, struct ttf_clock *clock,
                                struct ttf_lamps *lamps, struct ttf_panel **ret,
                                struct ttf_err *err);
/* *ret stays NULL, and 0, for a service manager's watchdog where no manager watches this process. */
TTF_MUST_USE int box_make_watchdog(const struct ttf_board *board, const struct box_host *host,
                                   struct ttf_watchdog **ret, struct ttf_err *err);

/*
 * The machine's serial, letters and digits, at most 32, as it has it on USB too: what a person wrote (/etc/ttfbox/usb-serial), else what its
 * firmware tells, else one made from the machine's id. Where there is none of these, its name in the network, or "".
 */
void box_host_serial(const struct box_host *host, char ret[64]);

/* ---- hardware.c, or hardware_none.c of a build without a box ---- */

TTF_MUST_USE int box_gpiod_lines(const struct ttf_line_spec *specs, unsigned n,
                                 struct ttf_lines **ret, struct ttf_err *err);
/* As ttf_lines_gpiod_holder. */
TTF_MUST_USE int box_gpiod_holder(const struct ttf_line_spec *spec, char ret_holder[64],
                                  struct ttf_err *err);
TTF_MUST_USE int box_v4l2_camera(const struct ttf_v4l2_config *config, struct ttf_clock *clock,
                                 struct ttf_camera **ret, struct ttf_err *err);
TTF_MUST_USE int box_libcamera_camera(const struct ttf_libcamera_config *config,
                                      struct ttf_clock *clock, struct ttf_camera **ret,
                                      struct ttf_err *err);

#endif
