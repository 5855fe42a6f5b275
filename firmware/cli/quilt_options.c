/* SPDX-License-Identifier: Apache-2.0 */
/* quilt_options.c: see quilt_options.h. */
#include "quilt_options.h"

#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "commands.h"

#define PREVIEW_MEMORY (64 << 20)

/* ---- what goes together ---- */

enum rule_kind {
    APART = 0, /* not both */
    NEEDS      /* the first only with the second */
};

struct rule {
    enum rule_kind kind;
    enum cli_option a, b;
    const char *hint;
};

#define FIXED    "the map says it already"
#define ONE_RATE "give one control of the pace"
#define FULL     "give a rank: the search over all frames has none"
#define NO_COPY  "such an output is no plain copy of its input"

static const struct rule RULES[] = {
    {APART, OPT_RANK, OPT_RANK_ERROR, "the one sets the rank, the other finds it"},
    {APART, OPT_RATE_MAP, OPT_LIGHT, ONE_RATE},
    {APART, OPT_RATE_MAP, OPT_CURVATURE, ONE_RATE},
    {APART, OPT_LIGHT, OPT_CURVATURE, ONE_RATE},
    {APART, OPT_NORMALS, OPT_HEIGHTS, "either says how the surface is turned"},
    {NEEDS, OPT_NORMALS, OPT_LIGHT, "as --light 0.5,0.3,0.4"},
    {NEEDS, OPT_HEIGHTS, OPT_LIGHT, "as --light 0.5,0.3,0.4"},
    {NEEDS, OPT_KEEP_GRADIENT, OPT_FLATTEN, "there is no gradient otherwise"},
    {APART, OPT_KEEP_GRADIENT, OPT_TILEABLE, "a gradient does not fit its other side"},
    {NEEDS, OPT_FLATTEN_SIGMA, OPT_FLATTEN, "it says what --flatten takes for slow"},
    {NEEDS, OPT_DEFLICKER_WINDOW, OPT_DEFLICKER, "it says how many frames --deflicker looks at"},
    {NEEDS, OPT_TIME, OPT_PREVIEW, "a whole synthesis takes the time it needs"},
    {APART, OPT_FIGURES, OPT_NO_FIGURES, "either measure or do not"},
    {APART, OPT_FACTORS, OPT_PER_FRAME, "frames quilted alone have no compression"},
    {APART, OPT_SAVE_MAP, OPT_PER_FRAME, "frames quilted alone have no one map"},
    {APART, OPT_AGREEMENT, OPT_PER_FRAME, "frames quilted alone have no one map"},
    {APART, OPT_AGREEMENT, OPT_SOURCE, "it is measured of one input"},
    {APART, OPT_AGREEMENT, OPT_MIRROR, "it is measured of blocks that are not turned"},
    {APART, OPT_AGREEMENT, OPT_FLIPS, "it is measured of blocks that are not turned"},
    {APART, OPT_AGREEMENT, OPT_ROTATIONS, "it is measured of blocks that are not turned"},
    {APART, OPT_AGREEMENT, OPT_TILEABLE, "it is measured of plain outputs"},
    {APART, OPT_AGREEMENT, OPT_AVOID, "it is measured of plain matching"},
    {APART, OPT_PER_FRAME, OPT_JITTER, "frames quilted alone have no time of their own"},
    {APART, OPT_PER_FRAME, OPT_RATE_MAP, "frames quilted alone have no time of their own"},
    {APART, OPT_PER_FRAME, OPT_LIGHT, "frames quilted alone have no time of their own"},
    {APART, OPT_PER_FRAME, OPT_CURVATURE, "frames quilted alone have no time of their own"},
    {APART, OPT_PER_FRAME, OPT_SOURCE, "frames quilted alone have one input"},
    {APART, OPT_CHECK, OPT_JITTER, NO_COPY},
    {APART, OPT_CHECK, OPT_RATE_MAP, NO_COPY},
    {APART, OPT_CHECK, OPT_LIGHT, NO_COPY},
    {APART, OPT_CHECK, OPT_CURVATURE, NO_COPY},
    {APART, OPT_CHECK, OPT_KEEP_GRADIENT, NO_COPY},
    {APART, OPT_MAP, OPT_SIZE, FIXED},
    {APART, OPT_MAP, OPT_BLOCK, FIXED},
    {APART, OPT_MAP, OPT_OVERLAP, FIXED},
    {APART, OPT_MAP, OPT_TOLERANCE, FIXED},
    {APART, OPT_MAP, OPT_SEED, FIXED},
    {APART, OPT_MAP, OPT_METRIC, FIXED},
    {APART, OPT_MAP, OPT_PER_FRAME, FIXED},
    {APART, OPT_MAP, OPT_FEATHER, FIXED},
    {APART, OPT_MAP, OPT_RANK, FIXED},
    {APART, OPT_MAP, OPT_RANK_ERROR, FIXED},
    {APART, OPT_MAP, OPT_SVD, FIXED},
    {APART, OPT_MAP, OPT_FACTORS, "nothing is matched where a map is given"},
    {APART, OPT_MAP, OPT_JITTER, FIXED},
    {APART, OPT_MAP, OPT_MIRROR, FIXED},
    {APART, OPT_MAP, OPT_FLIPS, FIXED},
    {APART, OPT_MAP, OPT_ROTATIONS, FIXED},
    {APART, OPT_MAP, OPT_TILEABLE, FIXED},
    {APART, OPT_MAP, OPT_AVOID, FIXED},
    {APART, OPT_MAP, OPT_SAVE_MAP, "it would be the same"},
    {APART, OPT_MAP, OPT_AGREEMENT, "nothing is matched where a map is given"},
    {APART, OPT_MAP, OPT_PREVIEW, "a map is of inputs of one size"},
};

