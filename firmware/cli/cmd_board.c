/* SPDX-License-Identifier: Apache-2.0 */
/* cmd_board.c: `ttfbox board probe`. */
#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "abilities.h"
#include "board_findings.h"
#include "box.h"
#include "commands.h"
#include "hand_over.h"

/* Counts the devices that do not answer. */
struct probe {
    struct cli *cli;
    const struct ttf_board *board;
    struct ttf_box box;
    unsigned silent;
    bool no_camera; /* a back-end found none of its cameras */
};

/* Cameras that do not answer are left out of a box: the others are found by name. */
static const struct ttf_camera_mode *mode_of(const struct ttf_board *board, const char *name)
{
    unsigned i = 0;

    while (i + 1 < board->n_cameras && strcmp(board->cameras[i].name, name) != 0)
        i++;
    return &board->cameras[i].mode;
}

/* What it can and cannot: a 0 of exposure_max_ns or gain_max_milli is no such control. */
static void say_abilities(struct probe *p, const char *name, const struct ttf_camera_caps *caps,
                          const struct ttf_frame_format *f)
{
    struct ttf_json *j = &p->cli->out;
    struct probe_abilities can;

    probe_abilities(caps, f, &can);
    cli_say(p->cli, "camera %-10s %s, %u x %u, %s", name, caps->model, f->width, f->height,
            can.pixels);
    for (unsigned i = 0; i < PROBE_ABILITIES; i++)
        cli_say(p->cli, "                  %s", can.line[i]);
    ttf_json_kstring(j, "model", caps->model);
    ttf_json_kint(j, "width", f->width);
    ttf_json_kint(j, "height", f->height);
    ttf_json_kint(j, "bits", f->bits);
    ttf_json_kstring(j, "pixels", can.pixels);
    ttf_json_kint(j, "exposure_min_ns", caps->exposure_min_ns);
    ttf_json_kint(j, "exposure_max_ns", caps->exposure_max_ns);
    ttf_json_kint(j, "gain_min_milli", caps->gain_min_milli);
    ttf_json_kint(j, "gain_max_milli", caps->gain_max_milli);
    ttf_json_kbool(j, "white_balance", caps->has_white_balance);
    ttf_json_kbool(j, "lens", caps->has_lens);
    if (caps->lens_held)
        ttf_json_kint(j, "lens_code", caps->lens_code);
    ttf_json_kbool(j, "steerable", caps->steerable);
    ttf_json_kint(j, "timing_bound_ns", caps->timing_bound_ns);
    ttf_json_kint(j, "frame_period_ns", caps->frame_period_ns);
    ttf_json_kint(j, "lead_frames", caps->lead_frames);
}

