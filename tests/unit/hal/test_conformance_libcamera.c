/* SPDX-License-Identifier: Apache-2.0 */
/* A camera behind libcamera keeps every camera's promises: steerable and not, late by few frames and by many, poor in controls. */
#include <stdlib.h>

#include "clock.h"
#include "conformance/conformance.h"
#include "fake_libcamera.h"
#include "fake_v4l2.h"
#include "ttf/base/time.h"

struct made {
    struct fake_libcamera fake;
};

static void destroy(struct ttf_box *box)
{
    struct made *made = box->box_private;

    ttf_camera_destroy(box->cameras[0].camera);
    fake_libcamera_free(&made->fake);
    ttf_clock_destroy(box->clock);
    free(made);
}

static int make(struct ttf_box *ret, void (*change)(struct fake_libcamera *fake),
                const struct ttf_libcamera_config *config)
{
    struct made *made = calloc(1, sizeof(*made));
    struct ttf_clock *clock;
    struct lc_system system;
    int r;

    if (!made)
        return -1;
    clock = fake_clock_create(sim_clock_virtual_create(TTF_NS_PER_S, "boot", NULL, NULL),
                              &made->fake.monotonic_lag_ns);
    fake_libcamera_init(&made->fake, clock);
    made->fake.monotonic_lag_ns = 7 * TTF_NS_PER_H / 10;
    if (change)
        change(&made->fake);
    *ret =
        (struct ttf_box){.clock = clock, .n_cameras = 1, .destroy = destroy, .box_private = made};
    system = fake_libcamera_system(&made->fake);
    r = lc_camera_create_on(&system, config, clock, &ret->cameras[0].camera, NULL);
    if (r < 0)
        ttf_box_destroy(ret);
    return r;
}

static const struct ttf_libcamera_config PLAIN = {.id = ""};

static int make_plain(struct ttf_box *ret)
{
    return make(ret, NULL, &PLAIN);
}

static void be_vimc(struct fake_libcamera *fake)
{
    fake->limits.has = 1u << LC_CONTRAST;
    fake->raw[0].fourcc = 0;
    fake->stamp_monotonic = true;
    /* A pipeline of software on a busy machine: as uneven as its bound allows. */
    fake->uneven_ns = 40 * TTF_NS_PER_MS;
}

static int make_like_vimc(struct ttf_box *ret)
{
    return make(ret, be_vimc, &PLAIN);
}

static void be_late(struct fake_libcamera *fake)
{
    fake->delay = 4;
    fake->stamp_readout = true;
    fake->readout_ns = 15 * TTF_NS_PER_MS;
}

static int make_late(struct ttf_box *ret)
{
    static const struct ttf_libcamera_config config = {.stamp = TTF_LIBCAMERA_STAMP_READOUT,
                                                       .readout_ns = 15 * TTF_NS_PER_MS,
                                                       .delay_frames = 4,
                                                       .buffers = 4};

    return make(ret, be_late, &config);
}

static void be_deaf(struct fake_libcamera *fake)
{
    fake->deaf_durations = true;
    fake->stamp_none = true;
}

static int make_processed_and_deaf(struct ttf_box *ret)
{
    static const struct ttf_libcamera_config config = {.stream = TTF_LIBCAMERA_PROCESSED};

    return make(ret, be_deaf, &config);
}

static const struct ttf_libcamera_config PI = {.stream = TTF_LIBCAMERA_RAW,
                                               .stamp = TTF_LIBCAMERA_STAMP_READOUT};

static void be_vc4(struct fake_libcamera *fake)
{
    fake_libcamera_be_pi(fake, FAKE_VC4);
}

static int make_vc4(struct ttf_box *ret)
{
    return make(ret, be_vc4, &PI);
}

static void be_pisp(struct fake_libcamera *fake)
{
    fake_libcamera_be_pi(fake, FAKE_PISP);
}

static int make_pisp(struct ttf_box *ret)
{
    return make(ret, be_pisp, &PI);
}

int main(void)
{
    const struct conformance_factory plain = {"libcamera", make_plain};
    const struct conformance_factory vimc = {"libcamera without controls", make_like_vimc};
    const struct conformance_factory late = {"libcamera, four frames late", make_late};
    const struct conformance_factory deaf = {"libcamera, processed, not steerable, without stamps",
                                             make_processed_and_deaf};
    const struct conformance_factory vc4 = {"libcamera, raw of a Raspberry Pi 4", make_vc4};
    const struct conformance_factory pisp = {"libcamera, raw of a Raspberry Pi 5", make_pisp};

    return conformance_camera(&plain) + conformance_camera(&vimc) + conformance_camera(&late) +
           conformance_camera(&deaf) + conformance_camera(&vc4) + conformance_camera(&pisp);
}
