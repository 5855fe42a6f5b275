/* SPDX-License-Identifier: Apache-2.0 */
#include "fake_libcamera.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ttf/base/time.h"

#define CODE(a, b, c, d) \
    ((uint32_t)(a) | (uint32_t)(b) << 8 | (uint32_t)(c) << 16 | (uint32_t)(d) << 24)
#define PACKED (UINT64_C(0x0b) << 56 | 1)

/* One camera: the handle is the fake. */
static struct fake_libcamera *of(struct lc_handle *handle)
{
    return (struct fake_libcamera *)(void *)handle;
}

/* ---- the sensor ---- */

static bool marked(uint64_t bits, uint64_t n, uint64_t from)
{
    return n >= from && n - from < 64 && bits >> (n - from) & 1;
}

static double value(const struct lc_settings *s, enum lc_control control, double unset)
{
    return s->set & 1u << control ? s->value[control][0] : unset;
}

/* Gains are 1 / (1 - code / 1024), codes cut down. */
static double granted_gain(double asked)
{
    double code = floor(1024 - 1024 / asked);

    return 1024 / (1024 - code);
}

static int64_t granted_exposure_ns(const struct fake_libcamera *f)
{
    int64_t asked = (int64_t)(value(&f->obeyed, LC_EXPOSURE, 10000) * 1e3);

    if (f->automatic)
        asked = (10 + (int64_t)(f->frame % 7)) * TTF_NS_PER_MS;
    if (f->longest_exposure_ns && asked > f->longest_exposure_ns)
        asked = f->longest_exposure_ns;
    return f->line_ns > 0 ? asked / f->line_ns * f->line_ns : asked;
}

static int64_t duration_ns(const struct fake_libcamera *f, int64_t exposure_ns)
{
    int64_t asked =
        f->deaf_durations ? 0 : (int64_t)(value(&f->obeyed, LC_FRAME_DURATION, 0) * 1e3 + 0.5);
    int64_t needed = exposure_ns + 4 * f->line_ns;

    asked = asked > f->least_ns ? asked : f->least_ns;
    return asked > needed ? asked : needed;
}

static void tell(const struct fake_libcamera *f, struct lc_settings *told, enum lc_control control,
                 double a, double b)
{
    if (f->untold >> control & 1 || !(f->limits.has >> control & 1))
        return;
    told->set |= 1u << control;
    told->value[control][0] = a;
    told->value[control][1] = b;
}

static void describe(const struct fake_libcamera *f, int64_t exposure_ns, int64_t duration,
                     struct lc_done *done)
{
    const struct lc_settings *o = &f->obeyed;
    int64_t stamp = f->next_ns + (f->stamp_readout ? exposure_ns : 0);

    if (!f->stamp_none) {
        done->driver_ns = f->next_ns + exposure_ns + f->readout_ns - f->monotonic_lag_ns;
        done->sensor_ns = stamp;
    }
    if (f->stamp_monotonic)
        done->driver_ns = done->sensor_ns = stamp - f->monotonic_lag_ns;
    if (marked(f->mute, f->frame, f->fate_from))
        return;
    tell(f, &done->told, LC_EXPOSURE, floor((double)exposure_ns / 1e3), 0);
    tell(f, &done->told, LC_GAIN, granted_gain(fmax(value(o, LC_GAIN, 1), 1)), 0);
    tell(f, &done->told, LC_COLOUR_GAINS, value(o, LC_COLOUR_GAINS, 1),
         o->set & 1u << LC_COLOUR_GAINS ? o->value[LC_COLOUR_GAINS][1] : 1);
    tell(f, &done->told, LC_LENS, value(o, LC_LENS, 0), 0);
    tell(f, &done->told, LC_FRAME_DURATION, floor((double)duration / 1e3), 0);
    if (f->digital_gain > 0) {
        done->told.set |= 1u << LC_DIGITAL_GAIN;
        done->told.value[LC_DIGITAL_GAIN][0] = f->digital_gain;
    }
}

