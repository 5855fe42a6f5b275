/* SPDX-License-Identifier: Apache-2.0 */
/* The simulated camera's frames: waiting for them, drawing them, and what faults make of them. */
#include <errno.h>
#include <string.h>

#include "camera.h"
#include "ttf/base/time.h"

/* From the last row's readout until the driver hands the buffer over. */
#define TRANSFER_NS (2 * TTF_NS_PER_MS)

/* Keys that keep apart what is drawn from the same instant. */
enum {
    KEY_JITTER = 2,
    KEY_NOISE = 3,
    KEY_CORRUPT = 4
};

/* To until_ns, or to the power cut if that comes first: then -ENODEV. */
static int wait_powered(struct sim_box *box, int64_t until_ns)
{
    ttf_clock_wait_until(box->clock, until_ns < box->cut_ns ? until_ns : box->cut_ns);
    return sim_box_dead(box) ? -ENODEV : 0;
}

/* World locked: does the camera hang at boot_ns? Notes a hang that begins. */
static bool hangs(struct sim_camera *camera, int64_t boot_ns)
{
    struct sim_faults *f = &camera->box->faults;
    int64_t offset = camera->box->elapsed_offset_ns;

    if (camera->hung && boot_ns < camera->hang_until_ns)
        return true;
    if (camera->hung)
        sim_camera_unhang(camera);
    for (unsigned i = 0; i < f->n; i++) {
        bool stubborn = f->fault[i].amount >= 3;
        int64_t began, ends;

        if (f->fault[i].kind != TTF_FAULT_CAMERA_HANG)
            continue;
        began = sim_fault_began(f, i, boot_ns + offset);
        /* Power coming back cures what a reopening would. */
        if (began == TTF_NS_NEVER || (began < f->power_on_ns && !stubborn) ||
            began < camera->hang_cured_ns[i])
            continue;
        ends = sim_fault_ends(f, i, began);
        camera->hung = true;
        camera->hang = i;
        camera->hang_began_ns = began;
        camera->hang_until_ns =
            ends == TTF_NS_NEVER || (f->fault[i].rate_per_million > 0 && !stubborn) ? TTF_NS_NEVER
                                                                                    : ends - offset;
        return true;
    }
    return false;
}

void sim_camera_unhang(struct sim_camera *camera)
{
    camera->hung = false;
    camera->hang_cured_ns[camera->hang] = camera->hang_began_ns + 1;
}

static struct sim_buffer *free_buffer(struct sim_camera *camera)
{
    struct sim_buffer *found = NULL;

    pthread_mutex_lock(&camera->lock);
    for (unsigned i = 0; i < camera->box->config.buffers && !found; i++)
        if (!camera->buffer[i].held)
            found = &camera->buffer[i];
    if (found)
        found->held = true;
    pthread_mutex_unlock(&camera->lock);
    return found;
}

/* Waits for one; -ETIMEDOUT, -ENODEV. */
static int take_buffer(struct sim_camera *camera, int64_t deadline_ns, struct sim_buffer **ret)
{
    struct sim_box *box = camera->box;
    int64_t until = deadline_ns < box->cut_ns ? deadline_ns : box->cut_ns;

    for (;;) {
        *ret = free_buffer(camera);
        if (*ret)
            return 0;
        if (ttf_gate_wait(camera->freed, until) < 0)
            return sim_box_dead(box) ? -ENODEV : -ETIMEDOUT;
    }
}

/* World locked. Each row's light, averaged over that row's exposure. */
static double light_rows(struct sim_camera *camera, const struct sim_exposure *e,
                         struct sim_exposure_light *ret)
{
    struct sim_box *box = camera->box;
    uint32_t height = box->config.height;
    int64_t read = sim_box_elapsed(box, e->read_ns);
    float *ambient = camera->rows + (size_t)box->config.n_lamps * height;

