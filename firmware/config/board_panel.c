/* SPDX-License-Identifier: Apache-2.0 */
/* board_panel.c: `panel:`, `clock:`, `watchdog:` and `lock:` of a board. */
#include <errno.h>
#include <stdio.h>
#include <string.h>

#include "board_file.h"
#include "ttf/hal/watchdog_device.h"

static bool is_none(const struct yaml_node *node)
{
    return node->kind == YAML_SCALAR && strcmp(node->text, "none") == 0;
}

/* ---- clock, watchdog ---- */

static const struct cfg_field DEVICE[] = {{"backend", NULL, 0, 0, 0, NULL, 0, 0}, {0}};
static const struct cfg_field WATCHDOG[] = {{"backend", NULL, 0, 0, 0, NULL, 0, 0},
                                            {"device", cfg_text64,
                                             offsetof(struct ttf_board, watchdog_path), 0, 0,
                                             "as " TTF_WATCHDOG_DEVICE, 0, 0},
                                            {0}};

int board_read_device(const struct cfg_field *field, struct yaml_node *node, void *at,
                      struct ttf_err *err)
{
    enum ttf_device_kind kind = (enum ttf_device_kind)(int)field->lo;
    struct ttf_board *board = at;
    int r;

    if (is_none(node) && kind != TTF_DEVICE_CLOCK) {
        board->device[kind] = NULL;
        return 0;
    }
    if (node->kind != YAML_MAP)
        return cfg_error(node, err, "write {backend: sim}", "a device's description is meant");
    r = board_backend(node, kind, &board->device[kind], err);
    if (r < 0)
        return r;
    if (strcmp(board->device[kind]->name, "device") != 0)
        return cfg_map(DEVICE, node, board, err);
    memcpy(board->watchdog_path, TTF_WATCHDOG_DEVICE, sizeof TTF_WATCHDOG_DEVICE);
    return cfg_map(WATCHDOG, node, board, err);
}

/* ---- panel ---- */

static const struct cfg_field SIM_PANEL[] = {
    {"backend", NULL, 0, 0, 0, NULL, 0, 0},
    {"door_switch", cfg_bool, offsetof(struct ttf_board, sim.door_switch), 0, 0,
     "whether the box feels its door, true or false", 0, 0},
    {0}};

/* As it is read: either wire may be missing. */
struct panel {
    char file[512];
    struct ttf_line_spec button, led;
};

#define P(member) offsetof(struct panel, member)

static const struct cfg_field BUTTON[] = {
    BOARD_WIRE_FIELDS(P(button)),
    {"pull_up", cfg_bool, P(button.pull_up), 0, 0, "true: the chip pulls the line up", 0, 0},
    {0}};
static const struct cfg_field LED[] = {BOARD_WIRE_FIELDS(P(led)), {0}};

static const struct cfg_field PANEL[] = {
    {"backend", NULL, 0, 0, 0, NULL, 0, 0},
    {"file", cfg_path512, P(file), 0, 0, "the file whose bytes are the wires", 0, 0},
    {"button", cfg_section, 0, 0, 0, "the button's wire, active while it is pressed", BUTTON, 0},
    {"led", cfg_section, 0, 0, 0, "the status light's wire", LED, 0},
    {0}};

static int take_wire(struct ttf_board_panel *panel, const struct yaml_node *node,
                     struct ttf_line_spec *wire, const char *label, int *ret_index,
                     struct ttf_err *err)
{
    *ret_index = -1;
    if (!node)
        return 0;
    if (wire->line[0] == '\0')
        return cfg_error(node, err, "write {chip: gpiochip0, line: 3}", "'line' is missing");
    (void)snprintf(wire->label, sizeof wire->label, "%s", label);
    *ret_index = (int)panel->n_wires;
    panel->wires[panel->n_wires++] = *wire;
    return 0;
}

static int read_wires(struct ttf_board *board, struct yaml_node *node, struct ttf_err *err)
{
    struct ttf_board_panel *panel = &board->panel;
    struct panel read = {0};
    int r = cfg_map(PANEL, node, &read, err);

    read.button.input = true;
    memset(panel, 0, sizeof *panel);
    memcpy(panel->file, read.file, sizeof panel->file);
    if (r == 0)
        r = take_wire(panel, yaml_child(node, "button"), &read.button, "button", &panel->button,
                      err);
    if (r == 0)
        r = take_wire(panel, yaml_child(node, "led"), &read.led, "led", &panel->led, err);
    if (r == 0 && strcmp(board->device[TTF_DEVICE_PANEL]->name, "file") == 0 && !*panel->file)
        r = cfg_error(node, err, "write file: PATH", "wires in a file, but no 'file' is named");
    return r;
}

int board_read_panel(const struct cfg_field *field, struct yaml_node *node, void *at,
                     struct ttf_err *err)
{
    struct ttf_board *board = at;
    int r;

    (void)field;
    if (is_none(node)) {
        board->device[TTF_DEVICE_PANEL] = NULL;
        return 0;
    }
    if (node->kind != YAML_MAP)
        return cfg_error(node, err, "write {backend: sim}", "a device's description is meant");
    r = board_backend(node, TTF_DEVICE_PANEL, &board->device[TTF_DEVICE_PANEL], err);
    if (r < 0)
        return r;
    if (strcmp(board->device[TTF_DEVICE_PANEL]->name, "sim") == 0)
        return cfg_map(SIM_PANEL, node, board, err);
    return read_wires(board, node, err);
}
