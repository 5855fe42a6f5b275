/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The simulated camera. It runs freely without anybody drawing its frames: only
 * those of a set are computed, when next() hands them out.
 */
#include "camera.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "camera_timing.h"
#include "ttf/base/time.h"

static const int64_t recovery_ns[TTF_CAMERA_RECOVERY_COUNT] = {
    10 * TTF_NS_PER_MS, 300 * TTF_NS_PER_MS, 1500 * TTF_NS_PER_MS};

static struct sim_camera *of(struct ttf_camera *base)
{
    return (struct sim_camera *)base;
}

int sim_camera_no_power(struct ttf_err *err)
{
    return ttf_err_set(err, -ENODEV, "camera", "the simulated box has lost power");
}

static void fill_caps(struct sim_camera *camera)
{
    const struct ttf_sim_config *c = &camera->box->config;
    const struct camera_timing *t = &camera->timing;
    struct ttf_camera_caps *caps = &camera->base.caps;

    *caps = (struct ttf_camera_caps){
        .model = "SIMULATED",
        .exposure_min_ns = c->exposure_min_ns,
        .exposure_max_ns = c->exposure_max_ns,
        .gain_min_milli = c->gain_min_milli,
        .gain_max_milli = c->gain_max_milli,
        .steerable = c->steerable,
        .timing_bound_ns = camera_timing_bound_ns(t) + c->jitter_ns,
        .frame_period_ns = c->frame_period_ns,
        .lead_frames = c->control_delay_frames,
        .lead_ns = (int64_t)(c->control_delay_frames + 1) * c->frame_period_ns + c->readout_ns / 2,
        .buffers = c->buffers,
        .simulated = true,
    };
}

static int camera_configure(struct ttf_camera *base, const struct ttf_camera_mode *mode,
                            struct ttf_err *err)
{
    struct sim_camera *camera = of(base);
    const struct ttf_sim_config *c = &camera->box->config;

    if (sim_box_dead(camera->box))
        return sim_camera_no_power(err);
    if (mode->packing != TTF_PACKING_NONE && mode->packing != TTF_PACKING_RAW16)
        return ttf_err_set(err, -EINVAL, "camera", "the simulated camera gives raw 16-bit only");
    base->format = (struct ttf_frame_format){
        .width = c->width,
        .height = c->height,
        .stride = (size_t)c->width * sizeof(uint16_t),
        .packing = TTF_PACKING_RAW16,
        .cfa = TTF_CFA_RGGB,
        .bits = (uint8_t)c->bits,
        .black_level = (uint16_t)c->black_level,
        .white_level = (uint16_t)((1u << c->bits) - 1),
    };
    fill_caps(camera);
    return 0;
}

/* Free running begins anew, at a phase of its own. */
static void begin_stream(struct sim_camera *camera)
{
    struct sim_box *box = camera->box;
    int64_t now = ttf_clock_now_ns(box->clock), period = camera->timing.period_ns;
    uint64_t key = (uint64_t)sim_box_elapsed(box, now);

    camera->phase_ns =
        now + 2 * period + (int64_t)(sim_mix(box->config.seed, key, 1) % (uint64_t)period);
    camera->sequence = 0;
    camera->sequence_ns = now;
    camera->lost = false;
    camera->n = camera->next = 0;
}

static int camera_start(struct ttf_camera *base, struct ttf_err *err)
{
    struct sim_camera *camera = of(base);

    if (sim_box_dead(camera->box))
        return sim_camera_no_power(err);
    begin_stream(camera);
    return 0;
}

static void take_back_buffers(struct sim_camera *camera)
{
    pthread_mutex_lock(&camera->lock);
    for (unsigned i = 0; i < camera->box->config.buffers; i++)
        camera->buffer[i].held = false;
    pthread_mutex_unlock(&camera->lock);
}

static void camera_stop(struct ttf_camera *base)
{
    of(base)->n = of(base)->next = 0;
    take_back_buffers(of(base));
}

/* As the driver makes it: clamped, in its steps, and what it cannot control 0. */
static struct ttf_exposure grant(const struct ttf_sim_config *c, const struct ttf_exposure *asked,
                                 int64_t permille)
{
    struct ttf_exposure granted = {0};
    int64_t exposure = asked->exposure_ns;

    if (exposure > c->exposure_max_ns)
        exposure = c->exposure_max_ns;
    exposure = exposure / 1000 * permille + exposure % 1000 * permille / 1000;
    granted.exposure_ns =
        camera_quantise(exposure, c->exposure_min_ns, c->exposure_max_ns, c->exposure_step_ns);
    if (c->gain_max_milli > 0)
        granted.gain_milli = (uint32_t)camera_quantise(asked->gain_milli, c->gain_min_milli,
                                                       c->gain_max_milli, c->gain_step_milli);
    return granted;
}

static int camera_submit(struct ttf_camera *base, const struct ttf_camera_set *set,
                         struct ttf_err *err)
{
    struct sim_camera *camera = of(base);
    struct sim_box *box = camera->box;
    const struct camera_timing *t = &camera->timing;
    struct ttf_exposure granted = grant(&box->config, &set->settings[0], 1000);
    int64_t read_ns;

