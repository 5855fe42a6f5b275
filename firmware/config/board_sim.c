/* SPDX-License-Identifier: Apache-2.0 */
/* board_sim.c: the `sim:` section of a board; every field of struct ttf_sim_config has its key. */
#include <errno.h>
#include <stdio.h>
#include <string.h>

#include "board_file.h"

#define S(member) offsetof(struct ttf_sim_config, member)
#define L(member) offsetof(struct ttf_sim_lamp, member)
#define HOUR      ((double)TTF_NS_PER_H)
#define DAY       ((double)TTF_NS_PER_DAY)
#define SECOND    1e9
#define NO_LIMIT  0, 0
#define TABLE(key, table, meant)                   \
    {                                              \
        key, cfg_section, 0, 0, 0, meant, table, 0 \
    }

/* clock: virtual | real. */
static int read_clock(const struct cfg_field *field, struct yaml_node *node, void *at,
                      struct ttf_err *err)
{
    static const struct cfg_name WORDS[] = {{"virtual", 0}, {"real", 1}, {NULL, 0}};
    struct cfg_field words = *field;
    int value = 0;

    words.extra = WORDS;
    int r = cfg_enum(&words, node, &value, err);

    if (r == 0)
        *(bool *)at = value != 0;
    return r;
}

static const struct cfg_field COST[] = {
    {"develop", cfg_i64_time, S(cost_develop_ns), 0, HOUR, "time to develop a frame", 0, 0},
    {"commit", cfg_i64_time, S(cost_commit_ns), 0, HOUR, "time to write and sync a slot", 0, 0},
    {0}};

static const struct cfg_field ROOM[] = {
    {"temperature", cfg_double_degc, S(ambient_degc), -40, 80, "mean, as 21degC", 0, 0},
    {"day_swing", cfg_double_degc, S(day_swing_degc), 0, 40, "amplitude over a day", 0, 0},
    {"heat_tau", cfg_i64_time, S(heat_tau_ns), SECOND, 7 * DAY, "time constant of the box", 0, 0},
    {0}};

static const struct cfg_field OPTICS[] = {
    {"vignetting", cfg_double_ratio, S(vignetting), 0, 1, "light lost in the corner", 0, 0},
    {"perspective", cfg_double_ratio, S(perspective), 0, 0.3, "keystone, top against bottom", 0, 0},
    {"blur", cfg_double_px, S(blur_px), 0, 50, "sigma of the point spread, pixels", 0, 0},
    {"detail", cfg_u32_px, S(detail_px), 0, 8192,
     "longest side at which the sample is drawn; 0px: as fine as the frame sees it", 0, 0},
    {"margin", cfg_double_ratio, S(margin), 0, 0.4, "frame around the sample, each edge", 0, 0},
    {"margin_reflectance", cfg_double_ratio, S(margin_reflectance), 0, 1, "of that frame", 0, 0},
    {0}};

static const struct cfg_field SENSOR[] = {
    {"width", cfg_u32_px, S(width), 16, 8192, "pixels, even", 0, 0},
    {"height", cfg_u32_px, S(height), 16, 8192, "pixels, even", 0, 0},
    {"bits", cfg_u32, S(bits), 8, 16, "bits per sample", 0, 0},
    {"black_level", cfg_u32, S(black_level), 0, 65535, "codes", 0, 0},
    {"full_well", cfg_double, S(full_well_e), 100, 1e7, "electrons at saturation", 0, 0},
    {"read_noise", cfg_double, S(read_noise_e), 0, 1e4, "electrons, rms", 0, 0},
    {"prnu", cfg_double_ratio, S(prnu), 0, 0.3, "response non-uniformity, rms", 0, 0},
    {"dark_current", cfg_double, S(dark_e_per_s), 0, 1e6, "electrons/s at 25 degC", 0, 0},
    {"dark_doubling", cfg_double_degc, S(dark_doubling_degc), 1, 100, "degC to double it", 0, 0},
    {"hot_fraction", cfg_double_ratio, S(hot_fraction), 0, 0.1, "share of hot pixels", 0, 0},
    {"hot_current", cfg_double, S(hot_e_per_s), 0, 1e8, "electrons/s of a hot pixel", 0, 0},
    {"sensitivity", cfg_double, S(sensitivity_e), 1, 1e10,
     "electrons/s of green on white in nominal light", 0, 0},
    {"channel_gain", cfg_double3, S(channel_gain), 0.001, 100, "response of R, G, B to white", 0,
     0},
    {"colour_mix", cfg_double_ratio, S(colour_mix), 0, 0.3,
     "share of each other colour in a colour", 0, 0},
    {"noise", cfg_bool, S(noise), NO_LIMIT, "shot and read noise and PRNU: true or false", 0, 0},
    {0}};

static const struct cfg_field TIMING[] = {
    {"exposure_min", cfg_i64_time, S(exposure_min_ns), 1, HOUR, "shortest exposure", 0, 0},
    {"exposure_max", cfg_i64_time, S(exposure_max_ns), 1, HOUR, "longest exposure", 0, 0},
    {"exposure_step", cfg_i64_time, S(exposure_step_ns), 1, HOUR, "exposure's quantum", 0, 0},
    {"gain_min", cfg_u32_milli, S(gain_min_milli), 0.001, 1e6, "lowest gain", 0, 0},
    {"gain_max", cfg_u32_milli, S(gain_max_milli), 0.001, 1e6, "highest gain", 0, 0},
    {"gain_step", cfg_u32_milli, S(gain_step_milli), 0.001, 1e6, "gain's quantum", 0, 0},
    {"frame_period", cfg_i64_time, S(frame_period_ns), 1e5, HOUR, "free-running frame time", 0, 0},
    {"frame_period_max", cfg_i64_time, S(frame_period_max_ns), 1e5, HOUR, "longest frame time", 0,
     0},
    {"readout", cfg_i64_time, S(readout_ns), 0, HOUR, "first row to last row", 0, 0},
    {"control_delay", cfg_u32, S(control_delay_frames), 0, 16, "frames until settings act", 0, 0},
    {"steerable", cfg_bool, S(steerable), NO_LIMIT, "whether frames can be placed in time", 0, 0},
    {"jitter", cfg_i64_time, S(jitter_ns), 0, SECOND, "of timestamps, peak", 0, 0},
    {"buffers", cfg_u32, S(buffers), 2, 64, "frames held at once", 0, 0},
    {0}};

