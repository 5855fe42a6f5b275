/* SPDX-License-Identifier: Apache-2.0 */
/* cmd_board_show.c: `ttfbox board show`: what a board's description says to those that cannot read it: scripts. */
#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>

#include "commands.h"
#include "ttf/config/daemon_file.h"

/* The board that a daemon's configuration names, with its changes of it. */
static int load_by_config(struct cli *cli, const char *path, struct ttf_board *ret)
{
    struct ttf_board_set sets[TTF_DAEMON_SETS_MAX];
    struct ttf_daemon_config *config;
    char file[PATH_MAX];
    int r;

    if (cli->opt.board || cli->opt.n_sets > 0) {
        ttf_err_set(&cli->err, -EINVAL, path, "it names the board and its changes itself");
        return ttf_err_hint(&cli->err, "either CONFIG, or --board and --set"), -EINVAL;
    }
    config = calloc(1, sizeof *config);
    r = config ? ttf_daemon_file_load_board(path, config, &cli->err) : -ENOMEM;
    for (unsigned i = 0; r == 0 && i < config->n_sets; i++)
        sets[i] = (struct ttf_board_set){config->set[i].path, config->set[i].value};
    if (r == 0)
        r = ttf_board_locate(config->board, ttf_daemon_board_folders(), file, sizeof file,
                             &cli->err);
    if (r == 0)
        r = ttf_board_load(file, sets, config->n_sets, ret, &cli->err);
    free(config);
    return r;
}

typedef const char *member_fn(const struct ttf_board *board, unsigned i);

/* One line of words; none where the board does not say. */
static void say_list(struct cli *cli, const struct ttf_board *board, const char *key,
                     member_fn *member)
{
    char words[256] = "";
    size_t n = 0;

    ttf_json_key(&cli->out, key);
    ttf_json_array(&cli->out);
    for (unsigned i = 0; member(board, i); i++) {
        n += (size_t)snprintf(words + n, sizeof words - n, " %s", member(board, i));
        ttf_json_string(&cli->out, member(board, i));
    }
    ttf_json_array_end(&cli->out);
    if (n > 0)
        cli_say(cli, "%-10s%s", key, words);
}

int cmd_board_show(struct cli *cli)
{
    static const char *const ROLES[] = {
        [TTF_USB_NONE] = "none", [TTF_USB_HOST] = "host", [TTF_USB_DEVICE] = "device"};
    struct ttf_board *board = calloc(1, sizeof *board);
    int r = !board                 ? -ENOMEM
            : cli->opt.n_args == 0 ? cli_load_board(cli, board)
                                   : load_by_config(cli, cli->opt.args[0], board);

    if (r == 0) {
        cli_say(cli, "%-10s %s", "board", board->name);
        cli_say(cli, "%-10s %s", "usb", ROLES[board->machine.usb_role]);
        ttf_json_kstring(&cli->out, "board", board->name);
        ttf_json_kstring(&cli->out, "usb", ROLES[board->machine.usb_role]);
        say_list(cli, board, "units", ttf_board_unit);
        say_list(cli, board, "gadget", ttf_board_function);
    }
    free(board);
    return r;
}
