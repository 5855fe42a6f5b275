/* SPDX-License-Identifier: Apache-2.0 */
/* cmd_token.c: `ttfbox token`: the secret that lets a browser or a program do more than read over the cable. */
#include <errno.h>

#include "commands.h"
#include "ttf/config/daemon_file.h"
#include "ttf/http/token.h"

#define DEFAULT_CONFIG "/etc/ttfbox/ttfboxd.yaml"

int cmd_token(struct cli *cli)
{
    const char *path = cli->opt.n_args > 0 ? cli->opt.args[0] : DEFAULT_CONFIG;
    struct ttf_daemon_config config;
    char token[TTF_HTTP_TOKEN_SIZE];
    int r = ttf_daemon_file_load(path, &config, &cli->err);

    if (r < 0)
        return r;
    r = ttf_http_token_read(config.token_file, token, &cli->err);
    if (r == -ENOENT)
        ttf_err_hint(&cli->err, "ttfboxd makes it at its first start");
    else if (r == -EACCES)
        ttf_err_hint(&cli->err, "it is the service's: sudo ttfbox token");
    if (r < 0)
        return r;
    cli_say(cli, "%s", token);
    ttf_json_kstring(&cli->out, "token", token);
    return 0;
}
