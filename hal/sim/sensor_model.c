/* SPDX-License-Identifier: Apache-2.0 */
#include "sensor_model.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* A pixel's own response, mean 1: drawn anew each time, for a large sensor's would be as large as two of its frames. */
static float response(const struct sensor *s, uint32_t index)
{
    const uint32_t bits = (uint32_t)(noise_draw(s->prnu_stream, index) >> 32);

    return fmaxf(0.0f, 1.0f + s->prnu * noise_normal(&s->normal, bits));
}

static int init_hot(struct sensor *s, const struct ttf_sim_config *config)
{
    const uint64_t place = noise_stream(s->seed, NOISE_HOT_PLACE, 0);
    const uint64_t rate = noise_stream(s->seed, NOISE_HOT_RATE, 0);
    const size_t n = (size_t)s->width * s->height;
    const float share = (float)config->hot_fraction;
    size_t count = 0;

    for (size_t i = 0; i < n; i++)
        count += noise_uniform(place, i) < share;
    s->n_hot = 0;
    s->hot = malloc((count ? count : 1) * sizeof(*s->hot));
    if (!s->hot)
        return -ENOMEM;
    for (size_t i = 0; i < n && s->n_hot < count; i++) {
        if (!(noise_uniform(place, i) < share))
            continue;
        /* Log-normal about the typical rate: a few are very hot, as on real sensors. */
        s->hot[s->n_hot].index = (uint32_t)i;
        s->hot[s->n_hot].e_per_s =
            (float)config->hot_e_per_s *
            expf(0.7f * noise_normal(&s->normal, (uint32_t)(noise_draw(rate, i) >> 32)));
        s->n_hot++;
    }
    return 0;
}

int sensor_init(struct sensor *s, const struct ttf_sim_config *config)
{
    memset(s, 0, sizeof(*s));
    s->width = config->width;
    s->height = config->height;
    s->noise = config->noise;
    s->black = (float)config->black_level;
    s->white = (float)((1u << config->bits) - 1u);
    s->code_per_e = (s->white - s->black) / (float)config->full_well_e;
    s->well_e = (float)(config->full_well_e * SENSOR_WELL_RESERVE);
    s->read_e = (float)config->read_noise_e;
    s->sensitivity_e = config->sensitivity_e;
    memcpy(s->channel_gain, config->channel_gain, sizeof(s->channel_gain));
    s->dark_e_per_s = config->dark_e_per_s;
    s->dark_doubling_degc = config->dark_doubling_degc;
    s->seed = config->seed;
    noise_normal_init(&s->normal);
    s->prnu = s->noise ? (float)config->prnu : 0.0f;
    s->prnu_stream = noise_stream(s->seed, NOISE_PRNU, 0);
    return init_hot(s, config);
}

void sensor_finish(struct sensor *s)
{
    free(s->hot);
    s->hot = NULL;
}

void sensor_expose(const struct sensor *s, const struct ttf_exposure *granted, double temp_degc,
                   uint64_t noise_key, struct sensor_exposure *ret)
{
    const double seconds = (double)granted->exposure_ns * 1e-9;
    const double warmth = exp2((temp_degc - 25.0) / s->dark_doubling_degc);

    /* 0 is a camera without the control: unity. */
    ret->code_per_e =
        s->code_per_e * (granted->gain_milli ? (float)granted->gain_milli * 1e-3f : 1.0f);
    for (int c = 0; c < 3; c++)
        ret->e_per_light[c] = (float)(s->sensitivity_e * s->channel_gain[c] * seconds);
    ret->hot_s = (float)(seconds * warmth);
    ret->dark_e = (float)(s->dark_e_per_s * seconds * warmth);
    ret->stream = noise_stream(s->seed, NOISE_SHOT_READ, noise_key);
}

static uint16_t to_code(const struct sensor *s, const struct sensor_exposure *e, float electrons)
{
    const float code = s->black + electrons * e->code_per_e + 0.5f;

    if (!(code > 0.0f))
        return 0;
    return (uint16_t)(code < s->white ? code : s->white);
}

static size_t first_hot(const struct sensor *s, uint32_t index)
{
    size_t lo = 0, hi = s->n_hot;

    while (lo < hi) {
        const size_t mid = lo + (hi - lo) / 2;

        if (s->hot[mid].index < index)
            lo = mid + 1;
        else
            hi = mid;
    }
    return lo;
}

void sensor_read_row(const struct sensor *s, const struct sensor_exposure *e, uint32_t y,
                     float *electrons, uint16_t *dst)
{
    const uint32_t w = s->width, row = y * w;

    for (uint32_t x = 0; x < w; x++)
        electrons[x] =
            (s->prnu > 0.0f ? electrons[x] * response(s, row + x) : electrons[x]) + e->dark_e;
    for (size_t i = first_hot(s, row); i < s->n_hot && s->hot[i].index < row + w; i++)
        electrons[s->hot[i].index - row] += s->hot[i].e_per_s * e->hot_s;
    if (!s->noise) {
        for (uint32_t x = 0; x < w; x++)
            dst[x] = to_code(s, e, fminf(electrons[x], s->well_e));
        return;
    }
    for (uint32_t x = 0; x < w; x++) {
        const uint64_t bits = noise_draw(e->stream, row + x);
        const float got = noise_poisson(&s->normal, electrons[x], (uint32_t)(bits >> 32));
        const float read = s->read_e * noise_normal(&s->normal, (uint32_t)bits);

        dst[x] = to_code(s, e, fminf(got, s->well_e) + read);
    }
}
