/* SPDX-License-Identifier: Apache-2.0 */
/* plain_box.h: a simulated camera without faults of any kind, for tests to add one at a time. */
#ifndef TTF_TESTS_HAL_SCENE_PLAIN_BOX_H
#define TTF_TESTS_HAL_SCENE_PLAIN_BOX_H

#include <stdint.h>

#include "image_model.h"

/*
 * Ideal optics, an even light of 1 (no lamps), a noiseless sensor of 16 bits, black 0; one second
 * of reflectance 1 gives sensitivity_e = 1000 electrons, full well 65535: one code an electron.
 */
void plain_config(uint32_t w, uint32_t h, struct ttf_sim_config *ret);

/* A scene that is `value(x, y, channel)` of the pixel asked for, at any time. Not to be destroyed. */
typedef float (*plain_value_fn)(uint32_t x, uint32_t y, uint32_t w, uint32_t h, unsigned channel);
struct plain_scene {
    plain_value_fn value;
    struct ttf_scene scene;
};
void plain_scene_init(struct plain_scene *s, plain_value_fn value);
float plain_white(uint32_t x, uint32_t y, uint32_t w, uint32_t h, unsigned channel);

/* Creates the model, takes one exposure of one second at 25 degC under even light `ambient`, destroys. */
void plain_expose(const struct ttf_sim_config *config, struct plain_scene *scene, float ambient,
                  uint16_t *dst);

/* The same of an existing model. */
void plain_shoot(struct sim_image_model *model, uint32_t height, float ambient, int64_t exposure_ns,
                 uint32_t gain_milli, double temp_degc, uint64_t key, uint16_t *dst);

struct sim_image_model *plain_model(const struct ttf_sim_config *config, struct plain_scene *scene);

#endif
