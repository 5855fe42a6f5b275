/* SPDX-License-Identifier: Apache-2.0 */
/* Defaults of the simulated box, and the check of what a board's description says. */
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "faults.h"
#include "ttf/base/attr.h"
#include "ttf/base/time.h"
#include "ttf/hal/sim.h"

static struct ttf_sim_lamp default_lamp(const char *name, double x)
{
    struct ttf_sim_lamp lamp = {
        .info = {.kind = TTF_LAMP_PWM,
                 .max_on_ns = 60 * TTF_NS_PER_DAY,
                 .max_duty_permille = TTF_LAMP_FULL,
                 .duty_window_ns = TTF_NS_PER_DAY,
                 .max_temp_mdegc = 60000,
                 .hysteresis_mdegc = 5000,
                 .interlock_door = true,
                 .warm_up_ns = 5 * TTF_NS_PER_MIN},
        .x = x,
        .y = 0.5,
        .height = 1.2,
        .strength = 0.5,
        .cold_fraction = 0.85,
        .warm_tau_ns = TTF_NS_PER_MIN,
        .ageing_per_kh = 0.02,
        .ripple = 0.05,
        .colour = {1.0, 1.0, 1.0},
        .heat_degc = 6.0,
    };

    snprintf(lamp.info.name, sizeof(lamp.info.name), "%s", name);
    return lamp;
}

static void default_optics_and_sensor(struct ttf_sim_config *c)
{
    c->vignetting = 0.25;
    c->perspective = 0.02;
    c->blur_px = 0.7;
    c->margin = 0.05;
    c->margin_reflectance = 0.1;
    c->width = 1014;
    c->height = 760;
    c->bits = 12;
    c->black_level = 256;
    c->full_well_e = 15000;
    c->read_noise_e = 3;
    c->prnu = 0.006;
    c->dark_e_per_s = 2;
    c->dark_doubling_degc = 7;
    c->hot_fraction = 1e-4;
    c->hot_e_per_s = 2000;
    c->sensitivity_e = 322500; /* 20 ms: 43 % of the full well */
    c->channel_gain[0] = 0.55;
    c->channel_gain[1] = 1.0;
    c->channel_gain[2] = 0.65;
    c->noise = true;
}

static void default_timing(struct ttf_sim_config *c)
{
    c->exposure_min_ns = 25 * TTF_NS_PER_US;
    c->exposure_max_ns = 10 * TTF_NS_PER_S;
    c->exposure_step_ns = 25 * TTF_NS_PER_US;
    c->gain_min_milli = 1000;
    c->gain_max_milli = 16000;
    c->gain_step_milli = 125;
    c->frame_period_ns = 33333333;
    c->frame_period_max_ns = TTF_NS_PER_S;
    c->readout_ns = 19 * TTF_NS_PER_MS;
    c->control_delay_frames = 2;
    c->steerable = true;
    c->jitter_ns = 50 * TTF_NS_PER_US;
    c->buffers = 4;
}

void ttf_sim_config_defaults(struct ttf_sim_config *ret)
{
    memset(ret, 0, sizeof(*ret));
    ret->seed = 1;
    ret->start_utc_ns = INT64_C(1767225600) * TTF_NS_PER_S; /* 2026-01-01 */
    ret->outage_ns = TTF_NS_PER_MIN;
    ret->rtc = true;
    ret->cost_develop_ns = 100 * TTF_NS_PER_MS;
    ret->cost_commit_ns = 50 * TTF_NS_PER_MS;
    ret->n_lamps = 2;
    ret->lamps[0] = default_lamp("left", 0.0);
    ret->lamps[1] = default_lamp("right", 1.0);
    ret->mains_hz = 50;
    ret->ambient = 0.0;
    ret->ambient_degc = 22;
    ret->day_swing_degc = 1.5;
    ret->heat_tau_ns = 20 * TTF_NS_PER_MIN;
    default_optics_and_sensor(ret);
    default_timing(ret);
    ret->n_sensors = 2;
    ret->sensors[0] = (struct ttf_sim_sensor){.name = "box-temp", .kind = TTF_SENSOR_TEMP_MDEGC};
    ret->sensors[1] =
        (struct ttf_sim_sensor){.name = "box-humidity", .kind = TTF_SENSOR_HUMIDITY_MPCT};
    ret->door_switch = true;
}

