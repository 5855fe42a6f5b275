/* SPDX-License-Identifier: Apache-2.0 */
/* registry.c: the back-ends that a board may name. A new one is a line here and one in box/. */
#include <string.h>

#include "ttf/base/attr.h"
#include "ttf/config/board_file.h"

#define ALL_DEVICES ((1u << TTF_DEVICE_KIND_COUNT) - 1)

static const struct ttf_backend_entry BACKENDS[] = {
    {"sim", ALL_DEVICES, "the simulated box"},
    {"v4l2", 1u << TTF_DEVICE_CAMERA, "a camera of the kernel's Video4Linux2"},
    {"libcamera", 1u << TTF_DEVICE_CAMERA, "a camera behind libcamera, as a Raspberry Pi's"},
    {"gpiod", 1u << TTF_DEVICE_LAMPS | 1u << TTF_DEVICE_PANEL,
     "lines of a GPIO chip; those of lamps are held by ttfbox-lampd"},
    {"file", 1u << TTF_DEVICE_LAMPS | 1u << TTF_DEVICE_PANEL, "wires in a file, for tests"},
    {"sysfs", 1u << TTF_DEVICE_SENSORS, "what kernel drivers show under /sys"},
    {"systemd", 1u << TTF_DEVICE_WATCHDOG, "the service manager"},
    {"device", 1u << TTF_DEVICE_WATCHDOG, "the machine's own watchdog"},
    {"machine", 1u << TTF_DEVICE_CLOCK, "the machine's own clock"},
};

const struct ttf_backend_entry *ttf_backend_entry(unsigned i)
{
    return i < TTF_COUNT_OF(BACKENDS) ? &BACKENDS[i] : NULL;
}

const struct ttf_backend_entry *ttf_backend_find(const char *name)
{
    for (unsigned i = 0; i < TTF_COUNT_OF(BACKENDS); i++)
        if (strcmp(BACKENDS[i].name, name) == 0)
            return &BACKENDS[i];
    return NULL;
}
