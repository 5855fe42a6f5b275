/* SPDX-License-Identifier: Apache-2.0 */
/*
 * box_private.h: the simulated box from inside: one world that its devices
 * share. Private to hal/sim.
 *
 * Two times: `boot` is the box's boot clock; `elapsed` counts from the first
 * power-on through all boots and is what scene, light, faults and noise know.
 * The world is behind one lock and is brought up to date lazily, by whoever
 * looks: sim_world_enter() before, sim_world_leave() after.
 */
#ifndef TTF_HAL_SIM_BOX_PRIVATE_H
#define TTF_HAL_SIM_BOX_PRIVATE_H

#include <pthread.h>

#include "clock_utc.h"
#include "faults.h"
#include "image_model.h"
#include "light.h"
#include "ttf/hal/box.h"
#include "ttf/hal/guardian.h"
#include "ttf/hal/sim.h"

/* A box needs this long from power-on until its program runs. */
#define SIM_BOOTED_NS    TTF_NS_PER_S
#define SIM_EVENTS_MAX   64
#define SIM_TEMP_POLL_NS TTF_NS_PER_S

struct sim_box {
    struct ttf_sim_config config;
    struct ttf_scene scene;
    struct ttf_clock *clock;
    struct sim_utc utc;
    int64_t elapsed_offset_ns; /* elapsed - boot */
    int64_t cut_ns;            /* boot clock; TTF_NS_NEVER */
    int64_t back_ns;           /* elapsed, after that cut */
    char boot_id[37];

    pthread_mutex_t lock; /* of all below */
    int64_t world_ns;     /* boot clock: the world is up to date until then */
    struct sim_faults faults;
    struct sim_light light;
    struct ttf_guardian guardian;
    int temp_sensor; /* index of the one the guardian watches, or -1 */
    bool stuck[TTF_LAMPS_MAX];
    unsigned stuck_permille[TTF_LAMPS_MAX];
    bool door_open, door_pushed_open;
    unsigned n_events; /* of the panel, oldest first */
    struct ttf_panel_event events[SIM_EVENTS_MAX];
    bool dog_armed;
    int64_t dog_timeout_ns, dog_fed_ns;
    unsigned dog_bites;

    pthread_mutex_t image_lock; /* of image */
    struct sim_image_model *image;
};

int64_t sim_box_elapsed(const struct sim_box *box, int64_t boot_ns);

/* True once power is cut. Any thread. */
bool sim_box_dead(struct sim_box *box);

/* Locks the world and brings it up to now. 0, or -ENODEV (not locked) when power is cut. */
int sim_world_enter(struct sim_box *box);
void sim_world_leave(struct sim_box *box);

/* Sets up the world at the box's start. */
void sim_world_init(struct sim_box *box, int64_t now_ns);

/* World locked: what the guardian commands now becomes the light. Call after every change of it. */
void sim_world_sync(struct sim_box *box);

/* World locked: the door moves by hand. */
void sim_world_push_door(struct sim_box *box, bool open);

/* World locked: an event for the panel; the oldest goes when there are too many. */
void sim_panel_event(struct sim_box *box, enum ttf_panel_event_kind kind, int64_t at_ns);

/* Value of sensor i at this instant (world locked). */
int64_t sim_sensor_value(struct sim_box *box, unsigned i, int64_t boot_ns);

/* How often the watchdog has bitten by now. */
unsigned sim_watchdog_bites(struct sim_box *box);

/* Each makes its device, or NULL without memory. The box outlives them. */
struct ttf_camera *sim_camera_create(struct sim_box *box);
struct ttf_lamps *sim_lamps_create(struct sim_box *box);
struct ttf_sensors *sim_sensors_create(struct sim_box *box);
struct ttf_panel *sim_panel_create(struct sim_box *box);
struct ttf_watchdog *sim_watchdog_create(struct sim_box *box);

#endif
