/* SPDX-License-Identifier: Apache-2.0 */
/* box.c: back-ends' constructors by name; see box.h. */
#include "box.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

#include "scene.h"
#include "ttf/hal/sim.h"

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

static int make_sim(const struct ttf_board *board, struct ttf_io *io, struct ttf_box *ret,
                    struct ttf_err *err)
{
    struct ttf_sim_config config = board->sim;
    struct ttf_scene scene = {0};
    int r;

    if (board->n_cameras != 1 || strcmp(board->cameras[0].name, "main") != 0) {
        ttf_err_set(err, -ENOTSUP, board->path, "the simulated box has one camera, 'main'");
        ttf_err_hint(err, "write cameras: {main: {backend: sim}}");
        return -ENOTSUP;
    }
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

/* A back-end makes a whole box; what the board says it has not is not used. */
static void leave_out(const struct ttf_board *board, struct ttf_box *box)
{
    if (!board->device[TTF_DEVICE_PANEL]) {
        ttf_panel_destroy(box->panel);
        box->panel = NULL;
    }
    if (!board->device[TTF_DEVICE_WATCHDOG]) {
        ttf_watchdog_destroy(box->watchdog);
        box->watchdog = NULL;
    }
}

/* One line per back-end of config's registry that can make a whole box. */
static const struct {
    const char *name;
    int (*make)(const struct ttf_board *board, struct ttf_io *io, struct ttf_box *ret,
                struct ttf_err *err);
} MAKERS[] = {{"sim", make_sim}};

int box_create(const struct ttf_board *board, struct ttf_io *io, struct ttf_box *ret,
               struct ttf_err *err)
{
    const char *wanted = board->cameras[0].backend->name;

    for (unsigned i = 0; i < TTF_COUNT_OF(MAKERS); i++) {
        int r;

        if (strcmp(MAKERS[i].name, wanted) != 0)
            continue;
        r = MAKERS[i].make(board, io, ret, err);
        if (r < 0)
            return r;
        leave_out(board, ret);
        (void)snprintf(ret->board, sizeof ret->board, "%s", board->name);
        (void)snprintf(ret->serial, sizeof ret->serial, "%s", board->serial);
        return 0;
    }
    return ttf_err_set(err, -ENOTSUP, board->path, "back-end '%s' is not built in", wanted);
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

/* Which operations a full disk refuses; a failing one refuses all that reach it. */
static bool needs_room(const char *op)
{
    static const char *const OPS[] = {"open", "pwrite", "append", "mkdir"};

    for (unsigned i = 0; i < TTF_COUNT_OF(OPS); i++)
        if (strcmp(OPS[i], op) == 0)
            return true;
    return false;
}

static unsigned storage_of(const struct box_disk *disk, const char *path)
{
    size_t n = strlen(disk->second);

    return n > 0 && strncmp(path, disk->second, n) == 0 && (path[n] == '/' || path[n] == '\0');
}

static void disk_space(void *ctx, const char *path, struct ttf_io_space *space)
{
    const struct box_disk *disk = ctx;
    int64_t free_bytes;
    bool read_only;

    ttf_sim_storage_state(disk->box, storage_of(disk, path), &free_bytes, &read_only);
    if (free_bytes != TTF_NS_UNKNOWN && free_bytes < space->free_bytes)
        space->free_bytes = free_bytes;
    space->read_only |= read_only;
}

static int disk_fault(void *ctx, const char *op, const char *path)
{
    const struct box_disk *disk = ctx;
    unsigned storage = storage_of(disk, path);

    if (ttf_sim_storage_fault_at(disk->box, TTF_FAULT_IO_ERROR, storage))
        return -EIO;
    if (ttf_sim_storage_fault_at(disk->box, TTF_FAULT_READ_ONLY, storage))
        return -EROFS;
    if (needs_room(op) && ttf_sim_storage_fault_at(disk->box, TTF_FAULT_DISK_FULL, storage))
        return -ENOSPC;
    return 0;
}

int box_disk_create(struct box_disk *disk, struct ttf_io *machine, const struct ttf_box *box,
                    const char *second)
{
    *disk = (struct box_disk){.box = box, .second = second, .io = machine};
    if (!box->simulated)
        return 0;
    disk->faulty = ttf_io_faulty_create(machine, disk_fault, disk);
    if (!disk->faulty)
        return -ENOMEM;
    ttf_io_faulty_space(disk->faulty, disk_space);
    disk->io = disk->faulty;
    return 0;
}

void box_disk_destroy(struct box_disk *disk)
{
    ttf_io_faulty_destroy(disk->faulty);
    disk->faulty = disk->io = NULL;
}
