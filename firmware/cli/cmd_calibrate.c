/* SPDX-License-Identifier: Apache-2.0 */
/* cmd_calibrate.c: `ttfbox calibrate dark | flat | chart | geometry | flicker`. */
#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "box.h"
#include "calibrate_chart.h"
#include "calibrate_say.h"
#include "commands.h"
#include "sim_target.h"
#include "ttf/capture/guided_calibration.h"
#include "ttf/config/plan_file.h"

#define FRAMES_DEFAULT      64
#define REFLECTANCE_DEFAULT 0.9

/* One calibration being made. */
struct guided {
    enum ttf_calibration_part part;
    struct ttf_plan plan; /* whose shot it is for; a plain one without --plan */
    struct ttf_plan_shot shot;
    struct ttf_box box;
    struct ttf_calibration calibration;
};

static int choose_shot(struct cli *cli, struct guided *g)
{
    const char *stream = cli->opt.shot;
    struct ttf_plan_file *file = NULL;

    ttf_plan_defaults(&g->plan);
    if (!cli->opt.plan) {
        if (stream)
            return ttf_err_set(&cli->err, -EINVAL, "--shot", "names a shot of no --plan");
        g->shot = g->plan.shots[0];
        ttf_guided_plain_shot(&g->box, &g->shot);
    } else {
        unsigned i = 0;
        int r = ttf_plan_file_load(cli->opt.plan, &file, &cli->err);

        if (r < 0)
            return r;
        g->plan = *ttf_plan_file_plan(file);
        ttf_plan_file_free(file);
        while (stream && i < g->plan.n_shots && strcmp(g->plan.shots[i].stream, stream) != 0)
            i++;
        if (i == g->plan.n_shots)
            return ttf_err_set(&cli->err, -EINVAL, "--shot", "the plan has no stream '%s'", stream);
        g->shot = g->plan.shots[i];
    }
    if (cli->opt.exposure_ns)
        g->shot.exposure.exposure_ns = cli->opt.exposure_ns;
    return 0;
}

/* What there is in CAL already; -EEXIST if it has the very part that is to be made, -EINVAL if another must be made first. */
static int open_folder(struct cli *cli, struct guided *g)
{
    const char *folder = cli->opt.output;
    char path[4096];
    struct ttf_io_stat st;
    int r;

    (void)snprintf(path, sizeof path, "%s/calibration.json", folder);
    if (cli->io->ops->stat(cli->io, path, &st) < 0) {
        r = cli_refuse_existing(cli, folder);
        return r < 0 ? r : ttf_calibration_may_take(&g->calibration, g->part, &cli->err);
    }
    r = ttf_calibration_load(cli->io, folder, &g->calibration, &cli->err);
    if (r < 0)
        return r;
    if (ttf_calibration_has(&g->calibration, g->part)) {
        ttf_err_set(&cli->err, -EEXIST, folder, "holds a %s already",
                    ttf_calibration_part_name(g->part));
        ttf_err_hint(&cli->err, "nothing is overwritten: make a new calibration with another -o");
        return -EEXIST;
    }
    return ttf_calibration_may_take(&g->calibration, g->part, &cli->err);
}

/* What a simulated target reflects; what others are told of their configuration is an option here. */
static int ask_target(struct cli *cli, struct guided *g, double *ret)
{
    int r = sim_target_reflectance(&g->box, ret, &cli->err);

    if (r == -EINVAL)
        ttf_err_hint(&cli->err, "say --scene white");
    return r;
}

/* The frames, fitted into the calibration. */
static int take(struct cli *cli, struct guided *g, struct ttf_guided_config *config)
{
    struct ttf_chart_view view;
    struct ttf_chart chart;
    int r = 0;

    if (g->part == TTF_CALIBRATION_DARK)
        return ttf_guided_dark(config, &g->calibration, &cli->err);
    if (g->part == TTF_CALIBRATION_FLAT) {
        if (g->box.simulated && cli->opt.reflectance == 0)
            r = ask_target(cli, g, &config->reflectance);
        return r < 0 ? r : ttf_guided_flat(config, &g->calibration, &cli->err);
    }
    if (g->part == TTF_CALIBRATION_GEOMETRY)
        return ttf_guided_geometry(config, cli->opt.pitch_mm, &g->calibration, &cli->err);
    if (g->part == TTF_CALIBRATION_FLICKER)
        return ttf_guided_flicker(config, &g->calibration, &cli->err);
    r = calibrate_chart_corners(cli, &g->box, &view);
    if (r == 0)
        r = calibrate_chart_values(cli, &g->box, &chart);
    return r < 0 ? r : ttf_guided_chart(config, &view, &chart, &g->calibration, &cli->err);
}

