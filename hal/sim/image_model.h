/* SPDX-License-Identifier: Apache-2.0 */
/*
 * image_model.h: from the scene's reflectance and the light on it to the raw
 * codes of one frame. Private to hal/sim. Knows no time beyond its arguments:
 * camera.c says when, light.c how bright, this how it looks.
 */
#ifndef TTF_HAL_SIM_IMAGE_MODEL_H
#define TTF_HAL_SIM_IMAGE_MODEL_H

#include <stdint.h>

#include "ttf/base/err.h"
#include "ttf/base/frame.h"
#include "ttf/hal/sim.h"

struct sim_image_model;

/*
 * The light during one exposure. Mains ripple and a rolling shutter make it
 * differ from row to row: [lamp][row], averaged over that row's exposure, 1 = the
 * lamp's nominal strength (level, warmth, ageing, faults and ripple in it;
 * position, fall-off and colour not).
 */
struct sim_exposure_light {
    unsigned n_lamps;
    const float *lamp_rows[TTF_LAMPS_MAX]; /* each `height` entries */
    const float
        *ambient_rows; /* `height` entries: leaked light and daylight, even over the sample */
};

/* Copies config, borrows scene (both outlive it or are copied). -ENOMEM, -EINVAL. */
int sim_image_model_create(const struct ttf_sim_config *config, struct ttf_scene *scene,
                           struct sim_image_model **ret, struct ttf_err *err);
void sim_image_model_destroy(struct sim_image_model *model);

/*
 * Exposes one frame: scene at elapsed_ns (time since first power-on of the
 * exposure's middle), under `light`, with `granted` settings, the sensor at
 * temp_degc. noise_key makes this frame's noise different from all others' (the
 * same key and arguments give the same bits). dst: height x width codes, tightly
 * packed, `bits` significant.
 */
int sim_image_expose(struct sim_image_model *model, int64_t elapsed_ns,
                     const struct sim_exposure_light *light, const struct ttf_exposure *granted,
                     double temp_degc, uint64_t noise_key, uint16_t *dst, struct ttf_err *err);

/* True reflectance over the sample, w x h x 3 (for ttf_sim_truth). */
int sim_image_truth(struct sim_image_model *model, int64_t elapsed_ns, uint32_t w, uint32_t h,
                    float *rgb, struct ttf_err *err);

/* The sample's corners in frame pixels (see ttf_sim_corners). */
void sim_image_corners(const struct sim_image_model *model, double ret_xy[4][2]);

#endif
