/* SPDX-License-Identifier: Apache-2.0 */
/* sim_fixture.h: small simulated boxes for the tests beside it. Include after cmocka.h. */
#ifndef TTF_TESTS_HAL_SIM_FIXTURE_H
#define TTF_TESTS_HAL_SIM_FIXTURE_H

#include "ttf/base/time.h"
#include "ttf/hal/sim.h"

#define S  TTF_NS_PER_S
#define MS TTF_NS_PER_MS

/* 64 x 48, a grey chart, no noise and no jitter, lamps that are bright at once. */
struct ttf_sim_config sim_small(void);

/* Makes the box and starts its camera; fails the test if that fails. */
struct ttf_box sim_box(const struct ttf_sim_config *config);

/* The same with another scene. */
struct ttf_box sim_box_of(const struct ttf_sim_config *config, const struct ttf_scene *scene);

/* Adds a fault. */
void sim_add_fault(struct ttf_sim_config *config, enum ttf_fault_kind kind, int64_t at_ns,
                   int64_t duration_ns, int64_t amount, const char *target);

/* All lamps at full until alive_until_ns. */
void sim_light_up(struct ttf_box *box, int64_t alive_until_ns);

/* Submits one exposure with this middle and takes its frame; what next() returned. */
int sim_shoot(struct ttf_box *box, int64_t exposure_ns, int64_t middle_ns,
              struct ttf_frame **ret_frame);

/* The mean of a frame's codes above black; releases the frame. */
double sim_mean(struct ttf_box *box, struct ttf_frame *frame);

/* sim_shoot, which must succeed, then sim_mean. 20 ms. */
double sim_brightness(struct ttf_box *box, int64_t middle_ns);

struct ttf_lamp_state sim_lamp(struct ttf_box *box, unsigned i);

void sim_wait(struct ttf_box *box, int64_t boot_ns);

#endif