static int check_rules(struct cli *cli)
{
    for (unsigned i = 0; i < TTF_COUNT_OF(RULES); i++) {
        const struct rule *rule = &RULES[i];
        char name[40];

        if (!cli_given(&cli->opt, rule->a) ||
            cli_given(&cli->opt, rule->b) != (rule->kind == APART))
            continue;
        (void)snprintf(name, sizeof name, "--%s", cli_option_def(rule->a)->name);
        ttf_err_set(&cli->err, -EINVAL, name,
                    rule->kind == APART ? "does not go together with --%s" : "needs --%s",
                    cli_option_def(rule->b)->name);
        return ttf_err_hint(&cli->err, "%s", rule->hint), -EINVAL;
    }
    return 0;
}

static int refuse(struct cli *cli, const char *option, const char *what, const char *hint)
{
    ttf_err_set(&cli->err, -EINVAL, option, "%s", what);
    return ttf_err_hint(&cli->err, "%s", hint), -EINVAL;
}

static bool is_full(const struct cli_options *o)
{
    return o->rank == 0;
}

static int check_full(struct cli *cli)
{
    static const enum cli_option PAST[] = {OPT_SVD,      OPT_FACTORS, OPT_SOURCE,
                                           OPT_MIRROR,   OPT_FLIPS,   OPT_ROTATIONS,
                                           OPT_TILEABLE, OPT_AVOID,   OPT_AGREEMENT};
    char what[80];

    for (unsigned i = 0; is_full(&cli->opt) && i < TTF_COUNT_OF(PAST); i++) {
        if (!cli_given(&cli->opt, PAST[i]))
            continue;
        (void)snprintf(what, sizeof what, "full does not go together with --%s",
                       cli_option_def(PAST[i])->name);
        return refuse(cli, "--rank", what, FULL);
    }
    return 0;
}

bool quilt_options_pace(const struct cli *cli)
{
    const struct cli_options *o = &cli->opt;

    return o->rate_map || cli_given(o, OPT_LIGHT) || o->curvature ||
           cli->command->run == cmd_synth_composite;
}

static int check_control(struct cli *cli)
{
    const struct cli_options *o = &cli->opt;
    bool heights = o->heights || (o->curvature && strcmp(o->curvature, "sigmoid") != 0);

    if ((cli_given(o, OPT_RATE_OFFSET) || cli_given(o, OPT_RATE_GAIN)) && !quilt_options_pace(cli))
        return refuse(cli, cli_given(o, OPT_RATE_GAIN) ? "--rate-gain" : "--rate-offset",
                      "there is no control of the pace",
                      "give --rate-map, --light or --curvature too");
    if (cli_given(o, OPT_HEIGHT_SCALE) && !heights)
        return refuse(cli, "--height-scale", "there are no heights",
                      "give --heights, or a picture to --curvature");
    if (cli_given(o, OPT_LIGHT) && !(o->light[2] > 0))
        return refuse(cli, "--light", "a light must be above the plane",
                      "give a third number greater than 0, as 0.5,0.3,0.4");
    if (o->jitter_rounded && !cli_given(o, OPT_JITTER) && !o->map && !quilt_options_pace(cli))
        return refuse(cli, "--jitter-rounded", "there are no times between frames",
                      "give --jitter or a control of the pace too");
    if (cli_given(o, OPT_JITTER_EVERY) && !cli_given(o, OPT_JITTER))
        return refuse(cli, "--jitter-every", "no block has a time of its own", "give --jitter too");
    return 0;
}

