/* SPDX-License-Identifier: Apache-2.0 */
/* cmd_import.c: `ttfbox import`. */
#include <errno.h>
#include <inttypes.h>
#include <string.h>

#include "commands.h"
#include "ttf/dataset/import.h"

static int on_progress(void *ctx, int64_t done, int64_t total)
{
    cli_progress_at(ctx, done, total, NULL);
    return *cli_stop_flag();
}

static int choose(struct cli *cli, struct ttf_import_config *config)
{
    const char *transfer = cli->opt.transfer;

    if (cli->opt.order) {
        int order = ttf_import_order_find(cli->opt.order);

        if (order < 0) {
            ttf_err_set(&cli->err, -EINVAL, "--order", "'%s' is no order", cli->opt.order);
            ttf_err_hint(&cli->err, "natural, given, exif-time or name-time");
            return -EINVAL;
        }
        config->order = (enum ttf_import_order)order;
    }
    if (!transfer || strcmp(transfer, "auto") == 0)
        config->transfer = TTF_TRANSFER_AUTO;
    else if (strcmp(transfer, "srgb") == 0)
        config->transfer = TTF_TRANSFER_SRGB;
    else if (strcmp(transfer, "linear") == 0)
        config->transfer = TTF_TRANSFER_LINEAR;
    else {
        ttf_err_set(&cli->err, -EINVAL, "--transfer", "'%s' is no curve", transfer);
        ttf_err_hint(&cli->err, "auto, srgb or linear");
        return -EINVAL;
    }
    return 0;
}

int cmd_import(struct cli *cli)
{
    struct cli_progress bar;
    struct ttf_import_result result;
    struct ttf_import_config config = {
        .inputs = cli->opt.args,
        .n_inputs = cli->opt.n_args,
        .output = cli->opt.output,
        .interval_ns = cli->opt.interval_ns,
        .mm_per_px = cli->opt.mm_per_px,
        .title = cli->opt.title,
        .origin_utc_ns = 0,
        .progress = on_progress,
        .progress_ctx = &bar,
    };
    int r = cli_need(cli, cli->opt.output, "-o", "say where the dataset goes, as -o copper");

    if (r == 0 && cli->opt.title && !*cli->opt.title)
        r = ttf_err_set(&cli->err, -EINVAL, "--title", "is empty");
    if (r == 0)
        r = cli_refuse_existing(cli, cli->opt.output);
    if (r == 0)
        r = choose(cli, &config);
    if (r < 0)
        return r;
    cli_stop_catch();
    cli_progress_begin(&bar, cli, "importing");
    r = ttf_import(cli->io, &config, &result, &cli->err);
    cli_progress_end(&bar);
    if (r < 0)
        return r;
    cli_say(cli, "dataset           %s", cli->opt.output);
    cli_say(cli,
            "frames            %" PRId64 " of %u x %u, one every %.6g s, %" PRId64
            " slots without an image",
            result.frames, result.width, result.height, (double)result.interval_ns / 1e9,
            result.missed);
    if (result.alpha_dropped)
        cli_say(cli, "alpha             left out: a dataset has none");
    if (result.foreign_profile)
        cli_say(cli, "colour profile    of the pictures was not applied: taken as sRGB");
    cli_say(cli, "sealed            digest %s", result.digest);
    ttf_json_kstring(&cli->out, "dataset", cli->opt.output);
    ttf_json_kint(&cli->out, "frames", result.frames);
    ttf_json_kint(&cli->out, "missed", result.missed);
    ttf_json_kint(&cli->out, "interval_ns", result.interval_ns);
    ttf_json_kint(&cli->out, "width", result.width);
    ttf_json_kint(&cli->out, "height", result.height);
    ttf_json_kbool(&cli->out, "alpha_dropped", result.alpha_dropped);
    ttf_json_kbool(&cli->out, "foreign_profile", result.foreign_profile);
    ttf_json_kstring(&cli->out, "digest", result.digest);
    return CLI_DONE;
}