    if (sim_world_enter(box) < 0)
        return sim_camera_no_power(err);
    read_ns = camera_timing_first_ns(t, camera->phase_ns, box->world_ns, granted.exposure_ns,
                                     set->middle_ns);
    for (unsigned i = 0; i < set->n; i++) {
        struct sim_exposure *e = &camera->set[i];
        int64_t amount;

        granted = grant(&box->config, &set->settings[i], 1000);
        if (i > 0)
            read_ns += camera_timing_frame_ns(t, granted.exposure_ns);
        if (sim_fault_on_frame(&box->faults, TTF_FAULT_WRONG_SETTINGS,
                               sim_box_elapsed(box, read_ns), &amount))
            granted = grant(&box->config, &set->settings[i], 1000 + amount);
        e->read_ns = read_ns;
        e->granted = granted;
        sim_camera_foresee(camera, e);
    }
    camera->phase_ns = read_ns;
    sim_world_leave(box);
    camera->n = set->n;
    camera->next = 0;
    return 0;
}

static void camera_cancel(struct ttf_camera *base)
{
    of(base)->n = of(base)->next = 0;
}

static void camera_release(struct ttf_camera *base, struct ttf_frame *frame)
{
    struct sim_camera *camera = of(base);
    struct sim_buffer *buffer = frame->backend;

    pthread_mutex_lock(&camera->lock);
    buffer->held = false;
    pthread_mutex_unlock(&camera->lock);
    ttf_gate_open(camera->freed);
}

/* -EIO for a step that is too mild: the stream was set going again and gave nothing. */
static int camera_recover(struct ttf_camera *base, enum ttf_camera_recovery step,
                          struct ttf_err *err)
{
    struct sim_camera *camera = of(base);
    struct sim_box *box = camera->box;
    bool hung;

    ttf_clock_wait_until(box->clock, ttf_clock_now_ns(box->clock) + recovery_ns[step]);
    camera_stop(base);
    if (sim_world_enter(box) < 0)
        return sim_camera_no_power(err);
    hung = camera->hung && box->world_ns < camera->hang_until_ns &&
           box->faults.fault[camera->hang].amount > (int64_t)step;
    if (camera->hung && !hung)
        sim_camera_unhang(camera);
    sim_world_leave(box);
    if (hung)
        return ttf_err_set(err, -EIO, "camera", "the camera gives no frames after a %s",
                           ttf_camera_recovery_name(step));
    if (step >= TTF_CAMERA_RESTART || !base->streaming)
        begin_stream(camera);
    return 0;
}

static void camera_destroy(struct ttf_camera *base)
{
    struct sim_camera *camera = of(base);

    for (unsigned i = 0; camera->buffer && i < camera->box->config.buffers; i++)
        free(camera->buffer[i].data);
    free(camera->buffer);
    free(camera->rows);
    ttf_gate_destroy(camera->freed);
    pthread_mutex_destroy(&camera->lock);
    free(camera);
}

static const struct ttf_camera_ops sim_camera_ops = {
    .name = "sim",
    .configure = camera_configure,
    .start = camera_start,
    .stop = camera_stop,
    .submit = camera_submit,
    .next = sim_camera_next,
    .release = camera_release,
    .cancel = camera_cancel,
    .recover = camera_recover,
    .destroy = camera_destroy,
};

static int allocate(struct sim_camera *camera)
{
    const struct ttf_sim_config *c = &camera->box->config;
    size_t pixels = (size_t)c->width * c->height;

    camera->buffer = calloc(c->buffers, sizeof(*camera->buffer));
    camera->rows = calloc((size_t)(c->n_lamps + 1) * c->height, sizeof(*camera->rows));
    camera->freed = ttf_gate_create(camera->box->clock);
    if (!camera->buffer || !camera->rows || !camera->freed)
        return -ENOMEM;
    for (unsigned i = 0; i < c->buffers; i++) {
        camera->buffer[i].data = malloc(pixels * sizeof(uint16_t));
        if (!camera->buffer[i].data)
            return -ENOMEM;
    }
    return 0;
}

struct ttf_camera *sim_camera_create(struct sim_box *box)
{
    const struct ttf_sim_config *c = &box->config;
    struct sim_camera *camera = calloc(1, sizeof(*camera));

    if (!camera || pthread_mutex_init(&camera->lock, NULL) != 0) {
        free(camera);
        return NULL;
    }
    camera->base.ops = &sim_camera_ops;
    camera->box = box;
    camera->timing = (struct camera_timing){
        .period_ns = c->frame_period_ns,
        .period_max_ns = c->frame_period_max_ns,
        .readout_ns = c->readout_ns,
        .line_ns = c->readout_ns / c->height > 0 ? c->readout_ns / c->height : 1,
        .delay_frames = c->control_delay_frames,
        .steerable = c->steerable,
        .grid_ns = box->elapsed_offset_ns,
    };
    if (allocate(camera) == 0)
        return &camera->base;
    camera_destroy(&camera->base);
    return NULL;
}
