/* SPDX-License-Identifier: Apache-2.0 */
/* Making the simulated box, and what its tests and glue may ask of it. */
#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "box_private.h"
#include "clock.h"
#include "ttf/base/time.h"

/* A version 4 identifier, from the seed and the boot. */
static void make_boot_id(char ret[37], uint64_t seed, int64_t power_on_ns)
{
    uint64_t a = sim_mix(seed, (uint64_t)power_on_ns, UINT64_C(0xb001));
    uint64_t b = sim_mix(seed, (uint64_t)power_on_ns, UINT64_C(0xb002));

    snprintf(ret, 37, "%08" PRIx32 "-%04" PRIx32 "-4%03" PRIx32 "-%04" PRIx32 "-%012" PRIx64,
             (uint32_t)(a >> 32), (uint32_t)(a >> 16) & 0xffff, (uint32_t)a & 0xfff,
             (uint32_t)(0x8000 | (b >> 50)), b & UINT64_C(0xffffffffffff));
}

static int power_lost(void *priv)
{
    return sim_box_dead(priv);
}

/* Frees what there is. */
static void finish(struct sim_box *box)
{
    sim_image_model_destroy(box->image);
    if (box->scene.ops && box->scene.ops->destroy)
        box->scene.ops->destroy(box->scene.priv);
    ttf_clock_destroy(box->clock);
    sim_utc_finish(&box->utc);
    pthread_mutex_destroy(&box->image_lock);
    pthread_mutex_destroy(&box->lock);
    free(box);
}

static void destroy_box(struct ttf_box *box)
{
    for (unsigned i = 0; i < box->n_cameras; i++)
        ttf_camera_destroy(box->cameras[i].camera);
    ttf_lamps_destroy(box->lamps);
    ttf_sensors_destroy(box->sensors);
    ttf_panel_destroy(box->panel);
    ttf_watchdog_destroy(box->watchdog);
    if (box->box_private)
        finish(box->box_private);
}

static int make_clock(struct sim_box *box, struct ttf_err *err)
{
    const struct ttf_sim_config *c = &box->config;
    const int64_t cost_ns[TTF_WORK_COUNT] = {
        [TTF_WORK_DEVELOP] = c->cost_develop_ns, [TTF_WORK_COMMIT] = c->cost_commit_ns};
    int64_t powered_ns = 0; /* boot clock at power-on */

    if (c->real_time) {
        box->clock = sim_clock_machine_create(&box->utc);
        if (!box->clock)
            return ttf_err_set(err, -errno, "clock", "the machine's clock cannot be used");
        powered_ns = ttf_clock_now_ns(box->clock) - SIM_BOOTED_NS;
    } else {
        make_boot_id(box->boot_id, c->seed, c->power_on_ns);
        box->clock = sim_clock_virtual_create(SIM_BOOTED_NS, box->boot_id, cost_ns, &box->utc);
        if (!box->clock)
            return ttf_err_set(err, -ENOMEM, "clock", "not enough memory");
    }
    box->elapsed_offset_ns = c->power_on_ns - powered_ns;
    box->utc.elapsed_offset_ns = box->elapsed_offset_ns;
    return 0;
}

static void find_cut(struct sim_box *box)
{
    unsigned i = 0;
    int64_t cut = sim_fault_cut_ns(&box->faults, &i);

    box->cut_ns = box->back_ns = TTF_NS_NEVER;
    if (cut == TTF_NS_NEVER)
        return;
    box->cut_ns = cut - box->elapsed_offset_ns;
    box->back_ns = cut + box->faults.fault[i].amount * TTF_NS_PER_S;
}

/* The box without its devices. Owns the scene on success only. */
static int make_world(const struct ttf_sim_config *config, const struct ttf_scene *scene,
                      struct sim_box **ret, struct ttf_err *err)
{
    struct sim_box *box = calloc(1, sizeof(*box));
    int r;

    if (!box)
        return ttf_err_set(err, -ENOMEM, "sim", "not enough memory");
    box->config = *config;
    sim_faults_init(&box->faults, &box->config);
    if (pthread_mutex_init(&box->lock, NULL) != 0 ||
        pthread_mutex_init(&box->image_lock, NULL) != 0 ||
        sim_utc_init(&box->utc, &box->config, &box->faults) < 0) {
        free(box);
        return ttf_err_set(err, -ENOMEM, "sim", "not enough memory");
    }
    r = make_clock(box, err);
    if (r < 0)
        goto err_box;
    box->scene = *scene;
    r = sim_image_model_create(&box->config, &box->scene, &box->image, err);
    if (r < 0) {
        box->scene.ops = NULL;
        goto err_box;
    }
    find_cut(box);
    sim_world_init(box, ttf_clock_now_ns(box->clock));
    *ret = box;
    return 0;

err_box:
    finish(box);
    return r;
}

int ttf_sim_box_create(const struct ttf_sim_config *config, const struct ttf_scene *scene,
                       struct ttf_box *ret, struct ttf_err *err)
{
    struct ttf_box made = {.board = "sim", .simulated = true};
    struct sim_box *box = NULL;
    int r = ttf_sim_config_check(config, err);

