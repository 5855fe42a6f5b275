/* SPDX-License-Identifier: Apache-2.0 */
/* hand_over.c: of `ttfbox`: the commands that `ttfbox-full` does. */
#include "hand_over.h"

#include <errno.h>
#include <string.h>
#include <unistd.h>

#include "commands.h"
#include "ttf/hal/program.h"

#define FULL "ttfbox-full"

bool cli_is_full(void)
{
    return false;
}

int cli_hand_over(struct cli *cli)
{
    char program[TTF_PROGRAM_PATH_MAX];
    int r = ttf_program_find(FULL, program);

    if (r == 0) {
        execv(program, cli->words);
        ttf_err_set(&cli->err, -ENOPKG, program,
                    "this program does the command, and cannot be run: %s", strerrordesc_np(errno));
    } else {
        ttf_err_set(&cli->err, -ENOPKG, FULL, "this program does the command, and %s",
                    r == -EACCES ? "may not be run"
                                 : "is neither beside ttfbox nor in ../lib/ttfbox from there");
    }
    ttf_err_hint(&cli->err, "it comes with ttfbox: copy it along, or reinstall");
    return -ENOPKG;
}

int cmd_pull(struct cli *cli)
{
    return cli_hand_over(cli);
}

int cmd_serve(struct cli *cli)
{
    return cli_hand_over(cli);
}

int cmd_usb(struct cli *cli)
{
    return cli_hand_over(cli);
}

int cmd_usb_list(struct cli *cli)
{
    return cli_hand_over(cli);
}

int cmd_usb_token(struct cli *cli)
{
    return cli_hand_over(cli);
}