/* One field and where it must lie. */
struct range {
    const char *field;
    double value, min, max;
};

static int check_ranges(const char *prefix, const struct range *ranges, size_t n,
                        struct ttf_err *err)
{
    for (size_t i = 0; i < n; i++) {
        char where[128];

        if (ranges[i].value >= ranges[i].min && ranges[i].value <= ranges[i].max)
            continue;
        snprintf(where, sizeof(where), "%s%s", prefix, ranges[i].field);
        return ttf_err_set(err, -EINVAL, where, "%.10g is not within %.10g to %.10g",
                           ranges[i].value, ranges[i].min, ranges[i].max);
    }
    return 0;
}

#define DAYS(n) ((double)(n) * (double)TTF_NS_PER_DAY)

static int check_world(const struct ttf_sim_config *c, struct ttf_err *err)
{
    const struct range ranges[] = {
        {"start_utc_ns", (double)c->start_utc_ns, 0, 4e18},
        {"power_on_ns", (double)c->power_on_ns, 0, DAYS(36500)},
        {"outage_ns", (double)c->outage_ns, 0, DAYS(3650)},
        {"utc_back_ns", (double)c->utc_back_ns, 0, DAYS(3650)},
        {"cost_develop_ns", (double)c->cost_develop_ns, 0, DAYS(1)},
        {"cost_commit_ns", (double)c->cost_commit_ns, 0, DAYS(1)},
        {"mains_hz", c->mains_hz, 1, 1000},
        {"ambient", c->ambient, 0, 1000},
        {"daylight", c->daylight, 0, 1000},
        {"ambient_degc", c->ambient_degc, -60, 100},
        {"day_swing_degc", c->day_swing_degc, 0, 60},
        {"heat_tau_ns", (double)c->heat_tau_ns, 1e6, DAYS(10)},
        {"vignetting", c->vignetting, 0, 1},
        {"perspective", c->perspective, 0, 0.3},
        {"blur_px", c->blur_px, 0, 50},
        {"margin", c->margin, 0, 0.4},
        {"margin_reflectance", c->margin_reflectance, 0, 1},
    };

    return check_ranges("", ranges, TTF_COUNT_OF(ranges), err);
}

static int check_sensor(const struct ttf_sim_config *c, struct ttf_err *err)
{
    const struct range ranges[] = {
        {"width", c->width, 16, 8192},
        {"height", c->height, 16, 8192},
        {"bits", c->bits, 8, 16},
        {"black_level", c->black_level, 0, (double)(1u << (c->bits & 31)) / 2},
        {"full_well_e", c->full_well_e, 1, 1e9},
        {"read_noise_e", c->read_noise_e, 0, 1e6},
        {"prnu", c->prnu, 0, 0.3},
        {"dark_e_per_s", c->dark_e_per_s, 0, 1e9},
        {"dark_doubling_degc", c->dark_doubling_degc, 0.1, 1000},
        {"hot_fraction", c->hot_fraction, 0, 0.5},
        {"hot_e_per_s", c->hot_e_per_s, 0, 1e12},
        {"sensitivity_e", c->sensitivity_e, 0, 1e15},
        {"channel_gain[0]", c->channel_gain[0], 0, 100},
        {"channel_gain[1]", c->channel_gain[1], 0, 100},
        {"channel_gain[2]", c->channel_gain[2], 0, 100},
        {"colour_mix", c->colour_mix, 0, 0.3},
    };
    int r = check_ranges("", ranges, TTF_COUNT_OF(ranges), err);

    if (r < 0)
        return r;
    if (c->width % 2 || c->height % 2)
        return ttf_err_set(err, -EINVAL, c->width % 2 ? "width" : "height",
                           "a colour filter array needs an even number of pixels");
    return 0;
}

