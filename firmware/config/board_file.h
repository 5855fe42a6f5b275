/* SPDX-License-Identifier: Apache-2.0 */
/* board_file.h: what board_file.c and the sections of a board's file share. */
#ifndef CONFIG_BOARD_FILE_H
#define CONFIG_BOARD_FILE_H

#include "decode.h"
#include "ttf/config/board_file.h"

/* The board's `lamps:` map (name -> facts) into board->sim.lamps[].info, replacing the defaults. */
int board_read_lamps(const struct cfg_field *field, struct yaml_node *node, void *at,
                     struct ttf_err *err);

/* `sensors:` (name -> kind). */
int board_read_sensors(const struct cfg_field *field, struct yaml_node *node, void *at,
                       struct ttf_err *err);

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
