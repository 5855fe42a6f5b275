/* SPDX-License-Identifier: Apache-2.0 */
/* board_machine.c: `machine:` of a board: what the computer in the box is, and which of its lines are something else. */
#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "board_file.h"

#define M(member) offsetof(struct ttf_board, machine.member)

static const struct cfg_name HEADERS[] = {
    {"none", TTF_HEADER_NONE}, {"raspberry-pi", TTF_HEADER_RASPBERRY_PI}, {NULL, 0}};
static const struct cfg_name ROLES[] = {
    {"none", TTF_USB_NONE}, {"host", TTF_USB_HOST}, {"device", TTF_USB_DEVICE}, {NULL, 0}};

static const struct cfg_name POWERS[] = {{"usb", TTF_POWER_USB},
                                         {"header", TTF_POWER_HEADER},
                                         {"poe", TTF_POWER_POE},
                                         {"socket", TTF_POWER_SOCKET},
                                         {NULL, 0}};

static const struct cfg_field MACHINE[] = {
    {"model", cfg_text64, M(model), 0, 0, "how the machine's name for itself begins", 0, 0},
    {"header", cfg_enum, M(header), 0, 0, "its pin header: none or raspberry-pi", HEADERS, 0},
    {"usb_role", cfg_enum, M(usb_role), 0, 0,
     "of its port that may be either: none, host, or device (a PC pulls datasets by it)", ROLES, 0},
    {"usb_single", cfg_bool, M(usb_single), 0, 0, "true: it has no other USB port", 0, 0},
    {"usb_powers", cfg_bool, M(usb_powers), 0, 0, "true: that port is its power input, too", 0, 0},
    {"power", cfg_enum, M(power), 0, 0, "by what it is fed: usb, header, poe or socket", POWERS, 0},
    {"usb_devices", board_read_usb_devices, 0, 0, 0,
     "a list of what is plugged into its USB ports: cameras and chips by name, disk, network", 0,
     0},
    {0}};

int board_read_machine(const struct cfg_field *field, struct yaml_node *node, void *at,
                       struct ttf_err *err)
{
    (void)field;
    return cfg_map(MACHINE, node, at, err);
}

/* Of the 40-pin header of a Raspberry Pi. */
static const struct ttf_header_use USES[] = {
    {0, 1, "the ID EEPROM of HATs, which firmware talks to at each boot", NULL},
    {2, 3, "the I2C bus, with pull-ups of its own on the board", "dev/i2c-1"},
    {7, 11, "the SPI bus", "dev/spidev0.0"},
    {14, 15, "the serial console (UART)", "dev/serial0"},
};

const struct ttf_header_use *ttf_board_header_use(const struct ttf_line_spec *wire)
{
    const char *digits = strncmp(wire->line, "GPIO", 4) == 0 ? wire->line + 4 : wire->line;
    bool header = wire->chip[0] == '\0' || strcmp(wire->chip, "gpiochip0") == 0 ||
                  strncmp(wire->chip, "pinctrl-", 8) == 0;
    long line;

    if (wire->period_ns > 0) /* a chip of channels, not the header's */
        return NULL;
    if (!header || !*digits || strspn(digits, "0123456789") != strlen(digits) || strlen(digits) > 3)
        return NULL;
    line = strtol(digits, NULL, 10);
    for (unsigned i = 0; i < TTF_COUNT_OF(USES); i++)
        if (line >= USES[i].first && line <= USES[i].last)
            return &USES[i];
    return NULL;
}

/* A wire, and where its file says so. */
struct place {
    const struct ttf_line_spec *wire;
    struct yaml_node *node;
};

static unsigned all_wires(struct ttf_board *board, struct yaml_node *root,
                          struct place ret[2 * TTF_LINES_MAX])
{
    struct ttf_board_guardian *g = &board->guardian;
    struct yaml_node *panel = yaml_child(root, "panel");
    const struct ttf_backend_entry *lamps = board->device[TTF_DEVICE_LAMPS];
    const struct ttf_backend_entry *buttons = board->device[TTF_DEVICE_PANEL];
    unsigned n = 0;

    for (unsigned i = 0; lamps && strcmp(lamps->name, "gpiod") == 0 && i < g->n_wires; i++) {
        ret[n].wire = &g->wires[i];
        ret[n++].node = (int)i == g->door
                            ? yaml_child(yaml_child(root, "guardian"), "door")
                            : yaml_child(yaml_child(root, "lamps"), g->wires[i].label);
    }
    for (unsigned i = 0; buttons && strcmp(buttons->name, "gpiod") == 0 && i < board->panel.n_wires;
         i++) {
        ret[n].wire = &board->panel.wires[i];
        ret[n++].node = yaml_child(panel, board->panel.wires[i].label);
    }
    return n;
}

static int check_wire(const struct ttf_board *board, const struct place *places, unsigned i,
                      struct ttf_err *err)
{
    const struct ttf_line_spec *wire = places[i].wire;
    const struct ttf_header_use *use =
        board->machine.header == TTF_HEADER_RASPBERRY_PI ? ttf_board_header_use(wire) : NULL;
    bool pwm = wire->period_ns > 0;

    if (use)
        return cfg_error(places[i].node, err, "take a free line: GPIO4 to 6, 12, 13, 16 to 27",
                         "line %s is also %s", wire->line, use->what);
    for (unsigned k = 0; k < i; k++)
        if ((places[k].wire->period_ns > 0) == pwm &&
            strcmp(places[k].wire->chip, wire->chip) == 0 &&
            strcmp(places[k].wire->line, wire->line) == 0)
            return cfg_error(places[i].node, err, "each wire has a line of its own",
                             "%s %s is already that of '%s'", pwm ? "PWM channel" : "line",
                             wire->line, places[k].wire->label);
    return 0;
}

int board_finish_machine(struct ttf_board *board, struct yaml_node *root, struct ttf_err *err)
{
    struct place places[2 * TTF_LINES_MAX];
    unsigned n = all_wires(board, root, places);

    for (unsigned i = 0; i < n; i++) {
        int r = check_wire(board, places, i, err);

        if (r < 0)
            return r;
    }
    return board_finish_usb(board, root, err);
}
