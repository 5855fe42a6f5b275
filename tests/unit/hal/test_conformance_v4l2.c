/* SPDX-License-Identifier: Apache-2.0 */
/* A V4L2 camera keeps every camera's promises, with and without controls, whatever its driver stamps. */
#include <stdlib.h>

#include "clock.h"
#include "conformance/conformance.h"
#include "fake_v4l2.h"

struct made {
    struct fake_v4l2 fake;
};

static void destroy(struct ttf_box *box)
{
    struct made *made = box->box_private;

    ttf_camera_destroy(box->cameras[0].camera);
    fake_v4l2_free(&made->fake);
    ttf_clock_destroy(box->clock);
    free(made);
}

static int make(struct ttf_box *ret, void (*change)(struct fake_v4l2 *fake),
                const struct ttf_v4l2_config *config)
{
    struct made *made = calloc(1, sizeof(*made));
    struct ttf_clock *clock;
    int r;

    if (!made)
        return -1;
    clock = fake_clock_create(sim_clock_virtual_create(TTF_NS_PER_S, "boot", NULL, NULL),
                              &made->fake.monotonic_lag_ns);
    fake_v4l2_init(&made->fake, clock);
    made->fake.monotonic_lag_ns = 7 * TTF_NS_PER_H / 10;
    if (change)
        change(&made->fake);
    *ret =
        (struct ttf_box){.clock = clock, .n_cameras = 1, .destroy = destroy, .box_private = made};
    r = v4l2_camera_create_on(&fake_v4l2_sys, &made->fake, config, clock, &ret->cameras[0].camera,
                              NULL);
    if (r < 0)
        ttf_box_destroy(ret);
    return r;
}

static const struct ttf_v4l2_config PLAIN = {.gain_unity = 64};

static int make_plain(struct ttf_box *ret)
{
    return make(ret, NULL, &PLAIN);
}

static void take_controls_away(struct fake_v4l2 *fake)
{
    for (unsigned i = 0; i < FAKE_CONTROLS; i++)
        fake->controls[i].id = 0;
}

static int make_without_controls(struct ttf_box *ret)
{
    static const struct ttf_v4l2_config config = {0};

    return make(ret, take_controls_away, &config);
}

static void stamp_the_beginning(struct fake_v4l2 *fake)
{
    fake->stamp_flags = V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC | V4L2_BUF_FLAG_TSTAMP_SRC_SOE;
}

static int make_stamped_at_the_beginning(struct ttf_box *ret)
{
    static const struct ttf_v4l2_config config = {
        .gain_unity = 64, .readout_ns = 15 * TTF_NS_PER_MS, .buffers = 4};

    return make(ret, stamp_the_beginning, &config);
}

static void stamp_nothing(struct fake_v4l2 *fake)
{
    fake->stamp_flags = V4L2_BUF_FLAG_TIMESTAMP_UNKNOWN;
    fake->frozen_sequence = true;
    fake->row_padding = 6;
}

static int make_poor(struct ttf_box *ret)
{
    return make(ret, stamp_nothing, &PLAIN);
}

int main(void)
{
    const struct conformance_factory plain = {"v4l2", make_plain};
    const struct conformance_factory bare = {"v4l2 without controls", make_without_controls};
    const struct conformance_factory soe = {"v4l2, stamped at the beginning",
                                            make_stamped_at_the_beginning};
    const struct conformance_factory poor = {"v4l2 without stamps and sequence", make_poor};

    return conformance_camera(&plain) + conformance_camera(&bare) + conformance_camera(&soe) +
           conformance_camera(&poor);
}
