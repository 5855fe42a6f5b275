/* SPDX-License-Identifier: Apache-2.0 */
#include "plain_box.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

void plain_config(uint32_t w, uint32_t h, struct ttf_sim_config *ret)
{
    memset(ret, 0, sizeof(*ret));
    ret->seed = 7;
    ret->width = w;
    ret->height = h;
    ret->bits = 16;
    ret->full_well_e = 65535.0;
    ret->dark_doubling_degc = 6.0;
    ret->sensitivity_e = 1000.0;
    for (int c = 0; c < 3; c++)
        ret->channel_gain[c] = 1.0;
}

static int render(void *scene, int64_t t_ns, uint32_t w, uint32_t h, float *rgb,
                  struct ttf_err *err)
{
    const struct plain_scene *s = scene;

    for (uint32_t y = 0; y < h; y++) {
        for (uint32_t x = 0; x < w; x++) {
            for (unsigned c = 0; c < 3; c++)
                *rgb++ = s->value(x, y, w, h, c);
        }
    }
    return 0;
}

static void destroy(void *scene)
{
}

static const struct ttf_scene_ops plain_ops = {
    .name = "plain", .render = render, .destroy = destroy};

void plain_scene_init(struct plain_scene *s, plain_value_fn value)
{
    s->value = value;
    s->scene.ops = &plain_ops;
    s->scene.priv = s;
}

float plain_white(uint32_t x, uint32_t y, uint32_t w, uint32_t h, unsigned channel)
{
    return 1.0f;
}

struct sim_image_model *plain_model(const struct ttf_sim_config *config, struct plain_scene *scene)
{
    struct sim_image_model *model = NULL;

    assert_int_equal(sim_image_model_create(config, &scene->scene, &model, NULL), 0);
    return model;
}

void plain_shoot(struct sim_image_model *model, uint32_t height, float ambient, int64_t exposure_ns,
                 uint32_t gain_milli, double temp_degc, uint64_t key, uint16_t *dst)
{
    float *rows = malloc(height * sizeof(*rows));
    const struct ttf_exposure granted = {.exposure_ns = exposure_ns, .gain_milli = gain_milli};
    struct sim_exposure_light light = {.n_lamps = 0, .ambient_rows = rows};

    assert_non_null(rows);
    for (uint32_t y = 0; y < height; y++)
        rows[y] = ambient;
    assert_int_equal(sim_image_expose(model, 0, &light, &granted, temp_degc, key, dst, NULL), 0);
    free(rows);
}

void plain_expose(const struct ttf_sim_config *config, struct plain_scene *scene, float ambient,
                  uint16_t *dst)
{
    struct sim_image_model *model = plain_model(config, scene);

    plain_shoot(model, config->height, ambient, INT64_C(1000000000), 1000, 25.0, 1, dst);
    sim_image_model_destroy(model);
}
