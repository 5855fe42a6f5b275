/* SPDX-License-Identifier: Apache-2.0 */
/* board_devices.c: `lamps:` and `sensors:` of a board: facts about devices, whatever drives them. */
#include <errno.h>
#include <stdio.h>
#include <string.h>

#include "board_file.h"
#include "ttf/hal/pwm.h"

/* A lamp as it is read: facts, and the wire of one that is not simulated. */
struct lamp {
    struct ttf_lamp_info info;
    struct ttf_line_spec wire;
    struct ttf_line_spec pwm; /* its wire, if that is a PWM channel */
    unsigned channel;
};

#define L(member) offsetof(struct lamp, info.member)

static const struct cfg_name KINDS[] = {
    {"switch", TTF_LAMP_SWITCH}, {"steps", TTF_LAMP_STEPS}, {"pwm", TTF_LAMP_PWM}, {NULL, 0}};

/* interlock: door | none. */
static int read_interlock(const struct cfg_field *field, struct yaml_node *node, void *at,
                          struct ttf_err *err)
{
    static const struct cfg_name WORDS[] = {{"none", 0}, {"door", 1}, {NULL, 0}};
    struct cfg_field words = *field;
    int value = 0;

    words.extra = WORDS;
    int r = cfg_enum(&words, node, &value, err);

    if (r == 0)
        *(bool *)at = value != 0;
    return r;
}

#define DAY ((double)TTF_NS_PER_DAY)

#define P(member) offsetof(struct lamp, member)

static const struct cfg_field PWM[] = {
    {"chip", cfg_text64, P(pwm.chip), 0, 0, "the PWM chip, as pwmchip0, or its device", 0, true},
    {"channel", cfg_u32, P(channel), 0, 255, "the chip's channel, as 0", 0, true},
    {"period", cfg_i64_time, P(pwm.period_ns), TTF_PWM_PERIOD_MIN_NS, TTF_PWM_PERIOD_MAX_NS,
     "the length of a cycle, as 50us", 0, true},
    {0}};

static const struct cfg_field LAMP[] = {
    {"backend", NULL, 0, 0, 0, NULL, 0, 0},
    {"kind", cfg_enum, L(kind), 0, 0, "switch, steps or pwm", KINDS, 0},
    {"steps", cfg_u32, L(steps), 1, 1000, "equal steps above dark, of a lamp in steps", 0, 0},
    {"max_on", cfg_i64_time, L(max_on_ns), 0, 366 * DAY, "longest time on, as 12h; 0s: any", 0, 0},
    {"max_duty", cfg_unsigned_permille, L(max_duty_permille), 1, 1000,
     "largest share of time on, as 60%", 0, 0},
    {"duty_window", cfg_i64_time, L(duty_window_ns), 1e9, 366 * DAY,
     "the time that max_duty is a share of, as 24h", 0, 0},
    {"max_temp", cfg_i32_mdegc, L(max_temp_mdegc), 0, 200000, "goes off above, as 60degC", 0, 0},
    {"hysteresis", cfg_i32_mdegc, L(hysteresis_mdegc), 0, 100000,
     "how much cooler it must be to be lit again, as 5degC", 0, 0},
    {"interlock", read_interlock, L(interlock_door), 0, 0, "door or none", 0, 0},
    {"warm_up", cfg_i64_time, L(warm_up_ns), 0, DAY, "the time its light takes to settle", 0, 0},
    BOARD_WIRE_FIELDS(P(wire)),
    {"pwm", cfg_section, 0, 0, 0, "{chip, channel, period}: its wire is a PWM channel", PWM, 0},
    {0}};

/* A lamp on a PWM channel takes any level, unless it is said to have steps or to be a switch. */
static int take_channel(struct yaml_node *node, struct lamp *lamp, struct ttf_err *err)
{
    if (lamp->wire.line[0] || lamp->wire.chip[0] || lamp->wire.active_low)
        return cfg_error(node, err, "either 'line' or 'pwm'; a PWM lamp is lit while it is high",
                         "a lamp has one wire");
    if (!yaml_child(node, "kind"))
        lamp->info.kind = TTF_LAMP_PWM;
    lamp->info.pwm_period_ns = lamp->info.kind == TTF_LAMP_SWITCH ? 0 : lamp->pwm.period_ns;
    lamp->wire = lamp->pwm;
    (void)snprintf(lamp->wire.line, sizeof lamp->wire.line, "%u", lamp->channel);
    return 0;
}