/* The next frame begins: with the first request, if there is one. */
static void begin_frame(struct fake_libcamera *f)
{
    struct fake_exposed *e = &f->exposed[f->n_exposed];
    int64_t exposure, duration;

    if (f->n_queue > 0) {
        unsigned slot = (unsigned)((f->frame + f->delay) % FAKE_PENDING);

        f->pending[slot] = f->queue[0].settings;
        f->pending_of[slot] = f->frame + f->delay;
    }
    if (f->pending_of[f->frame % FAKE_PENDING] == f->frame &&
        f->pending[f->frame % FAKE_PENDING].set)
        f->obeyed = f->pending[f->frame % FAKE_PENDING];
    exposure = granted_exposure_ns(f);
    duration = duration_ns(f, exposure);
    f->began_ns[f->frame % 64] = f->next_ns;
    if (f->n_queue > 0 && f->n_exposed < FAKE_REQUESTS &&
        !marked(f->dropped, f->frame, f->fate_from)) {
        *e = (struct fake_exposed){.complete_ns = f->next_ns + exposure + f->readout_ns};
        e->done.buffer = f->queue[0].buffer;
        e->done.sequence = (uint32_t)f->frame;
        e->done.bytes = f->bytes;
        if (marked(f->cut, f->frame, f->fate_from))
            e->done.bytes /= 2;
        if (marked(f->in_error, f->frame, f->fate_from))
            e->done.status = LC_BAD;
        describe(f, exposure, duration, &e->done);
        f->n_exposed++;
        memmove(f->queue, f->queue + 1, --f->n_queue * sizeof(*f->queue));
    }
    f->next_ns += duration + (f->frame % 3 == 0 ? f->uneven_ns : 0);
    f->frame++;
}

static void run(struct fake_libcamera *f)
{
    int64_t now = ttf_clock_now_ns(f->clock);

    if (!f->streaming || f->silent)
        return;
    while (f->next_ns <= now) {
        int64_t duration = duration_ns(f, granted_exposure_ns(f));

        if (duration <= 0)
            return;
        /* Long after the last request nothing changes any more. */
        if (f->n_queue == 0 && now - f->next_ns > 100 * duration) {
            int64_t n = (now - f->next_ns) / duration - 20;

            f->next_ns += n * duration;
            f->frame += (uint64_t)n;
        }
        begin_frame(f);
    }
}

/* ---- the table ---- */

static const char *version(void *ctx)
{
    (void)ctx;
    return "0.0.0-fake";
}

static int begin(void *ctx)
{
    struct fake_libcamera *f = ctx;

    if (f->begin_failure)
        return f->begin_failure;
    f->begun++;
    return 0;
}

static void end(void *ctx)
{
    ((struct fake_libcamera *)ctx)->ended++;
}

static void complaint(void *ctx, char *ret, size_t size)
{
    (void)ctx;
    (void)snprintf(ret, size, "no sensor answers");
}

static int list(void *ctx, unsigned i, struct lc_identity *ret)
{
    struct fake_libcamera *f = ctx;

    if (i > 0 || !f->id)
        return 0;
    (void)snprintf(ret->id, sizeof(ret->id), "%s", f->id);
    (void)snprintf(ret->model, sizeof(ret->model), "%s", f->model);
    return 1;
}

static int hold(void *ctx, const char *id, struct lc_handle **ret)
{
    struct fake_libcamera *f = ctx;

    if (f->hold_failure)
        return f->hold_failure;
    if (!f->id || strcmp(id, f->id) != 0)
        return -ENODEV;
    f->held++;
    *ret = (struct lc_handle *)(void *)f;
    return 0;
}

static void free_buffers(struct fake_libcamera *f)
{
    for (unsigned i = 0; i < f->n; i++)
        free(f->memory[i]);
    memset(f->memory, 0, sizeof(f->memory));
    f->n = 0;
}

static int stop(struct lc_handle *handle)
{
    struct fake_libcamera *f = of(handle);

    f->stops++;
    f->streaming = false;
    f->n_queue = f->n_exposed = 0;
    return 0;
}

static void let_go(struct lc_handle *handle)
{
    of(handle)->let_go++;
    of(handle)->streaming = false;
    free_buffers(of(handle));
}

