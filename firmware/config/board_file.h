/* SPDX-License-Identifier: Apache-2.0 */
/* board_file.h: what board_file.c and the sections of a board's file share. */
#ifndef CONFIG_BOARD_FILE_H
#define CONFIG_BOARD_FILE_H

#include "decode.h"
#include "ttf/config/board_file.h"

/* `cameras:` */
int board_read_cameras(const struct cfg_field *field, struct yaml_node *node, void *at,
                       struct ttf_err *err);

/* `clock:` and `watchdog:`: the field's lo is the kind of device; and `panel:`. */
int board_read_device(const struct cfg_field *field, struct yaml_node *node, void *at,
                      struct ttf_err *err);
int board_read_panel(const struct cfg_field *field, struct yaml_node *node, void *at,
                     struct ttf_err *err);

/* The board's `lamps:` map (name -> facts) into board->sim.lamps[].info, replacing the defaults. */
int board_read_lamps(const struct cfg_field *field, struct yaml_node *node, void *at,
                     struct ttf_err *err);

/* `sensors:` (name -> kind). */
int board_read_sensors(const struct cfg_field *field, struct yaml_node *node, void *at,
                       struct ttf_err *err);

/* `guardian:`; and, at the end, the wires of lamps that are not simulated, in order, and whether all fits. */
int board_read_guardian(const struct cfg_field *field, struct yaml_node *node, void *at,
                        struct ttf_err *err);
int board_finish_guardian(struct ttf_board *board, struct yaml_node *root, struct ttf_err *err);

/* `chip`, `line`, `active_low`, `pull_up` of a wire; base: a struct ttf_line_spec at this offset. */
#define BOARD_WIRE_FIELDS(offset)                                                            \
    {"chip", cfg_text64, (offset) + offsetof(struct ttf_line_spec, chip),                    \
     0,      0,          "the GPIO chip, as gpiochip0",                                      \
     0,      0},                                                                             \
        {"line", cfg_text64, (offset) + offsetof(struct ttf_line_spec, line),                \
         0,      0,          "the line's name, or its number on the chip",                   \
         0,      0},                                                                         \
    {                                                                                        \
        "active_low", cfg_bool, (offset) + offsetof(struct ttf_line_spec, active_low), 0, 0, \
            "true: a low level lights it", 0, 0                                              \
    }

/* `machine:`; and, at the end, whether wires and ports get along on it. */
int board_read_machine(const struct cfg_field *field, struct yaml_node *node, void *at,
                       struct ttf_err *err);
int board_finish_machine(struct ttf_board *board, struct yaml_node *root, struct ttf_err *err);

/* `machine.usb_devices:`; and, at the end, what excludes what on its USB ports and its power input. */
int board_read_usb_devices(const struct cfg_field *field, struct yaml_node *node, void *at,
                           struct ttf_err *err);
int board_finish_usb(const struct ttf_board *board, struct yaml_node *root, struct ttf_err *err);

/* `units:` and `gadget:`; and, at the end, whether they get along with each other and with the rest; without those of a
 * PC's device where a change of machine.usb_role has made it none. */
int board_read_units(const struct cfg_field *field, struct yaml_node *node, void *at,
                     struct ttf_err *err);
int board_read_gadget(const struct cfg_field *field, struct yaml_node *node, void *at,
                      struct ttf_err *err);
int board_finish_services(struct ttf_board *board, struct yaml_node *root, struct ttf_err *err);

/* `sim:`: everything of struct ttf_sim_config and the scene; at is the struct ttf_board. */
int board_read_sim(const struct cfg_field *field, struct yaml_node *node, void *at,
                   struct ttf_err *err);

/* `sim.faults:`. */
int board_read_faults(const struct cfg_field *field, struct yaml_node *node, void *at,
                      struct ttf_err *err);

/* `sim.scene:`. */
int board_read_scene(const struct cfg_field *field, struct yaml_node *node, void *at,
                     struct ttf_err *err);

/* `backend: NAME` of a device into a const struct ttf_backend_entry *; extra: enum in disguise, see board_file.c. */
int board_backend(struct yaml_node *map, enum ttf_device_kind kind,
                  const struct ttf_backend_entry **ret, struct ttf_err *err);

#endif
