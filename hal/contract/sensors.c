/* SPDX-License-Identifier: Apache-2.0 */
#include "ttf/hal/sensors.h"

#include <stddef.h>

const char *ttf_sensor_kind_name(enum ttf_sensor_kind kind)
{
    static const char *const names[TTF_SENSOR_KIND_COUNT] = {
        "temp_mdegc", "humidity_mpct", "light_permille", "pressure_pa", "undervoltage"};

    return (unsigned)kind < TTF_SENSOR_KIND_COUNT ? names[kind] : "unknown";
}

int ttf_sensors_read(struct ttf_sensors *sensors, struct ttf_reading ret[TTF_SENSORS_MAX],
                     struct ttf_err *err)
{
    return sensors->ops->read(sensors, ret, err);
}

void ttf_sensors_destroy(struct ttf_sensors *sensors)
{
    if (sensors)
        sensors->ops->destroy(sensors);
}