static int offer(struct lc_handle *handle, enum lc_role role, unsigned i, struct lc_offer *ret)
{
    const struct lc_offer *offers = role == LC_RAW ? of(handle)->raw : of(handle)->processed;

    if (i >= 8 || !offers[i].fourcc)
        return 0;
    *ret = offers[i];
    return 1;
}

static int configure(struct lc_handle *handle, const struct lc_ask *ask, struct lc_granted *ret)
{
    struct fake_libcamera *f = of(handle);
    unsigned per_pixel = ask->role == LC_RAW ? 2 : 3;

    if (!f->id)
        return -ENODEV;
    if (f->configure_failure)
        return f->configure_failure;
    free_buffers(f);
    f->asked = *ask;
    f->configured++;
    *ret = (struct lc_granted){.fourcc = f->granted_fourcc ? f->granted_fourcc : ask->fourcc,
                               .modifier = f->granted_fourcc ? f->granted_modifier : ask->modifier,
                               .width = f->width,
                               .height = f->height,
                               .stride = f->width * per_pixel + f->row_padding,
                               .colour = f->colour ? f->colour : ask->colour};
    if (f->pipeline != FAKE_PLAIN && ask->role == LC_RAW)
        fake_pi_grant(f, ask, ret);
    ret->bytes = (size_t)ret->stride * f->height;
    (void)snprintf(ret->colour_text, sizeof(ret->colour_text), "some other");
    f->bytes = ret->bytes;
    return 0;
}

static int limits(struct lc_handle *handle, struct lc_limits *ret)
{
    *ret = of(handle)->limits;
    return 0;
}

static int allocate(struct lc_handle *handle, unsigned n, unsigned *ret_n)
{
    struct fake_libcamera *f = of(handle);

    free_buffers(f);
    f->n = n < f->buffers_max ? n : f->buffers_max;
    for (unsigned i = 0; i < f->n; i++)
        f->memory[i] = calloc(1, f->bytes + 2);
    *ret_n = f->n;
    return 0;
}

static int buffer(struct lc_handle *handle, unsigned i, const void **ret_at, size_t *ret_length)
{
    *ret_at = of(handle)->memory[i];
    *ret_length = of(handle)->bytes;
    return 0;
}

static int start(struct lc_handle *handle, const struct lc_settings *settings)
{
    struct fake_libcamera *f = of(handle);

    if (!f->id)
        return -ENODEV;
    if (f->start_failure)
        return f->start_failure;
    f->starts++;
    f->streaming = true;
    f->obeyed = f->last = *settings;
    f->next_ns = ttf_clock_now_ns(f->clock) + 5 * TTF_NS_PER_MS;
    memset(f->pending, 0, sizeof(f->pending));
    memset(f->pending_of, 0, sizeof(f->pending_of));
    return 0;
}

static int queue(struct lc_handle *handle, unsigned index, const struct lc_settings *settings)
{
    struct fake_libcamera *f = of(handle);

    if (!f->id)
        return -ENODEV;
    if (f->queue_failure)
        return f->queue_failure;
    run(f);
    if (f->n_queue == FAKE_REQUESTS)
        return -ENOBUFS;
    f->queue[f->n_queue] = (struct fake_queued){.buffer = index, .settings = *settings};
    if (marked(f->forgets, f->requests, f->fate_request))
        f->queue[f->n_queue].settings.set = 0;
    f->n_queue++;
    f->requests++;
    f->last = *settings;
    return 0;
}

static int take(struct lc_handle *handle, struct lc_done *ret)
{
    struct fake_libcamera *f = of(handle);

    run(f);
    if (!f->id)
        return -ENODEV;
    if (f->cancels && f->n_queue > 0) {
        *ret = (struct lc_done){.buffer = f->queue[0].buffer, .status = LC_CANCELLED};
        memmove(f->queue, f->queue + 1, --f->n_queue * sizeof(*f->queue));
        return 0;
    }
    if (f->n_exposed == 0 || f->exposed[0].complete_ns > ttf_clock_now_ns(f->clock))
        return -EAGAIN;
    *ret = f->exposed[0].done;
    memmove(f->exposed, f->exposed + 1, --f->n_exposed * sizeof(*f->exposed));
    return 0;
}