    if (r == 0)
        r = make_world(config, scene, &box, err);
    if (r < 0 || !box) {
        if (scene->ops && scene->ops->destroy)
            scene->ops->destroy(scene->priv);
        return r;
    }
    snprintf(made.serial, sizeof(made.serial), "SIMULATED-%" PRIu64, config->seed);
    made.clock = box->clock;
    made.box_private = box;
    made.power_lost = power_lost;
    made.destroy = destroy_box;
    made.n_cameras = 1;
    snprintf(made.cameras[0].name, sizeof(made.cameras[0].name), "main");
    made.cameras[0].camera = sim_camera_create(box);
    made.lamps = sim_lamps_create(box);
    made.sensors = sim_sensors_create(box);
    made.panel = sim_panel_create(box);
    made.watchdog = sim_watchdog_create(box);
    if (!made.cameras[0].camera || !made.lamps || !made.sensors || !made.panel || !made.watchdog) {
        destroy_box(&made);
        return ttf_err_set(err, -ENOMEM, "sim", "not enough memory");
    }
    *ret = made;
    return 0;
}

/* The world behind a box, or NULL. Only this file's destroy marks a box as ours. */
static struct sim_box *world_of(const struct ttf_box *box)
{
    return box->destroy == destroy_box ? box->box_private : NULL;
}

int ttf_sim_truth(const struct ttf_box *box, int64_t middle_ns, uint32_t w, uint32_t h, float *rgb,
                  struct ttf_err *err)
{
    struct sim_box *sim = world_of(box);
    int r;

    if (!sim)
        return ttf_err_set(err, -ENOTSUP, box->board, "only a simulated box knows the truth");
    pthread_mutex_lock(&sim->image_lock);
    r = sim_image_truth(sim->image, sim_box_elapsed(sim, middle_ns), w, h, rgb, err);
    pthread_mutex_unlock(&sim->image_lock);
    return r;
}

int ttf_sim_corners(const struct ttf_box *box, double ret_xy[4][2])
{
    struct sim_box *sim = world_of(box);

    if (!sim)
        return -ENOTSUP;
    sim_image_corners(sim->image, ret_xy);
    return 0;
}

bool ttf_sim_storage_fault(const struct ttf_box *box, enum ttf_fault_kind kind)
{
    return ttf_sim_storage_fault_at(box, kind, 0);
}

void ttf_sim_storage_state(const struct ttf_box *box, unsigned storage, int64_t *ret_free_bytes,
                           bool *ret_read_only)
{
    struct sim_box *sim = world_of(box);
    int64_t left;
    int64_t t;

    *ret_free_bytes = TTF_NS_UNKNOWN;
    *ret_read_only = false;
    if (!sim || sim_world_enter(sim) < 0)
        return;
    t = sim_box_elapsed(sim, sim->world_ns);
    for (unsigned i = 0; i < sim->faults.n; i++) {
        if (!sim_fault_storage_lasts(&sim->faults, i, storage, t))
            continue;
        left = sim->faults.fault[i].amount << 20;
        if (sim->faults.fault[i].kind == TTF_FAULT_DISK_FULL &&
            (*ret_free_bytes == TTF_NS_UNKNOWN || left < *ret_free_bytes))
            *ret_free_bytes = left;
        *ret_read_only |= sim->faults.fault[i].kind == TTF_FAULT_READ_ONLY;
    }
    sim_world_leave(sim);
}

bool ttf_sim_storage_fault_at(const struct ttf_box *box, enum ttf_fault_kind kind, unsigned storage)
{
    struct sim_box *sim = world_of(box);
    bool fails;

    if (!sim ||
        (kind != TTF_FAULT_DISK_FULL && kind != TTF_FAULT_IO_ERROR && kind != TTF_FAULT_READ_ONLY))
        return false;
    if (sim_world_enter(sim) < 0)
        return kind == TTF_FAULT_IO_ERROR; /* no power, no disk */
    fails = sim_fault_on_storage(&sim->faults, kind, storage, sim_box_elapsed(sim, sim->world_ns));
    sim_world_leave(sim);
    return fails;
}

int64_t ttf_sim_elapsed_ns(const struct ttf_box *box, int64_t boot_ns)
{
    struct sim_box *sim = world_of(box);

    return sim ? sim_box_elapsed(sim, boot_ns) : boot_ns;
}

int64_t ttf_sim_back_ns(const struct ttf_box *box)
{
    struct sim_box *sim = world_of(box);
    int64_t now;

    if (!sim)
        return TTF_NS_UNKNOWN;
    now = ttf_clock_now_ns(sim->clock);
    return now >= sim->cut_ns ? sim->back_ns : sim_box_elapsed(sim, now) + sim->config.outage_ns;
}

unsigned ttf_sim_watchdog_bites(const struct ttf_box *box)
{
    struct sim_box *sim = world_of(box);

    return sim ? sim_watchdog_bites(sim) : 0;
}

int ttf_sim_panel_push(const struct ttf_box *box, enum ttf_panel_event_kind kind)
{
    struct sim_box *sim = world_of(box);

    if (!sim)
        return -ENOTSUP;
    if (sim_world_enter(sim) < 0)
        return -ENODEV;
    if (kind == TTF_PANEL_DOOR_OPENED || kind == TTF_PANEL_DOOR_CLOSED)
        sim_world_push_door(sim, kind == TTF_PANEL_DOOR_OPENED);
    else
        sim_panel_event(sim, kind, sim->world_ns);
    sim_world_leave(sim);
    return 0;
}
