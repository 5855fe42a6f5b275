/* SPDX-License-Identifier: Apache-2.0 */
/* The simulated box keeps every interface's promises, steerable or not. */
#include "conformance/conformance.h"
#include "ttf/hal/sim.h"

static int make(struct ttf_box *ret, bool steerable)
{
    struct ttf_sim_config config;
    struct ttf_scene scene;
    int r = ttf_scene_procedural("chart", 1, TTF_NS_PER_DAY, &scene, NULL);

    if (r < 0)
        return r;
    ttf_sim_config_defaults(&config);
    config.width = 64;
    config.height = 48;
    config.steerable = steerable;
    return ttf_sim_box_create(&config, &scene, ret, NULL);
}

static int make_steerable(struct ttf_box *ret)
{
    return make(ret, true);
}

static int make_free_running(struct ttf_box *ret)
{
    return make(ret, false);
}

int main(void)
{
    const struct conformance_factory sim = {"sim", make_steerable};
    const struct conformance_factory free_running = {"sim, not steerable", make_free_running};

    return conformance_clock(&sim) + conformance_camera(&sim) + conformance_camera(&free_running) +
           conformance_lamps(&sim) + conformance_sensors(&sim) + conformance_panel(&sim) +
           conformance_watchdog(&sim);
}