/* One that is not simulated has a wire of its name; wires come in the lamps' order. */
static int take_wire(struct ttf_board *board, struct yaml_node *node, struct lamp *lamp,
                     struct ttf_err *err)
{
    struct ttf_line_spec *wire = &board->guardian.wires[board->guardian.n_wires];
    int r;

    if (strcmp(board->device[TTF_DEVICE_LAMPS]->name, "sim") == 0)
        return lamp->wire.line[0] || lamp->wire.chip[0] || yaml_child(node, "pwm")
                   ? cfg_error(node, err, "take away 'line', 'chip' and 'pwm'",
                               "a simulated lamp has no wire")
                   : 0;
    if (yaml_child(node, "pwm")) {
        r = take_channel(node, lamp, err);
        if (r < 0)
            return r;
    } else if (lamp->info.kind != TTF_LAMP_SWITCH) {
        return cfg_error(yaml_child(node, "kind"), err, "write pwm: {chip, channel, period}",
                         "a line is on or off: levels between need a PWM channel");
    }
    if (lamp->wire.line[0] == '\0')
        return cfg_error(node, err, "write line: GPIO17, or chip: gpiochip0 and line: 17",
                         "'line' is missing: the lamp's wire");
    *wire = lamp->wire;
    memcpy(wire->label, lamp->info.name, sizeof wire->label);
    board->guardian.n_wires++;
    return 0;
}

/* What all devices of a map say alike: a name, a back-end, the same one for all. */
static int read_head(struct yaml_node *c, enum ttf_device_kind kind, char name[32],
                     struct ttf_board *board, struct ttf_err *err)
{
    const struct ttf_backend_entry *backend = NULL;
    int r;

    c->used = true;
    if (!*c->key || strlen(c->key) > 31 ||
        strspn(c->key, "abcdefghijklmnopqrstuvwxyz0123456789-") != strlen(c->key))
        return cfg_error_at_key(c, err, "1 to 31 of a-z, 0-9 and '-'", "no name of a device");
    if (c->kind != YAML_MAP)
        return cfg_error(c, err, "write {backend: sim, ...}", "a device's description is meant");
    r = board_backend(c, kind, &backend, err);
    if (r < 0)
        return r;
    if (board->device[kind] && board->device[kind] != backend)
        return cfg_error(c, err, "one back-end drives them all", "back-ends differ");
    board->device[kind] = backend;
    memset(name, 0, 32);
    memcpy(name, c->key, strlen(c->key));
    return 0;
}

/* A list that may be `none` or empty. */
static bool is_none(const struct yaml_node *node)
{
    return node->kind == YAML_SCALAR && strcmp(node->text, "none") == 0;
}

int board_read_lamps(const struct cfg_field *field, struct yaml_node *node, void *at,
                     struct ttf_err *err)
{
    struct ttf_board *board = at;
    struct ttf_sim_config defaults;
    unsigned n = 0;

    ttf_sim_config_defaults(&defaults);
    board->sim.n_lamps = 0;
    board->guardian.n_wires = 0;
    if (is_none(node))
        return 0;
    if (node->kind != YAML_MAP || node->n > TTF_LAMPS_MAX)
        return cfg_error(node, err, field->meant, "a map of at most %d lamps is meant",
                         TTF_LAMPS_MAX);
    for (struct yaml_node *c = node->child; c; c = c->next, n++) {
        /* Its model is that of the default lamp at the same place; sim.lamps changes it. */
        board->sim.lamps[n] = defaults.lamps[n < defaults.n_lamps ? n : 0];
        struct lamp lamp = {.info = {.kind = TTF_LAMP_PWM,
                                     .max_duty_permille = 1000,
                                     .duty_window_ns = TTF_NS_PER_DAY}};
        int r = read_head(c, TTF_DEVICE_LAMPS, lamp.info.name, board, err);

        if (r == 0 && strcmp(board->device[TTF_DEVICE_LAMPS]->name, "sim") != 0)
            lamp.info.kind = TTF_LAMP_SWITCH; /* what a wire can do */
        if (r == 0)
            r = cfg_map(LAMP, c, &lamp, err);
        if (r == 0 && lamp.info.kind == TTF_LAMP_STEPS && lamp.info.steps == 0)
            r = cfg_error(c, err, "write steps: 4", "a lamp in steps needs 'steps'");
        if (r == 0)
            r = take_wire(board, c, &lamp, err);
        if (r < 0)
            return r;
        board->sim.lamps[n].info = lamp.info;
    }
    board->sim.n_lamps = n;
    return 0;
}

