/* SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <stdio.h>
#include <string.h>

#include "sim_fixture.h"

struct ttf_sim_config sim_small(void)
{
    struct ttf_sim_config c;

    ttf_sim_config_defaults(&c);
    c.width = 64;
    c.height = 48;
    c.readout_ns = 48 * 25000;
    c.jitter_ns = 0;
    c.noise = false;
    c.hot_fraction = 0;
    c.dark_e_per_s = 0;
    for (unsigned i = 0; i < c.n_lamps; i++) {
        c.lamps[i].cold_fraction = 1;
        c.lamps[i].ripple = 0;
        c.lamps[i].ageing_per_kh = 0;
    }
    return c;
}

struct ttf_box sim_box(const struct ttf_sim_config *config)
{
    struct ttf_scene scene;

    assert_int_equal(ttf_scene_procedural("chart", 7, TTF_NS_PER_DAY, &scene, NULL), 0);
    return sim_box_of(config, &scene);
}

struct ttf_box sim_box_of(const struct ttf_sim_config *config, const struct ttf_scene *scene)
{
    const struct ttf_camera_mode mode = {0};
    struct ttf_box box;
    struct ttf_err err = {0};

    if (ttf_sim_box_create(config, scene, &box, &err) < 0)
        fail_msg("%s: %s", err.where, err.what);
    assert_int_equal(ttf_camera_configure(box.cameras[0].camera, &mode, NULL, NULL), 0);
    assert_int_equal(ttf_camera_start(box.cameras[0].camera, NULL), 0);
    return box;
}

void sim_add_fault(struct ttf_sim_config *config, enum ttf_fault_kind kind, int64_t at_ns,
                   int64_t duration_ns, int64_t amount, const char *target)
{
    struct ttf_fault *f = &config->faults[config->n_faults++];

    *f = (struct ttf_fault){
        .kind = kind, .at_ns = at_ns, .duration_ns = duration_ns, .amount = amount};
    snprintf(f->target, sizeof(f->target), "%s", target ? target : "");
}

void sim_light_up(struct ttf_box *box, int64_t alive_until_ns)
{
    assert_int_equal(ttf_lamps_acquire(box->lamps, alive_until_ns, NULL), 0);
    for (unsigned i = 0; i < ttf_lamps_count(box->lamps); i++)
        assert_int_equal(ttf_lamps_set(box->lamps, i, 1000, NULL), 0);
}

int sim_shoot(struct ttf_box *box, int64_t exposure_ns, int64_t middle_ns,
              struct ttf_frame **ret_frame)
{
    struct ttf_exposure e = {.exposure_ns = exposure_ns, .gain_milli = 1000};
    struct ttf_camera_set set = {.settings = &e, .n = 1, .middle_ns = middle_ns};
    struct ttf_camera *camera = box->cameras[0].camera;
    int64_t now = ttf_clock_now_ns(box->clock);
    int r = ttf_camera_submit(camera, &set, NULL);

    if (r < 0)
        return r;
    return ttf_camera_next(camera, (middle_ns > now ? middle_ns : now) + 8 * S, ret_frame, NULL);
}

double sim_mean(struct ttf_box *box, struct ttf_frame *frame)
{
    const uint16_t *codes = frame->data;
    size_t n = (size_t)frame->format.width * frame->format.height;
    double sum = 0;

    for (size_t i = 0; i < n; i++)
        sum += codes[i];
    sum = sum / (double)n - frame->format.black_level;
    ttf_camera_release(box->cameras[0].camera, frame);
    return sum;
}

double sim_brightness(struct ttf_box *box, int64_t middle_ns)
{
    struct ttf_frame *frame = NULL;

    assert_int_equal(sim_shoot(box, 20 * MS, middle_ns, &frame), 0);
    return frame ? sim_mean(box, frame) : 0;
}

struct ttf_lamp_state sim_lamp(struct ttf_box *box, unsigned i)
{
    struct ttf_lamp_state s;

    assert_int_equal(ttf_lamps_state(box->lamps, i, &s), 0);
    return s;
}

void sim_wait(struct ttf_box *box, int64_t boot_ns)
{
    ttf_clock_wait_until(box->clock, boot_ns);
}
