/* SPDX-License-Identifier: Apache-2.0 */
/* board_guardian.c: `guardian:` of a board: what ttfbox-lampd has besides the lamps. */
#include <errno.h>
#include <stdio.h>
#include <string.h>

#include "board_file.h"
#include "ttf/hal/lampd.h"

#define G(member) offsetof(struct guardian, member)

/* As it is read: the door's wire comes behind the lamps', which may be read later. */
struct guardian {
    char socket[128];
    char file[512];
    char temperature[32];
    struct ttf_line_spec door;
};

static const struct cfg_field DOOR[] = {
    BOARD_WIRE_FIELDS(G(door)),
    {"pull_up", cfg_bool, G(door.pull_up), 0, 0, "true: the chip pulls the line up", 0, 0},
    {0}};

static const struct cfg_field GUARDIAN[] = {
    {"socket", cfg_text128, G(socket), 0, 0, "a socket's path, as " TTF_LAMPD_SOCKET, 0, 0},
    {"file", cfg_path512, G(file), 0, 0, "the file whose bytes are the wires", 0, 0},
    {"temperature", cfg_text32, G(temperature), 0, 0,
     "the sensor that lamps with max_temp are watched by", 0, 0},
    {"door", cfg_section, 0, 0, 0, "the door switch's wire, active while the door is open", DOOR,
     0},
    {0}};

int board_read_guardian(const struct cfg_field *field, struct yaml_node *node, void *at,
                        struct ttf_err *err)
{
    struct ttf_board_guardian *guardian = &((struct ttf_board *)at)->guardian;
    struct guardian read = {.socket = TTF_LAMPD_SOCKET};
    int r;

    if (node->kind != YAML_MAP)
        return cfg_error(node, err, field->meant, "a map is meant");
    r = cfg_map(GUARDIAN, node, &read, err);
    if (r < 0)
        return r;
    if (strlen(read.socket) >= sizeof guardian->socket)
        return cfg_error(yaml_child(node, "socket"), err, "at most 107 letters",
                         "too long for a socket's path");
    memcpy(guardian->socket, read.socket, sizeof guardian->socket);
    memcpy(guardian->file, read.file, sizeof guardian->file);
    memcpy(guardian->temp_sensor, read.temperature, sizeof guardian->temp_sensor);
    guardian->door = -1;
    if (yaml_child(node, "door")) {
        if (read.door.line[0] == '\0')
            return cfg_error(yaml_child(node, "door"), err, "write {chip: gpiochip0, line: 3}",
                             "'line' is missing: the switch's wire");
        guardian->door = TTF_LINES_MAX - 1; /* its place is known when the lamps are read */
        guardian->wires[TTF_LINES_MAX - 1] = read.door;
        guardian->wires[TTF_LINES_MAX - 1].input = true;
        snprintf(guardian->wires[TTF_LINES_MAX - 1].label, sizeof read.door.label, "door");
    }
    return 0;
}

static bool has_temperature(const struct ttf_board *board, const char *name)
{
    for (unsigned i = 0; i < board->n_sysfs; i++)
        if (board->sysfs[i].kind == TTF_SENSOR_TEMP_MDEGC &&
            (name[0] == '\0' || strcmp(board->sysfs[i].name, name) == 0))
            return true;
    return false;
}

/* A limit that nobody can watch is none; a lamp that can never be lit is a mistake. */
static int check_lamp(const struct ttf_board *board, const struct ttf_lamp_info *lamp,
                      struct yaml_node *node, struct ttf_err *err)
{
    if (lamp->max_temp_mdegc > 0 && !has_temperature(board, board->guardian.temp_sensor))
        return cfg_error(node, err, "write guardian: {temperature: NAME} of a sensor of the board",
                         "'max_temp' without a temperature: the lamp would stay dark");
    if (lamp->interlock_door && board->guardian.door < 0)
        return cfg_error(node, err, "write guardian: {door: {line: ...}}",
                         "'interlock: door' without a door switch");
    return 0;
}

int board_finish_guardian(struct ttf_board *board, struct yaml_node *root, struct ttf_err *err)
{
    struct ttf_board_guardian *guardian = &board->guardian;
    const struct ttf_backend_entry *backend = board->device[TTF_DEVICE_LAMPS];
    struct yaml_node *lamps = yaml_child(root, "lamps");

    if (guardian->socket[0] == '\0')
        memcpy(guardian->socket, TTF_LAMPD_SOCKET, sizeof TTF_LAMPD_SOCKET);
    if (!backend || strcmp(backend->name, "sim") == 0)
        return yaml_child(root, "guardian")
                   ? cfg_error(yaml_child(root, "guardian"), err,
                               "lamps with wires have a back-end other than sim",
                               "a guardian without lamps that have wires")
                   : 0;
    if (strcmp(backend->name, "file") == 0 && guardian->file[0] == '\0')
        return cfg_error(lamps, err, "write guardian: {file: PATH}",
                         "wires in a file, but no 'file' is named");
    for (unsigned i = 0; i < board->sim.n_lamps; i++) {
        const struct ttf_lamp_info *lamp = &board->sim.lamps[i].info;
        int r = check_lamp(board, lamp, yaml_child(lamps, lamp->name), err);

        if (r < 0)
            return r;
    }
    if (guardian->door >= 0) {
        guardian->wires[guardian->n_wires] = guardian->wires[guardian->door];
        guardian->door = (int)guardian->n_wires++;
    }
    return 0;
}