static int check_timing(const struct ttf_sim_config *c, struct ttf_err *err)
{
    const double hour = (double)TTF_NS_PER_H;
    const struct range ranges[] = {
        {"exposure_min_ns", (double)c->exposure_min_ns, 1, hour},
        {"exposure_max_ns", (double)c->exposure_max_ns, (double)c->exposure_min_ns, hour},
        {"exposure_step_ns", (double)c->exposure_step_ns, 1, hour},
        {"gain_min_milli", c->gain_min_milli, c->gain_max_milli > 0 ? 1 : 0, c->gain_max_milli},
        {"gain_max_milli", c->gain_max_milli, 0, 1e6},
        {"gain_step_milli", c->gain_step_milli, c->gain_max_milli > 0 ? 1 : 0, 1e6},
        {"readout_ns", (double)c->readout_ns, 0, hour},
        {"frame_period_ns", (double)c->frame_period_ns, (double)c->readout_ns + 1, hour},
        {"frame_period_max_ns", (double)c->frame_period_max_ns, (double)c->frame_period_ns, hour},
        {"control_delay_frames", c->control_delay_frames, 0, 100},
        {"jitter_ns", (double)c->jitter_ns, 0, (double)c->frame_period_ns},
        {"buffers", c->buffers, 2, 64},
    };

    return check_ranges("", ranges, TTF_COUNT_OF(ranges), err);
}

static int check_name(const char *name, const char *where, struct ttf_err *err)
{
    size_t n = strspn(name, "abcdefghijklmnopqrstuvwxyz0123456789-");

    if (n == 0 || name[n] != '\0')
        return ttf_err_set(err, -EINVAL, where, "a name is made of a-z, 0-9 and -, not '%s'", name);
    return 0;
}

static int check_lamp(const struct ttf_sim_config *c, unsigned i, struct ttf_err *err)
{
    const struct ttf_sim_lamp *lamp = &c->lamps[i];
    const struct ttf_lamp_info *info = &lamp->info;
    bool duty = info->max_duty_permille < TTF_LAMP_FULL;
    char prefix[32], where[64];
    const struct range ranges[] = {
        {"kind", (double)info->kind, TTF_LAMP_SWITCH, TTF_LAMP_PWM},
        {"steps", info->steps, info->kind == TTF_LAMP_STEPS ? 1 : 0, TTF_LAMP_FULL},
        {"max_on_ns", (double)info->max_on_ns, 0, DAYS(36500)},
        {"max_duty_permille", info->max_duty_permille, 0, TTF_LAMP_FULL},
        {"duty_window_ns", (double)info->duty_window_ns, duty ? 1 : 0, DAYS(366)},
        {"hysteresis_mdegc", info->hysteresis_mdegc, 0, 200000},
        {"warm_up_ns", (double)info->warm_up_ns, 0, DAYS(1)},
        {"x", lamp->x, -100, 100},
        {"y", lamp->y, -100, 100},
        {"height", lamp->height, 1e-3, 1000},
        {"strength", lamp->strength, 0, 1000},
        {"cold_fraction", lamp->cold_fraction, 0, 1},
        {"warm_tau_ns", (double)lamp->warm_tau_ns, 1, DAYS(1)},
        {"ageing_per_kh", lamp->ageing_per_kh, 0, 1000},
        {"ripple", lamp->ripple, 0, 1},
        {"colour[0]", lamp->colour[0], 0, 100},
        {"colour[1]", lamp->colour[1], 0, 100},
        {"colour[2]", lamp->colour[2], 0, 100},
        {"heat_degc", lamp->heat_degc, 0, 500},
    };
    int r;

    snprintf(prefix, sizeof(prefix), "lamps[%u].", i);
    snprintf(where, sizeof(where), "%sname", prefix);
    r = check_name(info->name, where, err);
    if (r == 0)
        r = check_ranges(prefix, ranges, TTF_COUNT_OF(ranges), err);
    for (unsigned k = 0; r == 0 && k < i; k++)
        if (strcmp(c->lamps[k].info.name, info->name) == 0)
            r = ttf_err_set(err, -EINVAL, where, "two lamps are named '%s'", info->name);
    return r;
}

/* A lamp whose temperature is watched needs somebody who feels it. */
static int check_watched(const struct ttf_sim_config *c, unsigned i, struct ttf_err *err)
{
    char where[64];

    if (c->lamps[i].info.max_temp_mdegc == 0)
        return 0;
    for (unsigned k = 0; k < c->n_sensors; k++)
        if (c->sensors[k].kind == TTF_SENSOR_TEMP_MDEGC)
            return 0;
    snprintf(where, sizeof(where), "lamps[%u].max_temp_mdegc", i);
    ttf_err_set(err, -EINVAL, where, "a temperature limit, but no temperature sensor");
    ttf_err_hint(err, "add a sensor of kind temp_mdegc, or take the limit away");
    return -EINVAL;
}

