/* SPDX-License-Identifier: Apache-2.0 */
/*
 * sensors.h: what the box feels. One thread at a time.
 */
#ifndef TTF_HAL_SENSORS_H
#define TTF_HAL_SENSORS_H

#include <stdbool.h>
#include <stdint.h>

#include "ttf/base/attr.h"
#include "ttf/base/err.h"

#define TTF_SENSORS_MAX 16

struct ttf_sensors;

/* The unit is part of the kind; values are integers in it. */
enum ttf_sensor_kind {
    TTF_SENSOR_TEMP_MDEGC = 0, /* thousandths of a degree Celsius */
    TTF_SENSOR_HUMIDITY_MPCT,  /* thousandths of a per cent relative humidity */
    TTF_SENSOR_LIGHT_PERMILLE, /* photodiode, relative to the reference lamp state */
    TTF_SENSOR_PRESSURE_PA,
    TTF_SENSOR_UNDERVOLTAGE, /* 1: the supply was too low since the last look; else 0 */
    TTF_SENSOR_KIND_COUNT
};

/* "temp_mdegc", "humidity_mpct", "light_permille", "pressure_pa", "undervoltage". */
const char *ttf_sensor_kind_name(enum ttf_sensor_kind kind);

struct ttf_reading {
    char name[32]; /* [a-z0-9-], unique on the board */
    enum ttf_sensor_kind kind;
    bool ok; /* false: no answer, or one that cannot be; value is then 0 and means nothing */
    int64_t value;
    int64_t at_ns; /* boot clock; what was measured is not older, however long its driver took */
};

/*
 * Reads all sensors now. Returns how many readings were written to ret[], at
 * most TTF_SENSORS_MAX, also for sensors that did not answer; a negative errno
 * only if none can be asked at all. A back-end that knows why a sensor is not ok says it in *err, of the
 * first of them, whose name is `where`, and returns the count all the same (code is 0 where there is nothing to say).
 */
TTF_MUST_USE int ttf_sensors_read(struct ttf_sensors *sensors,
                                  struct ttf_reading ret[TTF_SENSORS_MAX], struct ttf_err *err);

/* NULL allowed. */
void ttf_sensors_destroy(struct ttf_sensors *sensors);

/* --- for authors of back-ends: all ops mandatory, struct embedded first --- */
struct ttf_sensors_ops {
    const char *name;
    int (*read)(struct ttf_sensors *sensors, struct ttf_reading ret[TTF_SENSORS_MAX],
                struct ttf_err *err);
    void (*destroy)(struct ttf_sensors *sensors);
};

struct ttf_sensors {
    const struct ttf_sensors_ops *ops;
};

#endif
