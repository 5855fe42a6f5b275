/* SPDX-License-Identifier: Apache-2.0 */
/* board_devices.c: `lamps:` and `sensors:` of a board: facts about devices, whatever drives them. */
#include <errno.h>
#include <stdio.h>
#include <string.h>

#include "board_file.h"

#define L(member) offsetof(struct ttf_lamp_info, member)

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
    {0}};

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
    if (is_none(node))
        return 0;
    if (node->kind != YAML_MAP || node->n > TTF_LAMPS_MAX)
        return cfg_error(node, err, field->meant, "a map of at most %d lamps is meant",
                         TTF_LAMPS_MAX);
    for (struct yaml_node *c = node->child; c; c = c->next, n++) {
        /* Its model is that of the default lamp at the same place; sim.lamps changes it. */
        board->sim.lamps[n] = defaults.lamps[n < defaults.n_lamps ? n : 0];
        struct ttf_lamp_info *info = &board->sim.lamps[n].info;
        int r;

        *info = (struct ttf_lamp_info){
            .kind = TTF_LAMP_PWM, .max_duty_permille = 1000, .duty_window_ns = TTF_NS_PER_DAY};
        r = read_head(c, TTF_DEVICE_LAMPS, info->name, board, err);
        if (r == 0)
            r = cfg_map(LAMP, c, info, err);
        if (r < 0)
            return r;
        if (info->kind == TTF_LAMP_STEPS && info->steps == 0)
            return cfg_error(c, err, "write steps: 4", "a lamp in steps needs 'steps'");
    }
    board->sim.n_lamps = n;
    return 0;
}

static const struct cfg_name SENSORS[] = {{"temperature", TTF_SENSOR_TEMP_MDEGC},
                                          {"humidity", TTF_SENSOR_HUMIDITY_MPCT},
                                          {"light", TTF_SENSOR_LIGHT_PERMILLE},
                                          {"pressure", TTF_SENSOR_PRESSURE_PA},
                                          {NULL, 0}};
static const struct cfg_field SENSOR[] = {{"backend", NULL, 0, 0, 0, NULL, 0, 0},
                                          {"kind", cfg_enum, offsetof(struct ttf_sim_sensor, kind),
                                           0, 0, "temperature, humidity, light or pressure",
                                           SENSORS, true},
                                          {0}};

int board_read_sensors(const struct cfg_field *field, struct yaml_node *node, void *at,
                       struct ttf_err *err)
{
    struct ttf_board *board = at;
    unsigned n = 0;

    board->sim.n_sensors = 0;
    if (is_none(node))
        return 0;
    if (node->kind != YAML_MAP || node->n > TTF_SENSORS_MAX)
        return cfg_error(node, err, field->meant, "a map of at most %d sensors is meant",
                         TTF_SENSORS_MAX);
    for (struct yaml_node *c = node->child; c; c = c->next, n++) {
        struct ttf_sim_sensor *sensor = &board->sim.sensors[n];
        int r = read_head(c, TTF_DEVICE_SENSORS, sensor->name, board, err);

        if (r == 0)
            r = cfg_map(SENSOR, c, sensor, err);
        if (r < 0)
            return r;
    }
    board->sim.n_sensors = n;
    return 0;
}
