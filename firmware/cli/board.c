/* SPDX-License-Identifier: Apache-2.0 */
/* board.c: which board, found where, changed how. */
#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "cli.h"
#include "commands.h"
#include "run.h"
#include "ttf/hal/clock.h"
#include "ttf/hal/sim.h"

/* A box's own configuration would name another default; without one it is the simulated box. */
#define DEFAULT_BOARD "sim"

const char *const *cli_board_folders(void)
{
    static const char *const FOLDERS[] = {"boards", TTFBOX_INSTALLED_BOARDS, TTFBOX_SOURCE_BOARDS,
                                          NULL};

    return FOLDERS;
}

static bool is_procedural(const char *scene)
{
    for (unsigned i = 0; ttf_scene_name(i); i++)
        if (strcmp(ttf_scene_name(i), scene) == 0)
            return true;
    return false;
}

/*
 * --scene: a procedural sample's name, a folder of pictures or a dataset. Names come first: what
 * `--scene copper` means must not change when the run makes a folder called copper.
 */
static int override_scene(struct cli *cli, struct ttf_board *board)
{
    const char *scene = cli->opt.scene;
    char manifest[PATH_MAX];
    struct ttf_io_stat st;

    if (!board->simulated) {
        ttf_err_set(&cli->err, -EINVAL, "--scene", "this board's camera looks at a real sample");
        return ttf_err_hint(&cli->err, "--scene is for simulated boards"), -EINVAL;
    }
    if (strlen(scene) >= sizeof board->scene.images)
        return ttf_err_set(&cli->err, -EINVAL, "--scene", "the path is too long");
    memset(board->scene.name, 0, sizeof board->scene.name);
    board->scene.images[0] = '\0';
    board->scene.dataset[0] = '\0';
    if (is_procedural(scene) || cli->io->ops->stat(cli->io, scene, &st) < 0 || !st.is_dir) {
        if (strchr(scene, '/') || strlen(scene) >= sizeof board->scene.name)
            return ttf_err_set(&cli->err, -ENOENT, scene, "there is no such folder to look at");
        memcpy(board->scene.name, scene, strlen(scene) + 1);
        return 0;
    }
    (void)snprintf(manifest, sizeof manifest, "%s/dataset.json", scene);
    if (cli->io->ops->stat(cli->io, manifest, &st) == 0)
        memcpy(board->scene.dataset, scene, strlen(scene) + 1);
    else
        memcpy(board->scene.images, scene, strlen(scene) + 1);
    return 0;
}

int cli_load_board(struct cli *cli, struct ttf_board *ret)
{
    const char *name = cli->opt.board ? cli->opt.board : DEFAULT_BOARD;
    char path[PATH_MAX];
    int r = ttf_board_locate(name, cli_board_folders(), path, sizeof path, &cli->err);

    if (r == 0)
        r = ttf_board_load(path, cli->opt.sets, cli->opt.n_sets, ret, &cli->err);
    if (r == 0 && cli->opt.scene)
        r = override_scene(cli, ret);
    if (r == 0 && cli->opt.has_seed)
        ret->sim.seed = (uint64_t)cli->opt.seed;
    return r;
}

void cli_describe_board(struct cli *cli, const struct ttf_board *board, char ret[256])
{
    const struct run_choices choices = {.scene = cli->opt.scene,
                                        .sets = cli->opt.sets,
                                        .n_sets = cli->opt.n_sets,
                                        .has_seed = cli->opt.has_seed};

    run_describe(cli->io, board, &choices, ret);
}

int cli_own_box(struct cli *cli, const struct ttf_board *board, struct box_lock *ret)
{
    char who[256];

    (void)snprintf(who, sizeof who, "ttfbox %s, process %d, into %.150s", cli->command->name,
                   (int)getpid(), cli->opt.output);
    return box_lock_take(board->lock, who, false, ret, &cli->err);
}

int64_t cli_now_ns(void *clock)
{
    return ttf_clock_now_ns(clock);
}
