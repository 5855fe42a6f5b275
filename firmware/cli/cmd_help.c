/* SPDX-License-Identifier: Apache-2.0 */
/* cmd_help.c: `ttfbox help [--man] [COMMAND]`. */
#include <errno.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

#include "commands.h"
#include "help.h"

/* The command that the arguments name: as words, or as a page's name ("plan-check"). */
static const struct cli_command *named(const struct cli *cli)
{
    const struct cli_command *c;
    char page[64], wanted[64] = "ttfbox";
    size_t n = strlen(wanted);

    for (unsigned i = 0; i < cli->opt.n_args && n < sizeof wanted; i++)
        n += (size_t)snprintf(wanted + n, sizeof wanted - n, "-%s", cli->opt.args[i]);
    for (unsigned i = 0; (c = cli_command(i)); i++)
        if (strcmp(help_page_name(c, page, sizeof page), wanted) == 0)
            return c;
    return NULL;
}

/* One word that several commands begin with, as "synth". */
static bool is_group(const struct cli *cli)
{
    const struct cli_command *c;
    size_t n = strlen(cli->opt.args[0]);

    for (unsigned i = 0; cli->opt.n_args == 1 && (c = cli_command(i)); i++)
        if (strncmp(c->name, cli->opt.args[0], n) == 0 && c->name[n] == ' ')
            return true;
    return false;
}

int cmd_help(struct cli *cli)
{
    const struct cli_command *c;

    if (cli->opt.n_args == 0) {
        if (cli->opt.man)
            help_man_overview(stdout);
        else
            help_overview(stdout, NULL);
        return CLI_DONE;
    }
    c = named(cli);
    if (!c && !cli->opt.man && is_group(cli)) {
        help_overview(stdout, cli->opt.args[0]);
        return CLI_DONE;
    }
    if (!c) {
        ttf_err_set(&cli->err, -EINVAL, NULL, "there is no such command");
        ttf_err_hint(&cli->err, "'ttfbox help' lists them");
        return -EINVAL;
    }
    if (cli->opt.man) {
        help_man_command(stdout, c);
        return CLI_DONE;
    }
    cli_say(cli, "ttfbox %s: %s\n\n%s\n\n'ttfbox %s --help' lists its options.", c->name,
            c->summary, c->text, c->name);
    return CLI_DONE;
}
