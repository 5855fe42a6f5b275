/* SPDX-License-Identifier: Apache-2.0 */
/* commands.c: every command's words; see commands.h. */
#include "commands.h"

#include <string.h>

#include "commands_private.h"

static const struct cli_command HELP = {
    .name = "help",
    .args = "[COMMAND]",
    .summary = "explain the program or a command",
    .text = "The same texts as --help; with --man as the source of the manual page.",
    .max_args = 3,
    .run = cmd_help,
    .options = {{OPT_MAN, NULL}, {OPT_END, NULL}},
    .examples = {{"ttfbox help --man capture | man -l -", "read the manual page"}},
};

static const struct cli_commands HELP_ALONE = {&HELP, 1};

/* In the order of --help. */
static const struct cli_commands *const TABLES[] = {&cli_commands_capture, &cli_commands_data,
                                                    &cli_commands_synth, &HELP_ALONE};

const struct cli_command *cli_command(unsigned i)
{
    for (unsigned t = 0; t < TTF_COUNT_OF(TABLES); t++) {
        if (i < TABLES[t]->n)
            return &TABLES[t]->list[i];
        i -= TABLES[t]->n;
    }
    return NULL;
}

/* How many of the words the name takes up, or 0. */
static int match(const char *name, int n, char *const *words)
{
    int used = 0;

    while (*name) {
        size_t length = strcspn(name, " ");

        if (used == n || strlen(words[used]) != length || strncmp(words[used], name, length) != 0)
            return 0;
        used++;
        name += length;
        name += *name == ' ';
    }
    return used;
}

const struct cli_command *cli_command_find(int n, char *const *words, int *ret_words,
                                           bool *ret_group)
{
    const struct cli_command *command;

    *ret_group = false;
    for (unsigned i = 0; (command = cli_command(i)) != NULL; i++) {
        const char *name = command->name;
        size_t length = strcspn(name, " ");
        int used = match(name, n, words);

        if (used) {
            *ret_words = used;
            return command;
        }
        if (n && strlen(words[0]) == length && strncmp(name, words[0], length) == 0)
            *ret_group = true;
    }
    return NULL;
}
