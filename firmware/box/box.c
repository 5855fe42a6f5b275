/* SPDX-License-Identifier: Apache-2.0 */
/*
 * box.c: from a board's description to a box, device by device. A board with simulated devices begins as a whole
 * simulated box, whose other devices are replaced by real ones; its world keeps what the board says of them.
 */
#include "box.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

#include "devices.h"
#include "scene.h"
#include "ttf/hal/sim.h"

static bool is_sim(const struct ttf_board *board, enum ttf_device_kind kind)
{
    return board->device[kind] && strcmp(board->device[kind]->name, "sim") == 0;
}

/* ---- the simulated part ---- */

static int make_scene(const struct ttf_board *board, struct ttf_io *io, struct ttf_scene *ret,
                      struct ttf_err *err)
{
    const struct ttf_board_scene *scene = &board->scene;

    if (*scene->images)
        return scene_of_images(io, scene->images, scene->span_ns, ret, err);
    if (*scene->dataset)
        return scene_of_dataset(io, scene->dataset, scene->span_ns, ret, err);
    return ttf_scene_procedural(scene->name, board->sim.seed, scene->span_ns, ret, err);
}

/* An even target fills the frame: around the sample it goes on as it is. */
static int widen_target(const struct ttf_scene *scene, struct ttf_sim_config *config,
                        struct ttf_err *err)
{
    float rgb[3];
    int r = scene->ops->render(scene->priv, 0, 1, 1, rgb, err);

    if (r == 0)
        config->margin_reflectance = (rgb[0] + rgb[1] + rgb[2]) / 3.0;
    return r;
}

static int check_simulated_cameras(const struct ttf_board *board, struct ttf_err *err)
{
    for (unsigned i = 0; i < board->n_cameras; i++) {
        if (strcmp(board->cameras[i].backend->name, "sim") != 0 ||
            strcmp(board->cameras[i].name, "main") == 0)
            continue;
        ttf_err_set(err, -ENOTSUP, board->path, "the simulated box has one camera, 'main'");
        ttf_err_hint(err, "write cameras: {main: {backend: sim}}");
        return -ENOTSUP;
    }
    return 0;
}

static int make_sim(const struct ttf_board *board, struct ttf_io *io, struct ttf_box *ret,
                    struct ttf_err *err)
{
    struct ttf_sim_config config = board->sim;
    struct ttf_scene scene = {0};
    int r = check_simulated_cameras(board, err);

    if (r < 0)
        return r;
    r = make_scene(board, io, &scene, err);
    if (r < 0)
        return r;
    if (strcmp(board->scene.name, "white") == 0)
        r = widen_target(&scene, &config, err);
    if (r < 0) {
        scene.ops->destroy(scene.priv);
        return r;
    }
    return ttf_sim_box_create(&config, &scene, ret, err);
}

/* What the board has not, or has of another back-end, is not used. */
static void leave_out(const struct ttf_board *board, struct ttf_box *box,
                      struct ttf_camera **ret_camera)
{
    *ret_camera = box->cameras[0].camera;
    box->cameras[0].camera = NULL;
    box->n_cameras = 0;
    if (board->device[TTF_DEVICE_LAMPS] && !is_sim(board, TTF_DEVICE_LAMPS)) {
        ttf_lamps_destroy(box->lamps);
        box->lamps = NULL;
    }
    if (board->device[TTF_DEVICE_SENSORS] && !is_sim(board, TTF_DEVICE_SENSORS)) {
        ttf_sensors_destroy(box->sensors);
        box->sensors = NULL;
    }
    if (!is_sim(board, TTF_DEVICE_PANEL)) {
        ttf_panel_destroy(box->panel);
        box->panel = NULL;
    }
    if (!is_sim(board, TTF_DEVICE_WATCHDOG)) {
        ttf_watchdog_destroy(box->watchdog);
        box->watchdog = NULL;
    }
}

/* ---- the real part ---- */

/* A panel may ask its lamps' guardian, all of them the clock. */
static void destroy_real(struct ttf_box *box)
{
    ttf_panel_destroy(box->panel);
    for (unsigned i = 0; i < box->n_cameras; i++)
        ttf_camera_destroy(box->cameras[i].camera);
    ttf_lamps_destroy(box->lamps);
    ttf_sensors_destroy(box->sensors);
    ttf_watchdog_destroy(box->watchdog);
    ttf_clock_destroy(box->clock);
}

static int begin(const struct ttf_board *board, struct ttf_io *io, struct ttf_box *box,
                 struct ttf_err *err)
{
    memset(box, 0, sizeof *box);
    if (board->simulated)
        return make_sim(board, io, box, err);
    box->destroy = destroy_real;
    box->clock = ttf_clock_real_create();
    return box->clock ? 0 : ttf_err_set(err, -errno, "clock", "the machine's clock cannot be had");
}