static const struct cfg_field LAMP[] = {
    {"x", cfg_double, L(x), -10, 10, "above the sample, 0.5 = middle", 0, 0},
    {"y", cfg_double, L(y), -10, 10, "above the sample, 0.5 = middle", 0, 0},
    {"height", cfg_double, L(height), 0.01, 100, "in widths of the sample", 0, 0},
    {"strength", cfg_double, L(strength), 0, 1000, "1 = nominal", 0, 0},
    {"cold", cfg_double_ratio, L(cold_fraction), 0, 1, "light at switch-on", 0, 0},
    {"warm_tau", cfg_i64_time, L(warm_tau_ns), 0, DAY, "time constant of warming up", 0, 0},
    {"ageing", cfg_double_ratio, L(ageing_per_kh), 0, 1, "light lost per 1000 h", 0, 0},
    {"ripple", cfg_double_ratio, L(ripple), 0, 1, "at twice the mains frequency", 0, 0},
    {"colour", cfg_double3, L(colour), 0, 10, "R, G, B of its light", 0, 0},
    {"heat", cfg_double_degc, L(heat_degc), 0, 100, "box warmer in the long run", 0, 0},
    {0}};

/* sim.lamps: {left: {x: 0.2}}: the model of lamps that the board has. */
static int read_lamps(const struct cfg_field *field, struct yaml_node *node, void *at,
                      struct ttf_err *err)
{
    struct ttf_sim_config *sim = at;
    const char *names[TTF_LAMPS_MAX + 1];
    unsigned n;

    for (n = 0; n < sim->n_lamps; n++)
        names[n] = sim->lamps[n].info.name;
    names[n] = NULL;
    if (node->kind != YAML_MAP)
        return cfg_error(node, err, field->meant, "a map by the lamps' names is meant");
    for (struct yaml_node *c = node->child; c; c = c->next) {
        int r;

        c->used = true;
        for (n = 0; n < sim->n_lamps; n++)
            if (c->key && strcmp(sim->lamps[n].info.name, c->key) == 0)
                break;
        if (n == sim->n_lamps) {
            const char *near = cfg_nearest(c->key, names);
            char hint[100];

            snprintf(hint, sizeof hint, near ? "did you mean '%s'?" : "name it there first",
                     near ? near : "");
            return cfg_error_at_key(c, err, hint, "the board's 'lamps' have no such lamp");
        }
        r = cfg_map(LAMP, c, &sim->lamps[n], err);
        if (r < 0)
            return r;
    }
    return 0;
}

static const struct cfg_field SIM[] = {
    {"seed", cfg_u64, S(seed), NO_LIMIT, "a whole number; the same seed, the same bits", 0, 0},
    {"clock", read_clock, S(real_time), NO_LIMIT, "virtual or real", 0, 0},
    {"start", cfg_i64_utc, S(start_utc_ns), NO_LIMIT, "UTC of the first power-on", 0, 0},
    {"power_on", cfg_i64_time, S(power_on_ns), 0, 36600 * DAY, "when this boot began", 0, 0},
    {"outage", cfg_i64_time, S(outage_ns), 0, 366 * DAY, "how long a power cut lasts", 0, 0},
    {"rtc", cfg_bool, S(rtc), NO_LIMIT, "whether UTC is kept over a cut", 0, 0},
    {"utc_back", cfg_i64_time, S(utc_back_ns), 0, 366 * DAY,
     "without rtc: when after a later power-on UTC is given again; 0s: never", 0, 0},
    TABLE("cost", COST, "virtual time that work takes"),
    {"scene", NULL, 0, 0, 0, NULL, 0, 0}, /* read from the board's own struct */
    {"mains", cfg_double_mains, S(mains_hz), 50, 60, "50Hz or 60Hz", 0, 0},
    {"ambient", cfg_double_ratio, S(ambient), 0, 10, "light that leaks in", 0, 0},
    {"daylight", cfg_double_ratio, S(daylight), 0, 100, "open air: peak of a day's light", 0, 0},
    TABLE("room", ROOM, "temperatures"),
    {"lamps", read_lamps, 0, 0, 0, "models of the board's lamps", 0, 0},
    TABLE("optics", OPTICS, "the lens"),
    TABLE("sensor", SENSOR, "the image sensor"),
    TABLE("timing", TIMING, "the camera's timing and controls"),
    {"faults", board_read_faults, 0, 0, 0, "a list of faults", 0, 0},
    {0}};

int board_read_sim(const struct cfg_field *field, struct yaml_node *node, void *at,
                   struct ttf_err *err)
{
    struct ttf_board *board = at;
    struct yaml_node *scene = yaml_child(node, "scene");
    int r = cfg_map(SIM, node, &board->sim, err);

    if (r == 0 && scene)
        r = board_read_scene(field, scene, board, err);
    return r;
}