static int descriptor(struct lc_handle *handle)
{
    (void)handle;
    return -1;
}

static int wait_for(const struct lc_system *system, struct lc_handle *handle,
                    struct ttf_clock *clock, int64_t deadline_ns)
{
    struct fake_libcamera *f = system->ctx;

    (void)handle;
    for (;;) {
        int64_t now = ttf_clock_now_ns(clock), next = deadline_ns;

        run(f);
        if (!f->id || (f->cancels && f->n_queue > 0) ||
            (f->n_exposed > 0 && f->exposed[0].complete_ns <= now))
            return 0;
        if (now >= deadline_ns)
            return -ETIMEDOUT;
        if (f->n_exposed > 0 && f->exposed[0].complete_ns < next)
            next = f->exposed[0].complete_ns;
        if (f->streaming && !f->silent && f->next_ns > now && f->next_ns < next)
            next = f->next_ns;
        ttf_clock_wait_until(clock, next);
    }
}

static const struct lc_ops OPS = {
    .abi = LC_ABI,
    .version = version,
    .begin = begin,
    .end = end,
    .complaint = complaint,
    .list = list,
    .hold = hold,
    .let_go = let_go,
    .offer = offer,
    .configure = configure,
    .limits = limits,
    .allocate = allocate,
    .buffer = buffer,
    .start = start,
    .stop = stop,
    .queue = queue,
    .take = take,
    .descriptor = descriptor,
};

struct lc_system fake_libcamera_system(struct fake_libcamera *fake)
{
    return (struct lc_system){.ops = &OPS, .ctx = fake, .wait = wait_for};
}

static void limit(struct fake_libcamera *f, enum lc_control control, double min, double max)
{
    f->limits.has |= 1u << control;
    f->limits.min[control] = min;
    f->limits.max[control] = max;
}

void fake_libcamera_init(struct fake_libcamera *f, struct ttf_clock *clock)
{
    memset(f, 0, sizeof(*f));
    f->clock = clock;
    f->id = "/base/soc/i2c0mux/i2c@1/imx000@1a";
    f->model = "imx000";
    f->width = 64;
    f->height = 48;
    f->buffers_max = FAKE_REQUESTS;
    f->least_ns = f->readout_ns = 20 * TTF_NS_PER_MS;
    f->line_ns = 18900;
    f->delay = 2;
    f->raw[0] = (struct lc_offer){CODE('R', 'G', '1', '0'), PACKED, 64, 48};
    f->raw[1] = (struct lc_offer){CODE('R', 'G', '1', '2'), PACKED, 64, 48};
    f->raw[2] = (struct lc_offer){CODE('R', 'G', '1', '2'), 0, 64, 48};
    f->processed[0] = (struct lc_offer){CODE('N', 'V', '1', '2'), 0, 64, 48};
    f->processed[1] = (struct lc_offer){CODE('B', 'G', '2', '4'), 0, 64, 48};
    limit(f, LC_EXPOSURE, 19, 5e6);
    limit(f, LC_GAIN, 1, 16);
    limit(f, LC_COLOUR_GAINS, 0, 32);
    limit(f, LC_LENS, 0, 12);
    limit(f, LC_FRAME_DURATION, 20000, 1e8);
    limit(f, LC_AUTO_EXPOSURE, 0, 1);
    limit(f, LC_AUTO_BALANCE, 0, 1);
    limit(f, LC_AUTO_FOCUS, 0, 2);
    limit(f, LC_NOISE_REDUCTION, 0, 4);
    limit(f, LC_SHARPNESS, 0, 16);
    limit(f, LC_CONTRAST, 0, 32);
}

void fake_libcamera_free(struct fake_libcamera *f)
{
    free_buffers(f);
}

void fake_libcamera_take_away(struct fake_libcamera *f, enum lc_control control)
{
    f->limits.has &= ~(1u << control);
}

uint64_t fake_libcamera_next(struct fake_libcamera *f)
{
    run(f);
    return f->frame;
}
