/* SPDX-License-Identifier: Apache-2.0 */
/* hardware_none.c: a build without a box (TTFBOX_BOX=OFF): a PC's tools alone. */
#include <errno.h>

#include "devices.h"

static int none(const char *backend, struct ttf_err *err)
{
    ttf_err_set(err, -ENOTSUP, NULL, "back-end '%s' is not built in", backend);
    ttf_err_hint(err, "this is a build without a box: configure with -DTTFBOX_BOX=ON");
    return -ENOTSUP;
}

int box_gpiod_lines(const struct ttf_line_spec *specs, unsigned n, struct ttf_lines **ret,
                    struct ttf_err *err)
{
    return none("gpiod", err);
}

int box_gpiod_holder(const struct ttf_line_spec *spec, char ret_holder[64], struct ttf_err *err)
{
    return none("gpiod", err);
}

int box_v4l2_camera(const struct ttf_v4l2_config *config, struct ttf_clock *clock,
                    struct ttf_camera **ret, struct ttf_err *err)
{
    return none("v4l2", err);
}

int box_libcamera_camera(const struct ttf_libcamera_config *config, struct ttf_clock *clock,
                         struct ttf_camera **ret, struct ttf_err *err)
{
    return none("libcamera", err);
}