    ret->n_lamps = box->config.n_lamps;
    for (unsigned i = 0; i < ret->n_lamps; i++) {
        float *rows = camera->rows + (size_t)i * height;

        ret->lamp_rows[i] = rows;
        for (uint32_t y = 0; y < height; y++) {
            int64_t end = read + (int64_t)y * camera->timing.readout_ns / height;

            rows[y] = (float)sim_light_lamp_mean(&box->light, i, end - e->granted.exposure_ns, end);
        }
    }
    for (uint32_t y = 0; y < height; y++) {
        int64_t end = read + (int64_t)y * camera->timing.readout_ns / height;

        ambient[y] = (float)sim_light_ambient(&box->light, end - e->granted.exposure_ns / 2);
    }
    ret->ambient_rows = ambient;
    return sim_light_temp_degc(&box->light, read);
}

static int expose(struct sim_camera *camera, const struct sim_exposure *e, uint16_t *dst,
                  struct ttf_err *err)
{
    struct sim_box *box = camera->box;
    int64_t middle = e->read_ns + camera_timing_middle_ns(&camera->timing, e->granted.exposure_ns);
    struct sim_exposure_light light = {0};
    double degc;
    int r;

    if (sim_world_enter(box) < 0)
        return -ENODEV;
    degc = light_rows(camera, e, &light);
    sim_world_leave(box);
    pthread_mutex_lock(&box->image_lock);
    r = sim_image_expose(
        box->image, sim_box_elapsed(box, middle), &light, &e->granted, degc,
        sim_mix(box->config.seed, (uint64_t)sim_box_elapsed(box, e->read_ns), KEY_NOISE), dst, err);
    pthread_mutex_unlock(&box->image_lock);
    return r;
}

static void scramble(struct sim_camera *camera, const struct sim_exposure *e, uint16_t *dst)
{
    const struct ttf_frame_format *f = &camera->base.format;
    uint64_t key = (uint64_t)sim_box_elapsed(camera->box, e->read_ns);

    for (size_t i = 0; i < (size_t)f->width * f->height; i++)
        dst[i] = (uint16_t)(sim_mix(key, i, KEY_CORRUPT) & ((1u << f->bits) - 1));
}

static int64_t jitter(const struct sim_camera *camera, const struct sim_exposure *e)
{
    int64_t peak = camera->box->config.jitter_ns;
    uint64_t key = (uint64_t)sim_box_elapsed(camera->box, e->read_ns);

    return peak > 0 ? (int64_t)(sim_mix(camera->box->config.seed, key, KEY_JITTER) %
                                (uint64_t)(2 * peak + 1)) -
                          peak
                    : 0;
}

void sim_camera_foresee(struct sim_camera *camera, struct sim_exposure *e)
{
    struct sim_faults *f = &camera->box->faults;
    int64_t t = sim_box_elapsed(camera->box, e->read_ns), amount;

    e->short_permille = 1000;
    e->late_ns = 0;
    e->corrupt = false;
    e->missing = sim_fault_on_frame(f, TTF_FAULT_FRAME_MISSING, t, NULL);
    if (e->missing)
        return;
    e->corrupt = sim_fault_on_frame(f, TTF_FAULT_FRAME_CORRUPT, t, NULL);
    if (sim_fault_on_frame(f, TTF_FAULT_FRAME_SHORT, t, &amount))
        e->short_permille = amount;
    if (sim_fault_on_frame(f, TTF_FAULT_FRAME_LATE, t, &amount))
        e->late_ns = amount * TTF_NS_PER_MS;
}

static void describe(struct sim_camera *camera, const struct sim_exposure *e,
                     struct sim_buffer *buffer)
{
    int64_t period = camera->timing.period_ns, passed = e->read_ns - camera->sequence_ns;
    size_t bytes = camera->base.format.stride * camera->base.format.height;