static int check_words(struct cli *cli)
{
    const struct cli_options *o = &cli->opt;
    const char *compress = o->compress;

    if (compress && strcmp(compress, "none") != 0 && strcmp(compress, "deflate") != 0) {
        ttf_err_set(&cli->err, -EINVAL, "--compress", "'%s' is no compression", compress);
        return ttf_err_hint(&cli->err, "none or deflate"), -EINVAL;
    }
    if (o->metric && ttf_metric_find(o->metric) < 0) {
        ttf_err_set(&cli->err, -EINVAL, "--metric", "'%s' is no space", o->metric);
        return ttf_err_hint(&cli->err, "display or linear"), -EINVAL;
    }
    if (o->svd && strcmp(o->svd, "joint") != 0 && strcmp(o->svd, "channels") != 0) {
        ttf_err_set(&cli->err, -EINVAL, "--svd", "'%s' is no way to compress", o->svd);
        return ttf_err_hint(&cli->err, "joint or channels"), -EINVAL;
    }
    if (o->deflicker_window % 2 == 0)
        return refuse(cli, "--deflicker-window", "must be odd",
                      "a frame is in its window's middle");
    return 0;
}

/* ---- where things go ---- */

/* Where a path will lie: its folder's real name and its own. -errno without such a folder. */
static int real_name(const char *path, char *ret, size_t size)
{
    char folder[PATH_MAX], real[PATH_MAX];
    size_t n = strlen(path);
    const char *base;

    while (n > 1 && path[n - 1] == '/')
        n--;
    for (base = path + n; base > path && base[-1] != '/';)
        base--;
    if (n >= sizeof folder)
        return -ENAMETOOLONG;
    (void)snprintf(folder, sizeof folder, "%.*s", base > path ? (int)(base - path) : 1,
                   base > path ? path : ".");
    if (!realpath(folder, real))
        return -errno;
    (void)snprintf(ret, size, "%s/%.*s", real[1] ? real : "", (int)(path + n - base), base);
    return 0;
}

/* A file beside the result: in a folder that is there, not in a dataset, and not the result. */
static int check_beside(struct cli *cli, const char *option, const char *path, const char *other)
{
    char file[2 * PATH_MAX], out[2 * PATH_MAX];
    int r = real_name(path, file, sizeof file);
    size_t n;

    if (r < 0) {
        ttf_err_set(&cli->err, r, option, "%s: there is no such folder", path);
        return ttf_err_hint(&cli->err, "make the folder first"), r;
    }
    r = cli_refuse_inside_dataset(cli, path);
    if (r < 0 || !other || real_name(other, out, sizeof out) < 0)
        return r;
    n = strlen(out);
    if (strncmp(file, out, n) != 0 || (file[n] && file[n] != '/'))
        return 0;
    ttf_err_set(&cli->err, -EINVAL, option, "%s lies where %s will be", path, other);
    return ttf_err_hint(&cli->err, "name another place"), -EINVAL;
}

static int check_outputs(struct cli *cli, enum quilt_sink_kind kind)
{
    const struct cli_options *o = &cli->opt;
    int r = 0;

    if (o->check && kind != QUILT_SINK_DATASET)
        return ttf_err_set(&cli->err, -EINVAL, "--check", "needs a dataset to read back");
    if (kind != QUILT_SINK_NULL) {
        r = cli_need(cli, o->output, "-o", "say where the result goes, as -o big");
        if (r == 0)
            r = cli_refuse_existing(cli, o->output);
    }
    if (r == 0 && o->save_map)
        r = cli_refuse_existing(cli, o->save_map);
    if (r == 0 && o->save_map)
        r = check_beside(cli, "--save-map", o->save_map, o->output);
    if (r == 0 && o->factors)
        r = check_beside(cli, "--factors", o->factors, o->output);
    if (r == 0 && o->factors && o->save_map)
        r = check_beside(cli, "--factors", o->factors, o->save_map);
    return r;
}

int quilt_options_check(struct cli *cli, enum quilt_sink_kind *ret_kind)
{
    int kind = quilt_sink_find(cli->opt.sink ? cli->opt.sink : "dataset");
    int r;

    if (kind < 0) {
        ttf_err_set(&cli->err, -EINVAL, "--sink", "'%s' is no sink", cli->opt.sink);
        return ttf_err_hint(&cli->err, "dataset, raw or null"), -EINVAL;
    }
    *ret_kind = (enum quilt_sink_kind)kind;
    r = check_words(cli);
    if (r == 0)
        r = check_rules(cli);
    if (r == 0)
        r = check_full(cli);
    if (r == 0)
        r = check_control(cli);
    return r < 0 ? r : check_outputs(cli, *ret_kind);
}

/* ---- as a configuration ---- */

