/* SPDX-License-Identifier: Apache-2.0 */
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "box_private.h"
#include "ttf/base/time.h"

struct sim_sensors {
    struct ttf_sensors base;
    struct sim_box *box;
};

/* 55 % at 22 degC; the air's water stays, so warmer air is relatively drier (6 % of it a degree). */
static double humidity_pct(double degc)
{
    return fmin(100.0, 55.0 * exp(-0.06 * (degc - 22.0)));
}

/* Weather that comes and goes in three days. */
static double pressure_pa(double elapsed_s)
{
    return 101325.0 + 400.0 * sin(elapsed_s * (6.283185307179586 / (3.0 * 86400.0)));
}

static double brightness(struct sim_box *box, int64_t elapsed)
{
    double sum = sim_light_ambient(&box->light, elapsed), strength = 0.0;

    for (unsigned i = 0; i < box->config.n_lamps; i++) {
        sum += box->config.lamps[i].strength * sim_light_lamp(&box->light, i, elapsed);
        strength += box->config.lamps[i].strength;
    }
    return strength > 0.0 ? sum / strength : sum;
}

int64_t sim_sensor_value(struct sim_box *box, unsigned i, int64_t boot_ns)
{
    int64_t elapsed = sim_box_elapsed(box, boot_ns);
    double degc = sim_light_temp_degc(&box->light, elapsed);

    switch (box->config.sensors[i].kind) {
    case TTF_SENSOR_TEMP_MDEGC:
        return llround(degc * 100.0) * 10; /* hundredths of a degree, as such sensors resolve */
    case TTF_SENSOR_HUMIDITY_MPCT:
        return llround(humidity_pct(degc) * 10.0) * 100;
    case TTF_SENSOR_LIGHT_PERMILLE:
        return llround(1000.0 * brightness(box, elapsed));
    case TTF_SENSOR_PRESSURE_PA:
        return llround(pressure_pa((double)elapsed / (double)TTF_NS_PER_S));
    default:
        return 0;
    }
}

static int sensors_read(struct ttf_sensors *base, struct ttf_reading ret[TTF_SENSORS_MAX],
                        struct ttf_err *err)
{
    struct sim_box *box = ((struct sim_sensors *)base)->box;
    int64_t now;

    if (sim_world_enter(box) < 0)
        return ttf_err_set(err, -ENODEV, "sensors", "the simulated box has lost power");
    now = box->world_ns;
    for (unsigned i = 0; i < box->config.n_sensors; i++) {
        struct ttf_reading *r = &ret[i];

        snprintf(r->name, sizeof(r->name), "%s", box->config.sensors[i].name);
        r->kind = box->config.sensors[i].kind;
        r->ok = !sim_fault_on_sensor(&box->faults, i, sim_box_elapsed(box, now));
        r->value = r->ok ? sim_sensor_value(box, i, now) : 0;
        r->at_ns = now;
    }
    sim_world_leave(box);
    return (int)box->config.n_sensors;
}

static void sensors_destroy(struct ttf_sensors *base)
{
    free(base);
}

static const struct ttf_sensors_ops sim_sensors_ops = {
    .name = "sim", .read = sensors_read, .destroy = sensors_destroy};

struct ttf_sensors *sim_sensors_create(struct sim_box *box)
{
    struct sim_sensors *sensors = calloc(1, sizeof(*sensors));

    if (!sensors)
        return NULL;
    sensors->base.ops = &sim_sensors_ops;
    sensors->box = box;
    return &sensors->base;
}