    camera->sequence += passed > period ? (uint32_t)(passed / period) : 1;
    camera->sequence_ns = e->read_ns;
    buffer->frame = (struct ttf_frame){
        .format = camera->base.format,
        .data = buffer->data,
        .bytes = bytes / 1000 * (size_t)e->short_permille +
                 bytes % 1000 * (size_t)e->short_permille / 1000,
        .start_ns = e->read_ns - e->granted.exposure_ns + jitter(camera, e),
        .end_ns = e->read_ns + camera->timing.readout_ns + jitter(camera, e),
        .sequence = camera->sequence,
        .flags = TTF_FRAME_SIMULATED | (e->corrupt ? (unsigned)TTF_FRAME_ERROR : 0u) |
                 (e->short_permille < 1000 ? (unsigned)TTF_FRAME_SHORT : 0u) |
                 (camera->lost ? (unsigned)TTF_FRAME_SEQUENCE_GAP : 0u),
        .settings = e->granted,
        .set_index = camera->next,
        .backend = buffer,
    };
    camera->lost = false;
}

static void give_back(struct sim_camera *camera, struct sim_buffer *buffer)
{
    pthread_mutex_lock(&camera->lock);
    buffer->held = false;
    pthread_mutex_unlock(&camera->lock);
}

/*
 * Waits until the next exposure's buffer is there. 1: the exposure was lost, look
 * at the one after it. -ETIMEDOUT, -ENODEV.
 */
static int await(struct sim_camera *camera, const struct sim_exposure *e, int64_t deadline_ns)
{
    struct sim_box *box = camera->box;
    int64_t ready = e->read_ns + camera->timing.readout_ns + TRANSFER_NS + e->late_ns;
    int64_t hang_until;
    bool hung;

    if (ready > deadline_ns && !e->missing)
        return wait_powered(box, deadline_ns) < 0 ? -ENODEV : -ETIMEDOUT;
    if (e->missing)
        return 1;
    if (wait_powered(box, ready) < 0 || sim_world_enter(box) < 0)
        return -ENODEV;
    hung = hangs(camera, e->read_ns);
    hang_until = camera->hang_until_ns;
    sim_world_leave(box);
    if (!hung)
        return 0;
    if (hang_until > deadline_ns)
        return wait_powered(box, deadline_ns) < 0 ? -ENODEV : -ETIMEDOUT;
    return wait_powered(box, hang_until) < 0 ? -ENODEV : 1;
}

/* The driver knows that the rest was lost when a later frame of the stream comes. */
static int set_is_over(struct sim_camera *camera, int64_t deadline_ns, struct ttf_err *err)
{
    int64_t known = camera->set[camera->n - 1].read_ns + camera->timing.readout_ns + TRANSFER_NS +
                    camera->timing.period_ns;

    if (wait_powered(camera->box, known < deadline_ns ? known : deadline_ns) < 0)
        return sim_camera_no_power(err);
    return known <= deadline_ns
               ? ttf_err_set(err, -ENODATA, "camera", "the rest of the set was lost")
               : ttf_err_set(err, -ETIMEDOUT, "camera", "no frame came in time");
}

int sim_camera_next(struct ttf_camera *base, int64_t deadline_ns, struct ttf_frame **ret_frame,
                    struct ttf_err *err)
{
    struct sim_camera *camera = (struct sim_camera *)base;
    struct sim_buffer *buffer;
    const struct sim_exposure *e;
    int r;

    if (sim_box_dead(camera->box))
        return sim_camera_no_power(err);
    for (;; camera->next++, camera->lost = true) {
        if (camera->next == camera->n)
            return set_is_over(camera, deadline_ns, err);
        e = &camera->set[camera->next];
        r = await(camera, e, deadline_ns);
        if (r <= 0)
            break;
    }
    if (r == 0)
        r = take_buffer(camera, deadline_ns, &buffer);
    if (r == -ETIMEDOUT)
        return ttf_err_set(err, r, "camera", "no frame came in time");
    if (r < 0)
        return sim_camera_no_power(err);
    if (e->corrupt)
        scramble(camera, e, buffer->data);
    else
        r = expose(camera, e, buffer->data, err);
    if (r < 0) {
        give_back(camera, buffer);
        return r;
    }
    describe(camera, e, buffer);
    camera->next++;
    *ret_frame = &buffer->frame;
    return 0;
}