static void set_matching(const struct cli_options *o, struct ttf_quilt_config *c)
{
    c->tolerance = o->tolerance;
    c->seed = (uint64_t)o->seed;
    if (o->metric)
        c->metric = (enum ttf_metric)ttf_metric_find(o->metric);
    c->rank = (unsigned)o->rank;
    c->rank_error = o->rank_error / 100;
    c->per_channel = o->svd && strcmp(o->svd, "channels") == 0;
    c->mirror = o->mirror;
    c->flips = o->flips;
    c->rotations = o->rotations;
    c->tileable = o->tileable;
    c->avoid_px = (uint32_t)o->avoid;
    c->agreement_queries = (unsigned)o->agreement;
    if (o->preview && !cli_given(o, OPT_MEMORY))
        c->memory_bytes = PREVIEW_MEMORY;
    else
        c->memory_bytes = (size_t)o->memory_bytes;
}

int quilt_options_config(struct cli *cli, enum quilt_sink_kind kind, struct ttf_quilt_config *ret)
{
    const struct cli_options *o = &cli->opt;

    ttf_quilt_defaults(ret);
    ret->width = o->size[0];
    ret->height = o->size[1];
    if (o->block[0] && !o->block_auto) {
        ret->block_width = o->block[0];
        ret->block_height = o->block[1];
    }
    ret->overlap_x = o->overlap[0];
    ret->overlap_y = o->overlap[1];
    ret->per_frame = o->per_frame;
    ret->feather_px = (uint32_t)o->feather;
    ret->jitter_frames = (uint32_t)o->jitter;
    ret->jitter_round = o->jitter_rounded;
    ret->jitter_every = (uint32_t)o->jitter_every;
    ret->measure = o->figures || (kind == QUILT_SINK_DATASET && !o->no_figures);
    set_matching(o, ret);
    return 0;
}

static uint32_t divided(uint32_t value, uint32_t by, uint32_t least)
{
    return value / by > least ? value / by : least;
}

uint32_t quilt_frames_kept(uint32_t frames, uint32_t step, uint32_t least)
{
    uint32_t kept = (frames + step / 2) / step;

    return kept > least ? kept : least;
}

static void shrink_lengths(struct ttf_quilt_config *c, uint32_t shrink)
{
    if (c->width) {
        c->width = divided(c->width, shrink, 1);
        c->height = divided(c->height, shrink, 1);
    }
    c->block_width = divided(c->block_width, shrink, 4);
    c->block_height = divided(c->block_height, shrink, 4);
    if (c->overlap_x) {
        c->overlap_x = divided(c->overlap_x, shrink, 1);
        c->overlap_y = divided(c->overlap_y, shrink, 1);
    }
    c->avoid_px = c->avoid_px ? divided(c->avoid_px, shrink, 1) : 0;
    c->feather_px /= shrink;
}

void quilt_config_reduce(struct ttf_quilt_config *c, uint32_t shrink, uint32_t step)
{
    if (shrink > 1)
        shrink_lengths(c, shrink);
    c->jitter_frames = quilt_frames_kept(c->jitter_frames, step, 0);
    c->jitter_every = quilt_frames_kept(c->jitter_every, step, 1);
}

/* What sets the pace: a composite's is its photograph. */
static const char *pace_name(const struct cli *cli)
{
    const struct cli_options *o = &cli->opt;

    if (o->rate_map)
        return "--rate-map";
    if (cli_given(o, OPT_LIGHT))
        return "--light";
    if (o->map && !o->curvature)
        return "--map";
    return o->curvature ? "--curvature" : o->args[0];
}

int quilt_options_name(struct cli *cli, int code)
{
    static const char *const FIELDS[][2] = {{"size", "--size"},
                                            {"block", "--block"},
                                            {"overlap", "--overlap"},
                                            {"tolerance", "--tolerance"},
                                            {"metric", "--metric"},
                                            {"feather", "--feather"},
                                            {"rank", "--rank"},
                                            {"rank_error", "--rank-error"},
                                            {"jitter", "--jitter"},
                                            {"jitter_every", "--jitter-every"},
                                            {"per_frame", "--per-frame"},
                                            {"tileable", "--tileable"},
                                            {"sources", "--source"},
                                            {"factors", "--factors"},
                                            {"map", "--map"}};

    if (code < 0 && strcmp(cli->err.where, "rate map") == 0)
        (void)snprintf(cli->err.where, sizeof cli->err.where, "%.255s", pace_name(cli));
    for (unsigned i = 0; code < 0 && i < TTF_COUNT_OF(FIELDS); i++)
        if (strcmp(cli->err.where, FIELDS[i][0]) == 0)
            (void)snprintf(cli->err.where, sizeof cli->err.where, "%s", FIELDS[i][1]);
    return code;
}
