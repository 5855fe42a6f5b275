/* SPDX-License-Identifier: Apache-2.0 */
/* help.h: what the table of commands says, as help texts and manual pages. */
#ifndef CLI_HELP_H
#define CLI_HELP_H

#include <stdio.h>

#include "commands.h"

/* All commands, or those whose names begin with the word `group` (NULL: all). */
void help_overview(FILE *out, const char *group);

/* Manual pages as troff source: of the program, and of one command. */
void help_man_overview(FILE *out);
void help_man_command(FILE *out, const struct cli_command *command);

/* "ttfbox-plan-check": the page's name. Returns buf. */
const char *help_page_name(const struct cli_command *command, char *buf, size_t size);

#endif