static const struct cfg_name SENSORS[] = {
    {"temperature", TTF_SENSOR_TEMP_MDEGC},    {"humidity", TTF_SENSOR_HUMIDITY_MPCT},
    {"light", TTF_SENSOR_LIGHT_PERMILLE},      {"pressure", TTF_SENSOR_PRESSURE_PA},
    {"undervoltage", TTF_SENSOR_UNDERVOLTAGE}, {NULL, 0}};
static const struct cfg_name BUSES[] = {
    {"hwmon", TTF_SYSFS_HWMON}, {"iio", TTF_SYSFS_IIO}, {NULL, 0}};

#define S(member) offsetof(struct ttf_sysfs_sensor, member)

static const struct cfg_field SENSOR[] = {
    {"backend", NULL, 0, 0, 0, NULL, 0, 0},
    {"kind", cfg_enum, S(kind), 0, 0, "temperature, humidity, light, pressure or undervoltage",
     SENSORS, true},
    {"bus", cfg_enum, S(bus), 0, 0, "hwmon or iio", BUSES, 0},
    {"device", cfg_text64, S(device), 0, 0, "what its driver calls it, as bme280", 0, 0},
    {"channel", cfg_text64, S(channel), 0, 0, "as temp1 or in_temp", 0, 0},
    {"full", cfg_double, S(full), 1e-6, 1e9, "of light: the driver's value that is full", 0, 0},
    {0}};

static int check_sensor(const struct ttf_board *board, struct yaml_node *node,
                        const struct ttf_sysfs_sensor *sensor, struct ttf_err *err)
{
    bool simulated = strcmp(board->device[TTF_DEVICE_SENSORS]->name, "sim") == 0;

    if (simulated && sensor->device[0])
        return cfg_error(node, err, "take away 'device'", "a simulated sensor has no driver");
    if (!simulated && !sensor->device[0])
        return cfg_error(node, err, "write device: bme280",
                         "'device' is missing: its driver's name");
    if (!simulated && sensor->kind == TTF_SENSOR_LIGHT_PERMILLE && !(sensor->full > 0))
        return cfg_error(node, err, "write full: 2000", "'full' is missing: full light");
    return 0;
}

int board_read_sensors(const struct cfg_field *field, struct yaml_node *node, void *at,
                       struct ttf_err *err)
{
    struct ttf_board *board = at;
    unsigned n = 0;

    board->sim.n_sensors = board->n_sysfs = 0;
    if (is_none(node))
        return 0;
    if (node->kind != YAML_MAP || node->n > TTF_SENSORS_MAX)
        return cfg_error(node, err, field->meant, "a map of at most %d sensors is meant",
                         TTF_SENSORS_MAX);
    for (struct yaml_node *c = node->child; c; c = c->next, n++) {
        struct ttf_sysfs_sensor *sensor = &board->sysfs[n];
        int r;

        memset(sensor, 0, sizeof *sensor);
        r = read_head(c, TTF_DEVICE_SENSORS, sensor->name, board, err);
        if (r == 0)
            r = cfg_map(SENSOR, c, sensor, err);
        if (r == 0)
            r = check_sensor(board, c, sensor, err);
        if (r < 0)
            return r;
        memcpy(board->sim.sensors[n].name, sensor->name, sizeof board->sim.sensors[n].name);
        board->sim.sensors[n].kind = sensor->kind;
    }
    board->sim.n_sensors = n;
    if (n > 0 && strcmp(board->device[TTF_DEVICE_SENSORS]->name, "sysfs") == 0)
        board->n_sysfs = n;
    return 0;
}
