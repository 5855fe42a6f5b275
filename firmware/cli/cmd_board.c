/* SPDX-License-Identifier: Apache-2.0 */
/* cmd_board.c: `ttfbox board probe`. */
#include <errno.h>
#include <inttypes.h>
#include <stdio.h>

#include "box.h"
#include "commands.h"

/* Counts the devices that do not answer. */
struct probe {
    struct cli *cli;
    const struct ttf_board *board;
    struct ttf_box box;
    unsigned silent;
};

static void probe_cameras(struct probe *p)
{
    struct ttf_json *j = &p->cli->out;

    ttf_json_key(j, "cameras");
    ttf_json_array(j);
    for (unsigned i = 0; i < p->box.n_cameras; i++) {
        struct ttf_frame_format f;
        struct ttf_err err = {0};
        const char *name = p->box.cameras[i].name;
        int r =
            ttf_camera_configure(p->box.cameras[i].camera, &p->board->cameras[i].mode, &f, &err);
        const struct ttf_camera_caps *caps = ttf_camera_caps(p->box.cameras[i].camera);

        ttf_json_object(j);
        ttf_json_kstring(j, "name", name);
        ttf_json_kbool(j, "ok", r == 0);
        if (r < 0) {
            cli_say(p->cli, "camera %-10s DOES NOT ANSWER: %s", name, err.what);
            p->silent++;
            ttf_json_object_end(j);
            continue;
        }
        cli_say(p->cli,
                "camera %-10s %s, %u x %u, %u bits, exposure %.3f ms to %.0f ms, gain %.1f to "
                "%.1f, %s",
                name, caps->model, f.width, f.height, f.bits, (double)caps->exposure_min_ns / 1e6,
                (double)caps->exposure_max_ns / 1e6, caps->gain_min_milli / 1e3,
                caps->gain_max_milli / 1e3, caps->steerable ? "steerable" : "free-running");
        ttf_json_kstring(j, "model", caps->model);
        ttf_json_kint(j, "width", f.width);
        ttf_json_kint(j, "height", f.height);
        ttf_json_kint(j, "bits", f.bits);
        ttf_json_kint(j, "exposure_min_ns", caps->exposure_min_ns);
        ttf_json_kint(j, "exposure_max_ns", caps->exposure_max_ns);
        ttf_json_kbool(j, "steerable", caps->steerable);
        ttf_json_kint(j, "timing_bound_ns", caps->timing_bound_ns);
        ttf_json_object_end(j);
    }
    ttf_json_array_end(j);
}

static void probe_lamps(struct probe *p)
{
    struct ttf_json *j = &p->cli->out;

    ttf_json_key(j, "lamps");
    ttf_json_array(j);
    for (unsigned i = 0; p->box.lamps && i < ttf_lamps_count(p->box.lamps); i++) {
        const struct ttf_lamp_info *info = ttf_lamps_info(p->box.lamps, i);
        struct ttf_lamp_state state;
        char longest[32] = "any time";
        bool ok = ttf_lamps_state(p->box.lamps, i, &state) == 0;

        p->silent += !ok;
        if (info->max_on_ns)
            (void)snprintf(longest, sizeof longest, "at most %.1f h",
                           (double)info->max_on_ns / TTF_NS_PER_H);
        cli_say(p->cli, "lamp %-12s %s%s, on for %s, duty %u permille%s", info->name,
                ok ? "" : "DOES NOT ANSWER, ",
                info->kind == TTF_LAMP_SWITCH  ? "switch"
                : info->kind == TTF_LAMP_STEPS ? "steps"
                                               : "pwm",
                longest, info->max_duty_permille,
                info->interlock_door ? ", off while the door is open" : "");
        ttf_json_object(j);
        ttf_json_kstring(j, "name", info->name);
        ttf_json_kbool(j, "ok", ok);
        ttf_json_object_end(j);
    }
    ttf_json_array_end(j);
}

