/* SPDX-License-Identifier: Apache-2.0 */
/* cmd_sample.c: `ttfbox sample`: which part of the picture is which sample, in a dataset's samples.json. */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "commands.h"
#include "sample_table.h"
#include "ttf/capture/note.h"
#include "ttf/config/units.h"
#include "ttf/hal/clock.h"

/* "X,Y,WxH" */
static int take_region(const char *text, struct ttf_sample_rect *ret, struct ttf_err *err)
{
    const char *y = strchr(text, ','), *size = y ? strchr(y + 1, ',') : NULL;
    uint32_t width = 0, height = 0;
    char part[2][24];
    int r = -EINVAL;

    if (size && y - text < (ptrdiff_t)sizeof part[0] && size - y <= (ptrdiff_t)sizeof part[1]) {
        (void)snprintf(part[0], sizeof part[0], "%.*s", (int)(y - text), text);
        (void)snprintf(part[1], sizeof part[1], "%.*s", (int)(size - y - 1), y + 1);
        r = ttf_integer_parse(part[0], &ret->x, NULL);
        r = r ? r : ttf_integer_parse(part[1], &ret->y, NULL);
        r = r ? r : ttf_size_parse(size + 1, &width, &height, NULL);
    }
    if (r) {
        ttf_err_set(err, -EINVAL, "--region", "'%.60s' is no region", text);
        ttf_err_hint(err,
                     "write X,Y,WxH, pixels from the picture's top left corner, as 120,80,400x300; "
                     "W and H from 1 to 65535");
        return -EINVAL;
    }
    ret->width = width;
    ret->height = height;
    return 0;
}

static int change(struct cli *cli, const char *path, const struct ttf_sample_change *changes,
                  unsigned n)
{
    struct ttf_clock *clock = ttf_clock_real_create();
    int r;

    if (!clock)
        return ttf_err_set(&cli->err, -ENOMEM, path, "no memory");
    r = ttf_samples_say(clock, cli->io, path, changes, n, &cli->err);
    ttf_clock_destroy(clock);
    return r;
}

static int change_one(struct cli *cli, const char *path, const char *id)
{
    struct ttf_sample_change one = {.id = id,
                                    .remove = cli->opt.remove,
                                    .title = cli->opt.title,
                                    .treatment = cli->opt.treatment};
    struct ttf_sample_rect region;
    int r = 0;

    if (one.remove && (cli->opt.region || one.title || one.treatment))
        return ttf_err_set(&cli->err, -EINVAL, "--remove", "nothing else can be said with it");
    if (!one.remove && !cli->opt.region && !one.title && !one.treatment) {
        ttf_err_set(&cli->err, -EINVAL, id, "nothing is said of this sample");
        ttf_err_hint(&cli->err, "say --region, --title, --treatment or --remove");
        return -EINVAL;
    }
    if (cli->opt.region) {
        r = take_region(cli->opt.region, &region, &cli->err);
        one.region = &region;
    }
    return r ? r : change(cli, path, &one, 1);
}

static int change_by_table(struct cli *cli, const char *path, unsigned *ret_n)
{
    struct sample_table table;
    int r = 0;

    if (cli->opt.n_args > 1 || cli->opt.remove || cli->opt.region || cli->opt.title ||
        cli->opt.treatment)
        return ttf_err_set(&cli->err, -EINVAL, "--table", "nothing else can be said with it");
    r = sample_table_read(cli->io, cli->opt.table, &table, &cli->err);
    *ret_n = table.n;
    if (r == 0)
        r = change(cli, path, table.changes, table.n);
    sample_table_free(&table);
    return r;
}

/* What was changed, and what the file holds by now. */
static int say(struct cli *cli, const char *path, unsigned changed)
{
    struct ttf_sample_region *regions = NULL;
    unsigned n = 0;
    int r = ttf_samples_read(cli->io, path, &regions, &n, &cli->err);

    free(regions);
    if (r < 0)
        return r;
    cli_say(cli, "samples           %u %s, %u now in %s/samples.json", changed,
            cli->opt.remove ? "removed" : "set", n, path);
    ttf_json_kstring(&cli->out, "dataset", path);
    ttf_json_kint(&cli->out, "samples", changed);
    ttf_json_kint(&cli->out, "samples_now", n);
    return 0;
}

int cmd_sample(struct cli *cli)
{
    const char *path = cli->opt.args[0];
    unsigned n = 1;
    int r;

    if (cli->opt.table)
        r = change_by_table(cli, path, &n);
    else if (cli->opt.n_args > 1)
        r = change_one(cli, path, cli->opt.args[1]);
    else
        r = cli_need(cli, NULL, "ID", "say which sample, or --table FILE for many");
    return r ? r : say(cli, path, n);
}