/* In the board's order; *sim is used up if one of them is simulated. */
static int add_cameras(const struct ttf_board *board, struct ttf_box *box, struct ttf_camera **sim,
                       struct ttf_err *err)
{
    int worst = 0;

    for (unsigned i = 0; i < board->n_cameras; i++) {
        struct ttf_box_camera *place = &box->cameras[box->n_cameras];
        int r = 0;

        if (strcmp(board->cameras[i].backend->name, "sim") == 0) {
            place->camera = *sim;
            *sim = NULL;
        } else {
            r = box_make_camera(&board->cameras[i], box->clock, &place->camera, worst ? NULL : err);
        }
        if (r < 0) {
            worst = worst ? worst : r;
            continue;
        }
        memcpy(place->name, board->cameras[i].name, sizeof place->name);
        box->n_cameras++;
    }
    return worst;
}

/* What is not there yet of this kind. 0 too if the board has none. */
static int add(const struct ttf_board *board, const struct box_host *host,
               enum ttf_device_kind kind, struct ttf_box *box, struct ttf_err *err)
{
    if (!board->device[kind] || is_sim(board, kind))
        return 0;
    switch (kind) {
    case TTF_DEVICE_LAMPS:
        return box_make_lamps(board, box->clock, &box->lamps, err);
    case TTF_DEVICE_SENSORS:
        return box_make_sensors(board, host, box->clock, &box->sensors, err);
    case TTF_DEVICE_PANEL:
        return box_make_panel(board, box->clock, box->lamps, &box->panel, err);
    case TTF_DEVICE_WATCHDOG:
        return box_make_watchdog(board, host, &box->watchdog, err);
    default:
        return 0;
    }
}

static void name_box(const struct ttf_board *board, const struct box_host *host,
                     struct ttf_box *box)
{
    (void)snprintf(box->board, sizeof box->board, "%s", board->name);
    (void)snprintf(box->serial, sizeof box->serial, "%s", board->serial);
    if (!*box->serial)
        box_host_serial(host, box->serial);
}

int box_create_what_answers(const struct ttf_board *board, struct ttf_io *io,
                            const struct box_host *host, struct ttf_box *ret,
                            struct ttf_err errs[TTF_DEVICE_KIND_COUNT])
{
    const struct box_host machine = {0};
    struct ttf_camera *sim = NULL;
    struct ttf_box box;
    int r;

    memset(errs, 0, TTF_DEVICE_KIND_COUNT * sizeof *errs);
    if (!host)
        host = &machine;
    r = begin(board, io, &box, &errs[TTF_DEVICE_CLOCK]);
    if (r < 0)
        return r;
    if (host->host_time)
        ttf_clock_trust_host(box.clock, host->host_time);
    if (board->simulated)
        leave_out(board, &box, &sim);
    /* Lamps before cameras: a box that cannot have its light need not wake its camera. */
    for (int kind = TTF_DEVICE_LAMPS; kind < TTF_DEVICE_KIND_COUNT; kind++)
        errs[kind].code = add(board, host, (enum ttf_device_kind)kind, &box, &errs[kind]);
    errs[TTF_DEVICE_CAMERA].code = add_cameras(board, &box, &sim, &errs[TTF_DEVICE_CAMERA]);
    ttf_camera_destroy(sim);
    name_box(board, host, &box);
    *ret = box;
    return 0;
}

int box_create(const struct ttf_board *board, struct ttf_io *io, const struct box_host *host,
               struct ttf_box *ret, struct ttf_err *err)
{
    struct ttf_err errs[TTF_DEVICE_KIND_COUNT];
    struct ttf_box box;
    int r = box_create_what_answers(board, io, host, &box, errs);

    if (r < 0) {
        if (err)
            *err = errs[TTF_DEVICE_CLOCK];
        return r;
    }
    for (int kind = 0; kind < TTF_DEVICE_KIND_COUNT; kind++) {
        if (errs[kind].code == 0)
            continue;
        if (err)
            *err = errs[kind];
        ttf_box_destroy(&box);
        return errs[kind].code;
    }
    *ret = box;
    return 0;
}

bool box_may_answer_later(int error)
{
    static const int PASSING[] = {ENODEV, ENOENT, ENXIO,        EACCES,    EBUSY, EIO,
                                  EAGAIN, EPROTO, ECONNREFUSED, ETIMEDOUT, ESTALE};

    for (unsigned i = 0; i < TTF_COUNT_OF(PASSING); i++)
        if (error == -PASSING[i])
            return true;
    return false;
}

int box_configure(const struct ttf_board *board, const struct ttf_box *box, struct ttf_err *err)
{
    for (unsigned i = 0; i < box->n_cameras; i++) {
        struct ttf_frame_format granted;
        int r =
            ttf_camera_configure(box->cameras[i].camera, &board->cameras[i].mode, &granted, err);

        if (r < 0)
            return r;
    }
    return 0;
}
