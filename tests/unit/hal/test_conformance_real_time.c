/* SPDX-License-Identifier: Apache-2.0 */
/* The machine's clock, and the simulated devices on it. */
#include <errno.h>

#include "conformance/conformance.h"
#include "ttf/hal/sim.h"

static void destroy_clock(struct ttf_box *box)
{
    ttf_clock_destroy(box->clock);
}

static int make_machine(struct ttf_box *ret)
{
    *ret = (struct ttf_box){.clock = ttf_clock_real_create(), .destroy = destroy_clock};
    return ret->clock ? 0 : -errno;
}

static int make_sim(struct ttf_box *ret)
{
    struct ttf_sim_config config;
    struct ttf_scene scene;
    int r = ttf_scene_procedural("chart", 1, TTF_NS_PER_DAY, &scene, NULL);

    if (r < 0)
        return r;
    ttf_sim_config_defaults(&config);
    config.width = 64;
    config.height = 48;
    config.real_time = true;
    config.frame_period_ns = 5 * TTF_NS_PER_MS; /* a quick sensor, for a quick test */
    config.readout_ns = 2 * TTF_NS_PER_MS;
    return ttf_sim_box_create(&config, &scene, ret, NULL);
}

int main(void)
{
    const struct conformance_factory machine = {"machine", make_machine};
    const struct conformance_factory sim = {"sim on the machine's clock", make_sim};

    return conformance_clock(&machine) + conformance_clock(&sim) + conformance_camera(&sim) +
           conformance_lamps(&sim);
}
