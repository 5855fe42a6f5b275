/* SPDX-License-Identifier: Apache-2.0 */
/*
 * sysfs.h: sensors that kernel drivers show under /sys: hwmon (temp1_input, humidity1_input) and IIO
 * (in_temp_input, or raw, offset and scale, the latter two of the channel or, where it has none, of its type: in_temp_scale of
 * in_temp_object). Counts without a scale are not ok, but of light, which is a share of the board's own number. As the kernel's Documentation/hwmon/sysfs-interface and
 * Documentation/ABI/testing/sysfs-bus-iio have them.
 */
#ifndef TTF_HAL_SYSFS_H
#define TTF_HAL_SYSFS_H

#include "ttf/base/attr.h"
#include "ttf/base/err.h"
#include "ttf/hal/clock.h"
#include "ttf/hal/sensors.h"

enum ttf_sysfs_bus {
    TTF_SYSFS_HWMON = 0,
    TTF_SYSFS_IIO
};

struct ttf_sysfs_sensor {
    char name[32]; /* the box's word for it, [a-z0-9-] */
    enum ttf_sensor_kind kind;
    enum ttf_sysfs_bus bus;
    char device
        [64]; /* what its driver calls it: "bme280", "cpu_thermal"; of several the lowest number */
    char channel[64]; /* "temp1", "in_temp"; empty: the kind's usual one */
    double full;      /* of TTF_SENSOR_LIGHT_PERMILLE: the driver's value that is 1000; > 0 */
};

/*
 * root: "/sys", or a folder laid out like it. A device that is not there now may come later: its readings are
 * not ok until then; one that is not where it was is looked for anew, one that fails is asked once. n in 1..TTF_SENSORS_MAX; specs are copied; the clock is borrowed. -EINVAL naming the sensor, -ENOMEM.
 * Reading allocates nothing but when a device has to be looked for.
 */
TTF_MUST_USE int ttf_sensors_sysfs_create(const char *root, const struct ttf_sysfs_sensor *specs,
                                          unsigned n, struct ttf_clock *clock,
                                          struct ttf_sensors **ret, struct ttf_err *err);

#endif
