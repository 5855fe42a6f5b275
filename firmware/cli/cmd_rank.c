/* SPDX-License-Identifier: Apache-2.0 */
/* cmd_rank.c: `ttfbox synth rank`: figure 5 of Enrique et al. 2005 for any sequence. */
#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "commands.h"
#include "quilt_input.h"
#include "rank_plot.h"
#include "ttf/synth/rank_curve.h"

/* The plot's name: the table's with another ending. */
static int name_plot(struct cli *cli, char *buf, size_t size)
{
    const char *table = cli->opt.output, *slash = strrchr(table, '/');
    const char *dot = strrchr(slash ? slash : table, '.');
    int n =
        (int)(dot && dot > (slash ? slash + 1 : table) ? dot - table : (ptrdiff_t)strlen(table));

    if ((size_t)n + 5 > size)
        return ttf_err_set(&cli->err, -ENAMETOOLONG, "-o", "the path is too long");
    (void)snprintf(buf, size, "%.*s.svg", n, table);
    if (strcmp(buf, table) != 0)
        return 0;
    ttf_err_set(&cli->err, -EINVAL, "-o", "'%s' is the plot's name", table);
    return ttf_err_hint(&cli->err, "name the table, as curve.csv"), -EINVAL;
}

static int configure(struct cli *cli, struct ttf_quilt_config *ret)
{
    const struct cli_options *o = &cli->opt;

    ttf_quilt_defaults(ret);
    ret->rank = cli_given(o, OPT_RANK) ? (unsigned)o->rank : TTF_QUILT_RANK_MAX;
    ret->cancel = cli_stop_flag();
    if (ret->rank == TTF_QUILT_RANK_FULL) {
        ttf_err_set(&cli->err, -EINVAL, "--rank", "full is no rank of a curve");
        return ttf_err_hint(&cli->err, "a number from 1 to 64"), -EINVAL;
    }
    if (o->metric && ttf_metric_find(o->metric) < 0) {
        ttf_err_set(&cli->err, -EINVAL, "--metric", "'%s' is no space", o->metric);
        return ttf_err_hint(&cli->err, "display or linear"), -EINVAL;
    }
    if (o->metric)
        ret->metric = (enum ttf_metric)ttf_metric_find(o->metric);
    if (o->svd && strcmp(o->svd, "joint") != 0 && strcmp(o->svd, "channels") != 0) {
        ttf_err_set(&cli->err, -EINVAL, "--svd", "'%s' is no way to compress", o->svd);
        return ttf_err_hint(&cli->err, "joint or channels"), -EINVAL;
    }
    ret->per_channel = o->svd && strcmp(o->svd, "channels") == 0;
    return 0;
}

/* title NULL: the table. All of it or nothing. */
static int write_one(struct cli *cli, const char *path, const struct ttf_quilt_rank_curve *curve,
                     const char *title)
{
    char *text = NULL;
    size_t bytes = 0;
    FILE *out = open_memstream(&text, &bytes);
    int r = -ENOMEM;

    if (!out)
        return ttf_err_set(&cli->err, r, NULL, "no memory");
    if (title)
        rank_plot(out, curve, title);
    else
        rank_table(out, curve);
    if (fclose(out) == 0)
        r = ttf_io_write_file(cli->io, path, text, bytes, &cli->err);
    else
        ttf_err_set(&cli->err, r, NULL, "no memory");
    free(text);
    return r;
}

static int write_both(struct cli *cli, const char *plot, const struct ttf_quilt_rank_curve *curve,
                      const struct quilt_input *input)
{
    bool simulated = input->reader && ttf_reader_manifest(input->reader)->simulated;
    char title[200];
    int r = write_one(cli, cli->opt.output, curve, NULL);

    (void)snprintf(title, sizeof title, "%.120s: what rank k misses%s", cli->opt.args[0],
                   simulated ? " (SIMULATED)" : "");
    if (r < 0)
        return r;
    r = write_one(cli, plot, curve, title);
    if (r < 0)
        (void)cli->io->ops->unlink(cli->io, cli->opt.output);
    return r;
}

static void say(struct cli *cli, const char *plot, const struct ttf_quilt_rank_curve *curve,
                const struct quilt_input *input)
{
    bool simulated = input->reader && ttf_reader_manifest(input->reader)->simulated;
    unsigned last = curve->n - 1;

    cli_say(cli, "%stable             %s", simulated ? "SIMULATED\n" : "", cli->opt.output);
    cli_say(cli, "plot              %s", plot);
    for (unsigned k = 1; k <= last; k = k < 15 && last >= 15 ? (k < 5 ? 5 : 15)
                                        : k < last           ? last
                                                             : k + 1)
        cli_say(cli, "rank %-12u misses %.3f %%", k, 100 * curve->errors[k]);
    ttf_json_kstring(&cli->out, "table", cli->opt.output);
    ttf_json_kstring(&cli->out, "plot", plot);
    ttf_json_kbool(&cli->out, "simulated", simulated);
    ttf_json_kint(&cli->out, "frames", quilt_input_top(input)->n);
    ttf_json_key(&cli->out, "errors_by_rank");
    ttf_json_array(&cli->out);
    for (unsigned k = 0; k < curve->n; k++)
        ttf_json_double(&cli->out, curve->errors[k]);
    ttf_json_array_end(&cli->out);
}

/* All that can be refused before anything is read. */
static int check(struct cli *cli, struct ttf_quilt_config *config, char *plot, size_t size)
{
    int r = cli_need(cli, cli->opt.output, "-o", "say where the table goes, as -o curve.csv");

    if (r == 0)
        r = configure(cli, config);
    if (r == 0)
        r = name_plot(cli, plot, size);
    if (r == 0)
        r = cli_refuse_existing(cli, cli->opt.output);
    return r < 0 ? r : cli_refuse_existing(cli, plot);
}

int cmd_synth_rank(struct cli *cli)
{
    struct quilt_input input = {0};
    struct ttf_quilt_config config;
    struct ttf_quilt_rank_curve curve;
    struct ttf_pool *pool = NULL;
    char plot[PATH_MAX];
    int r = check(cli, &config, plot, sizeof plot);

    if (r == 0)
        r = quilt_input_open(cli, cli->opt.args[0], &input);
    if (r == 0) {
        cli_stop_catch();
        pool = ttf_pool_create((unsigned)cli->opt.threads);
        r = pool ? ttf_quilt_rank_curve(&config, quilt_input_top(&input), pool, &curve, &cli->err)
                 : -ENOMEM;
    }
    if (r == 0)
        r = write_both(cli, plot, &curve, &input);
    if (r == 0)
        say(cli, plot, &curve, &input);
    ttf_pool_destroy(pool);
    quilt_input_close(&input);
    return r;
}
