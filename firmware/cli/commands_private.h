/* SPDX-License-Identifier: Apache-2.0 */
/* commands_private.h: the tables that commands.c puts together, by subject. */
#ifndef CLI_COMMANDS_PRIVATE_H
#define CLI_COMMANDS_PRIVATE_H

#include "commands.h"
#include "ttf/base/attr.h"

struct cli_commands {
    const struct cli_command *list;
    unsigned n;
};

extern const struct cli_commands cli_commands_capture, cli_commands_data, cli_commands_synth;

#endif
