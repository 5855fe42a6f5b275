/* SPDX-License-Identifier: Apache-2.0 */
/* cmd_usb_token.c: `ttfbox usb token`: the box's token, which it shows once to whoever is at its cable. */
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "commands.h"
#include "ttf/hal/clock.h"
#include "ttf/pull/ask.h"
#include "usb_box.h"

/* Before anything is asked: what is shown once is not to be lost for want of a place. -1: none is wanted. */
static int open_file(struct cli *cli, int *ret)
{
    const char *path = cli->opt.token_file;

    *ret = path ? open(path, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600) : -1;
    if (!path || *ret >= 0)
        return 0;
    return ttf_err_set(&cli->err, -errno, path, "cannot be made: %s", strerrordesc_np(errno));
}

static int ask(struct cli *cli, char **ret_token)
{
    struct ttf_pull_config config = {.ended = usb_bridge_ended};
    struct usb_bridge *bridge = NULL;
    int r = 0;

    config.clock = ttf_clock_real_create();
    if (!config.clock)
        return ttf_err_set(&cli->err, -errno, "clock", "the machine's clock cannot be had");
    cli_stop_catch();
    config.stop = cli_stop_flag();
    r = usb_bridge_begin(cli->opt.box ? cli->opt.box : "usb", false, config.clock, &bridge,
                         &cli->err);
    if (r == 0) {
        config.box = usb_bridge_where(bridge);
        config.ended_ctx = bridge;
        r = ttf_pull_token(&config, ret_token, &cli->err);
    }
    usb_bridge_end(bridge);
    ttf_clock_destroy(config.clock);
    return r;
}

static int keep(struct cli *cli, int fd, const char *token)
{
    int r = dprintf(fd, "%s\n", token) < 0 || fsync(fd) < 0 ? -errno : 0;

    return r < 0 ? ttf_err_set(&cli->err, r, cli->opt.token_file, "cannot be written: %s",
                               strerrordesc_np(-r))
                 : 0;
}

int cmd_usb_token(struct cli *cli)
{
    char *token = NULL;
    int fd = -1;
    int r = open_file(cli, &fd);

    if (r == 0)
        r = ask(cli, &token);
    if (r == 0) {
        /* Whatever becomes of the file. */
        cli_say(cli, "%s", token);
        ttf_json_kstring(&cli->out, "token", token);
        if (fd >= 0)
            r = keep(cli, fd, token);
        if (r < 0) /* it is shown once, and what --json would have said is not said */
            (void)fprintf(stderr, "ttfbox usb token: %s\n", token);
    } else if (fd >= 0) {
        (void)unlink(cli->opt.token_file);
    }
    if (fd >= 0)
        (void)close(fd);
    free(token);
    return r;
}