/* Whether it is in force is found by looking back over the minutes that it lasts: a day at most. */
static bool lasting_at_random(const struct ttf_fault *fault)
{
    switch (fault->kind) {
    case TTF_FAULT_CAMERA_HANG:
    case TTF_FAULT_LAMP_DEAD:
    case TTF_FAULT_LAMP_FADING:
    case TTF_FAULT_LAMP_STUCK:
    case TTF_FAULT_SENSOR_GONE:
    case TTF_FAULT_DOOR_OPEN:
        return fault->rate_per_million > 0;
    default:
        return false;
    }
}

static double most_amount(enum ttf_fault_kind kind)
{
    switch (kind) {
    case TTF_FAULT_FRAME_SHORT:
    case TTF_FAULT_LAMP_FADING:
        return TTF_LAMP_FULL;
    case TTF_FAULT_CAMERA_HANG:
        return 3;
    case TTF_FAULT_WRONG_SETTINGS:
        return 1e6;
    default:
        return 4e9;
    }
}

static int check_fault(const struct ttf_sim_config *c, unsigned i, struct ttf_err *err)
{
    const struct ttf_fault *fault = &c->faults[i];
    bool step = fault->kind == TTF_FAULT_CLOCK_STEP;
    double most = most_amount(fault->kind);
    bool cut = fault->kind == TTF_FAULT_POWER_CUT && fault->rate_per_million == 0;
    char prefix[32];
    const struct range ranges[] = {
        {"kind", (double)fault->kind, 0, TTF_FAULT_KIND_COUNT - 1},
        {"at_ns", (double)fault->at_ns, cut ? 1 : 0, DAYS(36500)},
        {"duration_ns", (double)fault->duration_ns, 0,
         lasting_at_random(fault) ? DAYS(1) : DAYS(366)},
        {"rate_per_million", fault->rate_per_million, 0, 1e6},
        {"amount", (double)fault->amount,
         step                                      ? -4e9
         : fault->kind == TTF_FAULT_WRONG_SETTINGS ? -999
                                                   : 0,
         most},
    };
    int r;

    snprintf(prefix, sizeof(prefix), "faults[%u].", i);
    r = check_ranges(prefix, ranges, TTF_COUNT_OF(ranges), err);
    if (r == 0 && sim_fault_target(c, fault) < 0) {
        char where[64];

        snprintf(where, sizeof(where), "%starget", prefix);
        r = ttf_err_set(err, -EINVAL, where, "there is no '%s' that %s could be about",
                        fault->target, ttf_fault_name(fault->kind));
    }
    return r;
}

int ttf_sim_config_check(const struct ttf_sim_config *config, struct ttf_err *err)
{
    const struct range counts[] = {
        {"n_lamps", config->n_lamps, 0, TTF_LAMPS_MAX},
        {"n_sensors", config->n_sensors, 0, TTF_SENSORS_MAX},
        {"n_faults", config->n_faults, 0, TTF_SIM_FAULTS_MAX},
    };
    int r = check_ranges("", counts, TTF_COUNT_OF(counts), err);

    if (r == 0)
        r = check_world(config, err);
    if (r == 0)
        r = check_sensor(config, err);
    if (r == 0)
        r = check_timing(config, err);
    for (unsigned i = 0; r == 0 && i < config->n_lamps; i++) {
        r = check_lamp(config, i, err);
        if (r == 0)
            r = check_watched(config, i, err);
    }
    for (unsigned i = 0; r == 0 && i < config->n_sensors; i++) {
        char where[64];

        snprintf(where, sizeof(where), "sensors[%u].name", i);
        r = check_name(config->sensors[i].name, where, err);
        if (r == 0 && (unsigned)config->sensors[i].kind >= TTF_SENSOR_KIND_COUNT)
            r = ttf_err_set(err, -EINVAL, where, "no such kind of sensor");
    }
    for (unsigned i = 0; r == 0 && i < config->n_faults; i++)
        r = check_fault(config, i, err);
    return r;
}
