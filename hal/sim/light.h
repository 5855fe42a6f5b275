/* SPDX-License-Identifier: Apache-2.0 */
/*
 * light.h: how bright the lamps are, how warm the box is, at any instant, in
 * closed form. Private to hal/sim. Times are elapsed time. The caller serialises.
 *
 * History is a list of segments during which nothing is switched; the last
 * SIM_LIGHT_SEGMENTS are kept, so questions about instants before them get the
 * oldest segment's answer.
 */
#ifndef TTF_HAL_SIM_LIGHT_H
#define TTF_HAL_SIM_LIGHT_H

#include <stdbool.h>
#include <stdint.h>

#include "faults.h"
#include "ttf/hal/sim.h"

#define SIM_LIGHT_SEGMENTS 512

/* Light that falls in through an open door, in lamps' nominal strengths. */
#define SIM_DOOR_LIGHT 0.5

/* What is switched. */
struct sim_light_state {
    unsigned level[TTF_LAMPS_MAX]; /* permille, as the lamp itself burns */
    bool door_open;
};

struct sim_light_segment {
    int64_t from_ns;
    struct sim_light_state state;
    double warmth[TTF_LAMPS_MAX]; /* at from_ns: 0 cold .. 1 warm */
    double heat_degc;             /* at from_ns: the box above the room */
};

struct sim_light {
    const struct ttf_sim_config *config; /* borrowed */
    const struct sim_faults *faults;     /* borrowed */
    unsigned n;
    struct sim_light_segment segment[SIM_LIGHT_SEGMENTS];
};

/* All dark, cold and closed since from_ns. */
void sim_light_init(struct sim_light *light, const struct ttf_sim_config *config,
                    const struct sim_faults *faults, int64_t from_ns);

/* From t on (not before the last change) things are switched so. */
void sim_light_switch(struct sim_light *light, int64_t t, const struct sim_light_state *state);

const struct sim_light_state *sim_light_now(const struct sim_light *light);

/* Share of its nominal strength that lamp i gives at t, without mains ripple. */
double sim_light_lamp(const struct sim_light *light, unsigned i, int64_t t);

/* The same averaged over from..to (to > from), with ripple. */
double sim_light_lamp_mean(const struct sim_light *light, unsigned i, int64_t from, int64_t to);

/* Leaked light, daylight and an open door's at t, in nominal strengths. */
double sim_light_ambient(const struct sim_light *light, int64_t t);

/* The box's temperature at t. */
double sim_light_temp_degc(const struct sim_light *light, int64_t t);

/* It will not be hotter than this from t on unless something is switched. */
double sim_light_temp_bound_degc(const struct sim_light *light, int64_t t);

#endif
