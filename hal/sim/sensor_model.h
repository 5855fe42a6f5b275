/* SPDX-License-Identifier: Apache-2.0 */
/*
 * sensor_model.h: from photons to codes. Private to the image model.
 *
 * Light falling on a pixel in one exposure becomes electrons with the pixel's own
 * response (PRNU); dark current adds its own; both arrive as a Poisson process;
 * the well saturates; the amplifier adds read noise (referred to its input);
 * gain, black level and the converter follow.
 */
#ifndef TTF_HAL_SIM_SENSOR_MODEL_H
#define TTF_HAL_SIM_SENSOR_MODEL_H

#include <stddef.h>
#include <stdint.h>

#include "noise.h"
#include "ttf/base/frame.h"
#include "ttf/hal/sim.h"

/* How much more than full_well_e the well itself holds: at gain 1 the converter saturates first. */
#define SENSOR_WELL_RESERVE 1.1

struct sensor_hot {
    uint32_t index; /* y * width + x */
    float e_per_s;  /* at 25 degC, beside the mean dark current */
};

/* Constant after sensor_init; owns its arrays. */
struct sensor {
    uint32_t width, height;
    bool noise;
    float black, white; /* codes */
    float code_per_e;   /* at gain 1 */
    float well_e, read_e;
    double sensitivity_e, channel_gain[3];
    double dark_e_per_s, dark_doubling_degc;
    uint64_t seed;
    float prnu; /* rms of a pixel's response about 1; 0: all alike */
    uint64_t prnu_stream;
    struct sensor_hot *hot; /* by rising index */
    size_t n_hot;
    struct noise_normal normal;
};

/* 0 or -ENOMEM. */
int sensor_init(struct sensor *s, const struct ttf_sim_config *config);
void sensor_finish(struct sensor *s);

/* One exposure's constants. */
struct sensor_exposure {
    float code_per_e;     /* gain included */
    float e_per_light[3]; /* electrons of an R, G, B pixel for reflectance x light 1 */
    float dark_e;         /* mean dark electrons */
    float hot_s;          /* seconds by which hot pixels' currents count (temperature included) */
    uint64_t stream;
};

void sensor_expose(const struct sensor *s, const struct ttf_exposure *granted, double temp_degc,
                   uint64_t noise_key, struct sensor_exposure *ret);

/* Which of R, G, B (0, 1, 2) pixel (x, y) sees: RGGB. */
static inline unsigned sensor_channel(uint32_t x, uint32_t y)
{
    return (x & 1u) + (y & 1u);
}

/*
 * Row y: electrons[0..width-1] holds the mean photo-electrons before PRNU and is
 * overwritten; dst gets the codes.
 */
void sensor_read_row(const struct sensor *s, const struct sensor_exposure *e, uint32_t y,
                     float *electrons, uint16_t *dst);

#endif