/* A reading for people; programs get the number and its kind. */
static const char *reading_text(const struct ttf_reading *reading, char *buf, size_t size)
{
    double thousandth = (double)reading->value / 1000;

    switch (reading->kind) {
    case TTF_SENSOR_TEMP_MDEGC:
        (void)snprintf(buf, size, "%.2f degC", thousandth);
        break;
    case TTF_SENSOR_HUMIDITY_MPCT:
        (void)snprintf(buf, size, "%.1f %% humidity", thousandth);
        break;
    case TTF_SENSOR_LIGHT_PERMILLE:
        (void)snprintf(buf, size, "%" PRId64 " permille light", reading->value);
        break;
    default:
        (void)snprintf(buf, size, "%s: %" PRId64, ttf_sensor_kind_name(reading->kind),
                       reading->value);
    }
    return buf;
}

static void probe_sensors(struct probe *p)
{
    struct ttf_reading readings[TTF_SENSORS_MAX];
    struct ttf_json *j = &p->cli->out;
    char text[48];
    int n = p->box.sensors ? ttf_sensors_read(p->box.sensors, readings, NULL) : 0;

    if (n < 0) {
        cli_say(p->cli, "sensors           DO NOT ANSWER");
        p->silent++;
    }
    ttf_json_key(j, "sensors");
    ttf_json_array(j);
    for (int i = 0; i < n; i++) {
        p->silent += !readings[i].ok;
        cli_say(p->cli, "sensor %-10s %s", readings[i].name,
                readings[i].ok ? reading_text(&readings[i], text, sizeof text) : "DOES NOT ANSWER");
        ttf_json_object(j);
        ttf_json_kstring(j, "name", readings[i].name);
        ttf_json_kstring(j, "kind", ttf_sensor_kind_name(readings[i].kind));
        ttf_json_kbool(j, "ok", readings[i].ok);
        ttf_json_kint(j, "value", readings[i].value);
        ttf_json_object_end(j);
    }
    ttf_json_array_end(j);
}

static void probe_rest(struct probe *p)
{
    struct ttf_json *j = &p->cli->out;
    struct ttf_utc utc;
    int door = p->box.panel ? ttf_panel_door(p->box.panel) : -ENOTSUP;

    ttf_clock_utc(p->box.clock, &utc);
    cli_say(p->cli, "clock             %s, UTC vouched for by %s",
            ttf_clock_is_virtual(p->box.clock) ? "virtual" : "real", ttf_trust_name(utc.trust));
    cli_say(p->cli, "door              %s",
            door == 1   ? "open"
            : door == 0 ? "closed"
                        : "no switch");
    cli_say(p->cli, "watchdog          %s", p->box.watchdog ? "there" : "none");
    ttf_json_kbool(j, "virtual_clock", ttf_clock_is_virtual(p->box.clock));
    ttf_json_kstring(j, "utc_trust", ttf_trust_name(utc.trust));
    if (door >= 0)
        ttf_json_kbool(j, "door_open", door == 1);
    ttf_json_kbool(j, "watchdog", p->box.watchdog != NULL);
}

int cmd_board_probe(struct cli *cli)
{
    struct ttf_board board;
    struct probe p = {.cli = cli, .board = &board};
    int r = cli_load_board(cli, &board);

    if (r == 0)
        r = box_create(&board, cli->io, NULL, &p.box, &cli->err);
    if (r < 0)
        return r;
    cli_say(cli, "board             %s, serial %s%s", p.box.board, p.box.serial,
            p.box.simulated ? ", SIMULATED" : "");
    ttf_json_kstring(&cli->out, "board", p.box.board);
    ttf_json_kstring(&cli->out, "serial", p.box.serial);
    ttf_json_kbool(&cli->out, "simulated", p.box.simulated);
    probe_cameras(&p);
    probe_lamps(&p);
    probe_sensors(&p);
    probe_rest(&p);
    ttf_json_kint(&cli->out, "silent", p.silent);
    ttf_box_destroy(&p.box);
    return p.silent ? CLI_FAILED : CLI_DONE;
}
