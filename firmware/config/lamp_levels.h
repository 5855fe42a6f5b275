/* SPDX-License-Identifier: Apache-2.0 */
/* lamp_levels.h: `{left: 100%, right: 400permille}` of a plan. */
#ifndef CONFIG_LAMP_LEVELS_H
#define CONFIG_LAMP_LEVELS_H

#include "decode.h"
#include "ttf/capture/plan.h"

/* Levels in permille of lamps by name; whether the box has them is ttf_plan_check's. */
int cfg_lamp_levels(const struct cfg_field *field, struct yaml_node *node,
                    struct ttf_lamp_level levels[TTF_LAMPS_MAX], unsigned *ret_n,
                    struct ttf_err *err);

#endif
