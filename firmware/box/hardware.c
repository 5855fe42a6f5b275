/* SPDX-License-Identifier: Apache-2.0 */
/* hardware.c: back-ends that need a box's libraries or kernel. */
#include "devices.h"
#include "ttf/hal/gpiod.h"

int box_gpiod_lines(const struct ttf_line_spec *specs, unsigned n, struct ttf_lines **ret,
                    struct ttf_err *err)
{
    return ttf_lines_gpiod_create(specs, n, ret, err);
}

int box_gpiod_holder(const struct ttf_line_spec *spec, char ret_holder[64], struct ttf_err *err)
{
    return ttf_lines_gpiod_holder(spec, ret_holder, err);
}

int box_v4l2_camera(const struct ttf_v4l2_config *config, struct ttf_clock *clock,
                    struct ttf_camera **ret, struct ttf_err *err)
{
    return ttf_v4l2_camera_create(config, clock, ret, err);
}

int box_libcamera_camera(const struct ttf_libcamera_config *config, struct ttf_clock *clock,
                         struct ttf_camera **ret, struct ttf_err *err)
{
    return ttf_libcamera_camera_create(config, clock, ret, err);
}