static void probe_cameras_of(struct probe *p)
{
    struct ttf_json *j = &p->cli->out;

    ttf_json_key(j, "cameras");
    ttf_json_array(j);
    for (unsigned i = 0; i < p->box.n_cameras; i++) {
        struct ttf_frame_format f;
        struct ttf_err err = {0};
        const char *name = p->box.cameras[i].name;
        int r = ttf_camera_configure(p->box.cameras[i].camera, mode_of(p->board, name), &f, &err);

        ttf_json_object(j);
        ttf_json_kstring(j, "name", name);
        ttf_json_kbool(j, "ok", r == 0);
        if (r < 0) {
            cli_say(p->cli, "camera %-10s DOES NOT ANSWER: %s", name, err.what);
            p->silent++;
            ttf_json_object_end(j);
            continue;
        }
        say_abilities(p, name, ttf_camera_caps(p->box.cameras[i].camera), &f);
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
    struct ttf_err why = {0};
    char text[48];
    int n = p->box.sensors ? ttf_sensors_read(p->box.sensors, readings, &why) : 0;

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
    if (n >= 0 && why.code)
        cli_say(p->cli, "  %s: %s", why.where, why.what);
}

static void probe_rest(struct probe *p, bool panel_silent)
{
    struct ttf_json *j = &p->cli->out;
    struct ttf_utc utc;
    int door = p->box.panel ? ttf_panel_door(p->box.panel) : -ENOTSUP;

    ttf_clock_utc(p->box.clock, &utc);
    cli_say(p->cli, "clock             %s, UTC vouched for by %s",
            ttf_clock_is_virtual(p->box.clock) ? "virtual" : "real", ttf_trust_name(utc.trust));
    cli_say(p->cli, "door              %s",
            door == 1      ? "open"
            : door == 0    ? "closed"
            : panel_silent ? "not known: the panel does not answer"
                           : "no switch");
    cli_say(p->cli, "watchdog          %s", p->box.watchdog ? "there" : "none");
    ttf_json_kbool(j, "virtual_clock", ttf_clock_is_virtual(p->box.clock));
    ttf_json_kstring(j, "utc_trust", ttf_trust_name(utc.trust));
    if (door >= 0)
        ttf_json_kbool(j, "door_open", door == 1);
    ttf_json_kbool(j, "watchdog", p->box.watchdog != NULL);
}

/* What the board names, and what does not answer: each in its own words. */
static void say_silent(struct probe *p, const struct ttf_err errs[TTF_DEVICE_KIND_COUNT])
{
    static const char *const KINDS[TTF_DEVICE_KIND_COUNT] = {
        [TTF_DEVICE_CAMERA] = "camera", [TTF_DEVICE_CLOCK] = "clock",
        [TTF_DEVICE_LAMPS] = "lamps",   [TTF_DEVICE_SENSORS] = "sensors",
        [TTF_DEVICE_PANEL] = "panel",   [TTF_DEVICE_WATCHDOG] = "watchdog"};
    struct ttf_json *j = &p->cli->out;
    char text[900];

    ttf_json_key(j, "do_not_answer");
    ttf_json_array(j);
    for (int kind = 0; kind < TTF_DEVICE_KIND_COUNT; kind++) {
        if (errs[kind].code == 0)
            continue;
        p->silent++;
        cli_say(p->cli, "%-17s DOES NOT ANSWER: %s", KINDS[kind],
                ttf_err_text(&errs[kind], text, sizeof text));
        ttf_json_object(j);
        ttf_json_kstring(j, "device", KINDS[kind]);
        ttf_json_kstring(j, "why", errs[kind].what);
        ttf_json_kstring(j, "hint", errs[kind].hint);
        ttf_json_object_end(j);
    }
    ttf_json_array_end(j);
}

/* Devices are asked; of a camera that another program has, only who that is. */
static int ask_devices(struct probe *p)
{
    struct ttf_err errs[TTF_DEVICE_KIND_COUNT];
    char owner[256];
    int r = box_create_what_answers(p->board, p->cli->io, NULL, &p->box, errs);

    if (r < 0) {
        p->cli->err = errs[TTF_DEVICE_CLOCK];
        return r;
    }
    cli_say(p->cli, "board             %s, serial %s%s", p->box.board, p->box.serial,
            p->box.simulated ? ", SIMULATED" : "");
    ttf_json_kstring(&p->cli->out, "board", p->box.board);
    ttf_json_kstring(&p->cli->out, "serial", p->box.serial);
    ttf_json_kbool(&p->cli->out, "simulated", p->box.simulated);
    p->no_camera = errs[TTF_DEVICE_CAMERA].code == -ENODEV;
    say_silent(p, errs);
    if (box_lock_owner(p->board->lock, owner)) {
        cli_say(p->cli, "owner             %s: its camera is not asked", owner);
        ttf_json_kstring(&p->cli->out, "owner", owner);
    } else {
        probe_cameras_of(p);
    }
    probe_lamps(p);
    probe_sensors(p);
    probe_rest(p, errs[TTF_DEVICE_PANEL].code != 0);
    ttf_json_kint(&p->cli->out, "silent", p->silent);
    return 0;
}

int cmd_board_probe(struct cli *cli)
{
    struct ttf_board *board;
    struct probe p = {.cli = cli};
    unsigned problems = 0;
    int r;

    if (cli->opt.bundle && !cli_is_full())
        return cli_hand_over(cli);
    p.board = board = calloc(1, sizeof *board);
    r = board ? cli_load_board(cli, board) : -ENOMEM;
    /* Another machine's files have no devices to ask. */
    if (r == 0 && !cli->opt.root)
        r = ask_devices(&p);
    if (r == 0 && (board->real || cli->opt.root || cli->opt.output))
        problems = board_findings(cli, board, p.box.clock, p.no_camera);
    if (r == 0)
        ttf_json_kint(&cli->out, "problems", problems);
    if (r == 0 && cli->opt.bundle)
        r = board_bundle(cli, board);
    ttf_box_destroy(&p.box);
    free(board);
    return r < 0 ? r : p.silent || problems ? CLI_FAILED : CLI_DONE;
}
