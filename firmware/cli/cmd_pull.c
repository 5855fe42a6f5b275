/* SPDX-License-Identifier: Apache-2.0 */
/* cmd_pull.c: `ttfbox pull`: datasets of a box, brought here. */
#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "commands.h"
#include "ttf/dataset/json_parse.h"
#include "ttf/hal/clock.h"
#include "ttf/http/token.h"
#include "ttf/pull/ask.h"
#include "ttf/pull/pull.h"
#include "usb_box.h"

#define NAMES_MAX 64

struct show {
    const struct cli *cli;
    struct cli_progress bar;
    char dataset[65]; /* whose bar it is */
    int64_t since_ns, since_bytes, since_slots;
    char label[80];
};

/* Speed since this dataset's first byte, and how long the rest takes at the pace of its slots. */
static void show_pace(struct show *show, const struct ttf_pull_progress *p)
{
    double s = (double)(p->now_ns - show->since_ns) / 1e9;
    int64_t done = p->slots_done - show->since_slots, left = p->slots - p->slots_done;
    char text[80];
    int n;

    if (s <= 0)
        return;
    n = snprintf(text, sizeof text, "slots, %.1f MB/s",
                 (double)(p->bytes - show->since_bytes) / 1e6 / s);
    if (done > 0 && left > 0)
        (void)snprintf(text + n, sizeof text - (size_t)n, ", %.0f s left",
                       s * (double)left / (double)done);
    cli_progress_at(&show->bar, p->slots_done, p->slots, text);
}

static void on_progress(void *ctx, const struct ttf_pull_progress *p)
{
    struct show *show = ctx;

    if (p->text) {
        cli_progress_end(&show->bar);
        cli_warn("ttfbox: %s: %s", p->dataset, p->text);
        return;
    }
    if (strcmp(show->dataset, p->dataset) != 0) {
        cli_progress_end(&show->bar);
        (void)snprintf(show->dataset, sizeof show->dataset, "%.64s", p->dataset);
        (void)snprintf(show->label, sizeof show->label, "pulling %s", show->dataset);
        cli_progress_begin(&show->bar, show->cli, show->label);
        show->since_ns = p->now_ns;
        show->since_bytes = p->bytes;
        show->since_slots = p->slots_done;
    }
    show_pace(show, p);
}

/* "a,b" as names. They live as long as *text. */
static int take_names(struct cli *cli, char *text, const char *names[NAMES_MAX + 1])
{
    unsigned n = 0;
    char *save = NULL;

    for (char *name = strtok_r(text, ",", &save); name; name = strtok_r(NULL, ",", &save)) {
        if (n == NAMES_MAX)
            return ttf_err_set(&cli->err, -EINVAL, "--only", "more than %d names", NAMES_MAX);
        names[n++] = name;
    }
    names[n] = NULL;
    return n > 0 ? 0 : ttf_err_set(&cli->err, -EINVAL, "--only", "names nothing");
}

static int list(struct cli *cli, const struct ttf_pull_config *config)
{
    char *text = NULL;
    json_t *json;
    int r = ttf_pull_list(config, &text, &cli->err);

    if (r < 0)
        return r;
    r = ttf_json_parse(text, strlen(text), &json, NULL);
    if (r < 0) {
        free(text);
        return ttf_err_set(&cli->err, r == -EINVAL ? -EPROTO : r, config->box,
                           "the box's answer is no JSON");
    }
    json_decref(json);
    ttf_json_key(&cli->out, "box");
    ttf_json_raw(&cli->out, text);
    cli_say(cli, "%s", text);
    free(text);
    return 0;
}

/* A box without network and battery does not know what time it is. Whatever comes of it, the pull goes on. */
static void offer_time(struct cli *cli, const struct ttf_pull_config *config)
{
    if (config->token && ttf_pull_offer_time(config, NULL) == 1)
        cli_say(cli, "the box          took this machine's time: it had none better");
}

static int pull(struct cli *cli, struct ttf_pull_config *config)
{
    struct show show = {.cli = cli};
    struct ttf_pull_result result;
    struct ttf_json *j = &cli->out;
    int64_t begun = ttf_clock_now_ns(config->clock);
    double s;
    int r;

    cli_stop_catch();
    config->stop = cli_stop_flag();
    config->progress = on_progress;
    config->progress_ctx = &show;
    offer_time(cli, config);
    r = ttf_pull(config, &result, &cli->err);
    s = (double)(ttf_clock_now_ns(config->clock) - begun) / 1e9;
    cli_progress_end(&show.bar);
    if (r < 0)
        return r;
    ttf_json_kint(j, "datasets", result.datasets);
    ttf_json_kint(j, "sealed", result.sealed);
    ttf_json_kint(j, "slots", result.slots);
    ttf_json_kint(j, "files", result.files);
    ttf_json_kint(j, "bytes", result.bytes);
    ttf_json_kint(j, "damaged", result.damaged);
    ttf_json_kbool(j, "stopped", result.stopped);
    cli_say(cli, "datasets          %" PRId64 " in %s, %" PRId64 " of them sealed", result.datasets,
            config->dest, result.sealed);
    cli_say(cli, "slots             %" PRId64, result.slots);
    cli_say(cli, "came              %" PRId64 " files, %.1f MB in %.1f s (%.1f MB/s)", result.files,
            (double)result.bytes / 1e6, s, s > 0 ? (double)result.bytes / 1e6 / s : 0);
    if (result.stopped)
        cli_say(cli, "stopped           run it again, and it goes on");
    return result.stopped && !config->follow ? CLI_FAILED : 0;
}

int cmd_pull(struct cli *cli)
{
    char token[TTF_HTTP_TOKEN_SIZE];
    const char *names[NAMES_MAX + 1];
    struct ttf_pull_config config = {
        .io = cli->io,
        .box = cli->opt.box,
        .dest = cli->opt.n_args > 0 ? cli->opt.args[0] : ".",
        .follow = cli->opt.follow,
    };
    char *only = cli->opt.only ? strdup(cli->opt.only) : NULL;
    struct usb_bridge *bridge = NULL;
    int r = 0;

    if (cli->opt.usb && config.box)
        r = ttf_err_set(&cli->err, -EINVAL, "--usb", "and --box are one too many");
    else if (cli->opt.usb)
        config.box = "usb";
    if (r == 0)
        r = cli_need(cli, config.box, "--box", "as --box http://192.168.7.1:8417, or --usb");
    if (r == 0 && cli->opt.only)
        r = only ? take_names(cli, only, names)
                 : ttf_err_set(&cli->err, -ENOMEM, NULL, "no memory");
    if (r == 0 && only)
        config.names = names;
    if (r == 0 && cli->opt.token_file) {
        r = ttf_http_token_read(cli->opt.token_file, token, &cli->err);
        config.token = token;
    }
    if (r == 0) {
        config.clock = ttf_clock_real_create();
        if (!config.clock)
            r = ttf_err_set(&cli->err, -errno, "clock", "the machine's clock cannot be had");
    }
    if (r == 0 && usb_box_is(config.box)) {
        r = usb_bridge_begin(config.box, config.follow, config.clock, &bridge, &cli->err);
        config.box = bridge ? usb_bridge_where(bridge) : NULL;
        config.ended = usb_bridge_ended;
        config.ended_ctx = bridge;
    }
    if (r == 0)
        r = cli->opt.list ? list(cli, &config) : pull(cli, &config);
    usb_bridge_end(bridge);
    ttf_clock_destroy(config.clock);
    free(only);
    return r;
}