static int acquire(struct cli *cli, struct guided *g)
{
    struct ttf_guided_config config = {
        .box = &g->box,
        .shot = &g->shot,
        .mains_hz = g->plan.mains_hz,
        .settle_ns = g->plan.settle_ns,
        .io = cli->io,
        .folder = cli->opt.output,
        .frames = cli->opt.frames ? (unsigned)cli->opt.frames : FRAMES_DEFAULT,
        .reflectance = cli->opt.reflectance > 0 ? cli->opt.reflectance : REFLECTANCE_DEFAULT,
    };
    int r;

    if (cli->opt.frames > 1000)
        return ttf_err_set(&cli->err, -EINVAL, "--frames", "more than 1000");
    r = take(cli, g, &config);
    if (r < 0 || !cli->opt.output)
        return r;
    r = ttf_calibration_name(&g->calibration, &cli->err);
    if (r == 0)
        r = ttf_io_mkdirs(cli->io, cli->opt.output, &cli->err);
    if (r == 0)
        r = ttf_calibration_save(&g->calibration, cli->io, cli->opt.output, &cli->err);
    return r;
}

/* What must be said before anything is looked at. */
static int check_options(struct cli *cli, enum ttf_calibration_part part)
{
    int r = part == TTF_CALIBRATION_GEOMETRY && cli->opt.pitch_mm <= 0
                ? cli_need(cli, NULL, "--pitch", "say how far the dots are apart, as --pitch 5")
                : 0;

    if (r < 0 || part == TTF_CALIBRATION_FLICKER || part == TTF_CALIBRATION_GEOMETRY)
        return r;
    return cli_need(cli, cli->opt.output, "-o", "say where the calibration goes, as -o cal");
}

/* All that CAL holds now; without one, what was measured. */
static void say(struct cli *cli, const struct guided *g)
{
    if (cli->opt.output)
        calibrate_say(cli, &g->calibration, cli->opt.output);
    else if (g->part == TTF_CALIBRATION_GEOMETRY)
        calibrate_say_geometry(cli, &g->calibration);
    else
        calibrate_say_flicker(cli, &g->calibration);
    if (g->part == TTF_CALIBRATION_FLICKER)
        calibrate_advise(cli, &g->calibration.flicker, g->plan.mains_hz);
}

static int calibrate(struct cli *cli, enum ttf_calibration_part part)
{
    struct guided *g = calloc(1, sizeof *g);
    struct ttf_board *board = calloc(1, sizeof *board);
    struct box_lock lock = {-1};
    int r = -ENOMEM;

    if (!g || !board)
        goto out;
    g->part = part;
    ttf_calibration_init(&g->calibration);
    r = check_options(cli, part);
    if (r == 0 && cli->opt.output)
        r = open_folder(cli, g);
    if (r == 0)
        r = cli_load_board(cli, board);
    if (r == 0)
        r = cli_own_box(cli, board, &lock);
    if (r == -EBUSY)
        ttf_err_hint(&cli->err, "the page of a box that ttfboxd has makes the same: Calibrate; or "
                                "stop that program first");
    if (r == 0)
        r = box_create(board, cli->io, NULL, &g->box, &cli->err);
    if (r == 0)
        r = box_configure(board, &g->box, &cli->err);
    if (r == 0)
        r = choose_shot(cli, g);
    if (r == 0)
        r = acquire(cli, g);
    if (r == 0)
        say(cli, g);
out:
    if (g) {
        ttf_box_destroy(&g->box);
        ttf_calibration_free(&g->calibration);
    }
    box_lock_drop(&lock);
    free(g);
    free(board);
    return r;
}

int cmd_calibrate_dark(struct cli *cli)
{
    return calibrate(cli, TTF_CALIBRATION_DARK);
}

int cmd_calibrate_flat(struct cli *cli)
{
    return calibrate(cli, TTF_CALIBRATION_FLAT);
}

int cmd_calibrate_chart(struct cli *cli)
{
    return calibrate(cli, TTF_CALIBRATION_CHART);
}

int cmd_calibrate_geometry(struct cli *cli)
{
    return calibrate(cli, TTF_CALIBRATION_GEOMETRY);
}

int cmd_calibrate_flicker(struct cli *cli)
{
    return calibrate(cli, TTF_CALIBRATION_FLICKER);
}
